//! The physical parameters by structured least squares, with standard errors.
//!
//! Enters: voltage, theta, alpha, first values of the parameters. Leaves: the parameters whose linear rig, (18) behind a
//! zero-order hold, has the output nearest to the recorded one. Deliberately absent: friction, dead zone, the distributed beam.

use flexbeam_lti::exponential::exponential_minus_identity;
use flexbeam_lti::{Mat, Vector};
use flexbeam_rig::Lumped;

use crate::Error;
use crate::triangle::{CHUNK_ROWS, Triangle};

/// Parameters: k1, k2, c, b.
const PARAMETERS: usize = 4;
/// States, and with them unknown initial values.
const STATES: usize = 4;
/// Unknowns that enter linearly: the initial state, a voltage added to the recorded one, and what the gauge shows at rest.
const LINEAR: usize = STATES + 2;
const VOLTAGE_OFFSET: usize = STATES;
const ALPHA_OFFSET: usize = STATES + 1;
const UNKNOWNS: usize = PARAMETERS + LINEAR;
/// Gauss-Newton converges in five to ten steps from an unstructured estimate; more are a sign of a wrong model.
const MOST_ITERATIONS: usize = 60;
/// A step below this part of its standard error changes nothing that the data can tell.
const STEP_OVER_STD: f64 = 1e-3;
/// A relative step below this is rounding: without noise the standard errors vanish and give no scale.
const STEP_OVER_VALUE: f64 = 1e-14;
/// Levenberg's factor: first value, and how it answers to a good and a bad step.
const DAMPING: (f64, f64, f64) = (1e-6, 0.1, 10.0);
/// Beyond this damping the step is shorter than rounding.
const MOST_DAMPING: f64 = 1e12;
/// Residuals below this part of an output are rounding of the simulation; weights do not rise above it.
const RESIDUAL_FLOOR: f64 = 1e-14;

/// Physical parameters with standard errors.
#[derive(Clone, Debug)]
pub struct LinkFit {
    /// The estimate.
    pub parameters: Lumped,
    /// One standard error of each, for white noise on the outputs.
    pub standard_errors: Lumped,
    /// theta, alpha, theta', alpha' at the first sample.
    pub initial_state: Vector,
    /// Constant voltage that acts beside the recorded one [V]: an asymmetric dead zone, or a mean that was removed.
    pub voltage_offset_v: f64,
    /// What the gauge shows at rest [rad].
    pub alpha_offset_rad: f64,
    /// Root mean square of what is left of theta and alpha [rad].
    pub residual_rms_rad: [f64; 2],
    /// Linearisations used.
    pub iterations: usize,
}

/// Least squares of (18)'s sampled output on theta and alpha over k1, k2, c, b, the initial state and two offsets.
///
/// Shapes: three records of the same length, one sample a period.
/// Assumes: white noise on the outputs, of two unknown variances; each output is weighted by what it leaves.
/// Errors: [`Error::Length`], [`Error::TooFewSamples`], [`Error::NotSettled`].
/// Numerics: Levenberg-Marquardt on the triangular factor of the Jacobian; exact gradients: d e^M from e^[M dM; 0 M]. 1e-12 without noise.
/// Source: Ljung 1999, sections 7.4 and 9.4 (output error, standard errors); Van Loan 1978 for the block exponential.
pub fn structured_fit(
    voltage_v: &[f64],
    theta_rad: &[f64],
    alpha_rad: &[f64],
    period_s: f64,
    start: Lumped,
) -> Result<LinkFit, Error> {
    let record = Record::new(voltage_v, theta_rad, alpha_rad, period_s)?;
    let mut sigma = record.rms();
    let mut point = start.to_array();
    // These enter linearly: whatever they are now, the first step finds them.
    let mut linear = Vector::zeros(LINEAR);
    linear[0] = theta_rad[0];
    linear[1] = alpha_rad[0];
    let mut lambda = DAMPING.0;
    let mut at = record.linearised(&point, &linear, &sigma);
    for iterations in 1..=MOST_ITERATIONS {
        let (step, linear_step) = at.step(lambda);
        let settled = at.settled(&point, &step);
        let next: [f64; PARAMETERS] = std::array::from_fn(|p| point[p] + step[p]);
        let next_linear = &linear + linear_step;
        let tried = record.linearised(&next, &next_linear, &sigma);
        // Within rounding of the least there is no descent left to see.
        if tried.cost() <= at.cost() || settled {
            (point, linear) = (next, next_linear);
            lambda *= DAMPING.1;
            sigma = record.noise(&tried);
            at = record.linearised(&point, &linear, &sigma);
            if settled {
                return Ok(at.into_fit(point, &linear, iterations));
            }
        } else {
            lambda *= DAMPING.2;
        }
        if lambda > MOST_DAMPING {
            break;
        }
    }
    let step = at.step(lambda).0;
    let relative = (0..PARAMETERS).map(|p| (step[p] / point[p]).abs()).fold(0.0, f64::max);
    Err(Error::NotSettled { iterations: MOST_ITERATIONS, step: relative })
}

