//! The voltage at which the hub starts to move, both ways, from a slow ramp; and what follows for the variable structure.
//!
//! Enters: a recorded ramp ([`crate::excitation::SlowRamp`]). Leaves: breakaway voltages, thresholds, u_p.
//! Deliberately absent: the simulator's friction constants, which a real rig does not publish.

use crate::Error;
use crate::friction::Estimate;

/// One revolution of the load shaft in encoder counts.
const COUNTS: f64 = 4096.0;
/// Part of the breakaway that the inverse law adds: below one by more than the test's own error.
const INVERSE_SHARE: f64 = 0.95;
/// Width of the inverse law's ramp, as a part of the larger breakaway: above the noise of u, below what hunts.
const RAMP_SHARE: f64 = 0.04;
/// 0.15 degree.
const STATIONARY_ERROR_RAD: f64 = 0.15 * std::f64::consts::PI / 180.0;
/// The switched law sticks when eps_u is below u_p or u_p below the breakaway, crawls when just above, and swings when well above.
const SWITCHED_MARGIN: f64 = 1.15;

/// Ramps a direction for a standard error.
const FEWEST_RAMPS: usize = 2;
/// Degrees of freedom beyond which Student's t is Gauss's.
const MOST_FREEDOM: f64 = 1000.0;
/// Counts of the parabola: a second of the default ramp on the paper's rig.
const ONSET_COUNTS: usize = 12;
/// Starts of the parabola within a count that are tried.
const STARTS: i32 = 48;
/// A ramp begins below this part of its peak; a run at constant voltage does not.
const RAMP_START: f64 = 0.2;

/// When the hub counts as moving.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// One encoder count [rad], default 2 pi / 4096.
    pub resolution_rad: f64,
    /// Counts that the hub must leave its rest by, default 2: one may be a flicker between two counts.
    pub counts: f64,
    /// Time that it must stay that far away [s], default 0.1.
    pub hold_s: f64,
}

impl Default for Detection {
    fn default() -> Detection {
        Detection { resolution_rad: std::f64::consts::TAU / COUNTS, counts: 2.0, hold_s: 0.1 }
    }
}

/// Where the hub starts to move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Breakaway {
    /// Voltage of the last sample at rest on the positive ramp [V], positive.
    pub plus_v: f64,
    /// The same on the negative ramp [V], negative.
    pub minus_v: f64,
    /// Sample of `plus_v`, from 0.
    pub plus_sample: usize,
    /// Sample of `minus_v`, from 0.
    pub minus_sample: usize,
}

/// Settings of the variable structure, DESIGN section 7.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thresholds {
    /// Voltage added or sent in the positive direction [V].
    pub u_p_plus_v: f64,
    /// The same in the negative direction, as a magnitude [V].
    pub u_p_minus_v: f64,
    /// Threshold of switch 2 [V].
    pub eps_u_v: f64,
    /// Threshold of switch 1 [rad].
    pub eps_e_rad: f64,
}

/// Breakaway voltages of a recorded slow ramp.
///
/// Each direction: the ramp is the longest stretch with a voltage of that sign. The hub moves from the first sample on at which
/// it has left its rest by `counts` in the direction of the voltage and stays that far away for `hold_s`; the breakaway
/// voltage is that of the last sample before, within half a count of the rest.
///
/// Shapes: one voltage and one hub angle a sample.
/// Errors: [`Error::Length`], [`Error::NeverMoved`], [`Error::NotAtRest`].
/// Numerics: late by the time that the hub takes for its first half count: 0.004 V with the default ramp on the paper's plant.
pub fn breakaway(
    voltage_v: &[f64],
    theta_rad: &[f64],
    period_s: f64,
    detection: &Detection,
) -> Result<Breakaway, Error> {
    if voltage_v.len() != theta_rad.len() {
        return Err(Error::Length { inputs: voltage_v.len(), outputs: theta_rad.len() });
    }
    let hold = ((detection.hold_s / period_s).round() as usize).max(1);
    let ramp = |sign, direction| Ramp { voltage_v, theta_rad, sign, direction, hold, detection };
    let plus_sample = ramp(1.0, "forward").last_at_rest()?;
    let minus_sample = ramp(-1.0, "backward").last_at_rest()?;
    Ok(Breakaway { plus_v: voltage_v[plus_sample], minus_v: voltage_v[minus_sample], plus_sample, minus_sample })
}

