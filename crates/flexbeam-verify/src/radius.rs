//! The robust radius by a third road: definiteness of the Pick matrix, level by level, its data from contour integrals.
//!
//! Enters: a plant, alpha, beta, timing. Leaves: the largest additive perturbation that some controller survives.
//! Deliberately absent: Hankel singular values, eigenvectors, the w-plane.

use crate::{Error, Timing};
use flexbeam_lti::{C64, CMat, StateSpace, Zpk};

/// Radius of the continuous problem: Gbar0(s) = G0(s - beta), alpha(s).
///
/// Returns `None` when nothing lies right of Re s = -beta.
/// Errors: [`Error::PoleOnLine`], [`Error::RepeatedPole`], [`Error::NotSettled`].
/// Source: Nevanlinna-Pick; DESIGN 6.1.
pub fn continuous_radius(nominal: &StateSpace, alpha: &Zpk, beta: f64) -> Result<Option<f64>, Error> {
    let points = points_right_of(nominal, beta)?;
    let mut values = Vec::with_capacity(points.len());
    for (i, &p) in points.iter().enumerate() {
        let residue = residue(nominal, p - beta);
        let slope = others(&points, i).fold((p + p.conj()).inv(), |x, q| x * (p - q) / (p + q.conj()));
        values.push(alpha.at(p) / (residue * slope));
    }
    let kernel = |p: C64, q: C64| (p + q.conj()).inv();
    radius(&points, &values, kernel)
}

/// Radius of the sampled problem: Gbar0(z) of the plant behind zero-order hold, delay and filter; alpha_w(w) in the w-plane.
///
/// Worked in the disk of 1/z, with the sampled residues from the continuous ones.
/// Errors: as [`continuous_radius`]; [`Error::Setting`] when the filter is slower than beta.
pub fn sampled_radius(nominal: &StateSpace, timing: Timing, alpha_w: &Zpk, beta: f64) -> Result<Option<f64>, Error> {
    timing.check()?;
    expect_fast_filter(timing, beta)?;
    let Ts = timing.period_s;
    let points = points_right_of(nominal, beta)?;
    let mut values = Vec::with_capacity(points.len());
    for (i, &p) in points.iter().enumerate() {
        let s = p - beta;
        // Residue of the held, delayed, filtered plant at z = e^(p Ts), in the shifted plane.
        let held = residue(nominal, s) * integral_of_exp(s, Ts) * (-s * timing.delay_s).exp();
        let residue = held * timing.filter(timing.z(s)).0 * (beta * Ts).exp();
        // B(z) = prod (z - z_q)/(1 - conj(z_q) z) has modulus 1 on the circle.
        let slope = others(&points, i).fold(-expm1((p + p.conj()) * Ts).inv(), |x, q| {
            -x * (q * Ts).exp() * expm1((p - q) * Ts) / expm1((p + q.conj()) * Ts)
        });
        let w = (p * (Ts / 2.0)).tanh() * (2.0 / Ts);
        values.push(alpha_w.at(w) / (residue * slope));
    }
    let kernel = |p: C64, q: C64| -expm1(-(p + q.conj()) * Ts).inv();
    radius(&points, &values, kernel)
}

/// Two poles nearer than this, relative to their size, have no residues of their own.
const COINCIDENT: f64 = 1e-7;
/// A pole this near to the line, relative to the largest pole, cannot be told from one on it.
const ON_LINE: f64 = 1e-11;

/// Poles p + beta with positive real part.
fn points_right_of(nominal: &StateSpace, beta: f64) -> Result<Vec<C64>, Error> {
    let poles = nominal.poles();
    let scale = poles.iter().map(|p| p.norm()).fold(0.0, f64::max);
    if let Some(p) = poles.iter().find(|p| (p.re + beta).abs() <= ON_LINE * scale) {
        return Err(Error::PoleOnLine { re: p.re, im: p.im, degree: beta });
    }
    let points: Vec<C64> = poles.iter().filter(|p| p.re + beta > 0.0).map(|p| p + beta).collect();
    for (i, p) in points.iter().enumerate() {
        if distance(poles.iter().map(|q| q + beta), *p) <= COINCIDENT * scale.min(p.norm()) {
            return Err(Error::RepeatedPole { re: points[i].re - beta, im: points[i].im });
        }
    }
    Ok(points)
}

