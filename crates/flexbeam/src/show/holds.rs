//! What each kind of file holds, in words and tables.

use flexbeam_files::{
    Certificate, ColumnSummary, Controller, LoopFigures, Model, Note, RecordingSummary, Refinement, Rig,
};
use flexbeam_kernel as kernel;
use flexbeam_lti::StateSpace;
use flexbeam_report::{Cell, Table, engineering, significant};
use flexbeam_rig::{Damping, GaugeSees, Link, RigParameters};

use crate::controller_file::kernel_settings;
use crate::identify::physical_table;
use crate::poles;

/// Digits of a figure that a person compares.
pub(super) const DIGITS: usize = 5;

/// Names and what stands behind them; nothing for what a file does not say.
pub(super) fn facts<'a>(rows: impl IntoIterator<Item = (&'a str, Option<String>)>) -> String {
    let known: Vec<_> = rows.into_iter().filter_map(|(name, value)| Some((name, value?))).collect();
    let width = known.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    known.iter().map(|(name, value)| format!("{name:width$}  {value}\n")).collect()
}

fn number(x: f64, unit: &str) -> Option<String> {
    Some(format!("{} {unit}", significant(x, DIGITS)).trim_end().to_string())
}

fn degrees(x_rad: f64) -> Option<String> {
    number(x_rad.to_degrees(), "degree")
}

fn coefficients(c: &[f64]) -> String {
    let powers = c.iter().map(|c| significant(*c, DIGITS));
    powers.collect::<Vec<_>>().join(", ")
}

fn function(num: &[f64], den: &[f64]) -> Option<String> {
    Some(format!("[{}] / [{}], highest power first", coefficients(num), coefficients(den)))
}

fn refined(refinement: &Refinement) -> String {
    let Refinement { errors, iterations, missed_after, .. } = refinement;
    format!("{errors} errors, {iterations} steps, {:.4} % of the outputs missed", 100.0 * missed_after)
}

/// Order, period, signals, poles, fits, physical parameters.
pub(super) fn model(model: &Model, system: &StateSpace) -> String {
    let found = model.identification.as_ref();
    let time = match (model.period_s, &model.continuous) {
        (Some(period_s), Some(_)) => format!("sampled every {}, and continuous", engineering(period_s, 4, "s")),
        (Some(period_s), None) => format!("sampled every {}, no continuous form", engineering(period_s, 4, "s")),
        (None, _) => "continuous".into(),
    };
    let mut text = facts([
        ("order", Some(system.order().to_string())),
        ("time", Some(time)),
        ("inputs", Some(model.inputs.join(", "))),
        ("outputs", Some(model.outputs.join(", "))),
        ("identified by", found.map(|i| format!("{}, {} block rows", i.method, i.block_rows))),
        ("refined by", found.and_then(|i| i.refinement.as_ref()).map(refined)),
        ("estimated from", found.and_then(|i| i.samples).map(|samples| format!("{samples} samples"))),
        ("uncertainty", model.uncertainty.as_ref().and_then(|u| function(&u.num, &u.den))),
        ("at stability degree", model.uncertainty.as_ref().and_then(|u| number(u.beta, "1/s"))),
    ]);
    text += &format!("\n{}", poles::table(system).text());
    if let Some(validation) = &model.validation {
        let rows =
            validation.fit_percent.iter().map(|(name, fit)| [name.as_str().into(), Cell::Number(format!("{fit:.2}"))]);
        let table = rows.fold(Table::new(&[("output", ""), ("fit on unseen samples", "%")]), Table::row);
        text += &format!("\n{}", table.text());
    }
    if let Some(physical) = &model.physical {
        text += &format!("\n{}", physical_table(physical).text());
    }
    text
}

