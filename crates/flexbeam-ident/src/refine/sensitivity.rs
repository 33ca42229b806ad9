//! What a predictor leaves of a recording, and how that answers to every entry of its matrices.
//!
//! Enters: predictor, its input, the output to be met. Leaves: second moments of the residuals; the triangular factor of the
//! weighted Jacobian in given directions. Deliberately absent: which directions, and how far to go in them.

use std::ops::ControlFlow;

use flexbeam_lti::{Mat, Vector};

use crate::triangle::{CHUNK_ROWS, Triangle};

/// x(k+1) = A x + B w, yhat = C x + D w, from x(0): one simulation for output error, one filter of [u; y] for prediction.
pub(crate) struct Predictor {
    pub A: Mat,
    pub B: Mat,
    pub C: Mat,
    pub D: Mat,
    pub initial_state: Vector,
}

/// Input of the predictor and output to be met, channels x samples.
pub(crate) struct Record {
    pub W: Mat,
    pub Y: Mat,
}

/// Asked between chunks of the record whether to go on.
pub(crate) type Ask<'a> = &'a mut dyn FnMut() -> ControlFlow<()>;

impl Predictor {
    /// Entries of [A B x(0); C D] that a Jacobian has columns for, row after row.
    pub fn entries(&self) -> usize {
        let (n, v, l) = self.sizes();
        n * (n + v + 1) + l * (n + v)
    }

    /// Place of an entry of [A B x(0)] among [`Predictor::entries`].
    pub fn state_entry(&self, row: usize, column: usize) -> usize {
        row * (self.A.nrows() + self.B.ncols() + 1) + column
    }

    /// Place of an entry of [C D].
    pub fn output_entry(&self, row: usize, column: usize) -> usize {
        let (n, v, _) = self.sizes();
        n * (n + v + 1) + row * (n + v) + column
    }

    fn sizes(&self) -> (usize, usize, usize) {
        (self.A.nrows(), self.B.ncols(), self.C.nrows())
    }
}

/// E E'/s, E the residuals; None when they overflow.
///
/// Numerics: (n + l)(n + v) products a sample, memory independent of s.
pub(crate) fn second_moment(predictor: &Predictor, record: &Record, ask: Ask) -> ControlFlow<(), Option<Mat>> {
    let l = predictor.C.nrows();
    let mut run = Run::new(predictor);
    let mut moment = Mat::zeros(l, l);
    let mut residual = vec![0.0; l];
    let samples = record.Y.ncols();
    for first in (0..samples).step_by(CHUNK_ROWS) {
        ask()?;
        for k in first..samples.min(first + CHUNK_ROWS) {
            run.residual(record, k, &mut residual);
            for (c, e) in residual.iter().enumerate() {
                moment.column_mut(c).iter_mut().zip(&residual).for_each(|(sum, f)| *sum += e * f);
            }
            run.advance();
        }
        if !moment.iter().all(|x| x.is_finite()) {
            return ControlFlow::Continue(None);
        }
    }
    ControlFlow::Continue(Some(moment / samples as f64))
}

/// Triangular factor of [weight J directions | weight e], J the derivatives of yhat by [`Predictor::entries`].
///
/// Shapes: weight l x l, `directions` d x entries (a direction a row); returns (d + 1) x (d + 1).
/// Numerics: exact derivatives. d yhat_p by (A)_rc is component r of the state of the dual system (A', C_p') driven by x_c, so
/// l (n + v + 1) simulations serve all entries: l n^2 (n + v + 1) products a sample, then d products an entry and l 2 d^2 in the factor.
/// Memory independent of s.
pub(crate) fn jacobian(
    predictor: &Predictor,
    record: &Record,
    weight: &Mat,
    directions: &Mat,
    ask: Ask,
) -> ControlFlow<(), Mat> {
    let (l, d) = (predictor.C.nrows(), directions.nrows());
    let mut run = Run::new(predictor);
    let mut dual = DualStates::new(predictor, weight);
    let mut triangle = Triangle::new(d + 1);
    let mut residual = vec![0.0; l];
    let samples = record.Y.ncols();
    for first in (0..samples).step_by(CHUNK_ROWS) {
        ask()?;
        let width = CHUNK_ROWS.min(samples - first);
        let mut by_entry = Mat::zeros(predictor.entries(), width * l);
        let mut left = Vector::zeros(width * l);
        for k in 0..width {
            run.residual(record, first + k, &mut residual);
            for p in 0..l {
                let row = k * l + p;
                dual.derivatives(p, run.driven(), by_entry.column_mut(row).as_mut_slice());
                left[row] = (0..l).map(|q| weight[(p, q)] * residual[q]).sum();
            }
            dual.advance(run.driven());
            run.advance();
        }
        let mut chunk = (directions * by_entry).transpose().insert_column(d, 0.0);
        chunk.set_column(d, &left);
        triangle.absorb(&mut chunk);
    }
    ControlFlow::Continue(triangle.R)
}

