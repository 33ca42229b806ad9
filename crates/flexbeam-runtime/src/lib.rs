//! The real-time loop.
//!
//! Enters: a controller, live settings, a back end. Leaves: voltages on a clock, samples for the recorder, a report.
//! Deliberately absent: design, identification, drawing; linear algebra in the real-time thread.

pub mod back_end;
mod exchange;
pub mod framed;
pub mod line;
pub mod port;
pub mod rig_side;
pub mod serial;
pub mod served_rig;
pub mod udp;
pub mod wire;
