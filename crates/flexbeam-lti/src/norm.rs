//! Norms of systems: the largest gain over frequency, and the energy of the impulse response.
//!
//! Enters: a system. Leaves: its L-infinity, H-infinity or H2 norm.
//! Deliberately absent: grids of frequencies.

use crate::sampling::to_w;
use crate::schur::{balanced, spectrum};
use crate::split::{balanced_states, expect_no_boundary_pole, expect_stable};
use crate::sylvester::{discrete_lyapunov, lyapunov};
use crate::{C64, Error, Mat, StateSpace, Time};

/// The peak is closed in when no gain exceeds it by more than this, relative; the level set then lies within
/// 1e-5 of the peak's width, well above what eigenvalues of the Hamiltonian resolve.
const LEVEL: f64 = 1e-10;
/// Hamiltonian eigenvalues this near to the axis, relative to the balanced Hamiltonian, are taken as crossings. Generous,
/// about 60 sqrt(eps), since a double one is known to sqrt(eps): a false crossing costs one evaluation of G, a missed one the answer.
const NEAR_AXIS: f64 = 1e-6;
/// Level sets tried; convergence is quadratic, four are typical.
const LEVELS: usize = 60;

/// The largest gain and where it is reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeakGain {
    /// Largest singular value over frequency; attained at `omega_rad_s`, and exceeded nowhere by more than 2e-10 relative.
    pub norm: f64,
    /// Where it is reached [rad/s]; infinite, or pi/Ts, at the end of the axis.
    pub omega_rad_s: f64,
    /// Hamiltonian eigenvalue problems solved.
    pub iterations: usize,
}

/// sup over w of the largest singular value of G(jw), or of G(e^(jwTs)); poles may lie on both sides.
///
/// Errors: [`Error::BoundaryPole`] for a pole on the axis or the unit circle; [`Error::NotConverged`].
/// Numerics: about five eigenvalue problems of order 2n. Sampled systems go through the w-plane.
/// Source: Bruinsma and Steinbuch 1990; Boyd and Balakrishnan 1990. Differs: crossings are taken generously and every interval
/// between two is probed, so that the verdict rests on values of G, not on a tolerance.
pub fn linf_norm(G: &StateSpace) -> Result<PeakGain, Error> {
    let poles = expect_no_boundary_pole(G)?;
    match G.time {
        Time::Continuous => peak_gain(&balanced_states(G), &poles),
        Time::Sampled { period_s } => {
            let W = balanced_states(&to_w(G)?);
            let peak = peak_gain(&W, &spectrum(&W.A)?)?;
            let omega_rad_s = 2.0 / period_s * (0.5 * period_s * peak.omega_rad_s).atan();
            Ok(PeakGain { omega_rad_s, ..peak })
        }
    }
}

/// [`linf_norm`] of a stable system.
///
/// Errors: also [`Error::WrongSide`] for a pole that is not stable.
///
/// ```
/// use flexbeam_lti::{Mat, StateSpace, Time, norm::hinf_norm};
/// // 1/(s^2 + 0.02 s + 1): 1/(2 zeta sqrt(1 - zeta^2)) at sqrt(1 - 2 zeta^2).
/// let A = Mat::from_row_slice(2, 2, &[0.0, 1.0, -1.0, -0.02]);
/// let (B, C) = (Mat::from_column_slice(2, 1, &[0.0, 1.0]), Mat::from_row_slice(1, 2, &[1.0, 0.0]));
/// let peak = hinf_norm(&StateSpace::new(A, B, C, Mat::zeros(1, 1), Time::Continuous)?)?;
/// assert!((peak.norm - 50.0025001875).abs() < 1e-7 && (peak.omega_rad_s - 0.9999).abs() < 1e-6);
/// # Ok::<(), flexbeam_lti::Error>(())
/// ```
pub fn hinf_norm(G: &StateSpace) -> Result<PeakGain, Error> {
    expect_stable(G)?;
    linf_norm(G)
}

/// sqrt(trace(C P C' + D D')), P the controllability Gramian; D counts in sampled time only.
///
/// Returns infinity for a continuous system with D not zero.
/// Errors: [`Error::WrongSide`], [`Error::BoundaryPole`] for a pole that is not stable; those of [`lyapunov`].
pub fn h2_norm(G: &StateSpace) -> Result<f64, Error> {
    expect_stable(G)?;
    let Q = &G.B * G.B.transpose();
    let energy = match G.time {
        Time::Continuous if G.D.amax() > 0.0 => f64::INFINITY,
        Time::Continuous => (&G.C * lyapunov(&G.A, &Q)? * G.C.transpose()).trace(),
        Time::Sampled { .. } => (&G.C * discrete_lyapunov(&G.A, &Q)? * G.C.transpose()).trace() + G.D.norm_squared(),
    };
    Ok(energy.max(0.0).sqrt())
}

