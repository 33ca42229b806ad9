//! All knowledge of the apparatus: a flexible beam on a geared motor.
//!
//! Enters: parameters, voltages, a seed. Leaves: linear models, exact responses, simulated measurements.
//! Deliberately absent: files, the clock, design of controllers.

mod beam;
mod error;
mod lumped;
mod motion;
mod physical;
mod roots;

pub use beam::{Beam, Damping, Response};
pub use error::Error;
pub use lumped::Output;
pub use motion::Motion;
pub use physical::{Drive, Lumped, Physical};
pub use roots::clamped_free_root;
