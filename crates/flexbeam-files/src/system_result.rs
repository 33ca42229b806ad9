//! The answer of an export of a model or a controller as data.

use serde::Serialize;

/// `flexbeam export --as mat|json` of a model or a controller.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SystemResult {
    /// The file that was written.
    pub file: String,
    /// Its SHA-256, in hexadecimal.
    pub sha256: String,
    /// `mat` or `json`.
    pub format: String,
    /// The script beside it; null for `json`.
    pub script: Option<String>,
    /// The file it was made from.
    pub source: String,
    /// SHA-256 of that file, in hexadecimal.
    pub source_sha256: String,
    /// Its schema.
    pub schema: String,
    /// Number of states.
    pub order: usize,
    /// Sample period [s]; null in continuous time.
    pub period_s: Option<f64>,
    /// What a person should know of the source; null when there is nothing.
    pub notice: Option<String>,
}
