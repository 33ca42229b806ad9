//! `flexbeam verify`: the certificate by other formulas, the exact distributed beam, runs on the simulated rig.

use std::collections::BTreeMap;
use std::path::Path;

use flexbeam_files::{Controller, DistributedBeam, Extended, Figure, MonteCarlo, Spread, VerifyResult, json_text};
use flexbeam_lti::{C64, Rational, StateSpace, Zpk};
use flexbeam_report::{Cell, Table, Verdict, significant};
use flexbeam_verify::{
    BeamPlant, Campaign, Claim, Comparison, OnBeam, Quantiles, Scenario, Subject, Summary, Timing, Verified,
    monte_carlo, on_beam, verify,
};

use crate::Failure;
use crate::cli;
use crate::controller_file::{controller_system, kernel_settings};
use crate::design::beam_of_rig;
use crate::output::progress;
use crate::project::controller_and_rig;
use crate::response::rig_at;

/// Some figure broke.
#[derive(Debug, thiserror::Error)]
#[error("the controller is not verified:\n  {}\nhint: design it again; a controller file that was edited by hand keeps its old certificate, and --rig FILE describes a beam that is not the paper's", .0.join("\n  "))]
struct NotVerified(Vec<String>);

/// Runs the command.
pub fn run(arguments: &cli::Verify) -> Result<(), Failure> {
    let (file, rig) = controller_and_rig(&arguments.controller, arguments.rig.as_deref())?;
    let tried = || format!("verify {}", arguments.controller.display());
    let parts = Parts::of(&file)?;
    let figures = parts.figures(&file).map_err(Failure::while_trying(tried()))?;
    let beam = parts.on_beam(&file, rig.as_deref())?;
    let runs =
        (arguments.runs > 0).then(|| campaign(arguments, rig.as_deref(), &file, &parts.controller)).transpose()?;
    let mut result = result(&figures, &beam, runs.as_ref(), arguments.seed, file.design.stability_degree);
    result.failures.extend(other_filter(&file));
    result.verified = result.failures.is_empty();
    if arguments.json {
        println!("{}", json_text(&result));
    } else {
        let all: Vec<&Verified> = figures.iter().chain(&beam.1).collect();
        print!("{}", table(&all).text());
        if let Some(runs) = &runs {
            print!("{}", runs_table(runs).text());
        }
    }
    if result.verified { Ok(()) } else { Err(Failure::No(Box::new(NotVerified(result.failures)))) }
}

/// A sentence for each figure of the certificate that the controller's numbers do not bear out.
///
/// Errors: a file that makes no system.
pub fn broken_figures(file: &Controller) -> Result<Vec<String>, Failure> {
    let figures = Parts::of(file)?.figures(file).map_err(Failure::while_trying("recompute the certificate"))?;
    let broken = figures.iter().filter(|figure| !figure.agrees).map(sentence);
    Ok(broken.chain(other_filter(file)).collect())
}

/// The certificate speaks of the filter of the design; the loop runs those of the settings.
fn other_filter(file: &Controller) -> Option<String> {
    let (settings, designed) = (kernel_settings(&file.settings, None), file.design.low_pass);
    let other = [settings.theta, settings.alpha].into_iter().find(|c| c.low_pass != designed || c.scale != 1.0)?;
    let (low_pass, scale) = (other.low_pass, other.scale);
    Some(format!("settings: low_pass {low_pass} and scale {scale} of a channel, the design took {designed} and 1"))
}

/// What a controller file says, as the verifier wants it.
pub struct Parts {
    nominal: StateSpace,
    controller: StateSpace,
    alpha: Zpk,
    alpha_w: Zpk,
    timing: Timing,
}

impl Parts {
    /// Turns the file's plain tables into systems.
    pub fn of(file: &Controller) -> Result<Parts, Failure> {
        let design = &file.design;
        let nominal =
            file.plant_state_space().map_err(Failure::while_trying("use the nominal plant of the controller"))?;
        Ok(Parts {
            nominal,
            controller: controller_system(file)?,
            alpha: zpk(&design.uncertainty_num, &design.uncertainty_den)?,
            alpha_w: zpk(&design.sampled_uncertainty_num, &design.sampled_uncertainty_den)?,
            timing: Timing { period_s: file.period_s, delay_s: design.delay_s, low_pass: design.low_pass },
        })
    }

