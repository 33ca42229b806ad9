//! Additive decomposition: G = G_1 + G_2 by where the poles lie.
//!
//! Enters: a system. Leaves: two systems whose sum it is.
//! Deliberately absent: products (inner-outer, coprime factors).

use crate::schur::{balanced, ordered_schur, spectrum_off_line};
use crate::sylvester::sylvester;
use crate::{C64, Error, Mat, StateSpace, Time};

/// G = G_1 + G_2, the poles with `first` in G_1 together with D.
///
/// Assumes: `first` says the same of both members of a conjugate pair.
/// Errors: [`Error::NotSeparable`], [`Error::SharedEigenvalue`] when the parts have a pole in common; those of [`ordered_schur`].
/// Numerics: O(n^3); the error of the sum grows with the norm of the decoupling matrix, that is as the parts' poles approach.
/// Source: Safonov, Jonckheere, Verma and Limebeer 1987.
pub fn split(G: &StateSpace, first: impl Fn(C64) -> bool) -> Result<(StateSpace, StateSpace), Error> {
    let StateSpace { A, B, C, .. } = balanced_states(G);
    let S = ordered_schur(&A, first)?;
    let (n, k) = (G.order(), S.leading);
    let (Q1, Q2) = (S.Q.columns(0, k), S.Q.columns(k, n - k));
    let T = |i, j, rows, columns| S.T.view((i, j), (rows, columns)).into_owned();
    let (T1, T2) = (T(0, 0, k, k), T(k, k, n - k, n - k));
    // T1 Y - Y T2 = -T12: [I Y; 0 I] removes T12.
    let Y = sylvester(&T1, &-&T2, &-T(0, k, k, n - k))?;
    let B2 = Q2.tr_mul(&B);
    let B1 = Q1.tr_mul(&B) - &Y * &B2;
    let C2 = &C * (Q1 * &Y + Q2);
    let D2 = Mat::zeros(G.outputs(), G.inputs());
    let one = StateSpace::new(T1, B1, &C * Q1, G.D.clone(), G.time)?;
    let two = StateSpace::new(T2, B2, C2, D2, G.time)?;
    Ok((one, two))
}

/// G = stable + antistable, D with the stable part: Re s < 0, or |z| < 1.
///
/// Errors: [`Error::BoundaryPole`] for a pole on the axis or the circle; those of [`split`].
pub fn stable_antistable(G: &StateSpace) -> Result<(StateSpace, StateSpace), Error> {
    expect_no_boundary_pole(G)?;
    split(G, |p| is_stable(p, G.time))
}

/// Re s < 0, or |z| < 1.
pub(crate) fn is_stable(pole: C64, time: Time) -> bool {
    match time {
        Time::Continuous => pole.re < 0.0,
        Time::Sampled { .. } => pole.norm() < 1.0,
    }
}

/// Errors: [`Error::BoundaryPole`].
pub(crate) fn expect_no_boundary_pole(G: &StateSpace) -> Result<Vec<C64>, Error> {
    let distance = |p: C64| match G.time {
        Time::Continuous => p.re.abs(),
        Time::Sampled { .. } => (p.norm() - 1.0).abs(),
    };
    match spectrum_off_line(&balanced(&G.A).0, distance)? {
        (_, Some(p)) => Err(Error::BoundaryPole { re: p.re, im: p.im }),
        (poles, None) => Ok(poles),
    }
}

/// Errors: [`Error::BoundaryPole`], [`Error::WrongSide`].
pub(crate) fn expect_stable(G: &StateSpace) -> Result<(), Error> {
    let poles = expect_no_boundary_pole(G)?;
    match poles.iter().find(|p| !is_stable(**p, G.time)) {
        Some(p) => Err(Error::WrongSide { re: p.re, im: p.im, needed: "stable" }),
        None => Ok(()),
    }
}

