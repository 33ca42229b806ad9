//! `flexbeam design`: model to controller and certificate, or the reason why there is none.

mod model_bound;

use std::path::{Path, PathBuf};

use flexbeam_design::{
    Outcome, Reference, Solvability, Specification, Uncertainty, cover, design, low_pass, solvability,
};
use flexbeam_files::{Controller, DesignResult, Document, Extended, Model, Settings, SolvabilityResult, json_text};
use flexbeam_lti::{C64, Rational, StateSpace};
use flexbeam_report::{Check, significant};
use flexbeam_rig::{Beam, Damping, Link};

use crate::Failure;
use crate::cli;
use crate::controller_file::{Particulars, controller_file, stiffness, uncertainty};
use crate::nominal::{lumped, nominal_plant};
use crate::output::{overwrite, provenance};
use crate::rig_file::rig_parameters;

/// Runs the command.
pub fn run(arguments: &cli::Design) -> Result<(), Failure> {
    expect_not_negative(arguments)?;
    let model = Model::read(&arguments.model)?;
    let nominal = nominal_plant(&model, &arguments.output_name, arguments.nominal)?;
    if arguments.uncertainty.as_deref() == Some("beam") {
        tell_apart(arguments, &model)?;
    }
    let specification = match specification(arguments, &model, &nominal) {
        Err(Failure::No(reason)) => return answer_no(arguments, None, reason),
        other => other?,
    };
    if arguments.robust_only {
        return robust_only(arguments, &nominal, &specification);
    }
    let file = match solved(arguments, &nominal, &specification) {
        Err(Failure::No(reason)) => return answer_no(arguments, Some((&nominal, &specification)), reason),
        other => other?,
    };
    if arguments.json {
        println!("{}", json_text(&DesignResult::of(&file)));
    } else {
        print!("{}", Check::table(&checks(&file)).text());
        let out = arguments.out.display();
        eprintln!("wrote {out}\nnext: flexbeam rig test --apply-to {out} measures what the law against friction needs");
    }
    Ok(())
}

/// Designs, and writes the controller.
///
/// Errors: [`Failure::No`] where there is none; those of reading and writing.
pub(crate) fn designed(arguments: &cli::Design) -> Result<Controller, Failure> {
    expect_not_negative(arguments)?;
    let model = Model::read(&arguments.model)?;
    let nominal = nominal_plant(&model, &arguments.output_name, arguments.nominal)?;
    solved(arguments, &nominal, &specification(arguments, &model, &nominal)?)
}

fn solved(arguments: &cli::Design, nominal: &StateSpace, specification: &Specification) -> Result<Controller, Failure> {
    let replace = overwrite::<Controller>(&arguments.out, arguments.force)?;
    let tried = || format!("design a controller for {}", arguments.model.display());
    let solved = match design(nominal, specification).map_err(Failure::while_trying(tried()))? {
        Outcome::Solved(solved) => solved,
        Outcome::Unsolvable(reason) => return Err(Failure::No(Box::new(reason))),
    };
    let parents: Vec<&Path> = [&arguments.model].into_iter().chain(&arguments.rig).map(PathBuf::as_path).collect();
    let provenance = provenance(&parents, &arguments.out)?;
    let file = controller_file(&solved, specification, nominal, particulars(arguments)?, Some(provenance))?;
    file.write(&arguments.out, replace)?;
    Ok(file)
}

fn specification(arguments: &cli::Design, model: &Model, nominal: &StateSpace) -> Result<Specification, Failure> {
    let low_pass = arguments.low_pass_hz.map_or(1.0, |cutoff_hz| low_pass(cutoff_hz, arguments.period));
    Ok(Specification {
        stability_degree: arguments.stability_degree,
        uncertainty: alpha(arguments, model, nominal)?,
        stiffness: stiffness(asked_stiffness(arguments)?, arguments.residual_voltage),
        reference: reference(arguments)?,
        period_s: arguments.period,
        delay_s: arguments.period,
        low_pass,
    })
}

