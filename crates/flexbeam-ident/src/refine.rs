//! Refinement: from a good estimate to the best one, by the errors of simulation or of prediction.
//!
//! Enters: a sampled model, a recording, what is known. Leaves: a model of the same order that is never worse on that
//! recording, and why the descent ended. Deliberately absent: the choice of the order, validation.
//!
//! ```
//! use flexbeam_ident::refine::{Settings, refine};
//! use flexbeam_lti::{Mat, StateSpace, Time, Vector, simulation::simulate};
//!
//! let system = |pole: f64, gain: f64| {
//!     let one = |x: f64| Mat::from_element(1, 1, x);
//!     StateSpace::new(one(pole), one(gain), one(1.0), one(0.0), Time::Sampled { period_s: 1.0 })
//! };
//! let U = Mat::from_fn(1, 200, |_, k| ((k * k) as f64).sin());
//! let Y = simulate(&system(0.9, 2.0)?, &U, &Vector::zeros(1))?;
//! let refined = refine(&system(0.7, 1.0)?, &U, &Y, &Settings::default(), &mut |_| std::ops::ControlFlow::Continue(()))?;
//! assert!((refined.model.A[(0, 0)] - 0.9).abs() < 1e-10);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod balance;
mod block_form;
mod criterion;
mod descent;
mod identified;
mod local;
mod reseat;
mod sensitivity;
mod start;

use std::ops::ControlFlow;

use flexbeam_lti::{Mat, StateSpace, Vector};

use crate::scaling::{Scaling, rescaled};
use crate::{Error, Feedthrough, Poles};
pub use criterion::Criterion;
use criterion::Measure;
use descent::Descent;
pub use identified::refine_identified;
use local::{Point, Structure};

/// Which errors are made small.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Errors {
    /// Of the output simulated from the input alone: unbiased for any noise that has nothing to do with the input.
    #[default]
    Simulated,
    /// Of the output predicted one sample ahead, innovations form x(k+1) = A x + B u + K e: the least variance where the noise is
    /// the model's own, and what closed-loop recordings need. K as a first value; zero where there is none.
    Predicted(Option<Mat>),
}

/// Settings of [`refine`].
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Default [`Errors::Simulated`].
    pub errors: Errors,
    /// How several outputs count, default [`Criterion::Fit`].
    pub criterion: Criterion,
    /// Poles known to be exactly 1, default 0: those of the start that are nearest.
    pub integrators: usize,
    /// Default [`Feedthrough::Free`].
    pub feedthrough: Feedthrough,
    /// Default [`Poles::Free`].
    pub poles: Poles,
    /// An unknown constant stands on every output, default false. A mean that was removed is not the rest position.
    pub offset: bool,
    /// Linearisations at most, default 200: ten to thirty are usual.
    pub most_iterations: usize,
    /// Relative offset at which the descent has settled, default 1e-3: what is left to go is a thousandth of what the noise makes
    /// uncertain.
    pub tolerance: f64,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            errors: Errors::default(),
            criterion: Criterion::default(),
            integrators: 0,
            feedthrough: Feedthrough::default(),
            poles: Poles::default(),
            offset: false,
            most_iterations: 200,
            tolerance: 1e-3,
        }
    }
}

/// How far a refinement has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Linearisations done.
    pub iterations: usize,
    /// Part of the outputs that is missed, as in [`Refined`].
    pub missed: f64,
}

/// Why a refinement ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// What is left to go is far below what the noise makes uncertain.
    Settled,
    /// Nothing is missed but rounding.
    Rounding,
    /// No step, however short, lowers the cost: at the precision of the arithmetic, or at the edge of what is permitted.
    NoDescent,
    /// A dozen linearisations lowered the cost by less than 1e-5 of it: a flat valley, usually of a pole that the data do not
    /// tell.
    Slow,
    /// As many linearisations as were permitted.
    Iterations,
    /// Whoever watched asked for an end.
    Asked,
}

/// A refined model.
#[derive(Clone, Debug)]
pub struct Refined {
    /// Between the same signals as the start; integrators first, with eigenvalue 1 to the last bit.
    pub model: StateSpace,
    /// Innovations gain, n x l, where prediction was asked for.
    pub K: Option<Mat>,
    /// State at the first sample.
    pub initial_state: Vector,
    /// Constant on each output; zeros unless asked for.
    pub offset: Vector,
    /// Parameters that were free: those of the input-output behaviour, the offsets, and the initial state.
    pub parameters: usize,
    /// Linearisations used.
    pub iterations: usize,
    /// Part of the outputs that the start missed (of the simulation or of the prediction): 0 nothing, 1 as much as their means
    /// do; for one output 1 - fit/100. Infinite when the start overflows.
    pub missed_before: f64,
    /// Part that is still missed, never more than before.
    pub missed_after: f64,
    /// Why it ended.
    pub reason: Reason,
}

