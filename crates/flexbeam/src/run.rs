//! `flexbeam run`: a controller on the clock, on a rig.

mod arming;
mod certified;
mod lines;
mod reference;
mod terminal;

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use flexbeam_files::{Controller, Document, Overwrite, RunFile, RunHeader, RunResult, json_text};
use flexbeam_kernel as kernel;
use flexbeam_report::{Cell, Table, engineering};
use flexbeam_rig::RigParameters;
use flexbeam_runtime::port::Port;
use flexbeam_runtime::{
    Cause, ControlSocket, ControllerData, EventKind, FrozenLimit, Latest, Live, Outcome, RunContext, RunSink, Session,
    Setup, Sink, Steering, run_result, with_table,
};

use crate::controller_file::kernel_settings;
use crate::output::provenance;
use crate::port::{self, now_unix_ns};
use crate::response::rig_at;
use crate::{Failure, cli};

/// Something about the run that makes no sense.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoRun {
    #[error("found {name} of {found}, needed {needed}\nhint: `flexbeam run --help` lists units and defaults")]
    Setting { name: &'static str, found: f64, needed: &'static str },
    #[error(
        "found a controller designed for a delay of {delay_s} s, needed {period_s} s: the loop has one period of delay\nhint: design it again with --period {period_s}"
    )]
    Delay { delay_s: f64, period_s: f64 },
    #[error("found no control over signals ({0}), needed it for Ctrl-C\nhint: start it from a plain terminal")]
    Signals(std::io::Error),
}

/// The rig faulted and was stopped.
#[derive(Debug, thiserror::Error)]
#[error("the rig was stopped, 0 V: {0}")]
struct Stopped(String);

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

/// Runs the command.
pub fn run(arguments: &cli::Run) -> Result<(), Failure> {
    let plan = Plan::of(arguments)?;
    let overwrite = if arguments.force { Overwrite::Allow } else { Overwrite::SameKind };
    let header = plan.header(arguments)?;
    flexbeam_files::check_free(&arguments.out, overwrite)?;

    let back_end = port::open(&plan.port, &plan.rig, arguments.seed)?;
    let mut setup = plan.setup.clone();
    let homed = plan.port != Port::Simulated || arguments.home;
    let back_end = if homed { arming::home(back_end, &mut setup, arguments.link.sign_check)? } else { back_end };

    let file = RunFile::create(&arguments.out, overwrite, &RunHeader { start_unix_ns: now_unix_ns(), ..header })?;
    let context = RunContext { port: plan.port.to_string(), period_s: setup.period_s };
    let latest = Latest::default();
    let sink = RunSink::new(file, &arguments.out, context.clone());
    let sinks: Vec<Box<dyn Sink>> = vec![Box::new(sink), Box::new(latest.clone())];
    let period_s = setup.period_s;
    let session = Session::arm(back_end, setup, sinks).map_err(|refused| {
        // Nothing ran, so nothing is worth keeping.
        let _ = std::fs::remove_file(RunFile::part_path(&arguments.out));
        Failure::while_trying(plan.tried.clone())(refused)
    })?;
    plan.overrides.iter().for_each(|text| session.note(EventKind::Override, text));
    let steering = Steering { controls: session.controls.clone(), live: session.live.clone(), latest, period_s };
    let _socket = arguments.control.as_deref().map(|path| open_socket(path, &steering)).transpose()?;
    watch(arguments, &plan, &session, &steering);
    answer(arguments, session.finish(), &context)
}

/// Until the run is over: on the terminal where there is one, then in lines whatever was not told yet.
fn watch(arguments: &cli::Run, plan: &Plan, session: &Session, steering: &Steering) {
    if !arguments.plain && !arguments.json && terminal::is_there() {
        let controller = arguments.controller.file_name().unwrap_or_default().to_string_lossy().into_owned();
        terminal::watch(session, steering, terminal::About { controller, port: plan.port.to_string() });
    }
    lines::watch(session, steering);
}

fn open_socket(path: &Path, steering: &Steering) -> Result<ControlSocket, Failure> {
    ControlSocket::open(path, steering.clone())
        .map_err(|refused| Failure::Input { tried: String::new(), error: Box::new(refused) })
}

/// What is to be run, checked as far as it can be before a rig is touched.
struct Plan {
    tried: String,
    port: Port,
    rig: RigParameters,
    setup: Setup,
    /// Rules that were set aside, by name.
    overrides: Vec<String>,
}

impl Plan {
    fn of(arguments: &cli::Run) -> Result<Plan, Failure> {
        let file = Controller::read(&arguments.controller)?;
        let tried = format!("run {}", arguments.controller.display());
        check(arguments, &file).map_err(Failure::while_trying(tried.clone()))?;
        let port = port::port(&arguments.link.port)?;
        let overrides = certified::check(&file, &tried, arguments.unverified.as_deref())?;
        Ok(Plan {
            rig: rig_at(arguments.rig.as_deref(), file.period_s)?,
            setup: setup(arguments, &file)?,
            overrides: overrides.into_iter().collect(),
            port,
            tried,
        })
    }

    fn header(&self, arguments: &cli::Run) -> Result<RunHeader, Failure> {
        let parents: Vec<&Path> = [Some(&arguments.controller), arguments.rig.as_ref()]
            .into_iter()
            .flatten()
            .map(|path| path.as_path())
            .collect();
        Ok(RunHeader {
            period_s: self.setup.period_s,
            start_unix_ns: 0,
            port: self.port.to_string(),
            provenance: provenance(&parents, &arguments.out)?,
            controller: flexbeam_files::read_bytes(&arguments.controller)?,
        })
    }
}

