//! The estimating samples and what is known of the system that they came from.
//!
//! Enters: inputs and outputs with their scales, known structure. Leaves: the input that shapes the states, B, D, x(0) and offsets for
//! given A and C. Deliberately absent: the choice between estimates.

use flexbeam_lti::{Mat, StateSpace, Time, Vector, simulation};

use crate::correlation::{Channels, Gram, gram_of};
use crate::hankel::factor::{Factor, samples_needed};
use crate::identify::{Feedthrough, Poles};
use crate::output_map::Unknowns;
use crate::samples::{Fitted, Samples};
use crate::{Error, Options, integrators, stable};

/// Samples, and what is known of them.
pub(crate) struct Estimation<'a> {
    /// Inputs and outputs.
    pub samples: Samples<'a>,
    /// Their H H' about the means of `samples`, for one number of block rows.
    pub gram: &'a Gram,
    /// Time axis of the model.
    pub time: Time,
    /// Poles known to be 1.
    pub integrators: usize,
    /// D.
    pub feedthrough: Feedthrough,
    /// Where the other poles may lie.
    pub poles: Poles,
    /// An unknown constant stands on every output.
    pub offset: bool,
    /// Hankel rows lose their own offsets.
    pub constant_row: bool,
}

/// A model of the scaled samples.
#[derive(Clone, Debug)]
pub(crate) struct Estimate {
    /// A, B, C, D.
    pub model: StateSpace,
    /// State at the first sample.
    pub initial_state: Vector,
    /// Constant on each output.
    pub offset: Vector,
    /// Fit of each output on the samples that estimated.
    pub fit_percent: Vec<f64>,
}

impl<'a> Estimation<'a> {
    /// Samples that estimate, and what `options` knows.
    pub fn new(samples: Samples<'a>, gram: &'a Gram, time: Time, options: &Options) -> Estimation<'a> {
        Estimation {
            samples,
            gram,
            time,
            integrators: options.integrators,
            feedthrough: if options.integrators > 0 { Feedthrough::Zero } else { options.feedthrough },
            poles: options.poles,
            offset: options.remove_mean,
            constant_row: options.constant_row,
        }
    }

    /// Samples.
    pub fn count(&self) -> usize {
        self.samples.channels.samples()
    }

    /// Outputs.
    pub fn outputs(&self) -> usize {
        self.samples.channels.count() - self.samples.m
    }

    /// Triangular factor of the Hankel matrices (8): of the inputs, or of their running sums where integrators are known.
    ///
    /// Errors: [`Error::TooFewSamples`], [`Error::NotExciting`].
    pub fn factor(&self, block_rows: usize) -> Result<Factor, Error> {
        let (m, l) = (self.samples.m, self.outputs());
        let needed = samples_needed(block_rows, m, l);
        if self.count() < needed {
            return Err(Error::TooFewSamples { what: "estimation", found: self.count(), needed, block_rows });
        }
        let factor = match self.integrators {
            0 => self.plain_factor(block_rows, self.constant_row),
            _ => self.summed_factor(block_rows),
        };
        factor.expect_exciting()?;
        Ok(factor)
    }

    /// Triangular factor of inputs and outputs as they are.
    pub fn plain_factor(&self, block_rows: usize, constant_row: bool) -> Factor {
        let Samples { channels, scaling, m, threads } = &self.samples;
        if self.gram.i == block_rows {
            return Factor::of_gram(self.gram, *m, &scaling.scale, constant_row);
        }
        let gram = gram_of(channels, block_rows, *threads).expect("finite samples").about(&scaling.mean);
        Factor::of_gram(&gram, *m, &scaling.scale, constant_row)
    }

    /// The sum starts anywhere: what is missing of it is an offset of every Hankel row.
    fn summed_factor(&self, block_rows: usize) -> Factor {
        let Samples { channels, scaling, m, threads } = &self.samples;
        let V = integrators::running_sum(&self.samples.matrices().0);
        let summed = Channels::of_columns(&V).beside(channels.from(*m));
        let summed = gram_of(&summed, block_rows, *threads).expect("finite samples");
        let scale: Vec<f64> = (0..*m).map(|_| 1.0).chain(scaling.scale[*m..].iter().copied()).collect();
        Factor::of_gram(&summed, *m, &scale, true)
    }

    /// A and C of all states from those of the shift structure: integrators in front, other poles where they may lie.
    pub fn structured(&self, gamma: &Mat, A: Mat, C: Mat) -> (Mat, Mat) {
        let A = match self.poles {
            Poles::Free => A,
            Poles::Stable => stable::stable(gamma, self.outputs(), A, self.count()),
        };
        if self.integrators == 0 { (A, C) } else { integrators::prepended(self, &A, &C) }
    }

    /// B, D, x(0) and the offsets by least squares on the simulated output (17').
    ///
    /// Errors: those of the simulation.
    pub fn completed(&self, A: Mat, C: Mat) -> Result<Estimate, Error> {
        self.completed_from(&self.samples, A, C)
    }

    /// Squared errors of the simulated output, summed over the outputs, of the first samples; A and C are completed on these alone.
    ///
    /// Errors: those of the simulation.
    pub fn squares(&self, samples: usize, A: &Mat, C: &Mat) -> Result<Vec<f64>, Error> {
        let head = self.samples.part(0..samples.min(self.count()));
        let estimate = self.completed_from(&head, A.clone(), C.clone())?;
        Ok(missed(&head, &estimate)?.row_iter().map(|e| e.norm_squared()).collect())
    }

    /// y - yhat, samples x outputs, of the simulation; infinite where it overflows.
    ///
    /// Errors: those of the simulation.
    pub fn missed(&self, estimate: &Estimate) -> Result<Mat, Error> {
        missed(&self.samples, estimate)
    }

    fn completed_from(&self, samples: &Samples, A: Mat, C: Mat) -> Result<Estimate, Error> {
        let unknowns = Unknowns { feedthrough: self.feedthrough, offset: self.offset };
        let Fitted { found, fit_percent } = samples.input_matrices(&A, &C, unknowns)?;
        let model = StateSpace::new(A, found.B, C, found.D, self.time)?;
        Ok(Estimate { model, initial_state: found.initial_state, offset: found.offset, fit_percent })
    }
}

fn missed(samples: &Samples, estimate: &Estimate) -> Result<Mat, Error> {
    let (U, Y) = samples.matrices();
    let simulated = simulation::simulate(&estimate.model, &U.transpose(), &estimate.initial_state)?;
    Ok(Mat::from_fn(Y.nrows(), Y.ncols(), |k, p| Y[(k, p)] - estimate.offset[p] - simulated[(p, k)]))
}