impl Breakaway {
    /// For the inverse law u_c = u + u_p sat(u/eps_u): u_p just below the breakaway, a narrow ramp, and eps_e 0.15 degree, or
    /// a count if that is more.
    ///
    /// A u_p at the breakaway itself makes the stuck hub creep under the sensors' noise, and a wide ramp hunts: on the paper's
    /// rig with K(0) = 7 V/rad the full breakaway leaves 0.36 degree and swings, 95 % of it 0.16 degree and rests.
    pub fn inverse_thresholds(&self, resolution_rad: f64) -> Thresholds {
        Thresholds {
            u_p_plus_v: INVERSE_SHARE * self.plus_v,
            u_p_minus_v: -INVERSE_SHARE * self.minus_v,
            eps_u_v: RAMP_SHARE * self.plus_v.max(-self.minus_v),
            eps_e_rad: STATIONARY_ERROR_RAD.max(resolution_rad),
        }
    }

    /// v_res: the largest |u| behind the inverse law at which the hub may still stick [V].
    ///
    /// u + u_p sat(u/eps_u) reaches the breakaway V_b at u = V_b - u_p beyond the ramp, at u = V_b eps_u/(eps_u + u_p) on it,
    /// which is DESIGN section 7's formula when u_p = V_b.
    pub fn residual_v(&self, thresholds: &Thresholds) -> f64 {
        let eps_u = thresholds.eps_u_v;
        let one_way = |breakaway: f64, u_p: f64| {
            let beyond = breakaway - u_p;
            if beyond >= eps_u { beyond } else { breakaway * eps_u / (eps_u + u_p) }
        };
        one_way(self.plus_v, thresholds.u_p_plus_v).max(one_way(-self.minus_v, thresholds.u_p_minus_v))
    }

    /// For the switched law: u_p 15 % above the breakaway, eps_u 15 % above the larger u_p.
    pub fn switched_thresholds(&self, resolution_rad: f64) -> Thresholds {
        let (u_p_plus_v, u_p_minus_v) = (SWITCHED_MARGIN * self.plus_v, -SWITCHED_MARGIN * self.minus_v);
        let eps_u_v = SWITCHED_MARGIN * u_p_plus_v.max(u_p_minus_v);
        Thresholds { u_p_plus_v, u_p_minus_v, eps_u_v, eps_e_rad: STATIONARY_ERROR_RAD.max(resolution_rad) }
    }
}

/// Breakaway voltages of repeated slow ramps, each with its standard error.
///
/// Each ramp's onset is where a parabola through its first counts begins, t_n = t_0 + q sqrt(n - 1/2 - d) with the rest d counts
/// above the middle of its count: [`breakaway`]'s delay is gone. The standard error joins the scatter of the ramps and
/// a rectangle of `step_v`, the resolution of the converter (0 where it is not known), which no repetition shows.
///
/// Returns: forward, and backward as a negative voltage.
/// Errors: those of [`breakaway`]; [`Error::TooFewRamps`] below two ramps a direction.
/// Source: JCGM 100 (GUM), 4.3.7 and G.4.1 for the joint error and its degrees of freedom.
pub fn repeated(
    voltage_v: &[f64],
    theta_rad: &[f64],
    period_s: f64,
    detection: &Detection,
    step_v: f64,
) -> Result<[Estimate; 2], Error> {
    if voltage_v.len() != theta_rad.len() {
        return Err(Error::Length { inputs: voltage_v.len(), outputs: theta_rad.len() });
    }
    let hold = ((detection.hold_s / period_s).round() as usize).max(1);
    let one_way = |sign, direction| {
        let onsets = Ramp { voltage_v, theta_rad, sign, direction, hold, detection }.onsets_v(period_s)?;
        joint(&onsets, step_v, direction)
    };
    Ok([one_way(1.0, "forward")?, one_way(-1.0, "backward")?])
}

fn joint(onsets_v: &[f64], step_v: f64, direction: &'static str) -> Result<Estimate, Error> {
    let found = onsets_v.len();
    if found < FEWEST_RAMPS {
        return Err(Error::TooFewRamps { direction, found, needed: FEWEST_RAMPS });
    }
    let n = found as f64;
    let value = onsets_v.iter().sum::<f64>() / n;
    let by_scatter = onsets_v.iter().map(|v| (v - value).powi(2)).sum::<f64>() / (n * (n - 1.0));
    let by_converter = step_v * step_v / 12.0;
    // Welch and Satterthwaite; the rectangle is known and has endless degrees of freedom.
    let freedom = (n - 1.0) * ((by_scatter + by_converter) / by_scatter).powi(2);
    Ok(Estimate {
        value,
        standard_error: (by_scatter + by_converter).sqrt(),
        freedom: freedom.min(MOST_FREEDOM) as usize,
    })
}

/// One direction of the test.
struct Ramp<'a> {
    voltage_v: &'a [f64],
    theta_rad: &'a [f64],
    sign: f64,
    direction: &'static str,
    hold: usize,
    detection: &'a Detection,
}

