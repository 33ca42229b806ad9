//! The watchdog: a thread of its own that cuts the voltage off when the loop hangs where it cannot notice itself.

use crate::back_end::Cutoff;
use crate::clock::{Clock, Monotonic};
use crate::controls::Controls;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// The loop looks at its own lateness first; the watchdog bites when the loop did not even wake.
const PATIENCE: u64 = 2;

/// How often it looks, as a part of its patience.
const LOOKS: u64 = 8;
const SHORTEST_PAUSE: Duration = Duration::from_micros(100);
/// A patient watchdog still notices soon that the run is over.
const LONGEST_PAUSE: Duration = Duration::from_millis(10);

/// Real-time: yes. Looks until `done`; bites once, when a loop that has begun did not wake for two hold times and a period.
///
/// Returns: whether it bit.
pub(crate) fn watch(
    controls: &Controls,
    cutoff: Option<&dyn Cutoff>,
    period_ns: u64,
    hold_ns: u64,
    done: &AtomicBool,
) -> bool {
    let limit_ns = hold_ns.saturating_mul(PATIENCE).saturating_add(period_ns);
    let pause = Duration::from_nanos(limit_ns / LOOKS).clamp(SHORTEST_PAUSE, LONGEST_PAUSE);
    let (mut beats, mut since_ns) = (0, 0);
    while !done.load(Ordering::Acquire) {
        let now_ns = Monotonic.now_ns();
        if controls.beats() != beats {
            (beats, since_ns) = (controls.beats(), now_ns);
        }
        if beats != 0 && now_ns.saturating_sub(since_ns) > limit_ns {
            controls.bite();
            if let Some(cutoff) = cutoff {
                cutoff.cut();
            }
            return true;
        }
        std::thread::sleep(pause);
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::AtomicU32;

    struct Counting(Arc<AtomicU32>);

    impl Cutoff for Counting {
        fn cut(&self) {
            self.0.fetch_add(1, Ordering::SeqCst);
        }
    }

    #[test]
    fn a_loop_that_stops_beating_is_cut_off_once() {
        let (controls, cuts, done) = (Controls::default(), Arc::new(AtomicU32::new(0)), AtomicBool::new(false));
        controls.beat();
        assert!(watch(&controls, Some(&Counting(cuts.clone())), 1_000_000, 2_000_000, &done));
        assert!(controls.bitten());
        assert_eq!(cuts.load(Ordering::SeqCst), 1);
    }

    #[test]
    fn before_the_first_beat_and_after_the_end_it_rests() {
        let (controls, done) = (Controls::default(), AtomicBool::new(false));
        std::thread::scope(|scope| {
            let watching = scope.spawn(|| watch(&controls, None, 1_000_000, 1_000_000, &done));
            std::thread::sleep(Duration::from_millis(20));
            done.store(true, Ordering::Release);
            assert!(!watching.join().unwrap());
        });
        assert!(!controls.bitten());
    }
}
