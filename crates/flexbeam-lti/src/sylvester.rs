//! Linear matrix equations: Sylvester and Lyapunov, continuous and discrete.
//!
//! Enters: coefficient matrices. Leaves: the solution.
//! Deliberately absent: iterative methods for large sparse systems.

use crate::schur::{diagonal_blocks, eigenvalues, ordered_schur};
use crate::state_space::{expect_finite, expect_shape};
use crate::{C64, Error, Mat};

/// Sums of eigenvalues below this, relative to the matrices, count as zero: their solution would be rounding alone.
const SINGULAR: f64 = f64::EPSILON;

/// Solution of  A X + X B = C.
///
/// Shapes: A n x n, B m x m, C n x m; returns X n x m.
/// Errors: [`Error::Shape`], [`Error::NotFinite`], [`Error::NotConverged`]; [`Error::SharedEigenvalue`] when A and -B have one in common.
/// Numerics: O(n^3 + m^3), backward stable; the error grows with 1/min |lambda(A) + lambda(B)|.
/// Source: Bartels and Stewart 1972.
pub fn sylvester(A: &Mat, B: &Mat, C: &Mat) -> Result<Mat, Error> {
    expect_shape("C of A X + X B = C", C, A.nrows(), B.nrows())?;
    expect_finite("C", C)?;
    let U = ordered_schur(A, |_| false)?;
    let V = ordered_schur(B, |_| false)?;
    expect_apart(&eigenvalues(&U.T), &eigenvalues(&V.T), U.T.norm() + V.T.norm())?;
    let Y = triangular_sylvester(&U.T, &V.T, U.Q.tr_mul(C) * &V.Q)?;
    Ok(&U.Q * Y * V.Q.transpose())
}

/// Solution of  A X + X A' + Q = 0.
///
/// Shapes: all n x n. Returns X, exactly symmetric when Q is.
/// Errors: as [`sylvester`]; A must have no two eigenvalues with sum zero.
pub fn lyapunov(A: &Mat, Q: &Mat) -> Result<Mat, Error> {
    let X = sylvester(A, &A.transpose(), &-Q)?;
    Ok(if *Q == Q.transpose() { symmetric_part(&X) } else { X })
}

/// Solution of  A X A' - X + Q = 0.
///
/// Shapes: all n x n. Returns X, exactly symmetric when Q is.
/// Errors: as [`sylvester`]; A must have no two eigenvalues with product one.
/// Source: Kitagawa 1977: the Schur form of A, block columns from the last to the first.
pub fn discrete_lyapunov(A: &Mat, Q: &Mat) -> Result<Mat, Error> {
    expect_shape("Q of A X A' - X + Q = 0", Q, A.nrows(), A.nrows())?;
    expect_finite("Q", Q)?;
    let S = ordered_schur(A, |_| false)?;
    expect_no_reciprocals(&eigenvalues(&S.T))?;
    let Y = triangular_stein(&S.T, S.Q.tr_mul(Q) * &S.Q)?;
    let X = &S.Q * Y * S.Q.transpose();
    Ok(if *Q == Q.transpose() { symmetric_part(&X) } else { X })
}

pub(crate) fn symmetric_part(X: &Mat) -> Mat {
    (X + X.transpose()) * 0.5
}

fn expect_apart(alpha: &[C64], beta: &[C64], size: f64) -> Result<(), Error> {
    for a in alpha {
        if beta.iter().any(|b| (a + b).norm() <= SINGULAR * size) {
            return Err(Error::SharedEigenvalue { re: a.re, im: a.im });
        }
    }
    Ok(())
}

fn expect_no_reciprocals(z: &[C64]) -> Result<(), Error> {
    for a in z {
        if z.iter().any(|b| (a * b - 1.0).norm() <= SINGULAR * (1.0 + (a * b).norm())) {
            return Err(Error::SharedEigenvalue { re: a.re, im: a.im });
        }
    }
    Ok(())
}

/// T Y + Y S = F for quasi-triangular T and S, blocks from the lower left.
pub(crate) fn triangular_sylvester(T: &Mat, S: &Mat, F: Mat) -> Result<Mat, Error> {
    let mut Y = F;
    for (j, q) in diagonal_blocks(S) {
        let known = Y.columns(0, j) * S.view((0, j), (j, q));
        let mut column = Y.columns(j, q) - known;
        for (i, p) in diagonal_blocks(T).rev() {
            let below = i + p;
            let known = T.view((i, below), (p, T.nrows() - below)) * column.rows(below, T.nrows() - below);
            let rest = column.rows(i, p) - known;
            let operator = left_and_right(T.view((i, i), (p, p)).into_owned(), S.view((j, j), (q, q)).into_owned());
            column.rows_mut(i, p).copy_from(&small_solution(operator, rest, T[(i, i)])?);
        }
        Y.columns_mut(j, q).copy_from(&column);
    }
    Ok(Y)
}