fn peak_gain(G: &StateSpace, poles: &[C64]) -> Result<PeakGain, Error> {
    let mut peak = first_guess(G, poles);
    if peak.norm == 0.0 {
        return Ok(peak);
    }
    for iterations in 1..=LEVELS {
        peak.iterations = iterations;
        let level = peak.norm * (1.0 + 2.0 * LEVEL);
        let probes = midpoints(&crossings(G, level)?);
        let best = highest(G, probes.into_iter());
        if best.norm <= level {
            let better = if best.norm > peak.norm { best } else { peak };
            return Ok(PeakGain { iterations, ..better });
        }
        peak = best;
    }
    Err(Error::NotConverged { what: "the level sets of the peak gain", iterations: LEVELS })
}

/// The highest gain at the ends of the axis, at the poles' frequencies, and at as many more points as an entry has
/// zeros: if it is zero there, it is zero.
fn first_guess(G: &StateSpace, poles: &[C64]) -> PeakGain {
    let size = poles.iter().map(|p| p.norm()).fold(0.0, f64::max);
    let spread = (1..=G.order()).map(|k| size * k as f64 / (G.order() + 1) as f64);
    let resonances = poles.iter().flat_map(|p| [p.im.abs(), p.norm()]);
    highest(G, [0.0, f64::INFINITY].into_iter().chain(resonances).chain(spread))
}

fn highest(G: &StateSpace, omegas: impl Iterator<Item = f64>) -> PeakGain {
    let mut peak = PeakGain { norm: 0.0, omega_rad_s: 0.0, iterations: 0 };
    for omega_rad_s in omegas {
        let norm = gain(G, omega_rad_s);
        if norm > peak.norm {
            peak = PeakGain { norm, omega_rad_s, ..peak };
        }
    }
    peak
}

/// Largest singular value of G(jw).
fn gain(G: &StateSpace, omega_rad_s: f64) -> f64 {
    if G.D.is_empty() {
        return 0.0;
    }
    if omega_rad_s.is_infinite() {
        return G.D.singular_values()[0];
    }
    let value = G.at(C64::new(0.0, omega_rad_s));
    if value.len() == 1 { value[0].norm() } else { value.singular_values()[0] }
}

/// Frequencies where a singular value of G may equal the level, ascending.
fn crossings(G: &StateSpace, level: f64) -> Result<Vec<f64>, Error> {
    let H = balanced(&hamiltonian(G, level)).0;
    let near = NEAR_AXIS * H.norm();
    let on_axis = spectrum(&H)?.into_iter().filter(|p| p.im >= 0.0 && p.re.abs() <= near);
    let mut omegas: Vec<f64> = on_axis.map(|p| p.im).collect();
    omegas.sort_by(f64::total_cmp);
    Ok(omegas)
}

/// Has the eigenvalue jw exactly when a singular value of G(jw) is gamma. gamma > the largest singular value of D.
///
/// Source: Boyd and Balakrishnan 1990, eq. 2.3.
fn hamiltonian(G: &StateSpace, gamma: f64) -> Mat {
    let (n, m, l) = (G.order(), G.inputs(), G.outputs());
    let R = Mat::from_diagonal_element(m, m, gamma) - G.D.tr_mul(&G.D) / gamma;
    let S = Mat::from_diagonal_element(l, l, gamma) - &G.D * G.D.transpose() / gamma;
    let solve = |M: Mat, X: &Mat| M.cholesky().expect("the level is above the gain at infinite frequency").solve(X);
    let RB = solve(R.clone(), &G.B.transpose());
    let F = &G.A + RB.tr_mul(&G.D.tr_mul(&G.C)) / gamma;
    let mut H = Mat::zeros(2 * n, 2 * n);
    H.view_mut((0, 0), (n, n)).copy_from(&F);
    H.view_mut((0, n), (n, n)).copy_from(&(&G.B * &RB));
    H.view_mut((n, 0), (n, n)).copy_from(&-(G.C.tr_mul(&solve(S, &G.C))));
    H.view_mut((n, n), (n, n)).copy_from(&-F.transpose());
    H
}

