//! Optimal model matching: the reference model M and the prefilter T = M/N.
//!
//! Enters: rise time, overshoot or M itself, the voltage that the largest step may take. Leaves: T and M as one sampled system.
//!
//! Source: (23)-(27) with the rule of DESIGN 6.4. Sampling gives a plant zeros of its own; those with negative real part
//! alternate in sign from sample to sample, and an inverse of them would ring at the Nyquist frequency. M keeps them.

use flexbeam_lti::reduction::balanced_truncation;
use flexbeam_lti::simulation::simulate;
use flexbeam_lti::{C64, Mat, Rational, StateSpace, Time, Vector, Zpk, sampling};

use crate::Error;
use crate::feedback::Feedback;

/// What the tip is asked to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Reference {
    /// As fast as the largest step's voltage permits.
    Fastest {
        /// Overshoot of M [percent].
        overshoot_percent: f64,
        /// Largest voltage of the nominal loop [V].
        max_voltage_v: f64,
        /// Largest step [rad].
        max_step_rad: f64,
    },
    /// Given rise time, 10 to 90 percent.
    RiseTime {
        /// Rise time of M [s].
        rise_time_s: f64,
        /// Overshoot of M [percent].
        overshoot_percent: f64,
    },
    /// M given by its coefficients.
    Model(Rational),
}

/// The continuous reference model M, M(0) = 1.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceModel {
    /// Zeros, poles, gain.
    pub zpk: Zpk,
    /// 10 to 90 percent rise time [s].
    pub rise_time_s: f64,
}

/// The prefilter for one period.
#[derive(Clone, Debug)]
pub struct Prefilter {
    /// The continuous model it follows.
    pub model: ReferenceModel,
    /// Input v, outputs (T v, M v).
    pub system: StateSpace,
    /// Largest |u| of the nominal loop for a unit step [V/rad], exact: u is constant between samples.
    pub peak_voltage_per_rad: f64,
}

/// The two poles beyond the dominant pair lie this many times farther out: they shape the start, not the rise.
const FAST_POLES: f64 = 3.0;

/// The slowest model that is tried has its slowest pole this much left of -beta, relative to beta.
const LEFT_OF_BETA: f64 = 1e-6;

/// The slowest rise time that is tried when beta = 0 [s].
const SLOWEST_S: f64 = 100.0;

impl ReferenceModel {
    /// A damped pair for the overshoot, further poles for the relative degree, rise time 1 s.
    ///
    /// Errors: [`Error::Setting`] for an overshoot that is negative or beyond what these poles can do.
    /// Numerics: the damping ratio is bisected on the overshoot of the whole M, since the further poles take some of it.
    pub fn with_overshoot(overshoot_percent: f64, relative_degree: usize) -> Result<ReferenceModel, Error> {
        let damped = |zeta: f64| {
            let imaginary = (1.0 - zeta * zeta).max(0.0).sqrt();
            let mut poles = vec![C64::new(-zeta, imaginary), C64::new(-zeta, -imaginary)];
            poles.resize(relative_degree.max(2), C64::new(-FAST_POLES, 0.0));
            with_unit_gain(vec![], poles)
        };
        let zpk = damped(damping_ratio(overshoot_percent, |zeta| Ok(Step::of(&damped(zeta))?.overshoot_percent()))?);
        Ok(ReferenceModel { rise_time_s: Step::of(&zpk)?.rise_time_s(), zpk }.scaled_to(1.0))
    }

    /// The same model, faster or slower.
    #[must_use]
    pub fn scaled_to(&self, rise_time_s: f64) -> ReferenceModel {
        let scale = self.rise_time_s / rise_time_s;
        let poles = self.zpk.poles.iter().map(|p| p * scale).collect();
        let zeros = self.zpk.zeros.iter().map(|z| z * scale).collect();
        ReferenceModel { zpk: with_unit_gain(zeros, poles), rise_time_s }
    }

    /// M from its coefficients, scaled to M(0) = 1.
    pub fn from_rational(M: &Rational) -> Result<ReferenceModel, Error> {
        let zpk = with_unit_gain(M.zeros()?, M.poles()?);
        if !zpk.gain.is_finite() {
            return Err(Error::Setting { name: "M(0)", value: 0.0, needed: "not 0: the tip is to arrive" });
        }
        Ok(ReferenceModel { rise_time_s: Step::of(&zpk)?.rise_time_s(), zpk })
    }