impl Ramp<'_> {
    fn last_at_rest(&self) -> Result<usize, Error> {
        self.last_at_rest_of(self.longest_stretch())
    }

    fn last_at_rest_of(&self, ramp: std::ops::Range<usize>) -> Result<usize, Error> {
        let never = Error::NeverMoved { direction: self.direction, reached_v: self.reached_v(&ramp) };
        if ramp.is_empty() {
            return Err(never);
        }
        let rest = self.theta_rad[ramp.start];
        self.expect_rest(ramp.start, rest)?;
        // Rounding of the angle must not hide a whole count.
        let far = |k: usize| self.away(k, rest) > self.detection.counts - 0.25;
        let last = self.theta_rad.len().saturating_sub(self.hold);
        let moving = ramp.clone().take_while(|&k| k <= last).find(|&k| (k..k + self.hold).all(far)).ok_or(never)?;
        Ok((ramp.start..moving).rev().find(|&k| self.away(k, rest) < 0.5).unwrap_or(ramp.start))
    }

    /// Counts from the rest, in the direction of the voltage.
    fn away(&self, k: usize, rest: f64) -> f64 {
        self.sign * (self.theta_rad[k] - rest) / self.detection.resolution_rad
    }

    fn reached_v(&self, ramp: &std::ops::Range<usize>) -> f64 {
        self.voltage_v[ramp.clone()].iter().map(|v| v.abs()).fold(0.0, f64::max)
    }

    /// Voltage at the onset of each slow ramp that moved the hub.
    ///
    /// Errors: no ramp of this sign moved it; it did not rest before one.
    fn onsets_v(&self, period_s: f64) -> Result<Vec<f64>, Error> {
        let ramps: Vec<_> = self.stretches().into_iter().filter(|ramp| self.is_ramp(ramp)).collect();
        let mut onsets = Vec::new();
        let mut reached = 0.0_f64;
        for ramp in &ramps {
            match self.last_at_rest_of(ramp.clone()) {
                Ok(last) => onsets.push(self.voltage_v[self.onset(ramp, last, period_s)]),
                Err(Error::NeverMoved { reached_v, .. }) => reached = reached.max(reached_v),
                Err(error) => return Err(error),
            }
        }
        if onsets.is_empty() {
            Err(Error::NeverMoved { direction: self.direction, reached_v: reached })
        } else {
            Ok(onsets)
        }
    }

    fn is_ramp(&self, ramp: &std::ops::Range<usize>) -> bool {
        self.voltage_v[ramp.start].abs() < RAMP_START * self.reached_v(ramp)
    }

    /// Sample at which the parabola through the first counts begins; not after the last sample at rest.
    fn onset(&self, ramp: &std::ops::Range<usize>, last_at_rest: usize, period_s: f64) -> usize {
        let rest = self.theta_rad[ramp.start];
        let crossing = |n: usize| {
            let past = (last_at_rest..ramp.end).find(|&k| self.away(k, rest) > n as f64 - 0.25)?;
            Some((past - last_at_rest) as f64 * period_s)
        };
        let crossings_s: Vec<f64> = (1..=ONSET_COUNTS).map_while(crossing).collect();
        let starts = (1 - STARTS / 2..STARTS / 2).map(|k| f64::from(k) / f64::from(STARTS));
        let best = starts.map(|start| start_of_parabola(&crossings_s, start)).min_by(|a, b| a.1.total_cmp(&b.1));
        let before = best.map_or(0.0, |(t_s, _)| (-t_s / period_s).max(0.0));
        last_at_rest.saturating_sub(before.round() as usize).max(ramp.start)
    }

    fn stretches(&self) -> Vec<std::ops::Range<usize>> {
        let (mut found, mut start) = (Vec::new(), 0);
        for part in self.voltage_v.chunk_by(|a, b| (self.sign * a > 0.0) == (self.sign * b > 0.0)) {
            if self.sign * part[0] > 0.0 {
                found.push(start..start + part.len());
            }
            start += part.len();
        }
        found
    }

    fn longest_stretch(&self) -> std::ops::Range<usize> {
        // Of several as long the first, which is the last in reverse.
        self.stretches().into_iter().rev().max_by_key(|stretch| stretch.len()).unwrap_or_default()
    }

    /// At rest within one count for the hold time before the ramp.
    fn expect_rest(&self, start: usize, rest: f64) -> Result<(), Error> {
        let still = |k: &usize| (self.theta_rad[*k] - rest).abs() < 1.5 * self.detection.resolution_rad;
        match (start.saturating_sub(self.hold)..start).find(|k| !still(k)) {
            None => Ok(()),
            Some(sample) => Err(Error::NotAtRest { voltage_v: self.voltage_v[sample], sample }),
        }
    }
}

