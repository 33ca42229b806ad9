//! Identification of recordings that are longer than memory, read once.
//!
//! Enters: chunks of samples, of any length, of one experiment or several. Leaves: a model, and afterwards its fit on samples that it has not seen.
//! Deliberately absent: files; B and D by the simulated output, which would have to see the samples a second time.

use flexbeam_lti::{Mat, StateSpace, Time, sampling};

use crate::candidate::chosen_order;
use crate::checks::{expect_order, expect_structure};
use crate::correlation::{Channels, Gram, NotFinite, Record};
use crate::hankel::factor::{Factor, samples_needed};
use crate::identify::{Feedthrough, Poles, Weighting};
use crate::innovations::innovations;
use crate::projection::directions;
use crate::scaling::{Scaling, rescaled};
use crate::validate::validate;
use crate::{Delay, Error, Identified, Method, Options, doubts, factor_map, subspace};

/// First samples of the first experiment that are kept to find its initial state, and for the fit of the estimation.
const KEPT_SAMPLES: usize = 1 << 16;

/// What is left of the samples: sums of their products, and a few thousand of them.
///
/// Numerics: a sample costs 2i (m + l)^2 products of integers. Sums do not depend on how the samples are cut into chunks, nor on threads, to the last bit; experiments and shards
/// add in double-double. Memory: 8 MB for each 100 rows 2i(m + l) squared, and 2^16 samples.
pub struct Accumulator {
    names: Vec<String>,
    /// Inputs m.
    m: usize,
    block_rows: usize,
    threads: usize,
    open: Record,
    closed: Gram,
    /// Samples taken before the open experiment.
    before: usize,
    /// channels x samples, the first of the first experiment.
    kept: Vec<f64>,
}

impl Accumulator {
    /// For recordings with these inputs and outputs.
    ///
    /// `threads` share the work; 0 takes as many as the machine has.
    /// Errors: [`Error::NoChannel`], [`Error::Setting`] for fewer than two block rows.
    pub fn new(inputs: &[String], outputs: &[String], block_rows: usize, threads: usize) -> Result<Accumulator, Error> {
        if inputs.is_empty() || outputs.is_empty() {
            return Err(Error::NoChannel { inputs: inputs.len(), outputs: outputs.len() });
        }
        let options = Options { block_rows, threads, ..Options::default() };
        expect_order(&options)?;
        let count = inputs.len() + outputs.len();
        Ok(Accumulator {
            names: [inputs, outputs].concat(),
            m: inputs.len(),
            block_rows,
            threads: options.threads(),
            open: Record::new(count, block_rows),
            closed: Record::new(count, block_rows).finish(),
            before: 0,
            kept: Vec::new(),
        })
    }

    /// Samples taken so far.
    pub fn samples(&self) -> usize {
        self.before + self.open.samples()
    }

    /// Continues the present experiment.
    ///
    /// Shapes: m x samples, l x samples.
    /// Errors: [`Error::Length`], [`Error::NotFinite`] with the sample counted from the first of all; the accumulator is of no more use then.
    pub fn absorb(&mut self, inputs: &Mat, outputs: &Mat) -> Result<(), Error> {
        if inputs.ncols() != outputs.ncols() {
            return Err(Error::Length { inputs: inputs.ncols(), outputs: outputs.ncols() });
        }
        assert_eq!(
            (inputs.nrows(), inputs.nrows() + outputs.nrows()),
            (self.m, self.names.len()),
            "channels of a chunk"
        );
        let channels = Channels::of_rows(inputs).beside(Channels::of_rows(outputs));
        let first = self.samples();
        self.open.absorb(&channels, self.threads).map_err(|NotFinite { channel, sample }| Error::NotFinite {
            channel: self.names[channel].clone(),
            sample: first + sample,
            value: channels.at(channel, sample),
        })?;
        if self.before == 0 {
            let wanted = (KEPT_SAMPLES - self.kept.len() / self.names.len()).min(channels.samples());
            let samples = (0..wanted).flat_map(|k| (0..channels.count()).map(move |c| (c, k)));
            self.kept.extend(samples.map(|(c, k)| channels.at(c, k)));
        }
        Ok(())
    }

    /// Closes the present experiment: what follows does not continue it.
    pub fn next_experiment(&mut self) {
        let record = std::mem::replace(&mut self.open, Record::new(self.names.len(), self.block_rows));
        self.before += record.samples();
        self.closed.add(&record.finish());
    }