    fn relative_degree(&self) -> usize {
        self.zpk.poles.len() - self.zpk.zeros.len()
    }
}

/// The prefilter of the loop made of `plant` (sampled, unshifted) and `feedback`.
///
/// `relative_degree` is that of the continuous plant. Errors: [`Error::ReferenceDegree`], [`Error::ReferencePole`],
/// [`Error::Voltage`].
pub fn prefilter(
    plant: &StateSpace,
    feedback: &Feedback,
    relative_degree: usize,
    beta: f64,
    reference: &Reference,
) -> Result<Prefilter, Error> {
    let plant = SampledPlant::new(plant, feedback, beta)?;
    match reference {
        Reference::Model(M) => {
            let model = ReferenceModel::from_rational(M)?;
            expect_matchable(&model, relative_degree, beta)?;
            plant.prefilter(model)
        }
        Reference::RiseTime { rise_time_s, overshoot_percent } => {
            if !(*rise_time_s > 0.0 && rise_time_s.is_finite()) {
                return Err(Error::Setting { name: "rise time [s]", value: *rise_time_s, needed: "positive" });
            }
            let model = ReferenceModel::with_overshoot(*overshoot_percent, relative_degree)?.scaled_to(*rise_time_s);
            expect_matchable(&model, relative_degree, beta)?;
            plant.prefilter(model)
        }
        Reference::Fastest { overshoot_percent, max_voltage_v, max_step_rad } => {
            let unit = ReferenceModel::with_overshoot(*overshoot_percent, relative_degree)?;
            let voltage = |rise_time_s| Ok(plant.peak_voltage(&unit.scaled_to(rise_time_s))? * max_step_rad);
            let slowest_s = slowest_rise_time(&unit, beta);
            let rise_time_s = fastest(voltage, 5.0 * plant.period_s, slowest_s, *max_voltage_v)?;
            let model = unit.scaled_to(rise_time_s);
            expect_matchable(&model, relative_degree, beta)?;
            plant.prefilter(model)
        }
    }
}

/// The rise time of the slowest model whose poles lie left of -beta.
fn slowest_rise_time(unit: &ReferenceModel, beta: f64) -> f64 {
    if beta == 0.0 {
        return SLOWEST_S;
    }
    let slowest = unit.zpk.poles.iter().map(|p| -p.re).fold(f64::INFINITY, f64::min);
    (slowest / (beta * (1.0 + LEFT_OF_BETA))).min(SLOWEST_S)
}

/// The shortest rise time whose voltage stays below the limit, by bisection on a logarithmic scale.
fn fastest(
    voltage: impl Fn(f64) -> Result<f64, Error>,
    shortest_s: f64,
    slowest_s: f64,
    max_voltage_v: f64,
) -> Result<f64, Error> {
    let (mut fast, mut slow) = (shortest_s, slowest_s);
    let least = voltage(slow)?;
    if !(least <= max_voltage_v) {
        return Err(Error::Voltage { voltage_v: least, rise_time_s: slow, max_voltage_v });
    }
    while slow > fast * (1.0 + RISE_TIME_WITHIN) {
        let middle = (fast * slow).sqrt();
        if voltage(middle)? <= max_voltage_v { slow = middle } else { fast = middle }
    }
    Ok(slow)
}

/// Nobody can tell two rise times apart that differ by less.
const RISE_TIME_WITHIN: f64 = 1e-4;

/// The sampled plant with what the matching needs of it.
struct SampledPlant {
    G: Zpk,
    period_s: f64,
    /// Poles of N: the well-damped poles of the plant and the mirrors of the others.
    damped: Vec<C64>,
    kept_zeros: Vec<C64>,
    inverted_zeros: Vec<C64>,
    /// e^(-beta Ts).
    line: f64,
}

/// A zero this close to z = 1 is one at s = 0: eigenvalues near 1 are good to some 1e-15, and the slowest zero of any use lies
/// a hundred times farther away.
const AT_REST: f64 = 1e-11;

