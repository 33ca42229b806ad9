//! From recordings to models.
//!
//! Enters: signals. Leaves: state space models, physical parameters, thresholds, and what they were judged by.
//! Deliberately absent: controllers, files, the rig itself.

pub mod breakaway;
mod error;
pub mod excitation;
mod hankel;
pub mod identify;
mod order;
mod output_map;
pub mod physical;
mod projection;
mod scaling;
mod singular;
pub mod structured;
mod subspace;
mod triangle;
pub mod validate;

pub use error::Error;
pub use identify::{Identified, Method, Options, Order, identify};