/// t_0 of t_n = t_0 + q sqrt(n - 1/2 - start), n = 1, 2 .., by least squares, and the sum of squares that is left [s^2].
fn start_of_parabola(crossings_s: &[f64], start: f64) -> (f64, f64) {
    let root = |k: usize| (k as f64 + 0.5 - start).sqrt();
    let n = crossings_s.len() as f64;
    let (x, y) = ((0..crossings_s.len()).map(root).sum::<f64>() / n, crossings_s.iter().sum::<f64>() / n);
    let (mut xx, mut xy) = (0.0, 0.0);
    for (k, t) in crossings_s.iter().enumerate() {
        xx += (root(k) - x).powi(2);
        xy += (root(k) - x) * (t - y);
    }
    let q = if xx > 0.0 { xy / xx } else { 0.0 };
    let t_0 = y - q * x;
    let left = crossings_s.iter().enumerate().map(|(k, t)| (t - t_0 - q * root(k)).powi(2)).sum();
    (t_0, left)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::SlowRamp;

    const PERIOD_S: f64 = 0.002;

    /// A hub with Coulomb friction: still below the breakaway, first order above, read by an encoder.
    fn hub(voltage_v: &[f64], plus_v: f64, minus_v: f64) -> Vec<f64> {
        let (mut theta, mut speed) = (0.3, 0.0_f64);
        let resolution = Detection::default().resolution_rad;
        voltage_v
            .iter()
            .map(|&v| {
                let driving = if v > plus_v {
                    v - plus_v
                } else if v < minus_v {
                    v - minus_v
                } else {
                    0.0
                };
                speed += PERIOD_S * 30.0 * (1.86 * driving - speed);
                theta += PERIOD_S * speed;
                (theta / resolution).floor() * resolution
            })
            .collect()
    }

    #[test]
    fn both_breakaways_are_found_within_the_delay_of_half_a_count() {
        let v = SlowRamp::default().voltage(PERIOD_S);
        for (plus, minus) in [(0.28, -0.10), (0.05, -0.41)] {
            let found = breakaway(&v, &hub(&v, plus, minus), PERIOD_S, &Detection::default()).unwrap();
            assert!((0.0..0.01).contains(&(found.plus_v - plus)), "{found:?}");
            assert!((0.0..0.01).contains(&(minus - found.minus_v)), "{found:?}");
        }
    }

    #[test]
    fn a_flicker_of_one_count_is_no_movement() {
        let v = SlowRamp::default().voltage(PERIOD_S);
        let mut theta = hub(&v, 0.28, -0.10);
        let resolution = Detection::default().resolution_rad;
        (1000..7000).step_by(3).for_each(|k| theta[k] += resolution);
        // And a knock that comes back.
        (3000..3020).for_each(|k| theta[k] += 5.0 * resolution);
        let found = breakaway(&v, &theta, PERIOD_S, &Detection::default()).unwrap();
        assert!((found.plus_v - 0.28).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn a_stuck_hub_and_a_moving_one_are_refused() {
        let v = SlowRamp { peak_v: 0.2, ..SlowRamp::default() }.voltage(PERIOD_S);
        let refused = breakaway(&v, &hub(&v, 0.28, -0.10), PERIOD_S, &Detection::default());
        assert_eq!(refused, Err(Error::NeverMoved { direction: "forward", reached_v: 0.2 }));
        let drifting: Vec<f64> = (0..v.len()).map(|k| 0.001 * k as f64).collect();
        let refused = breakaway(&v, &drifting, PERIOD_S, &Detection::default());
        assert!(matches!(refused, Err(Error::NotAtRest { .. })), "{refused:?}");
    }

    #[test]
    fn thresholds_keep_the_residual_voltage() {
        let found = Breakaway { plus_v: 0.28, minus_v: -0.10, plus_sample: 0, minus_sample: 0 };
        let inverse = found.inverse_thresholds(Detection::default().resolution_rad);
        // The applied voltage reaches the breakaway exactly at the residual voltage, in the direction that is stiffer.
        let u = found.residual_v(&inverse);
        let applied = u + inverse.u_p_plus_v * (u / inverse.eps_u_v).min(1.0);
        assert!((applied - found.plus_v).abs() < 1e-12, "{applied}");
        let full = Thresholds { u_p_plus_v: 0.28, u_p_minus_v: 0.10, ..inverse };
        let design = 0.28 * inverse.eps_u_v / (0.28 + inverse.eps_u_v);
        assert!((found.residual_v(&full) - design).abs() < 1e-12);
        let switched = found.switched_thresholds(Detection::default().resolution_rad);
        assert!(switched.eps_u_v > switched.u_p_plus_v && switched.u_p_plus_v > found.plus_v);
        assert!(switched.u_p_minus_v > -found.minus_v);
    }
}
