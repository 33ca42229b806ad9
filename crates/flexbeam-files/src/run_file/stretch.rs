//! The part of a run that is a recording: the controller ran, no tick is missing, every measurement is fresh.

use super::fault::RunFault;
use super::reader::RunRecording;
use super::sample::{RunColumns, RunPhase, RunSample};
use crate::fault::Fault;
use flexbeam_lti::{Mat, Signals};
use std::ops::Range;

/// The longest part of a run without a gap, and what kept it from being longer.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretch {
    /// Its samples, counted in the file.
    pub samples: Range<usize>,
    /// Samples of the running phase, in it or not.
    pub running: usize,
    /// Ticks that are missing between samples of the running phase.
    pub missed: u64,
    /// Samples of the running phase without a fresh measurement.
    pub stale: usize,
}

impl RunRecording {
    /// The longest stretch of samples of the running phase in which each tick follows the one before and each measurement is
    /// fresh; the first of several.
    pub fn longest_stretch(&self) -> Stretch {
        let mut search = StretchSearch::default();
        (0..self.samples.samples()).for_each(|k| search.take(&self.samples, k));
        search.found()
    }

    /// These samples as signals: every field but the tick.
    ///
    /// Assumes: the range lies within the samples; likewise below.
    pub fn signals(&self, samples: Range<usize>) -> Signals {
        let names = RunSample::NAMES[1..].iter().map(|name| name.to_string()).collect::<Vec<_>>();
        let units = RunSample::UNITS[1..].iter().map(|unit| unit.to_string()).collect();
        let rows = names.len();
        let data = samples.clone().filter_map(|k| self.samples.get(k)).flat_map(|sample| signal_values(&sample));
        let data = Mat::from_iterator(rows, samples.len(), data);
        Signals { names, units, period_s: self.header.period_s, data }
    }

    /// When these samples were taken, since the run began [s].
    pub fn time_s(&self, samples: Range<usize>) -> Vec<f64> {
        self.samples.tick[samples].iter().map(|tick| self.header.time_s(*tick)).collect()
    }

    /// What a person should know of a file that was cut off.
    pub fn cut_off_notice(&self) -> Option<String> {
        Some(self.cut_off?.notice(&self.source, self.samples.samples()))
    }
}

/// The fields of a sample but its tick.
pub(super) fn signal_values(sample: &RunSample) -> [f64; RunSample::SIGNALS.len()] {
    let [_, fields @ ..] = sample.values();
    fields
}

/// The search for the longest stretch, while samples come.
#[derive(Default)]
pub(super) struct StretchSearch {
    longest: Range<usize>,
    running: usize,
    missed: u64,
    stale: usize,
    /// Samples so far, and where the stretch began that the last one belongs to.
    count: usize,
    start: usize,
    /// Tick and whether the controller ran, of the sample before.
    before: Option<(u64, bool)>,
}

impl StretchSearch {
    /// Takes sample k of `columns`, the next one of the file.
    pub fn take(&mut self, columns: &RunColumns, k: usize) {
        let (tick, stale) = (columns.tick[k], columns.stale[k] != 0);
        let running = columns.phase[k] == RunPhase::Running as u8;
        self.running += usize::from(running);
        self.stale += usize::from(running && stale);
        let follows = self.before.is_some_and(|(before, _)| before.checked_add(1) == Some(tick));
        if let Some((before, true)) = self.before.filter(|_| running) {
            self.missed += tick.saturating_sub(before).saturating_sub(1);
        }
        self.count += 1;
        if !running || stale {
            self.start = self.count;
        } else if self.count - 1 > self.start && !follows {
            self.start = self.count - 1;
        }
        if self.count - self.start > self.longest.len() {
            self.longest = self.start..self.count;
        }
        self.before = Some((tick, running));
    }

    pub fn found(self) -> Stretch {
        Stretch { samples: self.longest, running: self.running, missed: self.missed, stale: self.stale }
    }
}

impl Stretch {
    /// What a person should know, where not all of the running phase is in it.
    ///
    /// Assumes: it holds a sample.
    pub(crate) fn notice(&self, period_s: f64) -> Option<String> {
        let Range { start, end } = self.samples;
        (self.samples.len() < self.running).then(|| {
            format!(
                "of {} samples while the controller ran, the longest stretch without a gap is taken: {} of them, \
                 {} s, from sample {start} to {}; ticks missing: {}, stale measurements: {}",
                self.running,
                self.samples.len(),
                self.samples.len() as f64 * period_s,
                end - 1,
                self.missed,
                self.stale
            )
        })
    }

    /// Errors: [`RunFault::ShortStretch`].
    pub(crate) fn check(&self, needed: usize) -> Result<(), Fault> {
        let found = self.samples.len();
        if found < needed { Err(RunFault::ShortStretch { found, needed }.into()) } else { Ok(()) }
    }
}
