//! Hankel singular values: how much of the input each state carries to the output.
//!
//! Enters: a stable or an antistable system. Leaves: its Hankel singular values.
//! Deliberately absent: optimal Hankel-norm approximation.

use crate::gramian::{controllability_factor, observability_factor};
use crate::sampling::to_w;
use crate::split::{expect_no_boundary_pole, is_stable};
use crate::{Error, Mat, StateSpace, Time};

/// Square roots of the eigenvalues of P Q, P and Q the Gramians of a stable system, descending.
///
/// Errors: [`Error::WrongSide`], [`Error::BoundaryPole`] for a pole that is not stable; those of [`controllability_factor`].
/// Numerics: singular values of L_Q' L_P, P = L_P L_P' and Q = L_Q L_Q' never formed: each is known to a few eps of the largest,
/// times the condition of the Lyapunov equations.
/// Source: Moore 1981; Hammarling 1982 for the factors.
pub fn hankel_singular_values(G: &StateSpace) -> Result<Vec<f64>, Error> {
    let (L_P, L_Q) = (controllability_factor(G)?, observability_factor(G)?);
    if G.order() == 0 {
        return Ok(Vec::new());
    }
    Ok(L_Q.tr_mul(&L_P).singular_values().iter().copied().collect())
}

/// Hankel singular values of an antistable system, that is of G(-s) or G(1/z), descending.
///
/// The smallest one of the antistable part of a plant is the largest additive perturbation that a controller can survive.
///
/// Errors: [`Error::WrongSide`], [`Error::BoundaryPole`] for a pole that is not antistable; those of [`controllability_factor`].
/// Source: Glover 1986.
///
/// ```
/// use flexbeam_lti::{Mat, StateSpace, Time, hankel::antistable_hankel_singular_values, split::stable_antistable};
/// // The paper's plant (18), voltage to tip angle, on the axis shifted by 12: DESIGN section 6.
/// let A = Mat::from_row_slice(4, 4, &[
///     0.0, 0.0, 1.0, 0.0,  0.0, 0.0, 0.0, 1.0,  0.0, 1060.8, -57.7, 0.0,  0.0, -1465.2, 57.7, 0.0,
/// ]);
/// let B = Mat::from_column_slice(4, 1, &[0.0, 0.0, 107.39, -107.39]);
/// let C = Mat::from_row_slice(1, 4, &[1.0, 1.0, 0.0, 0.0]);
/// let plant = StateSpace::new(A, B, C, Mat::zeros(1, 1), Time::Continuous)?;
/// let (_, antistable) = stable_antistable(&plant.shifted(12.0))?;
/// let radius = antistable_hankel_singular_values(&antistable)?[2];
/// assert!((radius - 0.0709455).abs() < 1e-7);
/// # Ok::<(), flexbeam_lti::Error>(())
/// ```
pub fn antistable_hankel_singular_values(G: &StateSpace) -> Result<Vec<f64>, Error> {
    let poles = expect_no_boundary_pole(G)?;
    if let Some(p) = poles.iter().find(|p| is_stable(**p, G.time)) {
        return Err(Error::WrongSide { re: p.re, im: p.im, needed: "antistable" });
    }
    hankel_singular_values(&mirrored(G)?)
}