/// Standard errors that [`structured_fit`] will have, before anything is recorded: square roots of the diagonal of the
/// inverse Fisher information, with the initial state and the two offsets unknown as they are to the fit.
///
/// Shapes: one voltage a sample; `noise_rad` the standard deviations of the noise on theta and alpha.
/// Assumes: the rig is (18) with these parameters, started at rest, and the noise white, Gaussian and independent.
/// Errors: [`Error::Setting`] for a noise that is not positive; [`Error::TooFewSamples`].
/// Source: Ljung 1999, section 7.4 (Cramer-Rao) and 13.3 (design of the input).
pub fn expected_errors(
    voltage_v: &[f64],
    period_s: f64,
    nominal: &Lumped,
    noise_rad: [f64; 2],
) -> Result<Lumped, Error> {
    if let Some(found) = noise_rad.into_iter().find(|sigma| !(*sigma > 0.0 && sigma.is_finite())) {
        return Err(Error::Setting { setting: "the noise of a sensor [rad]", found, needed: "a positive number" });
    }
    // The Jacobian asks what the model answers, never what was measured.
    let unmeasured = vec![0.0; voltage_v.len()];
    let record = Record::new(voltage_v, &unmeasured, &unmeasured, period_s)?;
    let at = record.linearised(&nominal.to_array(), &Vector::zeros(LINEAR), &noise_rad);
    Ok(Lumped::from_array(at.standard_errors()))
}

struct Record<'a> {
    voltage_v: &'a [f64],
    outputs: [&'a [f64]; 2],
    period_s: f64,
}

/// Triangular factor of the weighted Jacobian with the residuals as its last column.
struct Linearised {
    R: Mat,
    squares: [f64; 2],
    samples: usize,
}