/// What was asked, what was proven, what may change while it runs.
pub(super) fn controller(controller: &Controller) -> String {
    let design = &controller.design;
    let mut text = facts([
        ("order", Some(controller.order.to_string())),
        ("period", Some(engineering(controller.period_s, 4, "s"))),
        ("controls", Some(design.output.clone())),
        ("stability degree asked", number(design.stability_degree, "1/s")),
        ("stiffness asked", Some(design.stiffness.to_string())),
        ("uncertainty", function(&design.uncertainty_num, &design.uncertainty_den)),
        ("reference model", function(&design.reference_num, &design.reference_den)),
        ("its rise time", design.rise_time_s.map(|t| engineering(t, 4, "s"))),
        ("delay taken into account", Some(engineering(design.delay_s, 4, "s"))),
    ]);
    text += &format!("\n{}", certificate(&controller.certificate));
    text += &format!("\nsettings\n{}", settings(&kernel_settings(&controller.settings, None)));
    text
}

/// The figures of the sampled loop beside those of the continuous one.
pub(super) fn certificate(certificate: &Certificate) -> String {
    let Certificate { continuous, sampled, .. } = certificate;
    type Figure = fn(&LoopFigures) -> f64;
    let rows: [(&str, &str, Figure); 8] = [
        ("robust radius", "", |f| f.robust_radius.0),
        ("bound norm (22)", "", |f| f.bound_norm),
        ("stability degree", "1/s", |f| f.stability_degree),
        ("stiffness K(0)", "V/rad", |f| f.stiffness.0),
        ("gain margin", "", |f| f.gain_margin.0),
        ("phase margin", "degree", |f| f.phase_margin_rad.0.to_degrees()),
        ("delay margin", "s", |f| f.delay_margin_s.0),
        ("disk margin", "", |f| f.disk_margin.0),
    ];
    let columns = [("certificate", ""), ("sampled", ""), ("continuous", ""), ("unit", "")];
    let table = rows.into_iter().fold(Table::new(&columns), |table, (name, unit, figure)| {
        let cell = |figures| Cell::number(figure(figures), DIGITS);
        table.row([name.into(), cell(sampled), cell(continuous), unit.into()])
    });
    let rest = facts([
        ("residual voltage v_res", certificate.v_res_v.and_then(|v| number(v, "V"))),
        ("v_res/K(0)", certificate.stationary_error_rad.and_then(degrees)),
        ("prefilter's own degree", certificate.prefilter_degree.and_then(|d| number(d, "1/s"))),
    ]);
    format!("{}\n{rest}", table.text())
}

/// As they act: with the kernel's defaults where the file says nothing.
fn settings(settings: &kernel::Settings) -> String {
    let volts = |x: f64| number(x, "V");
    let angle = |x: f64| if x.is_finite() { degrees(x) } else { Some("none".into()) };
    facts([
        ("law", Some(format!("{:?}", settings.law).to_lowercase())),
        ("u_p forward", volts(settings.u_p_plus_v)),
        ("u_p backward", volts(settings.u_p_minus_v)),
        ("eps_u", volts(settings.eps_u_v)),
        ("eps_e", angle(settings.eps_e_rad)),
        ("hysteresis of switch 2", number(settings.hysteresis_u, "")),
        ("hysteresis of switch 1", number(settings.hysteresis_e, "")),
        ("breakaway forward", volts(settings.breakaway_plus_v)),
        ("breakaway backward", volts(settings.breakaway_minus_v)),
        ("voltage limit", volts(settings.voltage_limit_v)),
        ("deflection limit", angle(settings.deflection_limit_rad)),
        ("hub's limit", angle(settings.theta_limit_rad)),
        ("hub's limit in a tick", angle(settings.theta_step_limit_rad)),
        ("smooth step", number(settings.smooth_ticks, "ticks")),
        ("longer for steps above", angle(settings.smooth_step_rad)),
        ("low-pass share, theta", number(settings.theta.low_pass, "")),
        ("low-pass share, alpha", number(settings.alpha.low_pass, "")),
    ])
}

