//! `flexbeam reproduce`: the paper from end to end on the simulated rig.

mod figures;
mod laws;
mod page;
mod plant;

use std::path::Path;
use std::time::Instant;

use flexbeam_design::{Design, Outcome, Reference, Specification, design, low_pass};
use flexbeam_files as files;
use flexbeam_files::{Controller, DesignResult, Document, Overwrite, ReproduceSummary, json_text, write_bytes};
use flexbeam_ident::breakaway::{Breakaway, Thresholds};
use flexbeam_lti::StateSpace;
use flexbeam_rig::{Beam, RigParameters};
use flexbeam_verify::{OnBeam, Verified};
use indicatif::ProgressBar;

use crate::Failure;
use crate::cli;
use crate::controller_file::{Particulars, controller_file, stiffness};
use crate::design::{beam_of_rig, beam_uncertainty};
use crate::law::{test_result, with_thresholds};
use crate::nominal::lumped_psi;
use crate::output::{folder, progress, provenance, write_figure};
use crate::rig_test::{RAMP, breakaway};
use crate::verify::{Parts, distributed_beam};

/// beta of the design [1/s]: below the damping of the third mode, 2.018.
pub(crate) const BETA: f64 = 1.5;

/// Rise time of the reference model [s].
pub(crate) const RISE_TIME_S: f64 = 0.25;

/// Cut-off of the measurements' low-pass filters [Hz]: a sixth of the sample rate.
const LOW_PASS_HZ: f64 = 150.0;

/// Time over which a step of the reference is smoothed [s].
const SMOOTH_STEP_S: f64 = 0.2;

/// The largest step that the voltage is reckoned for [degree].
const LARGEST_STEP_DEG: f64 = 45.0;

/// The amplifier's limit [V].
const VOLTAGE_LIMIT_V: f64 = 10.0;

/// Everything that the figures and the report show.
struct Findings {
    rig: RigParameters,
    beam: Beam,
    plant: plant::Plant,
    breakaway: Breakaway,
    thresholds: Thresholds,
    nominal: StateSpace,
    specification: Specification,
    design: Box<Design>,
    controller: Controller,
    verified: Vec<Verified>,
    on_beam: OnBeam,
    beam_figures: Vec<Verified>,
    laws: laws::Laws,
}

/// No controller, which the paper's plant does not excuse.
#[derive(Debug, thiserror::Error)]
#[error("the certificate does not hold: {0}")]
struct Broken(String);

/// Runs the command.
pub fn run(arguments: &cli::Reproduce) -> Result<(), Failure> {
    let start = Instant::now();
    expect_free(&arguments.out)?;
    folder(&arguments.out)?;
    let bar = progress(STEPS, "");
    let findings = findings(arguments, &bar)?;
    announce(&bar, "drawing");
    let pictures = figures::all(&findings)?;
    for (name, figure) in &pictures {
        write_figure(&arguments.out, name, figure)?;
    }
    let summary = findings.summary(arguments.seed, &pictures, start.elapsed().as_secs_f64());
    let page = page::report(&findings, &pictures);
    write_bytes(&arguments.out.join("report.html"), page.as_bytes(), Overwrite::Allow)?;
    let json = json_text(&summary);
    write_bytes(&arguments.out.join("summary.json"), json.as_bytes(), Overwrite::Allow)?;
    bar.finish_and_clear();
    if arguments.json {
        println!("{json}");
    } else {
        print!("{}", page::terminal(&findings));
        eprintln!("wrote report.html, summary.json and {} figures in {}", pictures.len(), arguments.out.display());
    }
    match findings.broken() {
        None => Ok(()),
        Some(what) => Err(Failure::No(Box::new(Broken(what)))),
    }
}

