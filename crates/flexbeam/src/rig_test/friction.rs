//! The friction part of `rig test`: pilot, ramps and runs on a rig; numbers, picture and rig file from what was recorded.

use std::path::Path;

use flexbeam_files as files;
use flexbeam_files::{Document, FrictionResult, Quantity, RepeatedBreakaway, Rig};
use flexbeam_ident::breakaway::{Breakaway, Detection, breakaway as breakaway_of};
use flexbeam_ident::excitation::SlowRamp;
use flexbeam_ident::friction::plan::{Plan, pilot, pilot_runs};
use flexbeam_ident::friction::{Estimate, FrictionTest, Motor, Options, Recorded};
use flexbeam_lti::Signals;
use flexbeam_rig::RigParameters;

use super::bench::Bench;
use super::{NoRamp, TRIED};
use crate::identify::Hinted;
use crate::output::{overwrite, provenance, say};
use crate::{Failure, cli};

/// A pilot's ramp is over when the hub has turned so far [rad]: twenty counts.
const PILOT_TURN_RAD: f64 = 20.0 * std::f64::consts::TAU / 4096.0;
/// What the hub may turn beyond the travel before the runs are stopped, and how far from the start of the ramps.
const BEYOND: f64 = 1.3;

/// A pilot run turns two thirds of it on the paper's rig [degree].
const LEAST_TRAVEL_DEG: f64 = 50.0;

/// A travel for which no runs can be planned, or that the limit on the angle would cut short.
#[derive(Debug, thiserror::Error)]
#[error(
    "found a travel of {found} degree, needed {least} to {most:.0}\nhint: a third of a turn is plenty: --travel-deg 120; its upper end follows --max-angle-deg"
)]
struct NoTravel {
    found: f64,
    least: f64,
    most: f64,
}

/// The hub turned too far.
#[derive(Debug, thiserror::Error)]
#[error(
    "found the hub {found_deg:.0} degree from where it began, needed at most {most_deg:.0}; the rig was taken to 0 V\nhint: a smaller --travel-deg turns less; a slope of voltage over speed that changes with the angle does not suit this test"
)]
struct TooFar {
    found_deg: f64,
    most_deg: f64,
}

/// Up to the breakaway, forward and then backward, and no further.
///
/// Errors: those of the bench; a hub that does not move.
pub(super) fn pilot_ramps(bench: &mut Bench<'_>, ramp: &SlowRamp, detection: &Detection) -> Result<Breakaway, Failure> {
    let voltages = ramp.voltage(bench.period_s);
    // Rest and rise, rest and fall, rest.
    let rest = (ramp.rest_s / bench.period_s).round() as usize;
    let half = rest + (voltages.len() - 3 * rest) / 2;
    bench.send(voltages[..half].to_vec(), PILOT_TURN_RAD)?;
    bench.send(voltages[half..2 * half].to_vec(), PILOT_TURN_RAD)?;
    let row = rows(&bench.recorded());
    breakaway_of(&row[0], &row[1], bench.period_s, detection).map_err(super::untold)
}

/// More ramps, and runs at constant speed when they are asked for.
pub(super) fn ramps_and_runs(
    bench: &mut Bench<'_>,
    arguments: &cli::RigTest,
    found: &Breakaway,
    parameters: &RigParameters,
    repeats: usize,
) -> Result<(), Failure> {
    let (options, period_s) = (options(parameters), bench.period_s);
    let plan =
        Plan { travel_rad: arguments.travel_deg.to_radians(), limit_v: parameters.actuator.limit_v, ..Plan::default() };
    let before = bench.recorded().samples();
    let turn = |bench: &mut Bench<'_>, voltages| match bench.send(voltages, BEYOND * plan.travel_rad)? {
        false => Ok(()),
        true => Err(Failure::while_trying(TRIED)(too_far(&bench.recorded(), BEYOND * plan.travel_rad))),
    };
    say("pilot runs, then the ramps and runs that follow from them");
    turn(bench, pilot_runs(found, plan.coast_s, period_s, &options))?;
    let recorded = bench.recorded();
    let row = rows(&recorded).map(|row| row[before..].to_vec());
    let pilot = pilot(&recorded_of(&row, period_s), found, &options).map_err(super::untold)?;
    // The pilot's ramps are the first of them.
    turn(bench, plan.ramps(&pilot, repeats - 1, arguments.slope, arguments.rest, period_s))?;
    if arguments.friction {
        turn(bench, plan.runs(&pilot, period_s, &options).map_err(super::untold)?)?;
    }
    Ok(())
}

fn too_far(recorded: &Signals, most_rad: f64) -> TooFar {
    let theta = recorded.data.row(1);
    TooFar { found_deg: theta[theta.len() - 1].to_degrees(), most_deg: most_rad.to_degrees() }
}

/// Voltage, hub angle, deflection angle.
pub(super) fn rows(signals: &Signals) -> [Vec<f64>; 3] {
    [0, 1, 2].map(|k| signals.data.row(k).iter().copied().collect())
}

pub(super) fn recorded_of(rows: &[Vec<f64>; 3], period_s: f64) -> Recorded<'_> {
    let [voltage_v, theta_rad, alpha_rad] = rows;
    Recorded { voltage_v, theta_rad, alpha_rad, period_s }
}

pub(super) fn options(parameters: &RigParameters) -> Options {
    Options { resolution_rad: super::detection(parameters).resolution_rad, ..Options::default() }
}

