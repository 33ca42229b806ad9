//! A recording made ready: checked, moved by its delays, halved, scaled; and the way back.
//!
//! Enters: signals and options. Leaves: scaled samples that estimate, fits on both halves, models in the recording's units.
//! Deliberately absent: the estimate itself.

use flexbeam_lti::{Mat, Signals, StateSpace, Time, Vector};

use crate::estimation::{Estimate, Estimation};
use crate::hankel::factor::samples_needed;
use crate::identify::{Feedthrough, Method, Order, Poles};
use crate::scaling::Scaling;
use crate::validate::validate;
use crate::{Delay, Error, Innovations, Options, delay};

/// A recording, scaled.
pub(crate) struct Prepared {
    /// What estimates.
    pub estimating: Estimation,
    /// Delay of each input [samples].
    pub delays: Vec<usize>,
    /// Samples of the recording that belong to the estimating part; the longest delay takes the first ones.
    pub estimation_samples: usize,
    /// All samples, scaled, inputs moved: samples x channels.
    U: Mat,
    Y: Mat,
    inputs: Scaling,
    outputs: Scaling,
    /// Estimating samples as recorded.
    recorded: (Mat, Mat),
}

impl Prepared {
    /// Errors: as [`crate::identify()`], all that can be known before the factor.
    pub fn new(inputs: &Signals, outputs: &Signals, options: &Options) -> Result<Prepared, Error> {
        check(inputs, outputs, options)?;
        let (U, Y) = (inputs.data.transpose(), outputs.data.transpose());
        let all = estimation_samples(U.nrows(), options)?;
        let delays = delays(&U, &Y, all, options)?;
        let longest = delays.iter().copied().max().unwrap_or(0);
        let recorded = (U.rows(0, all).into_owned(), Y.rows(0, all).into_owned());
        let s = all.saturating_sub(longest);
        let needed = samples_needed(options.block_rows, U.ncols(), Y.ncols());
        expect_samples("estimation", s, needed, options.block_rows)?;
        let (U, Y) = (delay::moved(&U, &delays), Y.rows(longest, Y.nrows() - longest).into_owned());
        let inputs_scaling = Scaling::of(&U.rows(0, s).into_owned(), options.remove_mean && options.integrators == 0);
        let outputs_scaling = Scaling::of(&Y.rows(0, s).into_owned(), options.remove_mean);
        let (U, Y) = (inputs_scaling.apply(&U), outputs_scaling.apply(&Y));
        let time = Time::Sampled { period_s: inputs.period_s };
        let estimating = Estimation::new(U.rows(0, s).into_owned(), Y.rows(0, s).into_owned(), time, options);
        let estimation_samples = all;
        let (inputs, outputs) = (inputs_scaling, outputs_scaling);
        Ok(Prepared { estimating, delays, estimation_samples, U, Y, inputs, outputs, recorded })
    }

    /// Fits of each output on the estimating and on the other samples; None when there are no others.
    ///
    /// Errors: those of the simulation.
    pub fn fits(&self, estimate: &Estimate) -> Result<(Vec<f64>, Option<Vec<f64>>), Error> {
        let s = self.estimating.U.nrows();
        let on = |first: usize, count: usize| -> Result<Vec<f64>, Error> {
            let mut Y = self.Y.rows(first, count).transpose();
            Y.row_iter_mut().zip(&estimate.offset).for_each(|(mut y, d)| y.add_scalar_mut(-d));
            Ok(validate(&estimate.model, &self.U.rows(first, count).transpose(), &Y)?.fit_percent)
        };
        let others = self.U.nrows() - s;
        Ok((on(0, s)?, if others > 0 { Some(on(s, others)?) } else { None }))
    }

    /// The model between the channels as recorded, delays carried as states: B / u, y C, y D / u with the channels' scales.
    ///
    /// Errors: shapes that do not fit, which is a bug of the caller.
    pub fn restored(&self, model: &StateSpace) -> Result<StateSpace, Error> {
        let StateSpace { A, mut B, mut C, mut D, time } = model.clone();
        for (c, u) in self.inputs.scale.iter().enumerate() {
            B.column_mut(c).unscale_mut(*u);
            D.column_mut(c).unscale_mut(*u);
        }
        for (p, y) in self.outputs.scale.iter().enumerate() {
            C.row_mut(p).scale_mut(*y);
            D.row_mut(p).scale_mut(*y);
        }
        delay::carried(&StateSpace::new(A, B, C, D, time)?, &self.delays)
    }

    /// The innovations of [`Prepared::restored`]'s model: delayed inputs are disturbed by nothing.
    pub fn restored_innovations(&self, found: Innovations) -> Innovations {
        found.unscaled(&self.outputs.scale).below(self.delays.iter().sum())
    }

    /// State of [`Prepared::restored`]'s model at the first sample of all, where delayed inputs were on their way already.
    ///
    /// Errors: shapes that do not fit, which is a bug of the caller.
    pub fn first_state(&self, restored: &StateSpace, estimate: &Estimate) -> Result<Vector, Error> {
        if self.delays.iter().all(|d| *d == 0) {
            return Ok(estimate.initial_state.clone());
        }
        let (mut weighted, (U, Y)) = (restored.clone(), &self.recorded);
        for (p, y) in self.outputs.scale.iter().enumerate() {
            weighted.C.row_mut(p).unscale_mut(*y);
            weighted.D.row_mut(p).unscale_mut(*y);
        }
        let mut Y = self.outputs.apply(Y).transpose();
        Y.row_iter_mut().zip(&estimate.offset).for_each(|(mut y, d)| y.add_scalar_mut(-d));
        let mut U = U.transpose();
        U.row_iter_mut().zip(&self.inputs.mean).for_each(|(mut u, mean)| u.add_scalar_mut(-mean));
        Ok(validate(&weighted, &U, &Y)?.initial_state)
    }

    /// What was taken from the inputs.
    pub fn input_means(&self) -> Vec<f64> {
        self.inputs.mean.clone()
    }

    /// What was taken from the outputs, the estimated offsets with it.
    pub fn offsets(&self, estimate: &Estimate) -> Vec<f64> {
        let scaled = self.outputs.scale.iter().zip(&estimate.offset).map(|(scale, d)| scale * d);
        self.outputs.mean.iter().zip(scaled).map(|(mean, d)| mean + d).collect()
    }
}

fn delays(U: &Mat, Y: &Mat, s: usize, options: &Options) -> Result<Vec<usize>, Error> {
    match options.delay {
        Delay::Samples(d) => Ok(vec![d; U.ncols()]),
        Delay::Auto => {
            let (m, l, i) = (U.ncols(), Y.ncols(), options.block_rows);
            expect_samples("estimation", s, samples_needed(i, m, l), i)?;
            let scaled = |M: &Mat| {
                let part = M.rows(0, s).into_owned();
                Scaling::of(&part, true).apply(&part)
            };
            delay::estimated(&scaled(U), &scaled(Y), i)
        }
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
    expect_finite(inputs)?;
    expect_finite(outputs)?;
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

fn expect_finite(signals: &Signals) -> Result<(), Error> {
    match signals.data.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(k) => {
            let (channel, sample) = (k % signals.channels(), k / signals.channels());
            let channel = signals.names[channel].clone();
            Err(Error::NotFinite { channel, sample, value: signals.data[k] })
        }
    }
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
