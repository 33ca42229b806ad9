//! A recording of a rig on the clock: as a run recording, which keeps everything, or as a table, which cannot have gaps.

use std::cell::Cell;

use flexbeam_files::{Excitation, Overwrite, RunFile, RunHeader, json_text};
use flexbeam_lti::Signals;
use flexbeam_rig::RigParameters;
use flexbeam_runtime::port::Port;
use flexbeam_runtime::{Cause, FrozenLimit, Outcome, RunContext, RunSink, Sample, Sink, run_result};

use crate::on_rig::{RigAt, drive_rig, signals_of, whole, whole_in_memory};
use crate::output::provenance;
use crate::port::now_unix_ns;
use crate::{Failure, cli};

/// A table that would have gaps.
#[derive(Debug, thiserror::Error)]
#[error(
    "found {missed} missed periods and {stale} ticks without a measurement, needed none: a table cannot say so\nhint: -o recording.mcap keeps what came, and identify takes its longest stretch without gaps"
)]
struct Gaps {
    missed: u64,
    stale: u64,
}

/// A rig that ended its recording.
#[derive(Debug, thiserror::Error)]
#[error("the recording broke off, 0 V: {0}")]
struct BrokenOff(String);

/// What is to be recorded, and where.
pub struct Recording<'a> {
    pub arguments: &'a cli::Record,
    pub port: &'a Port,
    pub parameters: &'a RigParameters,
    /// One voltage a period [V].
    pub voltage_v: &'a [f64],
}

impl Recording<'_> {
    /// As a table of signals.
    ///
    /// Errors: a rig that faulted, gaps.
    pub fn as_signals(&self) -> Result<Signals, Failure> {
        let (outcome, samples) = self.driven(|| Ok(Vec::new()))?;
        ended_well(&outcome)?;
        whole_in_memory(&outcome)?;
        let meter = &outcome.report.meter;
        if meter.missed + meter.stale > 0 {
            let gaps = Gaps { missed: meter.missed, stale: meter.stale };
            return Err(Failure::while_trying(format!("record {}", self.arguments.out.display()))(gaps));
        }
        signals_of(&samples, self.parameters.period_s)
    }

    /// As a run recording; it is kept when the rig faults, too.
    ///
    /// Errors: a rig that faulted, a file that cannot be written.
    pub fn as_run(&self, planned: Excitation) -> Result<(), Failure> {
        let out = &self.arguments.out;
        let overwrite = if self.arguments.force { Overwrite::Allow } else { Overwrite::SameKind };
        RunFile::check_free(out, overwrite)?;
        let context = RunContext { port: self.port.to_string(), period_s: self.parameters.period_s };
        let begun = Cell::new(false);
        let sink = || -> Result<Vec<Box<dyn Sink>>, Failure> {
            let file = RunFile::create(out, overwrite, &self.header(planned)?)?;
            begun.set(true);
            Ok(vec![Box::new(RunSink::new(file, out, context.clone()))])
        };
        let (outcome, _) = self.driven(sink).inspect_err(|_| {
            if begun.get() {
                // Nothing ran, so nothing is worth keeping.
                let _ = std::fs::remove_file(RunFile::part_path(out));
            }
        })?;
        let result = run_result(&outcome.report, &outcome.recorded, &context, Some(out));
        if self.arguments.json {
            println!("{}", json_text(&result));
        } else {
            println!(
                "{}: {} ticks, {} missed, {} without measurement",
                out.display(),
                result.ticks,
                result.missed,
                result.stale
            );
            println!("next: flexbeam identify {} --block-rows 50", out.display());
        }
        ended_well(&outcome)?;
        whole(&outcome.recorded, out, result.unrecorded)
    }

    fn header(&self, planned: Excitation) -> Result<RunHeader, Failure> {
        let parents: Vec<_> = self.arguments.rig.iter().map(|path| path.as_path()).collect();
        Ok(RunHeader {
            period_s: self.parameters.period_s,
            start_unix_ns: now_unix_ns(),
            port: self.port.to_string(),
            provenance: provenance(&parents, &self.arguments.out)?,
            controller: None,
            excitation: Some(planned),
        })
    }

    fn driven(
        &self,
        sinks: impl FnOnce() -> Result<Vec<Box<dyn Sink>>, Failure>,
    ) -> Result<(Outcome, Vec<Sample>), Failure> {
        let Recording { arguments, port, parameters, voltage_v } = self;
        let rig = RigAt {
            port,
            link: &arguments.link,
            simulated: parameters,
            seed: !arguments.seed,
            frozen: FrozenLimit::default(),
        };
        drive_rig(&rig, parameters.period_s, voltage_v, sinks)
    }
}

fn ended_well(outcome: &Outcome) -> Result<(), Failure> {
    match outcome.report.cause {
        Cause::Over | Cause::Asked => Ok(()),
        Cause::Fault(_) => Err(Failure::Fault(Box::new(BrokenOff(outcome.report.text.clone())))),
    }
}
