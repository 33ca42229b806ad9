//! What every command does that drives a rig on a clock: limits, signals, zeroes, signs, a list of voltages.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use flexbeam_files::RunFile;
use flexbeam_kernel as kernel;
use flexbeam_lti::{Mat, Signals};
use flexbeam_rig::RigParameters;
use flexbeam_runtime::back_end::BackEnd;
use flexbeam_runtime::port::Port;
use flexbeam_runtime::{
    Cause, ControllerData, FrozenLimit, Live, NotHomed, Outcome, Phase, Recorded, Reference, Sample, Setup, SignWatch,
    Sink, Zero, drive, open_loop_setup, sign_check_voltages, signs_of, zero_of,
};
use signal_hook::consts::{SIGALRM, SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGTSTP, SIGUSR1, SIGUSR2, SIGXCPU, SIGXFSZ};

use crate::output::{progress, say};
use crate::{Failure, cli, port};

/// Two counts of an encoder with 4096 counts a turn, and half of one [rad].
const TWO_COUNTS_RAD: f64 = 2.5 * std::f64::consts::TAU / 4096.0;
/// Length of a look at the rig at rest [s].
const LOOK_S: f64 = 0.5;
/// How often it is looked at while it still moves.
const LOOKS: usize = 40;
/// Slope of the sign check's ramp [V/s].
const RATE_V_S: f64 = 2.0;

/// A run before the run that did not end well.
#[derive(Debug, thiserror::Error)]
#[error("found that {0}, needed a rig that can be homed\nhint: nothing but a few volts at most had been sent")]
struct EndedEarly(String);

/// Something about the loop that makes no sense.
#[derive(Debug, thiserror::Error)]
enum NoLoop {
    #[error("found {name} {found}, needed {needed}\nhint: --help lists units and defaults")]
    Setting { name: &'static str, found: f64, needed: &'static str },
    #[error("found no control over signals ({0}), needed it for Ctrl-C\nhint: start it from a plain terminal")]
    Signals(std::io::Error),
}

/// A run with the command line's limits, hold time and core, which Ctrl-C stops.
///
/// Errors: a number that makes no sense.
pub fn setup_on(link: &cli::RigLink, setup: Setup) -> Result<Setup, Failure> {
    check(link).map_err(Failure::while_trying("set up the loop"))?;
    let mut live = setup.live;
    let settings = &mut live.settings;
    settings.theta_limit_rad = settings.theta_limit_rad.min(link.max_angle_deg.to_radians());
    let mut step_limit_rad = link.max_speed_deg_s.to_radians() * setup.period_s;
    if step_limit_rad < TWO_COUNTS_RAD {
        let least = (TWO_COUNTS_RAD / setup.period_s).to_degrees();
        say(format_args!(
            "warning: below {least:.0} degree/s the encoder's steps alone would be too fast; that is the speed limit now"
        ));
        step_limit_rad = TWO_COUNTS_RAD;
    }
    settings.theta_step_limit_rad = settings.theta_step_limit_rad.min(step_limit_rad);
    let frozen = FrozenLimit::above_breakaway(settings.breakaway_plus_v, settings.breakaway_minus_v);
    Ok(Setup { live, frozen, hold_s: link.hold, core: link.core, asked: asked_by_signal()?, ..setup })
}

fn check(link: &cli::RigLink) -> Result<(), NoLoop> {
    let positive = [
        ("--hold [s]", link.hold),
        ("--max-angle-deg", link.max_angle_deg),
        ("--max-speed-deg-s", link.max_speed_deg_s),
    ];
    if let Some(&(name, found)) = positive.iter().find(|(_, x)| !(*x > 0.0 && x.is_finite())) {
        return Err(NoLoop::Setting { name, found, needed: "a positive number" });
    }
    match link.sign_check {
        volts if volts >= 0.0 && volts.is_finite() => Ok(()),
        found => Err(NoLoop::Setting { name: "--sign-check [V]", found, needed: "zero or a positive number" }),
    }
}

/// Ctrl-C, a termination, a hang-up, Ctrl-\, Ctrl-Z, and what else would end or halt a program that does not listen: its last
/// voltage would stand.
const ENDINGS: [i32; 9] = [SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP, SIGUSR1, SIGUSR2, SIGALRM, SIGXCPU];

/// The flag that a signal to end sets: to 0 V and to the end, within a period. A file that grows beyond its limit is an error of
/// the recording rather than the death of the program.
pub fn asked_by_signal() -> Result<Arc<AtomicBool>, Failure> {
    let asked = Arc::<AtomicBool>::default();
    for (signal, flag) in ENDINGS.map(|signal| (signal, asked.clone())).into_iter().chain([(SIGXFSZ, Arc::default())]) {
        signal_hook::flag::register(signal, flag)
            .map_err(NoLoop::Signals)
            .map_err(Failure::while_trying("listen to signals"))?;
    }
    Ok(asked)
}

