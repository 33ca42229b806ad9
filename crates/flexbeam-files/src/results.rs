//! The commands' answers, as `--json` prints them: one object, SI units, keys that scripts rely on.
//!
//! An infinite or undefined number becomes `null`.

use crate::certificate::LoopFigures;
use crate::controller::Controller;
use crate::excitation::Excitation;
use crate::extended::Extended;
use crate::model::Physical;
use serde::Serialize;
use std::collections::BTreeMap;

/// One answer as a JSON object on one line.
pub fn json_text<T: Serialize>(answer: &T) -> String {
    serde_json::to_string(answer).expect("answers have string keys only")
}

/// `flexbeam new`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NewResult {
    /// The project's folder.
    pub folder: String,
    /// What it is called.
    pub name: String,
    /// Files in it.
    pub files: Vec<String>,
}

/// `flexbeam design` with a controller.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DesignResult {
    /// Whether (22) is solvable.
    pub solvable: bool,
    /// The continuous loop.
    #[serde(flatten)]
    pub continuous: LoopFigures,
    /// Number of states of the controller.
    pub controller_order: usize,
    /// Sample period [s].
    pub period_s: f64,
    /// M(s).
    pub reference_model: ReferenceModel,
    /// alpha(s) in the shifted plane.
    pub uncertainty: RationalCoefficients,
    /// Residual voltage for which the stiffness was chosen [V].
    pub v_res_v: Option<f64>,
    /// v_res/K(0) [rad].
    pub stationary_error_rad: Option<f64>,
    /// The loop that runs: sampled, with its exact delay; poles in the z-plane.
    pub sampled: LoopFigures,
}

/// A rational function's coefficients, highest power first.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RationalCoefficients {
    /// Numerator.
    pub num: Vec<f64>,
    /// Denominator.
    pub den: Vec<f64>,
}

/// The reference model M(s).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReferenceModel {
    /// Numerator, highest power first.
    pub num: Vec<f64>,
    /// Denominator, highest power first.
    pub den: Vec<f64>,
    /// Rise time [s].
    pub rise_time_s: Option<f64>,
}

impl DesignResult {
    /// The answer that a controller file holds.
    pub fn of(controller: &Controller) -> DesignResult {
        let (design, certificate) = (&controller.design, &controller.certificate);
        DesignResult {
            solvable: true,
            continuous: certificate.continuous.clone(),
            controller_order: controller.order,
            period_s: controller.period_s,
            reference_model: ReferenceModel {
                num: design.reference_num.clone(),
                den: design.reference_den.clone(),
                rise_time_s: design.rise_time_s,
            },
            uncertainty: RationalCoefficients {
                num: design.uncertainty_num.clone(),
                den: design.uncertainty_den.clone(),
            },
            v_res_v: certificate.v_res_v,
            stationary_error_rad: certificate.stationary_error_rad,
            sampled: certificate.sampled.clone(),
        }
    }
}

/// `flexbeam design --robust-only`, and any design to which the answer is no.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SolvabilityResult {
    /// Whether (22) is solvable.
    pub solvable: bool,
    /// Largest perturbation, in units of the uncertainty, that some controller survives; null when nothing is unstable.
    pub robust_radius: Extended,
    /// beta that was asked for [1/s].
    pub stability_degree: f64,
    /// The sampled problem, where it was posed.
    pub sampled: Option<SampledRadius>,
    /// Why not, and what would make it solvable; null when it is.
    pub reason: Option<String>,
}

/// The sampled problem's radius.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SampledRadius {
    /// As in [`SolvabilityResult`].
    pub robust_radius: Extended,
}

/// `flexbeam simulate`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SimulateResult {
    /// Size of the step [rad].
    pub step_rad: f64,
    /// Law that was in force.
    pub law: crate::settings::Law,
    /// Seed of the sensor noise.
    pub seed: u64,
    /// Time after which the tip stays within 2 % [s]; null when it does not.
    pub settling_time_s: Option<f64>,
    /// Overshoot [percent of the step].
    pub overshoot_percent: f64,
    /// Mean error at the end [rad].
    pub stationary_error_rad: f64,
    /// Swing of the deflection that remains at the end [rad].
    pub residual_vibration_rad: f64,
    /// Largest magnitude of the voltage [V].
    pub peak_voltage_v: f64,
    /// Whether the loop keeps swinging.
    pub limit_cycle: bool,
    /// The kernel's fault, if the rig was stopped.
    pub fault: Option<String>,
    /// Files that were written.
    pub files: Vec<String>,
}

/// `flexbeam verify`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VerifyResult {
    /// Whether every figure agrees and every demand is met.
    pub verified: bool,
    /// Each figure of the continuous loop beside the one that the certificate claims.
    #[serde(flatten)]
    pub continuous: BTreeMap<String, Figure>,
    /// The same for the sampled loop.
    pub sampled: BTreeMap<String, Figure>,
    /// The loop around the exact distributed beam, where it was asked for.
    pub distributed_beam: Option<DistributedBeam>,
    /// Runs on the simulated rig, where they were asked for.
    pub monte_carlo: Option<MonteCarlo>,
    /// A sentence for each thing that does not hold.
    pub failures: Vec<String>,
}

