//! `flexbeam reproduce`: every number behind its report, as `summary.json` holds it.

use crate::model::Physical;
use crate::results::{DesignResult, DistributedBeam, RigTestResult, Spread};
use serde::Serialize;
use std::collections::BTreeMap;

/// The paper from end to end. SI units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReproduceSummary {
    /// Seed of excitation and sensor noise.
    pub seed: u64,
    /// (18) and what the recordings give for it.
    pub plant: PlantTable,
    /// How the model was identified.
    pub identification: IdentificationSummary,
    /// The slow-ramp test and the settings that follow.
    pub breakaway: RigTestResult,
    /// The controller's certificate.
    pub design: DesignResult,
    /// Whether every figure of the certificate was found again by other formulas.
    pub verified: bool,
    /// The loop around the exact distributed beam.
    pub distributed_beam: DistributedBeam,
    /// Steps on the nonlinear rig, by law.
    pub laws: BTreeMap<String, LawSummary>,
    /// Figures in the folder, without the ending.
    pub figures: Vec<String>,
    /// Time of the whole [s].
    pub seconds: f64,
}

/// k1, k2, c and b four times.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlantTable {
    /// As the paper prints them.
    pub printed: Physical,
    /// From a noise-free recording of the linear rig, unstructured, in physical coordinates.
    pub noise_free: Physical,
    /// Largest relative deviation of `noise_free` from `printed`.
    pub noise_free_error: f64,
    /// From the recording with 1 % output noise: least squares with standard errors; the nominal plant of the design.
    pub noisy: Physical,
    /// From the nonlinear rig with its modes and friction.
    pub nonlinear: Physical,
}

/// The identification of the noisy recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IdentificationSummary {
    /// Samples recorded.
    pub samples: usize,
    /// Block rows i.
    pub block_rows: usize,
    /// Order that the rule on the singular values chose.
    pub order: usize,
    /// Singular values, in descending order.
    pub singular_values: Vec<f64>,
    /// For each output, percent on samples not used for estimation.
    pub fit_percent: BTreeMap<String, f64>,
}

/// Steps of one law, both directions, many noise seeds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LawSummary {
    /// Upward steps.
    pub up: DirectionSummary,
    /// Downward steps.
    pub down: DirectionSummary,
}

/// Steps of one law in one direction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DirectionSummary {
    /// Number of runs.
    pub runs: usize,
    /// Height of the step [rad].
    pub step_rad: f64,
    /// Stationary error [rad].
    pub stationary_error_rad: Spread,
    /// Settling time, 2 % [s]; null when a run did not settle.
    pub settling_time_s: Option<Spread>,
    /// Runs that did not settle.
    pub unsettled: usize,
    /// Overshoot [percent].
    pub overshoot_percent: Spread,
    /// Residual vibration [rad].
    pub residual_vibration_rad: Spread,
    /// Runs that ended in a limit cycle.
    pub limit_cycles: usize,
}