/// The model nearest to the recording among those that can be reached from `start` downhill.
///
/// Shapes: `start` sampled, U m x s, Y l x s, as for [`crate::validate::validate`].
/// Assumes: white noise for the standard theory; any noise for the promise never to be worse.
/// Returns: at least as small a cost as the start's, with the best initial state; where the start lacks what is known
/// (integrators, D = 0), as the start's with that put right and B, D refitted.
/// Errors: [`Error::Length`], [`Error::TooFewSamples`], [`Error::Setting`], [`Error::Order`], [`Error::Overflow`], [`Error::Linear`].
/// Numerics: Levenberg-Marquardt over n(m + l) + m l (+ n l) local coordinates and x(0), exact gradients, QR instead of normal
/// equations. A linearisation costs l (n^2 (n + m + 1) + d (entries + 2 d)) products a sample, d parameters; memory beyond the
/// signals does not depend on s.
/// Source: McKelvey, Helmersson and Ribarits 2004; Ljung 1999, sections 7.4 and 10.2; Van Overschee and De Moor for the start.
pub fn refine(
    start: &StateSpace,
    U: &Mat,
    Y: &Mat,
    settings: &Settings,
    watch: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Refined, Error> {
    start::check(start, U, Y, settings)?;
    let scaling = Scales::of(U, Y);
    let (U, Y) = (scaling.inputs.apply_rows(U), scaling.outputs.apply_rows(Y));
    let measure = Measure::new(settings.criterion, &Y);
    let candidates = start::candidates(&scaling.scaled(start)?, &U, &Y, settings)?;
    let record = start::record(U, Y, settings);
    let structure = Structure {
        integrators: settings.integrators,
        no_feedthrough: settings.feedthrough == Feedthrough::Zero,
        offset: settings.offset,
    };
    let descent = Descent { record: &record, measure: &measure, structure, settings };
    let best = start::best(&descent, candidates, scaling.gain(settings), watch)?;
    let missed_before = best.judged.missed;
    let end = descent.down(best, watch);
    let Point { A, B, C, D, K, initial_state } = end.standing.point;
    let (m, l) = (start.inputs(), start.outputs());
    let offset = if settings.offset { D.column(m).into_owned() } else { Vector::zeros(l) };
    let (B, D) = (B.columns(0, m).into_owned(), D.columns(0, m).into_owned());
    let model = scaling.unscaled(&StateSpace::new(A, B, C, D, start.time)?)?;
    Ok(Refined {
        model,
        K: K.map(|K| scaling.unscaled_gain(K)),
        initial_state,
        offset: offset.component_mul(&Vector::from_column_slice(&scaling.outputs.scale)),
        parameters: end.dimension,
        iterations: end.iterations,
        missed_before,
        missed_after: end.standing.judged.missed,
        reason: end.reason,
    })
}

/// Scales of the signals, without their means.
struct Scales {
    inputs: Scaling,
    outputs: Scaling,
}

impl Scales {
    fn of(U: &Mat, Y: &Mat) -> Scales {
        Scales { inputs: Scaling::of_rows(U), outputs: Scaling::of_rows(Y) }
    }

    fn scaled(&self, model: &StateSpace) -> Result<StateSpace, Error> {
        let over = |scale: &[f64]| scale.iter().map(|x| x.recip()).collect::<Vec<_>>();
        rescaled(model, &over(&self.inputs.scale), &over(&self.outputs.scale))
    }

    fn unscaled(&self, model: &StateSpace) -> Result<StateSpace, Error> {
        rescaled(model, &self.inputs.scale, &self.outputs.scale)
    }

    /// First value of the gain between scaled signals.
    fn gain(&self, settings: &Settings) -> Option<Option<Mat>> {
        match &settings.errors {
            Errors::Simulated => None,
            Errors::Predicted(K) => {
                Some(K.as_ref().map(|K| Mat::from_fn(K.nrows(), K.ncols(), |r, c| K[(r, c)] * self.outputs.scale[c])))
            }
        }
    }

    fn unscaled_gain(&self, K: Mat) -> Mat {
        Mat::from_fn(K.nrows(), K.ncols(), |r, c| K[(r, c)] / self.outputs.scale[c])
    }
}

#[cfg(test)]
mod tests;
