//! The recorder's file: what the loop says, as the messages of a run recording.

use crate::back_end::Counters;
use crate::cause::{Cause, RunFault};
use crate::kernel_settings::table_of;
use crate::lifecycle::Phase;
use crate::live::Live;
use crate::meter::Times;
use crate::recorder::Recorded;
use crate::reference::{Reference, Shape};
use crate::sample::Sample;
use crate::sink::{RunEvent, RunReport, Sink, SinkError};
use flexbeam_files as files;
use flexbeam_files::{
    LinkCounts, LiveSettings, RunFile, RunPhase, RunReference, RunResult, RunSample, RunShape, TimeQuantiles,
};
use flexbeam_kernel::Channel;
use std::path::{Path, PathBuf};

/// What a report does not know of itself.
#[derive(Clone, Debug, PartialEq)]
pub struct RunContext {
    /// The rig.
    pub port: String,
    /// Sample period [s].
    pub period_s: f64,
}

/// Scales and zeroes of the sensors, which stay as they are for the whole run.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Calibration {
    pub(crate) theta: Channel,
    pub(crate) alpha: Channel,
}

impl Calibration {
    pub(crate) fn of(live: &Live) -> Calibration {
        Calibration { theta: live.settings.theta, alpha: live.settings.alpha }
    }
}

/// Writes a run's recording.
pub struct RunSink {
    /// Gone after it was finished.
    file: Option<RunFile>,
    path: PathBuf,
    context: RunContext,
    /// Samples that a power loss would take.
    at_risk: u64,
    calibration: Calibration,
}

impl RunSink {
    /// Real-time: no. Over a file that has just been begun; `path` is for messages.
    pub fn new(file: RunFile, path: &Path, context: RunContext) -> RunSink {
        RunSink { file: Some(file), path: path.to_path_buf(), context, at_risk: 0, calibration: Calibration::default() }
    }

    fn write(&mut self, what: impl FnOnce(&mut RunFile) -> Result<(), files::Error>) -> Result<(), SinkError> {
        let written = self.file.as_mut().map_or(Ok(()), what);
        written.map_err(|error| self.failed(&error))
    }

    fn failed(&self, error: &files::Error) -> SinkError {
        SinkError { sink: self.path.display().to_string(), reason: error.to_string(), lost: self.at_risk }
    }
}

impl Sink for RunSink {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.at_risk += 1;
        let sample = run_sample(sample, &self.calibration);
        self.write(|file| file.sample(&sample))
    }

    fn settings(&mut self, instant: u64, live: &Live) -> Result<(), SinkError> {
        self.calibration = Calibration::of(live);
        self.write(|file| file.settings(&run_settings(instant, live)))
    }

    fn event(&mut self, event: &RunEvent) -> Result<(), SinkError> {
        let event = run_event(event, self.context.period_s);
        self.write(|file| file.event(&event))
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        self.write(RunFile::flush)?;
        self.at_risk = 0;
        Ok(())
    }

    fn finish(&mut self, report: &RunReport) -> Result<(), SinkError> {
        let Some(file) = self.file.take() else { return Ok(()) };
        let result = run_result(report, &Recorded::default(), &self.context, Some(&self.path));
        file.finish(&result).map(drop).map_err(|error| self.failed(&error))
    }
}

/// Real-time: no. How a run went, for answers and recordings.
pub fn run_result(
    report: &RunReport,
    recorded: &Recorded,
    context: &RunContext,
    recording: Option<&Path>,
) -> RunResult {
    let meter = &report.meter;
    let cause = match report.cause {
        Cause::Over => "over",
        Cause::Asked => "asked",
        Cause::Fault(_) => "fault",
    };
    RunResult {
        cause: cause.into(),
        text: report.text.clone(),
        port: context.port.clone(),
        period_s: context.period_s,
        ticks: meter.lateness.count(),
        missed: meter.missed,
        stale: meter.stale,
        unrecorded: meter.unrecorded + recorded.refused,
        link: link_counts(report.link),
        lateness: quantiles(&meter.lateness),
        execution: quantiles(&meter.execution),
        tick: quantiles(&meter.tick),
        page_faults: meter.page_faults.minor + meter.page_faults.major,
        warnings: report.warnings.clone(),
        recording: recording.map(|path| path.display().to_string()),
    }
}