impl<'a> Record<'a> {
    fn new(
        voltage_v: &'a [f64],
        theta_rad: &'a [f64],
        alpha_rad: &'a [f64],
        period_s: f64,
    ) -> Result<Record<'a>, Error> {
        let s = voltage_v.len();
        for outputs in [theta_rad.len(), alpha_rad.len()] {
            if outputs != s {
                return Err(Error::Length { inputs: s, outputs });
            }
        }
        if s < UNKNOWNS {
            return Err(Error::TooFewSamples {
                what: "the physical parameters",
                found: s,
                needed: UNKNOWNS,
                block_rows: 1,
            });
        }
        Ok(Record { voltage_v, outputs: [theta_rad, alpha_rad], period_s })
    }

    fn rms(&self) -> [f64; 2] {
        self.outputs.map(|y| (y.iter().map(|x| x * x).sum::<f64>() / y.len() as f64).sqrt().max(f64::MIN_POSITIVE))
    }

    /// Standard deviation of what an output leaves.
    fn noise(&self, at: &Linearised) -> [f64; 2] {
        let rms = self.rms();
        std::array::from_fn(|o| (at.squares[o] / at.samples as f64).sqrt().max(RESIDUAL_FLOOR * rms[o]))
    }

    /// Simulates (18) and the sensitivities of its outputs to all unknowns.
    fn linearised(&self, point: &[f64; PARAMETERS], linear: &Vector, sigma: &[f64; 2]) -> Linearised {
        let sampled = Sensitive::new(point, self.period_s);
        let mut state = Trajectory::new(linear);
        let mut triangle = Triangle::new(UNKNOWNS + 1);
        let mut squares = [0.0; 2];
        let shown = [0.0, linear[ALPHA_OFFSET]];
        let s = self.voltage_v.len();
        for first in (0..s).step_by(CHUNK_ROWS) {
            let width = CHUNK_ROWS.min(s - first);
            let mut chunk = Mat::zeros(2 * width, UNKNOWNS + 1);
            for k in 0..width {
                for o in 0..2 {
                    let residual = self.outputs[o][first + k] - state.x[o] - shown[o];
                    squares[o] += residual * residual;
                    let row = 2 * k + o;
                    for p in 0..PARAMETERS {
                        chunk[(row, p)] = state.by_parameter[p][o] / sigma[o];
                    }
                    for q in 0..STATES {
                        chunk[(row, PARAMETERS + q)] = state.by_initial[q][o] / sigma[o];
                    }
                    chunk[(row, PARAMETERS + VOLTAGE_OFFSET)] = state.by_voltage[o] / sigma[o];
                    chunk[(row, PARAMETERS + ALPHA_OFFSET)] = o as f64 / sigma[o];
                    chunk[(row, UNKNOWNS)] = residual / sigma[o];
                }
                state.advance(&sampled, self.voltage_v[first + k] + linear[VOLTAGE_OFFSET]);
            }
            triangle.absorb(&mut chunk);
        }
        Linearised { R: triangle.R, squares, samples: s }
    }
}

impl Linearised {
    /// Sum of squares of the weighted residuals.
    fn cost(&self) -> f64 {
        let cost = self.R.column(UNKNOWNS).norm_squared();
        if cost.is_finite() { cost } else { f64::INFINITY }
    }

    /// Levenberg-Marquardt step of the parameters and of the linear unknowns.
    fn step(&self, lambda: f64) -> ([f64; PARAMETERS], Vector) {
        let mut damped = Triangle { R: self.R.clone() };
        let mut rows = Mat::zeros(UNKNOWNS, UNKNOWNS + 1);
        (0..UNKNOWNS).for_each(|k| rows[(k, k)] = lambda.sqrt() * self.R.column(k).norm());
        damped.absorb(&mut rows);
        let R = damped.R.view((0, 0), (UNKNOWNS, UNKNOWNS)).into_owned();
        let right = damped.R.view((0, UNKNOWNS), (UNKNOWNS, 1)).into_owned();
        let step = R.solve_upper_triangular(&right).unwrap_or_else(|| Mat::zeros(UNKNOWNS, 1));
        (std::array::from_fn(|p| step[p]), Vector::from_column_slice(&step.as_slice()[PARAMETERS..]))
    }

    /// Square roots of the diagonal of (R'R)^-1: lengths of the rows of R^-1.
    fn standard_errors(&self) -> [f64; PARAMETERS] {
        let R = self.R.view((0, 0), (UNKNOWNS, UNKNOWNS)).into_owned();
        // Row p of R^-1 is the solution z of R' z = e_p, transposed.
        std::array::from_fn(|p| {
            let mut e = Vector::zeros(UNKNOWNS);
            e[p] = 1.0;
            R.tr_solve_upper_triangular(&e).map_or(f64::INFINITY, |z| z.norm())
        })
    }

    fn settled(&self, point: &[f64; PARAMETERS], step: &[f64; PARAMETERS]) -> bool {
        let std = self.standard_errors();
        let scale = (self.cost() / (2 * self.samples - UNKNOWNS) as f64).sqrt();
        (0..PARAMETERS).all(|p| {
            step[p].abs() <= STEP_OVER_VALUE * point[p].abs() || step[p].abs() <= STEP_OVER_STD * scale * std[p]
        })
    }

