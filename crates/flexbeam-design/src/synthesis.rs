//! The design from end to end.

use flexbeam_lti::minimal::minimal;
use flexbeam_lti::{C64, Mat, StateSpace, Time, connections, sampling};

use crate::closed_loop::{LoopFigures, degree};
use crate::feedback::Feedback;
use crate::half_plane::HalfPlane;
use crate::interpolation::Interpolant;
use crate::radius::{conditions, robust_radius};
use crate::reference::{Prefilter, Reference, prefilter};
use crate::solvability::{Unsolvable, largest_beta, nearest_stiffness};
use crate::stiffness::{Stiffness, conditions_with_stiffness, integrator, stiffness_of};
use crate::{Error, Uncertainty};

/// What the design is asked for.
#[derive(Clone, Debug)]
pub struct Specification {
    /// beta [1/s]: every closed-loop pole shall have real part below -beta.
    pub stability_degree: f64,
    /// alpha(s) of (19), in the shifted plane [rad/V].
    pub uncertainty: Uncertainty,
    /// What the feedback does against constant disturbances.
    pub stiffness: Stiffness,
    /// What the tip does on a command.
    pub reference: Reference,
    /// Sample period [s].
    pub period_s: f64,
    /// Time from a measurement to the voltage that answers it [s]; one period on a rig that writes at the next tick.
    pub delay_s: f64,
    /// Coefficient a of the measurement's low-pass filter y_f += a (y - y_f); 1 passes everything.
    pub low_pass: f64,
}

/// A controller with the figures that certify it.
#[derive(Clone, Debug)]
pub struct Design {
    /// Radius of the continuous problem.
    pub robust_radius: Option<f64>,
    /// The continuous loop, beside.
    pub continuous: LoopFigures,
    /// Radius of the sampled problem, delay and filter included.
    pub sampled_radius: Option<f64>,
    /// The sampled loop with its exact delay: what runs.
    pub sampled: LoopFigures,
    /// The bound in the w-plane, in which `sampled.bound_norm` is taken.
    pub sampled_uncertainty: Uncertainty,
    /// Inputs (v, y, u_applied), outputs (u, M v), sampled: what the kernel steps.
    pub controller: StateSpace,
    /// -max ln|z|/Ts of the prefilter's own poles [1/s]; infinite for one without dynamics.
    pub prefilter_degree: f64,
    /// Reference model and the voltage it takes.
    pub prefilter: Prefilter,
}

/// A design, or the reason why there is none.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// There is a controller.
    Solved(Box<Design>),
    /// There is none.
    Unsolvable(Unsolvable),
}

/// Nominal plant and specification to a certified sampled controller.
///
/// Shapes: `nominal` is V -> psi, one input, one output, continuous, D = 0.
/// Errors: see [`Error`]; "no controller exists" is [`Outcome::Unsolvable`], not an error.
/// Numerics: eigenvalues of matrices of at most twice the loop's order; every figure is computed from the loop built
/// explicitly, not from the formulas that designed it.
/// Source: (19)-(27), DESIGN section 6.
pub fn design(nominal: &StateSpace, specification: &Specification) -> Result<Outcome, Error> {
    match attempt(nominal, specification) {
        Ok(design) => Ok(Outcome::Solved(Box::new(design))),
        Err(Stop::Unsolvable(reason)) => Ok(Outcome::Unsolvable(reason)),
        Err(Stop::Error(error)) => Err(error),
    }
}

/// Why a design ends early.
enum Stop {
    Unsolvable(Unsolvable),
    Error(Error),
}

impl From<Unsolvable> for Stop {
    fn from(reason: Unsolvable) -> Stop {
        Stop::Unsolvable(reason)
    }
}

impl From<Error> for Stop {
    fn from(error: Error) -> Stop {
        Stop::Error(error)
    }
}

