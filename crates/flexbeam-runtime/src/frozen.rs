//! An encoder that stands still while the voltage must move the hub: its cable came off, the hub is blocked, the amplifier is off.
//!
//! The gauge is not looked at: at a steady speed its converter may well give the same number for a while.

use flexbeam_rig::Measurement;

/// When the encoder counts as frozen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrozenLimit {
    /// Above this voltage the hub moves [V]; well above the breakaway voltage. Default 1.
    pub voltage_v: f64,
    /// For how long not a count may change under such a voltage [s]. Default 0.25.
    pub time_s: f64,
}

impl Default for FrozenLimit {
    fn default() -> FrozenLimit {
        FrozenLimit { voltage_v: 1.0, time_s: 0.25 }
    }
}

impl FrozenLimit {
    /// For a run that is to find out whether the hub moves.
    pub const NEVER: FrozenLimit = FrozenLimit { voltage_v: f64::INFINITY, time_s: f64::INFINITY };

    /// From breakaway voltages as they were measured, either way: half as much again and 0.1 V; the default where none was.
    pub fn above_breakaway(plus_v: f64, minus_v: f64) -> FrozenLimit {
        let largest_v = plus_v.max(minus_v);
        let voltage_v = if largest_v > 0.0 { 1.5 * largest_v + 0.1 } else { FrozenLimit::default().voltage_v };
        FrozenLimit { voltage_v, ..FrozenLimit::default() }
    }
}

/// Looks at every measurement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrozenWatch {
    voltage_v: f64,
    limit_ns: u64,
    last: Option<u64>,
    still_ns: u64,
}

impl FrozenWatch {
    pub(crate) fn new(limit: &FrozenLimit) -> FrozenWatch {
        let limit_ns = (limit.time_s * crate::clock::NS_PER_S) as u64;
        FrozenWatch { voltage_v: limit.voltage_v, limit_ns, last: None, still_ns: 0 }
    }

    /// Real-time: yes. For how long the encoder has been frozen, once that is too long [ns].
    pub(crate) fn look(&mut self, measured: &Measurement, voltage_v: f64, period_ns: u64) -> Option<u64> {
        let bits = measured.theta_rad.to_bits();
        let moves = voltage_v.abs() > self.voltage_v;
        let still = self.last == Some(bits) && moves;
        self.still_ns = if still { self.still_ns.saturating_add(period_ns) } else { 0 };
        self.last = Some(bits);
        (self.still_ns > self.limit_ns).then_some(self.still_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STILL: Measurement = Measurement { theta_rad: 0.1, alpha_rad: -0.2 };

    #[test]
    fn a_still_encoder_under_a_moving_voltage_is_frozen_after_its_time() {
        let limit = FrozenLimit { voltage_v: 0.5, time_s: 0.003 };
        let mut watch = FrozenWatch::new(&limit);
        let found: Vec<Option<u64>> = (0..6).map(|_| watch.look(&STILL, -0.6, 1_000_000)).collect();
        assert_eq!(found, [None, None, None, None, Some(4_000_000), Some(5_000_000)]);
    }

    #[test]
    fn rest_at_a_small_voltage_and_a_single_count_are_not() {
        let mut watch = FrozenWatch::new(&FrozenLimit { voltage_v: 0.5, time_s: 0.003 });
        assert!((0..100).all(|_| watch.look(&STILL, 0.5, 1_000_000).is_none()));
        let flicker = Measurement { theta_rad: f64::from_bits(STILL.theta_rad.to_bits() + 1), ..STILL };
        let readings = [STILL, flicker].into_iter().cycle().take(100);
        assert!(readings.into_iter().all(|m| watch.look(&m, 5.0, 1_000_000).is_none()));
    }

    #[test]
    fn the_voltage_follows_from_the_breakaway() {
        assert_eq!(FrozenLimit::above_breakaway(0.0, 0.0), FrozenLimit::default());
        assert!((FrozenLimit::above_breakaway(0.28, 0.10).voltage_v - 0.52).abs() < 1e-12);
    }
}
