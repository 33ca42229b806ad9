//! Discrete algebraic Riccati equation of the steady predictor.
//!
//! Enters: A, C and the joint covariance of what disturbs states and outputs. Leaves: the predictor's gain, its error's
//! covariances. Deliberately absent: the control equation (sampled designs go through the w-plane).

use crate::schur::spectrum;
use crate::state_space::{expect_finite, expect_shape};
use crate::sylvester::symmetric_part;
use crate::{Error, Mat};

/// Doublings: each squares the closed loop, so 60 settle all that can be told from the unit circle.
const MOST_DOUBLINGS: usize = 60;
/// A change below this part of P is rounding.
const SETTLED: f64 = 1e-15;

/// The steady one-step predictor x(k+1) = A x(k) + K (y(k) - C x(k)).
#[derive(Clone, Debug, PartialEq)]
pub struct Predictor {
    /// n x l; A - K C is stable.
    pub K: Mat,
    /// C P C' + R: covariance of y(k) - C x(k), l x l.
    pub innovation_covariance: Mat,
    /// Covariance of the state's error, n x n.
    pub P: Mat,
    /// Norm of what the equation leaves, relative to that of P.
    pub residual: f64,
}

/// P = A P A' + Q - (A P C' + S)(C P C' + R)^-1 (A P C' + S)', K = (A P C' + S)(C P C' + R)^-1.
///
/// Shapes: A, Q n x n; C l x n; R l x l; S n x l.
/// Assumes: [Q S; S' R] symmetric, not negative; every mode that does not decay is disturbed and seen.
/// Errors: [`Error::SingularWeight`] for R; [`Error::NotConverged`] where A - K C would keep an eigenvalue on the unit circle;
/// [`Error::Shape`], [`Error::NotFinite`].
/// Numerics: O(n^3) a doubling, quadratic convergence; expect `residual` below 1e-13.
/// Source: Anderson 1978 (doubling); Chu, Fan, Lin and Wang 2004 for its structure-preserving form.
pub fn predictor(A: &Mat, C: &Mat, Q: &Mat, R: &Mat, S: &Mat) -> Result<Predictor, Error> {
    let (n, l) = (A.nrows(), C.nrows());
    for (what, M, rows, columns) in [("A", A, n, n), ("C", C, l, n), ("Q", Q, n, n), ("R", R, l, l), ("S", S, n, l)] {
        expect_shape(what, M, rows, columns)?;
        expect_finite(what, M)?;
    }
    let root = symmetric_part(R).cholesky().ok_or(Error::SingularWeight)?;
    // Without S: x(k+1) = (A - S R^-1 C) x + S R^-1 y, disturbed by Q - S R^-1 S'.
    let F = A - S * root.solve(C);
    let Q_s = symmetric_part(&(Q - S * root.solve(&S.transpose())));
    let P = doubled(F.transpose(), C.transpose() * root.solve(C), Q_s)?;
    let innovation_covariance = symmetric_part(&(C * &P * C.transpose() + R));
    let gain = |P: &Mat| A * P * C.transpose() + S;
    let factor = innovation_covariance.clone().cholesky().ok_or(Error::SingularWeight)?;
    let K = factor.solve(&gain(&P).transpose()).transpose();
    let left = A * &P * A.transpose() + Q - &K * gain(&P).transpose() - &P;
    let residual = left.norm() / P.norm().max(f64::MIN_POSITIVE);
    let radius = spectrum(&(A - &K * C))?.iter().map(|z| z.norm()).fold(0.0, f64::max);
    if radius < 1.0 { Ok(Predictor { K, innovation_covariance, P, residual }) } else { Err(not_converged()) }
}

fn not_converged() -> Error {
    Error::NotConverged { what: "the doubling of the discrete Riccati equation", iterations: MOST_DOUBLINGS }
}

