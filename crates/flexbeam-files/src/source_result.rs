//! The answer of an export as source text.

use serde::Serialize;

/// `flexbeam export --as c|rust`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SourceResult {
    /// The folder that was written.
    pub folder: String,
    /// Paths of its files, with slashes.
    pub files: Vec<String>,
    /// `c` or `rust`.
    pub format: String,
    /// `f64` or `f32`.
    pub precision: String,
    /// Name of files, types and functions.
    pub name: String,
    /// The controller file.
    pub source: String,
    /// Its SHA-256, in hexadecimal.
    pub source_sha256: String,
    /// Number of states.
    pub order: usize,
    /// Sample period [s].
    pub period_s: f64,
    /// Largest differences of f32 from f64; null in f64.
    pub single_error: Option<SingleErrorResult>,
    /// What the difference of the loops in f32 and f64 never exceeds; null in f64, and where there is no bound.
    pub single_bound: Option<SingleBoundResult>,
    /// Why f32 has no bound; null where it has one, and in f64.
    pub no_bound: Option<String>,
    /// Why it was written although its certificate does not match; null where it does.
    pub unverified: Option<String>,
}

/// `flexbeam export --as fmu`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UnitResult {
    /// The archive that was written.
    pub file: String,
    /// Its SHA-256, in hexadecimal.
    pub sha256: String,
    /// Paths in it, with slashes.
    pub files: Vec<String>,
    /// `fmu`.
    pub format: String,
    /// Version of the functional mock-up interface: `2.0` or `3.0`.
    pub fmi: String,
    /// Name of the model.
    pub name: String,
    /// The controller file, the rig file, or the word for the paper's rig.
    pub source: String,
    /// Its SHA-256, in hexadecimal; null for a word.
    pub source_sha256: Option<String>,
    /// Its schema, `flexbeam.controller/1` or `flexbeam.rig/1`.
    pub schema: String,
    /// Number of states.
    pub order: usize,
    /// Sample period, which is the step [s].
    pub period_s: f64,
    /// Why it was written although its certificate does not match; null where it does.
    pub unverified: Option<String>,
}

/// Bounds of the difference between the loops in f32 and in f64, with the nominal plant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SingleBoundResult {
    /// For references within this [rad].
    pub reference_rad: f64,
    /// For deflections within this [rad].
    pub deflection_rad: f64,
    /// Of the voltage [V].
    pub voltage_v: f64,
    /// Of u [V].
    pub u_v: f64,
    /// Of the tip angle [rad].
    pub tip_rad: f64,
}

/// Largest differences from f64 over the test vectors.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SingleErrorResult {
    /// Ticks that were compared.
    pub ticks: usize,
    /// Of the voltage, while the law has no jumps [V].
    pub voltage_v: f64,
    /// Of the voltage under the switched law [V].
    pub switched_voltage_v: f64,
    /// Of u [V].
    pub u_v: f64,
    /// Of the angles [rad].
    pub angle_rad: f64,
}
