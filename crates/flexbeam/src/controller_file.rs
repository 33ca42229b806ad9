//! A design as a controller file, and a controller file as what the kernel runs.

use flexbeam_design::{Design, LoopFigures, Specification, Stiffness, Uncertainty};
use flexbeam_files as files;
use flexbeam_files::{Certificate, Controller, Extended, Matrices, Provenance, pairs};
use flexbeam_kernel as kernel;
use flexbeam_lti::{Mat, Rational, StateSpace, Time, Zpk};
use flexbeam_runtime::{law_of_file, with_table};

use crate::Failure;

/// What the file says beside the design's own figures.
pub struct Particulars {
    /// Output that is controlled.
    pub output: String,
    /// The stiffness as it was asked for.
    pub stiffness: files::Stiffness,
    /// Residual voltage that `needed` stiffness answers [V].
    pub v_res_v: f64,
    /// Overshoot asked of the reference model [percent].
    pub overshoot_percent: Option<f64>,
    /// Voltage that the largest step may take [V].
    pub max_voltage_v: f64,
    /// The largest step [rad].
    pub max_step_rad: f64,
    /// Law, thresholds, smooth step, limits.
    pub settings: files::Settings,
}

/// The controller file of a design.
pub fn controller_file(
    design: &Design,
    specification: &Specification,
    nominal: &StateSpace,
    particulars: Particulars,
    provenance: Option<Provenance>,
) -> Result<Controller, Failure> {
    let K = &design.controller;
    let D = K.D.columns(0, 2).into_owned();
    let (uncertainty_num, uncertainty_den) = coefficients(specification.uncertainty.zpk())?;
    let (bound_num, bound_den) = coefficients(design.sampled_uncertainty.zpk())?;
    let (reference_num, reference_den) = coefficients(&design.prefilter.model.zpk)?;
    let stiffness = design.sampled.stiffness;
    Ok(Controller {
        period_s: specification.period_s,
        order: K.order(),
        A: (&K.A).into(),
        B: (&K.B).into(),
        C: (&K.C).into(),
        D: (&D).into(),
        settings: particulars.settings,
        design: files::Design {
            method: "sampled".into(),
            output: particulars.output,
            stability_degree: specification.stability_degree,
            uncertainty_num,
            uncertainty_den,
            sampled_uncertainty_num: bound_num,
            sampled_uncertainty_den: bound_den,
            stiffness: particulars.stiffness,
            reference_num,
            reference_den,
            rise_time_s: Some(design.prefilter.model.rise_time_s),
            overshoot_percent: particulars.overshoot_percent,
            max_voltage_v: Some(particulars.max_voltage_v),
            max_step_rad: Some(particulars.max_step_rad),
            delay_s: specification.delay_s,
            low_pass: specification.low_pass,
        },
        plant: Matrices::from(nominal),
        certificate: Certificate {
            controller_order: K.order(),
            v_res_v: Some(particulars.v_res_v),
            stationary_error_rad: Some(particulars.v_res_v / stiffness.abs()).filter(|error| error.is_finite()),
            prefilter_degree: Some(design.prefilter_degree).filter(|degree| degree.is_finite()),
            continuous: figures(&design.continuous, design.robust_radius),
            sampled: figures(&design.sampled, design.sampled_radius),
            provenance: None,
        },
        provenance,
    })
}

fn figures(found: &LoopFigures, robust_radius: Option<f64>) -> files::LoopFigures {
    files::LoopFigures {
        robust_radius: Extended(robust_radius.unwrap_or(f64::INFINITY)),
        bound_norm: found.bound_norm,
        stability_degree: found.stability_degree,
        closed_loop_poles: pairs(&found.poles),
        stiffness: Extended(found.stiffness),
        gain_margin: Extended(found.margins.gain),
        phase_margin_rad: Extended(found.margins.phase_rad),
        delay_margin_s: Extended(found.margins.delay_s),
        disk_margin: Extended(found.margins.disk),
    }
}

/// Numerator and denominator, highest power first.
fn coefficients(function: &Zpk) -> Result<(Vec<f64>, Vec<f64>), Failure> {
    let rational = function.rational().map_err(Failure::while_trying("write the controller"))?;
    Ok((rational.num, rational.den))
}

/// The stiffness that the design is asked for.
pub fn stiffness(asked: files::Stiffness, v_res_v: f64) -> Stiffness {
    match asked {
        files::Stiffness::Needed => Stiffness::needed(v_res_v, NEEDED_WITHIN_DEG.to_radians()),
        files::Stiffness::Optimal => Stiffness::Optimal,
        files::Stiffness::Integral => Stiffness::Integral,
        files::Stiffness::Value(k) => Stiffness::Exactly(k),
    }
}

/// Error that `needed` stiffness leaves behind the residual voltage [degree].
pub const NEEDED_WITHIN_DEG: f64 = 0.15;

/// alpha(s) from coefficients.
pub fn uncertainty(num: &[f64], den: &[f64]) -> Result<Uncertainty, Failure> {
    let reading = || "use the uncertainty alpha(s)".to_string();
    let alpha = Rational::new(num.to_vec(), den.to_vec()).map_err(Failure::while_trying(reading()))?;
    Uncertainty::rational(&alpha).map_err(Failure::while_trying(reading()))
}

/// The controller as a system: inputs (v, y, u_applied), outputs (u, M v).
pub fn controller_system(file: &Controller) -> Result<StateSpace, Failure> {
    let n = file.order;
    let D = file.D.to_mat(2).insert_column(2, 0.0);
    let time = Time::Sampled { period_s: file.period_s };
    let [A, B, C]: [Mat; 3] = [file.A.to_mat(n), file.B.to_mat(3), file.C.to_mat(n)];
    StateSpace::new(A, B, C, D, time).map_err(Failure::while_trying("use the controller"))
}

/// The live settings: the file's, and the kernel's defaults where it says nothing. `law` overrides the file's.
pub fn kernel_settings(file: &files::Settings, law: Option<files::Law>) -> kernel::Settings {
    let settings = with_table(&kernel::Settings::default(), file);
    kernel::Settings { law: law.map_or(settings.law, law_of_file), ..settings }
}
