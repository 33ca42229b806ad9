//! Linear time-invariant systems, continuous and sampled.
//!
//! Enters: matrices, signals. Leaves: poles, zeros, norms, responses, other systems.
//! Deliberately absent: files, the clock, random numbers, the rig.

mod blocks;
pub mod connections;
#[cfg(test)]
mod draw;
mod error;
pub mod hankel;
pub mod logarithm;
pub mod schur;
pub mod exponential;
pub mod sampling;
mod signals;
pub mod split;
pub mod simulation;
mod state_space;
pub mod sylvester;
mod time;

pub use error::Error;
pub use signals::Signals;
pub use state_space::StateSpace;
pub use time::Time;

/// Real matrix: the one alias that every crate uses.
pub type Mat = nalgebra::DMatrix<f64>;
/// Real column vector.
pub type Vector = nalgebra::DVector<f64>;
/// Complex number.
pub type C64 = nalgebra::Complex<f64>;
/// Complex matrix.
pub type CMat = nalgebra::DMatrix<C64>;