    /// Every figure of the certificate, claimed and recomputed.
    pub fn figures(&self, file: &Controller) -> Result<Vec<Verified>, flexbeam_verify::Error> {
        let subject = Subject {
            nominal: &self.nominal,
            timing: self.timing,
            controller: &self.controller,
            beta: file.design.stability_degree,
            alpha: &self.alpha,
            alpha_w: &self.alpha_w,
            v_res_v: file.certificate.v_res_v.unwrap_or(0.0),
        };
        Ok(verify(&subject, &claim(file))?.figures)
    }

    /// The loop on the exact distributed beam.
    pub fn on_beam(&self, file: &Controller, rig: Option<&Path>) -> Result<(OnBeam, Vec<Verified>), Failure> {
        let tried = "verify on the distributed beam";
        let beam = BeamPlant::new(&beam_of_rig(rig)?, self.timing).map_err(Failure::while_trying(tried))?;
        let feedback = flexbeam_verify::Feedback::new(&self.controller).map_err(Failure::while_trying(tried))?;
        let beta = file.design.stability_degree;
        let found =
            on_beam(&beam, &self.nominal, &feedback, &self.alpha_w, beta).map_err(Failure::while_trying(tried))?;
        let figures = found.figures();
        Ok((found, figures))
    }
}

fn zpk(num: &[f64], den: &[f64]) -> Result<Zpk, Failure> {
    let tried = "use the uncertainty of the controller";
    let alpha = Rational::new(num.to_vec(), den.to_vec()).map_err(Failure::while_trying(tried))?;
    let gain = alpha.num[0] / alpha.den[0];
    let zeros = alpha.zeros().map_err(Failure::while_trying(tried))?;
    let poles = alpha.poles().map_err(Failure::while_trying(tried))?;
    Ok(Zpk { zeros, poles, gain })
}

fn claim(file: &Controller) -> Claim {
    let (certificate, sampled) = (&file.certificate, &file.certificate.sampled);
    let radius = |x: Extended| x.0.is_finite().then_some(x.0);
    Claim {
        continuous_radius: radius(certificate.continuous.robust_radius),
        robust_radius: radius(sampled.robust_radius),
        bound_norm: sampled.bound_norm,
        stability_degree: sampled.stability_degree,
        stiffness_v_per_rad: sampled.stiffness.0,
        gain_margin: sampled.gain_margin.0,
        phase_margin_rad: sampled.phase_margin_rad.0,
        delay_margin_s: sampled.delay_margin_s.0,
        disk_margin: sampled.disk_margin.0,
        closed_loop_poles: sampled.closed_loop_poles.iter().map(|[re, im]| C64::new(*re, *im)).collect(),
        stationary_error_rad: certificate.stationary_error_rad.unwrap_or(f64::NAN),
    }
}

/// Steps of the default size with drawn parameters.
fn campaign(
    arguments: &cli::Verify,
    rig: Option<&Path>,
    file: &Controller,
    controller: &StateSpace,
) -> Result<Summary, Failure> {
    let rig = rig_at(rig, file.period_s)?;
    let settings = kernel_settings(&file.settings, None);
    let scenario = Scenario { rig, settings, controller, step_rad: STEP_DEG.to_radians(), duration_s: DURATION_S };
    let campaign = Campaign { runs: arguments.runs, seed: arguments.seed, ..Campaign::default() };
    let bar = progress(arguments.runs as u64, "Monte Carlo on the rig");
    let summary = monte_carlo(&scenario, &campaign, |done| bar.set_position(done as u64));
    bar.finish_and_clear();
    summary.map_err(Failure::while_trying("run the Monte Carlo"))
}

/// The step of a run, upwards and downwards in turn [degree].
const STEP_DEG: f64 = 30.0;

/// Length of a run [s].
const DURATION_S: f64 = 5.0;

