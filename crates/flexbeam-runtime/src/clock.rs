//! The loop's clock: absolute deadlines, so that a late tick does not move the later ones.

use nix::errno::Errno;
use nix::sys::time::TimeSpec;
use nix::time::{ClockId, ClockNanosleepFlags, clock_gettime, clock_nanosleep};
use std::time::Duration;

/// Nanoseconds in a second.
pub const NS_PER_S: f64 = 1e9;

/// What the loop needs of a clock; a test brings its own.
pub trait Clock: Send {
    /// Real-time: yes. Now [ns], from an arbitrary origin; never runs backwards.
    fn now_ns(&self) -> u64;

    /// Real-time: yes. Returns at `deadline_ns`, or at once when that has passed.
    fn sleep_until(&mut self, deadline_ns: u64);
}

/// CLOCK_MONOTONIC.
#[derive(Clone, Copy, Debug, Default)]
pub struct Monotonic;

impl Clock for Monotonic {
    fn now_ns(&self) -> u64 {
        // The clock exists on every Linux. Without one every deadline is late, and the run ends as an overrun.
        clock_gettime(ClockId::CLOCK_MONOTONIC).map_or(u64::MAX, |now| Duration::from(now).as_nanos() as u64)
    }

    fn sleep_until(&mut self, deadline_ns: u64) {
        let deadline = TimeSpec::from_duration(Duration::from_nanos(deadline_ns));
        // A signal wakes the sleeper early; the deadline is absolute, so asking again is exact.
        while clock_nanosleep(ClockId::CLOCK_MONOTONIC, ClockNanosleepFlags::TIMER_ABSTIME, &deadline)
            == Err(Errno::EINTR)
        {}
    }
}

/// Which instant is due, and when.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Schedule {
    period_ns: u64,
    deadline_ns: u64,
    instant: u64,
}

/// One awakening.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Wake {
    /// Periods since the run began.
    pub instant: u64,
    /// From the deadline that was due to now [ns].
    pub lateness_ns: u64,
    /// Whole periods that passed without a tick.
    pub missed: u64,
    /// Now [ns].
    pub woke_ns: u64,
}

impl Schedule {
    /// The first instant is due at `start_ns`.
    pub(crate) fn new(start_ns: u64, period_ns: u64) -> Schedule {
        Schedule { period_ns: period_ns.max(1), deadline_ns: start_ns, instant: 0 }
    }

    /// Real-time: yes. Sleeps until the instant that is due; one that is missed by whole periods is not made up for.
    pub(crate) fn next(&mut self, clock: &mut impl Clock) -> Wake {
        clock.sleep_until(self.deadline_ns);
        let woke_ns = clock.now_ns();
        let lateness_ns = woke_ns.saturating_sub(self.deadline_ns);
        let missed = lateness_ns / self.period_ns;
        let instant = self.instant + missed;
        self.instant = instant + 1;
        self.deadline_ns = self.deadline_ns.saturating_add((missed + 1).saturating_mul(self.period_ns));
        Wake { instant, lateness_ns, missed, woke_ns }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Jumpy {
        now_ns: u64,
        late_ns: Vec<u64>,
    }

    impl Clock for Jumpy {
        fn now_ns(&self) -> u64 {
            self.now_ns
        }
        fn sleep_until(&mut self, deadline_ns: u64) {
            self.now_ns = self.now_ns.max(deadline_ns) + self.late_ns.pop().unwrap_or(0);
        }
    }

    #[test]
    fn a_late_tick_does_not_move_the_later_ones_and_whole_periods_are_skipped() {
        let mut clock = Jumpy { now_ns: 0, late_ns: vec![0, 0, 3500, 10, 0] };
        let mut schedule = Schedule::new(1000, 1000);
        let wakes: Vec<(u64, u64, u64)> =
            (0..5).map(|_| schedule.next(&mut clock)).map(|w| (w.instant, w.lateness_ns, w.missed)).collect();
        assert_eq!(wakes, [(0, 0, 0), (1, 10, 0), (5, 3500, 3), (6, 0, 0), (7, 0, 0)]);
    }

    #[test]
    fn the_monotonic_clock_sleeps_until_its_deadline_and_not_before() {
        let mut clock = Monotonic;
        let deadline = clock.now_ns() + 2_000_000;
        clock.sleep_until(deadline);
        let woke = clock.now_ns();
        assert!(woke >= deadline);
        clock.sleep_until(deadline); // already past: returns
        assert!(clock.now_ns() >= woke);
    }
}
