//! The projections of equation (13) and their weights, all from the triangular factor.
//!
//! Enters: [`Factor`]. Leaves: singular values and directions of the weighted projection, oblique projections in the
//! coordinates of Q. Deliberately absent: a matrix of width j.

use flexbeam_lti::Mat;

use crate::hankel::factor::Factor;
use crate::identify::Weighting;

/// A direction of the past that is weaker than this, relative to the strongest, is rounding: noise-free data make [U_p; Y_p]
/// singular, with about 1e-14 in place of zero.
const PAST_RANK: f64 = 1e-12;

/// Left part of the weighted projection's singular value decomposition, unweighted again: W1^-1 U.
pub(crate) struct Directions {
    /// All singular values, descending.
    pub singular_values: Vec<f64>,
    /// li x rank: column k belongs to singular value k.
    pub left: Mat,
}

/// W1 O_i W2 = U S V', equation (14), with W1^-1 U.
///
/// | weighting | W1 | W2 |
/// |---|---|---|
/// | N4SID | I | I |
/// | MOESP | I | projection orthogonal to U_f |
/// | CVA | (Y_f Pi Y_f')^(-1/2) | projection orthogonal to U_f |
///
/// Source: Van Overschee and De Moor 1996, table 4.1.
pub(crate) fn directions(factor: &Factor, weighting: Weighting) -> Directions {
    let (i, m, l) = (factor.i, factor.m, factor.l);
    let past = i * (m + l);
    let L32 = factor.L.view((i * m + past, i * m), (i * l, past));
    match weighting {
        Weighting::N4sid => left_directions(oblique(factor, i)),
        Weighting::Moesp => left_directions(L32.into_owned()),
        Weighting::Cva => {
            // [L32 L33] is Y_f orthogonal to U_f: its singular value decomposition is W1, and V1' the weighted projection.
            let Y_f = factor.L.view((i * m + past, i * m), (i * l, past + i * l)).into_owned();
            let (U, S, Vt) = singular(Y_f, true);
            let rank = S.iter().filter(|&&x| x > S[0] * PAST_RANK).count();
            let W1_inverse = Mat::from_fn(i * l, rank, |r, c| U[(r, c)] * S[c]);
            let correlated = left_directions(Vt.view((0, 0), (rank, past)).into_owned());
            Directions { left: W1_inverse * correlated.left, ..correlated }
        }
    }
}

/// O = Y_f /_{U_f} W_p in the coordinates of Q, with `past` block rows in W_p, equation (13).
///
/// Shapes: l(2i - past) x 2i(m + l). The paper's O_i has past = i, its O_{i-1} past = i + 1.
pub(crate) fn oblique(factor: &Factor, past: usize) -> Mat {
    let all = 2 * factor.i;
    let U_f = factor.inputs(past..all);
    let W_p = [factor.inputs(0..past), factor.outputs(0..past)].concat();
    let Y_f = factor.outputs(past..all);
    let rows = [U_f.clone(), W_p.clone(), Y_f.clone()].concat();
    let H = factor.L.select_rows(&rows);
    let L = H.transpose().qr().unpack_r().transpose();
    let (a, b) = (U_f.len(), W_p.len());
    let L22 = L.view((a, a), (b, b)).into_owned();
    let L32 = L.view((a + b, a), (Y_f.len(), b)).into_owned();
    over(&L32, L22) * factor.L.select_rows(&W_p)
}

/// K of least norm with K L22 = L32 in the range of L22.
fn over(L32: &Mat, L22: Mat) -> Mat {
    let (U, S, Vt) = singular(L22, true);
    let rank = S.iter().filter(|&&x| x > S[0] * PAST_RANK).count();
    let mut K = L32 * Vt.rows(0, rank).transpose();
    for c in 0..rank {
        K.column_mut(c).unscale_mut(S[c]);
    }
    K * U.columns(0, rank).transpose()
}

fn left_directions(M: Mat) -> Directions {
    // W2's rows are orthonormal coordinates: only the triangular factor of M' matters.
    let square = if M.ncols() > M.nrows() { M.transpose().qr().unpack_r().transpose() } else { M };
    let (left, S, _) = singular(square, false);
    Directions { singular_values: S, left }
}

/// U, singular values descending, V' (empty unless asked for).
fn singular(M: Mat, right: bool) -> (Mat, Vec<f64>, Mat) {
    let svd = M.svd(true, right);
    let U = svd.u.expect("asked for");
    let Vt = svd.v_t.unwrap_or_else(|| Mat::zeros(0, 0));
    (U, svd.singular_values.iter().copied().collect(), Vt)
}