/// T Y T' - Y + F = 0 for quasi-triangular T, blocks from the lower right.
fn triangular_stein(T: &Mat, F: Mat) -> Result<Mat, Error> {
    let n = T.nrows();
    let mut Y = F;
    for (j, q) in diagonal_blocks(T).rev() {
        let right = n - j - q;
        let later = Y.columns(j + q, right) * T.view((j, j + q), (q, right)).transpose();
        let mut column = Y.columns(j, q) + T * later;
        let S = T.view((j, j), (q, q)).into_owned();
        for (i, p) in diagonal_blocks(T).rev() {
            let below = n - i - p;
            let known = T.view((i, i + p), (p, below)) * column.rows(i + p, below) * S.transpose();
            let rest = column.rows(i, p) + known;
            let operator = Mat::identity(p * q, p * q) - S.kronecker(&T.view((i, i), (p, p)));
            column.rows_mut(i, p).copy_from(&small_solution(operator, rest, T[(i, i)])?);
        }
        Y.columns_mut(j, q).copy_from(&column);
    }
    Ok(Y)
}

/// X -> T X + X S on stacked columns.
fn left_and_right(T: Mat, S: Mat) -> Mat {
    Mat::identity(S.nrows(), S.nrows()).kronecker(&T) + S.transpose().kronecker(&Mat::identity(T.nrows(), T.nrows()))
}

/// Solves one to four equations; `near` names the eigenvalue when they are singular.
fn small_solution(operator: Mat, rest: Mat, near: f64) -> Result<Mat, Error> {
    let (p, q) = rest.shape();
    let stacked = rest.reshape_generic(nalgebra::Dyn(p * q), nalgebra::Dyn(1));
    let singular = Error::SharedEigenvalue { re: near, im: 0.0 };
    let x = if p * q == 1 { Some(&stacked / operator[0]) } else { operator.full_piv_lu().solve(&stacked) };
    let x = x.filter(|x| x.iter().all(|x| x.is_finite())).ok_or(singular)?;
    Ok(x.reshape_generic(nalgebra::Dyn(p), nalgebra::Dyn(q)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Draw;

    fn relative(residual: &Mat, A: &Mat, X: &Mat) -> f64 {
        residual.norm() / ((1.0 + A.norm()) * (X.norm() + f64::MIN_POSITIVE))
    }

    #[test]
    fn sylvester_leaves_a_small_residual() {
        let mut draw = Draw(11);
        for (n, m) in [(0, 0), (0, 3), (1, 1), (2, 1), (1, 3), (4, 5), (20, 9), (50, 50)] {
            let (A, B, C) = (draw.matrix(n, n), draw.matrix(m, m), draw.matrix(n, m));
            let X = sylvester(&A, &B, &C).unwrap();
            let residual = &A * &X + &X * &B - &C;
            assert!(residual.norm() <= 1e-14 * (A.norm() + B.norm()) * X.norm(), "{n} {m}");
        }
    }

    #[test]
    fn lyapunov_is_symmetric_positive_and_agrees_with_the_kronecker_product() {
        let mut draw = Draw(12);
        for n in [0, 1, 2, 3, 5, 8, 50] {
            let A = draw.stable(n, 0.1);
            let B = draw.matrix(n, 2);
            let Q = &B * B.transpose();
            let X = lyapunov(&A, &Q).unwrap();
            assert_eq!(X, X.transpose());
            assert!(relative(&(&A * &X + &X * A.transpose() + &Q), &A, &X) < 1e-14, "{n}");
            if n > 0 && n <= 8 {
                let I = Mat::identity(n, n);
                let K = I.kronecker(&A) + A.kronecker(&I);
                let x = K.lu().solve(&-Mat::from_column_slice(n * n, 1, Q.as_slice())).unwrap();
                assert!((Mat::from_column_slice(n, n, x.as_slice()) - &X).norm() < 1e-11 * X.norm());
            }
        }
    }

    #[test]
    fn discrete_lyapunov_leaves_a_small_residual() {
        let mut draw = Draw(13);
        for n in [0, 1, 2, 3, 4, 7, 20, 50] {
            let A = draw.matrix(n, n) * (0.9 / (n as f64).sqrt());
            let Q = draw.matrix(n, n);
            let X = discrete_lyapunov(&A, &Q).unwrap();
            assert!(relative(&(&A * &X * A.transpose() - &X + &Q), &A, &X) < 1e-14, "{n}");
        }
    }

    #[test]
    fn lightly_damped_and_badly_scaled() {
        let omega: f64 = 1e6;
        for zeta in [1e-4, 1e-8] {
            let A = Mat::from_row_slice(2, 2, &[0.0, 1.0, -omega * omega, -2.0 * zeta * omega]);
            let Q = Mat::from_row_slice(2, 2, &[0.0, 0.0, 0.0, 1.0]);
            let X = lyapunov(&A, &Q).unwrap();
            // Closed form: X22 = 1/(4 zeta omega), X11 = X22/omega^2. Entries 12 decades apart.
            let velocity = 0.25 / (zeta * omega);
            assert!((X[(1, 1)] / velocity - 1.0).abs() < 1e-7, "{}", X[(1, 1)] / velocity);
        }
    }

    #[test]
    fn shared_eigenvalues_are_named() {
        let A = Mat::from_row_slice(2, 2, &[0.0, 3.0, -3.0, 0.0]);
        assert!(matches!(lyapunov(&A, &Mat::identity(2, 2)), Err(Error::SharedEigenvalue { .. })));
        let A = Mat::from_row_slice(2, 2, &[2.0, 1.0, 0.0, 0.5]);
        assert!(matches!(discrete_lyapunov(&A, &Mat::identity(2, 2)), Err(Error::SharedEigenvalue { .. })));
        assert!(matches!(sylvester(&A, &A, &Mat::zeros(1, 2)), Err(Error::Shape { .. })));
    }
}
