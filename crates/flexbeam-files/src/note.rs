//! The note beside a recording: a CSV file stays plain, so its schema and its parents stand next to it.

use crate::document::Document;
use crate::excitation::Excitation;
use crate::hash::sha256_hex;
use crate::misfit::Misfit;
use crate::model::positive;
use crate::provenance::Provenance;
use flexbeam_lti::Signals;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// `flexbeam.recording/1`, in `recording.csv.toml` beside `recording.csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Note {
    /// SHA-256 of the recording, in hexadecimal; a note with another hash is not about it.
    pub sha256: String,
    /// Sample period [s].
    pub period_s: f64,
    /// Number of samples.
    pub samples: usize,
    /// Columns besides time, with their units.
    pub columns: Vec<String>,
    /// The voltage as it was planned, where the recording was made by `flexbeam record`.
    pub excitation: Option<Excitation>,
    /// Where it came from.
    pub provenance: Option<Provenance>,
}

impl Note {
    /// A note about a recording of these signals with these bytes.
    pub fn new(signals: &Signals, bytes: &[u8], provenance: Provenance) -> Note {
        Note {
            sha256: sha256_hex(bytes),
            period_s: signals.period_s,
            samples: signals.samples(),
            columns: signals.names.clone(),
            excitation: None,
            provenance: Some(provenance),
        }
    }

    /// Where the note of a recording stands.
    pub fn path_for(recording: &Path) -> PathBuf {
        let mut path = recording.as_os_str().to_os_string();
        path.push(".toml");
        path.into()
    }
}

impl Document for Note {
    const SCHEMA: &'static str = "flexbeam.recording/1";
    const HEAD: &'static str = "flexbeam recording: where the file of the same name without .toml came from.";

    fn provenance(&self) -> Option<&Provenance> {
        self.provenance.as_ref()
    }

    fn check(&self) -> Result<(), Misfit> {
        positive("period_s", self.period_s)?;
        if self.columns.is_empty() {
            return Err(Misfit::empty("columns"));
        }
        self.excitation.as_ref().map_or(Ok(()), |table| table.check().map_err(|misfit| misfit.under("excitation")))
    }
}
