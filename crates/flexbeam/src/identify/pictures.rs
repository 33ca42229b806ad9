//! The figures of `--plots`: singular values, measured and simulated outputs.

use std::path::Path;

use flexbeam_ident::validate::validate;
use flexbeam_ident::{Identified, Options};
use flexbeam_lti::{Mat, StateSpace};
use flexbeam_report::{Colour, Figure, Marker, Panel, Scale, Series};

use super::{Experiment, Found, Hinted, bode};
use crate::Failure;
use crate::output::{folder, write_figure};

/// Height of one output's panel, and of what stands around the panels [px].
const PANEL_PX: f64 = 190.0;
const AROUND_PX: f64 = 120.0;

/// Writes the figures into a folder.
pub(super) fn draw(path: &Path, experiment: &Experiment, found: &Found, options: &Options) -> Result<(), Failure> {
    folder(path)?;
    let mut written = Vec::new();
    written.extend(write_figure(path, "singular_values", &singular_values(&found.identified, usize::MAX))?);
    let outputs = outputs(experiment, &found.identified, options)
        .map_err(Failure::while_trying(format!("draw the outputs into {}", path.display())))?;
    written.extend(write_figure(path, "outputs", &outputs)?);
    written.extend(responses(path, experiment, found)?);
    eprintln!("{}: {}", path.display(), written.join(", "));
    Ok(())
}

/// A figure for each input; nothing, and the reason on standard error, where the recording is too short or does not excite.
fn responses(path: &Path, experiment: &Experiment, found: &Found) -> Result<Vec<String>, Failure> {
    let evidence = match bode::Evidence::of(experiment) {
        Ok(evidence) => evidence,
        Err(why) => {
            eprintln!("no measured frequency response: {}", Hinted(why));
            return Ok(Vec::new());
        }
    };
    let mut written = Vec::new();
    for (input, name) in experiment.inputs.names.iter().enumerate() {
        let figure = bode::figure(experiment, found, &evidence, input)
            .map_err(Failure::while_trying(format!("draw the responses into {}", path.display())))?;
        let name = if input == 0 { "frequency_response".into() } else { format!("frequency_response_{name}") };
        written.extend(write_figure(path, &name, &figure)?);
    }
    Ok(written)
}

/// On a logarithmic axis, with the chosen order between those kept and those left out.
pub(crate) fn singular_values(identified: &Identified, most: usize) -> Figure {
    let sigma: Vec<f64> = identified.singular_values.iter().copied().take(most).collect();
    let n = identified.singular_order.min(sigma.len());
    let index: Vec<f64> = (1..=sigma.len()).map(|k| k as f64).collect();
    let left_out = Series::stem("left out", &index[n..], &sigma[n..]).marker(Marker::Circle).colour(Colour::Grey);
    Figure::new("Order from the singular values", "Index").x_scale(Scale::Integer).panel(
        Panel::new("Singular value σₖ")
            .log_y()
            .stem("kept", &index[..n], &sigma[..n])
            .with(left_out)
            .vertical(n as f64 + 0.5, &format!("chosen order n = {}", identified.order)),
    )
}

/// Each output on the samples that were not used for estimation (on all when none are left), measured and simulated.
fn outputs(
    experiment: &Experiment,
    identified: &Identified,
    options: &Options,
) -> Result<Figure, flexbeam_ident::Error> {
    let (all, estimating) = (experiment.inputs.samples(), identified.estimation_samples);
    let first = if estimating < all { estimating } else { 0 };
    let part = |data: &Mat, means: &[f64]| {
        let mut part = data.columns(first, all - first).into_owned();
        part.row_iter_mut().zip(means).for_each(|(mut row, mean)| row.add_scalar_mut(-mean));
        part
    };
    let Y = part(&experiment.outputs.data, &identified.output_means);
    let U = part(&experiment.inputs.data, &identified.input_means);
    let simulated = simulated(identified, &U, &Y)?;
    let fits = identified.fit_percent.as_ref().unwrap_or(&identified.estimation_fit_percent);
    let t: Vec<f64> = (first..all).map(|k| k as f64 * experiment.inputs.period_s).collect();
    let title = if first == 0 { "Measured and simulated" } else { "Measured and simulated, unseen samples" };
    let height = AROUND_PX + PANEL_PX * Y.nrows() as f64;
    let figure = Figure::new(title, "Time [s]").size(800.0, height);
    Ok((0..Y.nrows()).fold(figure, |figure, k| {
        let row = |M: &Mat| M.row(k).iter().copied().collect::<Vec<f64>>();
        let label = label(experiment, k, options.remove_mean, fits[k]);
        figure.panel(
            Panel::new(&label)
                .with(Series::line("measured", &t, &row(&Y)).colour(Colour::Grey).width(2.2))
                .with(Series::line("simulated", &t, &row(&simulated)).colour(Colour::Blue)),
        )
    }))
}

/// The model's answer, from the initial state that suits all outputs best, each weighted by its rms as in the fits.
fn simulated(identified: &Identified, U: &Mat, Y: &Mat) -> Result<Mat, flexbeam_ident::Error> {
    let rms: Vec<f64> = Y.row_iter().map(|row| row.norm() / (Y.ncols() as f64).sqrt()).collect();
    let weight = |k: usize| if rms[k] > 0.0 { rms[k] } else { 1.0 };
    let over_rms = |M: &Mat| Mat::from_fn(M.nrows(), M.ncols(), |r, c| M[(r, c)] / weight(r));
    let model = &identified.model;
    let weighted = StateSpace { C: over_rms(&model.C), D: over_rms(&model.D), ..model.clone() };
    let answer = validate(&weighted, U, &over_rms(Y))?.simulated;
    Ok(Mat::from_fn(Y.nrows(), Y.ncols(), |r, c| answer[(r, c)] * weight(r)))
}

fn label(experiment: &Experiment, k: usize, remove_mean: bool, fit_percent: f64) -> String {
    let (name, unit) = (&experiment.outputs.names[k], &experiment.outputs.units[k]);
    let quantity = name.strip_suffix(unit.as_str()).map_or(name.as_str(), |stem| stem.trim_end_matches('_'));
    let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
    let mean = if remove_mean { ", mean removed" } else { "" };
    format!("{quantity}{unit}{mean} (fit {fit_percent:.1} %)")
}
