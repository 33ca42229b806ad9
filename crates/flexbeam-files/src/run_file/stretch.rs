//! The part of a run that is a recording: the controller ran, no tick is missing, every measurement is fresh.

use super::fault::RunFault;
use super::reader::RunRecording;
use super::sample::{RunPhase, RunSample};
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
        let columns = &self.samples;
        let running = |k: usize| columns.phase[k] == RunPhase::Running as u8;
        let good = |k: usize| running(k) && columns.stale[k] == 0;
        let follows = |k: usize| columns.tick[k - 1].checked_add(1) == Some(columns.tick[k]);
        let mut found = Stretch { samples: 0..0, running: 0, missed: 0, stale: 0 };
        let mut start = 0;
        for k in 0..columns.samples() {
            found.running += usize::from(running(k));
            found.stale += usize::from(running(k) && columns.stale[k] != 0);
            if k > 0 && running(k) && running(k - 1) {
                found.missed += columns.tick[k].saturating_sub(columns.tick[k - 1]).saturating_sub(1);
            }
            if !good(k) {
                start = k + 1;
            } else if k > start && !follows(k) {
                start = k;
            }
            if k + 1 > start && k + 1 - start > found.samples.len() {
                found.samples = start..k + 1;
            }
        }
        found
    }

    /// These samples as signals: every field but the tick.
    ///
    /// Assumes: the range lies within the samples; likewise below.
    pub fn signals(&self, samples: Range<usize>) -> Signals {
        let names = RunSample::NAMES[1..].iter().map(|name| name.to_string()).collect::<Vec<_>>();
        let units = RunSample::UNITS[1..].iter().map(|unit| unit.to_string()).collect();
        let rows = names.len();
        let data = samples.clone().filter_map(|k| self.samples.get(k)).flat_map(|sample| {
            let [_, fields @ ..] = sample.values();
            fields
        });
        let data = Mat::from_iterator(rows, samples.len(), data);
        Signals { names, units, period_s: self.header.period_s, data }
    }

    /// When these samples were taken, since the run began [s].
    pub fn time_s(&self, samples: Range<usize>) -> Vec<f64> {
        self.samples.tick[samples].iter().map(|tick| self.header.time_s(*tick)).collect()
    }

    /// What a person should know of a file that was cut off.
    pub fn cut_off_notice(&self) -> Option<String> {
        let cut = self.cut_off?;
        Some(format!(
            "{} ends too early, as after a power loss: {} samples up to byte {} are whole, {} bytes after it are not used",
            self.source.display(),
            self.samples.samples(),
            cut.whole,
            cut.unused
        ))
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
