//! `flexbeam rig test`: slow ramps in both directions, where the hub breaks away, and the settings that follow; with `--friction`
//! also runs at constant speed, and what rubs.

mod bench;
mod friction;
mod picture;
mod table;

use std::path::Path;

use flexbeam_files as files;
use flexbeam_files::{
    Controller, Document, FrictionResult, Layout, Overwrite, Recording, Rig, RigTestResult, json_text,
};
use flexbeam_ident::Error;
use flexbeam_ident::breakaway::{Breakaway, Detection, Thresholds, breakaway as breakaway_of, repeated as repeated_of};
use flexbeam_ident::excitation::SlowRamp;
use flexbeam_ident::friction::{Estimate, FrictionTest, friction as friction_test};
use flexbeam_lti::Signals;
use flexbeam_rig::{RigParameters, SimulatedRig, open_loop};
use flexbeam_runtime::port::Port;

use crate::identify::Hinted;
use crate::law::{test_result, with_thresholds};
use crate::output::{overwrite, say};
use crate::port::port;
use crate::record::{MOST_SAMPLES, Place};
use crate::rig_file::rig_parameters;
use crate::{Failure, cli};
use bench::Bench;

/// A ramp that cannot be driven.
#[derive(Debug, thiserror::Error)]
#[error("found {setting} {found}, needed a positive number\nhint: {hint}")]
struct NoRamp {
    setting: &'static str,
    found: f64,
    hint: &'static str,
}

/// A rig that ended its test.
#[derive(Debug, thiserror::Error)]
#[error("the rig test broke off, 0 V: {0}")]
struct BrokenOff(String);

/// The ramp of the command line's defaults.
///
/// The beam of the paper's rig swings on a stuck hub with a time constant of ten seconds; after two seconds of rest its swing
/// breaks the hub loose at 0.07 V in place of 0.10 V.
pub(crate) const RAMP: SlowRamp = SlowRamp { peak_v: 0.6, rate_v_s: 0.02, rest_s: 30.0 };

/// What a test or its recording says.
struct Measured {
    found: Breakaway,
    detection: Detection,
    repeated: Option<[Estimate; 2]>,
    friction: Option<FrictionTest>,
}

/// Sample period of a rig that is not simulated [s].
const PERIOD_S: f64 = 0.001;

/// `flexbeam rig test`.
pub fn run(arguments: &cli::RigTest) -> Result<(), Failure> {
    friction::check(arguments)?;
    let place = arguments.keep.as_deref().map(|csv| Place::free(csv, arguments.force)).transpose()?;
    arguments.write_rig.as_deref().map(|path| overwrite::<Rig>(path, arguments.force)).transpose()?;
    let controller = arguments.apply_to.as_deref().map(Controller::read).transpose()?;
    let parameters = rig_parameters(arguments.rig.as_deref())?;
    let measured = match &arguments.from {
        Some(path) => of_recording(arguments, path, &parameters)?,
        None => measured(arguments, &parameters, place.as_ref())?,
    };
    let law = law(arguments.law, controller.as_ref());
    let thresholds = match law {
        files::Law::Switched => measured.found.switched_thresholds(measured.detection.resolution_rad),
        _ => measured.found.inverse_thresholds(measured.detection.resolution_rad),
    };
    let rubs = measured.friction.as_ref().map(|test| told(arguments, test, &parameters)).transpose()?;
    if let (Some(controller), Some(path)) = (controller, &arguments.apply_to) {
        apply(controller, path, law, &measured.found, &thresholds)?;
    }
    let applied_to = arguments.apply_to.as_ref().map(|path| path.display().to_string());
    let result = RigTestResult {
        repeated: measured.repeated.map(friction::repeated_result),
        friction: rubs,
        ..test_result(law, &measured.found, &thresholds, applied_to)
    };
    answer(arguments, &result);
    Ok(())
}

/// The numbers of the runs; their rig file and their picture where they are asked for.
fn told(arguments: &cli::RigTest, test: &FrictionTest, parameters: &RigParameters) -> Result<FrictionResult, Failure> {
    let motor = friction::motor(arguments, parameters);
    let rubs = friction::result(test, &motor);
    friction::notes(test, &motor);
    if let Some(path) = &arguments.write_rig {
        friction::write_rig(path, arguments, &rubs)?;
    }
    if let Some(path) = &arguments.plots {
        picture::draw(path, test)?;
    }
    Ok(rubs)
}