/// A rig at a port; the simulated one has these parameters and this seed.
pub struct RigAt<'a> {
    /// Where.
    pub port: &'a Port,
    /// Limits, hold time, core, sign check.
    pub link: &'a cli::RigLink,
    /// Of the simulated rig.
    pub simulated: &'a RigParameters,
    /// Of the simulated rig's noise.
    pub seed: u64,
    /// When an encoder that stands still is a fault.
    pub frozen: FrozenLimit,
}

/// Sends a list of voltages to a rig on the clock, from its zeroes on, with these sinks beside.
///
/// Returns: the outcome, and every sample of the run, angles from the zeroes that were found.
/// Errors: a rig that cannot be opened, homed or armed.
pub fn drive_rig(
    rig: &RigAt<'_>,
    period_s: f64,
    voltages_v: &[f64],
    sinks: impl FnOnce() -> Result<Vec<Box<dyn Sink>>, Failure>,
) -> Result<(Outcome, Vec<Sample>), Failure> {
    let (back_end, setup) = ready(rig, period_s)?;
    let bar = progress(voltages_v.len() as u64, "driving the rig");
    let along = bar.clone();
    let setup = open_loop_setup(voltages_v.into(), &setup.live.settings, &setup);
    let offsets = [setup.live.settings.theta.offset_rad, setup.live.settings.alpha.offset_rad];
    let every = (0.1 / period_s).ceil() as u64;
    let (outcome, mut samples) = drive(back_end, setup, sinks()?, move |sample| {
        if sample.instant % every == 0 {
            along.set_position(sample.instant);
        }
        false
    })
    .map_err(Failure::while_trying(format!("drive the rig at {}", rig.port)))?;
    bar.finish_and_clear();
    from_zeroes(&mut samples, offsets);
    Ok((outcome, samples))
}

/// A rig with its limits, open and homed, for one list of voltages after another.
///
/// Errors: a rig that cannot be opened or homed.
pub fn ready(rig: &RigAt<'_>, period_s: f64) -> Result<(Box<dyn BackEnd>, Setup), Failure> {
    let live = Live { revision: 0, settings: kernel::Settings::default(), reference: Reference::default() };
    let mut setup = setup_on(rig.link, Setup::new(ControllerData::pass_through(), live, period_s))?;
    let mut back_end = port::open(rig.port, rig.simulated, rig.seed)?;
    within_reach(back_end.as_ref(), &mut setup);
    if *rig.port != Port::Simulated {
        back_end = home(back_end, &mut setup, rig.link.sign_check)?;
    }
    setup.frozen = rig.frozen;
    Ok((back_end, setup))
}

/// Angles from the zeroes that were found, theta's and alpha's.
pub fn from_zeroes(samples: &mut [Sample], offsets: [f64; 2]) {
    for sample in samples {
        sample.measured.theta_rad -= offsets[0];
        sample.measured.alpha_rad -= offsets[1];
    }
}

/// The running samples as a recording: voltage_v acts from its instant on.
pub fn signals_of(samples: &[Sample], period_s: f64) -> Result<Signals, Failure> {
    let running: Vec<&Sample> = samples.iter().filter(|s| s.phase == Phase::Running).collect();
    let row = |s: &Sample| [s.voltage_v, s.measured.theta_rad, s.measured.alpha_rad];
    let data = Mat::from_fn(3, running.len(), |channel, k| row(running[k])[channel]);
    let names = ["voltage_v", "theta_rad", "alpha_rad"].map(String::from).to_vec();
    let units = ["v", "rad", "rad"].map(String::from).to_vec();
    Signals::new(names, units, period_s, data).map_err(Failure::while_trying("make a recording"))
}

/// The voltage limit goes down to what the rig's output can give: the controller must not believe in volts that do not come.
pub fn within_reach(back_end: &dyn BackEnd, setup: &mut Setup) {
    let (limit_v, reach_v) = (&mut setup.live.settings.voltage_limit_v, back_end.reach_v());
    if reach_v < *limit_v {
        say(format_args!(
            "warning: {} reaches {reach_v} V either way, so the voltage limit is that and not {limit_v} V",
            back_end.name()
        ));
        *limit_v = reach_v;
    }
}

/// The run went well, its recording did not.
#[derive(Debug, thiserror::Error)]
#[error(
    "found that the recording breaks off ({reason}), needed all of it: {missing} samples are not in it\nhint: what was written until then stands in {part}, which `flexbeam show` and `identify` read"
)]
struct BreaksOff {
    reason: String,
    missing: u64,
    part: String,
}

/// Whether all that was to be recorded was.
///
/// Errors: what the recorder had to say, and where the rest stands.
pub fn whole(recorded: &Recorded, out: &Path, missing: u64) -> Result<(), Failure> {
    let Some(error) = recorded.failures.first() else { return Ok(()) };
    Err(Failure::while_trying(format!("record {}", out.display()))(BreaksOff {
        reason: error.reason.lines().next().unwrap_or_default().into(),
        missing,
        part: RunFile::part_path(out).display().to_string(),
    }))
}

