//! The physical parameters by structured least squares, with standard errors.
//!
//! Enters: voltage, any outputs made of theta and alpha, first values of the parameters. Leaves: the parameters whose linear rig,
//! (18) behind a zero-order hold, has the outputs nearest to the recorded ones. Deliberately absent: Coulomb friction, dead
//! zone, the distributed beam.
//!
//! With Delta(s) = s^3 + c s^2 + k2 s + c (k2 - k1), whose coefficients are three of the four parameters,
//!
//! ```text
//! theta/V = b (s^2 + k2 - k1) / (s Delta),   alpha/V = -b s / Delta,   psi/V = b (k2 - k1) / (s Delta)
//! ```
//!
//! so each output alone determines all four. A fifth, damping within the beam, shows as the zero -1/eta of psi and in theta's, but
//! not in alpha alone, whose four coefficients are all taken. The deflection does not see the integrator: not where the hub stands, and not a
//! constant voltage, which looks like a speed that it began with. Viscous friction at the hub is part of c.

mod trajectory;

use flexbeam_lti::{Mat, Vector};
use flexbeam_rig::{Lumped, Output};

use crate::Error;
use crate::triangle::{CHUNK_ROWS, Triangle};
use trajectory::{PARAMETERS, STATES, Sensitive, Trajectory};

/// Places among the unknowns: parameters, initial state, a voltage added to the recorded one, what each output shows at rest.
const ETA: usize = PARAMETERS - 1;
const VOLTAGE_OFFSET: usize = PARAMETERS + STATES;
const OUTPUT_OFFSETS: usize = VOLTAGE_OFFSET + 1;
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

/// One recorded output.
#[derive(Clone, Copy, Debug)]
pub struct Measured<'a> {
    /// What it shows.
    pub output: Output,
    /// One value a sample, in the output's unit.
    pub samples: &'a [f64],
}

/// What the beam's own damping is known to be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum BeamDamping {
    /// None, as in (18).
    #[default]
    None,
    /// Unknown: the beam pulls with K_stiff (alpha + eta alpha'), eta to be found; a first value [s].
    Unknown(f64),
}

/// A number and its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// One standard error.
    pub standard_error: f64,
}

/// Physical parameters with standard errors.
#[derive(Clone, Debug)]
pub struct LinkFit {
    /// The estimate.
    pub parameters: Lumped,
    /// One standard error of each, for white noise on the outputs.
    pub standard_errors: Lumped,
    /// eta [s], where it was unknown.
    pub beam_damping_s: Option<Estimate>,
    /// theta, alpha, theta', alpha' at the first sample; theta zero where no output sees it.
    pub initial_state: Vector,
    /// Constant voltage that acts beside the recorded one [V]: an asymmetric dead zone, or a mean that was removed. Zero where no
    /// output sees theta.
    pub voltage_offset_v: f64,
    /// What each output shows at rest; zero for the first one that sees theta, whose rest is where theta begins.
    pub offsets: Vec<f64>,
    /// Root mean square of what is left of each output.
    pub residual_rms: Vec<f64>,
    /// Linearisations used.
    pub iterations: usize,
}

/// Least squares of (18)'s sampled outputs on recorded ones over k1, k2, c, b, the initial state and offsets.
///
/// Shapes: records of the same length, one sample a period.
/// Assumes: white noise on the outputs, of unknown variances; each output is weighted by what it leaves.
/// Errors: [`Error::NoChannel`], [`Error::Length`], [`Error::TooFewSamples`], [`Error::NotSettled`], [`Error::NoLink`],
/// [`Error::BeamDampingUnseen`], /// [`Error::Linear`].
/// Numerics: Levenberg-Marquardt on the triangular factor of the Jacobian; exact gradients: d e^M from e^[M dM; 0 M]. 1e-12 without noise.
/// Source: Ljung 1999, sections 7.4 and 9.4 (output error, standard errors); Van Loan 1978 for the block exponential.
pub fn structured_fit(
    voltage_v: &[f64],
    measured: &[Measured],
    period_s: f64,
    start: Lumped,
    damping: BeamDamping,
) -> Result<LinkFit, Error> {
    let record = Record::new(voltage_v, measured, period_s, damping)?;
    let mut sigma = record.rms();
    let mut point = record.start(start, damping);
    let mut lambda = DAMPING.0;
    let mut at = record.linearised(&point, &sigma);
    for iterations in 1..=MOST_ITERATIONS {
        let step = at.step(lambda);
        let settled = at.settled(&point, &step);
        let next = &point + step;
        let tried = record.linearised(&next, &sigma);
        // Within rounding of the least there is no descent left to see.
        if tried.cost() <= at.cost() || settled {
            point = next;
            lambda *= DAMPING.1;
            sigma = record.noise(&tried);
            at = record.linearised(&point, &sigma);
            if settled {
                return expect_link(record.fit(&at, &point, iterations));
            }
        } else {
            lambda *= DAMPING.2;
        }
        if lambda > MOST_DAMPING {
            break;
        }
    }
    let step = at.step(lambda);
    let relative = (0..ETA).map(|p| (step[p] / point[p]).abs()).fold(0.0, f64::max);
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
    let measured = [Output::Theta, Output::Alpha].map(|output| Measured { output, samples: &unmeasured });
    let record = Record::new(voltage_v, &measured, period_s, BeamDamping::None)?;
    let at = record.linearised(&record.start(*nominal, BeamDamping::None), &noise_rad);
    Ok(parameters_of(&at.standard_errors()))
}

