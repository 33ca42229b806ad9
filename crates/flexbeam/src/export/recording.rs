//! A recording as CSV or for MATLAB.

use std::path::Path;

use flexbeam_files::{
    Document, Error, ExportResult, Fault, Layout, MatVariable, Note, Overwrite, RUN_SCHEMA, Recording, RunRecording,
    Tried, check_free, check_free_for_mat, json_text, mat_bytes, mat_variables, read_bytes, schema_of, sha256_hex,
    write_bytes, write_signals,
};
use flexbeam_lti::Signals;
use flexbeam_report::engineering;

use crate::output::{overwrite, provenance, waiting};
use crate::{Failure, cli};

/// What goes into the other file.
struct Content {
    /// All samples, gaps and all.
    signals: Signals,
    /// When they were taken [s].
    time_s: Vec<f64>,
    /// What else is known, by name, for a form that has a place for it.
    texts: Vec<(&'static str, String)>,
    /// What a person should know.
    notice: Option<String>,
}

/// What was written: its bytes' hash and its columns.
struct Exported {
    sha256: String,
    columns: Vec<String>,
}

pub(super) fn export(arguments: &cli::Export) -> Result<(), Failure> {
    let replace = permitted(arguments)?;
    let sign = waiting("reading the recording");
    let content = Content::read(arguments)?;
    sign.set_message("writing");
    let exported = if arguments.form == cli::Form::Mat {
        mat(arguments, &content, replace)?
    } else {
        csv(arguments, &content, replace)?
    };
    sign.finish_and_clear();
    answer(arguments, content, exported);
    Ok(())
}

/// Whether the file may be written, asked before the work; never onto the file that it is made from.
fn permitted(arguments: &cli::Export) -> Result<Overwrite, Failure> {
    let (file, out) = (&arguments.file, &arguments.out);
    let onto_itself = out.exists() && file.canonicalize().ok() == out.canonicalize().ok();
    if onto_itself && !arguments.force {
        return Err(Error::new(Tried::Write, out, Fault::Exists).into());
    }
    let replace = if arguments.force { Overwrite::Allow } else { Overwrite::SameKind };
    if arguments.form == cli::Form::Mat {
        check_free_for_mat(out, replace)?;
    } else {
        check_free(out, replace)?;
        overwrite::<Note>(&Note::path_for(out), arguments.force)?;
    }
    Ok(replace)
}

impl Content {
    fn read(arguments: &cli::Export) -> Result<Content, Failure> {
        let columns = Some(arguments.columns.clone()).filter(|columns| !columns.is_empty());
        let layout = Layout { columns, period_s: arguments.period, resample_s: arguments.resample };
        match schema_of(&arguments.file)?.as_deref() {
            Some(RUN_SCHEMA) => Content::of_run(&arguments.file, &layout),
            _ => Content::of_table(&arguments.file, &layout),
        }
    }

    fn of_table(file: &Path, layout: &Layout) -> Result<Content, Failure> {
        let recording = Recording::read(file, layout)?;
        let time_s = recording.instants_s();
        let texts = vec![("source_sha256", recording.sha256)];
        Ok(Content { signals: recording.signals, time_s, texts, notice: recording.notice })
    }

    /// Every sample of a run: unlike an identification, a person may want to see the gaps.
    fn of_run(file: &Path, layout: &Layout) -> Result<Content, Failure> {
        let run = RunRecording::read(file)?.agreeing_with(layout)?;
        let all = 0..run.samples.samples();
        let header = &run.header;
        let mut texts = vec![
            ("source_sha256", run.sha256.clone()),
            ("run_tool", header.provenance.tool.clone()),
            ("run_command", header.provenance.command.clone().unwrap_or_default()),
            ("port", header.port.clone()),
            ("start_unix_ns", header.start_unix_ns.to_string()),
            ("settings_json", json_text(&run.settings)),
            ("events_json", json_text(&run.events)),
        ];
        texts.extend(header.controller.as_ref().map(|bytes| ("controller_sha256", sha256_hex(bytes))));
        texts.extend(run.report.as_ref().map(|report| ("report_json", json_text(report))));
        Ok(Content { signals: run.signals(all.clone()), time_s: run.time_s(all), texts, notice: run.cut_off_notice() })
    }
}

/// The table, with a note beside it that leads back to the source.
fn csv(arguments: &cli::Export, content: &Content, replace: Overwrite) -> Result<Exported, Failure> {
    let (out, note_path) = (&arguments.out, Note::path_for(&arguments.out));
    let origin = provenance(&[&arguments.file], &note_path)?;
    write_signals(&content.signals, Some(&content.time_s), out, replace)?;
    let bytes = read_bytes(out)?;
    Note::new(&content.signals, &bytes, origin).write(&note_path, replace)?;
    let columns = std::iter::once("time_s".to_string()).chain(content.signals.names.iter().cloned()).collect();
    Ok(Exported { sha256: sha256_hex(&bytes), columns })
}

/// One variable a column, and text variables that say where it came from.
fn mat(arguments: &cli::Export, content: &Content, replace: Overwrite) -> Result<Exported, Failure> {
    let origin = provenance(&[&arguments.file], &arguments.out)?;
    let source = origin.parents.first().map(|parent| parent.path.clone()).unwrap_or_default();
    let own = [("source", source), ("tool", origin.tool), ("command", origin.command.unwrap_or_default())];
    let texts =
        own.iter().chain(&content.texts).map(|(name, text)| (name.to_string(), MatVariable::Text(text.clone())));
    let mut variables = mat_variables(&content.signals, content.time_s.clone());
    variables.extend(texts);
    let bytes = mat_bytes(&variables).map_err(|fault| Error::new(Tried::Write, &arguments.out, fault))?;
    write_bytes(&arguments.out, &bytes, replace)?;
    let columns = variables.into_iter().map(|(name, _)| name).collect();
    Ok(Exported { sha256: sha256_hex(&bytes), columns })
}

fn answer(arguments: &cli::Export, content: Content, exported: Exported) {
    if let Some(notice) = &content.notice {
        eprintln!("{notice}");
    }
    let (samples, period_s) = (content.signals.samples(), content.signals.period_s);
    let (file, source) = (arguments.out.display().to_string(), arguments.file.display().to_string());
    if !arguments.json {
        let period = engineering(period_s, 4, "s");
        println!("{file}: {samples} samples of {period} from {source}: {}", exported.columns.join(", "));
        return;
    }
    let format = if arguments.form == cli::Form::Mat { "mat" } else { "csv" };
    println!(
        "{}",
        json_text(&ExportResult {
            file,
            sha256: exported.sha256,
            format: format.into(),
            source,
            columns: exported.columns,
            samples,
            period_s,
            notice: content.notice,
        })
    );
}
