//! What a recording of a run holds, for a person.

use flexbeam_files::{RunEvent, RunReference, RunShape, RunSummary, json_text};
use flexbeam_report::{Cell, Table, significant};

use super::holds::{DIGITS, columns, length};

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
    if !run.settings.is_empty() {
        text += &format!("\n{}", settings(run).text());
    }
    if !run.events.is_empty() {
        text += &format!("\n{}", events(run.events).text());
    }
    if let Some(report) = run.report {
        text += &format!("\nreport: {}\n", json_text(report));
    }
    text
}

/// The settings at the start, then what each revision changed.
fn settings(run: &RunSummary<'_>) -> Table {
    let heads = [("revision", ""), ("from", "s"), ("reference", ""), ("settings", "")];
    let mut before: Vec<(String, String)> = Vec::new();
    run.settings.iter().fold(Table::new(&heads), |table, live| {
        let now = live.texts();
        let changed = now.iter().filter(|text| !before.contains(text)).map(|(name, value)| format!("{name} = {value}"));
        let unset = before.iter().filter(|(name, _)| !now.iter().any(|(other, _)| other == name));
        let unset = unset.map(|(name, _)| format!("{name} = default"));
        let changed = changed.chain(unset).collect::<Vec<_>>().join(", ");
        before = now;
        let from_s = Cell::number(live.tick as f64 * run.period_s, DIGITS);
        table.row([Cell::count(live.revision as usize), from_s, reference(&live.reference).into(), changed.into()])
    })
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
