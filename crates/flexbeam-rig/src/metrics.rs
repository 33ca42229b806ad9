//! Measures of a step response, taken on the true tip angle.

use crate::{ClosedLoopRecord, Error};

/// The tip counts as settled within this part of the step.
pub const SETTLING_BAND: f64 = 0.02;
/// Stationary error and residual vibration are taken over the end of the run: this long, or the second half of a
/// shorter response [s].
pub const FINAL_WINDOW_S: f64 = 1.0;
/// Smallest swing of the tip from one turn to the next that counts towards a limit cycle [rad]: 0.2 degree, a little
/// over two encoder counts.
pub const LIMIT_CYCLE_SWING_RAD: f64 = 0.2 * std::f64::consts::PI / 180.0;
/// A swing that falls below this part of itself over half the judged span is dying out.
const STILL_ALIVE: f64 = 0.7;
/// Two periods of an oscillation.
const FEWEST_SWINGS: usize = 4;
/// A hub that moves less than this part of a swing leaves the beam to swing on its own, which no loop sustains.
const HUB_SHARE: f64 = 0.1;
/// Below this there is no second half to judge.
const FEWEST_SAMPLES: usize = 8;

/// What a step response was like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepMetrics {
    /// Height of the step, from the tip's place when the reference last changed to the final reference [rad].
    pub step_rad: f64,
    /// Time from the reference's last change until the tip stays within 2 % of the step around the final reference [s];
    /// none when it was outside at the end.
    pub settling_time_s: Option<f64>,
    /// How far the tip went beyond the final reference, in percent of the step.
    pub overshoot_percent: f64,
    /// Mean of |reference - psi| over the final window [rad].
    pub stationary_error_rad: f64,
    /// Largest |reference - psi| in the final window [rad].
    pub largest_stationary_error_rad: f64,
    /// Root mean square of psi about its least-squares line in the final window [rad].
    pub residual_vibration_rad: f64,
    /// Largest magnitude of the commanded voltage, from the first sample to the last [V].
    pub peak_voltage_v: f64,
    /// Whether an oscillation persists: in the second half of the response the tip turns back at least four times by
    /// at least [`LIMIT_CYCLE_SWING_RAD`] each, the later half of these swings is at least 0.7 of the earlier half on
    /// average, and the hub takes part in it. A beam that rings out on a resting hub is no limit cycle.
    pub limit_cycle: bool,
}

impl StepMetrics {
    /// Measures of the response to the reference's last change.
    ///
    /// Errors: [`Error::TooFewSamples`] when less than 8 samples follow that change.
    pub fn of(record: &ClosedLoopRecord) -> Result<StepMetrics, Error> {
        let response = Response::after_last_change(record)?;
        let (stationary_error_rad, largest_stationary_error_rad) = response.stationary_error();
        Ok(StepMetrics {
            step_rad: response.step(),
            settling_time_s: response.settling_time_s(),
            overshoot_percent: response.overshoot_percent(),
            stationary_error_rad,
            largest_stationary_error_rad,
            residual_vibration_rad: rms_about_line(response.final_window()),
            peak_voltage_v: record.voltage_v.iter().fold(0.0, |peak, v| v.abs().max(peak)),
            limit_cycle: response.has_limit_cycle(),
        })
    }
}

/// The part of a run after the reference's last change.
struct Response<'a> {
    period_s: f64,
    target: f64,
    psi: &'a [f64],
    theta: &'a [f64],
}