    /// Adds what another one has seen: other experiments, or the shard of the same record that follows with 2i - 1 samples in common.
    ///
    /// The initial state stays that of the first. Shards count their common samples twice in the means, nowhere else.
    /// Assumes: the same channels and block rows.
    pub fn merge(&mut self, mut other: Accumulator) {
        self.next_experiment();
        other.next_experiment();
        self.closed.add(&other.closed);
        self.before += other.before;
    }

    /// The model, equations (7)-(17), with B and D from the triangular factor.
    ///
    /// Returns fits of the estimation over the samples that were kept, and none of the validation: see [`Validator`]. `options.estimate` has no meaning here.
    /// Errors: those of [`crate::identify()`]; [`Method::Paper`] is served, too.
    pub fn identify(mut self, period_s: f64, options: &Options) -> Result<Identified, Error> {
        let (m, c, i) = (self.m, self.names.len(), self.block_rows);
        expect_structure(m, c - m, options)?;
        expect_streamed(options)?;
        self.next_experiment();
        let needed = samples_needed(i, m, c - m);
        let found = self.closed.columns + 2 * i - 1;
        if found < needed {
            return Err(Error::TooFewSamples {
                what: "estimation",
                found: self.samples().min(found),
                needed,
                block_rows: i,
            });
        }
        let (scaling, gram) = Scaling::of(self.closed, |_| options.remove_mean);
        let factor = Factor::of_gram(&gram, m, &scaling.scale, options.constant_row); // (8), (9)
        factor.expect_exciting()?;
        let found = directions(&factor, options.method.weighting()); // (13), (14)
        let n = chosen_order(&factor, &found, &directions(&factor, Weighting::Moesp), 0, options)?;
        let gamma = subspace::gamma(&found, n); // (15)
        let time = Time::Sampled { period_s };
        let scaled = if options.method == Method::Paper {
            let [A, B, C, D] = subspace::state_sequences(&factor, &gamma).ok_or(Error::NoState)?; // (16), (17)
            StateSpace::new(A, B, C, D, time)?
        } else {
            let (A, C) = subspace::shift(&gamma, factor.l).ok_or(Error::NoState)?;
            let (B, D) = factor_map::input_matrices(&factor, &A, &C);
            StateSpace::new(A, B, C, D, time)?
        };
        let kept = Mat::from_column_slice(c, self.kept.len() / c, &self.kept);
        let kept = Mat::from_fn(c, kept.ncols(), |r, k| (kept[(r, k)] - scaling.mean[r]) / scaling.scale[r]);
        let first = validate(&scaled, &kept.rows(0, m).into_owned(), &kept.rows(m, c - m).into_owned())?;
        let model = rescaled(&scaled, &scaling.scale[..m], &scaling.scale[m..])?;
        let innovations = innovations(&factor, &scaled.A, &scaled.C, gram.columns);
        let method = if options.method == Method::Auto { Method::Moesp } else { options.method };
        Ok(Identified {
            continuous: sampling::inverse_zoh(&model),
            model,
            initial_state: first.initial_state,
            order: n,
            singular_order: n,
            singular_values: found.singular_values,
            block_rows: i,
            method,
            input_delay: vec![0; m],
            innovations: innovations.map(|found| found.unscaled(&scaling.scale[m..])),
            doubts: doubts::of_loop(&factor, options.feedthrough)?.into_iter().collect(),
            estimation_samples: gram.samples,
            fit_percent: None,
            estimation_fit_percent: first.fit_percent,
            input_means: scaling.mean[..m].to_vec(),
            output_means: scaling.mean[m..].to_vec(),
        })
    }
}

/// Errors: [`Error::Streamed`] for what needs the samples a second time.
fn expect_streamed(options: &Options) -> Result<(), Error> {
    let known = [
        (options.integrators > 0, "known integrators"),
        (options.feedthrough == Feedthrough::Zero, "a feedthrough known to be zero"),
        (options.poles == Poles::Stable, "stable poles"),
        (options.delay != Delay::Samples(0), "input delays"),
        (!options.more_block_rows.is_empty(), "several block rows"),
    ];
    known.iter().find(|known| known.0).map_or(Ok(()), |(_, structure)| Err(Error::Streamed { structure }))
}
