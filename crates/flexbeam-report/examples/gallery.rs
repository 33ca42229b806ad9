//! One picture of every kind that flexbeam prints, from made-up data: `cargo run --example gallery -- DIR`.

use flexbeam_report::{Cell, Check, Colour, Dash, Figure, Marker, Panel, Report, Scale, Series, Table, Verdict};
use std::f64::consts::PI;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "gallery".into());
    std::fs::create_dir_all(&folder)?;
    let figures = [
        ("voltage", voltage()),
        ("record", record()),
        ("tip_angle", tip_angle()),
        ("control", control()),
        ("singular_values", singular_values()),
        ("bode", bode()),
        ("radius", radius()),
        ("poles", poles()),
        ("extremes", extremes()),
    ];
    for (name, figure) in figures {
        std::fs::write(format!("{folder}/{name}.svg"), figure.svg())?;
        std::fs::write(format!("{folder}/{name}.png"), figure.png(2.0)?)?;
    }
    println!("{}", entries().text());
    std::fs::write(format!("{folder}/report.html"), report().html("flexbeam 0.1.0 · seed 1 · 22 November 2026"))?;
    Ok(())
}

fn grid(from: f64, to: f64, count: usize) -> Vec<f64> {
    (0..count).map(|k| from + (to - from) * k as f64 / (count - 1) as f64).collect()
}

fn decades(from: f64, to: f64, count: usize) -> Vec<f64> {
    grid(from.log10(), to.log10(), count).into_iter().map(|e| 10f64.powf(e)).collect()
}

fn of(x: &[f64], f: impl Fn(f64) -> f64) -> Vec<f64> {
    x.iter().map(|x| f(*x)).collect()
}

/// White Gaussian noise, near enough for a picture: sums of a congruential generator.
fn noise(count: usize, deviation: f64) -> Vec<f64> {
    let mut state = 1u64;
    let mut uniform = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..count).map(|_| deviation * ((0..12).map(|_| uniform()).sum::<f64>() - 6.0)).collect()
}

// ANCHOR: time_series
fn voltage() -> Figure {
    let t = grid(0.0, 10.0, 10_000);
    Figure::new("Fig. 5  Excitation: white Gaussian voltage", "Time [s]")
        .panel(Panel::new("Motor voltage V [V]").with(Series::step("voltage", &t, &noise(10_000, 1.5)).width(0.8)))
}
// ANCHOR_END: time_series

fn record() -> Figure {
    let t = grid(0.0, 10.0, 100_000);
    let mut theta: Vec<f64> = noise(100_000, 0.004);
    (1..theta.len()).for_each(|k| theta[k] += theta[k - 1]);
    let theta = of(&theta, |v| 20.0 * v);
    let alpha = of(&t, |t| 2.0 * (20.1 * t).sin() * (0.7 * t).sin() + 0.3 * (130.0 * t).sin());
    let psi: Vec<f64> = theta.iter().zip(&alpha).map(|(a, b)| a + b).collect();
    Figure::new("Fig. 6  What the rig answers", "Time [s]")
        .size(800.0, 560.0)
        .panel(Panel::new("Motor voltage V [V]").with(Series::line("voltage", &t, &noise(100_000, 1.5)).width(0.8)))
        .panel(Panel::new("Deflection α [deg]").with(Series::line("deflection α", &t, &alpha).width(1.0)))
        .panel(
            Panel::new("Angles [deg]")
                .with(Series::line("hub θ", &t, &theta).width(1.2))
                .with(Series::line("tip ψ = θ + α", &t, &psi).width(1.0)),
        )
}

// ANCHOR: tip_angle
fn tip_angle() -> Figure {
    let t = grid(0.0, 2.0, 2000);
    let step = |rate: f64, end: f64, ring: f64| {
        of(&t, |t| {
            end * (1.0 - (-rate * t).exp() * (1.0 + rate * t)) + ring * (12.0 * t).sin() * (-0.4 * t).exp() * t.min(0.3)
        })
    };
    let limit_cycle = of(&t, |t| if t > 0.6 { 1.2 * (9.0 * (t - 0.6)).sin() } else { 0.0 });
    let switched: Vec<f64> = step(14.0, 30.2, 0.0).iter().zip(&limit_cycle).map(|(a, b)| a + b).collect();
    Figure::new("Fig. 9  Tip angle after a step of 30°", "Time [s]").panel(
        Panel::new("Tip angle ψ [deg]")
            .horizontal(30.0, "reference")
            .with(Series::line("linear ideal", &t, &step(15.0, 30.0, 0.0)).colour(Colour::Grey).dash(Dash::Dashed))
            .line("no law", &t, &step(9.0, 24.0, 1.0))
            .line("switched law", &t, &switched)
            .line("inverse law", &t, &step(13.0, 29.8, 0.4)),
    )
}
// ANCHOR_END: tip_angle

