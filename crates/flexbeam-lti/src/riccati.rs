//! Continuous algebraic Riccati equation.
//!
//! Enters: A, B, Q, R. Leaves: the stabilising solution and its residual.
//! Deliberately absent: the discrete equation (sampled designs go through the w-plane), game-theoretic bounds.

use crate::schur::{balanced, ordered_schur, spectrum, spectrum_off_line};
use crate::state_space::{expect_finite, expect_shape};
use crate::sylvester::{lyapunov, symmetric_part};
use crate::{C64, CMat, Error, Mat};

/// Below this smallest singular value of U11, X is not known to a single digit.
const SINGULAR: f64 = 1e3 * f64::EPSILON;

/// Newton steps after the Schur form; one is typical, more help where X is large.
const NEWTON_STEPS: usize = 4;

/// Stabilising solution of a Riccati equation.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// n x n, symmetric; A - B R^-1 B' X is stable.
    pub X: Mat,
    /// Norm of what the equation leaves, relative to the sum of its terms' norms.
    pub residual: f64,
}

/// Stabilising solution of  A'X + XA - X B R^-1 B' X + Q = 0.
///
/// Shapes: A n x n, B n x m, Q n x n and R m x m symmetric; returns X n x n.
/// Assumes: R invertible, of any sign.
/// Errors: [`Error::AxisEigenvalues`] when the Hamiltonian has some on the imaginary axis (an unobserved or uncontrolled mode there, or no solution);
/// [`Error::NotStabilisable`]; [`Error::SingularWeight`] for R; [`Error::Shape`], [`Error::NotFinite`], [`Error::NotConverged`].
/// Numerics: O(n^3), Newton steps at the end; expect `residual` below 1e-14, above it as the norm of X passes 1e6.
/// Source: Laub 1979. Differs: the Hamiltonian is balanced by a symplectic diagonal (Benner 2001) first.
pub fn continuous_riccati(A: &Mat, B: &Mat, Q: &Mat, R: &Mat) -> Result<Solution, Error> {
    let n = A.nrows();
    for (what, M, rows, columns) in
        [("A", A, n, n), ("B", B, n, R.nrows()), ("Q", Q, n, n), ("R", R, R.nrows(), R.nrows())]
    {
        expect_shape(what, M, rows, columns)?;
        expect_finite(what, M)?;
    }
    let equation = Equation { A: A.clone(), B: B.clone(), F: weighted_input(B, R)?, Q: symmetric_part(Q) };
    let scale = equation.symplectic_scale();
    let scaled = equation.scaled(&scale);
    let X = scaled.solution_by_schur().map_err(|reason| reason.named(A, B))?;
    let X = scaled.refined(X);
    let X = Mat::from_fn(n, n, |i, j| X[(i, j)] / (scale[i] * scale[j]));
    let residual = equation.relative_residual(&X);
    Ok(Solution { X, residual })
}

/// R^-1 B'.
fn weighted_input(B: &Mat, R: &Mat) -> Result<Mat, Error> {
    if R.is_empty() {
        return Ok(B.transpose());
    }
    symmetric_part(R).full_piv_lu().solve(&B.transpose()).ok_or(Error::SingularWeight)
}

/// Why the Schur form gave no solution, before the culprit is named.
enum Failure {
    Uncontrolled,
    Other(Error),
}

impl From<Error> for Failure {
    fn from(error: Error) -> Failure {
        Failure::Other(error)
    }
}

impl Failure {
    fn named(self, A: &Mat, B: &Mat) -> Error {
        match self {
            Failure::Other(error) => error,
            Failure::Uncontrolled => least_controlled(A, B).unwrap_or_else(|error| error),
        }
    }
}

/// The mode with Re s >= 0 nearest to uncontrollable, as an error.
fn least_controlled(A: &Mat, B: &Mat) -> Result<Error, Error> {
    let distance = |p: &C64| {
        let n = A.nrows();
        let mut pencil = CMat::zeros(n, n + B.ncols());
        pencil.columns_mut(0, n).copy_from(&(A.map(C64::from) - CMat::from_diagonal_element(n, n, *p)));
        pencil.columns_mut(n, B.ncols()).copy_from(&B.map(C64::from));
        pencil.singular_values().min()
    };
    let rightmost = |p: &C64| C64::new(-p.re, p.im);
    let poles = spectrum(A)?;
    let unstable = poles.iter().filter(|p| p.re >= 0.0).min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let culprit = unstable.or(poles.iter().min_by(|a, b| rightmost(a).re.total_cmp(&rightmost(b).re)));
    let p = culprit.copied().unwrap_or_default();
    Ok(Error::NotStabilisable { re: p.re, im: p.im })
}

