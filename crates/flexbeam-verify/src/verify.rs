//! A certificate recomputed figure by figure.
//!
//! Enters: the nominal plant, the controller as the kernel runs it, what the certificate claims. Leaves: claimed beside
//! recomputed, and a verdict. Absent: any formula of the design.

use crate::feedback::{Feedback, Loop};
use crate::plant::{Plant, Timing};
use crate::{
    Error, bound_norm, continuous_radius, count, image_shortfall, margins, matching_error, pole_mismatch,
    sampled_radius, stability_degree,
};
use flexbeam_lti::{C64, StateSpace, Zpk};

/// What a certificate speaks about.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// V -> psi, continuous, D = 0.
    pub nominal: &'a StateSpace,
    /// Period, delay, measurement filter.
    pub timing: Timing,
    /// Inputs (v, y, u_applied), outputs (u, y_model).
    pub controller: &'a StateSpace,
    /// beta [1/s].
    pub beta: f64,
    /// alpha(s) in the shifted s-plane [rad/V].
    pub alpha: &'a Zpk,
    /// Its image in the w-plane.
    pub alpha_w: &'a Zpk,
    /// Voltage that the variable-structure law may leave without effect [V].
    pub v_res_v: f64,
}

/// Figures that a certificate states. A radius is `None` when nothing is unstable after the shift.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// Radius of the continuous problem.
    pub continuous_radius: Option<f64>,
    /// Radius of the sampled problem.
    pub robust_radius: Option<f64>,
    /// sup |alpha_w K/(1 + G K)| on the shifted circle.
    pub bound_norm: f64,
    /// -max ln|z|/Ts [1/s].
    pub stability_degree: f64,
    /// K(0) [V/rad]; infinite with integral action.
    pub stiffness_v_per_rad: f64,
    /// Upward gain margin.
    pub gain_margin: f64,
    /// Phase margin [rad].
    pub phase_margin_rad: f64,
    /// Delay margin [s].
    pub delay_margin_s: f64,
    /// Disk margin 2/||S - T||.
    pub disk_margin: f64,
    /// Closed-loop poles in the z-plane.
    pub closed_loop_poles: Vec<C64>,
    /// v_res/K(0) [rad].
    pub stationary_error_rad: f64,
}

/// How a recomputed figure is held against the claimed one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Comparison {
    /// |claimed - recomputed| <= tolerance max(|claimed|, |recomputed|), or both infinite.
    Equal,
    /// |1/claimed - 1/recomputed| <= tolerance (1/|claimed| + 1): for figures that may be infinite.
    EqualInverse,
    /// |claimed - recomputed| <= tolerance (|claimed| + 1): for figures that may be zero.
    EqualOrSmall,
    /// recomputed >= claimed - tolerance.
    AtLeast,
    /// recomputed <= claimed + tolerance.
    AtMost,
}

/// One figure, claimed and recomputed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verified {
    /// Name, as in the certificate.
    pub figure: &'static str,
    /// What the certificate states, or the limit that the figure must keep.
    pub claimed: f64,
    /// What came out here; not a number when it could not be computed.
    pub recomputed: f64,
    /// Tolerance in the sense of `comparison`.
    pub tolerance: f64,
    /// Why the tolerance is what it is, or what the limit means.
    pub reason: &'static str,
    /// Sense of the comparison.
    pub comparison: Comparison,
    /// Whether the two agree.
    pub agrees: bool,
}

/// All figures of a certificate.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// In the order of the certificate.
    pub figures: Vec<Verified>,
}

impl Verdict {
    /// Whether every figure agrees.
    pub fn verified(&self) -> bool {
        self.figures.iter().all(|f| f.agrees)
    }

    /// Figures that broke.
    pub fn broken(&self) -> impl Iterator<Item = &Verified> {
        self.figures.iter().filter(|f| !f.agrees)
    }
}

