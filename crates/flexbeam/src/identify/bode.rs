//! The figure `frequency_response`: as measured, without a model, and as the model says.

use std::f64::consts::TAU;

use flexbeam_ident::spectrum::{Averaged, Measured, Segments, averaged, circular_quantile, h1, repeats_after};
use flexbeam_lti::C64;
use flexbeam_lti::response::frequency_response;
use flexbeam_report::{Colour, Dash, Figure, Marker, Panel, Scale, Series};

use super::{Experiment, Found};
use crate::response::unwrapped_deg;

/// Points of the model's curve.
const POINTS: usize = 800;
/// Height of a panel, and of what stands around the panels [px].
const PANEL_PX: f64 = 170.0;
const AROUND_PX: f64 = 120.0;
/// Probability of the band.
const LEVEL: f64 = 0.95;
/// The band's lower end goes down to this part of the magnitude: a logarithmic axis has no zero.
const LOWEST: f64 = 0.03;

/// What was measured, and how.
pub(super) enum Evidence {
    /// Averaged periods of a periodic excitation.
    Periods(Averaged),
    /// H1 over overlapping pieces.
    Pieces(Measured),
}

impl Evidence {
    /// Averaged periods where the voltage repeats often enough, else H1.
    ///
    /// Errors: those of [`averaged`] and [`h1`].
    pub(super) fn of(experiment: &Experiment) -> Result<Evidence, flexbeam_ident::Error> {
        let Experiment { inputs, outputs, period_samples } = experiment;
        let seen = || repeats_after(&inputs.data.row(0).iter().copied().collect::<Vec<f64>>());
        let period = if inputs.channels() == 1 { period_samples.or_else(seen) } else { None };
        let whole = period.map_or(0, |period| inputs.samples() / period);
        match period {
            // The first period holds the transient, where another one can be spared.
            Some(period) if whole >= 2 => {
                averaged(inputs, outputs, period, usize::from(whole >= 3)).map(Evidence::Periods)
            }
            _ => h1(inputs, outputs, Segments::of_record(inputs.samples())).map(Evidence::Pieces),
        }
    }

    fn measured(&self) -> &Measured {
        match self {
            Evidence::Periods(found) => &found.measured,
            Evidence::Pieces(found) => found,
        }
    }
}

/// Magnitude and phase of each output over one input, and below them what the measurement is worth.
///
/// Errors: those of the model's response.
pub(super) fn figure(
    experiment: &Experiment,
    found: &Found,
    evidence: &Evidence,
    input: usize,
) -> Result<Figure, flexbeam_ident::Error> {
    let measured = evidence.measured();
    let hz: Vec<f64> = measured.omega_rad_s.iter().map(|w| w / TAU).collect();
    let (first, last) = (hz[0], hz[hz.len() - 1]);
    let model_hz: Vec<f64> = (0..POINTS).map(|k| first * (last / first).powf(k as f64 / (POINTS - 1) as f64)).collect();
    let omega: Vec<f64> = model_hz.iter().map(|f| f * TAU).collect();
    let model = frequency_response(&found.identified.model, &omega)?;
    let mut figure = Figure::new("Frequency response, measured and of the model", "Frequency [Hz]").log_x();
    let mut panels = 1;
    for output in 0..experiment.outputs.channels() {
        let of_model: Vec<C64> = model.iter().map(|G| G[(output, input)]).collect();
        let of_data: Vec<C64> = measured.G.iter().map(|G| G[(output, input)]).collect();
        let std: Vec<f64> = measured.std.iter().map(|std| std[(output, input)]).collect();
        figure = figure
            .panel(magnitude(&name(experiment, output, input), (&hz, &of_data, &std), (&model_hz, &of_model)))
            .panel(phase((&hz, &of_data), (&model_hz, &of_model)));
        panels += 2;
    }
    let figure = figure.panel(worth(experiment, evidence, &hz));
    Ok(figure.size(800.0, AROUND_PX + PANEL_PX * f64::from(panels)))
}

/// `|alpha/voltage| [rad/V]`
fn name(experiment: &Experiment, output: usize, input: usize) -> String {
    let part = |name: &str, unit: &str| name.strip_suffix(unit).map_or(name, |s| s.trim_end_matches('_')).to_string();
    let (y, u) = (&experiment.outputs, &experiment.inputs);
    let unit = |unit: &str| if unit == "v" { "V".to_string() } else { unit.to_string() };
    let per = match (y.units[output].as_str(), u.units[input].as_str()) {
        ("", "") => String::new(),
        (y, "") => format!(" [{}]", unit(y)),
        (y, u) => format!(" [{}/{}]", if y.is_empty() { "1".into() } else { unit(y) }, unit(u)),
    };
    let (numerator, denominator) = (part(&y.names[output], &y.units[output]), part(&u.names[input], &u.units[input]));
    format!("|{numerator}/{denominator}|{per}")
}

