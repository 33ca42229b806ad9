//! `--orders`: every order side by side, as a table, as figures and as JSON.

use std::path::Path;

use flexbeam_files::{ModeResult, OrderResult};
use flexbeam_ident::Options;
use flexbeam_ident::orders::{OrderRow, Stability, orders};
use flexbeam_report::{Cell, Colour, Figure, Marker, Panel, Scale, Series, Table, significant};

use super::{Experiment, Hinted, by_name};
use crate::output::write_figure;
use crate::{Failure, cli};

/// A fit below this is on its way to an overflow [percent].
const BOTTOMLESS: f64 = -1e6;

/// The rows that were asked for; none where none were.
pub(super) fn rows(
    arguments: &cli::Identify,
    experiment: &Experiment,
    options: &Options,
) -> Result<Vec<OrderRow>, Failure> {
    let Some(largest) = arguments.orders else { return Ok(Vec::new()) };
    orders(&experiment.inputs, &experiment.outputs, options, largest)
        .map_err(Hinted)
        .map_err(Failure::while_trying(format!("compare orders on {}", arguments.recording.display())))
}

/// For `--json`.
pub(super) fn results(experiment: &Experiment, rows: &[OrderRow]) -> Vec<OrderResult> {
    let result = |row: &OrderRow| OrderResult {
        order: row.order,
        fit_percent: by_name(experiment, row.fit_percent.as_ref()),
        estimation_fit_percent: by_name(experiment, Some(&row.estimation_fit_percent)),
        criterion: Some(row.criterion).filter(|criterion| criterion.is_finite()),
        modes: row
            .modes
            .iter()
            .map(|(mode, stable)| ModeResult {
                frequency_rad_s: mode.frequency_rad_s,
                damping: mode.damping,
                stable_frequency: stable.frequency,
                stable_damping: stable.damping,
                stable_shape: stable.shape,
            })
            .collect(),
    };
    rows.iter().map(result).collect()
}

/// Order, mean fits, criterion; the least criterion is marked.
pub(super) fn text(experiment: &Experiment, rows: &[OrderRow]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let least = rows.iter().map(|row| row.criterion).fold(f64::INFINITY, f64::min);
    let percent = |fit: f64| Cell::Number(if fit > BOTTOMLESS { format!("{fit:.2}") } else { "overflow".into() });
    let columns =
        [("order", ""), ("fit on unseen samples", "%"), ("on those that estimated", "%"), ("criterion", ""), ("", "")];
    let table = rows.iter().fold(Table::new(&columns), |table, row| {
        table.row([
            Cell::Number(row.order.to_string()),
            row.fit_percent.as_ref().map_or("none left".into(), |fits| percent(mean(fits))),
            percent(mean(&row.estimation_fit_percent)),
            Cell::Number(if row.criterion.is_finite() { significant(row.criterion, 7) } else { "overflow".into() }),
            if row.criterion == least { "least".into() } else { "".into() },
        ])
    });
    let over = if experiment.outputs.channels() > 1 { ", means over the outputs" } else { "" };
    format!("\norders{over}\n{}", table.text())
}

/// The stabilisation diagram, and fit and criterion over the order.
pub(super) fn draw(folder: &Path, rows: &[OrderRow], outputs: usize) -> Result<(), Failure> {
    if rows.is_empty() {
        return Ok(());
    }
    let mut written = write_figure(folder, "stabilisation", &stabilisation(rows, outputs))?.to_vec();
    written.extend(write_figure(folder, "orders", &fits(rows))?);
    eprintln!("{}: {}", folder.display(), written.join(", "));
    Ok(())
}

/// Poles over frequency and order, each with the sign of what it shares with the order before.
fn stabilisation(rows: &[OrderRow], outputs: usize) -> Figure {
    let stable = |s: Stability| usize::from(s.frequency) + usize::from(s.damping) + 2 * usize::from(s.shape);
    let (shape, both) =
        if outputs > 1 { ("frequency and shape", "frequency, damping, shape") } else { ("", "frequency and damping") };
    // With one output every shape is alike: frequency and damping are all there is to be stable.
    let kinds: &[(&str, &[usize], Marker, Colour)] = &[
        ("new", &[0], Marker::Cross, Colour::Grey),
        ("frequency", if outputs > 1 { &[1] } else { &[1, 3] }, Marker::Circle, Colour::Amber),
        ("frequency and damping", if outputs > 1 { &[2] } else { &[] }, Marker::Square, Colour::Sky),
        (shape, if outputs > 1 { &[3] } else { &[] }, Marker::Diamond, Colour::Green),
        (both, &[4], Marker::Disc, Colour::Blue),
    ];
    let panel = kinds.iter().fold(Panel::new("Order"), |panel, (name, which, marker, colour)| {
        let points = rows.iter().flat_map(|row| row.modes.iter().map(move |(mode, s)| (row.order, mode, *s)));
        let (x, y): (Vec<f64>, Vec<f64>) = points
            .filter(|(_, _, s)| which.contains(&stable(*s)))
            .map(|(order, mode, _)| (mode.frequency_rad_s / std::f64::consts::TAU, order as f64))
            .unzip();
        if x.is_empty() { panel } else { panel.with(Series::markers(name, &x, &y, *marker).colour(*colour)) }
    });
    let title = "Stabilisation: what each pole shares with the order before";
    Figure::new(title, "Natural frequency [Hz]").size(800.0, 460.0).panel(panel.y_scale(Scale::Integer))
}

/// What is worse than the mean of the output has no place on the axes: it would hide all the others.
fn fits(rows: &[OrderRow]) -> Figure {
    let order: Vec<f64> = rows.iter().map(|row| row.order as f64).collect();
    let of = |value: &dyn Fn(&OrderRow) -> f64| rows.iter().map(value).collect::<Vec<f64>>();
    let shown = |fit: f64| if fit >= 0.0 { fit } else { f64::NAN };
    let estimating = |row: &OrderRow| shown(mean(&row.estimation_fit_percent));
    let unseen = of(&|row| row.fit_percent.as_ref().map_or(f64::NAN, |fits| shown(mean(fits))));
    let criterion = of(&|row| if estimating(row).is_nan() { f64::NAN } else { row.criterion });
    let mut fit = Panel::new("Fit [%]");
    if unseen.iter().any(|fit| fit.is_finite()) {
        fit = fit.with(Series::line("unseen samples", &order, &unseen).marker(Marker::Disc));
    }
    let fit = fit.with(Series::line("those that estimated", &order, &of(&estimating)).marker(Marker::Circle));
    let criterion = Panel::new("Criterion").with(Series::line("", &order, &criterion).marker(Marker::Square));
    let title = "Fit and information criterion of every order";
    Figure::new(title, "Order").x_scale(Scale::Integer).panel(fit).panel(criterion)
}

fn mean(fits: &[f64]) -> f64 {
    fits.iter().sum::<f64>() / fits.len() as f64
}
