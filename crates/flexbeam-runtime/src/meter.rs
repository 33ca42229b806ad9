//! How well the loop kept its time: lateness, time of a whole period's work, time of the kernel's tick, page faults.

use hdrhistogram::Histogram;
use nix::sys::resource::{UsageWho, getrusage};

/// Longest time that is told apart [ns]: ten seconds; longer ones count as this.
const LONGEST_NS: u64 = 10_000_000_000;

/// Significant digits of the histograms: 0.1 % of the value.
const DIGITS: u8 = 3;

/// Times of many ticks, as a histogram of fixed size.
#[derive(Clone, Debug)]
pub struct Times(Histogram<u64>);

impl Default for Times {
    fn default() -> Times {
        Times::new()
    }
}

impl Times {
    /// Real-time: no. An empty histogram whose memory has been touched.
    pub fn new() -> Times {
        let mut histogram = Histogram::new_with_bounds(1, LONGEST_NS, DIGITS).expect("bounds that hdrhistogram takes");
        // Writing to every counter brings its page in now rather than at the first late tick.
        histogram.clear();
        Times(histogram)
    }

    /// Real-time: yes. One more time [ns].
    pub fn record(&mut self, ns: u64) {
        self.0.saturating_record(ns);
    }

    /// Time below which this part of the ticks lies [ns]; 0.5 is the median.
    pub fn quantile_ns(&self, part: f64) -> u64 {
        self.0.value_at_quantile(part)
    }

    /// The longest [ns].
    pub fn max_ns(&self) -> u64 {
        self.0.max()
    }

    /// Number of ticks.
    pub fn count(&self) -> u64 {
        self.0.len()
    }

    /// Part of the ticks that took longer than this.
    pub fn share_above(&self, ns: u64) -> f64 {
        1.0 - self.0.quantile_below(ns)
    }

    /// Adds the ticks of another run.
    pub fn add(&mut self, other: &Times) {
        self.0.add(&other.0).expect("both histograms have the same bounds");
    }
}

/// Page faults of this thread so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PageFaults {
    /// Without reading a disk.
    pub minor: u64,
    /// With.
    pub major: u64,
}

impl PageFaults {
    /// Real-time: yes. What the system has counted for the calling thread.
    pub fn of_this_thread() -> PageFaults {
        let usage = getrusage(UsageWho::RUSAGE_THREAD).ok();
        let count = |faults: i64| u64::try_from(faults).unwrap_or(0);
        usage.map_or(PageFaults::default(), |u| PageFaults {
            minor: count(u.minor_page_faults()),
            major: count(u.major_page_faults()),
        })
    }

    /// Real-time: yes. Those since `before`.
    pub fn since(self, before: PageFaults) -> PageFaults {
        PageFaults { minor: self.minor.saturating_sub(before.minor), major: self.major.saturating_sub(before.major) }
    }
}

/// What the loop measures of itself.
#[derive(Clone, Debug, Default)]
pub struct Meter {
    /// From each deadline to the awakening.
    pub lateness: Times,
    /// From the awakening until the period's work was done: back end, tick, hand-over to the recorder.
    pub execution: Times,
    /// The kernel's tick alone.
    pub tick: Times,
    /// Periods that passed without a tick.
    pub missed: u64,
    /// Ticks without a fresh measurement.
    pub stale: u64,
    /// Samples that found the way to the recorder full.
    pub unrecorded: u64,
    /// Page faults between the first tick and the last.
    pub page_faults: PageFaults,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_times() {
        let mut times = Times::new();
        (1..=1000).for_each(|us| times.record(us * 1000));
        for (part, us) in [(0.5, 500.0), (0.99, 990.0), (1.0, 1000.0)] {
            let found = times.quantile_ns(part) as f64 / 1000.0;
            assert!((found / us - 1.0).abs() < 2e-3, "{part}: {found}");
        }
        assert!((times.share_above(900_000) - 0.1).abs() < 2e-3);
        assert_eq!(times.count(), 1000);
    }

    #[test]
    fn times_beyond_the_bounds_count_as_the_longest() {
        let mut times = Times::new();
        times.record(u64::MAX);
        times.record(0);
        assert!(times.max_ns() >= LONGEST_NS && times.count() == 2);
    }

    #[test]
    fn touching_new_memory_is_a_page_fault_that_is_counted() {
        let before = PageFaults::of_this_thread();
        let mut pages = vec![0u8; 64 * 4096];
        pages.iter_mut().step_by(4096).for_each(|byte| *byte = 1);
        let faults = PageFaults::of_this_thread().since(before);
        assert!(std::hint::black_box(&pages)[0] == 1 && faults.minor > 0);
    }
}
