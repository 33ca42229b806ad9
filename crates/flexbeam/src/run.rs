//! `flexbeam run`: a controller on the clock, on a rig.

mod certified;
mod lines;
mod project;
mod reference;
mod saving;
mod scope;
mod terminal;
#[cfg(feature = "foxglove")]
mod viewers;

use std::path::Path;

use flexbeam_files::{
    CertificateSummary, Controller, Document, Overwrite, Project, RunFile, RunHeader, RunResult, Screen, json_text,
};
use flexbeam_report::{Cell, Table, engineering};
use flexbeam_rig::RigParameters;
use flexbeam_runtime::back_end::BackEnd;
use flexbeam_runtime::port::Port;
use flexbeam_runtime::scope::{About, ScopeServer};
use flexbeam_runtime::{
    BoundSocket, Cause, ControlSocket, ControllerData, EventKind, Latest, Live, NoSocket, Outcome, RunContext, RunSink,
    Session, Setup, Sink, Steering, run_result,
};

use crate::controller_file::kernel_settings;
use crate::on_rig::{home, setup_on, whole, within_reach};
use crate::output::{provenance, say};
use crate::port::{self, now_unix_ns};
use crate::response::rig_at;
use crate::{Failure, cli};
use project::Asked;

/// Something about the run that makes no sense.
#[derive(Debug, thiserror::Error)]
enum NoRun {
    #[error("found --duration {0} s, needed a positive number\nhint: without --duration it runs until it is stopped")]
    Duration(f64),
    #[error(
        "found a controller designed for a delay of {delay_s} s, needed {period_s} s: the loop has one period of delay\nhint: design it again with --period {period_s}"
    )]
    Delay { delay_s: f64, period_s: f64 },
}

/// The rig faulted and was stopped.
#[derive(Debug, thiserror::Error)]
#[error("the rig was stopped, 0 V: {0}")]
struct Stopped(String);

/// Runs the command.
pub fn run(given: &cli::Given<cli::Run>) -> Result<(), Failure> {
    let asked = Asked::of(given)?;
    let arguments = &asked.arguments;
    scope::check(&arguments.scope, given.states("scope_token_file"))?;
    let plan = Plan::of(&asked)?;
    let mut places = Places::take(&asked, &plan)?;
    let (rig, setup) = plan.rig_at_rest(arguments)?;
    let running = plan.armed(&asked, &places, rig, setup)?;
    let _socket = places.serve(&running.steering)?;
    watch(arguments, &plan, &places, &running);
    answer(arguments, running.session.finish(), &running.context)
}

/// What a run needs beside its rig, taken before the rig is touched.
struct Places {
    overwrite: Overwrite,
    socket: Option<BoundSocket>,
    scope: Option<ScopeServer>,
    #[cfg(feature = "foxglove")]
    viewers: Option<flexbeam_runtime::foxglove::Viewers>,
}

impl Places {
    /// Errors: a file that may not be replaced, a socket or an address that is taken.
    fn take(asked: &Asked, plan: &Plan) -> Result<Places, Failure> {
        let arguments = &asked.arguments;
        let overwrite = if arguments.force { Overwrite::Allow } else { Overwrite::SameKind };
        RunFile::check_free(&arguments.out, overwrite)?;
        Ok(Places {
            overwrite,
            socket: arguments.control.as_deref().map(BoundSocket::bind).transpose().map_err(said_itself)?,
            scope: scope::open(&arguments.scope, plan.about(asked))?,
            #[cfg(feature = "foxglove")]
            viewers: viewers::open(&arguments.viewers)?,
        })
    }

    /// The viewers stay with the places; the socket goes to its owner.
    fn serve(&mut self, steering: &Steering) -> Result<Option<ControlSocket>, Failure> {
        self.socket.take().map(|socket| socket.serve(steering.clone())).transpose().map_err(said_itself)
    }
}

/// A run under way.
struct Running {
    session: Session,
    steering: Steering,
    context: RunContext,
}

/// Until the run is over: on the terminal where there is one, then in lines whatever was not told yet.
fn watch(arguments: &cli::Run, plan: &Plan, places: &Places, Running { session, steering, .. }: &Running) {
    if !arguments.plain && !arguments.json && terminal::is_there() {
        let controller = arguments.controller.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let scope = places.scope.as_ref().map(ScopeServer::url);
        terminal::watch(session, steering, terminal::About { controller, port: plan.port.to_string(), scope });
    }
    lines::watch(session, steering);
}

