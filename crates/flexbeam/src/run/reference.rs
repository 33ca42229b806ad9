//! The reference of a run, from the command line.

use std::path::Path;
use std::sync::Arc;

use flexbeam_files::{Layout, Recording};
use flexbeam_runtime::{Reference, Shape};

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

/// What the command line asks for.
///
/// Errors: a file that cannot be read, or has another period.
pub fn of(arguments: &cli::Run, period_s: f64) -> Result<Reference, Failure> {
    let shape = match arguments.signal {
        cli::Signal::Step => Shape::Step,
        cli::Signal::Square => Shape::Square,
        cli::Signal::Sine => Shape::Sine,
        cli::Signal::Sawtooth => Shape::Sawtooth,
        cli::Signal::File => Shape::File,
    };
    let samples = match (&arguments.signal_file, shape) {
        (Some(path), _) => samples(path, period_s)?,
        (None, Shape::File) => return Err(Failure::while_trying("make the reference")(NoReference::NoFile)),
        (None, _) => Arc::new([]),
    };
    // A file is in radians already; its amplitude is 1 and may be changed on the way.
    let amplitude_rad = if shape == Shape::File { 1.0 } else { arguments.amplitude_deg.to_radians() };
    Ok(Reference {
        shape,
        amplitude_rad,
        period_s: arguments.signal_period,
        offset_rad: arguments.offset_deg.to_radians(),
        samples,
        ..Reference::default()
    })
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