/// A'X + XA - X B F X + Q = 0, B F and Q symmetric.
///
/// NUMERICS: B and F stay apart, since K = F X is often far smaller than X while (B F) X is not.
struct Equation {
    A: Mat,
    B: Mat,
    F: Mat,
    Q: Mat,
}

impl Equation {
    /// [A -BF; -Q -A'].
    fn hamiltonian(&self) -> Mat {
        let G = symmetric_part(&(&self.B * &self.F));
        crate::blocks::blocks(&self.A, &-G, &-&self.Q, &-self.A.transpose())
    }

    /// Diagonal of S such that diag(S^-1, S) H diag(S, S^-1) is nearly balanced, powers of two.
    fn symplectic_scale(&self) -> Vec<f64> {
        let n = self.A.nrows();
        let (_, free) = balanced(&self.hamiltonian());
        (0..n).map(|k| (0.5 * (free[k] / free[n + k]).log2()).round().exp2()).collect()
    }

    fn scaled(&self, s: &[f64]) -> Equation {
        let n = self.A.nrows();
        Equation {
            A: Mat::from_fn(n, n, |i, j| self.A[(i, j)] * (s[j] / s[i])),
            B: Mat::from_fn(n, self.B.ncols(), |i, j| self.B[(i, j)] / s[i]),
            F: Mat::from_fn(self.F.nrows(), n, |i, j| self.F[(i, j)] / s[j]),
            Q: Mat::from_fn(n, n, |i, j| self.Q[(i, j)] * (s[i] * s[j])),
        }
    }

    /// X = U21 U11^-1 from the stable invariant subspace [U11; U21] of the Hamiltonian.
    fn solution_by_schur(&self) -> Result<Mat, Failure> {
        let n = self.A.nrows();
        let H = self.hamiltonian();
        expect_no_axis_eigenvalue(&H)?;
        let U = ordered_schur(&H, |p| p.re < 0.0)?.Q;
        let (U11, U21) = (U.view((0, 0), (n, n)).into_owned(), U.view((n, 0), (n, n)).into_owned());
        if n > 0 && U11.singular_values().min() <= SINGULAR {
            return Err(Failure::Uncontrolled);
        }
        let X = U11.transpose().lu().solve(&U21.transpose()).ok_or(Failure::Uncontrolled)?;
        Ok(symmetric_part(&X))
    }

    /// Newton steps as long as each halves the residual.
    ///
    /// Source: Kleinman 1968.
    fn refined(&self, X: Mat) -> Mat {
        let (mut best, mut residual) = (X, f64::INFINITY);
        let mut next = best.clone();
        for _ in 0..=NEWTON_STEPS {
            let found = self.relative_residual(&next);
            if !(found < 0.5 * residual) {
                break;
            }
            (best, residual) = (next, found);
            let closed_loop = (&self.A - &self.B * (&self.F * &best)).transpose();
            match lyapunov(&closed_loop, &self.left_over(&best)) {
                Ok(step) => next = symmetric_part(&(&best + step)),
                Err(_) => break,
            }
        }
        best
    }

    fn left_over(&self, X: &Mat) -> Mat {
        let XA = X * &self.A;
        symmetric_part(&(&XA + XA.transpose() - (X * &self.B) * (&self.F * X) + &self.Q))
    }

    fn relative_residual(&self, X: &Mat) -> f64 {
        let terms = 2.0 * (X * &self.A).norm() + ((X * &self.B) * (&self.F * X)).norm() + self.Q.norm();
        if terms == 0.0 { 0.0 } else { self.left_over(X).norm() / terms }
    }
}