/// A figure of the certificate, claimed and found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// What the certificate says; null for infinity.
    pub claimed: Extended,
    /// What was found by another formula; null for infinity.
    pub found: Extended,
    /// Whether the two agree.
    pub agrees: bool,
}

/// The loop around the exact distributed beam.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DistributedBeam {
    /// Whether the loop is stable, by a Nyquist count on the exact response.
    pub stable: bool,
    /// Stability degree that the count confirms [1/s].
    pub stability_degree: Option<f64>,
    /// sup |dG/alpha| on the shifted line, below 1 where the uncertainty covers the beam.
    pub covered: Option<f64>,
}

/// Runs on the simulated rig with drawn parameters and noise.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MonteCarlo {
    /// Number of runs.
    pub runs: usize,
    /// Seed of the first draw.
    pub seed: u64,
    /// Runs that were stopped by a fault or did not stay bounded.
    pub unstable: usize,
    /// Runs that ended in a limit cycle.
    pub limit_cycles: usize,
    /// Stationary error over the runs [rad].
    pub stationary_error_rad: Spread,
    /// Settling time over the runs that settled [s]; null when none did.
    pub settling_time_s: Option<Spread>,
}

/// A figure over many runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Half of the runs lie below.
    pub median: f64,
    /// 95 % of the runs lie below.
    pub p95: f64,
    /// The largest.
    pub max: f64,
}

/// `flexbeam record`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecordResult {
    /// The recording.
    pub file: String,
    /// SHA-256 of the recording, in hexadecimal.
    pub sha256: String,
    /// Columns besides time.
    pub columns: Vec<String>,
    /// Number of samples.
    pub samples: usize,
    /// Sample period [s].
    pub period_s: f64,
    /// Root mean square of the voltage [V].
    pub rms_v: f64,
    /// Seed of excitation and sensor noise.
    pub seed: u64,
    /// The voltage as it was planned.
    pub excitation: Excitation,
    /// The lumped link's numbers and the standard errors expected of a fit to the whole recording; null without noise.
    pub expected: Option<Physical>,
}

/// `flexbeam rig test`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RigTestResult {
    /// Voltage at which the hub starts to move forward [V], positive.
    pub breakaway_plus_v: f64,
    /// The same backward [V], negative.
    pub breakaway_minus_v: f64,
    /// Law that the settings are for.
    pub law: crate::settings::Law,
    /// Voltage added or sent in the positive direction [V].
    pub u_p_plus_v: f64,
    /// The same in the negative direction, as a magnitude [V].
    pub u_p_minus_v: f64,
    /// Threshold of switch 2 [V].
    pub eps_u_v: f64,
    /// Threshold of switch 1 [rad].
    pub eps_e_rad: f64,
    /// v_res, the voltage behind the inverse law at which the hub may still stick [V]; null for another law.
    pub residual_voltage_v: Option<f64>,
    /// Controller file that has these settings now; null when none was named.
    pub applied_to: Option<String>,
    /// Breakaway of repeated ramps, the delay of its detection removed; null when no ramp was repeated.
    pub repeated: Option<crate::friction_result::RepeatedBreakaway>,
    /// Friction from constant-speed runs; null without `--friction`.
    pub friction: Option<crate::friction_result::FrictionResult>,
}

/// `flexbeam export`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExportResult {
    /// The file that was written.
    pub file: String,
    /// Its SHA-256, in hexadecimal.
    pub sha256: String,
    /// `csv` or `mat`.
    pub format: String,
    /// The file it was made from.
    pub source: String,
    /// Columns of a CSV file, variables of a MATLAB file.
    pub columns: Vec<String>,
    /// Number of samples.
    pub samples: usize,
    /// Sample period [s].
    pub period_s: f64,
    /// What a person should know of the source; null when there is nothing.
    pub notice: Option<String>,
}

/// `flexbeam show`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShowResult<'a, T: Serialize> {
    /// The file.
    pub file: String,
    /// Its schema; `flexbeam.recording/1` for a recording.
    pub schema: &'static str,
    /// What it holds.
    pub content: &'a T,
    /// Poles of a model, pairs [re, im]: in the s-plane [1/s] where there is a continuous model, else in the z-plane.
    pub poles: Option<Vec<[f64; 2]>>,
    /// The file and what it was made of, back to the recording.
    pub history: Vec<crate::provenance::Step>,
}

/// What a recording holds, without its samples.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecordingSummary {
    /// Number of samples.
    pub samples: usize,
    /// Sample period [s].
    pub period_s: f64,
    /// Columns besides time.
    pub columns: Vec<ColumnSummary>,
}

/// One column of a recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColumnSummary {
    /// Its name, with the unit.
    pub name: String,
    /// The smallest value.
    pub min: f64,
    /// The largest.
    pub max: f64,
    /// The mean.
    pub mean: f64,
    /// Standard deviation.
    pub std: f64,
}
