//! The real-time loop.
//!
//! Enters: a controller, live settings, a back end. Leaves: voltages on a clock, samples for the recorder, a report.
//! Deliberately absent: design, identification, drawing; linear algebra in the real-time thread.

pub mod back_end;
pub mod board;
pub mod comedi;
pub mod hil;
