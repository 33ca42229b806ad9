//! The report: what was done and found, for the screen, the printer and the terminal.

use flexbeam_files::{DirectionSummary, Physical};
use flexbeam_report::{Cell, Check, Report, Table, significant};
use flexbeam_verify::Verified;

use super::figures::Picture;
use super::{BETA, Findings, laws};
use crate::design::checks;
use crate::law::law_name;
use crate::verify::table as verified_table;

/// The self-contained page.
pub fn report(findings: &Findings, pictures: &[Picture]) -> String {
    let mut page = Report::new(
        "A flexible beam, from a recording to a robust controller",
        "The paper “Modelling and robust control of a flexible beam Quanser experiment” on the simulated rig, end to end.",
    );
    let figure = |page: &mut Report, name: &str, caption: &str| {
        if let Some((_, picture)) = pictures.iter().find(|(found, _)| *found == name) {
            page.figure(picture, caption);
        }
    };
    page.section("Identification");
    page.paragraph(
        "The linear rig is excited by a white Gaussian voltage; hub angle and deflection are recorded every millisecond, with 1 % of \
         noise on each. The order follows from the singular values of the weighted projection, the model from the shift structure \
         of the observability matrix.",
    );
    figure(&mut page, "fig05_input", "The voltage that excites the beam.");
    figure(
        &mut page,
        "fig06_deflection",
        "What the beam answers. From the deflection alone the integrator cannot be seen; with the hub angle it can.",
    );
    figure(&mut page, "singular_values", "The gap tells the order.");
    page.table("Plant (18) printed and recovered, with one standard error", &plant_table(findings));
    page.paragraph(
        "The last row comes from the nonlinear rig with three modes and friction. Its lumped parameters differ, because a lumped \
         beam that fits the distributed one best is not the one whose clamped frequency is right, and friction adds damping.",
    );
    page.section("Uncertainty");
    page.paragraph(&format!(
        "The nominal plant G₀ is the fit to the recording with noise. The distributed beam has more modes; their difference from \
         G₀ on the line s = jω − β is covered by a stable, minimum-phase bound α(s) = {}.",
        alpha_text(findings)
    ));
    figure(&mut page, "bode", "Identified models, nominal plant, distributed beam, and the bound.");
    figure(&mut page, "uncertainty", "The bound lies everywhere above the difference.");
    figure(
        &mut page,
        "radius",
        "The third mode, damped by 2.018 1/s, limits the stability degree that can be promised on the beam.",
    );
    page.section("Controller");
    page.certificate(
        "Certificate of the sampled loop: 1 kHz, one period of delay, measurement filter included",
        &checks(&findings.controller),
    );
    figure(&mut page, "poles", "The continuous loop: every pole lies left of −β.");
    let all: Vec<&Verified> = findings.verified.iter().chain(&findings.beam_figures).collect();
    page.table(
        "Each figure recomputed by other formulas, and counted on the exact distributed beam",
        &verified_table(&all),
    );
    page.section("On the nonlinear rig");
    page.paragraph(&format!(
        "A slow ramp finds where the hub breaks away: {} V forward and {} V backward. The thresholds of the variable structure follow \
         from it. Each law then takes {} steps of ±{}° with different sensor noise.",
        significant(findings.breakaway.plus_v, 3),
        significant(findings.breakaway.minus_v, 3),
        laws::SEEDS,
        laws::STEP_DEG
    ));
    figure(&mut page, "fig09_tip_angle", "Without a law the beam stops short; the inverse law brings it home.");
    figure(&mut page, "fig09_close", "The same, close to the target.");
    figure(
        &mut page,
        "fig10_control_input",
        "The controller's voltage before the variable structure, and what reaches the motor.",
    );
    page.table("Steps of 30° in both directions: median over the seeds, worst in brackets", &laws_table(findings));
    page.html(&format!("flexbeam {} · design with β = {BETA} 1/s", env!("CARGO_PKG_VERSION")))
}

/// What a person wants to read in the terminal.
pub fn terminal(findings: &Findings) -> String {
    let certificate = Check::table(&checks(&findings.controller)).text();
    let verdict = match findings.broken() {
        None => "every figure recomputed, stable on the exact distributed beam".to_string(),
        Some(what) => what,
    };
    format!(
        "{}\n{}\n{}\nverification: {verdict}\n",
        plant_table(findings).text(),
        certificate,
        laws_table(findings).text()
    )
}

fn alpha_text(findings: &Findings) -> String {
    let alpha = findings.specification.uncertainty.zpk();
    let factor = |roots: &[flexbeam_lti::C64]| match roots.first() {
        Some(root) => format!("(s + {})", significant(-root.re, 4)),
        None => "1".into(),
    };
    format!("{} {} / {} rad/V", significant(alpha.gain, 4), factor(&alpha.zeros), factor(&alpha.poles))
}

fn plant_table(findings: &Findings) -> Table {
    let plant = findings.plant.table();
    let columns = [("plant (18)", ""), ("k1", "1/s²"), ("k2", "1/s²"), ("c", "1/s"), ("b", "rad/s²/V")];
    let row = |table: Table, name: &str, p: &Physical, digits: usize| {
        let cell = |x: f64, std: Option<f64>| match std {
            Some(std) => Cell::from(format!("{} ± {}", significant(x, digits), significant(std, 2)).as_str()),
            None => Cell::from(significant(x, digits).as_str()),
        };
        let cells = [cell(p.k1, p.k1_std), cell(p.k2, p.k2_std), cell(p.c, p.c_std), cell(p.b, p.b_std)];
        table.row([Cell::from(name)].into_iter().chain(cells))
    };
    let table = row(Table::new(&columns), "as printed", &plant.printed, 5);
    let table = row(table, "recovered, no noise", &plant.noise_free, 12);
    let table = row(table, "recovered, 1 % noise", &plant.noisy, 6);
    row(table, "nonlinear rig, three modes", &plant.nonlinear, 4)
}

fn laws_table(findings: &Findings) -> Table {
    let columns = [
        ("law", ""),
        ("step", "deg"),
        ("stationary error", "deg"),
        ("settled (2 %)", "s"),
        ("residual vibration", "deg"),
        ("overshoot", "%"),
        ("limit cycles", "runs"),
    ];
    let summaries = findings.laws.summaries();
    laws::LAWS
        .map(law_name)
        .iter()
        .filter_map(|name| Some((*name, summaries.get(*name)?)))
        .fold(Table::new(&columns), |table, (name, law)| table.row(law_row(name, &law.up)).row(law_row("", &law.down)))
}

fn law_row(name: &str, d: &DirectionSummary) -> [Cell; 7] {
    let both = |median: f64, worst: f64| {
        Cell::from(format!("{} ({})", significant(median, 3), significant(worst, 3)).as_str())
    };
    let angle = |s: &flexbeam_files::Spread| both(s.median.to_degrees(), s.max.to_degrees());
    [
        name.into(),
        Cell::number(d.step_rad.to_degrees(), 3),
        angle(&d.stationary_error_rad),
        match &d.settling_time_s {
            Some(s) => both(s.median, s.max),
            None => Cell::from(format!("{} of {} never", d.unsettled, d.runs).as_str()),
        },
        angle(&d.residual_vibration_rad),
        both(d.overshoot_percent.median, d.overshoot_percent.max),
        Cell::from(format!("{} of {}", d.limit_cycles, d.runs).as_str()),
    ]
}
