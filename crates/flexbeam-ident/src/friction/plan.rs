//! The voltages of a friction test, planned from what a pilot showed.
//!
//! Enters: a pilot's breakaway voltages and slope, and the travel. Leaves: lists of voltages, one a sample.

use super::runs::steady_runs;
use super::{Options, Recorded};
use crate::Error;
use crate::breakaway::Breakaway;

/// The pilot run's voltage beyond the breakaway [V]: 0.65 rad/s on the paper's rig.
const PILOT_V: f64 = 0.35;
/// How far a repeated ramp goes beyond the breakaway [V]: twelve counts and more, and 0.2 rad in all.
const BEYOND_V: f64 = 0.06;
/// It falls so many times as fast as it rises: a hub that comes to rest gently leaves the beam at rest, too.
const FALL: f64 = 5.0;
/// What the fastest run may take of the voltage that there is.
const REACH: f64 = 0.9;

/// What is known before the constant-speed runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pilot {
    /// Voltage that moves the hub forward [V].
    pub plus_v: f64,
    /// The same backward [V], a magnitude.
    pub minus_v: f64,
    /// s [V s/rad], roughly.
    pub slope_v_s: f64,
}

/// Lengths and limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Largest turn of one run [rad], default 2.4.
    pub travel_rad: f64,
    /// Speeds each way, default 10: geometric from `slowest_rad_s` on.
    pub speeds: usize,
    /// Slowest run [rad/s], default 0.05: a Stribeck effect shows there.
    pub slowest_rad_s: f64,
    /// Fastest run [rad/s], default 3; less when travel or voltage end before.
    pub fastest_rad_s: f64,
    /// Further runs each way for the sake of their coasts, default 8: from half the fastest speed on.
    pub coasts: usize,
    /// Longest run [s], default 2.5.
    pub longest_s: f64,
    /// Zero voltage behind each run [s], default 1.5.
    pub coast_s: f64,
    /// Largest voltage of the rig [V], default 10.
    pub limit_v: f64,
}

impl Default for Plan {
    fn default() -> Plan {
        Plan {
            travel_rad: 2.4,
            speeds: 10,
            slowest_rad_s: 0.05,
            fastest_rad_s: 3.0,
            coasts: 8,
            longest_s: 2.5,
            coast_s: 1.5,
            limit_v: 10.0,
        }
    }
}

impl Plan {
    /// Forward and backward in turn, each at constant voltage and then cut: +w1, -w1, +w2, -w2 ..
    ///
    /// Errors: [`Error::Setting`] for a travel or a voltage too small for speeds that differ.
    pub fn runs(&self, pilot: &Pilot, period_s: f64, options: &Options) -> Result<Vec<f64>, Error> {
        let fastest = self.fastest(pilot, options)?;
        let samples = |t_s: f64| (t_s / period_s).round() as usize;
        let rest = || std::iter::repeat_n(0.0, samples(self.coast_s));
        let mut voltages: Vec<f64> = rest().collect();
        for w in self.speeds_rad_s(fastest) {
            let length = samples(self.longest_s.min(self.travel_rad / w));
            for voltage in [pilot.plus_v + pilot.slope_v_s * w, -pilot.minus_v - pilot.slope_v_s * w] {
                voltages.extend(std::iter::repeat_n(voltage, length).chain(rest()));
            }
        }
        Ok(voltages)
    }

    /// Geometric over the whole range for the curve, then even over its upper half for the coasts.
    fn speeds_rad_s(&self, fastest: f64) -> impl Iterator<Item = f64> {
        let part = |k: usize, n: usize| k as f64 / (n.max(2) - 1) as f64;
        let (slowest, speeds, coasts) = (self.slowest_rad_s, self.speeds, self.coasts);
        let curve = (0..speeds).map(move |k| slowest * (fastest / slowest).powf(part(k, speeds)));
        curve.chain((0..coasts).map(move |k| fastest * (0.5 + 0.5 * part(k, coasts))))
    }

    fn fastest(&self, pilot: &Pilot, options: &Options) -> Result<f64, Error> {
        // A tenth longer than the shortest run that counts: the pilot's slope is rough.
        let by_travel = self.travel_rad / (1.1 * (options.settle_s + options.steady_s));
        let by_voltage = (REACH * self.limit_v - pilot.plus_v.max(pilot.minus_v)) / pilot.slope_v_s;
        let fastest = self.fastest_rad_s.min(by_travel).min(by_voltage);
        if fastest > 4.0 * self.slowest_rad_s && self.speeds > 1 {
            return Ok(fastest);
        }
        let (setting, found) = if by_travel <= by_voltage {
            ("the travel [rad] of a friction test", self.travel_rad)
        } else {
            ("the voltage limit [V] of a friction test", self.limit_v)
        };
        Err(Error::Setting {
            setting,
            found,
            needed: "more: the fastest run must be four times as fast as the slowest",
        })
    }

    /// Rest, a slow rise just beyond the breakaway and a fall, forward and backward in turn, so many times.
    pub fn ramps(&self, pilot: &Pilot, repeats: usize, rate_v_s: f64, rest_s: f64, period_s: f64) -> Vec<f64> {
        let step_v = rate_v_s * period_s;
        let ramp = |sign: f64, peak_v: f64| {
            let rise = (peak_v / step_v).ceil() as usize;
            let fall = (rise as f64 / FALL) as usize;
            let up = (1..=rise).map(move |k| sign * peak_v * k as f64 / rise as f64);
            up.chain((0..fall).rev().map(move |k| sign * peak_v * k as f64 / fall as f64))
        };
        let rest = || std::iter::repeat_n(0.0, (rest_s / period_s).round() as usize);
        let both = || {
            let forward = ramp(1.0, pilot.plus_v + BEYOND_V);
            rest().chain(forward).chain(rest()).chain(ramp(-1.0, pilot.minus_v + BEYOND_V))
        };
        (0..repeats).flat_map(|_| both()).chain(rest()).collect()
    }
}

/// One run each way, little beyond the breakaway, from which [`pilot`] reads the slope.
pub fn pilot_runs(found: &Breakaway, rest_s: f64, period_s: f64, options: &Options) -> Vec<f64> {
    let samples = |t_s: f64| (t_s / period_s).round() as usize;
    let run = |voltage: f64| std::iter::repeat_n(voltage, samples(options.settle_s + options.steady_s + 0.1));
    let rest = || std::iter::repeat_n(0.0, samples(rest_s));
    rest().chain(run(found.plus_v + PILOT_V)).chain(rest()).chain(run(found.minus_v - PILOT_V)).chain(rest()).collect()
}

/// The slope of the pilot runs.
///
/// Errors: [`Error::TooFewRuns`] when one way shows no constant speed.
pub fn pilot(recorded: &Recorded<'_>, found: &Breakaway, options: &Options) -> Result<Pilot, Error> {
    recorded.check(options)?;
    let (runs, _) = steady_runs(recorded, options);
    let slope = |direction, sign: f64, breakaway_v: f64| {
        let run = runs.iter().find(|run| sign * run.speed_rad_s > 0.0);
        run.map(|run| (run.voltage_v - breakaway_v) / run.speed_rad_s).ok_or(Error::TooFewRuns {
            direction,
            found: 0,
            needed: 1,
        })
    };
    let slopes = [slope("forward", 1.0, found.plus_v)?, slope("backward", -1.0, found.minus_v)?];
    Ok(Pilot { plus_v: found.plus_v, minus_v: -found.minus_v, slope_v_s: 0.5 * (slopes[0] + slopes[1]) })
}
