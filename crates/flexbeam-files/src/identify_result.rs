//! What `identify` answers with `--json`.

use crate::matrices::Rows;
use crate::model::{Innovations, Physical, Refinement, Uncertainty};
use serde::Serialize;
use std::collections::BTreeMap;

/// `flexbeam identify`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IdentifyResult {
    /// Order n.
    pub order: usize,
    /// Sample period [s].
    pub period_s: f64,
    /// Block rows i.
    pub block_rows: usize,
    /// Method: `moesp`, `paper`, ..
    pub method: String,
    /// Singular values, in descending order.
    pub singular_values: Vec<f64>,
    /// Poles in the z-plane, pairs [re, im].
    pub poles: Vec<[f64; 2]>,
    /// Poles in the s-plane [1/s]; null where there is no continuous model.
    pub continuous_poles: Option<Vec<[f64; 2]>>,
    /// For each output, percent on the part of the recording that was not used for estimation, or null.
    pub fit_percent: BTreeMap<String, Option<f64>>,
    /// The lumped model's numbers; null where the model does not have its pattern.
    pub physical: Option<Physical>,
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// Names of the outputs.
    pub outputs: Vec<String>,
    /// State matrix.
    pub A: Rows,
    /// Input matrix.
    pub B: Rows,
    /// Output matrix.
    pub C: Rows,
    /// Feedthrough.
    pub D: Rows,
    /// State at the first sample.
    pub initial_state: Vec<f64>,
    /// The bound on what the nominal plant leaves out; null where it was not asked for.
    pub uncertainty: Option<Uncertainty>,
    /// Poles that were known to be 1.
    pub integrators: usize,
    /// Delay of each input, which the model carries as states [samples].
    pub input_delay: Vec<usize>,
    /// What was taken from the inputs; zeros unless means are removed.
    pub input_means: Vec<f64>,
    /// What was taken from the outputs, the offsets that were estimated with it.
    pub output_means: Vec<f64>,
    /// For each output, percent on the part that estimated, or null.
    pub estimation_fit_percent: BTreeMap<String, Option<f64>>,
    /// Innovations form; null where nothing but rounding is left.
    pub innovations: Option<Innovations>,
    /// What makes the recording doubtful, in words.
    pub doubts: Vec<String>,
    /// Every order up to the one asked for; null where none was asked for.
    pub orders: Option<Vec<OrderResult>>,
    /// Time of the identification itself, reading and refinement apart [s].
    pub identify_s: f64,
    /// What `--refine` did; null without it.
    pub refined: Option<RefinedResult>,
}

/// What `--refine` did, and how long it took.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RefinedResult {
    /// As in the model file.
    #[serde(flatten)]
    pub refinement: Refinement,
    /// Time that it took [s].
    pub refine_s: f64,
}

/// One order among several.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OrderResult {
    /// Order n.
    pub order: usize,
    /// For each output, percent on the part that was not used for estimation, or null.
    pub fit_percent: BTreeMap<String, Option<f64>>,
    /// For each output, percent on the part that estimated, or null.
    pub estimation_fit_percent: BTreeMap<String, Option<f64>>,
    /// Schwarz's information criterion of the simulation's errors; null where the simulation overflows.
    pub criterion: Option<f64>,
    /// Swings, by frequency.
    pub modes: Vec<ModeResult>,
}

/// One swing, and what it shares with the nearest one of the order before.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModeResult {
    /// Natural frequency [rad/s].
    pub frequency_rad_s: f64,
    /// Damping ratio.
    pub damping: f64,
    /// Frequency within 1 %.
    pub stable_frequency: bool,
    /// Damping within 5 %.
    pub stable_damping: bool,
    /// Shape with an assurance of 0.98 or more.
    pub stable_shape: bool,
}