/// Whether every sample of a list of voltages came home.
///
/// Errors: samples that got lost on their way to memory.
pub fn whole_in_memory(outcome: &Outcome) -> Result<(), Failure> {
    match outcome.report.meter.unrecorded {
        0 => Ok(()),
        missing => Err(Failure::while_trying("keep the samples")(Lost(missing))),
    }
}

/// Samples that the recorder's thread was too late for.
#[derive(Debug, thiserror::Error)]
#[error(
    "found {0} samples lost on their way to memory, needed all of them\nhint: the machine stood still for seconds; stop other programs"
)]
struct Lost(u64);

/// Finds the zeroes and checks the signs; the zeroes go into the settings.
///
/// Errors: a rig that does not come to rest, whose signs are wrong, or that faults.
pub fn home(back_end: Box<dyn BackEnd>, setup: &mut Setup, highest_v: f64) -> Result<Box<dyn BackEnd>, Failure> {
    let (back_end, zero) = at_rest(back_end, setup)?;
    let settings = &mut setup.live.settings;
    (settings.theta.offset_rad, settings.alpha.offset_rad) = (zero.theta_rad, zero.alpha_rad);
    say(format_args!(
        "homed: zero of the hub {:+.2}°, of the gauge {:+.3}° (noise {:.3}° rms)",
        zero.theta_rad.to_degrees(),
        zero.alpha_rad.to_degrees(),
        zero.alpha_noise_rad.to_degrees()
    ));
    if highest_v > 0.0 { signs(back_end, setup, zero, highest_v) } else { Ok(back_end) }
}

/// Looks until the rig is still.
fn at_rest(mut back_end: Box<dyn BackEnd>, setup: &Setup) -> Result<(Box<dyn BackEnd>, Zero), Failure> {
    // Before the zeroes are known no limit on the angles means anything; the voltage is 0 V.
    let unlimited = kernel::Settings { deflection_limit_rad: f64::MAX, ..kernel::Settings::default() };
    let still: Arc<[f64]> = vec![0.0; (LOOK_S / setup.period_s).ceil() as usize].into();
    let mut left = LOOKS;
    loop {
        let (rig, samples) = driven(back_end, open_loop_setup(still.clone(), &unlimited, setup), |_| false)?;
        back_end = rig;
        left -= 1;
        match zero_of(&samples) {
            Ok(zero) => return Ok((back_end, zero)),
            Err(NotHomed::NotAtRest { .. }) if left > 0 => {
                if left + 1 == LOOKS {
                    say("the rig still moves; waiting for it");
                }
            }
            Err(error) => return Err(Failure::while_trying("home the rig")(error)),
        }
    }
}

fn signs(back_end: Box<dyn BackEnd>, setup: &Setup, zero: Zero, highest_v: f64) -> Result<Box<dyn BackEnd>, Failure> {
    let voltages = sign_check_voltages(highest_v, RATE_V_S, setup.period_s);
    let mut watch = SignWatch::new(zero, setup.period_s);
    let setup = open_loop_setup(voltages, &setup.live.settings, setup);
    // A hub that does not move is what the check is to find.
    let setup = Setup { frozen: FrozenLimit::NEVER, ..setup };
    let (back_end, samples) = driven(back_end, setup, move |sample| watch.enough(sample))?;
    let agree = signs_of(&samples, &zero).map_err(Failure::while_trying("check the signs of the rig"))?;
    let turned = agree.theta_rad.to_degrees();
    match agree.alpha_rad {
        Some(alpha) => {
            say(format_args!(
                "signs agree: at {:+.2} V the hub turned {turned:+.2}°, the tip lagged {:+.2}°",
                agree.voltage_v,
                alpha.to_degrees()
            ));
        }
        None => say("the hub turns with the voltage; the gauge's sign is not proven, its swing drowned in noise"),
    }
    Ok(back_end)
}

/// Errors: a rig that faulted on the way: status 3.
fn driven(
    back_end: Box<dyn BackEnd>,
    setup: Setup,
    enough: impl FnMut(&Sample) -> bool + Send + 'static,
) -> Result<(Box<dyn BackEnd>, Vec<Sample>), Failure> {
    let asked = setup.asked.clone();
    let (outcome, samples) =
        drive(back_end, setup, Vec::new(), enough).map_err(Failure::while_trying("home the rig"))?;
    let Outcome { report, back_end, .. } = outcome;
    let stopped = asked.load(Ordering::Acquire);
    match (report.cause, back_end) {
        (Cause::Over | Cause::Asked, Some(back_end)) if !stopped => Ok((back_end, samples)),
        (Cause::Over | Cause::Asked, _) => {
            Err(Failure::Fault(Box::new(EndedEarly("it was stopped while homing".into()))))
        }
        (Cause::Fault(_), _) => Err(Failure::Fault(Box::new(EndedEarly(report.text)))),
    }
}
