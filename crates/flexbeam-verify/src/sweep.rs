//! Sweeps along a circle that no resonance escapes: the grid is dense where poles lie, and refined where a function bends.
//!
//! Enters: poles, functions of the angle. Leaves: angles, maxima, roots.

use flexbeam_lti::C64;
use std::f64::consts::PI;

/// Ratio of the distances of successive points from a pole: the next point is no farther than the pole.
const SPREAD: f64 = 2.0;
/// Points nearer to each other than this [rad] are one.
const DISTINCT: f64 = 1e-14;

/// Angles in [lowest, pi] on the circle, no interval longer than its distance to the nearest of the poles.
pub(crate) fn angles(poles: &[C64], radius: f64, lowest: f64) -> Vec<f64> {
    let mut angles = vec![lowest, PI];
    let mut around = |centre: f64, distance: f64| {
        angles.push(centre);
        let mut step = 0.25 * distance;
        while step < 2.0 * PI {
            angles.extend([centre - step, centre + step]);
            step *= SPREAD;
        }
    };
    around(0.0, 4.0 * lowest);
    for z in poles.iter().filter(|z| z.norm() > 0.0 && z.im >= 0.0) {
        around(z.arg(), (z.norm() / radius).ln().abs().max(lowest));
    }
    angles.retain(|angle| (lowest..=PI).contains(angle));
    angles.sort_by(f64::total_cmp);
    angles.dedup_by(|a, b| (*a - *b).abs() < DISTINCT);
    angles
}

/// A maximum and where it is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Largest value.
    pub value: f64,
    /// Frequency [rad/s].
    pub omega_rad_s: f64,
}

/// An interval is halved while the value in its middle departs from the mean of its ends by more than this part of the
/// largest value: what hides between two points is then at most a few parts in a thousand, and golden section finds it.
const STRAIGHT: f64 = 1e-3;
/// Local maxima below this part of the largest sample cannot become the largest.
const RIVAL: f64 = 0.97;
/// Halvings of one interval: enough to reach rounding.
const MOST_HALVINGS: usize = 45;
/// A function that bends at more points than this is rounding: refining it further finds nothing.
const MOST_SAMPLES: usize = 50_000;
/// Golden section ends at this part of the angle: a maximum is flat, its value then has all its digits.
const GOLDEN: f64 = 1e-9;

/// The supremum of f over the angles, refined between them where f is above `noise`.
///
/// Returns (angle, value); infinite when a value is.
pub(crate) fn supremum(angles: &[f64], noise: f64, f: impl Fn(f64) -> f64) -> (f64, f64) {
    supremum_from(angles.iter().map(|&x| (x, f(x))).collect(), noise, f)
}

/// The same from values that are known already.
pub(crate) fn supremum_from(mut samples: Vec<(f64, f64)>, noise: f64, f: impl Fn(f64) -> f64) -> (f64, f64) {
    for _ in 0..MOST_HALVINGS {
        let largest = samples.iter().map(|s| s.1).fold(0.0, f64::max);
        let bends = bending(&samples, STRAIGHT * largest, noise.max(0.5 * largest));
        if bends.is_empty() || samples.len() > MOST_SAMPLES {
            break;
        }
        samples.extend(bends.into_iter().map(|x| (x, f(x))));
        samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    let largest = samples.iter().map(|s| s.1).fold(0.0, f64::max);
    let is_peak = |w: &&[(f64, f64)]| w[1].1 >= w[0].1 && w[1].1 >= w[2].1 && w[1].1 >= RIVAL * largest;
    let refined = samples.windows(3).filter(is_peak).map(|w| golden(w[0].0, w[2].0, &f));
    let candidates = samples.iter().copied().chain(refined);
    candidates.max_by(|a, b| a.1.total_cmp(&b.1)).expect("a sweep has angles")
}

/// Middles of the intervals beside samples off the straight line through their neighbours.
fn bending(samples: &[(f64, f64)], tolerance: f64, relevant: f64) -> Vec<f64> {
    let mut middles = Vec::new();
    for w in samples.windows(3) {
        let share = (w[1].0 - w[0].0) / (w[2].0 - w[0].0);
        let straight = w[0].1 + share * (w[2].1 - w[0].1);
        let highest = w[0].1.max(w[1].1).max(w[2].1);
        if highest < relevant || (w[1].1 - straight).abs() <= tolerance || !highest.is_finite() {
            continue;
        }
        for pair in w.windows(2).filter(|p| p[1].0 - p[0].0 > 1e-12 * p[1].0) {
            middles.push(0.5 * (pair[0].0 + pair[1].0));
        }
    }
    middles.sort_by(f64::total_cmp);
    middles.dedup();
    middles
}

fn golden(mut a: f64, mut b: f64, f: &impl Fn(f64) -> f64) -> (f64, f64) {
    let section = 0.5 * (5.0_f64.sqrt() - 1.0);
    let at = |x: f64| (x, f(x));
    let (mut left, mut right) = (at(b - section * (b - a)), at(a + section * (b - a)));
    while b - a > GOLDEN * b {
        if left.1 >= right.1 {
            (b, right) = (right.0, left);
            left = at(b - section * (b - a));
        } else {
            (a, left) = (left.0, right);
            right = at(a + section * (b - a));
        }
    }
    if left.1 >= right.1 { left } else { right }
}

/// Roots of f between successive angles where it changes sign, to working precision.
///
/// Jumps through infinity also change the sign: the caller looks at f's size.
pub(crate) fn roots(angles: &[f64], f: impl Fn(f64) -> f64) -> Vec<f64> {
    let samples: Vec<(f64, f64)> = angles.iter().map(|&x| (x, f(x))).collect();
    let crossing = |w: &&[(f64, f64)]| w[0].1.is_sign_positive() != w[1].1.is_sign_positive();
    samples.windows(2).filter(crossing).map(|w| bisect(w[0], w[1].0, &f)).collect()
}

fn bisect(a: (f64, f64), mut high: f64, f: &impl Fn(f64) -> f64) -> f64 {
    let mut low = a.0;
    while high - low > 4.0 * f64::EPSILON * high {
        let middle = 0.5 * (low + high);
        if f(middle).is_sign_positive() == a.1.is_sign_positive() {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