/// Distance of p to the nearest of the poles but itself; a lone pole has all the room that there is.
fn distance(poles: impl Iterator<Item = C64>, p: C64) -> f64 {
    let mut distances: Vec<f64> = poles.map(|q| (q - p).norm()).collect();
    distances.sort_by(f64::total_cmp);
    distances.get(1).copied().unwrap_or(if p.norm() > 0.0 { p.norm() } else { 1.0 })
}

/// Points of the trapezoidal rule on a circle of half the distance to the next pole: the error is 2^-64.
const CIRCLE_POINTS: u32 = 64;

/// (1/2 pi j) times the integral of G around s.
fn residue(G: &StateSpace, s: C64) -> C64 {
    let radius = 0.5 * distance(G.poles().into_iter(), s);
    let around = |k: u32| C64::from_polar(radius, std::f64::consts::TAU * f64::from(k) / f64::from(CIRCLE_POINTS));
    (0..CIRCLE_POINTS).map(|k| G.at(s + around(k))[(0, 0)] * around(k)).sum::<C64>() / f64::from(CIRCLE_POINTS)
}

fn others(points: &[C64], i: usize) -> impl Iterator<Item = C64> + '_ {
    points.iter().enumerate().filter(move |(k, _)| *k != i).map(|(_, q)| *q)
}

/// e^x - 1.
///
/// Numerics: accurate relative to itself near 0, where poles of a fast sampled plant lie.
fn expm1(x: C64) -> C64 {
    let half = (0.5 * x.im).sin();
    C64::new(x.re.exp_m1() * x.im.cos() - 2.0 * half * half, x.re.exp() * x.im.sin())
}

/// (e^(s t) - 1)/s, the integral of e^(s t) from 0 to t.
fn integral_of_exp(s: C64, t: f64) -> C64 {
    if s.norm() * t < f64::EPSILON { C64::from(t) } else { expm1(s * t) / s }
}

fn expect_fast_filter(timing: Timing, beta: f64) -> Result<(), Error> {
    let name = "low-pass coefficient";
    let needed = "a filter faster than the stability degree, 1 - a < e^(-beta Ts)";
    let is_fast = 1.0 - timing.low_pass < timing.radius(beta);
    if is_fast { Ok(()) } else { Err(Error::Setting { name, value: timing.low_pass, needed }) }
}

/// Doublings of the level in search of an upper end.
const MOST_DOUBLINGS: i32 = 200;
/// Width of the bracket at the end: rounding.
const LEVEL: f64 = 4.0 * f64::EPSILON;

/// 1/level of the smallest level at which the Pick matrix is positive definite.
fn radius(points: &[C64], values: &[C64], kernel: impl Fn(C64, C64) -> C64) -> Result<Option<f64>, Error> {
    if points.is_empty() {
        return Ok(None);
    }
    let pick = |level: f64| {
        let entry = |i: usize, j: usize| (level * level - values[i] * values[j].conj()) * kernel(points[i], points[j]);
        CMat::from_fn(points.len(), points.len(), entry)
    };
    // No function takes a value larger than its norm.
    let mut low = values.iter().map(|w| w.norm()).fold(0.0, f64::max);
    let mut high = low;
    for doubling in 0.. {
        high *= 2.0;
        if is_positive_definite(pick(high)) {
            break;
        }
        low = high;
        if doubling == MOST_DOUBLINGS {
            return Err(Error::NotSettled { what: "the level of the Pick matrix", from: 0.0, to: high });
        }
    }
    while high - low > LEVEL * high {
        let middle = 0.5 * (low + high);
        if is_positive_definite(pick(middle)) { high = middle } else { low = middle }
    }
    Ok(Some(1.0 / high))
}

