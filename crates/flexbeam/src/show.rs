//! `flexbeam show`: what a file holds and where it came from.
//!
//! Enters: any file of ours. Leaves: tables, or one JSON object with the file's content and its history.
//! Deliberately absent: judgement; `flexbeam verify` gives that.

mod holds;
mod picture;
mod project;
mod run;

use std::path::Path;

use flexbeam_files::{
    Certificate, ColumnSummary, Controller, Document, Error, Fault, Layout, Model, Note, Project, RUN_SCHEMA,
    Recording, RecordingSummary, Rig, RunRecording, ShowResult, State, Step, Tried, json_text, pairs, schema_of, trace,
};
use flexbeam_lti::{Signals, StateSpace};

use crate::project::file_of;
use crate::rig_file::rig_parameters;
use crate::{Failure, cli};

/// The schemas that can be shown.
const SCHEMAS: [&str; 7] =
    [Model::SCHEMA, Controller::SCHEMA, Certificate::SCHEMA, Rig::SCHEMA, Project::SCHEMA, Note::SCHEMA, RUN_SCHEMA];

/// `flexbeam show`.
pub fn run(given: &cli::Show) -> Result<(), Failure> {
    let file = &file_of(&given.file);
    let arguments = &cli::Show { file: file.clone(), ..given.clone() };
    match schema_of(file)?.as_deref() {
        Some(Model::SCHEMA) => model(arguments),
        Some(Controller::SCHEMA) => document(arguments, holds::controller),
        Some(Certificate::SCHEMA) => document(arguments, holds::certificate),
        Some(Rig::SCHEMA) => {
            let parameters = rig_parameters(Some(file))?;
            document(arguments, |rig: &Rig| holds::rig(rig, &parameters))
        }
        Some(Project::SCHEMA) => document(arguments, project::project),
        Some(Note::SCHEMA) => document(arguments, holds::note),
        Some(RUN_SCHEMA) => of_run(arguments),
        Some(schema) => Err(unknown(file, schema).into()),
        None => recording(arguments),
    }
}

fn unknown(file: &Path, schema: &str) -> Error {
    let choices = SCHEMAS.map(String::from).to_vec();
    Error::new(Tried::Read, file, Fault::Choice { key: "schema".into(), found: schema.into(), choices, nearest: None })
}

fn document<D: Document>(arguments: &cli::Show, text: impl Fn(&D) -> String) -> Result<(), Failure> {
    let content = D::read(&arguments.file)?;
    let json =
        |file, history| json_text(&ShowResult { file, schema: D::SCHEMA, content: &content, poles: None, history });
    answer(arguments, D::SCHEMA, json, || text(&content))
}

fn model(arguments: &cli::Show) -> Result<(), Failure> {
    let content = Model::read(&arguments.file)?;
    let system = system(&content).map_err(Failure::while_trying(format!("show {}", arguments.file.display())))?;
    let json = |file, history| {
        let poles = Some(pairs(&system.poles()));
        json_text(&ShowResult { file, schema: Model::SCHEMA, content: &content, poles, history })
    };
    answer(arguments, Model::SCHEMA, json, || holds::model(&content, &system))
}

/// The continuous system where the file has one, else the sampled one.
fn system(model: &Model) -> Result<StateSpace, flexbeam_lti::Error> {
    model.continuous_state_space().unwrap_or_else(|| model.state_space())
}

fn recording(arguments: &cli::Show) -> Result<(), Failure> {
    let content = Recording::read(&arguments.file, &layout(arguments))?;
    if let Some(notice) = &content.notice {
        eprintln!("{notice}");
    }
    let signals = &content.signals;
    let summary =
        RecordingSummary { samples: signals.samples(), period_s: signals.period_s, columns: columns(signals) };
    let json =
        |file, history| json_text(&ShowResult { file, schema: Note::SCHEMA, content: &summary, poles: None, history });
    answer(arguments, Note::SCHEMA, json, || holds::recording(&summary))
}

fn of_run(arguments: &cli::Show) -> Result<(), Failure> {
    let content = RunRecording::read(&arguments.file)?.agreeing_with(&layout(arguments))?;
    let summary = content.summary(columns(&content.signals(0..content.samples.samples())));
    let json =
        |file, history| json_text(&ShowResult { file, schema: RUN_SCHEMA, content: &summary, poles: None, history });
    answer(arguments, RUN_SCHEMA, json, || run::run(&summary))?;
    if let Some(into) = &arguments.plots {
        let files = picture::run(&content, into)?;
        eprintln!("wrote {} in {}", files.join(", "), into.display());
    }
    Ok(())
}

fn layout(arguments: &cli::Show) -> Layout {
    let columns = Some(arguments.columns.clone()).filter(|columns| !columns.is_empty());
    Layout { columns, period_s: arguments.period, resample_s: arguments.resample }
}

fn columns(signals: &Signals) -> Vec<ColumnSummary> {
    let columns = signals.names.iter().zip(signals.data.row_iter()).map(|(name, row)| ColumnSummary {
        name: name.clone(),
        min: row.min(),
        max: row.max(),
        mean: row.mean(),
        std: row.variance().sqrt(),
    });
    columns.collect()
}

fn answer(
    arguments: &cli::Show,
    schema: &str,
    json: impl Fn(String, Vec<Step>) -> String,
    text: impl Fn() -> String,
) -> Result<(), Failure> {
    let history = trace(&arguments.file)?;
    let file = arguments.file.display().to_string();
    match arguments.json {
        true => println!("{}", json(file, history)),
        false => print!("{file}: {schema}\n\n{}\n{}", text(), lineage(&history)),
    }
    Ok(())
}

/// The walk back to the recording, a parent one step further in than its child.
fn lineage(history: &[Step]) -> String {
    let lines = history.iter().map(|step| {
        let indent = match step.generation {
            0 => String::new(),
            generation => "   ".repeat(generation - 1) + "└─ ",
        };
        let schema = step.schema.as_deref().unwrap_or("no schema");
        let state = match step.state {
            State::Start => "",
            State::Same => ", unchanged",
            State::Changed => ", CHANGED since",
            State::Missing => ", MISSING",
        };
        let command = step.command.as_ref().map_or(String::new(), |command| {
            let under = if step.generation == 0 { String::new() } else { "   ".repeat(step.generation) };
            format!("{under}made by: {command}\n")
        });
        format!("{indent}{} ({schema}{state})\n{command}", step.path.display())
    });
    "where it came from\n".to_string() + &lines.collect::<String>()
}
