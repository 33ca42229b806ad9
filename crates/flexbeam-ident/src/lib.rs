//! From recordings to models.
//!
//! Enters: signals. Leaves: state space models, physical parameters, thresholds, and what they were judged by.
//! Deliberately absent: controllers, files, the rig itself.
//!
//! The paper's (18), from a recording of its own linear model and back:
//!
//! ```
//! use flexbeam_ident::physical::physical_form;
//! use flexbeam_rig::{Lumped, Output};
//! use flexbeam_ident::{Options, excitation, identify};
//! use flexbeam_lti::{Mat, Signals, Vector, sampling::zoh, simulation::simulate};
//!
//! let period_s = 0.001;
//! let plant = Lumped::PAPER.state_space(&[Output::Theta, Output::Alpha]).unwrap();
//! let voltage_v = Mat::from_row_slice(1, 2000, &excitation::white_gaussian(2000, 2.0, 10.0, 1));
//! let angles_rad = simulate(&zoh(&plant, period_s)?, &voltage_v, &Vector::zeros(4))?;
//!
//! let signals = |names: &[&str], unit: &str, data| {
//!     let units = vec![unit.to_string(); names.len()];
//!     Signals::new(names.iter().map(|n| n.to_string()).collect(), units, period_s, data)
//! };
//! let inputs = signals(&["voltage"], "v", voltage_v)?;
//! let outputs = signals(&["theta", "alpha"], "rad", angles_rad)?;
//! let found = identify(&inputs, &outputs, &Options::default())?;
//! assert_eq!(found.order, 4);
//! let form = physical_form(&found.continuous?, 0, 1)?;
//! assert!((form.parameters.k1 - 1060.8).abs() < 1e-7);
//! assert!((form.model.A[(3, 1)] + 1465.2).abs() < 1e-7);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod bound;
pub mod breakaway;
mod candidate;
mod checks;
mod columns;
mod correlation;
mod delay;
mod double;
mod doubts;
mod error;
mod estimation;
pub mod excitation;
mod factor_map;
mod fourier;
pub mod friction;
mod hankel;
pub mod identify;
mod innovations;
mod integrators;
mod lanes;
mod modal;
mod modes;
mod order;
pub mod orders;
mod output_map;
pub mod physical;
mod prepared;
mod projection;
pub mod refine;
mod samples;
mod scaling;
mod shares;
mod singular;
pub mod spectrum;
mod stable;
pub mod streaming;
pub mod structured;
mod subspace;
mod triangle;
pub mod validate;
pub mod validator;

pub use delay::Delay;
pub use doubts::Doubt;
pub use error::Error;
pub use identify::{Feedthrough, Identified, Method, Options, Order, Poles, identify};
pub use innovations::Innovations;
pub use modes::Mode;
