//! A rig that takes one list of voltages after another: the simulated one out of time, any other on the clock.

use std::sync::atomic::Ordering;

use flexbeam_lti::{Mat, Signals};
use flexbeam_rig::{RigParameters, SimulatedRig, open_loop};
use flexbeam_runtime::back_end::BackEnd;
use flexbeam_runtime::port::Port;
use flexbeam_runtime::{Cause, FrozenLimit, Phase, Sample, Setup, drive, open_loop_setup};

use super::{BrokenOff, TRIED};
use crate::on_rig::{RigAt, from_zeroes, ready, signals_of, whole_in_memory};
use crate::output::say;
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
    OnClock(Box<OnClock<'a>>),
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
            Kind::OnClock(Box::new(OnClock { port, back_end: Some(back_end), setup }))
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
        let enough = move |sample: &Sample| {
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
        let samples = without_gaps(&samples).map_err(Failure::while_trying(TRIED))?;
        signals_of(&samples, period_s)
    }
}

/// Longest gap over which a line stands in for readings of a hub that moves [periods]: a tenth of the shortest window that the test
/// looks through.
const LONGEST_GAP: u64 = 17;
/// A hub that moved no further over a gap rested [rad]: one count and a half.
const AT_REST_RAD: f64 = 1.5 * std::f64::consts::TAU / 4096.0;

/// Too long without a reading.
#[derive(Debug, thiserror::Error)]
#[error(
    "found {0} periods in a row without a reading while the hub moved, needed at most {LONGEST_GAP}\nhint: stop other programs, or give the loop a core of its own: --core"
)]
struct Gap(u64);

/// The running samples, with a line over the angles where periods were missed or measurements did not come; the voltage stood there.
///
/// Errors: [`Gap`].
fn without_gaps(samples: &[Sample]) -> Result<Vec<Sample>, Gap> {
    let fresh: Vec<&Sample> = samples.iter().filter(|s| s.phase == Phase::Running && !s.stale).collect();
    let mut whole: Vec<Sample> = fresh.first().map(|first| **first).into_iter().collect();
    for pair in fresh.windows(2) {
        let (before, next) = (pair[0], pair[1]);
        let periods = next.instant - before.instant;
        let moved = (next.measured.theta_rad - before.measured.theta_rad).abs() > AT_REST_RAD;
        if moved && periods > LONGEST_GAP + 1 {
            return Err(Gap(periods - 1));
        }
        let part = |k: u64, from: f64, to: f64| from + (to - from) * k as f64 / periods as f64;
        whole.extend((1..periods).map(|k| {
            let mut between = Sample { instant: before.instant + k, ..*before };
            between.measured.theta_rad = part(k, before.measured.theta_rad, next.measured.theta_rad);
            between.measured.alpha_rad = part(k, before.measured.alpha_rad, next.measured.alpha_rad);
            between
        }));
        whole.push(*next);
    }
    let filled = whole.len() - fresh.len();
    if filled > 0 {
        say(format_args!(
            "{filled} of {} periods had no reading; a line between their neighbours stands in",
            whole.len()
        ));
    }
    Ok(whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(instant: u64, theta_rad: f64) -> Sample {
        let mut sample = Sample { instant, phase: Phase::Running, stale: false, voltage_v: 0.5, ..Sample::default() };
        sample.measured.theta_rad = theta_rad;
        sample
    }

    #[test]
    fn a_short_gap_is_a_line_and_a_long_one_is_refused() {
        let stale = Sample { stale: true, ..sample(2, 9.0) };
        let whole = without_gaps(&[sample(0, 0.0), sample(1, 0.1), stale, sample(4, 0.4)]).unwrap();
        assert_eq!(whole.len(), 5);
        for (k, sample) in whole.iter().enumerate() {
            assert_eq!((sample.instant, sample.voltage_v), (k as u64, 0.5));
            assert!((sample.measured.theta_rad - 0.1 * k as f64).abs() < 1e-15, "{k}");
        }
        assert!(matches!(without_gaps(&[sample(0, 0.0), sample(30, 1.0)]), Err(Gap(29))));
        assert_eq!(without_gaps(&[sample(0, 0.0), sample(30, 0.001)]).unwrap().len(), 31, "at rest");
    }
}