impl Verified {
    /// Compares.
    pub fn new(
        figure: &'static str,
        claimed: f64,
        recomputed: f64,
        comparison: Comparison,
        (tolerance, reason): (f64, &'static str),
    ) -> Verified {
        let agrees = match comparison {
            Comparison::Equal => {
                let largest = claimed.abs().max(recomputed.abs());
                claimed == recomputed || largest.is_finite() && (claimed - recomputed).abs() <= tolerance * largest
            }
            Comparison::EqualInverse => {
                (claimed.recip() - recomputed.recip()).abs() <= tolerance * (claimed.recip().abs() + 1.0)
            }
            Comparison::EqualOrSmall => (claimed - recomputed).abs() <= tolerance * (claimed.abs() + 1.0),
            Comparison::AtLeast => recomputed >= claimed - tolerance,
            Comparison::AtMost => recomputed <= claimed + tolerance,
        };
        Verified { figure, claimed, recomputed, tolerance, reason, comparison, agrees }
    }
}

type Tolerance = (f64, &'static str);

const RADIUS: Tolerance =
    (1e-7, "two roads to the radius share the poles of the plant, whose condition costs six to eight digits");
const NORM: Tolerance = (1e-6, "both sides evaluate a loop of some fifteen poles near z = 1, known to 1e-13");
/// Rounding moves a double pole by some root of 1e-16 in z, whatever the degree is.
fn degree_tolerance(subject: &Subject<'_>, claim: &Claim) -> Tolerance {
    let absolute_per_s = DOUBLE_POLE / subject.timing.period_s;
    (DEGREE.0.max(absolute_per_s / claim.stability_degree.abs()), DEGREE.1)
}

/// The root of the rounding of a pole near z = 1.
const DOUBLE_POLE: f64 = 2e-8;

const DEGREE: Tolerance = (1e-5, "eigenvalues of a multiple closed-loop pole carry the root of the rounding");
const MARGIN: Tolerance = (1e-6, "crossings are simple roots on both sides");
const STIFFNESS: Tolerance = (1e-6, "K(0) is a limit at z = 1, next to the slowest poles of K");
const ERROR: Tolerance = (1e-8, "half a microdegree: far below one encoder count");
const POLES: Tolerance = (1e-6, "a wrong pole shows by its own relative error; rounding of multiple poles does not");
const MATCHING: Tolerance = (1e-7, "y = M v by construction; sampled zeros of the plant are known to 1e-9");
const COVER: Tolerance = (1e-9, "a rational function evaluated twice");
const EXACT: Tolerance = (0.0, "a limit");

/// Recomputes every figure of the claim.
///
/// Returns: figures that could not be recomputed hold a NaN and do not agree.
/// Errors: [`Error`] for what is no plant, no controller, or has another period.
/// Numerics: some ten thousand evaluations of the loop gain, 20 milliseconds.
/// Source: DESIGN 6, the certificate.
pub fn verify(subject: &Subject<'_>, claim: &Claim) -> Result<Verdict, Error> {
    use Comparison::{AtLeast, AtMost, Equal, EqualInverse, EqualOrSmall};
    let Subject { nominal, timing, beta, alpha, alpha_w, .. } = *subject;
    let plant = Plant::new(nominal, timing)?;
    let feedback = Feedback::new(subject.controller)?;
    let L = Loop::new(&plant, &feedback)?;
    let compliance = feedback.compliance_rad_per_v();
    let margins = margins(&L);
    let degree_of = |poles: &[C64]| -poles.iter().map(|z| z.norm()).fold(0.0, f64::max).ln() / timing.period_s;
    let radius = |radius: Option<f64>| radius.unwrap_or(f64::INFINITY);
    let or_nan = |figure: Result<f64, Error>| figure.unwrap_or(f64::NAN);
    let norm = bound_norm(&L, alpha_w, beta).value;
    let found_continuous = or_nan(continuous_radius(nominal, alpha, beta).map(radius));
    let found_sampled = or_nan(sampled_radius(nominal, timing, alpha_w, beta).map(radius));
    let beyond = or_nan(count(&L, beta).map(|c| c.beyond as f64));
    let error = compliance.abs() * subject.v_res_v;
    let figures = vec![
        Verified::new("robust_radius", radius(claim.continuous_radius), found_continuous, Equal, RADIUS),
        Verified::new("sampled.robust_radius", radius(claim.robust_radius), found_sampled, Equal, RADIUS),
        Verified::new("sampled.bound_norm", claim.bound_norm, norm, Equal, NORM),
        Verified::new("bound_norm_limit", 1.0, norm, AtMost, NORM),
        Verified::new(
            "alpha_over_its_image",
            1.0,
            image_shortfall(alpha, alpha_w, timing.period_s).value,
            AtMost,
            COVER,
        ),
        Verified::new("poles_beyond_beta", 0.0, beyond, AtMost, EXACT),
        Verified::new(
            "sampled.stability_degree",
            claim.stability_degree,
            or_nan(stability_degree(&L)),
            Equal,
            degree_tolerance(subject, claim),
        ),
        Verified::new("closed_loop_poles", 0.0, pole_mismatch(&L, &claim.closed_loop_poles).value, AtMost, POLES),
        Verified::new("prefilter_degree", 0.0, degree_of(&feedback.prefilter_poles), AtLeast, EXACT),
        Verified::new("saturated_degree", 0.0, degree_of(&feedback.saturated_poles), AtLeast, EXACT),
        Verified::new("stiffness", claim.stiffness_v_per_rad, compliance.recip(), EqualInverse, STIFFNESS),
        Verified::new("gain_margin", claim.gain_margin, margins.gain, Equal, MARGIN),
        Verified::new("phase_margin_rad", claim.phase_margin_rad, margins.phase_rad, Equal, MARGIN),
        Verified::new("delay_margin_s", claim.delay_margin_s, margins.delay_s, Equal, MARGIN),
        Verified::new("disk_margin", claim.disk_margin, margins.disk, Equal, MARGIN),
        Verified::new("stationary_error_rad", claim.stationary_error_rad, error, EqualOrSmall, ERROR),
        Verified::new("model_gain", 1.0, feedback.model_gain(), Equal, STIFFNESS),
        Verified::new("matching_error", 0.0, matching_error(&L).value, AtMost, MATCHING),
    ];
    Ok(Verdict { figures })
}
