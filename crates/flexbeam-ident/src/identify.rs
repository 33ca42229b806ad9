//! Subspace identification from end to end: recording in, model out.

use flexbeam_lti::{Signals, StateSpace, Time, Vector, sampling};

use crate::correlation::{Channels, Gram, NotFinite, Record};
use crate::estimation::{Estimate, Estimation};
use crate::hankel::factor::samples_needed;
use crate::projection::directions;
use crate::samples::Samples;
use crate::scaling::Scaling;
use crate::validate::{Validation, validate};
use crate::{Error, candidate, subspace};

/// Weights of equation (14).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Weighting {
    /// W1 = I, W2 = I: the paper's oblique projection as it stands.
    N4sid,
    /// W1 = I, W2 the projection orthogonal to U_f.
    Moesp,
    /// W1 = (Y_f Pi Y_f')^(-1/2): the singular values are canonical correlations.
    Cva,
}

/// How the system matrices are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// CVA, MOESP and N4SID compete on the estimating samples; [`Identified::method`] tells which one was taken.
    #[default]
    Auto,
    /// Equations (13)-(17) to the letter: state sequences. Exact without noise only.
    Paper,
    /// N4SID weighting; A and C from the shift of Gamma, B, D and x(0) from the simulated output.
    N4sid,
    /// MOESP weighting; then as N4SID.
    Moesp,
    /// CVA weighting; then as N4SID.
    Cva,
}

impl Method {
    pub(crate) fn weighting(self) -> Weighting {
        match self {
            Method::Paper | Method::N4sid => Weighting::N4sid,
            Method::Auto | Method::Moesp => Weighting::Moesp,
            Method::Cva => Weighting::Cva,
        }
    }
}

/// Order of the model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// From the MOESP-weighted singular values: the place of their largest drop when that is 10^4 or more (data without
    /// noise), else the number above 2 omega times their median, omega after Gavish and Donoho 2014.
    #[default]
    Auto,
    /// This order.
    Fixed(usize),
}

/// D, the part of the input that the output shows at the same sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Feedthrough {
    /// Estimated.
    #[default]
    Free,
    /// Known to be zero.
    Zero,
}

/// Where the poles may lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Poles {
    /// Wherever the data put them.
    #[default]
    Free,
    /// Inside the unit circle, known integrators apart. Those that the data put outside come to rest at 1 - 1/s, s the
    /// estimating samples: the A of least misfit with a penalty on the offending directions alone.
    Stable,
}

/// Settings of [`identify`].
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Block rows i of (8), default 20. More see slower modes and cost i^2.
    pub block_rows: usize,
    /// Order n, default from the singular values.
    pub order: Order,
    /// Default [`Method::Auto`].
    pub method: Method,
    /// Part of the samples, from the first on, that estimates; the rest validates. Default 0.5; 1 leaves nothing to validate.
    pub estimate: f64,
    /// Remove the means of the estimating part from both parts, and estimate what is left of an offset on each output together with
    /// B, D and x(0): the mean of a finite record is not the rest position. Default false: a system that integrates turns the
    /// mean taken from its input into a drift, so a recording of the hub angle does better without. With known integrators the
    /// inputs keep their means.
    pub remove_mean: bool,
    /// Append a row of ones to the Hankel matrices: each Hankel row loses its own offset, which a drifting record likes. It
    /// acts on A and C only; B, D and x(0) see the offset that is left. Default false.
    pub constant_row: bool,
    /// Further block rows that compete with `block_rows` on the estimating samples, default none. Those that the record is too
    /// short for are left out.
    pub more_block_rows: Vec<usize>,
    /// Poles known to be exactly 1: a motor's angle has one. Default 0. D is zero then, and A = diag(1, .., A_s).
    pub integrators: usize,
    /// Default [`Feedthrough::Free`].
    pub feedthrough: Feedthrough,
    /// Default [`Poles::Free`].
    pub poles: Poles,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            block_rows: 20,
            order: Order::Auto,
            method: Method::Auto,
            estimate: 0.5,
            remove_mean: false,
            constant_row: false,
            more_block_rows: Vec::new(),
            integrators: 0,
            feedthrough: Feedthrough::Free,
            poles: Poles::Free,
        }
    }
}

/// An identified model and what it was judged by.
#[derive(Clone, Debug)]
pub struct Identified {
    /// Sampled model, in the recording's units, between the signals without their means.
    pub model: StateSpace,
    /// Exact inverse of the zero-order hold, or why there is none.
    pub continuous: Result<StateSpace, flexbeam_lti::Error>,
    /// State at the first sample.
    pub initial_state: Vector,
    /// Singular values of (14), descending; data scaled to unit rms.
    pub singular_values: Vec<f64>,
    /// Order n of the model.
    pub order: usize,
    /// Block rows i.
    pub block_rows: usize,
    /// The method whose weights were taken: never [`Method::Auto`].
    pub method: Method,
    /// Samples that estimated; the others validated.
    pub estimation_samples: usize,
    /// Fit of each output on the validating samples; None when there are none.
    pub fit_percent: Option<Vec<f64>>,
    /// Fit of each output on the estimating samples.
    pub estimation_fit_percent: Vec<f64>,
    /// Removed from the inputs; zeros unless asked for.
    pub input_means: Vec<f64>,
    /// Removed from the outputs, the means with the offsets that were estimated besides; zeros unless asked for.
    pub output_means: Vec<f64>,
}

