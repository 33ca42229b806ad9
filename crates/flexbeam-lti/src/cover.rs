//! A low-order alpha(s) that lies everywhere above a given difference |dG(jw - beta)|.
//!
//! Enters: the difference as a function of frequency. Leaves: alpha(s) = a (s/z + 1)/(s/p + 1), z <= p, as small as it can be
//! in the mean over the band, checked between the fitting points.

use crate::{C64, Zpk};

/// The band starts at this part of beta: below it s = jw - beta hardly moves.
const LOWEST: f64 = 0.1;

/// The band ends at this many times its start, or higher.
const BAND: f64 = 1e5;

/// It ends at least this many times above the fastest dynamics that the caller names.
const BEYOND: f64 = 3.0;

/// Fitting points over the band; the check uses twice as many, between them.
const POINTS: usize = 4000;

/// alpha stands above the difference by this factor: a difference computed from an identified model moves by some percent.
const RESERVE: f64 = 1.1;

/// alpha stays above the largest ratio that was found anywhere by this much.
const BETWEEN: f64 = 1e-6;

/// alpha's zero lies beyond this many beta: it becomes a closed-loop pole at -zero - beta, which should not be a slow one.
const ZERO_BEYOND: f64 = 10.0;

/// alpha rises by this factor at most. A bound that is tighter at low frequencies makes the loop stiffer there and costs phase:
/// on the paper's plant with K(0) = 7 V/rad the disk margin is 1.18 for a constant alpha and 1.02 when it rises by 9.
const LARGEST_RISE: f64 = 4.0;

/// The smallest lead alpha(s) above `difference` [rad/V], |dG(jw - beta)| as a function of w.
///
/// The band reaches from a tenth of `beta` over five decades, and past `fastest_rad_s`, the fastest mode that a rig excites:
/// outside it alpha is flat and the difference is taken to fall.
/// alpha does not roll off, so that the control sensitivity F/alpha does not grow at
/// high frequency, where the sensors' noise is.
///
/// Assumes: `beta` > 0.
/// Errors: [`Uncovered`] where the difference is infinite or not a number.
/// Numerics: peaks are refined by golden section; the fit minimises the mean of ln alpha over the band by a pattern search in
/// (ln z, ln p), the gain following from the largest ratio.
pub fn cover(difference: impl Fn(f64) -> f64, beta: f64, fastest_rad_s: f64) -> Result<Zpk, Uncovered> {
    let grid = |count: usize, offset: f64| {
        let band = (BEYOND * fastest_rad_s / (LOWEST * beta)).max(BAND);
        (0..count).map(move |k| LOWEST * beta * band.powf((k as f64 + offset) / count as f64)).collect::<Vec<f64>>()
    };
    let fitting = samples_with_peaks(&grid(POINTS, 0.0), &difference);
    if let Some((omega_rad_s, value)) = fitting.iter().copied().find(|(_, value)| !value.is_finite()) {
        return Err(Uncovered { omega_rad_s, value });
    }
    let lead = pattern_search(&fitting, ZERO_BEYOND * beta);
    let ratio = |omega: f64| difference(omega) / lead.magnitude(omega);
    let largest = |samples: Vec<(f64, f64)>| samples.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).expect("points");
    let fitted = fitting.iter().map(|(omega, value)| (*omega, value / lead.magnitude(*omega))).collect();
    let (closest_rad_s, checked) = largest(samples_with_peaks(&grid(2 * POINTS, 0.25), &ratio));
    if !checked.is_finite() {
        return Err(Uncovered { omega_rad_s: closest_rad_s, value: checked });
    }
    // What the check finds between the fitting points may take the reserve, but not more.
    let gain = (RESERVE * largest(fitted).1).max(checked * (1.0 + BETWEEN));
    Ok(lead.with_gain(gain))
}

/// A difference that no bound lies above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncovered {
    /// Frequency [rad/s].
    pub omega_rad_s: f64,
    /// The value found.
    pub value: f64,
}

/// (s/z + 1)/(s/p + 1).
#[derive(Clone, Copy)]
struct Lead {
    z: f64,
    p: f64,
}

impl Lead {
    fn magnitude(self, omega: f64) -> f64 {
        (omega / self.z).hypot(1.0) / (omega / self.p).hypot(1.0)
    }

    fn with_gain(self, gain: f64) -> Zpk {
        let (zeros, poles) = (vec![C64::new(-self.z, 0.0)], vec![C64::new(-self.p, 0.0)]);
        Zpk { zeros, poles, gain: gain * self.p / self.z }
    }

    /// Mean of ln alpha over the points when the gain is as small as they permit.
    fn cost(self, samples: &[(f64, f64)]) -> f64 {
        let (mut largest, mut sum) = (f64::NEG_INFINITY, 0.0);
        for (omega, value) in samples {
            let shape = self.magnitude(*omega).ln();
            largest = largest.max(value.ln() - shape);
            sum += shape;
        }
        largest + sum / samples.len() as f64
    }
}

/// Steps in (ln z, ln p), halved whenever none of the eight neighbours is better.
fn pattern_search(samples: &[(f64, f64)], lowest_zero: f64) -> Lead {
    let fits = |lead: &Lead| lead.z >= lowest_zero && lead.z <= lead.p && lead.p <= LARGEST_RISE * lead.z;
    let mut best = Lead { z: 2.0 * lowest_zero, p: 2.0 * lowest_zero };
    let mut cost = best.cost(samples);
    let mut step = 1.0_f64;
    while step > 1e-3 {
        let neighbours = (0..9).map(|k| (step * (f64::from(k % 3) - 1.0), step * (f64::from(k / 3) - 1.0)));
        let candidates = neighbours.map(|(dz, dp)| Lead { z: best.z * dz.exp(), p: best.p * dp.exp() }).filter(fits);
        let better = candidates.map(|lead| (lead.cost(samples), lead)).min_by(|a, b| a.0.total_cmp(&b.0));
        match better {
            Some((c, lead)) if c < cost => (cost, best) = (c, lead),
            _ => step *= 0.5,
        }
    }
    best
}

/// Values on the grid, and at each local maximum between its neighbours.
fn samples_with_peaks(grid: &[f64], f: &impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let mut samples: Vec<(f64, f64)> = grid.iter().map(|omega| (*omega, f(*omega))).collect();
    let peaks: Vec<(f64, f64)> = samples
        .windows(3)
        .filter(|w| w[1].1 >= w[0].1 && w[1].1 >= w[2].1)
        .map(|w| {
            let omega = golden_maximum(w[0].0, w[2].0, f);
            (omega, f(omega))
        })
        .collect();
    samples.extend(peaks);
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    samples
}

/// Golden-section search for a maximum between a and b.
fn golden_maximum(mut a: f64, mut b: f64, f: &impl Fn(f64) -> f64) -> f64 {
    const SECTION: f64 = 0.618_033_988_749_894_8;
    while b - a > 1e-10 * b {
        let (left, right) = (b - SECTION * (b - a), a + SECTION * (b - a));
        if f(left) >= f(right) { b = right } else { a = left }
    }
    0.5 * (a + b)
}