fn check(arguments: &cli::Run, file: &Controller) -> Result<(), NoRun> {
    let positive = [
        ("--hold [s]", arguments.link.hold),
        ("--duration [s]", arguments.duration.unwrap_or(1.0)),
        ("--max-angle-deg", arguments.max_angle_deg),
        ("--max-speed-deg-s", arguments.max_speed_deg_s),
    ];
    if let Some(&(name, found)) = positive.iter().find(|(_, x)| !(*x > 0.0 && x.is_finite())) {
        return Err(NoRun::Setting { name, found, needed: "a positive number" });
    }
    let volts = arguments.link.sign_check;
    if !(volts >= 0.0 && volts.is_finite()) {
        return Err(NoRun::Setting { name: "--sign-check [V]", found: volts, needed: "zero or a positive number" });
    }
    let (delay_s, period_s) = (file.design.delay_s, file.period_s);
    /// Rounding of a text file.
    const SAME: f64 = 1e-9;
    if (delay_s - period_s).abs() > SAME * period_s { Err(NoRun::Delay { delay_s, period_s }) } else { Ok(()) }
}

fn setup(arguments: &cli::Run, file: &Controller) -> Result<Setup, Failure> {
    let mut settings = kernel_settings(&file.settings, arguments.law.map(Into::into));
    settings.theta_limit_rad = settings.theta_limit_rad.min(arguments.max_angle_deg.to_radians());
    let speed_limit_rad_s = arguments.max_speed_deg_s.to_radians();
    settings.theta_step_limit_rad = settings.theta_step_limit_rad.min(speed_limit_rad_s * file.period_s);
    let frozen = FrozenLimit::above_breakaway(settings.breakaway_plus_v, settings.breakaway_minus_v);
    let live = Live { revision: 0, settings, reference: reference::of(arguments, file.period_s)? };
    let controller = ControllerData { order: file.order, coefficients: file.coefficients() };
    Ok(Setup {
        hold_s: arguments.link.hold,
        duration_s: arguments.duration,
        autostart: !arguments.wait,
        core: arguments.link.core,
        asked: asked_by_signal()?,
        frozen,
        ..Setup::new(controller, live, file.period_s)
    })
}

/// The flag that Ctrl-C, a hang-up or a termination sets: to 0 V and to the end, within a period.
pub fn asked_by_signal() -> Result<Arc<AtomicBool>, Failure> {
    let asked = Arc::<AtomicBool>::default();
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM, signal_hook::consts::SIGHUP] {
        signal_hook::flag::register(signal, asked.clone())
            .map_err(NoRun::Signals)
            .map_err(Failure::while_trying("listen to signals"))?;
    }
    Ok(asked)
}

/// The settings of a run that knows nothing of a controller: the kernel's, and a file's limits over them.
pub fn limits_of(file: Option<&Controller>) -> kernel::Settings {
    let default = kernel::Settings::default();
    file.map_or(default, |file| with_table(&default, &file.settings))
}

fn answer(arguments: &cli::Run, outcome: Outcome, context: &RunContext) -> Result<(), Failure> {
    let failed = outcome.recorded.failures.first();
    let kept = if failed.is_none() { arguments.out.clone() } else { RunFile::part_path(&arguments.out) };
    let result = run_result(&outcome.report, &outcome.recorded, context, Some(&kept));
    if arguments.json {
        println!("{}", json_text(&result));
    } else {
        print!("{}", table(&result).text());
        eprintln!("wrote {}", kept.display());
    }
    if let Cause::Fault(_) = outcome.report.cause {
        return Err(Failure::Fault(Box::new(Stopped(result.text))));
    }
    match failed {
        None => Ok(()),
        Some(error) => Err(Failure::while_trying(format!("record {}", arguments.out.display()))(BreaksOff {
            reason: error.reason.lines().next().unwrap_or_default().into(),
            missing: result.unrecorded,
            part: kept.display().to_string(),
        })),
    }
}

/// How the run went, for a person.
fn table(result: &RunResult) -> Table {
    let times = |t: &flexbeam_files::TimeQuantiles| {
        [t.median_s, t.p99_s, t.p999_s, t.max_s].map(|s| Cell::from(engineering(s, 3, "s")))
    };
    let link = &result.link;
    let count = |n: u64| Cell::count(n as usize);
    let columns = [("", ""), ("median", ""), ("99 %", ""), ("99.9 %", ""), ("longest", "")];
    let rows = [("lateness", &result.lateness), ("work in a period", &result.execution), ("tick alone", &result.tick)];
    let table = rows.into_iter().fold(Table::new(&columns), |table, (name, t)| {
        let [a, b, c, d] = times(t);
        table.row([name.into(), a, b, c, d])
    });
    let counts = [
        ("ticks", result.ticks),
        ("missed periods", result.missed),
        ("ticks without measurement", result.stale),
        ("late, twice, corrupt or foreign frames", link.late + link.duplicate + link.corrupt + link.foreign),
        ("samples not recorded", result.unrecorded),
        ("page faults", result.page_faults),
    ];
    counts
        .into_iter()
        .fold(table, |table, (name, n)| table.row([name.into(), count(n), "".into(), "".into(), "".into()]))
}
