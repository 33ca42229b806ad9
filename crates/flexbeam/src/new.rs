//! `flexbeam new`: a project that runs at once, made by the commands themselves on the simulated rig.
//!
//! Enters: a folder's name, perhaps a rig file. Leaves: the folder, whole or not at all.

mod place;

use std::path::Path;

use clap::Args;
use flexbeam_files::{
    Controller, Document, Law, NewResult, Overwrite, Project, json_text, read_bytes, toml_string, write_bytes,
};
use flexbeam_rig::RigParameters;

use crate::Failure;
use crate::cli;
use crate::design::designed;
use crate::identify::identified;
use crate::law::with_thresholds;
use crate::on_rig::asked_by_signal;
use crate::output::waiting;
use crate::record::recorded;
use crate::reproduce::{BETA, RISE_TIME_S};
use crate::rig_file::rig_parameters;
use crate::rig_test::{RAMP, breakaway};
use place::Place;

/// Cut-off of the measurements' low-pass filters, as a part of the sample rate.
const LOW_PASS: f64 = 0.15;

/// Block rows that see enough of the slowest swing, with friction and noise, too.
const BLOCK_ROWS: usize = 50;

/// Seed of excitation and noise.
const SEED: u64 = 1;

/// Ctrl-C, or another signal to end.
#[derive(Debug, thiserror::Error)]
#[error("found a signal to end, needed a second or two\nhint: nothing was made")]
struct Interrupted;

/// Runs the command.
pub fn run(arguments: &cli::New) -> Result<(), Failure> {
    let place = Place::of(&arguments.folder)?;
    let rig = rig_file(arguments)?;
    let parameters = rig_parameters(arguments.rig.as_deref())?;
    let asked = asked_by_signal()?;
    let unless_asked = || match asked.load(std::sync::atomic::Ordering::Acquire) {
        true => Err(Failure::while_trying(format!("make {}", arguments.folder.display()))(Interrupted)),
        false => Ok(()),
    };
    let half = place.beside()?;
    let name = arguments.name.clone().unwrap_or_else(|| place.name());
    let write = |name: &str, bytes: &[u8]| write_bytes(&half.path().join(name), bytes, Overwrite::Refuse);
    write("rig.toml", &rig)?;
    write(Project::FILE, PROJECT.replace("{name}", &toml_string(&name)).as_bytes())?;
    for step in steps(half.path(), &parameters) {
        step()?;
        unless_asked()?;
    }
    place.take(half)?;
    answer(arguments, name);
    Ok(())
}

/// The project's file, with a place for its name.
const PROJECT: &str = include_str!("new/flexbeam.toml");

/// The rig file's bytes: the one given, or one that says nothing.
fn rig_file(arguments: &cli::New) -> Result<Vec<u8>, Failure> {
    Ok(match &arguments.rig {
        Some(path) => read_bytes(path)?,
        None => include_bytes!("new/rig.toml").to_vec(),
    })
}

/// A recording, a model of it, a controller for the model that knows the rig's friction: as the commands make them.
fn steps<'a>(folder: &'a Path, rig: &'a RigParameters) -> [Box<dyn FnOnce() -> Result<(), Failure> + 'a>; 3] {
    let file = |name: &str| folder.join(name);
    let rig_file = Some(file("rig.toml"));
    // Friction in the data would bend the model, and the loop would tremble: see the book, Measurements.
    let record = cli::Record { rig: rig_file, linear: true, out: file("recording.csv"), ..defaults(&[]) };
    let block_rows = vec![BLOCK_ROWS];
    let identify: cli::Identify = defaults(&["recording.csv"]);
    let identify = cli::Identify { recording: file("recording.csv"), block_rows, out: file("model.toml"), ..identify };
    [
        Box::new(move || recorded(&record).map(drop)),
        Box::new(move || identified(&identify).map(drop)),
        Box::new(move || controller(folder, rig)),
    ]
}

/// The ramp test comes first: the design asks for the voltage that friction leaves.
fn controller(folder: &Path, rig: &RigParameters) -> Result<(), Failure> {
    let sign = waiting("measuring friction");
    let (friction, detection) = breakaway(rig, &RAMP, SEED)?;
    let thresholds = friction.inverse_thresholds(detection.resolution_rad);
    sign.set_message("designing");
    let design: cli::Design = defaults(&["model.toml", "--stability-degree", "1", "--uncertainty", "beam"]);
    let residual_v = friction.residual_v(&thresholds);
    let out = folder.join("controller.toml");
    let designed = designed(&cli::Design {
        model: folder.join("model.toml"),
        rig: Some(folder.join("rig.toml")),
        stability_degree: BETA,
        residual_voltage: residual_v,
        rise_time: Some(RISE_TIME_S),
        low_pass_hz: Some(LOW_PASS / rig.period_s),
        period: rig.period_s,
        out: out.clone(),
        ..design
    })?;
    let settings = with_thresholds(designed.settings.clone(), Law::Inverse, &friction, &thresholds);
    Controller { settings, ..designed }.write(&out, Overwrite::SameKind)?;
    Ok(())
}

/// A command's arguments where these words stand behind its name.
fn defaults<A: Args>(words: &[&str]) -> A {
    let command = A::augment_args(clap::Command::new("flexbeam"));
    let matches = command.try_get_matches_from(["flexbeam"].iter().chain(words)).expect("words that the command takes");
    A::from_arg_matches(&matches).expect("words that the command takes")
}

fn answer(arguments: &cli::New, name: String) {
    let folder = arguments.folder.display().to_string();
    if arguments.json {
        println!("{}", json_text(&NewResult { folder, name, files: FILES.map(|(file, _)| file.into()).to_vec() }));
        return;
    }
    println!("{folder}: the project {name:?}");
    FILES.iter().for_each(|(file, what)| println!("  {file:20}{what}"));
    println!(
        "next: flexbeam run {folder} --scope\n\
         with your own rig at PORT:\n  \
         flexbeam record --port PORT -o {folder}/recording.csv\n  \
         flexbeam identify {folder}/recording.csv --block-rows {BLOCK_ROWS} -o {folder}/model.toml\n  \
         flexbeam design {folder}/model.toml --rig {folder}/rig.toml --stability-degree {BETA} --uncertainty beam -o {folder}/controller.toml\n  \
         flexbeam rig test --port PORT --apply-to {folder}/controller.toml\n  \
         flexbeam run {folder} --port PORT, or port = \"PORT\" in {folder}/flexbeam.toml"
    );
}

/// What a new project holds.
const FILES: [(&str, &str); 6] = [
    ("flexbeam.toml", "how it runs, what is watched: edit it"),
    ("rig.toml", "the simulated rig"),
    ("recording.csv", "of that rig's linear model, without friction"),
    ("recording.csv.toml", "where the recording came from"),
    ("model.toml", "identified from the recording"),
    ("controller.toml", "designed for the model, with the law against friction"),
];