/// The socket's own error says what was tried.
fn said_itself(refused: NoSocket) -> Failure {
    Failure::Input { tried: String::new(), error: Box::new(refused) }
}

/// What is to be run, checked as far as it can be before a rig is touched.
struct Plan {
    tried: String,
    port: Port,
    rig: RigParameters,
    setup: Setup,
    /// Rules that were set aside, by name.
    overrides: Vec<String>,
    certificate: CertificateSummary,
}

impl Plan {
    fn of(asked: &Asked) -> Result<Plan, Failure> {
        let arguments = &asked.arguments;
        let file = asked.over(Controller::read(&arguments.controller)?);
        let tried = format!("run {}", arguments.controller.display());
        check(arguments, &file).map_err(Failure::while_trying(tried.clone()))?;
        let port = port::port(&arguments.link.port)?;
        let overrides = certified::check(&file, &tried, arguments.unverified.as_deref())?;
        Ok(Plan {
            rig: rig_at(arguments.rig.as_deref(), file.period_s)?,
            setup: setup(asked, &file)?,
            certificate: scope::certificate(&file, arguments.unverified.as_deref().filter(|_| overrides.is_some())),
            overrides: overrides.into_iter().collect(),
            port,
            tried,
        })
    }

    /// What the scope tells of it.
    fn about(&self, asked: &Asked) -> About {
        About {
            controller: asked.arguments.controller.display().to_string(),
            project: asked.name(),
            port: self.port.to_string(),
            period_s: self.setup.period_s,
            certificate: Some(self.certificate.clone()),
            recording: Some(asked.arguments.out.clone()),
            screen: asked.screen().unwrap_or_else(Screen::usual),
            save: asked.save(),
            asked: self.setup.asked.clone(),
        }
    }

    /// The rig, opened and at 0 V, with its zeroes in the settings where it was homed.
    ///
    /// Errors: a rig that is not there, does not come to rest, or turns the wrong way.
    fn rig_at_rest(&self, arguments: &cli::Run) -> Result<(Box<dyn BackEnd>, Setup), Failure> {
        let mut setup = self.setup.clone();
        let rig = port::open(&self.port, &self.rig, arguments.seed)?;
        within_reach(rig.as_ref(), &mut setup);
        let homed = self.port != Port::Simulated || arguments.home;
        let rig = if homed { home(rig, &mut setup, arguments.link.sign_check)? } else { rig };
        Ok((rig, setup))
    }

    /// The clock runs, the recording has begun.
    ///
    /// Errors: a recording that cannot be written, a run that cannot be armed; then nothing stays behind.
    fn armed(&self, asked: &Asked, places: &Places, rig: Box<dyn BackEnd>, setup: Setup) -> Result<Running, Failure> {
        let arguments = &asked.arguments;
        let header = self.header(asked)?;
        let context = RunContext { port: self.port.to_string(), period_s: setup.period_s };
        asked.saves_from(&setup.live)?;
        let folder = asked.make_folder()?;
        let file = RunFile::create(&arguments.out, places.overwrite, &header)?;
        let latest = Latest::default();
        let recording = RunSink::new(file, &arguments.out, context.clone());
        let sinks: Vec<Box<dyn Sink>> = vec![Box::new(recording), Box::new(latest.clone())];
        let sinks = scope::with_sink(sinks, places.scope.as_ref(), &header);
        #[cfg(feature = "foxglove")]
        let sinks = viewers::with_sink(sinks, places.viewers.as_ref(), &header);
        let session = Session::arm(rig, setup, sinks).map_err(|refused| {
            // Nothing ran, so nothing is worth keeping.
            let _ = std::fs::remove_file(RunFile::part_path(&arguments.out));
            folder.iter().for_each(|folder| drop(std::fs::remove_dir(folder)));
            Failure::while_trying(self.tried.clone())(refused)
        })?;
        self.overrides.iter().for_each(|text| session.note(EventKind::Override, text));
        let (controls, live) = (session.controls.clone(), session.live.clone());
        let steering = Steering { controls, live, latest, period_s: context.period_s };
        scope::admit(places.scope.as_ref(), &session, &steering);
        #[cfg(feature = "foxglove")]
        viewers::admit(places.viewers.as_ref(), &session, &steering);
        Ok(Running { session, steering, context })
    }