/// G(-s) without D, which Hankel singular values do not see; a sampled system in the w-plane, which keeps them.
fn mirrored(G: &StateSpace) -> Result<StateSpace, Error> {
    let W = match G.time {
        Time::Continuous => G.clone(),
        Time::Sampled { .. } => to_w(G)?,
    };
    StateSpace::new(-W.A, -W.B, W.C, Mat::zeros(G.outputs(), G.inputs()), Time::Continuous)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Draw;
    use crate::split::stable_antistable;
    use crate::sylvester::lyapunov;

    fn siso(A: Mat, B: &[f64], C: &[f64], time: Time) -> StateSpace {
        let n = A.nrows();
        let (B, C) = (Mat::from_column_slice(n, 1, B), Mat::from_row_slice(1, n, C));
        StateSpace::new(A, B, C, Mat::zeros(1, 1), time).unwrap()
    }

    #[test]
    fn first_order_closed_forms() {
        // b c/(s + a): b c/(2 a). b c/(z - a): b c/(1 - a^2).
        let G = siso(Mat::from_element(1, 1, -0.5), &[3.0], &[2.0], Time::Continuous);
        assert!((hankel_singular_values(&G).unwrap()[0] - 6.0).abs() < 1e-13);
        let G = siso(Mat::from_element(1, 1, 0.5), &[3.0], &[2.0], Time::Sampled { period_s: 1.0 });
        assert!((hankel_singular_values(&G).unwrap()[0] - 8.0).abs() < 1e-13);
        // 1/(z - 2) mirrored is z/(1 - 2 z) = -1/2 - (1/4)/(z - 1/2): (1/4)/(3/4).
        let G = siso(Mat::from_element(1, 1, 2.0), &[1.0], &[1.0], Time::Sampled { period_s: 1.0 });
        assert!((antistable_hankel_singular_values(&G).unwrap()[0] - 1.0 / 3.0).abs() < 1e-14);
    }

    #[test]
    fn second_order_closed_form() {
        // omega^2/(s^2 + 2 zeta omega s + omega^2). The cross Gramian has trace G(0)/2 and eigenvalues
        // sigma_1, -sigma_2: sigma_1 - sigma_2 = 1/2, sigma_1 sigma_2 = 1/(16 zeta^2).
        for zeta in [0.7, 0.05, 1e-4] {
            let omega: f64 = 25.0;
            let A = Mat::from_row_slice(2, 2, &[0.0, 1.0, -omega * omega, -2.0 * zeta * omega]);
            let G = siso(A, &[0.0, omega * omega], &[1.0, 0.0], Time::Continuous);
            let sigma = hankel_singular_values(&G).unwrap();
            assert!((sigma[0] - sigma[1] - 0.5).abs() < 1e-11 * sigma[0], "{sigma:?}");
            assert!((sigma[0] * sigma[1] * 16.0 * zeta * zeta - 1.0).abs() < 1e-11, "{sigma:?}");
        }
    }

    #[test]
    fn a_value_far_below_the_square_root_of_rounding_is_known() {
        // As above, heavily damped: sigma_2 = 1/(16 zeta^2 sigma_1) = 1.25e-11, lost when Gramians are formed.
        let (zeta, omega) = (1e5, 25.0f64);
        let A = Mat::from_row_slice(2, 2, &[0.0, 1.0, -omega * omega, -2.0 * zeta * omega]);
        let sigma = hankel_singular_values(&siso(A, &[0.0, omega * omega], &[1.0, 0.0], Time::Continuous)).unwrap();
        assert!((sigma[1] * 8.0 * zeta * zeta - 1.0).abs() < 1e-4, "{sigma:?}");
    }

    #[test]
    fn an_all_pass_system_has_only_ones() {
        let mut draw = Draw(31);
        let n = 6;
        let A = draw.stable(n, 0.2);
        let B = draw.matrix(n, 1);
        let P = lyapunov(&A, &(&B * B.transpose())).unwrap();
        // C = B' P^-1, D = -1 is all-pass (Glover 1984).
        let C = P.lu().solve(&B).unwrap();
        let G = siso(A, B.as_slice(), C.as_slice(), Time::Continuous);
        for sigma in hankel_singular_values(&G).unwrap() {
            assert!((sigma - 1.0).abs() < 1e-11, "{sigma}");
        }
    }

    /// Plant (18), psi = theta + alpha.
    fn paper_plant() -> StateSpace {
        let A =
            Mat::from_row_slice(4, 4, &[0., 0., 1., 0., 0., 0., 0., 1., 0., 1060.8, -57.7, 0., 0., -1465.2, 57.7, 0.]);
        siso(A, &[0., 0., 107.39, -107.39], &[1., 1., 0., 0.], Time::Continuous)
    }

    #[test]
    fn robust_radii_of_the_paper_plant() {
        // DESIGN section 6.
        for (beta, radius) in [(2.0, 0.4652946), (5.0, 0.1861179), (12.0, 0.0709455), (15.0, 0.0299731)] {
            let (_, antistable) = stable_antistable(&paper_plant().shifted(beta)).unwrap();
            let smallest = *antistable_hankel_singular_values(&antistable).unwrap().last().unwrap();
            println!("beta = {beta}: {smallest:.12}");
            assert!((smallest - radius).abs() < 1e-6, "beta = {beta}: {smallest:.12}");
        }
    }

    #[test]
    fn a_sampled_system_by_fast_sampling_and_by_its_mirror() {
        let G = siso(
            Mat::from_diagonal(&crate::Vector::from_row_slice(&[0.3, -0.6])),
            &[1.0, 2.0],
            &[1.0, -1.0],
            Time::Sampled { period_s: 1.0 },
        );
        // Hankel matrix of the impulse response, long enough for 0.6^60.
        let impulse = |k: i32| 0.3f64.powi(k) - 2.0 * (-0.6f64).powi(k);
        let H = Mat::from_fn(60, 60, |i, j| impulse((i + j) as i32));
        let known = H.singular_values();
        for (sigma, known) in hankel_singular_values(&G).unwrap().iter().zip(known.iter()) {
            assert!((sigma - known).abs() < 1e-12 * known, "{sigma} {known}");
        }
    }

    #[test]
    fn no_states_no_values_and_wrong_sides_are_named() {
        let G = StateSpace::static_gain(Mat::identity(2, 2), Time::Continuous).unwrap();
        assert_eq!(hankel_singular_values(&G).unwrap(), Vec::<f64>::new());
        let G = siso(Mat::from_element(1, 1, 1.0), &[1.0], &[1.0], Time::Continuous);
        assert!(matches!(hankel_singular_values(&G), Err(Error::WrongSide { needed: "stable", .. })));
        assert!(matches!(
            antistable_hankel_singular_values(&siso(-G.A, &[1.0], &[1.0], Time::Continuous)),
            Err(Error::WrongSide { .. })
        ));
    }

    #[test]
    fn fifty_states_in_any_coordinates() {
        let mut draw = Draw(32);
        let A = draw.stable(50, 0.05);
        let G = StateSpace::new(A, draw.matrix(50, 3), draw.matrix(2, 50), Mat::zeros(2, 3), Time::Continuous).unwrap();
        let sigma = hankel_singular_values(&G).unwrap();
        assert!(sigma.windows(2).all(|pair| pair[0] >= pair[1]));
        let V = draw.matrix(50, 50).qr().q();
        let H = StateSpace::new(V.tr_mul(&G.A) * &V, V.tr_mul(&G.B), &G.C * &V, G.D, Time::Continuous).unwrap();
        for (one, two) in sigma.iter().zip(hankel_singular_values(&H).unwrap()) {
            assert!((one - two).abs() < 1e-13 * sigma[0]);
        }
    }
}