/// The same system with states scaled by powers of two so that A is balanced.
pub(crate) fn balanced_states(G: &StateSpace) -> StateSpace {
    let (A, scale) = balanced(&G.A);
    let B = Mat::from_fn(G.order(), G.inputs(), |i, j| G.B[(i, j)] / scale[i]);
    let C = Mat::from_fn(G.outputs(), G.order(), |i, j| G.C[(i, j)] * scale[j]);
    StateSpace { A, B, C, D: G.D.clone(), time: G.time }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Draw;

    fn system(draw: &mut Draw, n: usize, time: Time) -> StateSpace {
        let (B, C, D) = (draw.matrix(n, 2), draw.matrix(3, n), draw.matrix(3, 2));
        StateSpace::new(draw.matrix(n, n), B, C, D, time).unwrap()
    }

    #[test]
    fn the_parts_sum_to_the_whole() {
        let mut draw = Draw(21);
        for time in [Time::Continuous, Time::Sampled { period_s: 0.1 }] {
            for n in [0, 1, 2, 5, 9, 50] {
                let G = system(&mut draw, n, time);
                let (stable, antistable) = stable_antistable(&G).unwrap();
                assert_eq!(stable.order() + antistable.order(), n);
                assert!(stable.poles().iter().all(|p| is_stable(*p, time)));
                assert!(antistable.poles().iter().all(|p| !is_stable(*p, time)));
                assert_eq!(antistable.D, Mat::zeros(3, 2));
                for s in [C64::new(0.3, 1.7), C64::new(0.0, 0.2), C64::new(-2.0, 30.0)] {
                    let whole = G.at(s);
                    let error = (stable.at(s) + antistable.at(s) - &whole).norm() / whole.norm();
                    assert!(error < 1e-10, "{n} {s}: {error}");
                }
            }
        }
    }

    #[test]
    fn frequencies_over_twelve_decades_split() {
        let mut A = Mat::zeros(4, 4);
        for (k, omega) in [1e-6, 1e6].iter().enumerate() {
            A[(2 * k, 2 * k + 1)] = 1.0;
            A[(2 * k + 1, 2 * k)] = -omega * omega;
            A[(2 * k + 1, 2 * k + 1)] = -2e-4 * omega;
        }
        let B = Mat::from_column_slice(4, 1, &[0.0, 1e-12, 0.0, 1e12]);
        let C = Mat::from_row_slice(1, 4, &[1.0, 0.0, 1.0, 0.0]);
        let G = StateSpace::new(A, B, C, Mat::zeros(1, 1), Time::Continuous).unwrap();
        let (slow, fast) = split(&G, |p| p.norm() < 1.0).unwrap();
        assert_eq!((slow.order(), fast.order()), (2, 2));
        for (part, omega) in [(slow, 1e-6), (fast, 1e6)] {
            let peak = part.at(C64::new(0.0, omega))[0].norm();
            assert!((peak / 5000.0 - 1.0).abs() < 1e-9, "{peak}");
        }
    }

    #[test]
    fn a_hidden_double_or_triple_integrator_is_on_the_boundary() {
        for n in 2..=3 {
            // Rounding moves the eigenvalues off the axis by 1e-8, 1e-5, to both sides.
            let mut A = Mat::from_diagonal(&crate::Vector::from_fn(5, |i, _| if i < n { 0.0 } else { -(i as f64) }));
            for i in 1..n {
                A[(i - 1, i)] = 1.0;
            }
            let Q = Draw(22).matrix(5, 5).qr().q();
            let one = Mat::from_element(5, 1, 1.0);
            let A = &Q * A * Q.transpose();
            for (A, time) in [
                (A.clone(), Time::Continuous),
                (crate::exponential::exponential(&(A * 0.5)), Time::Sampled { period_s: 0.5 }),
            ] {
                let G = StateSpace::new(A, one.clone(), one.transpose(), Mat::zeros(1, 1), time).unwrap();
                assert!(matches!(stable_antistable(&G), Err(Error::BoundaryPole { .. })), "{n} {time}");
            }
        }
    }

    #[test]
    fn an_integrator_is_on_the_boundary() {
        let one = Mat::from_element(1, 1, 1.0);
        let D = Mat::zeros(1, 1);
        let G = StateSpace::new(Mat::zeros(1, 1), one.clone(), one.clone(), D.clone(), Time::Continuous).unwrap();
        assert_eq!(stable_antistable(&G), Err(Error::BoundaryPole { re: 0.0, im: 0.0 }));
        let G = StateSpace::new(one.clone(), one.clone(), one, D, Time::Sampled { period_s: 1.0 }).unwrap();
        assert_eq!(stable_antistable(&G), Err(Error::BoundaryPole { re: 1.0, im: 0.0 }));
    }
}