fn attempt(nominal: &StateSpace, specification: &Specification) -> Result<Design, Stop> {
    let nominal = &strictly_proper(nominal)?;
    expect_positive("stability degree beta [1/s]", specification.stability_degree, true)?;
    expect_positive("period [s]", specification.period_s, false)?;
    expect_positive("delay [s]", specification.delay_s, true)?;
    if let Some(stiffness) = specification.stiffness.requested().filter(|stiffness| *stiffness != f64::INFINITY) {
        expect_positive("stiffness [V/rad]", stiffness, true)?;
    }
    if let Reference::Fastest { max_voltage_v, max_step_rad, .. } = specification.reference {
        expect_positive("largest voltage [V]", max_voltage_v, false)?;
        expect_positive("largest step [rad]", max_step_rad, false)?;
    }
    let (beta, alpha) = (specification.stability_degree, &specification.uncertainty);
    let continuous = Problem::new(nominal, beta, alpha)?;
    let plant = sampled_plant(nominal, specification)?; // DESIGN 6.6
    let alpha_w = alpha.in_w_plane(specification.period_s);
    let sampled = Problem::new(&plant, beta, &alpha_w)?;
    // Stiffness is asked of the loop that runs first, so that what a reason suggests holds for it.
    let sampled_feedback = sampled.stabilised(specification.stiffness)?; // (22)
    let continuous_feedback = continuous.stabilised(specification.stiffness)?;
    let relative_degree = relative_degree(nominal)?;
    let prefilter = prefilter(&plant, &sampled_feedback, relative_degree, beta, &specification.reference)?; // (24), (27)
    Ok(Design {
        robust_radius: continuous.radius,
        continuous: LoopFigures::of(nominal, &continuous_feedback.controller(), beta, alpha)?,
        sampled_radius: sampled.radius,
        sampled: LoopFigures::of(&plant, &sampled_feedback.controller(), beta, &alpha_w)?,
        controller: controller(&sampled_feedback, &prefilter)?,
        prefilter_degree: degree(&prefilter.system.poles(), plant.time),
        sampled_uncertainty: alpha_w,
        prefilter,
    })
}

/// Coefficient a of y_f += a (y - y_f) for a cut-off frequency: the filter's pole at e^(-2 pi f Ts).
pub fn low_pass(cutoff_hz: f64, period_s: f64) -> f64 {
    -(-std::f64::consts::TAU * cutoff_hz * period_s).exp_m1()
}

/// The plant as the sampled controller meets it: zero-order hold, delay, measurement filter.
pub fn sampled_plant(nominal: &StateSpace, specification: &Specification) -> Result<StateSpace, Error> {
    let period_s = specification.period_s;
    let plant = sampling::zoh_with_delay(nominal, period_s, specification.delay_s)?;
    let a = specification.low_pass;
    if a == 1.0 {
        return Ok(plant);
    }
    if !(a > 0.0 && a < 1.0) {
        return Err(Error::Setting { name: "low-pass coefficient", value: a, needed: "above 0, at most 1" });
    }
    let one = |x: f64| Mat::from_element(1, 1, x);
    let time = Time::Sampled { period_s };
    let filter = StateSpace::new(one(1.0 - a), one(a), one(1.0 - a), one(a), time)?;
    // The filter's zero at z = 0 takes away one period of the delay.
    Ok(minimal(&connections::series(&plant, &filter)?))
}

/// The interpolant may miss its conditions by this much, relative: the plant's unstable poles are cancelled as well as that.
const INTERPOLATED: f64 = 1e-6;

/// (22) for one plant, continuous or sampled, with a radius of at least one.
struct Problem<'a> {
    plant: HalfPlane,
    alpha: &'a Uncertainty,
    radius: Option<f64>,
}

