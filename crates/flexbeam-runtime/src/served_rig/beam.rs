//! The simulated beam and the clock that it follows: the host's while a run lasts, the wall's while none does.

use flexbeam_rig::{Measurement, SimulatedRig};
use std::time::Instant;

/// What the wall clock may be ahead of a resting beam before the rest of it is left out [periods]: a computer that slept for a
/// night must not be made up for.
const MOST_BEHIND: u64 = 10_000;

/// A simulated rig in time.
pub struct Beam {
    /// The rig.
    pub rig: SimulatedRig,
    clock: Clock,
}

/// Whose time it is.
#[derive(Clone, Copy)]
enum Clock {
    /// The host's: a voltage stands.
    Host {
        voltage_v: f64,
        /// How often it may yet be repeated: no voltage stands longer than its hold.
        periods_left: u64,
        since: Instant,
    },
    /// The wall's, at 0 V: so many periods are done since then.
    Wall { since: Instant, done: u64 },
}

impl Beam {
    /// Real-time: no. At 0 V.
    pub fn new(rig: SimulatedRig) -> Beam {
        Beam { rig, clock: Clock::Wall { since: Instant::now(), done: 0 } }
    }

    /// Real-time: no. The sensors of now.
    pub fn measure(&mut self) -> Measurement {
        self.rig.measure()
    }

    /// Real-time: no. A new voltage stands for its first period.
    pub fn hold(&mut self, voltage_v: f64, hold_ms: u16) {
        self.rig.apply(voltage_v);
        let allowed = f64::from(hold_ms) / 1000.0 / self.rig.parameters().period_s;
        let periods_left = (allowed.ceil() as u64).saturating_sub(1);
        self.clock = Clock::Host { voltage_v, periods_left, since: Instant::now() };
    }

    /// Real-time: no. The voltage that stands does so for further periods, as many as its hold allows.
    pub fn stand(&mut self, periods: u64) {
        if let Clock::Host { voltage_v, periods_left, .. } = &mut self.clock {
            let periods = periods.min(*periods_left);
            *periods_left -= periods;
            (0..periods).for_each(|_| self.rig.apply(*voltage_v));
        }
    }

    /// Real-time: no. From now on 0 V and the wall clock; up to now the last voltage stood, by the wall clock, too.
    pub fn rest(&mut self) {
        if let Clock::Host { since, .. } = self.clock {
            self.stand(self.periods_since(since).saturating_sub(1));
        }
        self.clock = Clock::Wall { since: Instant::now(), done: 0 };
    }

    /// Real-time: no. Lets a beam without a run swing on.
    pub fn follow_the_wall_clock(&mut self) {
        let Clock::Wall { since, done } = self.clock else { return };
        let due = self.periods_since(since);
        (0..due.saturating_sub(done).min(MOST_BEHIND)).for_each(|_| self.rig.apply(0.0));
        self.clock = Clock::Wall { since, done: due };
    }

    /// Real-time: no.
    fn periods_since(&self, since: Instant) -> u64 {
        (since.elapsed().as_secs_f64() / self.rig.parameters().period_s) as u64
    }
}
