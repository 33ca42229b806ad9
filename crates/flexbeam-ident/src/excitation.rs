//! Voltages that make a rig show itself.
//!
//! Enters: settings and, where chance is needed, a seed. Leaves: one voltage a sample.
//! Deliberately absent: the rig that they are sent to.

mod chirp;
mod multisine;
mod plan;
mod prbs;

pub use plan::{Excitation, Plan, Shape};
pub use prbs::binary_sequence;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// White Gaussian voltage (Figure 5), clipped at the limit.
///
/// Returns: `samples` values; the same for the same seed on every machine.
/// Assumes: `limit_v` of several `rms_v`; clipping lowers the rms (by 0.1 % at 3 rms) and colours nothing.
pub fn white_gaussian(samples: usize, rms_v: f64, limit_v: f64, seed: u64) -> Vec<f64> {
    let random = ChaCha8Rng::seed_from_u64(seed);
    let normal: rand_distr::Iter<StandardNormal, _, f64> = StandardNormal.sample_iter(random);
    normal.take(samples).map(|x| (rms_v * x).clamp(-limit_v, limit_v)).collect()
}

/// A slow ramp in one direction, then in the other, each from rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlowRamp {
    /// Largest voltage, both ways [V], default 0.5.
    pub peak_v: f64,
    /// Rate [V/s], default 0.02: the hub moves within 0.02 V of its breakaway for every second that it hesitates.
    pub rate_v_s: f64,
    /// Zero voltage before each ramp [s], default 30: a beam damped by 0.5 % still swings after ten seconds, and its pull on
    /// the hub makes the second breakaway look half as large.
    pub rest_s: f64,
}

impl Default for SlowRamp {
    fn default() -> SlowRamp {
        SlowRamp { peak_v: 0.5, rate_v_s: 0.02, rest_s: 30.0 }
    }
}

impl SlowRamp {
    /// Rest, ramp to +peak, rest, ramp to -peak, rest.
    pub fn voltage(&self, period_s: f64) -> Vec<f64> {
        let rest = (self.rest_s / period_s).round() as usize;
        let rise = (self.peak_v / self.rate_v_s / period_s).round() as usize;
        let ramp = |sign: f64| (1..=rise).map(move |k| sign * self.peak_v * k as f64 / rise as f64);
        let still = || std::iter::repeat_n(0.0, rest);
        still().chain(ramp(1.0)).chain(still()).chain(ramp(-1.0)).chain(still()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_gaussian_is_white_and_gaussian() {
        let v = white_gaussian(100_000, 2.0, 100.0, 5);
        let n = v.len() as f64;
        let moment = |p: i32| v.iter().map(|x| (x / 2.0).powi(p)).sum::<f64>() / n;
        // Four standard deviations of each estimate.
        assert!(moment(1).abs() < 4.0 / n.sqrt());
        assert!((moment(2) - 1.0).abs() < 4.0 * (2.0 / n).sqrt());
        assert!((moment(4) - 3.0).abs() < 4.0 * (96.0 / n).sqrt());
        for lag in 1..5 {
            let r = v.windows(lag + 1).map(|w| w[0] * w[lag] / 4.0).sum::<f64>() / n;
            assert!(r.abs() < 4.0 / n.sqrt(), "lag {lag}: {r}");
        }
    }

    #[test]
    fn seed_and_limit_are_kept() {
        let v = white_gaussian(1000, 3.0, 4.0, 1);
        assert_eq!(v, white_gaussian(1000, 3.0, 4.0, 1));
        assert_ne!(v, white_gaussian(1000, 3.0, 4.0, 2));
        assert!(v.contains(&4.0) && v.contains(&-4.0) && v.iter().all(|x| x.abs() <= 4.0));
    }

    #[test]
    fn slow_ramp_reaches_both_peaks_at_its_rate() {
        let v = SlowRamp { peak_v: 0.4, rate_v_s: 0.1, rest_s: 1.0 }.voltage(0.01);
        assert_eq!(v.len(), 3 * 100 + 2 * 400);
        assert_eq!((v[499], v[999]), (0.4, -0.4));
        assert!(v.windows(2).filter(|w| w[1] != 0.0).all(|w| (w[1] - w[0]).abs() < 0.1 * 0.01 * 1.0001));
    }
}
