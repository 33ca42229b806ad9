//! The voltage of a recording as it was planned: what an identification may know of it.

use crate::hash::sha256_hex;
use crate::misfit::Misfit;
use crate::model::{out_of_range, positive};
use crate::note::Note;
use crate::run_file::excitation_of_run;
use crate::write::read_bytes;
use crate::{Document, Fault};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The table `excitation` of a recording's note, and the text of that name in a run's metadata.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Excitation {
    /// `white`, `prbs`, `multisine`, `odd-multisine`, `chirp`, `log-chirp`.
    pub signal: String,
    /// Root mean square [V].
    pub rms_v: f64,
    /// Largest magnitude [V].
    pub peak_v: f64,
    /// Lowest and highest frequency [Hz]; nothing where all are excited.
    pub band_hz: Option<[f64; 2]>,
    /// Samples of a period; nothing where the voltage does not repeat.
    pub period_samples: Option<usize>,
    /// How many periods were sent.
    pub periods: usize,
    /// Samples of a binary sequence's clock.
    pub clock_samples: Option<usize>,
    /// Of all that is random.
    pub seed: u64,
}

impl Excitation {
    /// What is known of the recording with this SHA-256 at `path`: from the note beside it, or from its own metadata.
    ///
    /// Returns nothing where nobody says, and where the note is about another recording.
    pub fn of_recording(path: &Path, sha256: &str) -> Option<Excitation> {
        if let Ok(note) = Note::read(&Note::path_for(path))
            && note.sha256 == sha256
        {
            return note.excitation;
        }
        let bytes = read_bytes(path).ok().filter(|bytes| sha256_hex(bytes) == sha256)?;
        excitation_of_run(&bytes)
    }

    pub(crate) fn check(&self) -> Result<(), Misfit> {
        positive("rms_v", self.rms_v)?;
        positive("peak_v", self.peak_v)?;
        match self.band_hz {
            Some([low, high]) if !(low >= 0.0 && high > low) => {
                Err(out_of_range("band_hz", low, "a lower and a higher frequency [Hz]"))
            }
            _ if self.period_samples == Some(0) => Err(out_of_range("period_samples", 0.0, "at least 1")),
            _ => Ok(()),
        }
    }

    /// As one line, for metadata that are text.
    pub(crate) fn to_text(&self) -> String {
        serde_json::to_string(self).expect("an excitation has string keys only")
    }

    /// Errors: [`Fault::WrongType`].
    pub(crate) fn of_text(text: &str) -> Result<Excitation, Fault> {
        let fault = |found: String| Fault::WrongType {
            key: "excitation".into(),
            found,
            needed: "an excitation as one JSON object".into(),
        };
        let excitation: Excitation = serde_json::from_str(text).map_err(|error| fault(error.to_string()))?;
        excitation.check().map_err(|_| fault(format!("the text {text:?}")))?;
        Ok(excitation)
    }
}