/// A point inside each interval, geometric where both ends are positive.
fn midpoints(omegas: &[f64]) -> Vec<f64> {
    let middle = |pair: &[f64]| if pair[0] > 0.0 { (pair[0] * pair[1]).sqrt() } else { 0.5 * pair[1] };
    omegas.windows(2).map(middle).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Draw;

    fn resonance(zeta: f64, omega: f64) -> StateSpace {
        let A = Mat::from_row_slice(2, 2, &[0.0, 1.0, -omega * omega, -2.0 * zeta * omega]);
        let (B, C) = (Mat::from_column_slice(2, 1, &[0.0, omega * omega]), Mat::from_row_slice(1, 2, &[1.0, 0.0]));
        StateSpace::new(A, B, C, Mat::zeros(1, 1), Time::Continuous).unwrap()
    }

    fn random(draw: &mut Draw, n: usize, inputs: usize, outputs: usize) -> StateSpace {
        let A = draw.stable(n, 0.02);
        let (B, C, D) = (draw.matrix(n, inputs), draw.matrix(outputs, n), draw.matrix(outputs, inputs));
        StateSpace::new(A, B, C, D, Time::Continuous).unwrap()
    }

    #[test]
    fn a_resonance_peaks_where_the_book_says() {
        for zeta in [0.6, 0.1, 1e-2, 1e-4, 1e-6] {
            for omega in [1e-6, 1.0, 25.0, 1e6] {
                let peak = hinf_norm(&resonance(zeta, omega)).unwrap();
                let known = 0.5 / (zeta * (1.0 - zeta * zeta).sqrt());
                let at = omega * (1.0 - 2.0 * zeta * zeta).sqrt();
                assert!((peak.norm / known - 1.0).abs() < 3e-10, "{zeta} {omega}: {}", peak.norm / known - 1.0);
                assert!((peak.omega_rad_s / at - 1.0).abs() < 1e-4, "{zeta} {omega}: {peak:?}");
                assert!(peak.iterations <= 6, "{peak:?}");
            }
        }
    }

    #[test]
    fn no_frequency_lies_above_and_one_is_equal() {
        let mut draw = Draw(51);
        for (n, inputs, outputs) in [(1, 1, 1), (2, 2, 1), (3, 1, 3), (6, 2, 2), (10, 3, 2), (20, 1, 1)] {
            for _ in 0..5 {
                let G = random(&mut draw, n, inputs, outputs);
                let peak = hinf_norm(&G).unwrap();
                assert!((gain(&G, peak.omega_rad_s) / peak.norm - 1.0).abs() < 1e-9);
                let swept = highest(&G, (0..400).map(|k| 10f64.powf(-3.0 + 5.0 * f64::from(k) / 400.0)));
                assert!(swept.norm <= peak.norm * (1.0 + 3e-10), "{n}: {swept:?} above {peak:?}");
                assert!(swept.norm >= 0.9 * peak.norm || peak.omega_rad_s.is_infinite() || peak.omega_rad_s < 1e-3);
            }
        }
    }

    #[test]
    fn fifty_states_and_a_hidden_narrow_peak() {
        // A weak mode of damping 1e-4 among fifty states: a grid misses it by far.
        let mut draw = Draw(52);
        let mut G = random(&mut draw, 48, 1, 1);
        let mode = resonance(1e-4, 3.3);
        let broad = hinf_norm(&G).unwrap();
        G.A = G.A.resize(50, 50, 0.0);
        G.A.view_mut((48, 48), (2, 2)).copy_from(&mode.A);
        G.B = crate::blocks::stack(&G.B, &mode.B);
        G.C = crate::blocks::beside(&G.C, &(&mode.C * (broad.norm * 1e-3)));
        let peak = hinf_norm(&G).unwrap();
        assert!((peak.omega_rad_s - 3.3).abs() < 1e-3, "{peak:?}");
        assert!(peak.norm > 3.0 * broad.norm && peak.norm < 7.0 * broad.norm, "{peak:?} {broad:?}");
        assert!(peak.iterations <= 8);
    }

    #[test]
    fn all_pass_systems_have_their_constant() {
        // (s^2 - 2 zeta w s + w^2)/(s^2 + 2 zeta w s + w^2) = 1 - 4 zeta w s/(...).
        for (zeta, omega) in [(0.5, 1.0), (1e-4, 100.0)] {
            let mut G = resonance(zeta, omega);
            G.B = Mat::from_column_slice(2, 1, &[0.0, 1.0]);
            G.C = Mat::from_row_slice(1, 2, &[0.0, -4.0 * zeta * omega]);
            G.D = Mat::from_element(1, 1, 1.0);
            let peak = hinf_norm(&G).unwrap();
            assert!((peak.norm - 1.0).abs() < 1e-9, "{peak:?}");
        }
    }

    #[test]
    fn antistable_parts_count_in_linf_and_are_refused_in_hinf() {
        // 1/(s + 1) - 1/(s - 1) is 2/(1 + w^2) on the axis.
        let A = Mat::from_row_slice(2, 2, &[-1.0, 0.0, 0.0, 1.0]);
        let (B, C) = (Mat::from_element(2, 1, 1.0), Mat::from_row_slice(1, 2, &[1.0, -1.0]));
        let G = StateSpace::new(A, B, C, Mat::zeros(1, 1), Time::Continuous).unwrap();
        let peak = linf_norm(&G).unwrap();
        assert!((peak.norm - 2.0).abs() < 1e-9 && peak.omega_rad_s == 0.0, "{peak:?}");
        assert_eq!(hinf_norm(&G), Err(Error::WrongSide { re: 1.0, im: 0.0, needed: "stable" }));
        let axis = resonance(0.0, 7.0);
        assert!(matches!(linf_norm(&axis), Err(Error::BoundaryPole { im, .. }) if (im.abs() - 7.0).abs() < 1e-12));
    }

    #[test]
    fn the_peak_of_a_sampled_system_is_on_the_circle() {
        // 1/(z - a): largest at z = 1 for a > 0, at z = -1 for a < 0.
        for (a, omega) in [(0.9, 0.0), (-0.5, std::f64::consts::PI / 0.01)] {
            let one = Mat::from_element(1, 1, 1.0);
            let time = Time::Sampled { period_s: 0.01 };
            let G = StateSpace::new(&one * a, one.clone(), one.clone(), &one * 0.0, time).unwrap();
            let peak = hinf_norm(&G).unwrap();
            assert!((peak.norm * (1.0 - a.abs()) - 1.0).abs() < 1e-9, "{peak:?}");
            assert!((peak.omega_rad_s - omega).abs() < 1e-9 * (1.0 + omega), "{peak:?}");
        }
        let mut draw = Draw(53);
        for n in [2, 5, 9] {
            let A = draw.matrix(n, n) * (0.9 / (n as f64).sqrt());
            let (B, C, D) = (draw.matrix(n, 2), draw.matrix(2, n), draw.matrix(2, 2));
            let G = StateSpace::new(A, B, C, D, Time::Sampled { period_s: 1.0 }).unwrap();
            let peak = linf_norm(&G).unwrap();
            let on_circle = |omega: f64| G.at(C64::from_polar(1.0, omega)).singular_values()[0];
            assert!((on_circle(peak.omega_rad_s) / peak.norm - 1.0).abs() < 1e-9);
            let swept = (0..=3000).map(|k| on_circle(std::f64::consts::PI * f64::from(k) / 3000.0)).fold(0.0, f64::max);
            assert!(swept <= peak.norm * (1.0 + 3e-10) && swept > 0.99 * peak.norm);
        }
    }

    #[test]
    fn static_empty_and_zero_systems() {
        let G = StateSpace::static_gain(Mat::from_row_slice(1, 2, &[3.0, 4.0]), Time::Continuous).unwrap();
        assert!((hinf_norm(&G).unwrap().norm - 5.0).abs() < 1e-14);
        assert_eq!(h2_norm(&G).unwrap(), f64::INFINITY);
        let mut zero = resonance(0.1, 1.0);
        zero.C *= 0.0;
        assert_eq!(hinf_norm(&zero).unwrap().norm, 0.0);
        let empty = StateSpace::static_gain(Mat::zeros(0, 2), Time::Continuous).unwrap();
        assert_eq!(hinf_norm(&empty).unwrap().norm, 0.0);
    }

    #[test]
    fn the_difference_of_equal_systems_is_rounding() {
        let mut draw = Draw(54);
        for n in [2, 7, 15] {
            let G = random(&mut draw, n, 1, 1);
            let V = draw.matrix(n, n).qr().q();
            let mut difference = G.clone();
            difference.A = crate::blocks::diagonal(&G.A, &(V.tr_mul(&G.A) * &V));
            difference.B = crate::blocks::stack(&G.B, &V.tr_mul(&G.B));
            difference.C = crate::blocks::beside(&G.C, &-(&G.C * &V));
            difference.D *= 0.0;
            let peak = hinf_norm(&difference).unwrap();
            assert!(peak.norm < 1e-12 * hinf_norm(&G).unwrap().norm, "{peak:?}");
        }
    }

    #[test]
    fn h2_norm_is_the_energy_of_the_impulse_response() {
        // omega^2/(s^2 + 2 zeta omega s + omega^2): sqrt(omega/(4 zeta)).
        for (zeta, omega) in [(0.5f64, 1.0f64), (1e-4, 25.0)] {
            let known = (0.25 * omega / zeta).sqrt();
            assert!((h2_norm(&resonance(zeta, omega)).unwrap() / known - 1.0).abs() < 1e-11);
        }
        let mut draw = Draw(55);
        let A = draw.matrix(4, 4) * 0.3;
        let (B, C, D) = (draw.matrix(4, 2), draw.matrix(3, 4), draw.matrix(3, 2));
        let mut energy = D.norm_squared();
        let mut AB = B.clone();
        for _ in 0..200 {
            energy += (&C * &AB).norm_squared();
            AB = &A * AB;
        }
        let G = StateSpace::new(A, B, C, D, Time::Sampled { period_s: 0.1 }).unwrap();
        assert!((h2_norm(&G).unwrap().powi(2) / energy - 1.0).abs() < 1e-13);
    }
}
