//! A dry run before arming: the loop's work on its clock, without the rig, to see whether the machine holds the period.

use crate::clock::{Clock, NS_PER_S, Schedule};
use crate::meter::Meter;
use crate::sample::Sample;
use flexbeam_kernel::{Controller, Measured, Settings, State, tick};

/// Length of a dry run [s], within the numbers of ticks below.
const LENGTH_S: f64 = 0.2;
const FEWEST_TICKS: u64 = 20;
const MOST_TICKS: u64 = 4000;

/// A machine holds a period when it misses fewer periods than this part of them: one stall on a shared machine is no verdict.
const MISSED_SHARE: f64 = 0.2;

/// The machine is too slow, or too busy, for the period.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "found that this machine cannot hold a period of {:.0} us: {missed} of {periods} periods passed without a tick in a dry run, before anything moved; needed fewer than 20 %\nhint: a period of {:.0} us would hold; design with --period {suggested_s}, or stop other programs and see the warnings above",
    period_s * 1e6, suggested_s * 1e6
)]
pub struct CannotHold {
    /// The period [s].
    pub period_s: f64,
    /// Periods without a tick.
    pub missed: u64,
    /// Periods in all.
    pub periods: u64,
    /// A period that this machine would have held [s].
    pub suggested_s: f64,
}

/// Real-time: yes. Ticks of a controller at rest, on the clock.
pub(crate) fn dry_run(
    clock: &mut impl Clock,
    period_ns: u64,
    controller: &Controller<'_>,
    state: &mut State<'_>,
) -> Meter {
    let ticks = ((LENGTH_S * NS_PER_S) as u64 / period_ns.max(1)).clamp(FEWEST_TICKS, MOST_TICKS);
    let mut meter = Meter::default();
    let mut schedule = Schedule::new(clock.now_ns().saturating_add(period_ns), period_ns);
    for _ in 0..ticks {
        let wake = schedule.next(clock);
        let commanded = tick(&Settings::default(), controller, state, Measured::default());
        std::hint::black_box(Sample { commanded, ..Sample::default() });
        meter.lateness.record(wake.lateness_ns);
        meter.execution.record(clock.now_ns().saturating_sub(wake.woke_ns));
        meter.missed += wake.missed;
    }
    state.reset();
    meter
}

/// Errors: [`CannotHold`], with a period that would have done.
pub(crate) fn judge(meter: &Meter, period_ns: u64) -> Result<(), CannotHold> {
    let periods = meter.lateness.count() + meter.missed;
    if (meter.missed as f64) < MISSED_SHARE * periods as f64 {
        return Ok(());
    }
    let needed_ns = meter.lateness.quantile_ns(0.9) + meter.execution.quantile_ns(0.9);
    let suggested_us = (1.5e-3 * needed_ns as f64).max(1.25e-3 * period_ns as f64).ceil();
    Err(CannotHold {
        period_s: period_ns as f64 / NS_PER_S,
        missed: meter.missed,
        periods,
        suggested_s: suggested_us * 1e-6,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A machine whose every look at the clock takes this long.
    struct Slow {
        now_ns: std::cell::Cell<u64>,
        look_ns: u64,
    }

    impl Clock for Slow {
        fn now_ns(&self) -> u64 {
            self.now_ns.set(self.now_ns.get() + self.look_ns);
            self.now_ns.get()
        }
        fn sleep_until(&mut self, deadline_ns: u64) {
            self.now_ns.set(self.now_ns.get().max(deadline_ns));
        }
    }

    fn judged(look_ns: u64, period_ns: u64) -> Result<(), CannotHold> {
        let coefficients = [1.0, 0.0, 0.0, 0.0];
        let controller = Controller::new(0, &coefficients).unwrap();
        let mut memory = [0.0; 3];
        let mut state = State::new(&controller, &mut memory).unwrap();
        let mut clock = Slow { now_ns: 0.into(), look_ns };
        judge(&dry_run(&mut clock, period_ns, &controller, &mut state), period_ns)
    }

    #[test]
    fn a_period_that_is_shorter_than_the_work_is_found() {
        assert_eq!(judged(100, 1_000_000), Ok(()));
        let refused = judged(3000, 1000).unwrap_err();
        assert!(refused.missed > refused.periods / 2, "{refused:?}");
        assert_eq!(judged(3000, (refused.suggested_s * NS_PER_S) as u64), Ok(()), "the suggestion holds");
    }
}