/// The predictor on its way through a record.
struct Run {
    /// [A B; C D], a row after another.
    rows: Vec<f64>,
    n: usize,
    /// [x; w].
    driven: Vec<f64>,
    /// [x(k+1); yhat].
    answer: Vec<f64>,
}

impl Run {
    fn new(predictor: &Predictor) -> Run {
        let (n, v, l) = predictor.sizes();
        let mut rows = Vec::with_capacity((n + l) * (n + v));
        for (left, right) in [(&predictor.A, &predictor.B), (&predictor.C, &predictor.D)] {
            for r in 0..left.nrows() {
                rows.extend(left.row(r).iter().chain(right.row(r).iter()));
            }
        }
        let mut driven = vec![0.0; n + v];
        driven[..n].copy_from_slice(predictor.initial_state.as_slice());
        Run { rows, n, driven, answer: vec![0.0; n + l] }
    }

    /// y - yhat of sample k; [`Run::driven`] is that sample's from then on.
    fn residual(&mut self, record: &Record, k: usize, residual: &mut [f64]) {
        let v = record.W.nrows();
        self.driven[self.n..].copy_from_slice(&record.W.as_slice()[k * v..(k + 1) * v]);
        for (row, answer) in self.rows.chunks_exact(self.driven.len()).zip(&mut self.answer) {
            *answer = row.iter().zip(&self.driven).map(|(a, x)| a * x).sum();
        }
        let l = residual.len();
        let y = &record.Y.as_slice()[k * l..(k + 1) * l];
        for p in 0..l {
            residual[p] = y[p] - self.answer[self.n + p];
        }
    }

    fn driven(&self) -> &[f64] {
        &self.driven
    }

    fn advance(&mut self) {
        self.driven[..self.n].copy_from_slice(&self.answer[..self.n]);
    }
}

/// For every weighted output p the states of (A', C_p'): at rest driven by each of [x; w], and undriven from C_p'.
struct DualStates {
    n: usize,
    lanes: usize,
    A: Mat,
    /// weight C, transposed: n x l.
    C_t: Mat,
    weight: Mat,
    /// l n lanes: output after output, component after component, a lane a drive.
    states: Vec<f64>,
    next: Vec<f64>,
}

impl DualStates {
    fn new(predictor: &Predictor, weight: &Mat) -> DualStates {
        let (n, v, l) = predictor.sizes();
        let lanes = n + v + 1;
        let C_t = (weight * &predictor.C).transpose();
        let mut states = vec![0.0; l * n * lanes];
        for (row, c) in states.chunks_exact_mut(lanes).zip(C_t.iter()) {
            row[lanes - 1] = *c;
        }
        DualStates { n, lanes, A: predictor.A.clone(), C_t, weight: weight.clone(), next: states.clone(), states }
    }

    /// Derivatives of weighted output p by [`Predictor::entries`].
    fn derivatives(&self, p: usize, driven: &[f64], by_entry: &mut [f64]) {
        let size = self.n * self.lanes;
        let (state, output) = by_entry.split_at_mut(size);
        state.copy_from_slice(&self.states[p * size..(p + 1) * size]);
        for (q, row) in output.chunks_exact_mut(driven.len()).enumerate() {
            let weight = self.weight[(p, q)];
            row.iter_mut().zip(driven).for_each(|(d, x)| *d = weight * x);
        }
    }

    fn advance(&mut self, driven: &[f64]) {
        let (n, lanes) = (self.n, self.lanes);
        for (p, (state, next)) in
            self.states.chunks_exact(n * lanes).zip(self.next.chunks_exact_mut(n * lanes)).enumerate()
        {
            for (r, row) in next.chunks_exact_mut(lanes).enumerate() {
                let c = self.C_t[(r, p)];
                row[lanes - 1] = 0.0;
                row.iter_mut().zip(driven).for_each(|(y, x)| *y = c * x);
                for (a, old) in self.A.column(r).iter().zip(state.chunks_exact(lanes)) {
                    row.iter_mut().zip(old).for_each(|(y, x)| *y += a * x);
                }
            }
        }
        std::mem::swap(&mut self.states, &mut self.next);
    }
}