/// The rig with what the file leaves out filled in.
pub(super) fn rig(rig: &Rig, found: &RigParameters) -> String {
    let physical = &found.physical;
    let lumped = physical.lumped();
    let (link, damping, tip) = match found.link {
        Link::Lumped => ("lumped: a torsion spring".to_string(), None, None),
        Link::Modes { count, damping, tip_mass_kg } => {
            let damping = match damping {
                Damping::Modal { zeta } => format!("ratio {zeta} in every mode"),
                Damping::KelvinVoigt { eta_s } => format!("Kelvin-Voigt, {}", engineering(eta_s, 4, "s")),
            };
            (format!("{count} modes of the distributed beam"), Some(damping), number(tip_mass_kg, "kg"))
        }
    };
    let steps = |step: Option<f64>, unit| step.map_or(Some("exact".into()), |step| number(step, unit));
    let (actuator, gauge) = (&found.actuator, &found.sensors.gauge);
    facts([
        ("name", rig.name.clone()),
        ("period", Some(engineering(found.period_s, 4, "s"))),
        ("computing delay", Some(format!("{} × the period", found.computing_delay_periods))),
        ("J_base", number(physical.J_base, "kg m²")),
        ("J_link", number(physical.J_link, "kg m²")),
        ("K_stiff", number(physical.K_stiff, "N m/rad")),
        ("K_b = K_T", number(physical.K_b, "V s/rad")),
        ("K_g", number(physical.K_g, "")),
        ("R", number(physical.R_ohm, "ohm")),
        ("B_eq", number(physical.B_eq, "N m s/rad")),
        ("length", number(physical.length_m, "m")),
        ("k1", number(lumped.k1, "1/s²")),
        ("k2", number(lumped.k2, "1/s²")),
        ("c", number(lumped.c, "1/s")),
        ("b", number(lumped.b, "rad/s²/V")),
        ("link", Some(link)),
        ("damping", damping),
        ("mass at the tip", tip),
        ("voltage converter", steps(actuator.converter_step_v, "V")),
        ("voltage limit", number(actuator.limit_v, "V")),
        ("dead zone", Some(format!("{:+} V, {:+} V", actuator.dead_zone_plus_v, -actuator.dead_zone_minus_v))),
        ("Coulomb torque", number(found.friction.coulomb_nm, "N m")),
        ("Stribeck torque", found.friction.stribeck.and_then(|s| number(s.extra_nm, "N m"))),
        (
            "encoder",
            Some(found.sensors.encoder.counts_per_turn.map_or("exact".into(), |n| format!("{n} counts a turn"))),
        ),
        (
            "gauge sees",
            Some(match gauge.sees {
                GaugeSees::TipAngle => "the tip's deflection angle".into(),
                GaugeSees::RootStrain => "the strain at the root".into(),
            }),
        ),
        ("gauge noise", degrees(gauge.noise_rad)),
        ("gauge bias", degrees(gauge.bias_rad)),
        ("gauge converter", gauge.converter_step_rad.map_or(Some("exact".into()), degrees)),
    ])
}

/// What stands in the note beside a recording.
pub(super) fn note(note: &Note) -> String {
    facts([
        ("note about the recording", Some(format!("sha256 {}", note.sha256))),
        ("samples", Some(length(note.samples, note.period_s))),
        ("columns", Some(note.columns.join(", "))),
    ])
}

/// Length and columns.
pub(super) fn recording(recording: &RecordingSummary) -> String {
    format!("{}\n\n{}", length(recording.samples, recording.period_s), columns(&recording.columns))
}

/// A column a row.
pub(super) fn columns(columns: &[ColumnSummary]) -> String {
    let heads = [("column", ""), ("smallest", ""), ("largest", ""), ("mean", ""), ("standard deviation", "")];
    let table = columns.iter().fold(Table::new(&heads), |table, column| {
        let ColumnSummary { name, min, max, mean, std } = column;
        let cell = |x: f64| Cell::number(x, DIGITS);
        table.row([name.as_str().into(), cell(*min), cell(*max), cell(*mean), cell(*std)])
    });
    table.text()
}

pub(super) fn length(samples: usize, period_s: f64) -> String {
    let length_s = samples as f64 * period_s;
    format!("{samples} samples every {}, {} s", engineering(period_s, 4, "s"), significant(length_s, 4))
}
