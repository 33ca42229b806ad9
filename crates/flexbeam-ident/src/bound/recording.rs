//! From a recording and a nominal plant to alpha(s), step by step.

use flexbeam_lti::{Mat, Signals, StateSpace};

use super::{Band, Bound, Full, Source, bound, full, line, poles_beyond, replicates, unexplained};
use crate::{Error, Options, Order, identify};

/// What a bound is made for, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Stability degree [1/s].
    pub beta: f64,
    /// Probability that the band holds on the whole line. Default 0.95.
    pub level: f64,
    /// Re-estimates. Default 99: more cost time and make the band's width less a matter of luck.
    pub replicates: usize,
    /// Of the noise of the re-estimates. Default 1.
    pub seed: u64,
    /// How each model is estimated; order and estimating part are chosen here.
    pub estimation: Options,
}

impl Settings {
    /// The defaults for this stability degree.
    pub fn new(beta: f64) -> Settings {
        Settings { beta, level: 0.95, replicates: 99, seed: 1, estimation: Options::default() }
    }
}

/// A bound, and what it came from.
pub struct FromRecording {
    /// alpha(s).
    pub bound: Bound,
    /// Around the full model.
    pub band: Band,
    /// The full model with all outputs.
    pub full: Full,
    /// The full model from the input to the bounded output, continuous.
    pub model: StateSpace,
}

/// alpha(s) above |G(jw - beta) - nominal(jw - beta)| for the sum of some outputs.
///
/// Where the recording contradicts every order that was tried (friction, too many modes), what the best of them leaves, as
/// measured on s = jw with 95 %, is added to the band. That it is no larger left of the axis is then an assumption that nothing
/// tests, and so is that a pole right of the line that only other orders have is an artefact.
///
/// Shapes: one input; `rows` of the outputs add up to the output of the nominal plant, which is continuous.
/// Assumes: open loop, all samples in steady order: the whole recording estimates.
/// Errors: those of [`full`], [`Band::of_replicates`] and [`bound`].
/// Numerics: up to six estimates to find the order, then one for each re-estimate.
pub fn from_recording(
    inputs: &Signals,
    outputs: &Signals,
    nominal: &StateSpace,
    rows: &[usize],
    settings: &Settings,
) -> Result<FromRecording, Error> {
    let beta = settings.beta;
    if inputs.channels() != 1 {
        let (setting, found) = ("the number of inputs", inputs.channels() as f64);
        return Err(Error::Setting { setting, found, needed: "1 for a bound" });
    }
    if !(beta > 0.0 && beta.is_finite()) {
        let setting = "the stability degree beta [1/s]";
        return Err(Error::Setting { setting, found: beta, needed: "a positive number" });
    }
    let beyond = poles_beyond(nominal, beta).len();
    let full = full(inputs, outputs, &settings.estimation, |model| poles_beyond(model, beta).len() == beyond)?;
    let continuous = full.identified.continuous.as_ref().map_err(|why| Error::Linear(why.clone()))?;
    let model = summed(continuous, rows)?;
    let order = Order::Fixed(full.identified.order);
    let again = Options { order, estimate: 1.0, ..settings.estimation.clone() };
    let (inputs, outputs) = (less(inputs, &full.identified.input_means), less(outputs, &full.identified.output_means));
    let source = Source {
        inputs: &inputs,
        outputs: &outputs,
        model: &full.identified.model,
        initial_state: &full.identified.initial_state,
    };
    let estimate = |U: &Signals, Y: &Signals| summed(&identify(U, Y, &again).ok()?.continuous.ok()?, rows).ok();
    let replicates = replicates(&source, settings.replicates, settings.seed, estimate)?;
    let line = line(&[&model, nominal], beta, BEYOND * std::f64::consts::PI / inputs.period_s);
    let mut band = Band::of_replicates(&model, &replicates, line, beta, settings.level)?;
    if full.contradicted {
        band = band.widened(unexplained(&full.left, rows));
    }
    Ok(FromRecording { bound: bound(&model, nominal, &band, beta)?, band, full, model })
}

/// The line ends at this many times half the sampling frequency, where every model of a beam has fallen.
const BEYOND: f64 = 3.0;

/// One output, the sum of these.
fn summed(system: &StateSpace, rows: &[usize]) -> Result<StateSpace, Error> {
    let sum = Mat::from_fn(1, system.outputs(), |_, p| if rows.contains(&p) { 1.0 } else { 0.0 });
    Ok(StateSpace::new(system.A.clone(), system.B.clone(), &sum * &system.C, &sum * &system.D, system.time)?)
}

fn less(signals: &Signals, means: &[f64]) -> Signals {
    let data = Mat::from_fn(signals.channels(), signals.samples(), |r, t| signals.data[(r, t)] - means[r]);
    Signals { data, ..signals.clone() }
}
