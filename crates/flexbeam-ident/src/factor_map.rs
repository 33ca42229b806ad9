//! B and D from the triangular factor alone.
//!
//! Enters: the factor, A, C. Leaves: B and D. Deliberately absent: the samples, which a stream has let go by then; x(0), which the factor does not know.

use flexbeam_lti::Mat;

use crate::hankel::factor::Factor;
use crate::singular::basic_solution;
use crate::subspace::observability;
use crate::triangle::{CHUNK_ROWS, Triangle};

/// A combination of B and D that moves the outputs by less than this part of the strongest is not determined.
const UNKNOWN_RANK: f64 = 1e-14;

/// B and D that minimise |P (L_Y - H(B, D) L_U)|, P the projection orthogonal to Gamma = \[C; C A; ..\] of 2i block rows.
///
/// Y = Gamma X + H(B, D) U + noise for all 2i block rows, H lower block triangular with D on its diagonal and C A^(k-1) B in the k-th place below. Multiplied by the part of Q' that
/// spans the inputs it reads L_Y = Gamma X' + H L_U, the noise gone, because it does not follow the inputs; P takes out the states.
///
/// Shapes: A n x n, C l x n; returns n x m and l x m.
/// Numerics: QR of 4 i^2 l m rows and m (n + l) columns, a few rows at a time.
/// Source: Verhaegen and Dewilde 1992 (MOESP), with 2i block rows in place of i. Every window of 2i samples has a state of its own, so that slow modes are known less well than from
/// the simulated output: that is the price of reading the samples once.
pub(crate) fn input_matrices(factor: &Factor, A: &Mat, C: &Mat) -> (Mat, Mat) {
    let (m, l, n, windows) = (factor.m, factor.l, A.nrows(), 2 * factor.i);
    let gamma = observability(A, C, windows);
    let Q = gamma.clone().qr().q();
    let without_states = |M: &Mat| M - &Q * (Q.transpose() * M);
    let inputs = factor.L.select_rows(&factor.inputs(0..windows)).columns(0, windows * m).into_owned();
    let outputs = factor.L.select_rows(&factor.outputs(0..windows)).columns(0, windows * m).into_owned();
    let outputs = without_states(&outputs);
    // What entry (r, c) of [D; B] does to the outputs, before the inputs multiply it: block column k of H.
    let blocks: Vec<Mat> = (0..windows)
        .map(|k| {
            let mut block = Mat::zeros(windows * l, l + n);
            block.view_mut((k * l, 0), (l, l)).fill_with_identity();
            let below = (windows - k - 1) * l;
            block.view_mut(((k + 1) * l, l), (below, n)).copy_from(&gamma.rows(0, below));
            without_states(&block)
        })
        .collect();
    let unknowns = m * (l + n);
    let mut triangle = Triangle::new(unknowns + 1);
    let responses: Vec<Mat> = (0..windows * m).map(|column| response(&blocks, &inputs, m, column)).collect();
    for (column, response) in responses.iter().enumerate() {
        for first in (0..windows * l).step_by(CHUNK_ROWS) {
            let rows = CHUNK_ROWS.min(windows * l - first);
            let mut chunk = response.rows(first, rows).into_owned().insert_column(unknowns, 0.0);
            chunk.set_column(unknowns, &outputs.view((first, column), (rows, 1)).column(0));
            triangle.absorb(&mut chunk);
        }
    }
    let mut R = triangle.R.view((0, 0), (unknowns, unknowns)).into_owned();
    let lengths: Vec<f64> = R.column_iter().map(|c| if c.norm() > 0.0 { c.norm() } else { 1.0 }).collect();
    lengths.iter().enumerate().for_each(|(c, length)| R.column_mut(c).unscale_mut(*length));
    let found = basic_solution(&R, &triangle.R.view((0, unknowns), (unknowns, 1)).into_owned(), UNKNOWN_RANK);
    let all = Mat::from_fn(l + n, m, |r, c| found[c * (l + n) + r] / lengths[c * (l + n) + r]);
    (all.rows(l, n).into_owned(), all.rows(0, l).into_owned())
}

/// One column of P H L_U as a linear map of the entries of \[D; B\], input by input.
fn response(blocks: &[Mat], inputs: &Mat, m: usize, column: usize) -> Mat {
    let width = blocks[0].ncols();
    let mut found = Mat::zeros(blocks[0].nrows(), m * width);
    for c in 0..m {
        let mut part = found.columns_mut(c * width, width);
        for (k, block) in blocks.iter().enumerate() {
            let weight = inputs[(k * m + c, column)];
            if weight != 0.0 {
                part.zip_apply(block, |x, b| *x += weight * b);
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::white_gaussian;

    #[test]
    fn data_without_noise_give_b_and_d_exactly() {
        let mix = |r: usize, c: usize| (((r + 1) * (c + 2)) as f64).sin();
        #[rustfmt::skip]
        let A = Mat::from_row_slice(3, 3, &[
            1.0, 0.2, 0.0,
            0.0, 0.7, 0.5,
            0.0, -0.5, 0.7,
        ]);
        let (B, C, D) = (Mat::from_fn(3, 2, mix), Mat::from_fn(2, 3, |r, c| mix(c, r + 1)), Mat::from_fn(2, 2, mix));
        let s = 1000;
        let U = Mat::from_column_slice(s, 2, &white_gaussian(2 * s, 1.0, 9.0, 8));
        let mut Y = Mat::zeros(s, 2);
        let mut x = flexbeam_lti::Vector::from_column_slice(&[1.0, -2.0, 0.5]);
        for k in 0..s {
            let u = U.row(k).transpose();
            Y.set_row(k, &(&C * &x + &D * &u).transpose());
            x = &A * x + &B * u;
        }
        let (found, feedthrough) = input_matrices(&Factor::new(&U, &Y, 5, false), &A, &C);
        assert!((found - &B).norm() < 1e-10 && (feedthrough - &D).norm() < 1e-10);
    }
}
