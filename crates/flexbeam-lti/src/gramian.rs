//! Gramians as factors, P = L L', without forming P.
//!
//! Enters: a stable system. Leaves: real square factors of its Gramians.
//! Deliberately absent: Gramians themselves (`sylvester::lyapunov` gives them).

use crate::schur::complex_schur;
use crate::split::expect_stable;
use crate::{C64, CMat, Error, Mat, StateSpace, Time};

/// L with L L' = P,  A P + P A' + B B' = 0  or  A P A' - P + B B' = 0.
///
/// Shapes: returns n x n.
/// Errors: [`Error::WrongSide`], [`Error::BoundaryPole`] for a pole that is not stable; [`Error::NotConverged`].
/// Numerics: O(n^3); B B' is never formed, so L is as accurate as P would be in twice the digits.
/// Source: Hammarling 1982. Differs: complex triangular form, and B is carried with its columns instead of a triangle.
pub fn controllability_factor(G: &StateSpace) -> Result<Mat, Error> {
    expect_stable(G)?;
    factor(&G.A, &G.B, G.time)
}

/// L with L L' = Q,  A'Q + Q A + C'C = 0  or  A'Q A - Q + C'C = 0.
///
/// As [`controllability_factor`].
pub fn observability_factor(G: &StateSpace) -> Result<Mat, Error> {
    expect_stable(G)?;
    factor(&G.A.transpose(), &G.C.transpose(), G.time)
}

fn factor(A: &Mat, B: &Mat, time: Time) -> Result<Mat, Error> {
    let (T, Q) = complex_schur(A)?;
    let U = match time {
        Time::Continuous => continuous_triangle(&T, Q.adjoint() * B.map(C64::from)),
        Time::Sampled { .. } => sampled_triangle(&T, Q.adjoint() * B.map(C64::from)),
    };
    Ok(real_factor(&(Q * U)))
}

/// Upper triangular U,  T U U* + U U* T* + B B* = 0, from the last column to the first.
fn continuous_triangle(T: &CMat, mut B: CMat) -> CMat {
    let n = T.nrows();
    let mut U = CMat::zeros(n, n);
    for k in (0..n).rev() {
        let lambda = T[(k, k)];
        let tau = B.row(k).norm() / (-2.0 * lambda.re).sqrt();
        if tau == 0.0 {
            continue;
        }
        let y = B.rows(k, 1).adjoint() / C64::from(tau);
        let above = B.rows(0, k).into_owned();
        // (T11 + conj(lambda)) u = -(a tau + B1 y)
        let rest = -(T.view((0, k), (k, 1)) * C64::from(tau) + &above * &y);
        let u = shifted_solution(T, C64::from(1.0), lambda.conj(), rest);
        B.rows_mut(0, k).copy_from(&(above - &u * y.adjoint()));
        U.view_mut((0, k), (k, 1)).copy_from(&u);
        U[(k, k)] = C64::from(tau);
    }
    U
}

/// Upper triangular U,  T U U* T* - U U* + B B* = 0, from the last column to the first.
fn sampled_triangle(T: &CMat, mut B: CMat) -> CMat {
    let (n, m) = (T.nrows(), B.ncols());
    let mut U = CMat::zeros(n, n);
    for k in (0..n).rev() {
        let lambda = T[(k, k)];
        let margin = (1.0 - lambda.norm()) * (1.0 + lambda.norm());
        let tau = B.row(k).norm() / margin.sqrt();
        if tau == 0.0 {
            continue;
        }
        let y = B.rows(k, 1).adjoint() / C64::from(tau);
        let a_tau = T.view((0, k), (k, 1)) * C64::from(tau);
        let above = B.rows(0, k).into_owned();
        // (conj(lambda) T11 - I) u = -(conj(lambda) a tau + B1 y)
        let rest = -(&a_tau * lambda.conj() + &above * &y);
        let u = shifted_solution(T, lambda.conj(), C64::from(-1.0), rest);
        // u = [v B1] w with w = [conj(lambda); y] of length one: what is left is [v B1] on the complement of w.
        let v = T.view((0, 0), (k, k)) * &u + a_tau;
        let mut both = CMat::zeros(k, m + 1);
        both.column_mut(0).copy_from(&v.column(0));
        both.columns_mut(1, m).copy_from(&above);
        let mut w = CMat::zeros(m + 1, 1);
        w[0] = lambda.conj();
        w.rows_mut(1, m).copy_from(&y);
        B.rows_mut(0, k).copy_from(&(both * complement(w)));
        U.view_mut((0, k), (k, 1)).copy_from(&u);
        U[(k, k)] = C64::from(tau);
    }
    U
}