    fn into_fit(self, point: [f64; PARAMETERS], linear: &Vector, iterations: usize) -> LinkFit {
        LinkFit {
            parameters: Lumped::from_array(point),
            standard_errors: Lumped::from_array(self.standard_errors()),
            initial_state: linear.rows(0, STATES).into_owned(),
            voltage_offset_v: linear[VOLTAGE_OFFSET],
            alpha_offset_rad: linear[ALPHA_OFFSET],
            residual_rms_rad: self.squares.map(|x| (x / self.samples as f64).sqrt()),
            iterations,
        }
    }
}

/// Sampled (18) with its derivatives by the parameters.
///
/// The matrices act on differences: x(k+1) - x(k) = E [x(k); u(k)], so that positions do not lose the digits of a small step.
struct Sensitive {
    E: Step,
    by_parameter: [Step; PARAMETERS],
}

/// One row of [Phi - I, Gamma] for each state.
type Step = [[f64; STATES + 1]; STATES];

impl Sensitive {
    fn new(point: &[f64; PARAMETERS], period_s: f64) -> Sensitive {
        let M = held(&Lumped::from_array(*point)) * period_s;
        let E = rows_of(&exponential_minus_identity(&M));
        let by_parameter = std::array::from_fn(|p| {
            let mut direction = [0.0; PARAMETERS];
            direction[p] = 1.0;
            // (18) is linear in its parameters except for the two fixed ones.
            let dM = (held(&Lumped::from_array(direction)) - held(&Lumped::from_array([0.0; 4]))) * period_s;
            let mut block = Mat::zeros(2 * (STATES + 1), 2 * (STATES + 1));
            block.view_mut((0, 0), M.shape()).copy_from(&M);
            block.view_mut((STATES + 1, STATES + 1), M.shape()).copy_from(&M);
            block.view_mut((0, STATES + 1), M.shape()).copy_from(&dM);
            rows_of(&exponential_minus_identity(&block).columns(STATES + 1, STATES + 1).into_owned())
        });
        Sensitive { E, by_parameter }
    }
}

/// [A B; 0 0].
fn held(parameters: &Lumped) -> Mat {
    let (A, B) = parameters.matrices();
    let mut M = Mat::zeros(STATES + 1, STATES + 1);
    M.view_mut((0, 0), (STATES, STATES)).copy_from(&A);
    M.view_mut((0, STATES), (STATES, 1)).copy_from(&B);
    M
}

fn rows_of(M: &Mat) -> Step {
    std::array::from_fn(|r| std::array::from_fn(|c| M[(r, c)]))
}

/// State and its derivatives by every unknown.
struct Trajectory {
    x: [f64; STATES],
    by_parameter: [[f64; STATES]; PARAMETERS],
    by_initial: [[f64; STATES]; STATES],
    by_voltage: [f64; STATES],
}

impl Trajectory {
    fn new(linear: &Vector) -> Trajectory {
        let mut by_initial = [[0.0; STATES]; STATES];
        (0..STATES).for_each(|q| by_initial[q][q] = 1.0);
        Trajectory {
            x: std::array::from_fn(|k| linear[k]),
            by_parameter: [[0.0; STATES]; PARAMETERS],
            by_initial,
            by_voltage: [0.0; STATES],
        }
    }

    fn advance(&mut self, sampled: &Sensitive, u: f64) {
        for (p, by) in self.by_parameter.iter_mut().enumerate() {
            let through = increment(&sampled.E, by, 0.0);
            let direct = increment(&sampled.by_parameter[p], &self.x, u);
            (0..STATES).for_each(|k| by[k] += through[k] + direct[k]);
        }
        for by in &mut self.by_initial {
            let through = increment(&sampled.E, by, 0.0);
            (0..STATES).for_each(|k| by[k] += through[k]);
        }
        let through = increment(&sampled.E, &self.by_voltage, 1.0);
        (0..STATES).for_each(|k| self.by_voltage[k] += through[k]);
        let step = increment(&sampled.E, &self.x, u);
        (0..STATES).for_each(|k| self.x[k] += step[k]);
    }
}

fn increment(step: &Step, x: &[f64; STATES], u: f64) -> [f64; STATES] {
    std::array::from_fn(|r| (0..STATES).map(|c| step[r][c] * x[c]).sum::<f64>() + step[r][STATES] * u)
}
