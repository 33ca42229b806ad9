//! An alpha(s) for the design that lies everywhere above a given difference |dG(jw - beta)|.

use flexbeam_lti::cover::{self, Uncovered};

use crate::{Error, Uncertainty};

/// The smallest lead alpha(s) above `difference` [rad/V], |dG(jw - beta)| as a function of w.
///
/// Errors: [`Error::Setting`] unless beta is positive, [`Error::DifferenceNotFinite`].
/// Numerics: see [`flexbeam_lti::cover::cover`].
pub fn cover(difference: impl Fn(f64) -> f64, beta: f64, fastest_rad_s: f64) -> Result<Uncertainty, Error> {
    if !(beta > 0.0) {
        return Err(Error::Setting { name: "stability degree beta [1/s]", value: beta, needed: "positive" });
    }
    let not_finite = |Uncovered { omega_rad_s, value }| Error::DifferenceNotFinite { omega_rad_s, value };
    Uncertainty::new(cover::cover(difference, beta, fastest_rad_s).map_err(not_finite)?)
}