fn control() -> Figure {
    let t = grid(0.0, 2.0, 2000);
    let u = of(&t, |t| 9.2 * (-8.0 * t).exp() * (22.0 * t).cos() + 0.08 * (60.0 * t).sin() * (-t).exp());
    Figure::new("Fig. 10  Control input before the variable structure", "Time [s]").panel(
        Panel::new("u(t) [V]")
            .with(Series::step("u", &t, &u))
            .y_range(-10.5, 11.5)
            .horizontal(10.0, "amplifier limit +10 V")
            .horizontal(-10.0, "amplifier limit −10 V")
            .shade(0.0, 0.4, "moving")
            .note(0.0, 9.2, "first sample 9.2 V"),
    )
}

// ANCHOR: singular_values
fn singular_values() -> Figure {
    let k = grid(1.0, 20.0, 20);
    let sigma = of(&k, |k| if k < 4.5 { 300.0 * (-0.9 * k).exp() } else { 3e-4 * (1.0 + 2.0 / k) });
    Figure::new("Order from the singular values", "Index").x_scale(Scale::Integer).panel(
        Panel::new("Singular value σₖ")
            .log_y()
            .with(Series::stem("kept", &k[..4], &sigma[..4]))
            .with(Series::stem("left out", &k[4..], &sigma[4..]).marker(Marker::Circle).colour(Colour::Grey))
            .vertical(4.5, "chosen order n = 4"),
    )
}
// ANCHOR_END: singular_values

// ANCHOR: bode
fn bode() -> Figure {
    let w = decades(0.1, 1000.0, 800);
    let mode = |w: f64, w0: f64, z: f64| {
        let (re, im) = (1.0 - (w / w0).powi(2), 2.0 * z * w / w0);
        (-20.0 * re.hypot(im).log10(), -im.atan2(re) * 180.0 / PI)
    };
    let gain = |w: f64| 20.0 * (1.86 / w).log10() + mode(w, 25.9, 0.44).0 - 10.0 * (1.0 + (w / 34.9).powi(2)).log10();
    let phase = |w: f64| -90.0 + mode(w, 25.9, 0.44).1 - (w / 34.9).atan() * 180.0 / PI;
    let beam = |w: f64| gain(w) + mode(w, 129.5, 0.018).0 - mode(w, 115.0, 0.01).0;
    let beam_phase = |w: f64| phase(w) + mode(w, 129.5, 0.018).1 - mode(w, 115.0, 0.01).1;
    let bound = |w: f64| -9.0 + 10.0 * (1.0 + (w / 20.0).powi(2)).log10() - 10.0 * (1.0 + (w / 400.0).powi(2)).log10();
    let (g0, a) = (of(&w, gain), of(&w, bound));
    let lower: Vec<f64> = of(&w, |w| gain(w) - 2.0 - 3.0 * w.log10().max(0.0));
    let upper: Vec<f64> = of(&w, |w| gain(w) + 2.0 + 3.0 * w.log10().max(0.0));
    Figure::new("Identified model, nominal model and distributed beam", "Angular frequency ω [rad/s]")
        .log_x()
        .size(800.0, 600.0)
        .panel(
            Panel::new("Magnitude [dB]")
                .y_scale(Scale::Decibels)
                .share(1.6)
                .with(Series::band("|G₀| ± |α|", &w, &lower, &upper).colour(Colour::Grey))
                .line("G₀ (18)", &w, &g0)
                .with(Series::line("identified", &w, &of(&w, |w| gain(w) + 0.3)).dash(Dash::Dashed))
                .with(Series::line("distributed beam", &w, &of(&w, beam)).width(1.2))
                .with(Series::line("bound α(s)", &w, &a).dash(Dash::DashDot)),
        )
        .panel(
            Panel::new("Phase [deg]")
                .y_scale(Scale::Degrees)
                .line("G₀ (18)", &w, &of(&w, phase))
                .with(Series::line("identified", &w, &of(&w, |w| phase(w) - 2.0)).dash(Dash::Dashed))
                .with(Series::line("distributed beam", &w, &of(&w, beam_phase)).width(1.2)),
        )
}
// ANCHOR_END: bode

