//! Left singular vectors of a small matrix.
//!
//! Enters: a matrix of block-row size. Leaves: singular values, descending, and left singular vectors.
//! Deliberately absent: right singular vectors, which no step needs. nalgebra's own routine iterates for ever on some inputs.

use flexbeam_lti::Mat;

/// Columns whose cosine is below this are orthogonal to working precision (times the square root of their length).
const ORTHOGONAL: f64 = f64::EPSILON;
/// Jacobi converges quadratically: after a pivoted QR four to eight sweeps suffice, and the last ones rotate nothing.
const MOST_SWEEPS: usize = 40;

/// S and U of M = U S V'.
///
/// Returns as many as M has rows or columns, whichever is less; a vector that belongs to an exact zero is zero.
/// Numerics: pivoted QR of M', then one-sided Jacobi rotations: also the small singular values are good to working precision
/// of the triangular factor. O(n^3) a sweep, always ends.
/// Source: Hestenes 1958; Drmac and Veselic 2008 for the pivoted QR before it.
pub(crate) fn left_singular(M: &Mat) -> (Vec<f64>, Mat) {
    let (_, R, P) = M.transpose().col_piv_qr().unpack();
    // M' P = Q R, so M = (R P^-1)' Q': the columns of (R P^-1)' are what is left to be made orthogonal.
    let mut rows = R;
    P.inv_permute_columns(&mut rows);
    let mut X = rows.transpose();
    for _ in 0..MOST_SWEEPS {
        if !sweep(&mut X) {
            break;
        }
    }
    let mut order: Vec<(f64, usize)> = X.column_iter().map(|x| x.norm()).zip(0..).collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut U = Mat::zeros(X.nrows(), X.ncols());
    for (k, &(s, column)) in order.iter().enumerate() {
        if s > 0.0 {
            U.set_column(k, &(X.column(column) / s));
        }
    }
    (order.into_iter().map(|o| o.0).collect(), U)
}

/// Rotates every pair of columns onto right angles; false when all were orthogonal already.
fn sweep(X: &mut Mat) -> bool {
    let (rows, n) = X.shape();
    let threshold = ORTHOGONAL * (rows as f64).sqrt();
    let mut rotated = false;
    for p in 0..n {
        for q in p + 1..n {
            let (left, right) = X.as_mut_slice().split_at_mut(q * rows);
            let (x, y) = (&mut left[p * rows..(p + 1) * rows], &mut right[..rows]);
            let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
            for (a, b) in x.iter().zip(y.iter()) {
                (xx, yy, xy) = (xx + a * a, yy + b * b, xy + a * b);
            }
            if xy.abs() > threshold * (xx * yy).sqrt() {
                rotate(x, y, (yy - xx) / (2.0 * xy));
                rotated = true;
            }
        }
    }
    rotated
}

/// The rotation by less than 45 degrees whose cotangent of the doubled angle is `zeta`.
fn rotate(x: &mut [f64], y: &mut [f64], zeta: f64) {
    let t = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
    let c = 1.0 / t.hypot(1.0);
    let s = c * t;
    for (a, b) in x.iter_mut().zip(y.iter_mut()) {
        (*a, *b) = (c * *a - s * *b, s * *a + c * *b);
    }
}

/// A P = Q R with as many columns of Q as |R(k,k)| stand above `tolerance` |R(1,1)|; returns Q, and R P^-1.
///
/// Rows of R P^-1 are dropped with their columns of Q: what is left agrees with A to that tolerance.
pub(crate) fn pivoted(A: &Mat, tolerance: f64) -> (Mat, Mat) {
    let (Q, R, P) = A.clone().col_piv_qr().unpack();
    let floor = tolerance * R.get((0, 0)).map_or(0.0, |r| r.abs());
    let rank = (0..R.nrows().min(R.ncols())).take_while(|&k| R[(k, k)].abs() > floor).count();
    let mut rows = R.rows(0, rank).into_owned();
    P.inv_permute_columns(&mut rows);
    (Q.columns(0, rank).into_owned(), rows)
}

