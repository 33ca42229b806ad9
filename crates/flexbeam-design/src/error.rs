use flexbeam_lti::Time;

/// Why a design question cannot be answered. "The answer is no" is not among these: that is [`crate::Unsolvable`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// The linear algebra underneath found the question ill-posed.
    #[error(transparent)]
    Lti(#[from] flexbeam_lti::Error),
    /// The scalar theory needs one input and one output.
    #[error(
        "nominal plant has {inputs} inputs and {outputs} outputs; the scalar design needs one of each\nhint: name the controlled output and keep the motor voltage as the only input"
    )]
    NotScalar {
        /// Inputs found.
        inputs: usize,
        /// Outputs found.
        outputs: usize,
    },
    /// The nominal plant is given in sampled time.
    #[error(
        "nominal plant has {time}; the design starts from a continuous-time plant\nhint: a sampled model needs a continuous form first (inverse zero-order hold)"
    )]
    NotContinuous {
        /// The time axis found.
        time: Time,
    },
    /// Feedthrough in the nominal plant.
    #[error(
        "nominal plant has D = {value}, needed D = 0: a tip angle does not follow the voltage at once\nhint: take the physical form (identify theta and alpha with order 4), or set D to 0 in the model file"
    )]
    Feedthrough {
        /// The entry found.
        value: f64,
    },
    /// A mode that neither feedback nor measurement reaches, right of the line Re s = -beta.
    #[error(
        "mode {re:.6} {im:+.6}j rad/s lies right of -beta = {line:.6} and is {kind} (relative coupling {relative_gain:.1e}): no feedback moves it\nhint: remove the mode from the model if the beam does not have it, or take beta below its damping"
    )]
    HiddenMode {
        /// Real part of the mode [rad/s].
        re: f64,
        /// Imaginary part of the mode [rad/s].
        im: f64,
        /// -beta [1/s].
        line: f64,
        /// "not controllable" or "not observable".
        kind: &'static str,
        /// Relative size of the coupling that was found.
        relative_gain: f64,
    },
    /// A pole exactly on the line Re s = -beta.
    #[error(
        "pole {re:.6} {im:+.6}j of the nominal plant lies on the line Re s = -beta (beta = {beta}); the count of poles right of it is undefined{limit}\nhint: take beta a little smaller or larger{suggestion}"
    )]
    PoleOnLine {
        /// Real part of the pole [rad/s].
        re: f64,
        /// Imaginary part of the pole [rad/s].
        im: f64,
        /// The stability degree asked for [1/s].
        beta: f64,
        /// What the radius does as beta approaches the pole.
        limit: String,
        /// A beta to try.
        suggestion: String,
    },
    /// Two poles right of -beta that coincide.
    #[error(
        "pole {re:.6} {im:+.6}j (in the shifted plane) is repeated; the design covers simple poles right of -beta\nhint: take beta below their damping, or part the two by a hair"
    )]
    RepeatedPole {
        /// Real part, shifted plane.
        re: f64,
        /// Imaginary part, shifted plane.
        im: f64,
    },
    /// The Pick matrix of the points lost definiteness to rounding.
    #[error(
        "Pick matrix of {points} points is singular to working precision (pivot {pivot:.1e}): some poles right of -beta nearly coincide\nhint: a smaller beta leaves fewer of them right of the line"
    )]
    PickNotDefinite {
        /// Number of interpolation points.
        points: usize,
        /// The pivot or pole that failed.
        pivot: f64,
    },
    /// The interpolant does not meet its conditions.
    #[error(
        "the interpolant misses its conditions by {residual:.1e}, needed {tolerance:.0e}: some poles right of -beta nearly coincide, or the level is all but spent\nhint: a smaller beta, alpha or stiffness"
    )]
    Interpolation {
        /// Largest relative error in a condition.
        residual: f64,
        /// The relative tolerance.
        tolerance: f64,
    },
    /// The two roads to the radius disagree.
    #[error(
        "robust radius is {hankel:.12} by Hankel singular values and {pick:.12} by Nevanlinna-Pick; they must agree within {tolerance:.0e}: the plant is too badly conditioned\nhint: check the model's units, and that no two poles right of -beta nearly coincide"
    )]
    RadiusDisagreement {
        /// From the antistable part's smallest Hankel singular value.
        hankel: f64,
        /// From the Pick matrix.
        pick: f64,
        /// The relative tolerance.
        tolerance: f64,
    },
    /// alpha(s) that the theory excludes.
    #[error(
        "uncertainty alpha(s) {what} at {re:.6} {im:+.6}j; (19) needs alpha stable, minimum phase and biproper\nhint: mirror the root into Re s < 0, |alpha(jw)| stays as it is"
    )]
    Weight {
        /// "has a pole in Re s >= 0", ..
        what: &'static str,
        /// Real part.
        re: f64,
        /// Imaginary part.
        im: f64,
    },
    /// alpha(s) with unequal degrees.
    #[error(
        "uncertainty alpha(s) has {zeros} zeros and {poles} poles; the design needs equally many (alpha(infinity) finite and not 0)\nhint: add zeros far beyond the last mode"
    )]
    WeightDegree {
        /// Number of zeros.
        zeros: usize,
        /// Number of poles.
        poles: usize,
    },
    /// The plant moves away from the bound somewhere, whatever alpha is.
    #[error(
        "the difference to be covered is {value} at omega = {omega_rad_s} rad/s; a bound needs finite values\nhint: a pole of the beam or of the nominal plant lies on the line Re s = -beta; move beta"
    )]
    DifferenceNotFinite {
        /// Frequency [rad/s].
        omega_rad_s: f64,
        /// The value found.
        value: f64,
    },
    /// A setting outside its meaning.
    #[error("{name} = {value}, needed {needed}\nhint: `flexbeam design --help` lists units and defaults")]
    Setting {
        /// Name with unit.
        name: &'static str,
        /// Value found.
        value: f64,
        /// Condition.
        needed: &'static str,
    },
    /// A stiffness request on a plant that has no integrator.
    #[error(
        "stiffness {requested} V/rad asked for, but the nominal plant has no pole at s = 0 (nearest: {nearest:.6} rad/s)\nhint: --stiffness optimal asks nothing of the static gain"
    )]
    NoIntegrator {
        /// What was asked for [V/rad].
        requested: f64,
        /// The nearest real pole [rad/s].
        nearest: f64,
    },
    /// M that rolls off more slowly than the plant.
    #[error(
        "reference model M has relative degree {found}, the plant needs at least {needed}: T = M/N would not be proper\nhint: multiply M by 1/(1 + s t)^{}, t small", .needed - .found
    )]
    ReferenceDegree {
        /// Relative degree of the model given.
        found: usize,
        /// Relative degree of the plant.
        needed: usize,
    },
    /// M that is not stable enough.
    #[error(
        "reference model M has a pole at {re:.6} {im:+.6}j; all its poles must lie left of -beta = {line:.6}\nhint: a shorter rise time, or a smaller beta"
    )]
    ReferencePole {
        /// Real part.
        re: f64,
        /// Imaginary part.
        im: f64,
        /// -beta.
        line: f64,
    },
    /// No rise time keeps the voltage.
    #[error(
        "the largest step needs {voltage_v:.3} V even with a rise time of {rise_time_s} s; allowed {max_voltage_v} V\nhint: allow more voltage, a smaller largest step, or a smaller beta"
    )]
    Voltage {
        /// Voltage needed [V].
        voltage_v: f64,
        /// The slowest rise time tried [s].
        rise_time_s: f64,
        /// The limit [V].
        max_voltage_v: f64,
    },
}
