#![no_std]
#![forbid(unsafe_code)]
//! All that runs inside the loop.
//!
//! Enters: [`Measured`] angles and the reference, once a period. Leaves: [`Commanded`], the voltage to send and what a
//! scope wants to see. Deliberately absent: `std`, allocation, panics, input and output, the clock, linear algebra
//! crates, and every function whose last bit depends on the platform (sqrt, floor, round, fused multiply-add, powers,
//! sines). Simulation, verification, the real-time loop and generated code all run [`tick`], so its order is stated
//! once, there.
//!
//! # Example
//!
//! A proportional controller u = 2 (v - y) whose reference model is 1 follows a step of 0.1 rad with 0.2 V:
//!
//! ```
//! use flexbeam_kernel::{Controller, Fault, Measured, Settings, State, tick};
//!
//! let coefficients = [2.0, 1.0, -2.0, 0.0]; // order 0: only D, column-major, rows u and y_model, columns v and y
//! let controller = Controller::new(0, &coefficients)?;
//! let mut memory = [0.0; 3];
//! let mut state = State::new(&controller, &mut memory)?;
//! let measured = Measured { reference_rad: 0.1, theta_rad: 0.0, alpha_rad: 0.0 };
//! let commanded = tick(&Settings::default(), &controller, &mut state, measured);
//! assert_eq!(commanded.voltage_v, 0.2);
//! assert_eq!(commanded.fault, Fault::None);
//! # Ok::<(), flexbeam_kernel::Error>(())
//! ```

#[cfg(test)]
extern crate std;

mod controller;
mod filter;
mod law;
mod limits;
mod settings;
mod smooth;
mod state;
mod tick;

pub use controller::{Controller, Error};
pub use law::{Law, v_res};
pub use limits::Fault;
pub use settings::{Channel, Settings};
pub use state::State;
pub use tick::{Commanded, Measured, tick};