/// Errors: [`Error::NoLink`] where stiffness, inertia or damping would be negative.
fn expect_link(fit: LinkFit) -> Result<LinkFit, Error> {
    let Lumped { k1, k2, c, b } = fit.parameters;
    if k1 > 0.0 && k2 > k1 && c > 0.0 && b > 0.0 { Ok(fit) } else { Err(Error::NoLink { k1, k2, c, b }) }
}

struct Record<'a> {
    voltage_v: &'a [f64],
    outputs: &'a [Measured<'a>],
    /// Parts of theta and alpha in each output.
    weights: Vec<[f64; 2]>,
    period_s: f64,
    /// Places of the unknowns that the outputs tell.
    unknown: Vec<usize>,
}

/// Triangular factor of the weighted Jacobian with the residuals as its last column.
struct Linearised {
    R: Mat,
    squares: Vec<f64>,
    samples: usize,
    unknown: Vec<usize>,
    all: usize,
}

impl<'a> Record<'a> {
    fn new(
        voltage_v: &'a [f64],
        outputs: &'a [Measured<'a>],
        period_s: f64,
        damping: BeamDamping,
    ) -> Result<Record<'a>, Error> {
        let s = voltage_v.len();
        if outputs.is_empty() {
            return Err(Error::NoChannel { inputs: 1, outputs: 0 });
        }
        if let Some(other) = outputs.iter().find(|y| y.samples.len() != s) {
            return Err(Error::Length { inputs: s, outputs: other.samples.len() });
        }
        let shown: Vec<Output> = outputs.iter().map(|y| y.output).collect();
        let C = Lumped::PAPER.state_space(&shown)?.C;
        let weights: Vec<[f64; 2]> = C.row_iter().map(|row| [row[0], row[1]]).collect();
        let unknown = unknowns(&weights, damping);
        if unknown.contains(&ETA) && !unknown.contains(&VOLTAGE_OFFSET) {
            return Err(Error::BeamDampingUnseen);
        }
        let needed = unknown.len().div_ceil(outputs.len()) + 1;
        if s < needed {
            let what = "the physical parameters";
            return Err(Error::TooFewSamples { what, found: s, needed, block_rows: 1 });
        }
        Ok(Record { voltage_v, outputs, weights, period_s, unknown })
    }

    /// The parameters, and zeros for what enters linearly: whatever that is, the first step finds it.
    fn start(&self, start: Lumped, damping: BeamDamping) -> Vector {
        let mut point = Vector::zeros(self.all());
        point.as_mut_slice()[..ETA].copy_from_slice(&start.to_array());
        if let BeamDamping::Unknown(eta_s) = damping {
            point[ETA] = eta_s;
        }
        point
    }

    fn all(&self) -> usize {
        OUTPUT_OFFSETS + self.outputs.len()
    }

    fn rms(&self) -> Vec<f64> {
        let rms = |y: &[f64]| (y.iter().map(|x| x * x).sum::<f64>() / y.len() as f64).sqrt().max(f64::MIN_POSITIVE);
        self.outputs.iter().map(|y| rms(y.samples)).collect()
    }

    /// Standard deviation of what an output leaves.
    fn noise(&self, at: &Linearised) -> Vec<f64> {
        // Each output pays for its share of the unknowns.
        let free = at.samples as f64 - self.unknown.len() as f64 / self.outputs.len() as f64;
        let left = at.squares.iter().map(|squares| (squares / free).sqrt());
        left.zip(self.rms()).map(|(left, rms)| left.max(RESIDUAL_FLOOR * rms)).collect()
    }

    /// Simulates (18) and the sensitivities of its outputs to all unknowns.
    fn linearised(&self, point: &Vector, sigma: &[f64]) -> Linearised {
        let (l, s, unknowns) = (self.outputs.len(), self.voltage_v.len(), self.unknown.len());
        let sampled = Sensitive::new(&parameters(point), self.period_s);
        let mut state = Trajectory::new(&point.as_slice()[PARAMETERS..VOLTAGE_OFFSET]);
        let mut triangle = Triangle::new(unknowns + 1);
        let mut squares = vec![0.0; l];
        let mut all = vec![0.0; self.all()];
        for first in (0..s).step_by(CHUNK_ROWS) {
            let width = CHUNK_ROWS.min(s - first);
            let mut chunk = Mat::zeros(l * width, unknowns + 1);
            for k in 0..width {
                for o in 0..l {
                    let shown = seen(self.weights[o], &state.x) + point[OUTPUT_OFFSETS + o];
                    let residual = self.outputs[o].samples[first + k] - shown;
                    squares[o] += residual * residual;
                    self.derivatives(&state, o, &mut all);
                    let row = l * k + o;
                    self.unknown.iter().enumerate().for_each(|(c, q)| chunk[(row, c)] = all[*q] / sigma[o]);
                    chunk[(row, unknowns)] = residual / sigma[o];
                }
                state.advance(&sampled, self.voltage_v[first + k] + point[VOLTAGE_OFFSET]);
            }
            triangle.absorb(&mut chunk);
        }
        Linearised { R: triangle.R, squares, samples: s, unknown: self.unknown.clone(), all: self.all() }
    }

    /// Of output `o` by everything, known or not.
    fn derivatives(&self, state: &Trajectory, o: usize, all: &mut [f64]) {
        let weights = self.weights[o];
        let by_state = state.by_parameter.iter().chain(&state.by_initial).chain([&state.by_voltage]);
        all.iter_mut().zip(by_state).for_each(|(d, x)| *d = seen(weights, x));
        all[OUTPUT_OFFSETS..].fill(0.0);
        all[OUTPUT_OFFSETS + o] = 1.0;
    }

    fn fit(&self, at: &Linearised, point: &Vector, iterations: usize) -> LinkFit {
        let std = at.standard_errors();
        let free = self.unknown.contains(&ETA);
        LinkFit {
            parameters: parameters_of(point),
            standard_errors: parameters_of(&std),
            beam_damping_s: free.then(|| Estimate { value: point[ETA], standard_error: std[ETA] }),
            initial_state: point.rows(PARAMETERS, STATES).into_owned(),
            voltage_offset_v: point[VOLTAGE_OFFSET],
            offsets: point.as_slice()[OUTPUT_OFFSETS..].to_vec(),
            residual_rms: at.squares.iter().map(|x| (x / at.samples as f64).sqrt()).collect(),
            iterations,
        }
    }
}