/// Drives the rig: the simulated one with one ramp each way to the end, otherwise no further than the breakaway.
fn measured(
    arguments: &cli::RigTest,
    parameters: &RigParameters,
    place: Option<&Place<'_>>,
) -> Result<Measured, Failure> {
    let ramp = SlowRamp { peak_v: arguments.highest, rate_v_s: arguments.slope, rest_s: arguments.rest };
    let port = port(&arguments.link.port)?;
    let repeats = arguments.repeats.unwrap_or(if arguments.friction { 3 } else { 1 });
    if port == Port::Simulated && repeats == 1 && !arguments.friction && place.is_none() {
        let (found, detection) = breakaway(parameters, &ramp, arguments.seed)?;
        return Ok(Measured { found, detection, repeated: None, friction: None });
    }
    let period_s = if port == Port::Simulated { parameters.period_s } else { arguments.period.unwrap_or(PERIOD_S) };
    check(&ramp, period_s)?;
    let detection = detection(parameters);
    let mut bench = Bench::open(arguments, &port, parameters, period_s)?;
    let found = friction::pilot_ramps(&mut bench, &ramp, &detection)?;
    if repeats > 1 || arguments.friction {
        friction::ramps_and_runs(&mut bench, arguments, &found, parameters, repeats)?;
    }
    let signals = bench.recorded();
    // From all of it, so that --from a kept recording gives the same answer.
    let found = if repeats > 1 || arguments.friction { self::found(&signals, &detection)?.0 } else { found };
    if let Some(place) = place {
        let parents: Vec<&Path> = arguments.rig.iter().map(|path| path.as_path()).collect();
        place.write(&signals, &parents, None)?;
    }
    let repeated = (repeats > 1).then(|| repeated(&signals, parameters)).transpose().map_err(untold)?;
    let friction = arguments.friction.then(|| friction_of(&signals, parameters)).transpose().map_err(untold)?;
    Ok(Measured { found, detection, repeated, friction })
}

/// What a recording of such a test says.
///
/// Errors: a recording without ramps, and without `--friction` or runs that tell the voltage as well.
fn of_recording(arguments: &cli::RigTest, path: &Path, parameters: &RigParameters) -> Result<Measured, Failure> {
    let columns = Some(arguments.columns.clone()).filter(|columns| !columns.is_empty());
    let recording = Recording::read(path, &Layout { columns, period_s: arguments.period, resample_s: None })?.into_si();
    let signals = recording.select(&["voltage_v", "theta_rad", "alpha_rad"].map(String::from))?;
    let said = |why: Error| Failure::while_trying(format!("read a rig test in {}", path.display()))(Hinted(why));
    let detection = detection(parameters);
    let friction = arguments.friction.then(|| friction_of(&signals, parameters)).transpose().map_err(said)?;
    let repeated = repeated(&signals, parameters);
    if let Some(why) = friction.as_ref().and(repeated.as_ref().err()) {
        say(format_args!("no standard error of the breakaway: {why}"));
    }
    let row = friction::rows(&signals);
    let found = match (breakaway_of(&row[0], &row[1], signals.period_s, &detection), &friction) {
        (Ok(found), _) => found,
        (Err(why), None) => return Err(said(why)),
        (Err(why), Some(test)) => {
            say(format_args!("no slow ramp ({why}): the runs' voltage at standstill stands in for the breakaway"));
            at_standstill(test)
        }
    };
    Ok(Measured { found, detection, repeated: repeated.ok(), friction })
}

/// Where the curve of the steady runs meets zero speed: the breakaway of a hub that sticks no more than it rubs.
fn at_standstill(test: &FrictionTest) -> Breakaway {
    let rise_v = test.stribeck().map_or(0.0, |(extra, _)| extra.value);
    let (plus_v, minus_v) = (test.dry_plus_v().value + rise_v, -test.dry_minus_v().value - rise_v);
    Breakaway { plus_v, minus_v, plus_sample: 0, minus_sample: 0 }
}

fn untold(why: Error) -> Failure {
    Failure::while_trying(TRIED)(Hinted(why))
}

fn repeated(signals: &Signals, parameters: &RigParameters) -> Result<[Estimate; 2], Error> {
    let row = friction::rows(signals);
    let step_v = parameters.actuator.converter_step_v.unwrap_or(0.0);
    repeated_of(&row[0], &row[1], signals.period_s, &detection(parameters), step_v)
}

