/// Why a question about the rig cannot be answered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A quantity outside the range in which it means something.
    #[error("{quantity} is {found} {unit}; needed: {needed}")]
    Parameter {
        /// Which quantity.
        quantity: &'static str,
        /// The value found.
        found: f64,
        /// Its unit.
        unit: &'static str,
        /// The range that was needed.
        needed: &'static str,
    },
    /// A lumped model that no rig has: J_link = K_stiff/(k2 - k1) would not be positive.
    #[error("k1 = {k1} 1/s^2 and k2 = {k2} 1/s^2 leave no link inertia: k2 must exceed k1")]
    NoLinkInertia {
        /// K_stiff/J_base.
        k1: f64,
        /// K_stiff (1/J_link + 1/J_base).
        k2: f64,
    },
    /// A damping c that is smaller than what the viscous friction alone would give.
    #[error("c = {c} 1/s with b = {b} rad/s^2/V admits B_eq of at most {largest} N m s/rad, found {B_eq}")]
    TooMuchFriction {
        /// Hub damping found in the lumped model.
        c: f64,
        /// Input gain of the lumped model.
        b: f64,
        /// Viscous friction found.
        B_eq: f64,
        /// The largest viscous friction that a motor with K_b = K_T can have here.
        largest: f64,
    },
    /// A step response too short for its measures.
    #[error("{found} samples; the measures of a step response need at least {needed}")]
    TooFewSamples {
        /// Samples found.
        found: usize,
        /// Samples needed.
        needed: usize,
    },
    /// A linear system that could not be formed.
    #[error(transparent)]
    Lti(#[from] flexbeam_lti::Error),
}

/// `value`, when it is positive and finite.
pub(crate) fn positive(quantity: &'static str, unit: &'static str, value: f64) -> Result<f64, Error> {
    if value > 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(Error::Parameter { quantity, found: value, unit, needed: "positive and finite" })
}

/// `value`, when it is zero or positive, and finite.
pub(crate) fn not_negative(quantity: &'static str, unit: &'static str, value: f64) -> Result<f64, Error> {
    if value >= 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(Error::Parameter { quantity, found: value, unit, needed: "not negative, and finite" })
}