fn link_counts(counters: Counters) -> LinkCounts {
    let Counters { lost, late, duplicate, corrupt, foreign } = counters;
    LinkCounts { lost, late, duplicate, corrupt, foreign }
}

fn quantiles(times: &Times) -> TimeQuantiles {
    let seconds = |ns: u64| ns as f64 * 1e-9;
    TimeQuantiles {
        median_s: seconds(times.quantile_ns(0.5)),
        p99_s: seconds(times.quantile_ns(0.99)),
        p999_s: seconds(times.quantile_ns(0.999)),
        max_s: seconds(times.max_ns()),
    }
}

/// Real-time: no. The sample as a recording has it. The angles are from their zeroes, so that who reads the columns need not know of them; unfiltered.
pub(crate) fn run_sample(sample: &Sample, calibration: &Calibration) -> RunSample {
    let short = |ns: u64| u32::try_from(ns).unwrap_or(u32::MAX);
    let phase = match sample.phase {
        Phase::Configured | Phase::Armed => RunPhase::Armed,
        Phase::Running => RunPhase::Running,
        Phase::Stopped | Phase::Faulted => RunPhase::Stopped,
    };
    let commanded = &sample.commanded;
    RunSample {
        tick: sample.instant,
        voltage_v: sample.voltage_v,
        commanded_v: commanded.voltage_v,
        u_v: commanded.u_v,
        reference_rad: sample.reference_rad,
        smoothed_rad: commanded.reference_rad,
        theta_rad: calibration.theta.scaled(sample.measured.theta_rad),
        alpha_rad: calibration.alpha.scaled(sample.measured.alpha_rad),
        psi_rad: commanded.y_rad,
        y_model_rad: commanded.y_model_rad,
        error_rad: commanded.error_rad,
        lateness_ns: short(sample.lateness_ns),
        execution_ns: short(sample.execution_ns),
        settings: sample.revision,
        phase: phase as u8,
        fault: sample.fault.map_or(0, RunFault::code),
        stale: u8::from(sample.stale),
    }
}

/// Real-time: no. The settings that are in force from an instant on, as a recording has them.
pub fn run_settings(instant: u64, live: &Live) -> LiveSettings {
    let (settings, reference) = (table_of(&live.settings), run_reference(&live.reference));
    LiveSettings { revision: live.revision, tick: instant, settings, reference }
}

/// Real-time: no. The event as a recording has it.
pub(crate) fn run_event(event: &RunEvent, period_s: f64) -> files::RunEvent {
    let RunEvent { instant, kind, text } = event;
    files::RunEvent { tick: *instant, time_s: *instant as f64 * period_s, kind: kind.name().into(), text: text.clone() }
}

fn run_reference(reference: &Reference) -> RunReference {
    RunReference {
        shape: shape_of_run(reference.shape),
        amplitude_rad: reference.amplitude_rad,
        period_s: reference.period_s,
        offset_rad: reference.offset_rad,
    }
}

/// The shape as a file names it.
pub fn shape_of_run(shape: Shape) -> RunShape {
    match shape {
        Shape::Step => RunShape::Step,
        Shape::Square => RunShape::Square,
        Shape::Sine => RunShape::Sine,
        Shape::Sawtooth => RunShape::Sawtooth,
        Shape::File => RunShape::File,
    }
}

/// The generator's shape.
pub fn shape_of_file(shape: RunShape) -> Shape {
    match shape {
        RunShape::Step => Shape::Step,
        RunShape::Square => Shape::Square,
        RunShape::Sine => Shape::Sine,
        RunShape::Sawtooth => Shape::Sawtooth,
        RunShape::File => Shape::File,
    }
}