fn result(
    figures: &[Verified],
    (beam, beam_figures): &(OnBeam, Vec<Verified>),
    runs: Option<&Summary>,
    seed: u64,
    beta: f64,
) -> VerifyResult {
    let mut failures: Vec<String> = figures.iter().chain(beam_figures).filter(|f| !f.agrees).map(sentence).collect();
    let unstable = runs.map_or(0, |runs| runs.runs.iter().filter(|run| !run.is_stable()).count());
    if unstable > 0 {
        failures.push(format!("monte_carlo: {unstable} runs on drawn rigs were stopped or did not come to rest"));
    }
    // The one figure of the continuous loop that a sampled controller's file can prove.
    let is_continuous = |f: &&Verified| f.figure == "robust_radius";
    let map = |of: Vec<&Verified>| -> BTreeMap<String, Figure> { of.into_iter().map(entry).collect() };
    VerifyResult {
        verified: failures.is_empty(),
        continuous: map(figures.iter().filter(is_continuous).collect()),
        sampled: map(figures.iter().filter(|f| !is_continuous(f)).collect()),
        distributed_beam: Some(distributed_beam(beam, beta)),
        monte_carlo: runs.map(|runs| monte_carlo_result(runs, seed)),
        failures,
    }
}

/// The verdict on the exact beam.
pub fn distributed_beam(beam: &OnBeam, beta: f64) -> DistributedBeam {
    DistributedBeam {
        stable: beam.unstable.beyond == 0,
        stability_degree: (beam.beyond_beta.beyond == 0).then_some(beta),
        covered: Some(beam.difference.value),
    }
}

fn entry(f: &Verified) -> (String, Figure) {
    let name = f.figure.trim_start_matches("sampled.").to_string();
    (name, Figure { claimed: Extended(f.claimed), found: Extended(f.recomputed), agrees: f.agrees })
}

/// What broke, in words.
pub fn sentence(f: &Verified) -> String {
    let (claimed, found) = (significant(f.claimed, 8), significant(f.recomputed, 8));
    format!("{}: claimed {claimed}, found {found} ({})", f.figure, f.reason)
}

fn monte_carlo_result(runs: &Summary, seed: u64) -> MonteCarlo {
    let spread = |q: &Quantiles| Spread { median: q.median, p95: q.p95, max: q.worst };
    let count = runs.runs.len();
    MonteCarlo {
        runs: count,
        seed,
        unstable: runs.runs.iter().filter(|run| !run.is_stable()).count(),
        limit_cycles: runs.runs.iter().filter(|run| run.metrics.limit_cycle).count(),
        stationary_error_rad: spread(&runs.stationary_error_rad),
        settling_time_s: runs.settling_time_s.median.is_finite().then(|| spread(&runs.settling_time_s)),
    }
}

/// Each figure beside the claimed one, or beside the limit that it must keep.
pub fn table(figures: &[&Verified]) -> Table {
    let columns = [("figure", ""), ("", ""), ("claimed or limit", ""), ("recomputed", ""), ("verdict", "")];
    figures.iter().fold(Table::new(&columns), |table, f| {
        let number = |x: f64| Cell::number(x, 7);
        let sense = match f.comparison {
            Comparison::AtLeast => "≥",
            Comparison::AtMost => "≤",
            Comparison::Equal | Comparison::EqualInverse | Comparison::EqualOrSmall => "=",
        };
        let verdict = Cell::from(Verdict::from(f.agrees));
        table.row([f.figure.into(), sense.into(), number(f.claimed), number(f.recomputed), verdict])
    })
}

fn runs_table(runs: &Summary) -> Table {
    let title = format!("{} runs, ±{STEP_DEG}°", runs.runs.len());
    let table = Table::new(&[(title.as_str(), ""), ("median", ""), ("95 %", ""), ("worst", ""), ("unit", "")]);
    let row = |table: Table, name: &str, q: &Quantiles, scale: f64, unit: &str| {
        let cell = |x: f64| Cell::number(x * scale, 3);
        table.row([name.into(), cell(q.median), cell(q.p95), cell(q.worst), unit.into()])
    };
    let degree = 1f64.to_degrees();
    let table = row(table, "stationary error", &runs.stationary_error_rad, degree, "deg");
    let table = row(table, "settling time", &runs.settling_time_s, 1.0, "s");
    let table = row(table, "residual vibration", &runs.residual_vibration_rad, degree, "deg");
    let share = |x: f64| Cell::number(100.0 * x, 4);
    table.row(["stable runs".into(), share(runs.share_stable), "".into(), "".into(), "%".into()]).row([
        "limit cycles".into(),
        share(runs.share_limit_cycle),
        "".into(),
        "".into(),
        "%".into(),
    ])
}
