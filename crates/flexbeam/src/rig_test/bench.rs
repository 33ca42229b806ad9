//! A rig that takes one list of voltages after another: the simulated one out of time, any other on the clock.

use std::sync::atomic::Ordering;

use flexbeam_lti::{Mat, Signals};
use flexbeam_rig::{RigParameters, SimulatedRig, open_loop};
use flexbeam_runtime::back_end::BackEnd;
use flexbeam_runtime::port::Port;
use flexbeam_runtime::{Cause, FrozenLimit, Phase, Setup, drive, open_loop_setup};

use super::{BrokenOff, TRIED};
use crate::on_rig::{RigAt, from_zeroes, ready, signals_of, whole_in_memory};
use crate::{Failure, cli};

/// How often the simulated rig is asked whether it has turned enough [samples].
const LOOK: usize = 50;

/// The rig of one test, and all that it has recorded so far.
pub(super) struct Bench<'a> {
    rig: Kind<'a>,
    /// Sample period [s].
    pub period_s: f64,
    recorded: Vec<Signals>,
}

enum Kind<'a> {
    Simulated(Box<SimulatedRig>),
    OnClock(OnClock<'a>),
}

struct OnClock<'a> {
    port: &'a Port,
    /// None after a run that did not give it back.
    back_end: Option<Box<dyn BackEnd>>,
    setup: Setup,
}

impl<'a> Bench<'a> {
    /// Errors: a rig that cannot be opened or homed.
    pub fn open(
        arguments: &'a cli::RigTest,
        port: &'a Port,
        parameters: &'a RigParameters,
        period_s: f64,
    ) -> Result<Bench<'a>, Failure> {
        let rig = if *port == Port::Simulated {
            let rig = SimulatedRig::new(parameters, arguments.seed).map_err(Failure::while_trying(TRIED))?;
            Kind::Simulated(Box::new(rig))
        } else {
            let (link, seed, frozen) = (&arguments.link, arguments.seed, FrozenLimit::NEVER);
            let (back_end, setup) = ready(&RigAt { port, link, simulated: parameters, seed, frozen }, period_s)?;
            Kind::OnClock(OnClock { port, back_end: Some(back_end), setup })
        };
        Ok(Bench { rig, period_s, recorded: Vec::new() })
    }

    /// Sends these voltages until they are over or the hub has turned `most_rad` from where it began, and 0 V then.
    ///
    /// Returns: whether the hub turned that far.
    /// Errors: a rig that faulted or was stopped.
    pub fn send(&mut self, voltages_v: Vec<f64>, most_rad: f64) -> Result<bool, Failure> {
        let signals = match &mut self.rig {
            Kind::Simulated(rig) => simulated(rig, &voltages_v, most_rad)?,
            Kind::OnClock(rig) => rig.send(&voltages_v, self.period_s, most_rad)?,
        };
        let theta = signals.data.row(1);
        let far = (theta[theta.len() - 1] - theta[0]).abs() > most_rad;
        self.recorded.push(signals);
        Ok(far)
    }

    /// Everything in one recording, list behind list.
    ///
    /// Panics: before anything was sent.
    pub fn recorded(&self) -> Signals {
        joined(&self.recorded)
    }
}

fn simulated(rig: &mut SimulatedRig, voltages_v: &[f64], most_rad: f64) -> Result<Signals, Failure> {
    let start = rig.truth().theta_rad;
    let mut parts = Vec::new();
    for part in voltages_v.chunks(LOOK) {
        parts.push(open_loop(rig, part).map_err(Failure::while_trying(TRIED))?);
        if (rig.truth().theta_rad - start).abs() > most_rad {
            break;
        }
    }
    Ok(joined(&parts))
}

/// Panics: without a part.
fn joined(parts: &[Signals]) -> Signals {
    let columns: Vec<_> = parts.iter().flat_map(|part| part.data.column_iter()).collect();
    Signals { data: Mat::from_columns(&columns), ..parts[0].clone() }
}

impl OnClock<'_> {
    fn send(&mut self, voltages_v: &[f64], period_s: f64, most_rad: f64) -> Result<Signals, Failure> {
        let setup = open_loop_setup(voltages_v.into(), &self.setup.live.settings, &self.setup);
        let asked = setup.asked.clone();
        let mut start = None;
        let enough = move |sample: &flexbeam_runtime::Sample| {
            let theta = sample.measured.theta_rad;
            sample.phase == Phase::Running && (theta - *start.get_or_insert(theta)).abs() > most_rad
        };
        let back_end = self.back_end.take().expect("a run that went well gives its rig back");
        let (outcome, mut samples) = drive(back_end, setup, Vec::new(), enough)
            .map_err(Failure::while_trying(format!("drive the rig at {}", self.port)))?;
        let stopped = asked.load(Ordering::Acquire);
        let ended = matches!(outcome.report.cause, Cause::Over | Cause::Asked) && !stopped;
        if !ended {
            return Err(Failure::Fault(Box::new(BrokenOff(outcome.report.text))));
        }
        whole_in_memory(&outcome)?;
        self.back_end = outcome.back_end;
        let settings = &self.setup.live.settings;
        from_zeroes(&mut samples, [settings.theta.offset_rad, settings.alpha.offset_rad]);
        signals_of(&samples, period_s)
    }
}
