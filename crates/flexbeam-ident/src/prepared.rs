//! A recording made ready: checked, moved by its delays, halved, scaled; and the way back.
//!
//! Enters: signals and options. Leaves: samples that estimate, read where they lie; the fit on the others; models in the recording's
//! units. Deliberately absent: the estimate itself.

use flexbeam_lti::{Signals, StateSpace, Time, Vector};

use crate::checks::{check, estimation_samples, expect_finite, expect_samples};
use crate::correlation::{Channels, Gram, gram_of};
use crate::estimation::{Estimate, Estimation};
use crate::hankel::factor::samples_needed;
use crate::samples::Samples;
use crate::scaling::{Scaling, rescaled};
use crate::validate::validate;
use crate::{Delay, Error, Innovations, Options, delay};

/// A recording and its scales.
pub(crate) struct Prepared<'a> {
    /// Delay of each input [samples].
    pub delays: Vec<usize>,
    /// Samples of the recording that belong to the estimating part; the longest delay takes the first ones.
    pub estimation_samples: usize,
    /// As recorded.
    recorded: Channels<'a>,
    /// Inputs moved.
    moved: Channels<'a>,
    /// Of the estimating samples.
    scaling: Scaling,
    /// H H' of the estimating samples about the means of `scaling`.
    gram: Gram,
    m: usize,
    threads: usize,
    time: Time,
}

impl<'a> Prepared<'a> {
    /// Errors: as [`crate::identify()`], all that can be known before the factor.
    pub fn new(inputs: &'a Signals, outputs: &'a Signals, options: &Options) -> Result<Prepared<'a>, Error> {
        check(inputs, outputs, options)?;
        if options.delay != Delay::Samples(0) {
            // Moved inputs leave some samples unseen.
            expect_finite(inputs, outputs)?;
        }
        let (m, l, i, threads) = (inputs.channels(), outputs.channels(), options.block_rows, options.threads());
        let recorded = Channels::of_rows(&inputs.data).beside(Channels::of_rows(&outputs.data));
        let all = estimation_samples(recorded.samples(), options)?;
        let delays = delays(&recorded.part(0..all), m, options)?;
        let moved = recorded.later(&delays);
        let s = all.saturating_sub(recorded.samples() - moved.samples());
        expect_samples("estimation", s, samples_needed(i, m, l), i)?;
        // Each sample is looked at once, and again only to say where the bad one is.
        let gram = gram_of(&moved.part(0..s), i, threads);
        let (Ok(gram), None) = (gram, moved.part(s..moved.samples()).not_finite()) else {
            return Err(expect_finite(inputs, outputs).expect_err("a sample that is not finite"));
        };
        // An integrator turns the mean taken from its input into a drift.
        let removes_mean = |c| options.remove_mean && (c >= m || options.integrators == 0);
        let (scaling, gram) = Scaling::of(gram, removes_mean);
        let time = Time::Sampled { period_s: inputs.period_s };
        Ok(Prepared { delays, estimation_samples: all, recorded, moved, scaling, gram, m, threads, time })
    }

    /// What estimates.
    pub fn estimating(&self, options: &Options) -> Estimation<'_> {
        let samples = self.samples(&self.moved, 0..self.count(), &self.scaling);
        Estimation::new(samples, &self.gram, self.time, options)
    }

    /// Fit of each output on the other samples; None when there are none.
    ///
    /// Errors: those of the simulation.
    pub fn unseen_fit_percent(&self, estimate: &Estimate) -> Result<Option<Vec<f64>>, Error> {
        let rest = self.count()..self.moved.samples();
        if rest.is_empty() {
            return Ok(None);
        }
        let scaling = self.shifted(estimate);
        self.samples(&self.moved, rest, &scaling).fit_percent(&estimate.model).map(Some)
    }

    /// Estimating samples, those that the longest delay takes apart.
    fn count(&self) -> usize {
        self.estimation_samples - (self.recorded.samples() - self.moved.samples())
    }

    fn samples<'b>(&self, of: &Channels<'b>, range: std::ops::Range<usize>, scaling: &'b Scaling) -> Samples<'b> {
        Samples { channels: of.part(range), scaling, m: self.m, threads: self.threads }
    }

    /// The scales with the estimated offsets among the means.
    fn shifted(&self, estimate: &Estimate) -> Scaling {
        let mut scaling = self.scaling.clone();
        scaling.shift(self.m, estimate.offset.as_slice());
        scaling
    }

    /// The model between the channels as recorded, delays carried as states: B / u, y C, y D / u with the channels' scales.
    ///
    /// Errors: shapes that do not fit, which is a bug of the caller.
    pub fn restored(&self, model: &StateSpace) -> Result<StateSpace, Error> {
        let (u, y) = self.scaling.scale.split_at(self.m);
        delay::carried(&rescaled(model, u, y)?, &self.delays)
    }

    /// The innovations of [`Prepared::restored`]'s model: delayed inputs are disturbed by nothing.
    pub fn restored_innovations(&self, found: Innovations) -> Innovations {
        found.unscaled(&self.scaling.scale[self.m..]).below(self.delays.iter().sum())
    }

    /// State of [`Prepared::restored`]'s model at the first sample of all, where delayed inputs were on their way already.
    ///
    /// Errors: shapes that do not fit, which is a bug of the caller.
    pub fn first_state(&self, restored: &StateSpace, estimate: &Estimate) -> Result<Vector, Error> {
        if self.delays.iter().all(|d| *d == 0) {
            return Ok(estimate.initial_state.clone());
        }
        let scaling = self.shifted(estimate);
        let ones = vec![1.0; self.m];
        let inverse: Vec<f64> = scaling.scale[self.m..].iter().map(|y| y.recip()).collect();
        let weighted = rescaled(restored, &ones, &inverse)?;
        let (mut U, Y) = self.samples(&self.recorded, 0..self.estimation_samples, &scaling).matrices();
        U.column_iter_mut().zip(&scaling.scale).for_each(|(mut u, scale)| u.scale_mut(*scale));
        Ok(validate(&weighted, &U.transpose(), &Y.transpose())?.initial_state)
    }

    /// What was taken from the inputs.
    pub fn input_means(&self) -> Vec<f64> {
        self.scaling.mean[..self.m].to_vec()
    }

    /// What was taken from the outputs, the estimated offsets with it.
    pub fn offsets(&self, estimate: &Estimate) -> Vec<f64> {
        self.shifted(estimate).mean[self.m..].to_vec()
    }
}

fn delays(estimating: &Channels, m: usize, options: &Options) -> Result<Vec<usize>, Error> {
    let (i, threads) = (options.block_rows, options.threads());
    match options.delay {
        Delay::Samples(d) => Ok(vec![d; m]),
        Delay::Auto => {
            expect_samples("estimation", estimating.samples(), samples_needed(i, m, estimating.count() - m), i)?;
            let gram = gram_of(estimating, i, threads).expect("finite samples");
            let (scaling, _) = Scaling::of(gram, |_| true);
            let (U, Y) = Samples { channels: estimating.clone(), scaling: &scaling, m, threads }.matrices();
            delay::estimated(&U, &Y, i)
        }
    }
}