/// Limit of H: the solution of X = A'X (I + G X)^-1 A + H.
fn doubled(mut A: Mat, mut G: Mat, mut H: Mat) -> Result<Mat, Error> {
    let n = A.nrows();
    for _ in 0..MOST_DOUBLINGS {
        let W = (Mat::identity(n, n) + &G * &H).full_piv_lu();
        let (WA, WG) = (W.solve(&A).ok_or_else(not_converged)?, W.solve(&G).ok_or_else(not_converged)?);
        let step = symmetric_part(&(A.transpose() * &H * &WA));
        G = symmetric_part(&(&G + &A * WG * A.transpose()));
        H += &step;
        A = &A * WA;
        if step.norm() <= SETTLED * H.norm() {
            return Ok(H);
        }
        if !H.iter().all(|x| x.is_finite()) {
            break;
        }
    }
    Err(not_converged())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scalar(x: f64) -> Mat {
        Mat::from_element(1, 1, x)
    }

    /// p = a^2 p + q - (a p + s)^2/(p + r): the root of a quadratic.
    #[test]
    fn scalar_equations_have_the_roots_of_their_quadratic() {
        for (a, q, r, s) in [(0.9, 1.0, 1.0, 0.0), (1.0, 0.3, 2.0, 0.5), (1.2, 0.1, 1.0, -0.2), (0.5, 0.0, 1.0, 0.0)] {
            let found = predictor(&scalar(a), &scalar(1.0), &scalar(q), &scalar(r), &scalar(s)).unwrap();
            // p (p + r) = (a^2 p + q)(p + r) - (a p + s)^2, so p^2 + p (r - a^2 r - q + 2 a s) + s^2 - q r = 0.
            let half = (r - a * a * r - q + 2.0 * a * s) / 2.0;
            let p = -half + (half * half - s * s + q * r).sqrt();
            assert!((found.P[(0, 0)] - p).abs() < 1e-13 * p.max(1.0), "{a} {q} {r} {s}: {} for {p}", found.P[(0, 0)]);
            assert!((a - found.K[(0, 0)]).abs() < 1.0);
        }
    }

    /// An integrator and an unstable mode among five states, three of them disturbed with the outputs: the recursion of the
    /// Kalman filter, run until it stands still, ends at the same P.
    #[test]
    fn the_filter_s_recursion_ends_there() {
        let mix = |r: usize, c: usize| (((r + 1) * (c + 2)) as f64 * 1.3).sin();
        let mut A = Mat::from_fn(5, 5, |r, c| 0.1 * mix(r, c));
        (0..5).for_each(|k| A[(k, k)] += [1.0, 1.1, 0.7, 0.3, -0.5][k]);
        let (C, noise) =
            (Mat::from_fn(2, 5, mix), Mat::from_fn(7, 7, |r, c| mix(c + 1, r) + if r == c { 1.0 } else { 0.0 }));
        let joint = &noise * noise.transpose();
        let block = |r: usize, c: usize, rows: usize, columns: usize| joint.view((r, c), (rows, columns)).into_owned();
        let (Q, S, R) = (block(0, 0, 5, 5), block(0, 5, 5, 2), block(5, 5, 2, 2));
        let found = predictor(&A, &C, &Q, &R, &S).unwrap();
        let mut P = Mat::identity(5, 5);
        for _ in 0..5000 {
            let gain = &A * &P * C.transpose() + &S;
            let inner = (&C * &P * C.transpose() + &R).cholesky().unwrap();
            // Joseph's form: a sum of squares, which rounding cannot drive out of symmetry and below zero.
            let K = inner.solve(&gain.transpose()).transpose();
            let F = &A - &K * &C;
            let cross = &K * S.transpose();
            P = &F * &P * F.transpose() + &Q + &K * &R * K.transpose() - &cross - cross.transpose();
            P = symmetric_part(&P);
        }
        assert!((&found.P - &P).norm() < 1e-11 * P.norm());
        assert!(found.residual < 1e-13, "{:e}", found.residual);
    }

    #[test]
    fn an_undisturbed_integrator_has_no_stable_predictor() {
        let refused = predictor(&scalar(1.0), &scalar(1.0), &scalar(0.0), &scalar(1.0), &scalar(0.0));
        assert!(matches!(refused, Err(Error::NotConverged { .. })), "{refused:?}");
        let refused = predictor(&scalar(0.5), &scalar(1.0), &scalar(1.0), &scalar(0.0), &scalar(0.0));
        assert_eq!(refused, Err(Error::SingularWeight));
    }
}