impl SampledPlant {
    fn new(plant: &StateSpace, feedback: &Feedback, beta: f64) -> Result<SampledPlant, Error> {
        let Time::Sampled { period_s } = plant.time else { return Err(Error::NotContinuous { time: plant.time }) };
        let G = Zpk::from_state_space(plant)?;
        if G.zeros.iter().any(|z| (z - 1.0).norm() < AT_REST) {
            let needed = "not 0: a constant voltage must move the output, or no reference can be followed";
            return Err(Error::Setting { name: "static gain of the plant", value: 0.0, needed });
        }
        let line = (-beta * period_s).exp();
        let mut damped = remove(&G.poles, &feedback.unstable_poles);
        damped.extend(&feedback.mirrored_poles);
        let (inverted_zeros, kept_zeros) = G.zeros.iter().partition(|z| z.norm() < line && z.re > 0.0);
        Ok(SampledPlant { G, period_s, damped, kept_zeros, inverted_zeros, line })
    }

    /// M sampled: poles and zeros at e^(s Ts), the kept zeros of the plant, delays for the relative degree, M(1) = 1.
    fn sampled_model(&self, M: &ReferenceModel) -> Zpk {
        let map = |s: &C64| (s * self.period_s).exp();
        let mut zeros: Vec<C64> = M.zpk.zeros.iter().map(map).collect();
        zeros.extend(&self.kept_zeros);
        let mut poles: Vec<C64> = M.zpk.poles.iter().map(map).collect();
        // Zeros that the continuous plant has right of -beta enter as an all-pass factor, those of sampling as delays.
        poles.extend(self.kept_zeros.iter().filter(|z| z.re > 0.0).map(|z| z.conj().inv() * self.line * self.line));
        let relative_degree = self.G.poles.len() - self.G.zeros.len();
        poles.resize(poles.len().max(zeros.len() + relative_degree), C64::new(0.0, 0.0));
        let mut sampled = Zpk { zeros, poles, gain: 1.0 };
        sampled.gain = 1.0 / sampled.at(C64::new(1.0, 0.0)).re;
        sampled
    }

    /// T = M/N, N = k prod (z - zeros of G)/prod (z - damped poles): what both have in common is left out by construction.
    fn quotient(&self, M: &ReferenceModel, numerator: &[C64]) -> Zpk {
        let sampled = self.sampled_model(M);
        let mut zeros: Vec<C64> = M.zpk.zeros.iter().map(|s| (s * self.period_s).exp()).collect();
        zeros.extend(numerator);
        let mut poles = sampled.poles;
        poles.extend(&self.inverted_zeros);
        Zpk { zeros, poles, gain: sampled.gain / self.G.gain }
    }

    /// Peak of the step response of D T = M/G, until M has settled.
    fn peak_voltage(&self, M: &ReferenceModel) -> Result<f64, Error> {
        let system = self.quotient(M, &self.G.poles).to_state_space(Time::Sampled { period_s: self.period_s })?;
        let samples = (5.0 * M.rise_time_s / self.period_s) as usize + 2;
        let response = simulate(&system, &Mat::from_element(1, samples, 1.0), &Vector::zeros(system.order()))?;
        Ok(response.amax())
    }

    fn prefilter(&self, model: ReferenceModel) -> Result<Prefilter, Error> {
        let time = Time::Sampled { period_s: self.period_s };
        let peak_voltage_per_rad = self.peak_voltage(&model)?;
        let T = self.quotient(&model, &self.damped).to_state_space(time)?;
        let order = T.order();
        let M = self.sampled_model(&model).to_state_space(time)?;
        let both = stack(&T, &M)?;
        // T and M share their poles: half of the states do. A multiple pole near z = 1 can defeat the Gramians; then all stay.
        let system = balanced_truncation(&both, order).map_or(both, |reduced| reduced.system);
        Ok(Prefilter { model, system, peak_voltage_per_rad })
    }
}

/// One input, the outputs of both.
fn stack(first: &StateSpace, second: &StateSpace) -> Result<StateSpace, Error> {
    let (n, m) = (first.order(), second.order());
    let mut A = Mat::zeros(n + m, n + m);
    A.view_mut((0, 0), (n, n)).copy_from(&first.A);
    A.view_mut((n, n), (m, m)).copy_from(&second.A);
    let B = Mat::from_fn(n + m, 1, |i, _| if i < n { first.B[i] } else { second.B[i - n] });
    let mut C = Mat::zeros(2, n + m);
    C.view_mut((0, 0), (1, n)).copy_from(&first.C);
    C.view_mut((1, n), (1, m)).copy_from(&second.C);
    let D = Mat::from_column_slice(2, 1, &[first.D[0], second.D[0]]);
    Ok(StateSpace::new(A, B, C, D, first.time)?)
}

