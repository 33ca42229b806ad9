//! The estimating samples and what is known of the system that they came from.
//!
//! Enters: scaled inputs and outputs, known structure. Leaves: the input that shapes the states, B, D, x(0) and offsets for
//! given A and C. Deliberately absent: the choice between estimates.

use flexbeam_lti::{Mat, StateSpace, Time, Vector, simulation};

use crate::hankel::factor::Factor;
use crate::identify::{Feedthrough, Poles};
use crate::output_map::{Unknowns, input_matrices};
use crate::{Error, Options, integrators, stable};

/// Scaled samples, samples x channels, and what is known of them.
pub(crate) struct Estimation {
    /// Inputs.
    pub U: Mat,
    /// Outputs.
    pub Y: Mat,
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
}

impl Estimation {
    /// Samples that estimate, and what `options` knows.
    pub fn new(U: Mat, Y: Mat, time: Time, options: &Options) -> Estimation {
        Estimation {
            U,
            Y,
            time,
            integrators: options.integrators,
            feedthrough: if options.integrators > 0 { Feedthrough::Zero } else { options.feedthrough },
            poles: options.poles,
            offset: options.remove_mean,
            constant_row: options.constant_row,
        }
    }

    /// The first `samples` of them.
    pub fn head(&self, samples: usize) -> Estimation {
        let first = |M: &Mat| M.rows(0, samples.min(M.nrows())).into_owned();
        Estimation { U: first(&self.U), Y: first(&self.Y), ..*self }
    }

    /// Triangular factor of the Hankel matrices (8): of the inputs, or of their running sums where integrators are known.
    ///
    /// Errors: [`Error::TooFewSamples`], [`Error::NotExciting`].
    pub fn factor(&self, block_rows: usize) -> Result<Factor, Error> {
        let factor = match self.integrators {
            0 => Factor::new(&self.U, &self.Y, block_rows, self.constant_row)?,
            // The sum starts anywhere: what is missing of it is an offset of every Hankel row.
            _ => Factor::new(&integrators::running_sum(&self.U), &self.Y, block_rows, true)?,
        };
        factor.expect_exciting()?;
        Ok(factor)
    }

    /// A and C of all states from those of the shift structure: integrators in front, other poles where they may lie.
    pub fn structured(&self, gamma: &Mat, A: Mat, C: Mat) -> (Mat, Mat) {
        let A = match self.poles {
            Poles::Free => A,
            Poles::Stable => stable::stable(gamma, self.Y.ncols(), A, self.U.nrows()),
        };
        if self.integrators == 0 { (A, C) } else { integrators::prepended(self, &A, &C) }
    }

    /// B, D, x(0) and the offsets by least squares on the simulated output (17').
    ///
    /// Errors: shapes that do not fit, which is a bug of the caller.
    pub fn completed(&self, A: Mat, C: Mat) -> Result<Estimate, Error> {
        let unknowns = Unknowns { feedthrough: self.feedthrough, offset: self.offset };
        let found = input_matrices(&A, &C, &self.U, &self.Y, unknowns);
        let model = StateSpace::new(A, found.B, C, found.D, self.time)?;
        Ok(Estimate { model, initial_state: found.initial_state, offset: found.offset })
    }

    /// y - yhat, samples x outputs, of the simulation; infinite where it overflows.
    ///
    /// Errors: those of the simulation.
    pub fn missed(&self, estimate: &Estimate) -> Result<Mat, Error> {
        let simulated = simulation::simulate(&estimate.model, &self.U.transpose(), &estimate.initial_state)?;
        Ok(Mat::from_fn(self.Y.nrows(), self.Y.ncols(), |k, p| self.Y[(k, p)] - estimate.offset[p] - simulated[(p, k)]))
    }
}
