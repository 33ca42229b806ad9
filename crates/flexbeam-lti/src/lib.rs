//! Linear time-invariant systems, continuous and sampled.
//!
//! Enters: matrices, signals. Leaves: poles, zeros, norms, responses, other systems.
//! Deliberately absent: files, the clock, random numbers, the rig.

mod blocks;
mod compression;
pub mod connections;
pub mod cover;
pub mod discrete_riccati;
#[cfg(test)]
mod draw;
pub mod equilibration;
mod error;
pub mod exponential;
pub mod generalised;
pub mod gramian;
pub mod hankel;
pub mod logarithm;
pub mod minimal;
pub mod norm;
pub mod peak_to_peak;
mod rational;
pub mod reduction;
pub mod response;
pub mod riccati;
pub mod sampling;
pub mod schur;
mod signals;
pub mod simulation;
pub mod split;
mod state_space;
pub mod sylvester;
mod time;
pub mod zeros;
mod zpk;

pub use error::Error;
pub use rational::Rational;
pub use signals::Signals;
pub use state_space::StateSpace;
pub use time::Time;
pub use zpk::Zpk;

/// Real matrix: the one alias that every crate uses.
pub type Mat = nalgebra::DMatrix<f64>;
/// Real column vector.
pub type Vector = nalgebra::DVector<f64>;
/// Complex number.
pub type C64 = nalgebra::Complex<f64>;
/// Complex matrix.
pub type CMat = nalgebra::DMatrix<C64>;
