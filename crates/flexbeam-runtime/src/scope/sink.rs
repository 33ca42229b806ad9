//! What brings a run to the scope, on the recorder's thread.

use super::hall::Hall;
use super::history::Row;
use crate::live::Live;
use crate::recorder::Recorded;
use crate::recording::{Calibration, RunContext, run_event, run_result, run_sample};
use crate::sample::Sample;
use crate::sink::{RunEvent, RunReport, Sink, SinkError};
use std::sync::Arc;

/// Brings viewers a run.
pub struct ScopeSink {
    hall: Arc<Hall>,
    context: RunContext,
    calibration: Calibration,
}

impl ScopeSink {
    pub(super) fn new(hall: Arc<Hall>, context: RunContext) -> ScopeSink {
        ScopeSink { hall, context, calibration: Calibration::default() }
    }
}

impl Sink for ScopeSink {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let mut row = run_sample(sample, &self.calibration);
        // A recording has the kernel's number, which is zero before the start.
        row.psi_rad = sample.tip_rad(&self.calibration.theta, &self.calibration.alpha);
        self.hall.history.push(Row::of(&row));
        Ok(())
    }

    fn settings(&mut self, _instant: u64, live: &Live) -> Result<(), SinkError> {
        self.calibration = Calibration::of(live);
        Ok(())
    }

    fn event(&mut self, event: &RunEvent) -> Result<(), SinkError> {
        self.hall.chronicle().push(run_event(event, self.context.period_s));
        Ok(())
    }

    fn finish(&mut self, report: &RunReport) -> Result<(), SinkError> {
        let recording = self.hall.about.recording.as_deref();
        let result = run_result(report, &Recorded::default(), &self.context, recording);
        self.hall.chronicle().end(result);
        Ok(())
    }
}