/// All of `all` but the nearest to each of `some`.
fn remove(all: &[C64], some: &[C64]) -> Vec<C64> {
    let mut left = all.to_vec();
    for p in some {
        if let Some(k) = (0..left.len()).min_by(|a, b| (left[*a] - p).norm().total_cmp(&(left[*b] - p).norm())) {
            left.swap_remove(k);
        }
    }
    left
}

fn expect_matchable(model: &ReferenceModel, relative_degree: usize, beta: f64) -> Result<(), Error> {
    if model.relative_degree() < relative_degree {
        return Err(Error::ReferenceDegree { found: model.relative_degree(), needed: relative_degree });
    }
    match model.zpk.poles.iter().find(|p| !(p.re < -beta)) {
        Some(p) => Err(Error::ReferencePole { re: p.re, im: p.im, line: -beta }),
        None => Ok(()),
    }
}

/// The damping ratio whose step has this overshoot; `overshoot` falls with zeta.
fn damping_ratio(overshoot_percent: f64, overshoot: impl Fn(f64) -> Result<f64, Error>) -> Result<f64, Error> {
    if overshoot_percent == 0.0 {
        return Ok(1.0);
    }
    let (mut light, mut heavy) = (LEAST_DAMPING, 1.0);
    if !(overshoot_percent > 0.0 && overshoot_percent <= overshoot(light)?) {
        let needed = "at least 0, and no more than a pair with a damping ratio of 0.02 has";
        return Err(Error::Setting { name: "overshoot [percent]", value: overshoot_percent, needed });
    }
    while heavy - light > DAMPING_WITHIN {
        let middle = 0.5 * (light + heavy);
        if overshoot(middle)? > overshoot_percent { light = middle } else { heavy = middle }
    }
    Ok(0.5 * (light + heavy))
}

/// A reference model that swings longer than this is no reference.
const LEAST_DAMPING: f64 = 0.02;

/// Moves the overshoot by less than a thousandth of a percent.
const DAMPING_WITHIN: f64 = 1e-6;

fn with_unit_gain(zeros: Vec<C64>, poles: Vec<C64>) -> Zpk {
    let mut M = Zpk { zeros, poles, gain: 1.0 };
    M.gain = 1.0 / M.at(C64::new(0.0, 0.0)).re;
    M
}

/// The step response of a stable M with M(0) = 1.
struct Step {
    y: Mat,
    period_s: f64,
}

impl Step {
    fn of(M: &Zpk) -> Result<Step, Error> {
        let slowest = M.poles.iter().map(|p| -p.re).fold(f64::INFINITY, f64::min);
        if !(slowest > 0.0) {
            let p = M.poles.iter().find(|p| !(p.re < 0.0)).copied().unwrap_or_default();
            return Err(Error::ReferencePole { re: p.re, im: p.im, line: 0.0 });
        }
        let period_s = SPAN / slowest / SAMPLES as f64;
        let sampled = sampling::zoh(&M.to_state_space(Time::Continuous)?, period_s)?;
        let y = simulate(&sampled, &Mat::from_element(1, SAMPLES, 1.0), &Vector::zeros(sampled.order()))?;
        Ok(Step { y, period_s })
    }

    /// From 10 to 90 percent, linear between the samples.
    fn rise_time_s(&self) -> f64 {
        let crossing = |level: f64| {
            let k = self.y.iter().position(|y| *y >= level).unwrap_or(SAMPLES - 1).max(1);
            k as f64 - (self.y[k] - level) / (self.y[k] - self.y[k - 1])
        };
        (crossing(0.9) - crossing(0.1)) * self.period_s
    }

    /// What the highest sample stands above one, with the parabola through its neighbours.
    fn overshoot_percent(&self) -> f64 {
        let k = self.y.row(0).transpose().imax().clamp(1, SAMPLES - 2);
        let (before, here, after) = (self.y[k - 1], self.y[k], self.y[k + 1]);
        let curvature = 2.0 * here - before - after;
        let crest = if curvature > 0.0 { (after - before).powi(2) / (8.0 * curvature) } else { 0.0 };
        100.0 * (here + crest - 1.0).max(0.0)
    }
}

/// The response is followed for this many slowest time constants, which takes it to 1 - 1e-4 and better.
const SPAN: f64 = 15.0;

/// Samples over that span: with a damping ratio of 0.5 the rise time is good to 1e-5, with 0.05 to 1e-3.
const SAMPLES: usize = 6000;
