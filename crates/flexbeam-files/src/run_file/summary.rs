//! What a recording of a run holds, without its samples.

use super::messages::{LiveSettings, RunEvent};
use super::reader::{CutOff, RunRecording};
use crate::results::ColumnSummary;
use serde::Serialize;

/// The answer of `flexbeam show` for a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunSummary<'a> {
    /// Number of samples, of every phase.
    pub samples: usize,
    /// Samples while the controller ran.
    pub running: usize,
    /// Ticks that are missing between those.
    pub missed: u64,
    /// Those without a fresh measurement.
    pub stale: usize,
    /// Sample period [s].
    pub period_s: f64,
    /// When tick 0 began, since 1970-01-01 UTC [ns].
    pub start_unix_ns: u64,
    /// The rig.
    pub port: &'a str,
    /// Every field but the tick.
    pub columns: Vec<ColumnSummary>,
    /// The settings at the start and each change.
    pub settings: &'a [LiveSettings],
    /// What happened.
    pub events: &'a [RunEvent],
    /// The report at the end; null where the run did not come to one.
    pub report: Option<&'a serde_json::Value>,
    /// Where the file ends too early; null when it does not.
    pub cut_off: Option<CutOff>,
}

impl RunRecording {
    /// A summary with these figures of the columns.
    pub fn summary(&self, columns: Vec<ColumnSummary>) -> RunSummary<'_> {
        let stretch = self.longest_stretch();
        RunSummary {
            samples: self.samples.samples(),
            running: stretch.running,
            missed: stretch.missed,
            stale: stretch.stale,
            period_s: self.header.period_s,
            start_unix_ns: self.header.start_unix_ns,
            port: &self.header.port,
            columns,
            settings: &self.settings,
            events: &self.events,
            report: self.report.as_ref(),
            cut_off: self.cut_off,
        }
    }
}