fn friction_of(signals: &Signals, parameters: &RigParameters) -> Result<FrictionTest, Error> {
    let row = friction::rows(signals);
    friction_test(&friction::recorded_of(&row, signals.period_s), &friction::options(parameters))
}

/// The breakaway voltages of the simulated rig, by a slow ramp in both directions, and how the movement was detected.
///
/// Errors: a ramp without height or slope; a hub that the ramp does not move.
pub(crate) fn breakaway(
    parameters: &RigParameters,
    ramp: &SlowRamp,
    seed: u64,
) -> Result<(Breakaway, Detection), Failure> {
    check(ramp, parameters.period_s)?;
    let mut rig = SimulatedRig::new(parameters, seed).map_err(Failure::while_trying(TRIED))?;
    let voltage_v = ramp.voltage(parameters.period_s);
    let signals = open_loop(&mut rig, &voltage_v).map_err(Failure::while_trying(TRIED))?;
    found(&signals, &detection(parameters))
}

const TRIED: &str = "measure the breakaway voltages";

fn check(ramp: &SlowRamp, period_s: f64) -> Result<(), Failure> {
    let positive = [
        ("a highest voltage of", ramp.peak_v, "well above the breakaway: --highest 0.6"),
        ("a slope of", ramp.rate_v_s, "slower than the hub can follow: --slope 0.02"),
        ("a rest of", ramp.rest_s, "until the beam stands still: --rest 30"),
        ("a period of", period_s, "1 ms suits the beam: --period 0.001"),
    ];
    if let Some(&(setting, found, hint)) = positive.iter().find(|(_, x, _)| !(*x > 0.0 && x.is_finite())) {
        return Err(Failure::while_trying(TRIED)(NoRamp { setting, found, hint }));
    }
    let samples = (3.0 * ramp.rest_s + 2.0 * ramp.peak_v / ramp.rate_v_s) / period_s;
    if samples <= MOST_SAMPLES {
        return Ok(());
    }
    let hint = "ramp and rests must fit into 10^8 periods: a steeper --slope, a shorter --rest";
    Err(Failure::while_trying(TRIED)(NoRamp { setting: "a test of samples", found: samples, hint }))
}

/// Where the hub broke away in a recorded ramp.
fn found(signals: &Signals, detection: &Detection) -> Result<(Breakaway, Detection), Failure> {
    let row = |k: usize| signals.data.row(k).iter().copied().collect::<Vec<f64>>();
    let found = breakaway_of(&row(0), &row(1), signals.period_s, detection);
    Ok((found.map_err(Hinted).map_err(Failure::while_trying(TRIED))?, *detection))
}

/// The encoder's resolution stands on its data sheet; an exact one is taken as the usual one.
fn detection(parameters: &RigParameters) -> Detection {
    let counts = parameters.sensors.encoder.counts_per_turn;
    let resolution_rad = counts.map(|counts| std::f64::consts::TAU / f64::from(counts));
    let usual = Detection::default();
    Detection { resolution_rad: resolution_rad.unwrap_or(usual.resolution_rad), ..usual }
}

/// The law asked for, that of the controller, or the inverse law.
fn law(asked: Option<cli::Law>, controller: Option<&Controller>) -> files::Law {
    let of_file = controller.and_then(|controller| controller.settings.law).unwrap_or(files::Law::Inverse);
    asked.map_or(of_file, files::Law::from)
}

/// The controller with these settings, in place of the old file.
fn apply(
    mut controller: Controller,
    path: &Path,
    law: files::Law,
    found: &Breakaway,
    thresholds: &Thresholds,
) -> Result<(), Failure> {
    controller.settings = with_thresholds(controller.settings, law, found, thresholds);
    controller.write(path, Overwrite::SameKind)?;
    eprintln!("{}: settings replaced; the certificate's figures of the linear loop stay as they were", path.display());
    Ok(())
}

fn answer(arguments: &cli::RigTest, result: &RigTestResult) {
    if arguments.json {
        println!("{}", json_text(result));
        return;
    }
    println!("{}", table::settings(result).text());
    if let Some(rubs) = &result.friction {
        println!("{}", table::friction(rubs).text());
    }
    if arguments.apply_to.is_none() {
        println!("next: flexbeam rig test --apply-to controller.toml writes these settings into a controller");
    }
}