fn magnitude(label: &str, data: (&[f64], &[C64], &[f64]), model: (&[f64], &[C64])) -> Panel {
    let (hz, G, std) = data;
    let quantile = circular_quantile(LEVEL);
    let size: Vec<f64> = G.iter().map(|G| G.norm()).collect();
    let upper: Vec<f64> = size.iter().zip(std).map(|(g, s)| g + quantile * s).collect();
    let lower: Vec<f64> = size.iter().zip(std).map(|(g, s)| (g - quantile * s).max(LOWEST * g)).collect();
    let of_model: Vec<f64> = model.1.iter().map(|G| G.norm()).collect();
    Panel::new(label)
        .log_y()
        .share(1.3)
        .with(Series::band("95 % of the measurement", hz, &lower, &upper).colour(Colour::Sky))
        .with(Series::line("measured", hz, &size).colour(Colour::Grey).width(2.2))
        .with(Series::line("model", model.0, &of_model).colour(Colour::Blue))
}

fn phase(data: (&[f64], &[C64]), model: (&[f64], &[C64])) -> Panel {
    let of_model = unwrapped_deg(model.1);
    // On the model's branch: a measured phase has no jumps to be unwrapped by, only noise.
    let near = |(f, G): (&f64, &C64)| {
        let k = model.0.partition_point(|w| w < f).min(of_model.len() - 1);
        let degrees = G.arg().to_degrees();
        degrees - 360.0 * ((degrees - of_model[k]) / 360.0).round()
    };
    let of_data: Vec<f64> = data.0.iter().zip(data.1).map(near).collect();
    Panel::new("Phase [deg]")
        .y_scale(Scale::Degrees)
        .with(Series::markers("measured", data.0, &of_data, Marker::Circle).colour(Colour::Grey).width(0.8))
        .with(Series::line("model", model.0, &of_model).colour(Colour::Blue))
}

/// Coherence of each output; of averaged periods what is answer, noise and distortion of the first output.
fn worth(experiment: &Experiment, evidence: &Evidence, hz: &[f64]) -> Panel {
    match evidence {
        Evidence::Pieces(measured) => {
            let coherence = measured.coherence.as_deref().unwrap_or(&[]);
            (0..experiment.outputs.channels()).fold(Panel::new("Coherence").y_range(0.0, 1.05), |panel, p| {
                let of_output: Vec<f64> = coherence.iter().map(|at| at[p]).collect();
                let dash = if p % 2 == 0 { Dash::Solid } else { Dash::Dashed };
                let name = format!("coherence of {}", experiment.outputs.names[p]);
                panel.with(Series::line(&name, hz, &of_output).dash(dash))
            })
        }
        Evidence::Periods(found) => levels(experiment, found, hz),
    }
}

/// Levels of the last output: the angle that does not integrate stands last.
fn levels(experiment: &Experiment, found: &Averaged, hz: &[f64]) -> Panel {
    let p = experiment.outputs.channels() - 1;
    let (name, unit) = (&experiment.outputs.names[p], &experiment.outputs.units[p]);
    let of = |each: &[Vec<f64>]| each.iter().map(|at| at[p]).collect::<Vec<f64>>();
    let quantity = name.strip_suffix(unit.as_str()).map_or(name.as_str(), |s| s.trim_end_matches('_'));
    let mut panel = Panel::new(&format!("{quantity}, amplitude [{unit}]"))
        .log_y()
        .share(1.3)
        .with(Series::line("answer", hz, &of(&found.answer)).colour(Colour::Ink))
        .with(Series::line("noise of the mean", hz, &of(&found.noise)).colour(Colour::Green).dash(Dash::Dotted));
    for (name, detection, colour, marker) in [
        ("odd harmonics not sent", &found.odd, Colour::Vermilion, Marker::Cross),
        ("even harmonics", &found.even, Colour::Amber, Marker::Plus),
    ] {
        let hz: Vec<f64> = detection.omega_rad_s.iter().map(|w| w / TAU).collect();
        if !hz.is_empty() {
            panel = panel.with(Series::markers(name, &hz, &of(&detection.amplitude), marker).colour(colour).width(0.8));
        }
    }
    panel
}
