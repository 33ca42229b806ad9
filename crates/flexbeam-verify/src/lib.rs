//! Certificates recomputed by formulas that the design did not use.
//!
//! Enters: a nominal plant, the kernel's controller, a certificate; the rig's beam. Leaves: each claimed figure beside the
//! recomputed one, and a verdict.
//! Deliberately absent: any import of design or identification; files.

mod beam;
mod bound;
mod error;
mod feedback;
mod margins;
mod matching;
mod monte_carlo;
mod nyquist;
mod plant;
mod radius;
mod response;
mod sweep;
mod verify;

pub use beam::{BeamPlant, NeglectedMode, OnBeam, TAIL, on_beam, worst_neglected_mode};
pub use bound::{bound_norm, image_shortfall};
pub use error::Error;
pub use feedback::{Feedback, Loop};
pub use margins::{Margins, margins};
pub use matching::{matching_error, pole_mismatch};
pub use monte_carlo::{Campaign, Quantiles, Run, Scenario, Spread, Summary, monte_carlo};
pub use nyquist::{Count, count, stability_degree};
pub use plant::{Plant, Sampled, Timing};
pub use radius::{continuous_radius, sampled_radius};
pub use sweep::Peak;
pub use verify::{Claim, Comparison, Subject, Verdict, Verified, verify};
