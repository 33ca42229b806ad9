//! The newest sample, for whoever looks: the terminal, the control socket.

use crate::meter::Times;
use crate::sample::Sample;
use crate::sink::{RunEvent, Sink, SinkError};
use std::sync::{Arc, Mutex, PoisonError};

/// Holds the newest sample and the events so far. Only the recorder's thread writes, never the loop's.
#[derive(Clone, Debug, Default)]
pub struct Latest(Arc<Mutex<Seen>>);

#[derive(Debug, Default)]
struct Seen {
    sample: Option<Sample>,
    events: Vec<RunEvent>,
    lateness: Times,
    missed: u64,
    stale: u64,
}

/// How the clock was kept, as a viewer sees it on the way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SeenTiming {
    /// Ticks that were seen.
    pub ticks: u64,
    /// Lateness: median [ns].
    pub median_ns: u64,
    /// Lateness below which 99 % of the ticks lie [ns].
    pub p99_ns: u64,
    /// Largest lateness [ns].
    pub max_ns: u64,
    /// Periods without a sample.
    pub missed: u64,
    /// Samples without a fresh measurement.
    pub stale: u64,
}

impl Latest {
    fn lock(&self) -> std::sync::MutexGuard<'_, Seen> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The newest sample.
    pub fn get(&self) -> Option<Sample> {
        self.lock().sample
    }

    /// How the clock was kept so far.
    pub fn timing(&self) -> SeenTiming {
        let seen = self.lock();
        SeenTiming {
            ticks: seen.lateness.count(),
            median_ns: seen.lateness.quantile_ns(0.5),
            p99_ns: seen.lateness.quantile_ns(0.99),
            max_ns: seen.lateness.max_ns(),
            missed: seen.missed,
            stale: seen.stale,
        }
    }

    /// Events after the first `known` ones.
    pub fn events_after(&self, known: usize) -> Vec<RunEvent> {
        self.lock().events.get(known..).unwrap_or_default().to_vec()
    }
}

impl Sink for Latest {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let mut seen = self.lock();
        let before = seen.sample.replace(*sample);
        let gap = before.map_or(0, |before| sample.instant.saturating_sub(before.instant + 1));
        seen.missed += gap;
        seen.stale += u64::from(sample.stale && sample.phase.is_alive());
        seen.lateness.record(sample.lateness_ns);
        Ok(())
    }

    fn event(&mut self, event: &RunEvent) -> Result<(), SinkError> {
        self.lock().events.push(event.clone());
        Ok(())
    }
}
