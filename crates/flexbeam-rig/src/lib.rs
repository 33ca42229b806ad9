//! All knowledge of the apparatus: a flexible beam on a geared motor.
//!
//! Enters: parameters, voltages, a seed. Leaves: linear models, exact responses, simulated measurements.
//! Deliberately absent: files, the clock, design of controllers.

mod actuator;
mod beam;
mod closed_loop;
pub mod elementary;
mod error;
mod friction;
mod lumped;
mod metrics;
mod motion;
mod noise;
mod physical;
mod piece;
mod roots;
mod sensor;
mod simulated;
mod stick_slip;
pub mod ziggurat;

pub use actuator::Actuator;
pub use beam::{Beam, Damping, Response};
pub use closed_loop::{ClosedLoopRecord, closed_loop};
pub use error::Error;
pub use friction::{Friction, Stribeck};
pub use lumped::Output;
pub use metrics::{FINAL_WINDOW_S, LIMIT_CYCLE_SWING_RAD, SETTLING_BAND, StepMetrics};
pub use motion::Motion;
pub use noise::Noise;
pub use physical::{Drive, Lumped, Physical};
pub use piece::Piece;
pub use roots::clamped_free_root;
pub use sensor::{Encoder, Gauge, GaugeSees, Sensors};
pub use simulated::{Link, Measurement, RigNumbers, RigParameters, SimulatedRig, Truth, open_loop};