/// Files that somebody else made.
#[derive(Debug, thiserror::Error)]
#[error("found {0} there, which no reproduce has made\nhint: --out names another folder")]
struct Occupied(&'static str);

/// What an earlier run left may be replaced; a file of the same name in a folder without our summary may not.
fn expect_free(folder: &Path) -> Result<(), Failure> {
    let ours = std::fs::read_to_string(folder.join("summary.json")).is_ok_and(|text| text.starts_with(SUMMARY_START));
    let found = ["summary.json", "report.html", "recording.csv"].into_iter().find(|name| folder.join(name).exists());
    match found {
        Some(name) if !ours => Err(Failure::while_trying(format!("write to {}", folder.display()))(Occupied(name))),
        _ => Ok(()),
    }
}

/// How a summary begins: by its first key.
const SUMMARY_START: &str = "{\"seed\":";

/// Steps that the progress bar counts.
const STEPS: u64 = 6;

fn announce(bar: &ProgressBar, what: &'static str) {
    bar.set_message(what);
    bar.inc(1);
}

fn findings(arguments: &cli::Reproduce, bar: &ProgressBar) -> Result<Findings, Failure> {
    let rig = RigParameters::default();
    let beam = beam_of_rig(None)?;
    announce(bar, "recording and identifying");
    let plant = plant::identify(&rig, arguments.seed, &arguments.out)?; // (7)-(18)
    announce(bar, "slow ramp in both directions");
    let (breakaway, detection) = breakaway(&rig, &RAMP, arguments.seed)?;
    let thresholds = breakaway.inverse_thresholds(detection.resolution_rad);
    announce(bar, "designing");
    let nominal = lumped_psi(&plant.nominal)?;
    let v_res_v = breakaway.residual_v(&thresholds);
    let specification = specification(&beam, &nominal, rig.period_s, v_res_v)?; // (19)
    let tried = "design the controller";
    let solved = match design(&nominal, &specification).map_err(Failure::while_trying(tried))? {
        Outcome::Solved(solved) => solved, // (20)-(27)
        Outcome::Unsolvable(reason) => return Err(Failure::No(Box::new(reason))),
    };
    let particulars = particulars(&specification, &breakaway, &thresholds, v_res_v);
    let path = arguments.out.join("controller.toml");
    let provenance = provenance(&[&arguments.out.join("model.toml")], &path)?;
    let controller = controller_file(&solved, &specification, &nominal, particulars, Some(provenance))?;
    controller.write(&path, Overwrite::SameKind)?;
    announce(bar, "verifying by other formulas");
    let parts = Parts::of(&controller)?;
    let verified = parts.figures(&controller).map_err(Failure::while_trying("verify the controller"))?;
    let (on_beam, beam_figures) = parts.on_beam(&controller, None)?;
    announce(bar, "steps on the nonlinear rig");
    let switched = breakaway.switched_thresholds(detection.resolution_rad);
    let laws = laws::run(&rig, &controller, &switched, arguments.seed)?; // Figures 8-10
    Ok(Findings {
        rig,
        beam,
        plant,
        breakaway,
        thresholds,
        nominal,
        specification,
        design: solved,
        controller,
        verified,
        on_beam,
        beam_figures,
        laws,
    })
}

fn specification(beam: &Beam, nominal: &StateSpace, period_s: f64, v_res_v: f64) -> Result<Specification, Failure> {
    Ok(Specification {
        stability_degree: BETA,
        uncertainty: beam_uncertainty(beam, nominal, BETA)?,
        stiffness: stiffness(files::Stiffness::Needed, v_res_v),
        reference: Reference::RiseTime { rise_time_s: RISE_TIME_S, overshoot_percent: 0.0 },
        period_s,
        delay_s: period_s,
        low_pass: low_pass(LOW_PASS_HZ, period_s),
    })
}

fn particulars(
    specification: &Specification,
    breakaway: &Breakaway,
    thresholds: &Thresholds,
    v_res_v: f64,
) -> Particulars {
    let channel = files::Channel { low_pass: Some(specification.low_pass), ..files::Channel::default() };
    let settings = files::Settings {
        voltage_limit_v: Some(VOLTAGE_LIMIT_V),
        smooth_ticks: Some((SMOOTH_STEP_S / specification.period_s).round()),
        theta: Some(channel.clone()),
        alpha: Some(channel),
        ..files::Settings::default()
    };
    Particulars {
        output: "psi".into(),
        stiffness: files::Stiffness::Needed,
        v_res_v,
        overshoot_percent: Some(0.0),
        max_voltage_v: VOLTAGE_LIMIT_V,
        max_step_rad: LARGEST_STEP_DEG.to_radians(),
        settings: with_thresholds(settings, files::Law::Inverse, breakaway, thresholds),
    }
}

impl Findings {
    /// The first figure that was not found again.
    fn broken(&self) -> Option<String> {
        let broken = self.verified.iter().chain(&self.beam_figures).find(|figure| !figure.agrees)?;
        Some(format!("{} is claimed to be {} and was found to be {}", broken.figure, broken.claimed, broken.recomputed))
    }

    fn summary(&self, seed: u64, pictures: &[(&str, flexbeam_report::Figure)], seconds: f64) -> ReproduceSummary {
        ReproduceSummary {
            seed,
            plant: self.plant.table(),
            identification: self.plant.identification(),
            breakaway: test_result(
                files::Law::Inverse,
                &self.breakaway,
                &self.thresholds,
                Some("controller.toml".into()),
            ),
            design: DesignResult::of(&self.controller),
            verified: self.broken().is_none(),
            distributed_beam: distributed_beam(&self.on_beam, BETA),
            laws: self.laws.summaries(),
            figures: pictures.iter().map(|(name, _)| (*name).to_string()).collect(),
            seconds,
        }
    }
}