/// Model of order n between recorded inputs and outputs, equations (7)-(17).
///
/// Assumes: all channels of both in step; the inputs excite.
/// Errors: [`Error::Length`], [`Error::Period`], [`Error::NoChannel`], [`Error::NotFinite`], [`Error::Setting`],
/// [`Error::TooFewSamples`], [`Error::NotExciting`], [`Error::Order`], [`Error::NoState`].
/// Numerics: channels are scaled to unit rms, so units do not matter; orthogonal transformations only; 8 i^2 (m + l)^2
/// operations a sample. Without noise, poles to about 1e-13.
/// Source: the paper, (7)-(17); DESIGN section 5 says where the default differs.
pub fn identify(inputs: &Signals, outputs: &Signals, options: &Options) -> Result<Identified, Error> {
    check(inputs, outputs, options)?;
    let (m, l, i) = (inputs.channels(), outputs.channels(), options.block_rows);
    let s = estimation_samples(inputs.samples(), options)?;
    expect_samples("estimation", s, samples_needed(i, m, l), i)?;
    let all = Channels::of_rows(&inputs.data).beside(Channels::of_rows(&outputs.data));
    let (estimating, rest) = (0..s, s..all.samples());
    let gram = gram_of_finite(&all, &estimating, i).map_err(|bad| not_finite(inputs, outputs, bad))?;
    // An integrator turns the mean taken from its input into a drift.
    let (mut scaling, gram) = Scaling::of(gram, |c| options.remove_mean && (c >= m || options.integrators == 0));
    let time = Time::Sampled { period_s: inputs.period_s };
    let samples = Samples { channels: all.part(estimating), scaling: &scaling, m };

    let (chosen, estimate) = estimated(&Estimation::new(samples, &gram, time, options), options)?; // (8)-(17)
    scaling.shift(m, estimate.offset.as_slice());
    let unseen = Samples { channels: all.part(rest.clone()), scaling: &scaling, m };
    let fit_percent = if rest.is_empty() { None } else { Some(unseen.fit_percent(&estimate.model)?) };
    let (input_scaling, output_scaling) = (scaling.part(0..m), scaling.part(m..m + l));
    let model = unscaled(&estimate.model, &input_scaling, &output_scaling)?;
    Ok(Identified {
        continuous: sampling::inverse_zoh(&model),
        order: model.order(),
        model,
        initial_state: estimate.initial_state,
        singular_values: chosen.singular_values,
        block_rows: chosen.block_rows,
        method: chosen.method,
        estimation_samples: s,
        fit_percent,
        estimation_fit_percent: estimate.fit_percent,
        input_means: input_scaling.mean,
        output_means: output_scaling.mean,
    })
}

fn estimated(samples: &Estimation, options: &Options) -> Result<(candidate::Candidate, Estimate), Error> {
    if options.method == Method::Paper {
        return printed(samples, options);
    }
    let chosen = candidate::best(samples, options)?;
    let estimate = samples.completed(chosen.A.clone(), chosen.C.clone())?;
    Ok((chosen, estimate))
}

/// Equations (13)-(17) as the paper prints them.
fn printed(samples: &Estimation, options: &Options) -> Result<(candidate::Candidate, Estimate), Error> {
    let factor = samples.factor(options.block_rows)?; // (8), (9)
    let (found, moesp) = (directions(&factor, Weighting::N4sid), directions(&factor, Weighting::Moesp)); // (13), (14)
    let n = candidate::chosen_order(&factor, &found, &moesp, 0, options)?;
    let [A, B, C, D] = subspace::state_sequences(&factor, &subspace::gamma(&found, n)).ok_or(Error::NoState)?; // (15)-(17)
    let model = StateSpace::new(A.clone(), B, C.clone(), D, samples.time)?;
    let (U, Y) = samples.samples.matrices();
    let found_again = validate(&model, &U.transpose(), &Y.transpose())?;
    let chosen = candidate::Candidate {
        method: Method::Paper,
        block_rows: factor.i,
        singular_values: found.singular_values,
        A,
        C,
    };
    let Validation { initial_state, fit_percent, .. } = found_again;
    Ok((chosen, Estimate { model, initial_state, offset: Vector::zeros(factor.l), fit_percent }))
}