/// Errors: settings of which no test can be made.
pub(super) fn check(arguments: &cli::RigTest) -> Result<(), Failure> {
    if arguments.repeats == Some(0) {
        let (setting, hint) = ("a number of ramps of", "one ramp each way at least: --repeats 1");
        return Err(Failure::while_trying(TRIED)(NoRamp { setting, found: 0.0, hint }));
    }
    let (found, most) = (arguments.travel_deg, arguments.link.max_angle_deg / BEYOND);
    if arguments.friction && !(LEAST_TRAVEL_DEG..=most).contains(&found) {
        return Err(Failure::while_trying(TRIED)(NoTravel { found, least: LEAST_TRAVEL_DEG, most }));
    }
    Ok(())
}

/// The motor's constants of the rig file.
pub(super) fn motor(arguments: &cli::RigTest, parameters: &RigParameters) -> Motor {
    let physical = &parameters.physical;
    if arguments.no_viscous {
        Motor::NoViscous { R_ohm: physical.R_ohm }
    } else {
        Motor::Known { K_g: physical.K_g, K_b: physical.K_b, R_ohm: physical.R_ohm }
    }
}

pub(super) fn quantity(estimate: Estimate) -> Quantity {
    Quantity { value: estimate.value, std: estimate.standard_error, half_width_95: estimate.half_width_95() }
}

pub(super) fn repeated_result([plus, minus]: [Estimate; 2]) -> RepeatedBreakaway {
    RepeatedBreakaway { plus_v: quantity(plus), minus_v: quantity(minus) }
}

pub(super) fn result(test: &FrictionTest, motor: &Motor) -> FrictionResult {
    let some = |estimate: Option<Estimate>| estimate.map(quantity);
    FrictionResult {
        runs: test.runs.len(),
        left_out: test.left_out,
        dry_plus_v: quantity(test.dry_plus_v()),
        dry_minus_v: quantity(test.dry_minus_v()),
        slope_v_s: quantity(test.slope_v_s()),
        dead_zone_plus_v: some(test.dead_zone_plus_v()),
        dead_zone_minus_v: some(test.dead_zone_minus_v()),
        coulomb_plus_v: some(test.coulomb_plus_v()),
        coulomb_minus_v: some(test.coulomb_minus_v()),
        delay_s: some(test.delay_s()),
        torque_per_volt_nm: quantity(test.torque_per_volt(motor)),
        coulomb_nm: some(test.coulomb_nm(motor)),
        viscous_nm_s: quantity(test.viscous(motor)),
        stribeck_extra_nm: some(test.stribeck_extra_nm(motor)),
        stribeck_speed_rad_s: test.stribeck().map(|(_, speed)| speed),
    }
}

/// What a person should know besides the numbers: on standard error.
pub(super) fn notes(test: &FrictionTest, motor: &Motor) {
    if test.left_out > 0 {
        say(format_args!(
            "{} stretches of constant voltage were left out: the hub stood or was not steady",
            test.left_out
        ));
    }
    if let Some(why) = &test.together {
        say(format_args!("dead zone and Coulomb torque stay together: {}", Hinted(why.clone())));
    }
    let viscous = test.viscous(motor);
    if viscous.value < -viscous.half_width_95() {
        say(format_args!(
            "warning: the slope lies below the back-emf, as if viscous friction were {:.2e} N m s/rad\n\
             hint: K_b or K_g of the rig file is too large; --no-viscous takes the slope itself for the back-emf",
            viscous.value
        ));
    }
    if let Some(delay) = test.delay_s().filter(|delay| delay.value.abs() > delay.half_width_95().max(5e-4)) {
        say(format_args!(
            "the voltage acts {:.1} ms later than the recording says; the test allowed for it",
            1e3 * delay.value
        ));
    }
}

/// The rig of `--rig`, else the paper's, with the friction found.
///
/// Errors: dead zone and Coulomb torque that were not told apart; those of reading and writing.
pub(super) fn write_rig(path: &Path, arguments: &cli::RigTest, found: &FrictionResult) -> Result<(), Failure> {
    let replace = overwrite::<Rig>(path, arguments.force)?;
    let mut rig = arguments.rig.as_deref().map(Rig::read).transpose()?.unwrap_or_default();
    let (Some(plus), Some(minus), Some(coulomb)) = (found.dead_zone_plus_v, found.dead_zone_minus_v, found.coulomb_nm)
    else {
        return Err(Failure::while_trying(format!("write {}", path.display()))(NotParted));
    };
    // A rig has no negative dead zone or friction; the estimate of one that is zero may be.
    let actuator = rig.actuator.get_or_insert_default();
    actuator.dead_zone_plus_v = Some(plus.value.max(0.0));
    actuator.dead_zone_minus_v = Some(minus.value.max(0.0));
    let stribeck = found.stribeck_extra_nm.map(|extra| extra.value);
    rig.friction = Some(files::RigFriction {
        coulomb_nm: Some(coulomb.value.max(0.0)),
        stribeck_extra_nm: stribeck,
        stribeck_speed_rad_s: found.stribeck_speed_rad_s.filter(|_| stribeck.is_some()),
    });
    if rig.lumped.is_none() && !arguments.no_viscous {
        rig.physical.get_or_insert_default().B_eq = Some(found.viscous_nm_s.value.max(0.0));
    }
    let parents: Vec<&Path> = [&arguments.rig, &arguments.from].into_iter().flatten().map(|p| p.as_path()).collect();
    rig.provenance = Some(provenance(&parents, path)?);
    rig.write(path, replace)?;
    say(format_args!("wrote {}", path.display()));
    Ok(())
}

/// No rig file without the two.
#[derive(Debug, thiserror::Error)]
#[error(
    "found dead zone and Coulomb torque only as a sum, needed both\nhint: record runs that end in 0 V at once, and the second after that"
)]
struct NotParted;