/// Whether a Hermitian matrix has a Cholesky factor.
fn is_positive_definite(mut P: CMat) -> bool {
    let n = P.nrows();
    for k in 0..n {
        let pivot = P[(k, k)].re;
        if !(pivot > 0.0) {
            return false;
        }
        for j in k + 1..n {
            let factor = P[(j, k)] / pivot;
            for i in j..n {
                let update = P[(i, k)] * factor.conj();
                P[(i, j)] -= update;
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use flexbeam_rig::{Lumped, Output};

    fn plant() -> StateSpace {
        Lumped::PAPER.state_space(&[Output::Psi]).unwrap()
    }

    fn constant(gain: f64) -> Zpk {
        Zpk { zeros: vec![], poles: vec![], gain }
    }

    #[test]
    fn radii_of_the_design_page() {
        for (beta, printed) in [(2.0, 0.4652946), (5.0, 0.1861179), (12.0, 0.0709455), (15.0, 0.0299731)] {
            let found = continuous_radius(&plant(), &constant(1.0), beta).unwrap().unwrap();
            assert!((found - printed).abs() < 6e-8, "{beta}: {found} {printed}");
        }
        let lead = Zpk { zeros: vec![C64::from(-20.0)], poles: vec![C64::from(-400.0)], gain: 0.02 * 20.0 };
        let found = continuous_radius(&plant(), &lead, 12.0).unwrap().unwrap();
        assert!((found - 2.2905406).abs() < 6e-8, "{found}");
    }

    #[test]
    fn sampled_radius_of_the_design_page() {
        let timing = Timing { period_s: 1e-3, delay_s: 1e-3, low_pass: 1.0 };
        let found = sampled_radius(&plant(), timing, &constant(1.0), 12.0).unwrap().unwrap();
        assert!((found - 0.0709565).abs() < 6e-8, "{found}");
    }

    #[test]
    fn sampled_radius_tends_to_the_continuous_one_and_a_delay_costs() {
        let at = |period_s: f64, delay_s: f64| {
            let timing = Timing { period_s, delay_s, low_pass: 1.0 };
            sampled_radius(&plant(), timing, &constant(1.0), 12.0).unwrap().unwrap()
        };
        let continuous = continuous_radius(&plant(), &constant(1.0), 12.0).unwrap().unwrap();
        let [coarse, fine] = [1e-4, 1e-5].map(|period_s| (at(period_s, 0.0) - continuous).abs());
        assert!(fine < 0.2 * coarse && fine < 1e-6, "{coarse} {fine}");
        // Half a period of delay moves the phase of the residues, a whole one twice as much.
        let moved = [0.5e-3, 1e-3].map(|delay_s| at(1e-3, delay_s) - at(1e-3, 0.0));
        assert!((moved[1] / moved[0] - 2.0).abs() < 0.2, "{moved:?}");
    }

    #[test]
    fn nothing_unstable_has_no_radius_and_a_pole_on_the_line_is_an_error() {
        assert!(matches!(continuous_radius(&plant(), &constant(1.0), 0.0), Err(Error::PoleOnLine { .. })));
        let one = |x: f64| flexbeam_lti::Mat::from_element(1, 1, x);
        let stable = StateSpace::new(one(-3.0), one(1.0), one(1.0), one(0.0), flexbeam_lti::Time::Continuous).unwrap();
        assert_eq!(continuous_radius(&stable, &constant(1.0), 2.0), Ok(None));
        // One pole right of the line: G = 1/(s + 3 - beta), smallest Hankel singular value 1/(2 (beta - 3)).
        let found = continuous_radius(&stable, &constant(1.0), 5.0).unwrap().unwrap();
        assert!((found - 0.25).abs() < 1e-13, "{found}");
    }
}
