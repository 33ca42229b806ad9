//! Robust two-degree-of-freedom design with a prescribed stability degree.
//!
//! Enters: a nominal scalar plant, a bound alpha(s) on what it neglects, a specification. Leaves: a sampled controller in the
//! kernel's form and the figures that certify it, or the reason why there is none.
//! Deliberately absent: simulation of the nonlinear rig, files.

mod closed_loop;
mod cover;
mod error;
mod feedback;
mod half_plane;
mod interpolation;
mod margins;
mod radius;
mod reference;
mod solvability;
mod stiffness;
mod synthesis;
mod uncertainty;

pub use closed_loop::LoopFigures;
pub use cover::cover;
pub use error::Error;
pub use half_plane::HalfPlane;
pub use margins::{Margins, margins};
pub use radius::{radius_by_hankel, robust_radius};
pub use reference::{Prefilter, Reference, ReferenceModel};
pub use solvability::{Solvability, Unsolvable, solvability};
pub use stiffness::Stiffness;
pub use synthesis::{Design, Outcome, Specification, design, low_pass, sampled_plant};
pub use uncertainty::Uncertainty;