impl Response<'_> {
    fn after_last_change(record: &ClosedLoopRecord) -> Result<Response<'_>, Error> {
        let target = record.reference_rad.last().copied().unwrap_or(0.0);
        let start = record.reference_rad.iter().rposition(|&r| r != target).map_or(0, |k| k + 1);
        let (psi, theta) = (&record.psi_rad[start..], &record.theta_rad[start..]);
        if psi.len() < FEWEST_SAMPLES {
            return Err(Error::TooFewSamples { found: psi.len(), needed: FEWEST_SAMPLES });
        }
        Ok(Response { period_s: record.period_s, target, psi, theta })
    }

    fn step(&self) -> f64 {
        self.target - self.psi[0]
    }

    fn settling_time_s(&self) -> Option<f64> {
        let band = SETTLING_BAND * self.step().abs();
        let outside = self.psi.iter().rposition(|psi| !((psi - self.target).abs() <= band));
        match outside {
            None => Some(0.0),
            Some(last) if last + 1 == self.psi.len() => None,
            Some(last) => Some((last + 1) as f64 * self.period_s),
        }
    }

    fn overshoot_percent(&self) -> f64 {
        let step = self.step();
        if step == 0.0 {
            return 0.0;
        }
        self.psi.iter().map(|psi| 100.0 * (psi - self.target) / step).fold(0.0, f64::max)
    }

    fn final_window(&self) -> &[f64] {
        let window = ((FINAL_WINDOW_S / self.period_s).round() as usize).clamp(1, self.psi.len() / 2);
        &self.psi[self.psi.len() - window..]
    }

    /// Mean and largest.
    fn stationary_error(&self) -> (f64, f64) {
        let window = self.final_window();
        let errors = window.iter().map(|psi| (psi - self.target).abs());
        (errors.clone().sum::<f64>() / window.len() as f64, errors.fold(0.0, f64::max))
    }

    fn has_limit_cycle(&self) -> bool {
        let half = self.psi.len() / 2;
        let swings = swings(&self.psi[half..], LIMIT_CYCLE_SWING_RAD);
        if swings.len() < FEWEST_SWINGS {
            return false;
        }
        let (earlier, later) = swings.split_at(swings.len() / 2);
        let last_quarter = &self.theta[self.theta.len() - self.theta.len() / 4..];
        mean(later) >= STILL_ALIVE * mean(earlier) && range(last_quarter) >= HUB_SHARE * mean(later)
    }
}

/// Sizes of the moves from one turning point to the next; a turn smaller than `least` is none.
fn swings(x: &[f64], least: f64) -> Vec<f64> {
    let (mut lowest, mut highest) = (x[0], x[0]);
    let mut turns: Vec<f64> = Vec::new();
    let mut rising = None;
    for &x in x {
        lowest = x.min(lowest);
        highest = x.max(highest);
        if rising != Some(false) && highest - x >= least {
            turns.push(highest);
            (rising, lowest) = (Some(false), x);
        } else if rising != Some(true) && x - lowest >= least {
            turns.push(lowest);
            (rising, highest) = (Some(true), x);
        }
    }
    turns.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect()
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

fn range(x: &[f64]) -> f64 {
    x.iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b)) - x.iter().fold(f64::INFINITY, |a, &b| a.min(b))
}