/// A number that would only fail later, or not at all.
#[derive(Debug, thiserror::Error)]
#[error(
    "{name} is {found}, needed a number that is not negative\nhint: `flexbeam design --help` lists units and defaults"
)]
struct Negative {
    name: &'static str,
    found: f64,
}

fn expect_not_negative(arguments: &cli::Design) -> Result<(), Failure> {
    let numbers =
        [("--residual-voltage [V]", arguments.residual_voltage), ("--smooth-step [s]", arguments.smooth_step)];
    match numbers.into_iter().find(|(_, x)| !(*x >= 0.0 && x.is_finite())) {
        Some((name, found)) => Err(Failure::while_trying("read the specification")(Negative { name, found })),
        None => Ok(()),
    }
}

fn asked_stiffness(arguments: &cli::Design) -> Result<flexbeam_files::Stiffness, Failure> {
    let unreadable = |needed| NoStiffness { found: arguments.stiffness.clone(), needed };
    arguments.stiffness.parse().map_err(unreadable).map_err(Failure::while_trying("read --stiffness"))
}

/// No word and no number.
#[derive(Debug, thiserror::Error)]
#[error(
    "found {found:?}, needed one of {needed}\nhint: `needed` is the default: 0.15 degree behind the residual voltage"
)]
struct NoStiffness {
    found: String,
    needed: flexbeam_files::NoStiffness,
}

fn reference(arguments: &cli::Design) -> Result<Reference, Failure> {
    if !arguments.reference_num.is_empty() {
        let M = Rational::new(arguments.reference_num.clone(), arguments.reference_den.clone())
            .map_err(Failure::while_trying("use the reference model M(s)"))?;
        return Ok(Reference::Model(M));
    }
    let overshoot_percent = arguments.overshoot;
    Ok(match arguments.rise_time {
        Some(rise_time_s) => Reference::RiseTime { rise_time_s, overshoot_percent },
        None => Reference::Fastest {
            overshoot_percent,
            max_voltage_v: arguments.max_voltage,
            max_step_rad: arguments.max_step_deg.to_radians(),
        },
    })
}

/// Neither a number nor `beam`.
#[derive(Debug, thiserror::Error)]
enum NoBound {
    #[error(
        "found {0:?}, needed a positive number of rad/V, `model` or `beam`\nhint: --uncertainty beam covers the distributed beam"
    )]
    Unreadable(String),
    #[error(
        "no uncertainty is given\nhint: --uncertainty beam covers the distributed beam, --uncertainty 0.3 is a constant bound in rad/V"
    )]
    Missing,
}

/// alpha(s): coefficients, a constant, or what covers the distributed beam.
fn alpha(arguments: &cli::Design, model: &Model, nominal: &StateSpace) -> Result<Uncertainty, Failure> {
    let tried = "read the uncertainty";
    match arguments.uncertainty.as_deref() {
        None if arguments.uncertainty_num.is_empty() => Err(Failure::while_trying(tried)(NoBound::Missing)),
        None => uncertainty(&arguments.uncertainty_num, &arguments.uncertainty_den),
        Some("beam") => beam_uncertainty(&beam_of_rig(arguments.rig.as_deref())?, nominal, arguments.stability_degree),
        Some("model") => model_bound::of_model(arguments, model),
        Some(text) => match text.parse() {
            Ok(value) => Uncertainty::constant(value).map_err(Failure::while_trying(tried)),
            Err(_) => Err(Failure::while_trying(tried)(NoBound::Unreadable(text.into()))),
        },
    }
}

/// Says so when the model's own parameters are not the rig's: the bound has to cover that, too.
fn tell_apart(arguments: &cli::Design, model: &Model) -> Result<(), Failure> {
    let Some(physical) = &model.physical else { return Ok(()) };
    let rig = rig_parameters(arguments.rig.as_deref())?.physical.lumped();
    let pairs = lumped(physical).to_array().into_iter().zip(rig.to_array());
    let farthest = pairs.map(|(model, rig)| (model / rig - 1.0).abs()).fold(0.0, f64::max);
    if farthest > APART {
        let whose = if arguments.rig.is_some() { "the rig file's" } else { "the paper's (--rig FILE describes yours)" };
        eprintln!(
            "note: the model's parameters lie up to {:.0} % from {whose}; the bound covers the beam of the rig",
            100.0 * farthest
        );
    }
    Ok(())
}

