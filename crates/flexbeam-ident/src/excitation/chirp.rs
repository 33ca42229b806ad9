//! Sines whose frequency rises, of amplitude one.
//!
//! The phase of one period is a whole number of turns, so that the next one continues it.

use std::f64::consts::TAU;

/// From harmonic `ends[0]` to `ends[1]` of the period, by as many hertz in each second: phase k1 x + (k2 - k1) x^2/2 turns at
/// the part x of the period.
pub(super) fn linear(ends: [usize; 2], samples: usize) -> Vec<f64> {
    let [low, high] = ends.map(|k| k as f64);
    sines(samples, 0.5 * (low + high), |x| low * x + 0.5 * (high - low) * x * x)
}

/// By as many octaves in each second: phase k1 (q^x - 1)/ln q turns, q = k2/k1.
pub(super) fn logarithmic(ends: [usize; 2], samples: usize) -> Vec<f64> {
    let [low, high] = ends.map(|k| k as f64);
    let rate = (high / low).ln();
    sines(samples, (high - low) / rate, |x| low * (rate * x).exp_m1() / rate)
}

/// The phase stretched to whole turns: by less than one part in the number of turns.
fn sines(samples: usize, turns: f64, phase: impl Fn(f64) -> f64) -> Vec<f64> {
    let stretch = turns.round().max(1.0) / turns;
    (0..samples).map(|k| (TAU * stretch * phase(k as f64 / samples as f64)).sin()).collect()
}
