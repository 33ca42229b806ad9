//! The real-time loop.
//!
//! Enters: a controller, live settings, a back end. Leaves: voltages on a clock, samples for the recorder, a report.
//! Deliberately absent: design, identification, drawing; linear algebra in the real-time thread.

pub mod back_end;
pub mod board;
pub mod comedi;
#[cfg(feature = "foxglove")]
pub mod foxglove;
pub mod framed;
pub mod hil;
pub mod line;
pub mod port;
pub mod rig_side;
pub mod scope;
pub mod serial;
pub mod served_rig;
pub mod udp;
pub mod wire;

mod address;
mod cause;
mod clock;
mod control_socket;
mod controls;
mod dry_run;
mod exchange;
mod frozen;
mod homing;
mod kernel_settings;
mod lifecycle;
mod live;
mod meter;
mod open_loop;
mod printable;
mod real_time_loop;
mod recorder;
mod recording;
mod reference;
mod sample;
mod session;
mod simulated;
mod sink;
mod standing;
mod view;
mod watchdog;

pub use address::{NoAddress, ViewerAddress};
pub use cause::{Cause, RunFault, kernel_words};
pub use clock::{Clock, Monotonic, NS_PER_S};
pub use control_socket::{BoundSocket, ControlSocket, NoSocket, Steering, change_reference};
pub use controls::Controls;
pub use dry_run::CannotHold;
pub use frozen::FrozenLimit;
pub use homing::{NotHomed, SignWatch, SignsAgree, Zero, sign_check_voltages, signs_of, zero_of};
pub use kernel_settings::{law_of_file, law_of_kernel, table_of, with_table};
pub use lifecycle::{Event, Phase};
pub use live::{Live, LiveControl, LiveReader, Refused, live};
pub use meter::{Meter, PageFaults, Times};
pub use open_loop::{drive, open_loop_setup};
pub use recorder::Recorded;
pub use recording::{RunContext, RunSink, run_result, run_settings, shape_of_file, shape_of_run};
pub use reference::{Reference, Shape};
pub use sample::Sample;
pub use session::{ControllerData, NotArmed, Notes, Outcome, Session, Setup};
pub use simulated::SimulatedBackEnd;
pub use sink::{EventKind, RunEvent, RunReport, Sink, SinkError};
pub use standing::{LOOP_PRIORITY, Standing, WATCHDOG_PRIORITY, Warning};
pub use view::{Latest, SeenTiming};
