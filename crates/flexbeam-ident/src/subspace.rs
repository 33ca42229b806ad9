//! From the extended observability matrix or the state sequences to the system matrices.
//!
//! Enters: weighted directions, triangular factor, order. Leaves: A, C, or all of A, B, C, D by the paper's (15)-(17).
//! Deliberately absent: the choice of the order.

use flexbeam_lti::Mat;

use crate::hankel::factor::Factor;
use crate::projection::{Directions, oblique};
use crate::triangle::least_squares;

/// Gamma_i = W1^-1 U1 S1^{1/2}, li x n, equation (15).
pub(crate) fn gamma(directions: &Directions, n: usize) -> Mat {
    let mut gamma = directions.left.columns(0, n).into_owned();
    for k in 0..n {
        gamma.column_mut(k).scale_mut(directions.singular_values[k].sqrt());
    }
    gamma
}

/// A and C from the shift structure (12): Gamma without its first l rows is Gamma without its last l rows times A.
///
/// Returns None when Gamma without its last block row lacks rank n.
pub(crate) fn shift(gamma: &Mat, l: usize) -> Option<(Mat, Mat)> {
    let tall = gamma.nrows() - l;
    let A = least_squares(&gamma.rows(0, tall).into_owned(), &gamma.rows(l, tall).into_owned())?;
    Some((A, gamma.rows(0, l).into_owned()))
}

/// A, B, C, D by least squares on two state sequences, equations (16) and (17).
///
/// The sequences are coordinates in the orthonormal rows of Q, so (17)'s least squares over j columns is one over 2i(m + l).
/// Source: the paper, deterministic algorithm 2 of Van Overschee and De Moor 1996. Exact without noise only.
pub(crate) fn state_sequences(factor: &Factor, gamma: &Mat) -> Option<[Mat; 4]> {
    let (i, l, m, n) = (factor.i, factor.l, factor.m, gamma.ncols());
    let shorter = gamma.rows(0, (i - 1) * l).into_owned();
    let X_i = least_squares(gamma, &oblique(factor, i))?; // (16)
    let X_next = least_squares(&shorter, &oblique(factor, i + 1))?;
    let U_i = factor.L.select_rows(&factor.inputs(i..i + 1));
    let Y_i = factor.L.select_rows(&factor.outputs(i..i + 1));
    let left = stacked(&X_next, &Y_i).transpose();
    let right = stacked(&X_i, &U_i).transpose();
    let system = least_squares(&right, &left)?.transpose(); // (17)
    let block = |r: usize, c: usize, rows: usize, columns: usize| system.view((r, c), (rows, columns)).into_owned();
    Some([block(0, 0, n, n), block(0, n, n, m), block(n, 0, l, n), block(n, n, l, m)])
}

fn stacked(top: &Mat, bottom: &Mat) -> Mat {
    let mut both = Mat::zeros(top.nrows() + bottom.nrows(), top.ncols());
    both.rows_mut(0, top.nrows()).copy_from(top);
    both.rows_mut(top.nrows(), bottom.nrows()).copy_from(bottom);
    both
}
