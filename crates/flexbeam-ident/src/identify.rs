//! Subspace identification from end to end: recording in, model out.

use flexbeam_lti::{Mat, Signals, StateSpace, Time, Vector, sampling};

use crate::correlation::{Channels, NotFinite, gram_of};
use crate::hankel::factor::{Factor, samples_needed};
use crate::projection::{Directions, directions};
use crate::samples::{Fitted, Samples};
use crate::scaling::Scaling;
use crate::validate::validate;
use crate::{Error, order, subspace};

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
    /// What does best on real recordings: [`Method::Moesp`].
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
    /// Remove the means of the estimating part from both parts. Default false: a system that integrates turns the mean taken
    /// from its input into a drift, so a recording of the hub angle does better without.
    pub remove_mean: bool,
    /// Append a row of ones to the Hankel matrices: each Hankel row loses its own offset, which a drifting record likes. It
    /// acts on A and C only; B, D and x(0) see the offset that is left. Default false.
    pub constant_row: bool,
    /// Threads that share the work; 0, the default, takes as many as the machine has. The model does not depend on their number.
    pub threads: usize,
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
            threads: 0,
        }
    }
}

impl Options {
    pub(crate) fn threads(&self) -> usize {
        match self.threads {
            0 => std::thread::available_parallelism().map_or(1, |threads| threads.get()),
            threads => threads,
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
    /// Samples that estimated; the others validated.
    pub estimation_samples: usize,
    /// Fit of each output on the validating samples; None when there are none.
    pub fit_percent: Option<Vec<f64>>,
    /// Fit of each output on the estimating samples.
    pub estimation_fit_percent: Vec<f64>,
    /// Removed from the inputs; zeros unless asked for.
    pub input_means: Vec<f64>,
    /// Removed from the outputs; zeros unless asked for.
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
    let threads = options.threads();
    let all = Channels::of_rows(&inputs.data).beside(Channels::of_rows(&outputs.data));
    let gram = gram_of(&all.part(0..s), i, threads).map_err(|bad| not_finite(inputs, outputs, bad))?;
    let rest = s..all.samples();
    if let Some(bad) = all.part(rest.clone()).not_finite() {
        return Err(not_finite(inputs, outputs, NotFinite { sample: s + bad.sample, ..bad }));
    }
    let (scaling, gram) = Scaling::of(gram, options.remove_mean);
    let samples = |range| Samples { channels: all.part(range), scaling: &scaling, m, threads };

    let factor = Factor::of_gram(&gram, m, &scaling.scale, options.constant_row); // (8), (9)
    factor.expect_exciting()?;
    let directions = directions(&factor, options.method.weighting()); // (13), (14)
    let n = chosen_order(&factor, &directions, options)?;
    let gamma = subspace::gamma(&directions, n); // (15)
    let time = Time::Sampled { period_s: inputs.period_s };
    let (scaled, initial_state, estimation_fit_percent) =
        system(&factor, &gamma, options.method, &samples(0..s), time)?; // (16), (17)
    let fit_percent = if rest.is_empty() { None } else { Some(samples(rest).fit_percent(&scaled)?) };
    let (input_scaling, output_scaling) = (scaling.part(0..m), scaling.part(m..m + l));
    let model = unscaled(&scaled, &input_scaling, &output_scaling)?;
    Ok(Identified {
        continuous: sampling::inverse_zoh(&model),
        model,
        initial_state,
        order: n,
        singular_values: directions.singular_values,
        block_rows: i,
        estimation_samples: s,
        fit_percent,
        estimation_fit_percent,
        input_means: input_scaling.mean,
        output_means: output_scaling.mean,
    })
}

fn system(
    factor: &Factor,
    gamma: &Mat,
    method: Method,
    samples: &Samples,
    time: Time,
) -> Result<(StateSpace, Vector, Vec<f64>), Error> {
    if method == Method::Paper {
        let [A, B, C, D] = subspace::state_sequences(factor, gamma).ok_or(Error::NoState)?;
        let model = StateSpace::new(A, B, C, D, time)?;
        let (U, Y) = samples.matrices();
        let validation = validate(&model, &U.transpose(), &Y.transpose())?;
        return Ok((model, validation.initial_state, validation.fit_percent));
    }
    let (A, C) = subspace::shift(gamma, factor.l).ok_or(Error::NoState)?;
    let Fitted { found, fit_percent } = samples.input_matrices(&A, &C)?;
    Ok((StateSpace::new(A, found.B, C, found.D, time)?, found.initial_state, fit_percent))
}

/// The model between the channels as recorded: B / u, y C, y D / u with the channels' scales.
pub(crate) fn unscaled(model: &StateSpace, inputs: &Scaling, outputs: &Scaling) -> Result<StateSpace, Error> {
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

pub(crate) fn chosen_order(factor: &Factor, directions: &Directions, options: &Options) -> Result<usize, Error> {
    let rank = order::rank(&directions.singular_values);
    if rank == 0 {
        return Err(Error::NoState);
    }
    let shift = factor.l * (factor.i - 1);
    let order = match options.order {
        Order::Auto => automatic_order(factor, directions, options.method).min(shift).min(rank),
        Order::Fixed(order) => order,
    };
    if order > shift {
        return Err(Error::Order { order, largest: shift, reason: "the shift of Gamma has l (i - 1) rows" });
    }
    if order > rank {
        return Err(Error::Order { order, largest: rank, reason: "only so many singular values stand above rounding" });
    }
    Ok(order)
}

/// Always from the MOESP weighting: canonical correlations of noise-free data are all one and have no floor.
fn automatic_order(factor: &Factor, found: &Directions, method: Method) -> usize {
    let aspect = factor.l as f64 / (factor.m + factor.l) as f64;
    match method.weighting() {
        Weighting::Moesp => order::automatic(&found.singular_values, aspect),
        _ => order::automatic(&directions(factor, Weighting::Moesp).singular_values, aspect),
    }
}

fn check(inputs: &Signals, outputs: &Signals, options: &Options) -> Result<(), Error> {
    let setting = |setting, found, needed| Err(Error::Setting { setting, found, needed });
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
    expect_structure(options)?;
    if !(options.estimate > 0.0 && options.estimate <= 1.0) {
        return setting("estimate", options.estimate, "more than 0 and at most 1");
    }
    Ok(())
}

fn not_finite(inputs: &Signals, outputs: &Signals, bad: NotFinite) -> Error {
    let m = inputs.channels();
    let (signals, row) = if bad.channel < m { (inputs, bad.channel) } else { (outputs, bad.channel - m) };
    let value = signals.data[(row, bad.sample)];
    Error::NotFinite { channel: signals.names[row].clone(), sample: bad.sample, value }
}

/// Errors: settings that have no meaning whatever the recording.
pub(crate) fn expect_structure(options: &Options) -> Result<(), Error> {
    let setting = |setting, found, needed| Err(Error::Setting { setting, found, needed });
    if options.block_rows < 2 {
        return setting("block_rows", options.block_rows as f64, "at least 2");
    }
    if options.order == Order::Fixed(0) {
        return setting("order", 0.0, "at least 1");
    }
    Ok(())
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