/// Parameters that differ by more are another beam's, or were fitted through friction and neglected modes.
const APART: f64 = 0.02;

/// The exact response of the distributed beam is that of a beam without a tip mass.
#[derive(Debug, thiserror::Error)]
#[error(
    "the rig has a tip mass of {0} kg, and the exact beam has none\nhint: --uncertainty with coefficients covers such a rig; simulate takes the tip mass"
)]
struct TipMass(f64);

/// The distributed beam of a rig file; the paper's without one.
pub fn beam_of_rig(rig: Option<&Path>) -> Result<Beam, Failure> {
    let parameters = rig_parameters(rig)?;
    let damping = match parameters.link {
        Link::Modes { tip_mass_kg, .. } if tip_mass_kg != 0.0 => {
            return Err(Failure::while_trying("form the distributed beam")(TipMass(tip_mass_kg)));
        }
        Link::Modes { damping, .. } => damping,
        Link::Lumped => Damping::Modal { zeta: Beam::ZETA },
    };
    Beam::new(parameters.physical, damping).map_err(Failure::while_trying("form the distributed beam"))
}

/// A mode that no bound covers.
#[derive(Debug, thiserror::Error)]
#[error(
    "beta = {beta} cannot hold on the distributed beam: mode {number} ({omega_rad_s:.1} rad/s, {:.1} Hz) is damped by only {damping:.4} 1/s and was neglected, so it lies right of the line Re s = -beta and no alpha(s) covers it\nhint: beta must stay below {damping:.4}; {:.2} leaves the bound some room",
    .omega_rad_s / std::f64::consts::TAU, 0.75 * .damping
)]
struct NeglectedMode {
    beta: f64,
    number: usize,
    omega_rad_s: f64,
    damping: f64,
}

/// Modes of the distributed beam that are looked at: the damping of modal damping grows with frequency from the third on.
const MODES: usize = 8;

/// alpha(s) above |dG(jw - beta)|, the distributed beam less the nominal plant.
pub fn beam_uncertainty(beam: &Beam, nominal: &StateSpace, beta: f64) -> Result<Uncertainty, Failure> {
    let modes = beam.modes(MODES);
    let least = modes.iter().enumerate().skip(1).min_by(|a, b| (-a.1.re).total_cmp(&-b.1.re));
    if let Some((k, mode)) = least.filter(|(_, mode)| -mode.re <= beta) {
        let (number, omega_rad_s, damping) = (k + 1, mode.im, -mode.re);
        return Err(Failure::No(Box::new(NeglectedMode { beta, number, omega_rad_s, damping })));
    }
    let difference = |omega: f64| {
        let s = C64::new(-beta, omega);
        (beam.at(s).psi() - nominal.at(s)[(0, 0)]).norm()
    };
    cover(difference, beta, modes.last().map_or(0.0, |mode| mode.im))
        .map_err(Failure::while_trying("cover the distributed beam"))
}

fn particulars(arguments: &cli::Design) -> Result<Particulars, Failure> {
    let max_step_rad = arguments.max_step_deg.to_radians();
    let low_pass = arguments.low_pass_hz.map(|cutoff_hz| {
        let low_pass = Some(low_pass(cutoff_hz, arguments.period));
        flexbeam_files::Channel { low_pass, ..Default::default() }
    });
    Ok(Particulars {
        output: arguments.output_name.clone(),
        stiffness: asked_stiffness(arguments)?,
        v_res_v: arguments.residual_voltage,
        overshoot_percent: arguments.reference_num.is_empty().then_some(arguments.overshoot),
        max_voltage_v: arguments.max_voltage,
        max_step_rad,
        settings: Settings {
            voltage_limit_v: Some(arguments.max_voltage),
            smooth_ticks: Some((arguments.smooth_step / arguments.period).round()),
            theta: low_pass.clone(),
            alpha: low_pass,
            ..Settings::default()
        },
    })
}