/// Errors: [`Error::AxisEigenvalues`] when an eigenvalue of the Hamiltonian may lie on the axis, by its condition.
fn expect_no_axis_eigenvalue(H: &Mat) -> Result<(), Error> {
    let (eigenvalues, found) = spectrum_off_line(H, |p| p.re.abs())?;
    let left = eigenvalues.iter().filter(|p| p.re < 0.0).count();
    // An odd division means that two have met on the axis: the nearest is named.
    let nearest = || eigenvalues.iter().min_by(|a, b| a.re.abs().total_cmp(&b.re.abs())).copied();
    let culprit = if 2 * left == eigenvalues.len() { found } else { found.or_else(nearest) };
    culprit.map_or(Ok(()), |p| Err(Error::AxisEigenvalues { omega_rad_s: p.im.abs() }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Draw;

    fn check(A: &Mat, B: &Mat, Q: &Mat, R: &Mat, allowed: f64) -> Mat {
        let Solution { X, residual } = continuous_riccati(A, B, Q, R).unwrap();
        assert_eq!(X, X.transpose());
        let K = R.clone().lu().solve(&(B.transpose() * &X)).unwrap();
        // The residual by another grouping than the solver's own.
        let closed_loop = A - B * &K;
        let left = closed_loop.tr_mul(&X) + &X * A + Q;
        let terms = 2.0 * (&X * A).norm() + (&X * B * &K).norm() + Q.norm() + f64::MIN_POSITIVE;
        let relative = left.norm() / terms;
        assert!(relative <= allowed && residual <= allowed, "{relative:e} {residual:e}");
        assert!(spectrum(&closed_loop).unwrap().iter().all(|p| p.re < 0.0));
        X
    }

    #[test]
    fn scalar_closed_form() {
        // 2 a x - x^2 b^2/r + q = 0: x = r (a + sqrt(a^2 + b^2 q/r))/b^2.
        for (a, b, q, r) in
            [(1.0, 1.0, 1.0, 1.0), (-3.0, 0.1, 1e6, 1e-3), (2.0, 5.0, 0.0, 7.0), (1e-6, 1e3, 1e-6, 1e3f64)]
        {
            let one = |x: f64| Mat::from_element(1, 1, x);
            let X = check(&one(a), &one(b), &one(q), &one(r), 1e-14);
            let known = r * (a + (a * a + b * b * q / r).sqrt()) / (b * b);
            assert!((X[0] / known - 1.0).abs() < 1e-13, "{a} {b} {q} {r}");
        }
    }

    #[test]
    fn random_problems_up_to_fifty_states() {
        let mut draw = Draw(61);
        for n in [0, 1, 2, 3, 6, 12, 25, 50] {
            for m in [1, 3] {
                let A = draw.matrix(n, n) / (0.2 * n as f64 + 1.0).sqrt() - Mat::identity(n, n) * 0.5;
                let (B, C) = (draw.matrix(n, m), draw.matrix(2, n));
                let F = draw.matrix(m, m);
                let R = &F * F.transpose() + Mat::identity(m, m);
                // Fifty states under one input: X is 1e11, and rounding its entries alone leaves 1e-10.
                let allowed = if (n, m) == (50, 1) { 1e-10 } else { 1e-13 };
                let X = check(&A, &B, &C.tr_mul(&C), &R, allowed);
                assert!(n == 0 || X.clone().symmetric_eigenvalues().min() > -1e-10 * X.norm());
            }
        }
    }

    #[test]
    fn lightly_damped_modes_and_units_twelve_decades_apart() {
        let omegas = [1e-3, 1.0, 1e3];
        let mut A = Mat::zeros(6, 6);
        for (k, omega) in omegas.iter().enumerate() {
            A[(2 * k, 2 * k + 1)] = 1.0;
            A[(2 * k + 1, 2 * k)] = -omega * omega;
            A[(2 * k + 1, 2 * k + 1)] = -2e-4 * omega;
        }
        let B = Mat::from_column_slice(6, 1, &[0.0, 1e-6, 0.0, 1.0, 0.0, 1e6]);
        let C = Mat::from_row_slice(1, 6, &[1.0, 0.0, 1.0, 0.0, 1.0, 0.0]);
        let X = check(&A, &B, &C.tr_mul(&C), &Mat::identity(1, 1), 1e-13);
        let units: [f64; 6] = [1e6, 1e-6, 1.0, 1e3, 1e-3, 1e4];
        let scaled = |M: &Mat, power: [i32; 2]| {
            Mat::from_fn(M.nrows(), M.ncols(), |i, j| {
                let (row, column) = (units[i], if M.ncols() == 1 { 1.0 } else { units[j] });
                M[(i, j)] * row.powi(power[0]) * column.powi(power[1])
            })
        };
        let Q = C.tr_mul(&C);
        let Y =
            continuous_riccati(&scaled(&A, [1, -1]), &scaled(&B, [1, 1]), &scaled(&Q, [-1, -1]), &Mat::identity(1, 1));
        let back = scaled(&Y.unwrap().X, [1, 1]);
        for k in 0..36 {
            let (i, j) = (k % 6, k / 6);
            let size = (X[(i, i)] * X[(j, j)]).sqrt();
            assert!((back[(i, j)] - X[(i, j)]).abs() < 1e-9 * size, "{i} {j}");
        }
    }

    #[test]
    fn repeated_poles_and_double_integrator() {
        // Double integrator, Q = diag(1, 0), R = 1: X = [sqrt 2, 1; 1, sqrt 2].
        let A = Mat::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0]);
        let B = Mat::from_column_slice(2, 1, &[0.0, 1.0]);
        let Q = Mat::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 0.0]);
        let X = check(&A, &B, &Q, &Mat::identity(1, 1), 1e-14);
        let known = Mat::from_row_slice(2, 2, &[2f64.sqrt(), 1.0, 1.0, 2f64.sqrt()]);
        assert!((X - known).norm() < 1e-14);
        let chain = Mat::from_fn(8, 8, |i, j| f64::from(u8::from(j == i + 1)));
        let B = Mat::from_fn(8, 1, |i, _| f64::from(u8::from(i == 7)));
        check(&chain, &B, &Mat::identity(8, 8), &Mat::identity(1, 1), 1e-13);
    }

    #[test]
    fn no_weight_mirrors_the_unstable_poles() {
        let mut draw = Draw(62);
        let A = draw.matrix(5, 5) + Mat::identity(5, 5) * 0.4;
        assert!(spectrum(&A).unwrap().iter().any(|p| p.re > 0.1));
        let B = draw.matrix(5, 1);
        let X = check(&A, &B, &Mat::zeros(5, 5), &Mat::identity(1, 1), 1e-12);
        let key = |p: &C64| (p.re * 1e9).round() + p.im * 1e-3;
        let mut known: Vec<C64> = spectrum(&A).unwrap().iter().map(|p| C64::new(-p.re.abs(), p.im)).collect();
        let mut found = spectrum(&(&A - &B * B.tr_mul(&X))).unwrap();
        known.sort_by(|a, b| key(a).total_cmp(&key(b)));
        found.sort_by(|a, b| key(a).total_cmp(&key(b)));
        assert!(known.iter().zip(&found).all(|(a, b)| (a - b).norm() < 1e-9), "{known:?} {found:?}");
    }

    #[test]
    fn what_cannot_be_stabilised_is_named() {
        let V = Draw(63).matrix(3, 3).qr().q();
        let hidden = |poles: [f64; 3], b: [f64; 3], q: [f64; 3]| {
            let A = &V * Mat::from_diagonal(&crate::Vector::from_row_slice(&poles)) * V.transpose();
            let Q = &V * Mat::from_diagonal(&crate::Vector::from_row_slice(&q)) * V.transpose();
            continuous_riccati(&A, &(&V * Mat::from_column_slice(3, 1, &b)), &Q, &Mat::identity(1, 1))
        };
        let uncontrolled = hidden([2.0, -1.0, -3.0], [0.0, 1.0, 1.0], [1.0, 1.0, 1.0]);
        assert!(
            matches!(uncontrolled, Err(Error::NotStabilisable { re, im: 0.0 }) if (re - 2.0).abs() < 1e-12),
            "{uncontrolled:?}"
        );
        for (b, q) in [([0.0, 1.0, 1.0], [1.0; 3]), ([1.0, 1.0, 1.0], [0.0, 1.0, 1.0])] {
            let axis = hidden([0.0, -1.0, -3.0], b, q);
            assert!(matches!(axis, Err(Error::AxisEigenvalues { omega_rad_s }) if omega_rad_s < 1e-6), "{axis:?}");
        }
        let A = Mat::from_row_slice(2, 2, &[0.0, 7.0, -7.0, 0.0]);
        let axis = continuous_riccati(&A, &Mat::from_element(2, 1, 1.0), &Mat::zeros(2, 2), &Mat::identity(1, 1));
        assert!(
            matches!(axis, Err(Error::AxisEigenvalues { omega_rad_s }) if (omega_rad_s - 7.0).abs() < 1e-6),
            "{axis:?}"
        );
        let singular = continuous_riccati(&A, &Mat::zeros(2, 1), &Mat::zeros(2, 2), &Mat::zeros(1, 1));
        assert_eq!(singular, Err(Error::SingularWeight));
    }
}