/// What outputs with these parts of theta and alpha tell.
fn unknowns(weights: &[[f64; 2]], damping: BeamDamping) -> Vec<usize> {
    let first_of_theta = weights.iter().position(|w| w[0] != 0.0);
    let told = |place: usize| match place {
        ETA => damping != BeamDamping::None,
        PARAMETERS | VOLTAGE_OFFSET => first_of_theta.is_some(),
        OUTPUT_OFFSETS.. => Some(place - OUTPUT_OFFSETS) != first_of_theta,
        _ => true,
    };
    (0..OUTPUT_OFFSETS + weights.len()).filter(|place| told(*place)).collect()
}

fn parameters(point: &Vector) -> [f64; PARAMETERS] {
    std::array::from_fn(|p| point[p])
}

/// k1, k2, c, b of all unknowns.
fn parameters_of(all: &Vector) -> Lumped {
    Lumped::from_array([all[0], all[1], all[2], all[3]])
}

fn seen(weights: [f64; 2], x: &[f64; STATES]) -> f64 {
    weights[0] * x[0] + weights[1] * x[1]
}

impl Linearised {
    /// Sum of squares of the weighted residuals.
    fn cost(&self) -> f64 {
        let cost = self.R.column(self.unknown.len()).norm_squared();
        if cost.is_finite() { cost } else { f64::INFINITY }
    }

    /// Levenberg-Marquardt step of everything, zero where it is known.
    fn step(&self, lambda: f64) -> Vector {
        let d = self.unknown.len();
        let mut damped = Triangle { R: self.R.clone() };
        let mut rows = Mat::zeros(d, d + 1);
        (0..d).for_each(|k| rows[(k, k)] = lambda.sqrt() * self.R.column(k).norm());
        damped.absorb(&mut rows);
        let R = damped.R.view((0, 0), (d, d)).into_owned();
        let right = damped.R.view((0, d), (d, 1)).into_owned();
        self.spread(R.solve_upper_triangular(&right).unwrap_or_else(|| Mat::zeros(d, 1)).as_slice())
    }

    /// Square roots of the diagonal of (R'R)^-1: lengths of the rows of R^-1.
    fn standard_errors(&self) -> Vector {
        let d = self.unknown.len();
        let R = self.R.view((0, 0), (d, d)).into_owned();
        // Row p of R^-1 is the solution z of R' z = e_p, transposed.
        let lengths = (0..d).map(|p| {
            let e = Vector::from_fn(d, |k, _| f64::from(k == p));
            R.tr_solve_upper_triangular(&e).map_or(f64::INFINITY, |z| z.norm())
        });
        self.spread(&lengths.collect::<Vec<_>>())
    }

    fn spread(&self, values: &[f64]) -> Vector {
        let mut all = Vector::zeros(self.all);
        self.unknown.iter().zip(values).for_each(|(place, x)| all[*place] = *x);
        all
    }

    fn settled(&self, point: &Vector, step: &Vector) -> bool {
        let std = self.standard_errors();
        let rows = self.squares.len() * self.samples;
        let scale = (self.cost() / (rows - self.unknown.len()) as f64).sqrt();
        (0..PARAMETERS).all(|p| {
            step[p].abs() <= STEP_OVER_VALUE * point[p].abs() || step[p].abs() <= STEP_OVER_STD * scale * std[p]
        })
    }
}