/// H H' of the estimating samples; all samples are looked at, each once.
fn gram_of_finite(all: &Channels, estimating: &std::ops::Range<usize>, block_rows: usize) -> Result<Gram, NotFinite> {
    let mut record = Record::new(all.count(), block_rows);
    record.absorb(&all.part(estimating.clone()), 1)?;
    match all.part(estimating.end..all.samples()).not_finite() {
        Some(bad) => Err(NotFinite { sample: estimating.end + bad.sample, ..bad }),
        None => Ok(record.finish()),
    }
}

/// The model between the channels as recorded: B / u, y C, y D / u with the channels' scales.
fn unscaled(model: &StateSpace, inputs: &Scaling, outputs: &Scaling) -> Result<StateSpace, Error> {
    let StateSpace { A, mut B, mut C, mut D, time } = model.clone();
    for (c, u) in inputs.scale.iter().enumerate() {
        B.column_mut(c).unscale_mut(*u);
        D.column_mut(c).unscale_mut(*u);
    }
    for (p, y) in outputs.scale.iter().enumerate() {
        C.row_mut(p).scale_mut(*y);
        D.row_mut(p).scale_mut(*y);
    }
    Ok(StateSpace::new(A, B, C, D, time)?)
}

fn check(inputs: &Signals, outputs: &Signals, options: &Options) -> Result<(), Error> {
    let setting = |setting, found, needed| Err(Error::Setting { setting, found, needed });
    expect_together(inputs, outputs)?;
    if let Some(few) = [options.block_rows].iter().chain(&options.more_block_rows).find(|&&i| i < 2) {
        return setting("block_rows", *few as f64, "at least 2");
    }
    expect_structure(inputs.channels(), outputs.channels(), options)?;
    if !(options.estimate > 0.0 && options.estimate <= 1.0) {
        return setting("estimate", options.estimate, "more than 0 and at most 1");
    }
    Ok(())
}

/// Errors: an order without a state beside the integrators, more integrators than channels, structure that (13)-(17) do not know.
fn expect_structure(m: usize, l: usize, options: &Options) -> Result<(), Error> {
    let setting = |setting, found: usize, needed| Err(Error::Setting { setting, found: found as f64, needed });
    match options.order {
        Order::Fixed(0) => return setting("order", 0, "at least 1"),
        Order::Fixed(n) if n <= options.integrators => {
            return setting("order", n, "more than the known integrators");
        }
        _ => {}
    }
    if options.integrators > m.min(l) {
        return setting("integrators", options.integrators, "at most as many as inputs and as outputs");
    }
    let known = [
        (options.integrators > 0, "integrators"),
        (options.feedthrough == Feedthrough::Zero, "no feedthrough"),
        (options.poles == Poles::Stable, "stable poles"),
        (!options.more_block_rows.is_empty(), "several block rows"),
    ];
    match known.iter().find(|known| known.0 && options.method == Method::Paper) {
        Some((_, structure)) => Err(Error::Structure { structure }),
        None => Ok(()),
    }
}

/// Channels on both sides, recorded in step.
pub(crate) fn expect_together(inputs: &Signals, outputs: &Signals) -> Result<(), Error> {
    if inputs.channels() == 0 || outputs.channels() == 0 {
        return Err(Error::NoChannel { inputs: inputs.channels(), outputs: outputs.channels() });
    }
    if inputs.samples() != outputs.samples() {
        return Err(Error::Length { inputs: inputs.samples(), outputs: outputs.samples() });
    }
    let (input_s, output_s) = (inputs.period_s, outputs.period_s);
    let axes = [input_s, output_s].map(|period_s| Time::Sampled { period_s });
    if axes[0].common(axes[1]).is_err() {
        return Err(Error::Period { input_s, output_s });
    }
    Ok(())
}

/// All samples finite.
pub(crate) fn expect_finite(inputs: &Signals, outputs: &Signals) -> Result<(), Error> {
    let all = Channels::of_rows(&inputs.data).beside(Channels::of_rows(&outputs.data));
    all.not_finite().map_or(Ok(()), |bad| Err(not_finite(inputs, outputs, bad)))
}

fn not_finite(inputs: &Signals, outputs: &Signals, bad: NotFinite) -> Error {
    let m = inputs.channels();
    let (signals, row) = if bad.channel < m { (inputs, bad.channel) } else { (outputs, bad.channel - m) };
    let value = signals.data[(row, bad.sample)];
    Error::NotFinite { channel: signals.names[row].clone(), sample: bad.sample, value }
}

/// Whole samples of the estimating part.
fn estimation_samples(all: usize, options: &Options) -> Result<usize, Error> {
    let s = (all as f64 * options.estimate).floor() as usize;
    // The validating part must at least tell its initial state apart from the rest.
    if s < all {
        expect_samples("validation", all - s, 2 * options.block_rows, options.block_rows)?
    }
    Ok(s)
}

fn expect_samples(what: &'static str, found: usize, needed: usize, block_rows: usize) -> Result<(), Error> {
    if found < needed { Err(Error::TooFewSamples { what, found, needed, block_rows }) } else { Ok(()) }
}
