//! What the model leaves unexplained, as the steady predictor sees it.
//!
//! Enters: triangular factor, A, C. Leaves: the innovations gain K and the innovations' covariance.
//! Deliberately absent: an influence on A, B, C, D.

use flexbeam_lti::{Mat, discrete_riccati::predictor};

use crate::hankel::factor::Factor;
use crate::subspace::observability;
use crate::triangle::least_squares;

/// Part of the outputs' rms below which what is left is rounding, and predicts nothing.
const ROUNDING: f64 = 1e-10;
/// Part of the outputs' noise that also disturbs every state: a mode that nothing disturbs has no stable predictor.
const DISTURBANCE: f64 = 1e-8;

/// x(k+1) = A x + B u + K e, y = C x + D u + e.
#[derive(Clone, Debug, PartialEq)]
pub struct Innovations {
    /// Gain, n x l; A - K C is stable.
    pub K: Mat,
    /// Covariance of e, l x l, in the outputs' units.
    pub covariance: Mat,
}

/// K and the covariance of e from the residuals of the state sequences, by a Riccati equation.
///
/// Z_i, the orthogonal projection of Y_f on [W_p; U_f], is Gamma_i X_i plus something of U_f; so is Z_{i+1} of the sequence one
/// sample later. What A, C and U_f leave of [Gamma_{i-1}^+ Z_{i+1}; Y_i] has the covariance [Q S; S' R]. It is never negative, so a stable
/// predictor exists.
///
/// Shapes: the factor's data scaled as A and C are; `columns` of its Hankel matrices.
/// Returns None where nothing but rounding is left, or where A and C cannot be told apart by the outputs.
/// Numerics: the filter behind X_i has seen i samples only; K is biased where A - K C has not settled by then.
/// Source: Van Overschee and De Moor 1996, section 4.4.2 (robust algorithm 4.3), A and C given.
pub(crate) fn innovations(factor: &Factor, A: &Mat, C: &Mat, columns: usize) -> Option<Innovations> {
    let (i, l, n) = (factor.i, factor.l, A.nrows());
    let gamma = observability(A, C, i);
    let shorter = gamma.rows(0, (i - 1) * l).into_owned();
    let X_i = least_squares(&gamma, &projected(factor, i))?;
    let X_next = least_squares(&shorter, &projected(factor, i + 1))?;
    let Y_i = factor.L.select_rows(&factor.outputs(i..i + 1));
    let mut rest = Mat::zeros(n + l, X_i.ncols());
    rest.rows_mut(0, n).copy_from(&(X_next - A * &X_i));
    rest.rows_mut(n, l).copy_from(&(Y_i - C * &X_i));
    let U_f = factor.L.select_rows(&factor.inputs(i..2 * i)).transpose();
    let by_input = least_squares(&U_f, &rest.transpose())?;
    let rest = rest - (U_f * by_input).transpose();
    let joint = &rest * rest.transpose() / columns as f64;
    let block = |r: usize, c: usize, rows: usize, columns: usize| joint.view((r, c), (rows, columns)).into_owned();
    let R = block(n, n, l, l);
    if (0..l).any(|p| R[(p, p)] <= ROUNDING * ROUNDING) {
        return None;
    }
    let Q = block(0, 0, n, n);
    let floor = DISTURBANCE * Q.trace().max(R.trace());
    let Q = Q + Mat::identity(n, n) * floor;
    let found = predictor(A, C, &Q, &R, &block(0, n, n, l)).ok()?;
    Some(Innovations { K: found.K, covariance: found.innovation_covariance })
}

/// Outputs of the lags from `past` on, projected on all inputs and the outputs before: L's columns that belong to those.
fn projected(factor: &Factor, past: usize) -> Mat {
    let known = 2 * factor.i * factor.m + past * factor.l;
    let mut Z = factor.L.select_rows(&factor.outputs(past..2 * factor.i));
    Z.columns_mut(known, factor.L.ncols() - known).fill(0.0);
    Z
}

impl Innovations {
    /// Between outputs of these scales.
    pub(crate) fn unscaled(mut self, scale: &[f64]) -> Innovations {
        for (p, y) in scale.iter().enumerate() {
            self.K.column_mut(p).unscale_mut(*y);
            self.covariance.row_mut(p).scale_mut(*y);
            self.covariance.column_mut(p).scale_mut(*y);
        }
        self
    }

    /// For a model with this many further states, which hold inputs and are disturbed by nothing.
    pub(crate) fn below(mut self, states: usize) -> Innovations {
        let n = self.K.nrows();
        self.K = self.K.insert_rows(n, states, 0.0);
        self
    }
}