impl Problem<'_> {
    fn new<'a>(plant: &StateSpace, beta: f64, alpha: &'a Uncertainty) -> Result<Problem<'a>, Stop> {
        let shifted = HalfPlane::new(plant, beta)?;
        let radius = robust_radius(&shifted, alpha)?;
        match radius {
            Some(radius) if radius < 1.0 => {
                let (period_s, largest_beta) = match plant.time {
                    Time::Continuous => (None, largest_beta(plant, beta, alpha)),
                    Time::Sampled { period_s } => (Some(period_s), None),
                };
                Err(Unsolvable::Radius { radius, largest_beta, period_s }.into())
            }
            _ => Ok(Problem { plant: shifted, alpha, radius }),
        }
    }

    fn stabilised(&self, stiffness: Stiffness) -> Result<Feedback, Stop> {
        let interpolant = self.interpolant(stiffness)?;
        if !(interpolant.residual <= INTERPOLATED) {
            return Err(Error::Interpolation { residual: interpolant.residual, tolerance: INTERPOLATED }.into());
        }
        Ok(Feedback::new(&self.plant, self.alpha, &interpolant)?)
    }

    /// The interpolant of smallest norm where that is stiff enough, else the central one with the stiffness asked for.
    fn interpolant(&self, stiffness: Stiffness) -> Result<Interpolant, Stop> {
        let (plant, alpha) = (&self.plant, self.alpha);
        let softest = conditions(plant, alpha)?.optimal()?;
        let Some(requested) = stiffness.requested() else { return Ok(softest) };
        let softest_stiffness = stiffness_of(plant, alpha, &softest, requested)?;
        if matches!(stiffness, Stiffness::AtLeast(_)) && softest_stiffness >= requested {
            return Ok(softest);
        }
        let stiff = conditions_with_stiffness(plant, alpha, requested)?;
        let level = stiff.optimal()?.norm;
        if level < 1.0 {
            return Ok(stiff.central(integrator(plant, requested)?.0)?);
        }
        let nearest_v_per_rad = nearest_stiffness(plant, alpha, softest_stiffness, requested)?;
        Err(Unsolvable::Stiffness { requested_v_per_rad: requested, level, nearest_v_per_rad }.into())
    }
}

/// Feedback filters and prefilter side by side: inputs (v, y, u_applied), outputs (u, M v).
fn controller(feedback: &Feedback, prefilter: &Prefilter) -> Result<StateSpace, Error> {
    let (f, p) = (&feedback.filters, &prefilter.system);
    let (n, m) = (f.order(), p.order());
    let mut A = Mat::zeros(n + m, n + m);
    A.view_mut((0, 0), (n, n)).copy_from(&f.A);
    A.view_mut((n, n), (m, m)).copy_from(&p.A);
    let mut B = Mat::zeros(n + m, 3);
    B.view_mut((0, 1), (n, 2)).copy_from(&f.B);
    B.view_mut((n, 0), (m, 1)).copy_from(&p.B);
    let mut C = Mat::zeros(2, n + m);
    C.view_mut((0, 0), (1, n)).copy_from(&f.C);
    C.view_mut((0, n), (2, m)).copy_from(&p.C);
    let mut D = Mat::zeros(2, 3);
    D[(0, 1)] = f.D[(0, 0)];
    D.view_mut((0, 0), (2, 1)).copy_from(&p.D);
    Ok(StateSpace::new(A, B, C, D, f.time)?)
}

/// The nominal plant as the theory wants it: scalar, continuous, D = 0 once rounding is taken off.
pub(crate) fn strictly_proper(nominal: &StateSpace) -> Result<StateSpace, Error> {
    let (inputs, outputs) = (nominal.inputs(), nominal.outputs());
    if (inputs, outputs) != (1, 1) {
        return Err(Error::NotScalar { inputs, outputs });
    }
    if nominal.time != Time::Continuous {
        return Err(Error::NotContinuous { time: nominal.time });
    }
    let value = nominal.D[(0, 0)];
    let fastest = nominal.poles().iter().map(|p| p.norm()).fold(0.0, f64::max);
    let gain = nominal.at(C64::new(0.0, if fastest > 0.0 { fastest } else { 1.0 }))[(0, 0)].norm();
    if !(value.abs() <= FEEDTHROUGH * gain) {
        return Err(Error::Feedthrough { value });
    }
    Ok(StateSpace { D: Mat::zeros(1, 1), ..nominal.clone() })
}

/// A feedthrough below this part of the gain at the fastest pole is what identification leaves of zero.
const FEEDTHROUGH: f64 = 1e-9;

pub(crate) fn expect_positive(name: &'static str, value: f64, or_zero: bool) -> Result<(), Error> {
    let fits = value.is_finite() && (value > 0.0 || or_zero && value == 0.0);
    let needed = if or_zero { "not negative" } else { "positive" };
    if fits { Ok(()) } else { Err(Error::Setting { name, value, needed }) }
}

/// Poles minus zeros.
fn relative_degree(nominal: &StateSpace) -> Result<usize, Error> {
    let zeros = flexbeam_lti::zeros::transmission_zeros(nominal)?.len();
    Ok(nominal.order() - zeros)
}
