//! The full model: the smallest that leaves nothing in the recording that the input explains.

use flexbeam_lti::simulation::simulate;
use flexbeam_lti::{Mat, Signals, StateSpace};

use crate::spectrum::{Measured, Segments, circular_quantile, h1};
use crate::{Error, Identified, Options, Order, identify};

/// Orders that are tried, from the nominal plant's on: lightly damped modes come in pairs of states.
const ORDERS: [usize; 6] = [4, 6, 8, 10, 12, 14];

/// A recording contradicts its model when chance alone would show as much with less than this probability.
const CONTRADICTION: f64 = 0.01;

/// An order that leaves this many times what a smaller one left is not an improvement that went unnoticed.
const MORE: f64 = 1.5;

/// A model of the whole recording, and whether anything is left.
pub struct Full {
    /// Model, estimated from all samples.
    pub identified: Identified,
    /// Response of what the model leaves to the input: nothing but noise unless `contradicted`.
    pub left: Measured,
    /// Power of what the model leaves over the power of the outputs, summed over them.
    pub part_left: f64,
    /// Whether some of what is left answers to the input beyond chance: no order that was tried is enough.
    pub contradicted: bool,
}

/// The model of smallest order that the recording does not contradict. Where it contradicts all, the smallest that it does not
/// contradict a hundred times more strongly than the best one: no larger order says significantly more.
///
/// Among those that are all contradicted, only orders that are `alike` count, where there are any: a recording that rests on
/// friction is explained better and better by slow poles that no beam has.
///
/// An estimate that is not the best possible leaves its own error in the residuals, and that error answers to the input: a
/// contradiction may mean no more than that.
///
/// The residuals y - y_model are tested against the input at every frequency and output: with K independent pieces and m inputs
/// their multiple coherence exceeds g by chance with probability (1 - g)^(K - 1) for one input, and the smallest of all
/// these probabilities is compared with 1 % over their number (Bonferroni).
///
/// Assumes: one input, and an open loop.
/// Errors: those of [`identify`] when no order succeeds, and of [`h1`].
/// Source: Ljung 1999, section 16.6 (residual tests); Bendat and Piersol 2010, section 9.2.
pub fn full(
    inputs: &Signals,
    outputs: &Signals,
    options: &Options,
    alike: impl Fn(&StateSpace) -> bool,
) -> Result<Full, Error> {
    let mut tried: Vec<(f64, Full)> = Vec::new();
    let mut least_left = f64::INFINITY;
    let mut refused = None;
    for order in ORDERS {
        match tried_order(order, inputs, outputs, options) {
            // More states that leave more of the recording: an estimate that failed, whose wide residuals contradict nothing.
            Ok((_, found)) if found.part_left > MORE * least_left => {}
            Ok((chance, found)) if chance >= CONTRADICTION => return Ok(found),
            Ok((chance, found)) => {
                least_left = least_left.min(found.part_left);
                tried.push((chance, found));
            }
            Err(why) => {
                refused.get_or_insert(why);
            }
        }
    }
    let is_alike = |found: &Full| found.identified.continuous.as_ref().is_ok_and(&alike);
    if tried.iter().any(|(_, found)| is_alike(found)) {
        tried.retain(|(_, found)| is_alike(found));
    }
    let best = tried.iter().map(|(chance, _)| *chance).fold(0.0, f64::max);
    let near = tried.into_iter().find(|(chance, _)| *chance >= CONTRADICTION * best);
    near.map(|(_, found)| found).ok_or_else(|| refused.expect("an order was tried"))
}

fn tried_order(order: usize, inputs: &Signals, outputs: &Signals, options: &Options) -> Result<(f64, Full), Error> {
    let all = Options { order: Order::Fixed(order), estimate: 1.0, ..options.clone() };
    let identified = identify(inputs, outputs, &all)?;
    if let Err(why) = &identified.continuous {
        return Err(Error::Linear(why.clone()));
    }
    let residuals = residuals(inputs, outputs, &identified)?;
    let left = h1(inputs, &residuals, Segments::of_record(inputs.samples()))?;
    let chance = chance(&left, inputs.samples());
    let part = |p: usize| residuals.data.row(p).norm_squared() / outputs.data.row(p).norm_squared();
    let part_left = (0..outputs.channels()).map(part).sum();
    Ok((chance, Full { identified, left, part_left, contradicted: chance < CONTRADICTION }))
}

/// What the model's own answer leaves of the outputs.
fn residuals(inputs: &Signals, outputs: &Signals, identified: &Identified) -> Result<Signals, Error> {
    let less = |data: &Mat, means: &[f64]| Mat::from_fn(data.nrows(), data.ncols(), |r, t| data[(r, t)] - means[r]);
    let U = less(&inputs.data, &identified.input_means);
    let answer = simulate(&identified.model, &U, &identified.initial_state)?;
    let data = less(&outputs.data, &identified.output_means) - answer;
    Ok(Signals { data, ..outputs.clone() })
}

/// How likely chance alone shows a coherence as large as the largest.
fn chance(left: &Measured, samples: usize) -> f64 {
    let coherence = left.coherence.as_deref().unwrap_or(&[]);
    let free = Segments::of_record(samples).independent(samples) - 1.0;
    let all = coherence.iter().flatten();
    let count = all.clone().count() as f64;
    let largest = all.fold(0.0_f64, |most, g| most.max(*g));
    count * (1.0 - largest).powf(free)
}

/// What the model leaves of one output (a sum of rows), as measured on s = jw: |left| plus 95 %, at any frequency.
///
/// Between two frequencies the larger one holds, and beyond the ends the end's.
pub fn unexplained(left: &Measured, rows: &[usize]) -> impl Fn(f64) -> f64 + use<> {
    let quantile = circular_quantile(0.95);
    let at = |k: usize| {
        let G: flexbeam_lti::C64 = rows.iter().map(|r| left.G[k][(*r, 0)]).sum();
        let std: f64 = rows.iter().map(|r| left.std[k][(*r, 0)]).sum();
        G.norm() + quantile * std
    };
    let values: Vec<f64> = (0..left.G.len()).map(at).collect();
    let omega = left.omega_rad_s.clone();
    move |w: f64| {
        let k = omega.partition_point(|at| *at < w);
        let (before, after) = (k.saturating_sub(1), k.min(values.len() - 1));
        values[before.min(values.len() - 1)].max(values[after])
    }
}