// ANCHOR: radius
fn radius() -> Figure {
    let beta = grid(0.2, 14.0, 600);
    let radius = of(&beta, |b| 0.93 / b * (1.0 - (b / 17.0).powi(2)));
    let needed = of(&beta, |b| 0.05 + 0.04 / (2.018 - b).abs().max(1e-3));
    Figure::new("Robust radius against stability degree", "Stability degree β [1/s]").panel(
        Panel::new("Radius [rad/V]")
            .log_y()
            .y_range(0.02, 8.0)
            .line("robust radius", &beta, &radius)
            .with(Series::line("needed against the beam", &beta, &needed))
            .vertical(1.5, "chosen β = 1.5")
            .vertical(2.018, "mode 3 (354 rad/s)")
            .vertical(2.3, "mode 2 (130 rad/s)")
            .vertical(10.85, "mode 1 (23 rad/s)")
            .shade(2.018, 14.0, "not reachable with the beam"),
    )
}
// ANCHOR_END: radius

// ANCHOR: poles
fn poles() -> Figure {
    let pole = |re: &[f64], im: &[f64], name: &str, marker| Series::markers(name, re, im, marker);
    Figure::new("Closed-loop poles", "Real part [1/s]").size(640.0, 480.0).equal_aspect().panel(
        Panel::new("Imaginary part [rad/s]")
            .with(pole(
                &[-12.586, -12.586, -12.682, -12.682, -24.0, -34.87],
                &[23.21, -23.21, 23.23, -23.23, 0.0, 0.0],
                "closed loop",
                Marker::Cross,
            ))
            .with(pole(&[0.0, -34.872, -11.41, -11.41], &[0.0, 0.0, 23.2, -23.2], "plant", Marker::Plus))
            .with(pole(&[65.4], &[0.0], "zero of the beam", Marker::Circle))
            .vertical(-12.0, "−β = −12"),
    )
}
// ANCHOR_END: poles

/// Everything that goes wrong with data: gaps, a lone point, tiny numbers, a constant, nothing at all.
fn extremes() -> Figure {
    let t = grid(0.0, 3e-6, 300);
    let gaps = of(&t, |t| if (1e-6..1.5e-6).contains(&t) { f64::NAN } else { 4e-7 * (t * 6e6).sin() });
    Figure::new("Gaps, tiny numbers, a constant, nothing & <markup>", "Time [s]")
        .size(640.0, 480.0)
        .panel(Panel::new("Gap [m]").line("gap", &t, &gaps).markers("lone", &[1.25e-6], &[1e-7], Marker::Disc))
        .panel(Panel::new("Constant [V]").line("constant", &t, &of(&t, |_| 12345.678)))
        .panel(Panel::new("A label much too long for its panel [unit]").line("none", &[], &[]))
}

// ANCHOR: table
fn entries() -> Table {
    let mut table = Table::new(&[
        ("entry", ""),
        ("printed (18)", "1/s²"),
        ("identified", "1/s²"),
        ("relative error", ""),
        ("", ""),
    ]);
    for (name, printed, found) in
        [("k1", 1060.8, 1060.80001), ("k2", 1465.2, 1465.1993), ("c", 57.7, 57.6), ("b", 107.39, 107.39)]
    {
        let error: f64 = found / printed - 1.0;
        let verdict = Verdict::from(error.abs() < 1e-4);
        table.push([
            name.into(),
            Cell::number(printed, 5),
            Cell::number(found, 9),
            Cell::number(error, 2),
            verdict.into(),
        ]);
    }
    table
}
// ANCHOR_END: table

// ANCHOR: report
fn report() -> Report {
    let mut report = Report::new(
        "A flexible beam, from recording to controller",
        "What flexbeam reproduce found, with every figure.",
    );
    report.section("Identification");
    report.paragraph(
        "The rig was excited by a white Gaussian voltage for 10 s at 1 kHz. Order 4 follows from σ₅ < 10⁻³ σ₄.",
    );
    report.figure(&voltage(), "The motor voltage, standard deviation 1.5 V.");
    report.table("Entries of A and B beside the paper's print.", &entries());
    report.section("Design");
    report.formula("|ΔG(jω − β)| < |α(jω)| for all ω");
    report.figure(&bode(), "Identified model, nominal model G₀ and the distributed beam.");
    let check = |name: &str, symbol: &str, value: &str, unit: &str, required: &str, met: bool| Check {
        name: name.into(),
        symbol: symbol.into(),
        value: value.into(),
        unit: unit.into(),
        required: required.into(),
        verdict: met.into(),
    };
    let checks = [
        check("Stability degree", "β", "1.531", "1/s", "≥ 1.5", true),
        check("Bound norm, sampled", "‖S_w‖", "0.8456", "", "≤ 1", true),
        check("Stationary error", "v_res/K(0)", "0.162", "deg", "≤ 0.15", false),
    ];
    report.certificate("Certificate of the controller.", &checks);
    report.facts("Provenance.", &[("recording", "record.csv, sha256 12ab…"), ("model", "model.toml")]);
    report
}
// ANCHOR_END: report
