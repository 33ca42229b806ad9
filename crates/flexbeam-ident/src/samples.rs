//! Recorded inputs and outputs, read where they lie, less their means and over their scales.
//!
//! Enters: channels and their scaling. Leaves: B, D and x(0), fits, and copies only where an algorithm works on matrices.
//! Deliberately absent: A and C, which come from the triangular factor.

use flexbeam_lti::{Mat, StateSpace, Vector};

use crate::Error;
use crate::correlation::Channels;
use crate::identify::Feedthrough;
use crate::modal::{Free, ModalFit, Problem};
use crate::output_map::{InputMatrices, Unknowns, input_matrices};
use crate::scaling::Scaling;
use crate::validate::{fit_from_squares, validate};

/// Inputs, then outputs, of one stretch of a recording.
#[derive(Clone)]
pub(crate) struct Samples<'a> {
    pub channels: Channels<'a>,
    pub scaling: &'a Scaling,
    /// Inputs m.
    pub m: usize,
    /// Share the work; nothing depends on their number.
    pub threads: usize,
}

/// What is free, and the fit of each output in percent.
pub(crate) struct Fitted {
    pub found: InputMatrices,
    pub fit_percent: Vec<f64>,
}

impl<'a> Samples<'a> {
    /// B, D, x(0) and the outputs' offsets by least squares of the simulated output, and the fit.
    ///
    /// Errors: those of the simulation.
    pub fn input_matrices(&self, A: &Mat, C: &Mat, unknowns: Unknowns) -> Result<Fitted, Error> {
        let (n, m, l) = (A.nrows(), self.m, C.nrows());
        let free = Free { B: true, D: unknowns.feedthrough == Feedthrough::Free, offset: unknowns.offset };
        if let Some(fit) = self.problem(A, C, Mat::zeros(n, m), Mat::zeros(l, m)).solve(free) {
            debug_assert!(fit.offset.iter().all(|d| *d == 0.0), "no offset was asked for");
            let fit_percent = percent(&fit);
            let ModalFit { B, D, offset, initial_state, .. } = fit;
            return Ok(Fitted { found: InputMatrices { B, D, offset, initial_state }, fit_percent });
        }
        let (U, mut Y) = self.matrices();
        let found = input_matrices(A, C, &U, &Y, unknowns);
        let time = flexbeam_lti::Time::Sampled { period_s: 1.0 };
        let model = StateSpace::new(A.clone(), found.B.clone(), C.clone(), found.D.clone(), time)?;
        Y.column_iter_mut().zip(&found.offset).for_each(|(mut y, d)| y.add_scalar_mut(-d));
        let fit_percent = validate(&model, &U.transpose(), &Y.transpose())?.fit_percent;
        Ok(Fitted { found, fit_percent })
    }

    /// The samples of this range.
    pub fn part(&self, range: std::ops::Range<usize>) -> Samples<'a> {
        Samples { channels: self.channels.part(range), ..*self }
    }

    /// Fit of a model between the scaled channels, its initial state free.
    ///
    /// Errors: those of the simulation.
    pub fn fit_percent(&self, model: &StateSpace) -> Result<Vec<f64>, Error> {
        let free = Free { B: false, D: false, offset: false };
        if let Some(fit) = self.problem(&model.A, &model.C, model.B.clone(), model.D.clone()).solve(free) {
            return Ok(percent(&fit));
        }
        let (U, Y) = self.matrices();
        Ok(validate(model, &U.transpose(), &Y.transpose())?.fit_percent)
    }

    /// Scaled inputs and outputs, samples x channels.
    pub fn matrices(&self) -> (Mat, Mat) {
        let columns = |channels: std::ops::Range<usize>| {
            let mut data = Mat::zeros(self.channels.samples(), channels.len());
            for (c, mut column) in channels.zip(data.column_iter_mut()) {
                self.channels.copy(c, 0, self.scaling.mean[c], column.as_mut_slice());
                column.unscale_mut(self.scaling.scale[c]);
            }
            data
        };
        (columns(0..self.m), columns(self.m..self.channels.count()))
    }

    fn problem<'b>(&'b self, A: &'b Mat, C: &'b Mat, B: Mat, D: Mat) -> Problem<'b> {
        let offset = Vector::zeros(C.nrows());
        let Scaling { mean, scale } = self.scaling;
        Problem { A, C, B, D, offset, channels: self.channels.clone(), mean, scale, threads: self.threads }
    }
}

fn percent(fit: &ModalFit) -> Vec<f64> {
    fit.missed.iter().zip(&fit.moved).map(|(missed, moved)| fit_from_squares(*missed, *moved)).collect()
}
