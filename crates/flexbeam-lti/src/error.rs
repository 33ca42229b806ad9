use crate::{C64, Time};

/// Why a question about a linear system cannot be answered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// Matrices whose shapes do not fit together.
    #[error("{what}: found {found_rows} x {found_columns}, needed {needed_rows} x {needed_columns}")]
    Shape {
        /// Which matrix, in which role.
        what: &'static str,
        /// Rows found.
        found_rows: usize,
        /// Columns found.
        found_columns: usize,
        /// Rows needed.
        needed_rows: usize,
        /// Columns needed.
        needed_columns: usize,
    },
    /// An entry that is infinite or not a number.
    #[error("{what}({row},{column}) is {value}; a system has finite entries")]
    NotFinite {
        /// Which matrix.
        what: &'static str,
        /// Row, from 1.
        row: usize,
        /// Column, from 1.
        column: usize,
        /// The entry found.
        value: f64,
    },
    /// Two time axes that cannot be mixed.
    #[error("{left} and {right} cannot be connected; resample one of the two")]
    TimeMismatch {
        /// The first system's time.
        left: Time,
        /// The second system's time.
        right: Time,
    },
    /// A sample period that is not a positive number.
    #[error("sample period {period_s} s; it must be positive and finite")]
    Period {
        /// The period found.
        period_s: f64,
    },
    /// A question that makes no sense on a system's time axis.
    #[error("{what} needs {needed}; the system has {found}")]
    WrongTime {
        /// What was asked for.
        what: &'static str,
        /// The system's time.
        found: Time,
        /// The time needed.
        needed: &'static str,
    },
    /// A delay that is negative or not finite.
    #[error("delay {delay_s} s; it must be zero or positive and finite")]
    Delay {
        /// The delay found.
        delay_s: f64,
    },
    /// A pole on the one point that a bilinear map sends to infinity.
    #[error("the bilinear map needs a system without pole at {at}; found {found}")]
    MappedPole {
        /// The point sent to infinity.
        at: f64,
        /// The pole found.
        found: C64,
    },
    /// A sampled system that no continuous one has become.
    #[error("poles {poles:?} on the closed negative real axis: no continuous system has these samples")]
    NoContinuousEquivalent {
        /// The poles there; 0 is a delay.
        poles: Vec<f64>,
    },
    /// Feedback whose algebraic loop has no solution.
    #[error("I + D_K D_G is singular (reciprocal condition {reciprocal_condition:.1e}): the loop is not well posed")]
    AlgebraicLoop {
        /// Least singular value relative to the size of the terms.
        reciprocal_condition: f64,
    },
    /// An inverse that would not be proper.
    #[error("D is singular (reciprocal condition {reciprocal_condition:.1e}): the inverse is not proper")]
    SingularFeedthrough {
        /// Least singular value relative to the size of the terms.
        reciprocal_condition: f64,
    },
    /// A channel that the system does not have.
    #[error("{what} {index} (from 0) of a system with {count}")]
    NoSuchChannel {
        /// Input or output.
        what: &'static str,
        /// The channel asked for, from 0.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A denominator that is zero, or has no coefficients.
    #[error("the denominator is zero")]
    ZeroDenominator,
    /// More zeros than poles: no state space has this function.
    #[error("{zeros} zeros and {poles} poles: a state space needs at least as many poles as zeros")]
    Improper {
        /// Degree of the numerator.
        zeros: usize,
        /// Degree of the denominator.
        poles: usize,
    },
    /// A complex root whose conjugate is missing.
    #[error("{what} {value} without its conjugate: the function is not real")]
    NotConjugate {
        /// Zero or pole.
        what: &'static str,
        /// The root that stands alone.
        value: C64,
    },
    /// An iteration that did not settle.
    #[error("{what} did not converge in {iterations} iterations")]
    NotConverged {
        /// Which iteration.
        what: &'static str,
        /// How many were tried.
        iterations: usize,
    },
    /// A chosen eigenvalue that agrees with one left behind.
    #[error(
        "eigenvalue {re:.6} + {im:.6}j lies in both parts of the division to working precision; move the dividing line"
    )]
    NotSeparable {
        /// Real part.
        re: f64,
        /// Imaginary part.
        im: f64,
    },
    /// A linear matrix equation with no unique solution.
    #[error("the matrix equation is singular: eigenvalue {re:.6} + {im:.6}j is shared by its two sides")]
    SharedEigenvalue {
        /// Real part.
        re: f64,
        /// Imaginary part.
        im: f64,
    },
    /// A pole on the imaginary axis or the unit circle.
    #[error(
        "pole {re:.6} + {im:.6}j is on the stability boundary to working precision; shift the axis by a stability degree"
    )]
    BoundaryPole {
        /// Real part.
        re: f64,
        /// Imaginary part.
        im: f64,
    },
    /// A pole in the wrong half of the plane.
    #[error("pole {re:.6} + {im:.6}j; needed: all poles {needed}")]
    WrongSide {
        /// Real part.
        re: f64,
        /// Imaginary part.
        im: f64,
        /// Where poles must lie.
        needed: &'static str,
    },
    /// A matrix without a real principal logarithm.
    #[error("eigenvalue {eigenvalue:.6} on the closed negative real axis; a real logarithm needs none there")]
    NegativeEigenvalue {
        /// The eigenvalue.
        eigenvalue: f64,
    },
    /// A Riccati equation whose Hamiltonian does not part into a stable and an antistable half.
    #[error(
        "the Hamiltonian has eigenvalues on the imaginary axis near {omega_rad_s:.6} rad/s; \
         no mode there may be uncontrollable or unweighted"
    )]
    AxisEigenvalues {
        /// Where on the axis [rad/s].
        omega_rad_s: f64,
    },
    /// An unstable mode that the input does not reach.
    #[error("mode {re:.6} + {im:.6}j cannot be stabilised: the input does not reach it")]
    NotStabilisable {
        /// Real part.
        re: f64,
        /// Imaginary part.
        im: f64,
    },
    /// An input weight that cannot be inverted.
    #[error("the input weight R is singular; a Riccati equation needs every input weighted")]
    SingularWeight,
    /// More states asked for than there are.
    #[error("order {asked} asked for; the system has {available} states that join input and output")]
    Order {
        /// The order asked for.
        asked: usize,
        /// The most that can be had.
        available: usize,
    },
}
