//! The reference of a run, from the command line and the project.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use flexbeam_files::{Layout, ProjectReference, Recording, RunShape};
use flexbeam_runtime::{Reference, Shape, shape_of_file};

use crate::{Failure, cli};

/// A reference that cannot be played.
#[derive(Debug, thiserror::Error)]
enum NoReference {
    #[error("found --signal file without a file, needed --signal-file\nhint: a CSV file with time_s and reference_deg")]
    NoFile,
    #[error(
        "found a period of {found_s} s in the reference file, needed the controller's {needed_s} s\nhint: a reference is played one sample a tick, and never resampled by guessing"
    )]
    Period { found_s: f64, needed_s: f64 },
}

/// The reference that is asked for, in SI.
pub struct AskedReference {
    shape: Shape,
    amplitude_rad: f64,
    period_s: f64,
    offset_rad: f64,
    file: Option<PathBuf>,
}

impl AskedReference {
    /// By the command line and its defaults. A file is in radians already; its amplitude is 1 and may be changed on the way.
    pub fn of(arguments: &cli::Run) -> AskedReference {
        let shape = match arguments.signal {
            cli::Signal::Step => Shape::Step,
            cli::Signal::Square => Shape::Square,
            cli::Signal::Sine => Shape::Sine,
            cli::Signal::Sawtooth => Shape::Sawtooth,
            cli::Signal::File => Shape::File,
        };
        AskedReference {
            shape,
            amplitude_rad: if shape == Shape::File { 1.0 } else { arguments.amplitude_deg.to_radians() },
            period_s: arguments.signal_period,
            offset_rad: arguments.offset_deg.to_radians(),
            file: arguments.signal_file.clone(),
        }
    }

    /// The same, with the project's word where the command line says nothing.
    pub fn or_project(self, said: &ProjectReference, given: &cli::Given<cli::Run>) -> AskedReference {
        let shape = said.shape.map(shape_of_file).filter(|_| !given.states("signal")).unwrap_or(self.shape);
        // What a file is multiplied by is no angle, and the other way round.
        let same_sense = (shape == Shape::File) == (said.shape == Some(RunShape::File));
        let amplitude_rad = said.amplitude_rad.filter(|_| same_sense && !given.states("amplitude_deg"));
        let own_amplitude_rad = match shape {
            Shape::File => 1.0,
            _ => given.arguments.amplitude_deg.to_radians(),
        };
        AskedReference {
            shape,
            amplitude_rad: amplitude_rad.unwrap_or(own_amplitude_rad),
            period_s: said.period_s.filter(|_| !given.states("signal_period")).unwrap_or(self.period_s),
            offset_rad: said.offset_rad.filter(|_| !given.states("offset_deg")).unwrap_or(self.offset_rad),
            file: self.file.or_else(|| said.file.clone()),
        }
    }

    /// Its file.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// The reference itself, its file read.
    ///
    /// Errors: a file that cannot be read, or has another period.
    pub fn read(&self, period_s: f64) -> Result<Reference, Failure> {
        let samples = match (&self.file, self.shape) {
            (Some(path), _) => samples(path, period_s)?,
            (None, Shape::File) => return Err(Failure::while_trying("make the reference")(NoReference::NoFile)),
            (None, _) => Arc::new([]),
        };
        Ok(Reference {
            shape: self.shape,
            amplitude_rad: self.amplitude_rad,
            period_s: self.period_s,
            offset_rad: self.offset_rad,
            samples,
            ..Reference::default()
        })
    }
}

fn samples(path: &Path, period_s: f64) -> Result<Arc<[f64]>, Failure> {
    let recording = Recording::read(path, &Layout::default())?.into_si();
    let found_s = recording.signals.period_s;
    if (found_s - period_s).abs() > flexbeam_files::PERIOD_TOLERANCE * period_s {
        let error = NoReference::Period { found_s, needed_s: period_s };
        return Err(Failure::while_trying(format!("play {}", path.display()))(error));
    }
    Ok(recording.select(&["reference_rad"])?.data.iter().copied().collect())
}