    fn header(&self, asked: &Asked) -> Result<RunHeader, Failure> {
        let arguments = &asked.arguments;
        let beside = arguments.controller.with_file_name(Project::FILE);
        let of_run = asked.project.as_ref().map(|project| project.opened.file.clone());
        let project = of_run.or_else(|| beside.is_file().then_some(beside));
        let files = [Some(&arguments.controller), arguments.rig.as_ref(), project.as_ref()];
        let parents: Vec<&Path> = files.into_iter().flatten().map(|path| path.as_path()).collect();
        Ok(RunHeader {
            period_s: self.setup.period_s,
            start_unix_ns: now_unix_ns(),
            port: self.port.to_string(),
            provenance: provenance(&parents, &arguments.out)?,
            controller: Some(flexbeam_files::read_bytes(&arguments.controller)?),
            excitation: None,
        })
    }
}

fn check(arguments: &cli::Run, file: &Controller) -> Result<(), NoRun> {
    if let Some(duration_s) = arguments.duration.filter(|s| !(*s > 0.0 && s.is_finite())) {
        return Err(NoRun::Duration(duration_s));
    }
    let (delay_s, period_s) = (file.design.delay_s, file.period_s);
    /// Rounding of a text file.
    const SAME: f64 = 1e-9;
    if (delay_s - period_s).abs() > SAME * period_s { Err(NoRun::Delay { delay_s, period_s }) } else { Ok(()) }
}

fn setup(asked: &Asked, file: &Controller) -> Result<Setup, Failure> {
    let arguments = &asked.arguments;
    let settings = asked.limited(kernel_settings(&file.settings, arguments.law.map(Into::into)));
    let live = Live { revision: 0, settings, reference: asked.reference.read(file.period_s)? };
    let controller = ControllerData { order: file.order, coefficients: file.coefficients() };
    let setup = setup_on(&arguments.link, Setup::new(controller, live, file.period_s))?;
    Ok(Setup { duration_s: arguments.duration, autostart: !arguments.wait, ..setup })
}

fn answer(arguments: &cli::Run, outcome: Outcome, context: &RunContext) -> Result<(), Failure> {
    let failed = outcome.recorded.failures.first();
    let kept = if failed.is_none() { arguments.out.clone() } else { RunFile::part_path(&arguments.out) };
    let result = run_result(&outcome.report, &outcome.recorded, context, Some(&kept));
    if arguments.json {
        println!("{}", json_text(&result));
    } else {
        print!("{}", run_text(&result));
        say(format_args!("wrote {}", kept.display()));
    }
    if let Cause::Fault(_) = outcome.report.cause {
        return Err(Failure::Fault(Box::new(Stopped(result.text))));
    }
    whole(&outcome.recorded, &arguments.out, result.unrecorded)
}

/// How the run went, for a person.
pub fn run_text(result: &RunResult) -> String {
    format!("{}\n{}", times(result).text(), counts(result).text())
}

fn times(result: &RunResult) -> Table {
    let columns = [("time", ""), ("median", ""), ("99 %", ""), ("99.9 %", ""), ("longest", "")];
    let rows = [("late by", &result.lateness), ("work in a period", &result.execution), ("tick alone", &result.tick)];
    rows.into_iter().fold(Table::new(&columns), |table, (name, t)| {
        let [a, b, c, d] = [t.median_s, t.p99_s, t.p999_s, t.max_s].map(|s| Cell::from(engineering(s, 3, "s")));
        table.row([name.into(), a, b, c, d])
    })
}

fn counts(result: &RunResult) -> Table {
    let link = &result.link;
    let rows = [
        ("ticks", result.ticks),
        ("missed periods", result.missed),
        ("ticks without a measurement", result.stale),
        ("frames late, twice, corrupt or foreign", link.late + link.duplicate + link.corrupt + link.foreign),
        ("samples not recorded", result.unrecorded),
        ("page faults", result.page_faults),
    ];
    rows.into_iter().fold(Table::new(&[("what", ""), ("count", "")]), |table, (name, n)| {
        table.row([name.into(), Cell::count(n as usize)])
    })
}
