//! The pictures of the report: data of the findings into the report's plots.

use flexbeam_design::{Uncertainty, solvability};
use flexbeam_lti::{C64, StateSpace};
use flexbeam_report::{Colour, Dash, Figure, Marker, Panel, Scale, Series};
use flexbeam_rig::Lumped;

use super::{BETA, Findings};
use crate::Failure;
use crate::identify::pictures::singular_values;
use crate::nominal::lumped_psi;
use crate::response::{REST_S, degrees, unwrapped_deg};

/// A figure with the name of its files.
pub type Picture = (&'static str, Figure);

/// All figures, in the order of the paper.
pub fn all(findings: &Findings) -> Result<Vec<Picture>, Failure> {
    Ok(vec![
        ("fig05_input", input(findings)),
        ("fig06_deflection", deflection(findings)),
        ("singular_values", singular_values(&findings.plant.identified, 20)),
        ("bode", bode(findings)?),
        ("uncertainty", uncertainty(findings)),
        ("radius", radius(findings)),
        ("poles", poles(findings)),
        ("fig09_tip_angle", tip_angle(findings)),
        ("fig09_close", tip_angle_close(findings)),
        ("fig10_control_input", control_input(findings)),
    ])
}

fn times(count: usize, period_s: f64) -> Vec<f64> {
    (0..count).map(|k| k as f64 * period_s).collect()
}

fn input(findings: &Findings) -> Figure {
    let recording = &findings.plant.recording;
    let t = times(recording.samples(), recording.period_s);
    let v: Vec<f64> = recording.data.row(0).iter().copied().collect();
    Figure::new("Fig. 5  Input data record: white Gaussian voltage", "Time [s]")
        .panel(Panel::new("Motor voltage V [V]").with(Series::step("voltage", &t, &v).width(0.7)))
}

fn deflection(findings: &Findings) -> Figure {
    let recording = &findings.plant.recording;
    let t = times(recording.samples(), recording.period_s);
    let row = |k: usize| degrees(&recording.data.row(k).iter().copied().collect::<Vec<f64>>());
    Figure::new("Fig. 6  Output data record", "Time [s]")
        .size(800.0, 520.0)
        .panel(Panel::new("Deflection α [deg]").with(Series::line("deflection α", &t, &row(2)).width(0.9)))
        .panel(Panel::new("Hub angle θ [deg]").with(Series::line("hub θ", &t, &row(1)).width(0.9)))
}

fn decades(from: f64, to: f64, count: usize) -> Vec<f64> {
    (0..count).map(|k| from * (to / from).powf(k as f64 / (count - 1) as f64)).collect()
}

/// Frequencies of a curve with sharp resonances: a fine grid, and the resonances themselves.
fn frequencies(findings: &Findings, from: f64, to: f64) -> Vec<f64> {
    let mut omega = decades(from, to, 1500);
    for mode in findings.beam.modes(6).iter().filter(|mode| mode.im < to) {
        omega.extend((-20..=20).map(|k| mode.im + f64::from(k) * 0.2 * -mode.re));
    }
    omega.retain(|w| (from..=to).contains(w));
    omega.sort_by(f64::total_cmp);
    omega
}

fn bode(findings: &Findings) -> Result<Figure, Failure> {
    let omega = frequencies(findings, 0.1, 1000.0);
    let curve = |G: &StateSpace, rows: &[usize]| -> Vec<C64> {
        omega.iter().map(|w| rows.iter().map(|row| G.at(C64::new(0.0, *w))[(*row, 0)]).sum()).collect()
    };
    let printed = curve(&lumped_psi(&Lumped::PAPER)?, &[0]);
    let beam: Vec<C64> = omega.iter().map(|w| findings.beam.at(C64::new(0.0, *w)).psi()).collect();
    let mut magnitude = Panel::new("|ψ/V| [dB re 1 rad/V]").y_scale(Scale::Decibels).share(1.6).y_range(-140.0, 40.0);
    let mut phase = Panel::new("Phase [deg]").y_scale(Scale::Degrees);
    let mut add = |name: &str, G: &[C64], style: fn(Series) -> Series| {
        let db: Vec<f64> = G.iter().map(|g| 20.0 * g.norm().log10()).collect();
        magnitude = magnitude.clone().with(style(Series::line(name, &omega, &db)));
        phase = phase.clone().with(style(Series::line(name, &omega, &unwrapped_deg(G))));
    };
    add("distributed beam", &beam, |s| s.width(1.2));
    if let Some(G) = &findings.plant.modes_identified {
        add("identified, three modes", &curve(G, &[0, 1]), |s| s.dash(Dash::Dotted));
    }
    if let Ok(G) = &findings.plant.identified.continuous {
        add("identified, 1 % noise", &curve(G, &[0, 1]), |s| s.width(3.0).colour(Colour::Grey));
    }
    add("G₀, nominal", &curve(&findings.nominal, &[0]), |s| s);
    add("(18) as printed", &printed, |s| s.dash(Dash::Dashed));
    let alpha: Vec<f64> =
        omega.iter().map(|w| 20.0 * findings.specification.uncertainty.magnitude(*w).log10()).collect();
    let magnitude = magnitude.with(Series::line("bound |α(jω)|", &omega, &alpha).dash(Dash::DashDot));
    Ok(Figure::new("Voltage to tip angle, on s = jω", "Angular frequency ω [rad/s]")
        .log_x()
        .size(800.0, 640.0)
        .panel(magnitude)
        .panel(phase))
}

fn uncertainty(findings: &Findings) -> Figure {
    let omega = frequencies(findings, 0.1, 3000.0);
    let s = |w: f64| C64::new(-BETA, w);
    let difference: Vec<f64> =
        omega.iter().map(|w| (findings.beam.at(s(*w)).psi() - findings.nominal.at(s(*w))[(0, 0)]).norm()).collect();
    let alpha: Vec<f64> = omega.iter().map(|w| findings.specification.uncertainty.magnitude(*w)).collect();
    let nominal: Vec<f64> = omega.iter().map(|w| findings.nominal.at(s(*w))[(0, 0)].norm()).collect();
    let floor = vec![1e-6; omega.len()];
    Figure::new(&format!("What the bound covers, on s = jω − β with β = {BETA} 1/s"), "Angular frequency ω [rad/s]")
        .log_x()
        .panel(
            Panel::new("Gain [rad/V]")
                .log_y()
                .y_range(1e-6, 3.0)
                .with(Series::band("allowed difference", &omega, &floor, &alpha).colour(Colour::Grey))
                .with(Series::line("|ΔG|, beam less G₀", &omega, &difference).width(1.2))
                .with(Series::line("bound |α(jω)|", &omega, &alpha).dash(Dash::DashDot))
                .with(Series::line("|G₀|", &omega, &nominal).dash(Dash::Dashed)),
        )
}

/// The radius against beta for alpha = 1, with the damping of each mode: a neglected one ends the road.
fn radius(findings: &Findings) -> Figure {
    let one = Uncertainty::constant(1.0).ok();
    let beta: Vec<f64> = (1..=320).map(|k| 0.05 * f64::from(k)).collect();
    let radius: Vec<f64> = beta
        .iter()
        .map(|beta| {
            let answer = one.as_ref().and_then(|alpha| solvability(&findings.nominal, *beta, alpha).ok());
            answer.and_then(|answer| answer.robust_radius).unwrap_or(f64::NAN)
        })
        .collect();
    let modes = findings.beam.modes(6);
    let least = modes[1..].iter().map(|mode| -mode.re).fold(f64::INFINITY, f64::min);
    let mut panel = Panel::new("Robust radius [rad/V]")
        .log_y()
        .shade(least, 16.0, "not reachable on the beam")
        .line("radius for α(s) = 1", &beta, &radius)
        .with(Series::markers("this design", &[BETA], &[radius_at(&beta, &radius)], Marker::Circle));
    for (k, mode) in modes.iter().enumerate() {
        panel = panel.vertical(-mode.re, &format!("mode {}, {:.0} rad/s", k + 1, mode.im));
    }
    Figure::new("Robust radius against stability degree, and the damping of each mode", "Stability degree β [1/s]")
        .x_range(0.0, 16.0)
        .panel(panel)
}

fn radius_at(beta: &[f64], radius: &[f64]) -> f64 {
    beta.iter().zip(radius).find(|(b, _)| (**b - BETA).abs() < 1e-9).map_or(f64::NAN, |(_, r)| *r)
}

fn poles(findings: &Findings) -> Figure {
    let split = |poles: &[C64]| -> (Vec<f64>, Vec<f64>) { poles.iter().map(|p| (p.re, p.im)).unzip() };
    let (re, im) = split(&findings.design.continuous.poles);
    let (plant_re, plant_im) = split(&findings.nominal.poles());
    Figure::new("Poles of plant and closed loop", "Real part [1/s]").size(760.0, 440.0).panel(
        Panel::new("Imaginary part [rad/s]")
            .markers("closed loop", &re, &im, Marker::Cross)
            .markers("plant", &plant_re, &plant_im, Marker::Circle)
            .vertical(-BETA, "−β"),
    )
}

/// Time from the step on, and as much of a column.
fn from_step(values: &[f64], period_s: f64, until_s: f64) -> (Vec<f64>, Vec<f64>) {
    let (start, count) = ((REST_S / period_s).round() as usize, (until_s / period_s).round() as usize);
    let shown: Vec<f64> = values.iter().copied().skip(start).take(count).collect();
    (times(shown.len(), period_s), shown)
}

/// Seconds of the step that the figures show.
const SHOWN_S: f64 = 3.0;

fn tip_panel(findings: &Findings) -> Panel {
    let laws = &findings.laws;
    let period_s = findings.rig.period_s;
    let (t, ideal) = from_step(&degrees(&laws.ideal.psi_rad), period_s, SHOWN_S);
    let mut panel = Panel::new("Tip angle ψ [deg]").horizontal(super::laws::STEP_DEG, "reference");
    for (law, record) in super::laws::LAWS.iter().zip(&laws.records) {
        let (t, psi) = from_step(&degrees(&record.psi_rad), period_s, SHOWN_S);
        panel = panel.line(crate::law::law_name(*law), &t, &psi);
    }
    panel.with(Series::line("linear ideal", &t, &ideal).colour(Colour::Grey).dash(Dash::Dashed))
}

fn tip_angle(findings: &Findings) -> Figure {
    Figure::new("Fig. 9  Tip angle after a step of 30°", "Time [s]").panel(tip_panel(findings))
}

fn tip_angle_close(findings: &Findings) -> Figure {
    Figure::new("Fig. 9, the last degrees", "Time [s]").panel(tip_panel(findings).y_range(25.0, 31.5))
}

fn control_input(findings: &Findings) -> Figure {
    let period_s = findings.rig.period_s;
    let record = findings.laws.records.last().expect("a record of each law");
    let (t, u) = from_step(&record.u_v, period_s, SHOWN_S);
    let (_, v) = from_step(&record.voltage_v, period_s, SHOWN_S);
    Figure::new("Fig. 10  Control input u(t) before the variable structure, and the motor voltage", "Time [s]")
        .size(800.0, 520.0)
        .panel(Panel::new("u(t) before the law [V]").with(Series::step("controller u", &t, &u)))
        .panel(Panel::new("Motor voltage [V]").with(Series::step("motor V", &t, &v).width(0.9)))
}