/// Orthonormal columns orthogonal to the unit vector w: the reflection of w onto the first axis without its first column.
fn complement(w: CMat) -> CMat {
    let size = w.nrows();
    let phase = if w[0].norm() > 0.0 { w[0] / w[0].norm() } else { C64::from(1.0) };
    let mut z = w;
    z[0] += phase;
    let scale = C64::from(2.0 / z.norm_squared());
    let reflection = CMat::identity(size, size) - &z * z.adjoint() * scale;
    reflection.columns(1, size - 1).into_owned()
}

/// x with (alpha T11 + beta I) x = rest, T11 the leading triangle of T as large as `rest`.
fn shifted_solution(T: &CMat, alpha: C64, beta: C64, mut rest: CMat) -> CMat {
    for i in (0..rest.nrows()).rev() {
        let x = rest[i] / (alpha * T[(i, i)] + beta);
        rest[i] = x;
        for j in 0..i {
            rest[j] -= alpha * T[(j, i)] * x;
        }
    }
    rest
}

/// R real and square with R R' = L L*, which is real: [Re L  Im L], then QR.
fn real_factor(L: &CMat) -> Mat {
    let both = crate::blocks::stack(&L.map(|x| x.re).transpose(), &L.map(|x| x.im).transpose());
    if both.is_empty() { both.rows(0, L.nrows()).into_owned() } else { both.qr().r().transpose() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Draw;
    use crate::sylvester::{discrete_lyapunov, lyapunov};

    #[test]
    fn factors_multiply_to_the_gramians() {
        let mut draw = Draw(81);
        for n in [0, 1, 2, 3, 5, 10, 50] {
            for m in [1, 3] {
                let (B, C) = (draw.matrix(n, m), draw.matrix(m, n));
                let D = Mat::zeros(m, m);
                let A = draw.stable(n, 0.05);
                let G = StateSpace::new(A.clone(), B.clone(), C.clone(), D.clone(), Time::Continuous).unwrap();
                let (P, Q) = (controllability_factor(&G).unwrap(), observability_factor(&G).unwrap());
                let known = lyapunov(&A, &(&B * B.transpose())).unwrap();
                assert!((&P * P.transpose() - &known).norm() <= 1e-12 * known.norm());
                let known = lyapunov(&A.transpose(), &C.tr_mul(&C)).unwrap();
                assert!((&Q * Q.transpose() - &known).norm() <= 1e-12 * known.norm());
                let A = draw.matrix(n, n) * (0.9 / (n as f64 + 1.0).sqrt());
                let known = discrete_lyapunov(&A, &(&B * B.transpose())).unwrap();
                let G = StateSpace::new(A, B, C, D, Time::Sampled { period_s: 1.0 }).unwrap();
                let P = controllability_factor(&G).unwrap();
                assert!((&P * P.transpose() - &known).norm() <= 1e-12 * known.norm(), "{n} {m}");
            }
        }
    }

    #[test]
    fn an_unreached_state_has_a_zero_column() {
        let A = Mat::from_diagonal(&crate::Vector::from_row_slice(&[-1.0, -2.0]));
        let B = Mat::from_column_slice(2, 1, &[1.0, 0.0]);
        for (A, time) in [(A.clone(), Time::Continuous), (A / 4.0, Time::Sampled { period_s: 1.0 })] {
            let G = StateSpace::new(A, B.clone(), B.transpose(), Mat::zeros(1, 1), time).unwrap();
            let P = controllability_factor(&G).unwrap();
            assert_eq!((&P * P.transpose())[(1, 1)], 0.0);
            assert!(P[(0, 0)] != 0.0);
        }
    }
}
