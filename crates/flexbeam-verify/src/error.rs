/// Why a certificate cannot be checked. "The certificate is wrong" is not among these: that is a verdict.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A linear system that could not be formed.
    #[error(transparent)]
    Lti(#[from] flexbeam_lti::Error),
    /// The rig refused its parameters.
    #[error(transparent)]
    Rig(#[from] flexbeam_rig::Error),
    /// The kernel refused the controller.
    #[error(transparent)]
    Kernel(#[from] flexbeam_kernel::Error),
    /// A system with the wrong number of inputs or outputs, or on the wrong time axis.
    #[error("{what} has {inputs} inputs, {outputs} outputs and {time}; needed: {needed}")]
    Shape {
        /// Which system.
        what: &'static str,
        /// Inputs found.
        inputs: usize,
        /// Outputs found.
        outputs: usize,
        /// Time axis found.
        time: flexbeam_lti::Time,
        /// What was needed.
        needed: &'static str,
    },
    /// A setting outside its meaning.
    #[error("{name} = {value}; needed: {needed}")]
    Setting {
        /// Name with unit.
        name: &'static str,
        /// Value found.
        value: f64,
        /// Condition.
        needed: &'static str,
    },
    /// u_applied reaches the outputs at once: closing u_applied = u would be an algebraic loop that the kernel does not solve.
    #[error("the controller's D has {value} between u_applied and its outputs; the kernel needs 0 there")]
    Feedthrough {
        /// The entry found.
        value: f64,
    },
    /// A closed-loop pole on the contour, to working precision: it cannot be counted to either side.
    #[error(
        "a closed-loop pole lies on the line Re s = -{degree:.9} near omega = {omega_rad_s:.6} rad/s (|1 + L| = {return_difference:.1e}); its side cannot be told"
    )]
    OnContour {
        /// The degree of the contour [1/s].
        degree: f64,
        /// Frequency [rad/s].
        omega_rad_s: f64,
        /// Smallest |1 + L| met.
        return_difference: f64,
    },
    /// A search that found no end.
    #[error("{what} did not settle between {from} and {to}")]
    NotSettled {
        /// Which search.
        what: &'static str,
        /// Lower end.
        from: f64,
        /// Upper end.
        to: f64,
    },
    /// Two poles right of the line that coincide: no contour separates them.
    #[error("poles {re:.6} {im:+.6}j right of the line coincide; the radius needs simple ones")]
    RepeatedPole {
        /// Real part.
        re: f64,
        /// Imaginary part.
        im: f64,
    },
    /// A pole of the plant on the line Re s = -beta.
    #[error("pole {re:.6} {im:+.6}j of the plant lies on the line Re s = -{degree}; the radius is not defined there")]
    PoleOnLine {
        /// Real part.
        re: f64,
        /// Imaginary part.
        im: f64,
        /// beta [1/s].
        degree: f64,
    },
}
