//! Gain, phase, delay and disk margins of a scalar loop, from eigenvalues: no frequency grid.
//!
//! |L(jw)| = 1 where the Hamiltonian of L at level one has an eigenvalue jw; Im L(jw) = 0 where L(s) - L(-s) has a zero jw.
//! Each candidate is then polished on L itself.

use flexbeam_lti::equilibration::equilibrated;
use flexbeam_lti::norm::linf_norm;
use flexbeam_lti::response::Hessenberg;
use flexbeam_lti::schur::spectrum;
use flexbeam_lti::zeros::transmission_zeros;
use flexbeam_lti::{C64, Mat, StateSpace, Time, connections, sampling};

use crate::Error;

/// Margins of the loop gain L = G K; infinite where nothing limits them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Factor by which the gain may grow, all else equal.
    pub gain: f64,
    /// Angle by which the phase may lag [rad].
    pub phase_rad: f64,
    /// Delay that may be added [s].
    pub delay_s: f64,
    /// Radius of the disk around 1 of factors 1 + d/2 over 1 - d/2, |d| below it, that the loop survives: 2/||S - T||.
    /// Source: Seiler, Packard, Gahinet 2020, with skew 0.
    pub disk: f64,
}

/// Margins of a stable loop of plant G and controller K, u = -K y, both in one time axis.
///
/// Numerics: eigenvalues of matrices of twice the loop's order; candidates count as lying on the axis within
/// `NEAR_AXIS` and are polished by the secant method on the loop gain.
pub fn margins(G: &StateSpace, K: &StateSpace) -> Result<Margins, Error> {
    let L = connections::series(K, G)?;
    let half_plane = match L.time {
        Time::Continuous => equilibrated(&L),
        Time::Sampled { .. } => equilibrated(&sampling::to_w(&L)?),
    };
    let response = Hessenberg::new(&half_plane);
    let at = |v: f64| response.at(C64::new(0.0, v))[(0, 0)];
    let mut margins = Margins { gain: f64::INFINITY, phase_rad: f64::INFINITY, delay_s: f64::INFINITY, disk: 0.0 };
    for v in polished(unit_gain_candidates(&half_plane)?, |v| at(v).norm().ln()) {
        let phase = (-at(v)).arg().rem_euclid(std::f64::consts::TAU);
        margins.phase_rad = margins.phase_rad.min(phase);
        margins.delay_s = margins.delay_s.min(phase / omega_rad_s(v, L.time));
    }
    let crossings = polished(real_candidates(&half_plane)?, |v| at(v).im / at(v).norm());
    // L is real at both ends of the axis, which no eigenvalue finds: s = 0 or z = 1, and z = -1.
    let ends = [at(0.0).re, half_plane.D[(0, 0)]];
    for factor in crossings.into_iter().map(|v| at(v).re).chain(ends).map(|L| -1.0 / L) {
        if factor.is_finite() && factor > 1.0 {
            margins.gain = margins.gain.min(factor);
        }
    }
    margins.disk = disk_margin(&half_plane)?;
    Ok(margins)
}

/// A root this close to the axis, relative to its size, is tried; the polishing decides.
const NEAR_AXIS: f64 = 1e-3;

/// The frequency that belongs to w = jv: v = (2/Ts) tan(omega Ts/2).
fn omega_rad_s(v: f64, time: Time) -> f64 {
    match time {
        Time::Continuous => v,
        Time::Sampled { period_s } => 2.0 / period_s * (v * period_s / 2.0).atan(),
    }
}

/// Frequencies at which |L| may be one: imaginary eigenvalues of the Hamiltonian of L at level one.
fn unit_gain_candidates(L: &StateSpace) -> Result<Vec<f64>, Error> {
    let (n, d) = (L.order(), L.D[(0, 0)]);
    let r = 1.0 - d * d;
    if r == 0.0 {
        return Ok(vec![]);
    }
    let F = &L.A + &L.B * &L.C * (d / r);
    let mut H = Mat::zeros(2 * n, 2 * n);
    H.view_mut((0, 0), (n, n)).copy_from(&F);
    H.view_mut((0, n), (n, n)).copy_from(&(&L.B * L.B.transpose() / r));
    H.view_mut((n, 0), (n, n)).copy_from(&(L.C.transpose() * &L.C / -r));
    H.view_mut((n, n), (n, n)).copy_from(&-F.transpose());
    // Balanced: L may carry its gain in B or in C, and the two squares stand in opposite corners.
    Ok(near_axis(spectrum(&H)?.into_iter()))
}

/// Frequencies at which L may be real: zeros of L(s) - L(-s) on the axis.
fn real_candidates(L: &StateSpace) -> Result<Vec<f64>, Error> {
    let n = L.order();
    let mut A = Mat::zeros(2 * n, 2 * n);
    A.view_mut((0, 0), (n, n)).copy_from(&L.A);
    A.view_mut((n, n), (n, n)).copy_from(&-&L.A);
    let B = Mat::from_fn(2 * n, 1, |i, _| L.B[i % n]);
    let C = Mat::from_fn(1, 2 * n, |_, j| L.C[j % n]);
    let odd = StateSpace::new(A, B, C, Mat::zeros(1, 1), Time::Continuous)?;
    Ok(near_axis(transmission_zeros(&odd)?.into_iter()))
}

fn near_axis(roots: impl Iterator<Item = C64>) -> Vec<f64> {
    roots.filter(|s| s.im > 0.0 && s.re.abs() <= NEAR_AXIS * s.norm()).map(|s| s.im).collect()
}

/// Roots of f near the candidates, by the secant method; what does not converge was no root.
fn polished(candidates: Vec<f64>, f: impl Fn(f64) -> f64) -> Vec<f64> {
    candidates.into_iter().filter_map(|v| secant(v, &f)).collect()
}

fn secant(start: f64, f: &impl Fn(f64) -> f64) -> Option<f64> {
    let (mut a, mut b) = (start * (1.0 - NEAR_AXIS), start * (1.0 + NEAR_AXIS));
    let (mut fa, mut fb) = (f(a), f(b));
    for _ in 0..SECANT_STEPS {
        if fb == fa || (b - a).abs() <= 1e-13 * b.abs() {
            break;
        }
        let next = b - fb * (b - a) / (fb - fa);
        (a, fa) = (b, fb);
        b = next;
        fb = f(b);
    }
    let is_root = fb.abs() <= ROOT && (b / start - 1.0).abs() <= 10.0 * NEAR_AXIS;
    is_root.then_some(b)
}

/// The candidates are roots to many digits when they are roots at all: a few steps suffice.
const SECANT_STEPS: usize = 20;

/// Residual that counts as zero of ln |L| or of the sine of L's phase.
const ROOT: f64 = 1e-8;

/// 2/||S - T||, S - T = (1 - L)/(1 + L).
fn disk_margin(L: &StateSpace) -> Result<f64, Error> {
    let time = L.time;
    let one = StateSpace::static_gain(Mat::from_element(1, 1, 1.0), time)?;
    let sensitivity = connections::feedback(&one, L)?;
    let doubled = connections::series(&sensitivity, &StateSpace::static_gain(Mat::from_element(1, 1, 2.0), time)?)?;
    let minus_one = StateSpace::static_gain(Mat::from_element(1, 1, -1.0), time)?;
    Ok(2.0 / linf_norm(&connections::parallel(&doubled, &minus_one)?)?.norm)
}
