//! `flexbeam rig test`: a slow ramp in both directions, where the hub breaks away, and the settings that follow.

use std::path::Path;

use flexbeam_files as files;
use flexbeam_files::{Controller, Document, Overwrite, json_text};
use flexbeam_ident::breakaway::{Breakaway, Detection, Thresholds, breakaway as breakaway_of};
use flexbeam_ident::excitation::SlowRamp;
use flexbeam_lti::Signals;
use flexbeam_report::{Cell, Table};
use flexbeam_rig::{RigParameters, SimulatedRig, open_loop};
use flexbeam_runtime::port::Port;
use flexbeam_runtime::{Cause, FrozenLimit};

use crate::identify::Hinted;
use crate::law::{residual_v, test_result, with_thresholds};
use crate::on_rig::{RigAt, drive_rig, signals_of, whole_in_memory};
use crate::port::port;
use crate::record::MOST_SAMPLES;
use crate::rig_file::rig_parameters;
use crate::{Failure, cli};

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

/// `flexbeam rig test`.
pub fn run(arguments: &cli::RigTest) -> Result<(), Failure> {
    let controller = arguments.apply_to.as_deref().map(Controller::read).transpose()?;
    let parameters = rig_parameters(arguments.rig.as_deref())?;
    let ramp = SlowRamp { peak_v: arguments.highest, rate_v_s: arguments.slope, rest_s: arguments.rest };
    let (found, detection) = match port(&arguments.link.port)? {
        Port::Simulated => breakaway(&parameters, &ramp, arguments.seed)?,
        port => {
            let rig = RigAt {
                port: &port,
                link: &arguments.link,
                simulated: &parameters,
                seed: arguments.seed,
                frozen: FrozenLimit::NEVER,
            };
            breakaway_at(&rig, arguments.period, &ramp)?
        }
    };

    let law = law(arguments.law, controller.as_ref());
    let thresholds = match law {
        files::Law::Switched => found.switched_thresholds(detection.resolution_rad),
        _ => found.inverse_thresholds(detection.resolution_rad),
    };
    if let (Some(controller), Some(path)) = (controller, &arguments.apply_to) {
        apply(controller, path, law, &found, &thresholds)?;
    }
    answer(arguments, law, &found, &thresholds);
    Ok(())
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

/// The same of a rig at a port, on the clock.
///
/// Errors: those of [`breakaway`] and of [`drive_rig`]; a rig that faulted.
fn breakaway_at(rig: &RigAt<'_>, period_s: f64, ramp: &SlowRamp) -> Result<(Breakaway, Detection), Failure> {
    check(ramp, period_s)?;
    let voltage_v = ramp.voltage(period_s);
    let (outcome, samples) = drive_rig(rig, period_s, &voltage_v, || Ok(Vec::new()))?;
    if outcome.report.cause != Cause::Over {
        return Err(Failure::Fault(Box::new(BrokenOff(outcome.report.text))));
    }
    whole_in_memory(&outcome)?;
    found(&signals_of(&samples, period_s)?, &Detection::default())
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

fn answer(arguments: &cli::RigTest, law: files::Law, found: &Breakaway, thresholds: &Thresholds) {
    if arguments.json {
        let applied_to = arguments.apply_to.as_ref().map(|path| path.display().to_string());
        let result = test_result(law, found, thresholds, applied_to);
        println!("{}", json_text(&result));
        return;
    }
    println!("{}", table(law, found, thresholds).text());
    if arguments.apply_to.is_none() {
        println!("next: flexbeam rig test --apply-to controller.toml writes these settings into a controller");
    }
}

fn table(law: files::Law, found: &Breakaway, thresholds: &Thresholds) -> Table {
    let name = match law {
        files::Law::Switched => "switched law",
        files::Law::Inverse => "inverse law",
        files::Law::None => "inverse law (the controller uses none)",
    };
    let mut rows = vec![
        ("breakaway forward", found.plus_v, "V", "measured"),
        ("breakaway backward", found.minus_v, "V", "measured"),
        ("u_p forward", thresholds.u_p_plus_v, "V", name),
        ("u_p backward (magnitude)", thresholds.u_p_minus_v, "V", name),
        ("eps_u", thresholds.eps_u_v, "V", name),
        ("eps_e", thresholds.eps_e_rad.to_degrees(), "degree", name),
    ];
    rows.extend(residual_v(law, found, thresholds).map(|v| ("residual voltage v_res", v, "V", name)));
    rows.into_iter().fold(
        Table::new(&[("", ""), ("value", ""), ("unit", ""), ("from", "")]),
        |table, (what, x, unit, from)| {
            table.row([what.into(), Cell::Number(format!("{x:+.4}")), unit.into(), from.into()])
        },
    )
}
