//! Subspace identification from end to end: recording in, model out.

use flexbeam_lti::{Signals, StateSpace, Vector, sampling};

use crate::candidate::{Candidate, Chosen};
use crate::estimation::{Estimate, Estimation};
use crate::hankel::factor::Factor;
use crate::innovations::innovations;
use crate::prepared::Prepared;
use crate::projection::directions;
use crate::validate::{Validation, validate};
use crate::{Delay, Doubt, Error, Innovations, candidate, doubts, subspace};

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
    /// Whole samples that an input takes before anything answers; the model carries them as states with poles at 0. Default none.
    pub delay: Delay,
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
            more_block_rows: Vec::new(),
            integrators: 0,
            feedthrough: Feedthrough::Free,
            poles: Poles::Free,
            delay: Delay::Samples(0),
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
    /// The method whose weights were taken: never [`Method::Auto`].
    pub method: Method,
    /// Delay of each input [samples].
    pub input_delay: Vec<usize>,
    /// States that the singular values speak of: without known integrators and delays.
    pub singular_order: usize,
    /// Gain and covariance of the innovations form; None where rounding alone is left, as without noise.
    pub innovations: Option<Innovations>,
    /// What makes the recording doubtful.
    pub doubts: Vec<Doubt>,
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
/// Numerics: channels are scaled to unit rms, so units do not matter. The triangular factor comes from lagged correlations, exact or
/// provably as good, 2i (m + l)^2 products a sample; then O((2i (m + l))^3). Without noise, poles to about 1e-13.
/// Source: the paper, (7)-(17); DESIGN section 5 says where the default differs.
pub fn identify(inputs: &Signals, outputs: &Signals, options: &Options) -> Result<Identified, Error> {
    let prepared = Prepared::new(inputs, outputs, options)?;
    let samples = prepared.estimating(options);
    let (Chosen { candidate, factor }, estimate) = estimated(&samples, options)?; // (8)-(17)
    let (innovations, in_loop) = unexplained(&samples, factor, &estimate.model)?;
    let fit_percent = prepared.unseen_fit_percent(&estimate)?;
    let model = prepared.restored(&estimate.model)?;
    Ok(Identified {
        continuous: sampling::inverse_zoh(&model),
        order: model.order(),
        singular_order: estimate.model.order() - options.integrators,
        initial_state: prepared.first_state(&model, &estimate)?,
        model,
        singular_values: candidate.singular_values,
        block_rows: candidate.block_rows,
        method: candidate.method,
        innovations: innovations.map(|found| prepared.restored_innovations(found)),
        doubts: doubts(inputs, outputs, options, candidate.block_rows).into_iter().chain(in_loop).collect(),
        estimation_samples: prepared.estimation_samples,
        fit_percent,
        output_means: prepared.offsets(&estimate),
        estimation_fit_percent: estimate.fit_percent,
        input_means: prepared.input_means(),
        input_delay: prepared.delays,
    })
}

/// Of channels and horizon; an integrator's drift hides what moves within the horizon.
fn doubts(inputs: &Signals, outputs: &Signals, options: &Options, block_rows: usize) -> Vec<Doubt> {
    let slow = doubts::of_horizon(outputs, block_rows).filter(|_| options.integrators == 0);
    doubts::of_channels(inputs, outputs).into_iter().chain(slow).collect()
}

fn estimated(samples: &Estimation, options: &Options) -> Result<(Chosen, Estimate), Error> {
    if options.method == Method::Paper {
        return printed(samples, options);
    }
    let chosen = candidate::best(samples, options)?;
    let estimate = samples.completed(chosen.candidate.A.clone(), chosen.candidate.C.clone())?;
    Ok((chosen, estimate))
}

/// Equations (13)-(17) as the paper prints them.
fn printed(samples: &Estimation, options: &Options) -> Result<(Chosen, Estimate), Error> {
    let factor = samples.factor(options.block_rows)?; // (8), (9)
    let (found, moesp) = (directions(&factor, Weighting::N4sid), directions(&factor, Weighting::Moesp)); // (13), (14)
    let n = candidate::chosen_order(&factor, &found, &moesp, 0, options)?;
    let [A, B, C, D] = subspace::state_sequences(&factor, &subspace::gamma(&found, n)).ok_or(Error::NoState)?; // (15)-(17)
    let model = StateSpace::new(A.clone(), B, C.clone(), D, samples.time)?;
    let (U, Y) = samples.samples.matrices();
    let Validation { initial_state, fit_percent, .. } = validate(&model, &U.transpose(), &Y.transpose())?;
    let candidate =
        Candidate { method: Method::Paper, block_rows: factor.i, singular_values: found.singular_values, A, C };
    let offset = Vector::zeros(factor.l);
    Ok((Chosen { candidate, factor }, Estimate { model, initial_state, offset, fit_percent }))
}

/// Innovations, and whether there is feedback, both from the factor of the inputs as they are.
fn unexplained(
    samples: &Estimation,
    factor: Factor,
    model: &StateSpace,
) -> Result<(Option<Innovations>, Option<Doubt>), Error> {
    let factor = match samples.integrators {
        0 => factor,
        _ => samples.plain_factor(factor.i, true),
    };
    let columns = samples.count() - 2 * factor.i + 1;
    Ok((innovations(&factor, &model.A, &model.C, columns), doubts::of_loop(&factor, samples.feedthrough)?))
}