fn robust_only(arguments: &cli::Design, nominal: &StateSpace, specification: &Specification) -> Result<(), Failure> {
    let answer = solve(arguments, nominal, specification)?;
    if !answer.is_solvable() {
        // The design says why, and what would help.
        let tried = || format!("design a controller for {}", arguments.model.display());
        if let Outcome::Unsolvable(reason) = design(nominal, specification).map_err(Failure::while_trying(tried()))? {
            return answer_no(arguments, Some((nominal, specification)), Box::new(reason));
        }
    }
    let result = result(arguments, Some(answer), None);
    if arguments.json {
        println!("{}", json_text(&result));
    } else {
        match answer.robust_radius {
            Some(radius) => println!("(22) is solvable: robust radius {}", significant(radius, 7)),
            None => println!("(22) is solvable: nothing is unstable after the shift by beta"),
        }
    }
    Ok(())
}

fn solve(arguments: &cli::Design, nominal: &StateSpace, specification: &Specification) -> Result<Solvability, Failure> {
    let tried = format!("find the robust radius of {}", arguments.model.display());
    solvability(nominal, specification.stability_degree, &specification.uncertainty)
        .map_err(Failure::while_trying(tried))
}

/// The answer is no: the JSON object says so too.
fn answer_no(
    arguments: &cli::Design,
    problem: Option<(&StateSpace, &Specification)>,
    reason: Box<dyn std::error::Error>,
) -> Result<(), Failure> {
    if arguments.json {
        let answer = problem.map(|(nominal, specification)| solve(arguments, nominal, specification)).transpose()?;
        println!("{}", json_text(&result(arguments, answer, Some(reason.to_string()))));
    }
    Err(Failure::No(reason))
}

fn result(arguments: &cli::Design, answer: Option<Solvability>, reason: Option<String>) -> SolvabilityResult {
    let radius = answer.map_or(Some(f64::NAN), |answer| answer.robust_radius);
    SolvabilityResult {
        solvable: reason.is_none(),
        robust_radius: Extended(radius.unwrap_or(f64::INFINITY)),
        stability_degree: arguments.stability_degree,
        sampled: None,
        reason,
    }
}

/// The certificate as a table, what runs first.
pub fn checks(file: &Controller) -> Vec<Check> {
    let (certificate, design) = (&file.certificate, &file.design);
    let sampled = &certificate.sampled;
    let line = |name: &str, symbol: &str, value: f64, unit: &str, required: String, holds: bool| Check {
        name: name.into(),
        symbol: symbol.into(),
        value: significant(value, 5),
        unit: unit.into(),
        required,
        verdict: holds.into(),
    };
    let beta = design.stability_degree;
    let error_deg = certificate.stationary_error_rad.unwrap_or(f64::NAN).to_degrees();
    let degrees = |x: Extended| x.0.to_degrees();
    vec![
        line("robust radius", "", sampled.robust_radius.0, "", "≥ 1".into(), sampled.robust_radius.0 >= 1.0),
        line("bound norm (22)", "‖S_w‖", sampled.bound_norm, "", "≤ 1".into(), sampled.bound_norm <= 1.0),
        line(
            "stability degree",
            "β",
            sampled.stability_degree,
            "1/s",
            format!("> {beta}"),
            sampled.stability_degree > beta,
        ),
        line("stiffness", "K(0)", sampled.stiffness.0, "V/rad", String::new(), true),
        line("error behind v_res", "", error_deg, "deg", String::new(), error_deg.is_finite()),
        line("gain margin", "", sampled.gain_margin.0, "", "> 1".into(), sampled.gain_margin.0 > 1.0),
        line(
            "phase margin",
            "",
            degrees(sampled.phase_margin_rad),
            "deg",
            "> 0".into(),
            sampled.phase_margin_rad.0 > 0.0,
        ),
        line("delay margin", "", 1e3 * sampled.delay_margin_s.0, "ms", "> 0".into(), sampled.delay_margin_s.0 > 0.0),
        line("disk margin", "", sampled.disk_margin.0, "", "> 0".into(), sampled.disk_margin.0 > 0.0),
    ]
}