fn rms_about_line(x: &[f64]) -> f64 {
    let n = x.len() as f64;
    let (middle, mean) = ((n - 1.0) / 2.0, mean(x));
    let centred = || x.iter().enumerate().map(|(k, x)| (k as f64 - middle, x - mean));
    let spread: f64 = centred().map(|(t, _)| t * t).sum();
    let slope = if spread > 0.0 { centred().map(|(t, x)| t * x).sum::<f64>() / spread } else { 0.0 };
    (centred().map(|(t, x)| (x - slope * t).powi(2)).sum::<f64>() / n).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn record(target: f64, psi: impl Fn(f64) -> f64, theta: impl Fn(f64) -> f64) -> ClosedLoopRecord {
        let time_s: Vec<f64> = (0..5000).map(|k| f64::from(k) * 1e-3).collect();
        ClosedLoopRecord {
            period_s: 1e-3,
            reference_rad: time_s.iter().map(|&t| if t < 0.0995 { 0.0 } else { target }).collect(),
            psi_rad: time_s.iter().map(|&t| psi(t - 0.1)).collect(),
            theta_rad: time_s.iter().map(|&t| theta(t - 0.1)).collect(),
            voltage_v: time_s.iter().map(|t| -3.0 * (TAU * t).sin()).collect(),
            time_s,
            ..ClosedLoopRecord::default()
        }
    }

    /// Second order with damping ratio 0.5 at 12 rad/s, whose measures are known.
    fn second_order(t: f64) -> f64 {
        let (zeta, omega): (f64, f64) = (0.5, 12.0);
        let damped = omega * (1.0 - zeta * zeta).sqrt();
        let shape = (damped * t).cos() + zeta * omega / damped * (damped * t).sin();
        if t <= 0.0 { 0.0 } else { 1.0 - (-zeta * omega * t).exp() * shape }
    }

    #[test]
    fn measures_of_a_second_order_response() {
        let metrics = StepMetrics::of(&record(0.5, |t| 0.5 * second_order(t), |_| 0.0)).unwrap();
        let overshoot = 100.0 * (-0.5 * std::f64::consts::PI / 0.75_f64.sqrt()).exp();
        assert!((metrics.overshoot_percent - overshoot).abs() < 0.01, "{metrics:?}");
        // The last crossing of the band, from the closed form on a ten times finer grid.
        let crossing = (0..50_000).rev().map(|k| f64::from(k) * 1e-4).find(|&t| (second_order(t) - 1.0).abs() > 0.02);
        assert!((metrics.settling_time_s.unwrap() - crossing.unwrap()).abs() < 1.5e-3, "{metrics:?}");
        assert!(metrics.stationary_error_rad < 1e-9 && metrics.residual_vibration_rad < 1e-9);
        assert!((metrics.peak_voltage_v - 3.0).abs() < 1e-4);
        assert!(!metrics.limit_cycle);
    }

    #[test]
    fn a_downward_step_measures_like_an_upward_one() {
        let up = StepMetrics::of(&record(0.5, |t| 0.5 * second_order(t), |_| 0.0)).unwrap();
        let down = StepMetrics::of(&record(-0.5, |t| -0.5 * second_order(t), |_| 0.0)).unwrap();
        assert_eq!(StepMetrics { step_rad: 0.5, ..down }, up);
    }

    #[test]
    fn what_does_not_settle_has_no_settling_time() {
        let metrics = StepMetrics::of(&record(0.5, |t| if t > 0.0 { 0.4 } else { 0.0 }, |_| 0.0)).unwrap();
        assert_eq!(metrics.settling_time_s, None);
        assert!((metrics.stationary_error_rad - 0.1).abs() < 1e-12);
        assert!((metrics.largest_stationary_error_rad - 0.1).abs() < 1e-12);
    }

    #[test]
    fn residual_vibration_is_an_rms_without_the_drift() {
        let psi = |t: f64| 0.5 + 1e-3 * t + 2e-3 * (TAU * 20.0 * t).sin();
        let metrics = StepMetrics::of(&record(0.5, psi, psi)).unwrap();
        assert!((metrics.residual_vibration_rad / (2e-3 / 2.0_f64.sqrt()) - 1.0).abs() < 1e-2, "{metrics:?}");
    }

    #[test]
    fn a_limit_cycle_persists_with_the_hub_in_it() {
        let cycle =
            |amplitude: f64, decay: f64| move |t: f64| 0.5 + amplitude * (-decay * t).exp() * (TAU * 3.0 * t).sin();
        let judged = |psi: &dyn Fn(f64) -> f64, theta: &dyn Fn(f64) -> f64| {
            StepMetrics::of(&record(0.5, psi, theta)).unwrap().limit_cycle
        };
        assert!(judged(&cycle(0.01, 0.0), &cycle(0.01, 0.0)));
        assert!(judged(&cycle(0.01, -0.5), &cycle(0.01, -0.5)), "growing");
        assert!(!judged(&cycle(0.01, 0.0), &|_| 0.5), "a beam on a resting hub");
        assert!(!judged(&cycle(0.1, 0.6), &cycle(0.1, 0.6)), "dying out");
        assert!(!judged(&cycle(0.001, 0.0), &cycle(0.001, 0.0)), "too small to count");
        assert!(!judged(&|t| 0.5 - 0.1 * (-t).exp(), &|t| 0.5 - 0.1 * (-t).exp()), "a crawl");
        assert!(!judged(&|t| 0.1 * t, &|t| 0.1 * t), "a drift");
    }

    #[test]
    fn swings_go_from_turn_to_turn() {
        let x = [0.0, 1.0, 0.9, 2.0, 0.5, 0.6, 3.0, 2.9, 1.0];
        assert_eq!(swings(&x, 0.5), [2.0, 1.5, 2.5]);
        assert!(swings(&x, 5.0).is_empty());
    }

    #[test]
    fn a_response_too_short_is_refused() {
        let mut short = record(0.5, |_| 0.0, |_| 0.0);
        let last = short.samples() - 3;
        short.reference_rad[last] = 0.1;
        assert_eq!(StepMetrics::of(&short), Err(Error::TooFewSamples { found: 2, needed: 8 }));
    }
}