/// Number of columns of A that are independent to that tolerance.
pub(crate) fn rank(A: &Mat, tolerance: f64) -> usize {
    pivoted(A, tolerance).0.ncols()
}

/// X with A X = B in the range of A; combinations that A does not determine to that tolerance stay zero.
pub(crate) fn basic_solution(A: &Mat, B: &Mat, tolerance: f64) -> Mat {
    let (Q, R, P) = A.clone().col_piv_qr().unpack();
    let floor = tolerance * R.get((0, 0)).map_or(0.0, |r| r.abs());
    let rank = (0..R.nrows().min(R.ncols())).take_while(|&k| R[(k, k)].abs() > floor).count();
    let right = Q.columns(0, rank).transpose() * B;
    let head = R.view((0, 0), (rank, rank)).solve_upper_triangular(&right).expect("the diagonal stands above zero");
    let mut X = Mat::zeros(A.ncols(), B.ncols());
    X.rows_mut(0, rank).copy_from(&head);
    P.inv_permute_rows(&mut X);
    X
}

#[cfg(test)]
mod tests {
    use super::*;

    /// U S V' with V' implied: U' M must have orthogonal rows of lengths S.
    fn expect_singular(M: &Mat, tolerance: f64) -> Vec<f64> {
        let (S, U) = left_singular(M);
        let rows = U.transpose() * M;
        let gram = &rows * rows.transpose();
        let size = S[0] * S[0];
        for r in 0..S.len() {
            for c in 0..S.len() {
                let wanted = if r == c { S[r] * S[r] } else { 0.0 };
                assert!((gram[(r, c)] - wanted).abs() <= tolerance * size, "({r},{c})");
            }
        }
        assert!((&U * rows - M).norm() <= tolerance * M.norm(), "U U' M is not M");
        assert!(S.windows(2).all(|s| s[0] >= s[1]));
        S
    }

    #[test]
    fn wide_tall_and_deficient_matrices() {
        let smooth = |r: usize, c: usize| (((r + 1) * (r + 3 * c + 2)) as f64).sin();
        for (rows, columns) in [(5, 9), (9, 5), (1, 4), (4, 1), (12, 12)] {
            expect_singular(&Mat::from_fn(rows, columns, smooth), 1e-14);
        }
        let deficient = Mat::from_fn(8, 3, smooth) * Mat::from_fn(3, 10, smooth);
        let S = expect_singular(&deficient, 1e-14);
        assert!(S[2] > 0.01 * S[0] && S[3] < 1e-14 * S[0]);
    }

    /// Singular values of diag(1, 1e-6, 1e-12) Q keep their relative digits.
    #[test]
    fn graded_rows_keep_relative_accuracy() {
        let Q = Mat::from_fn(3, 3, |r, c| (((r + 1) * (c + 2)) as f64).cos()).qr().q();
        let graded = [1.0, 1e-6, 1e-12];
        let M = Mat::from_fn(3, 3, |r, c| graded[r] * Q[(r, c)]);
        let (S, _) = left_singular(&M);
        for (s, wanted) in S.iter().zip(graded) {
            assert!((s / wanted - 1.0).abs() < 1e-10, "{s:e} for {wanted:e}");
        }
    }

    #[test]
    fn basic_solution_solves_what_is_determined() {
        let A = Mat::from_fn(6, 4, |r, c| (((r + 1) * (c + 2)) as f64).sin());
        let twin = Mat::from_columns(&[A.column(0), A.column(1), A.column(2), A.column(0)]);
        let B = &twin * Mat::from_column_slice(4, 1, &[1.0, -2.0, 0.5, 3.0]);
        let X = basic_solution(&twin, &B, 1e-13);
        assert!((&twin * X - &B).norm() < 1e-13 * B.norm());
        assert_eq!(rank(&twin, 1e-13), 3);
        assert_eq!(rank(&Mat::zeros(3, 2), 1e-13), 0);
    }
}
