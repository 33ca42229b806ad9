//! The projections of equation (13) and their weights, all from the triangular factor.
//!
//! Enters: [`Factor`]. Leaves: singular values and directions of the weighted projection, oblique projections in the
//! coordinates of Q. Deliberately absent: a matrix of width j.

use flexbeam_lti::Mat;

use crate::hankel::factor::Factor;
use crate::identify::Weighting;
use crate::singular::{basic_solution, left_singular, pivoted};

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
        Weighting::N4sid => left_directions(&oblique(factor, i)),
        Weighting::Moesp => left_directions(&L32.into_owned()),
        Weighting::Cva => {
            // [L32 L33] is Y_f orthogonal to U_f. With its transpose Q R, R' is a root of Y_f Pi Y_f' and Q' = W1 [L32 L33].
            let Y_f = factor.L.view((i * m + past, i * m), (i * l, past + i * l));
            let (Q, R) = pivoted(&Y_f.transpose(), PAST_RANK);
            let correlated = left_directions(&Q.rows(0, past).transpose());
            Directions { left: R.transpose() * correlated.left, ..correlated }
        }
    }
}

fn left_directions(M: &Mat) -> Directions {
    let (singular_values, left) = left_singular(M);
    Directions { singular_values, left }
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
    // K L22 = L32, transposed.
    let K = basic_solution(&L22.transpose(), &L32.transpose(), PAST_RANK).transpose();
    K * factor.L.select_rows(&W_p)
}
