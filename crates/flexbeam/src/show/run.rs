//! What a recording of a run holds, for a person.

use flexbeam_files::{RunEvent, RunReference, RunResult, RunShape, RunSummary, json_text};
use flexbeam_report::{Cell, Table, significant};

use super::holds::{DIGITS, columns, length};
use crate::run::run_text;

/// Length, columns, settings, events and report.
pub(super) fn run(run: &RunSummary<'_>) -> String {
    let mut text = format!("{}, on {}\n", length(run.samples, run.period_s), run.port);
    text += &format!(
        "while the controller ran: {} samples; ticks missed: {}; stale measurements: {}\n",
        run.running, run.missed, run.stale
    );
    if let Some(cut) = run.cut_off {
        text += &format!("ENDS TOO EARLY: {} bytes are whole, {} after them are not used\n", cut.whole, cut.unused);
    }
    text += &format!("\n{}", columns(&run.columns));
    text += &settings(run);
    if !run.events.is_empty() {
        text += &format!("\n{}", events(run.events).text());
    }
    match run.report.map(|report| (report, RunResult::of_report(report))) {
        Some((_, Some(result))) => text += &format!("\n{}", run_text(&result)),
        Some((report, None)) => text += &format!("\nreport: {}\n", json_text(report)),
        None => {}
    }
    text
}

/// The settings at the start, then what each revision changed.
fn settings(run: &RunSummary<'_>) -> String {
    let mut before: Vec<(String, String)> = Vec::new();
    let mut text = String::new();
    for live in run.settings {
        let now = live.texts();
        let changed =
            now.iter().filter(|text| !before.contains(text)).map(|(name, value)| format!("{name} = {}", short(value)));
        let unset = before.iter().filter(|(name, _)| !now.iter().any(|(other, _)| other == name));
        let words: Vec<String> = changed.chain(unset.map(|(name, _)| format!("{name} = default"))).collect();
        let from_s = significant(live.tick as f64 * run.period_s, DIGITS);
        text += &format!("\nsettings {} from {from_s} s: {}\n", live.revision, reference(&live.reference));
        text += &wrapped(&words);
        before = now;
    }
    text
}

/// A number with the digits that a person compares; a word as it is.
fn short(value: &str) -> String {
    value.parse().map_or_else(|_| value.to_string(), |x: f64| significant(x, DIGITS))
}

/// Words with commas between them, in indented lines of the terminal's usual width.
fn wrapped(words: &[String]) -> String {
    const WIDTH: usize = 100;
    let mut lines = vec![String::new()];
    for word in words {
        let line = lines.last_mut().expect("there is always a line");
        if line.is_empty() {
            *line = format!("  {word}");
        } else if line.len() + word.len() + 2 > WIDTH {
            line.push(',');
            lines.push(format!("  {word}"));
        } else {
            *line += &format!(", {word}");
        }
    }
    lines.iter().filter(|line| !line.is_empty()).map(|line| format!("{line}\n")).collect()
}

fn reference(reference: &RunReference) -> String {
    let RunReference { shape, amplitude_rad, period_s, offset_rad } = *reference;
    let number = |x: f64| significant(x, DIGITS);
    let degrees = |x: f64| number(x.to_degrees());
    match shape {
        RunShape::Step => format!("step of {} degree from {}", degrees(amplitude_rad), degrees(offset_rad)),
        RunShape::File => "samples of a file".into(),
        RunShape::Square | RunShape::Sine | RunShape::Sawtooth => {
            let (around, word) = (degrees(offset_rad), json_text(&shape));
            let word = word.trim_matches('"');
            format!("{word}, ±{} degree around {around}, every {} s", degrees(amplitude_rad), number(period_s))
        }
    }
}

fn events(events: &[RunEvent]) -> Table {
    let heads = [("at", "s"), ("event", ""), ("", "")];
    events.iter().fold(Table::new(&heads), |table, event| {
        table.row([Cell::number(event.time_s, DIGITS), event.kind.as_str().into(), event.text.as_str().into()])
    })
}
