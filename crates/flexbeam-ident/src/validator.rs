//! The fit of a model on samples that arrive in chunks and are not kept.
//!
//! Enters: a model, chunks. Leaves: the fit in percent, the initial state free. Deliberately absent: the simulated output.

use flexbeam_lti::{Mat, StateSpace, Vector};

use crate::Error;
use crate::singular::basic_solution;
use crate::triangle::{CHUNK_ROWS, Triangle};
use crate::validate::fit_from_squares;

/// What is left of x(0) below this moves nothing.
const FADED: f64 = 1e-40;
/// A direction of x(0) that the outputs show less than this is not determined.
const STATE_RANK: f64 = 1e-14;

/// y - yhat of the model from rest is a linear map of x(0), whose least squares a triangular factor holds.
///
/// Numerics: O((n + l)(n + m)) a sample; QR with n columns until the first state has faded.
pub struct Validator {
    model: StateSpace,
    input_means: Vec<f64>,
    output_means: Vec<f64>,
    /// State of the model that started from rest.
    x: Vector,
    /// C A^k.
    decay: Mat,
    faded: bool,
    /// Triangular factor of \[C_p A^k, y_p - yhat_p\] for each output p, and of all outputs together.
    each: Vec<Triangle>,
    all: Triangle,
    /// First sample of each output, and sums of what differs from it.
    first: Option<Vector>,
    sums: Vec<[f64; 2]>,
    samples: usize,
    /// Squares after x(0) has faded.
    rest: Vec<f64>,
}

impl Validator {
    /// Starts at the first sample that the model has not seen; `identified` brings the means that its signals lose.
    pub fn new(identified: &crate::Identified) -> Validator {
        let model = identified.model.clone();
        let (n, l) = (model.order(), model.outputs());
        Validator {
            input_means: identified.input_means.clone(),
            output_means: identified.output_means.clone(),
            x: Vector::zeros(n),
            decay: model.C.clone(),
            faded: false,
            each: (0..l).map(|_| Triangle::new(n + 1)).collect(),
            all: Triangle::new(n + 1),
            first: None,
            sums: vec![[0.0; 2]; l],
            samples: 0,
            rest: vec![0.0; l],
            model,
        }
    }

    /// Continues by a chunk.
    ///
    /// Shapes: m x samples, l x samples.
    /// Errors: [`Error::Length`].
    pub fn absorb(&mut self, inputs: &Mat, outputs: &Mat) -> Result<(), Error> {
        if inputs.ncols() != outputs.ncols() {
            return Err(Error::Length { inputs: inputs.ncols(), outputs: outputs.ncols() });
        }
        for first in (0..inputs.ncols()).step_by(CHUNK_ROWS) {
            let count = CHUNK_ROWS.min(inputs.ncols() - first);
            self.absorb_part(&inputs.columns(first, count).into_owned(), &outputs.columns(first, count).into_owned());
        }
        Ok(())
    }

    fn absorb_part(&mut self, inputs: &Mat, outputs: &Mat) {
        let (n, l, count) = (self.model.order(), self.model.outputs(), inputs.ncols());
        let mut chunks = vec![Mat::zeros(if self.faded { 0 } else { count }, n + 1); l];
        for k in 0..count {
            let u = Vector::from_fn(inputs.nrows(), |c, _| inputs[(c, k)] - self.input_means[c]);
            let y = Vector::from_fn(l, |p, _| outputs[(p, k)] - self.output_means[p]);
            let missed = &y - &self.model.C * &self.x - &self.model.D * &u;
            let moved = &y - &*self.first.get_or_insert_with(|| y.clone());
            for p in 0..l {
                self.sums[p] = [self.sums[p][0] + moved[p], self.sums[p][1] + moved[p] * moved[p]];
                if self.faded {
                    self.rest[p] += missed[p] * missed[p];
                } else {
                    chunks[p].view_mut((k, 0), (1, n)).copy_from(&self.decay.row(p));
                    chunks[p][(k, n)] = missed[p];
                }
            }
            if !self.faded {
                self.decay = &self.decay * &self.model.A;
            }
            self.x = &self.model.A * &self.x + &self.model.B * u;
        }
        self.samples += count;
        if !self.faded {
            for (triangle, chunk) in self.each.iter_mut().zip(&mut chunks) {
                self.all.absorb(&mut chunk.clone());
                triangle.absorb(chunk);
            }
            self.faded = self.decay.amax() < FADED;
        }
    }

    /// Samples seen.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// 100 (1 - |y - yhat| / |y - mean y|) of each output; negative infinity when the simulation overflows.
    pub fn fit_percent(&self) -> Vec<f64> {
        let n = self.model.order();
        let R = &self.all.R;
        if !R.iter().chain(self.x.iter()).all(|x| x.is_finite()) {
            return vec![f64::NEG_INFINITY; self.each.len()];
        }
        let x0 = basic_solution(&R.view((0, 0), (n, n)).into_owned(), &R.view((0, n), (n, 1)).into_owned(), STATE_RANK);
        let fit = |p: usize| {
            let R = &self.each[p].R;
            let missed = (R.column(n) - R.columns(0, n) * &x0).norm_squared() + self.rest[p];
            let [sum, square] = self.sums[p];
            fit_from_squares(missed, square - sum * sum / self.samples as f64)
        };
        (0..self.each.len()).map(fit).collect()
    }
}
