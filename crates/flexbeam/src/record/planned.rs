//! What is to be sent, and what it promises, before the rig moves.

use flexbeam_files::{Excitation as Planned, FEWEST_ROWS, Physical};
use flexbeam_ident::excitation::{Excitation, Plan, Shape};
use flexbeam_ident::structured::expected_errors;
use flexbeam_report::significant;
use flexbeam_rig::RigParameters;

use super::MOST_SAMPLES;
use crate::cli;
use crate::output::say;

/// A setting of the experiment that makes no recording.
#[derive(Debug, thiserror::Error)]
#[error("found {setting} {found} {unit}, needed {needed}\nhint: {hint}")]
struct NoExperiment {
    setting: &'static str,
    found: f64,
    unit: &'static str,
    needed: String,
    hint: &'static str,
}

/// A band that is not two frequencies.
#[derive(Debug, thiserror::Error)]
#[error("found a band of {0} numbers, needed its lowest and highest frequency [Hz]\nhint: --band 0.5,100")]
struct NoBand(usize);

/// A shape and band of which the identification makes no voltage.
#[derive(Debug, thiserror::Error)]
#[error("{0}\nhint: flexbeam record --help lists signals, units and defaults")]
struct NoVoltage(flexbeam_ident::Error);

/// The plan that the command line describes, for this rig.
///
/// Errors: a duration, period, rms, peak or band of which no recording can be made.
pub(super) fn plan(arguments: &cli::Record, parameters: &RigParameters) -> Result<Plan, Box<dyn std::error::Error>> {
    let band_hz = match arguments.band[..] {
        [] => None,
        [low, high] => Some([low, high]),
        _ => return Err(NoBand(arguments.band.len()).into()),
    };
    let limit_v = parameters.actuator.limit_v;
    let peak_v = arguments.peak.unwrap_or(limit_v);
    if !(peak_v > 0.0 && peak_v <= limit_v) {
        return Err(NoExperiment {
            setting: "a peak of",
            found: peak_v,
            unit: "V",
            needed: format!("a positive number up to the amplifier's limit of {limit_v} V"),
            hint: "without --peak it is the amplifier's limit",
        }
        .into());
    }
    let shape = match arguments.signal {
        cli::Waveform::White => Shape::White,
        cli::Waveform::Prbs => Shape::Prbs,
        cli::Waveform::Multisine => Shape::Multisine,
        cli::Waveform::OddMultisine => Shape::OddMultisine,
        cli::Waveform::Chirp => Shape::Chirp,
        cli::Waveform::LogChirp => Shape::LogChirp,
    };
    let (periods, seed) = (arguments.periods, arguments.seed);
    let white = white(parameters, arguments.duration, arguments.rms, seed)?;
    Ok(Plan { shape, band_hz, peak_v, periods, ..white })
}

/// White noise of this rms over all frequencies, clipped at the amplifier's limit.
///
/// Errors: a duration, period or rms of which no recording can be made.
pub(super) fn white(
    parameters: &RigParameters,
    duration_s: f64,
    rms_v: f64,
    seed: u64,
) -> Result<Plan, Box<dyn std::error::Error>> {
    let wrong = |setting, found, unit, needed, hint| Err(NoExperiment { setting, found, unit, needed, hint }.into());
    let period_s = parameters.period_s;
    if !(period_s > 0.0 && period_s.is_finite()) {
        return wrong(
            "a sample period of",
            period_s,
            "s",
            "a positive number".into(),
            "1 ms suits the beam: --period 0.001",
        );
    }
    let samples = (duration_s / period_s).round();
    if !(samples >= FEWEST_ROWS as f64 && samples <= MOST_SAMPLES) {
        let needed = format!("{FEWEST_ROWS} to {MOST_SAMPLES:e} samples of {period_s} s");
        return wrong("a duration of", duration_s, "s", needed, "ten seconds are plenty: --duration 10");
    }
    if !(rms_v > 0.0 && rms_v.is_finite()) {
        return wrong(
            "an rms voltage of",
            rms_v,
            "V",
            "a positive number".into(),
            "half of the amplifier's limit: --rms 5",
        );
    }
    Ok(Plan {
        shape: Shape::White,
        band_hz: None,
        rms_v,
        peak_v: parameters.actuator.limit_v,
        periods: 1,
        samples: samples as usize,
        period_s,
        seed,
    })
}

/// The voltage of a plan; says so when the peak made it smaller.
///
/// Errors: a band or a number of periods of which no signal can be made.
pub(super) fn voltage(plan: &Plan) -> Result<Excitation, Box<dyn std::error::Error>> {
    let found = plan.excitation().map_err(NoVoltage)?;
    let rms_v = found.rms_v();
    if plan.shape != Shape::White && rms_v < plan.rms_v * (1.0 - SMALLER) {
        say(format_args!(
            "note: the voltage has {} V rms and not {} V: its crest factor is {} and its peak limit {} V",
            significant(rms_v, 3),
            significant(plan.rms_v, 3),
            significant(found.crest_factor(), 3),
            significant(plan.peak_v, 3),
        ));
    }
    Ok(found)
}

/// An rms that is short of what was asked for by less is rounding.
const SMALLER: f64 = 1e-9;

/// The table `excitation` of the recording's note.
pub(super) fn table(arguments: &cli::Record, found: &Excitation) -> Planned {
    Planned {
        signal: arguments.signal.name().into(),
        rms_v: found.rms_v(),
        peak_v: found.peak_v(),
        band_hz: found.band_hz,
        period_samples: found.period_samples,
        periods: arguments.periods,
        clock_samples: found.clock_samples,
        seed: arguments.seed,
    }
}

/// (18)'s numbers for this rig, with the standard errors that a fit to the whole recording will have, if the rig is linear and its
/// sensors' noise white; nothing where a sensor has no noise.
///
/// Errors: fewer samples than unknowns.
pub(super) fn expected(
    parameters: &RigParameters,
    voltage_v: &[f64],
) -> Result<Option<Physical>, Box<dyn std::error::Error>> {
    let noise_rad = parameters.sensors.noise_rad();
    if noise_rad.contains(&0.0) {
        return Ok(None);
    }
    let nominal = parameters.physical.lumped();
    let std = expected_errors(voltage_v, parameters.period_s, &nominal, noise_rad).map_err(NoVoltage)?;
    Ok(Some(Physical {
        k1: nominal.k1,
        k1_std: Some(std.k1),
        k2: nominal.k2,
        k2_std: Some(std.k2),
        c: nominal.c,
        c_std: Some(std.c),
        b: nominal.b,
        b_std: Some(std.b),
    }))
}

/// Says on standard error what the recording will be worth.
pub(super) fn say_expected(expected: &Physical, noise_rad: [f64; 2]) {
    let part = |name: &str, value: f64, std: Option<f64>| {
        format!("{name} {} ± {}", significant(value, 5), significant(std.unwrap_or(f64::NAN), 2))
    };
    let Physical { k1, k1_std, k2, k2_std, c, c_std, b, b_std } = *expected;
    say(format_args!(
        "expected of the whole recording, for the linear rig with {} mrad of noise on theta and {} on alpha: {}, {}, {}, {}",
        significant(1e3 * noise_rad[0], 2),
        significant(1e3 * noise_rad[1], 2),
        part("k1", k1, k1_std),
        part("k2", k2, k2_std),
        part("c", c, c_std),
        part("b", b, b_std),
    ));
}
