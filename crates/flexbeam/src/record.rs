//! `flexbeam record`: white Gaussian voltage through a rig. The simulated rig takes no time and leaves a CSV file with a note beside
//! it; a rig at another port, and every recording whose name ends in .mcap, is driven on the clock.

mod on_clock;

use std::path::{Path, PathBuf};

use flexbeam_files::{
    Document, FEWEST_ROWS, Note, Overwrite, RecordResult, check_free, csv_text, json_text, sha256_hex, write_bytes,
};
use flexbeam_ident::excitation::white_gaussian;
use flexbeam_lti::Signals;
use flexbeam_report::significant;
use flexbeam_rig::{RigParameters, SimulatedRig, open_loop};
use flexbeam_runtime::port::Port;

use crate::output::{overwrite, provenance, waiting};
use crate::port::port;
use crate::response::linear_rig;
use crate::rig_file::rig_parameters;
use crate::{Failure, cli};

/// A setting of the experiment that makes no recording.
#[derive(Debug, thiserror::Error)]
#[error("found {setting} {found} {unit}, needed {needed}\nhint: {hint}")]
struct NoExperiment {
    setting: &'static str,
    found: f64,
    unit: &'static str,
    needed: String,
    hint: &'static str,
}

/// `flexbeam record`.
pub fn run(arguments: &cli::Record) -> Result<(), Failure> {
    if arguments.out.extension().is_some_and(|extension| extension == "mcap") {
        let (port, parameters) = (port(&arguments.link.port)?, parameters(arguments)?);
        return on_clock::Recording { arguments, port: &port, parameters: &parameters }.as_run();
    }
    let (signals, bytes) = recorded(arguments)?;
    answer(arguments, &signals, &bytes);
    Ok(())
}

fn parameters(arguments: &cli::Record) -> Result<RigParameters, Failure> {
    let mut parameters = rig_parameters(arguments.rig.as_deref())?;
    parameters.period_s = arguments.period.unwrap_or(parameters.period_s);
    Ok(if arguments.linear { linear_rig(&parameters) } else { parameters })
}

/// Records, and writes the table and the note beside it.
///
/// Returns: the signals, and the table's bytes.
/// Errors: those of the rig and of writing.
pub(crate) fn recorded(arguments: &cli::Record) -> Result<(Signals, Vec<u8>), Failure> {
    let csv = &arguments.out;
    let (port, parameters) = (port(&arguments.link.port)?, parameters(arguments)?);
    let place = Place::free(csv, arguments.force)?;
    let signals = if port == Port::Simulated {
        let _sign = waiting("recording");
        let tried = format!("record {}", csv.display());
        excited(&parameters, arguments.duration, arguments.rms, arguments.seed)
            .map_err(|error| Failure::Input { tried, error })?
    } else {
        on_clock::Recording { arguments, port: &port, parameters: &parameters }.as_signals()?
    };
    let parents: Vec<&Path> = arguments.rig.iter().map(|path| path.as_path()).collect();
    let bytes = place.write(&signals, &parents)?;
    Ok((signals, bytes))
}

/// Where a table goes, and the note beside it.
pub(crate) struct Place<'a> {
    csv: &'a Path,
    note: PathBuf,
    replace: Overwrite,
    replace_note: Overwrite,
}

impl Place<'_> {
    /// Errors: something stands there that is not to be written over.
    pub fn free(csv: &Path, force: bool) -> Result<Place<'_>, Failure> {
        let replace = if force { Overwrite::Allow } else { Overwrite::SameKind };
        check_free(csv, replace)?;
        let note = Note::path_for(csv);
        let replace_note = overwrite::<Note>(&note, force)?;
        Ok(Place { csv, note, replace, replace_note })
    }

    /// Returns: the table's bytes.
    pub fn write(&self, signals: &Signals, parents: &[&Path]) -> Result<Vec<u8>, Failure> {
        let bytes = csv_text(signals, None).into_bytes();
        let text = Note::new(signals, &bytes, provenance(parents, &self.note)?).to_toml(&self.note)?;
        write_bytes(self.csv, &bytes, self.replace)?;
        write_bytes(&self.note, text.as_bytes(), self.replace_note)?;
        Ok(bytes)
    }
}

/// White Gaussian voltage of this rms, and what the rig's sensors read.
///
/// Errors: a duration, period or rms of which no recording can be made; those of the rig.
pub(crate) fn excited(
    parameters: &RigParameters,
    duration_s: f64,
    rms_v: f64,
    seed: u64,
) -> Result<Signals, Box<dyn std::error::Error>> {
    let voltage_v = excitation(parameters, duration_s, rms_v, seed)?;
    // The sensors' noise must not be the excitation once more: another seed, as far from this one as can be.
    let mut rig = SimulatedRig::new(parameters, !seed)?;
    Ok(open_loop(&mut rig, &voltage_v)?)
}

/// White Gaussian voltage of this rms, a sample a period, clipped at the amplifier's limit.
///
/// Errors: a duration, period or rms of which no recording can be made.
fn excitation(
    parameters: &RigParameters,
    duration_s: f64,
    rms_v: f64,
    seed: u64,
) -> Result<Vec<f64>, Box<dyn std::error::Error>> {
    let wrong = |setting, found, unit, needed, hint| Err(NoExperiment { setting, found, unit, needed, hint }.into());
    let period_s = parameters.period_s;
    if !(period_s > 0.0 && period_s.is_finite()) {
        return wrong(
            "a sample period of",
            period_s,
            "s",
            "a positive number".into(),
            "1 ms suits the beam: --period 0.001",
        );
    }
    let samples = (duration_s / period_s).round();
    if !(samples >= FEWEST_ROWS as f64 && samples <= MOST_SAMPLES) {
        let needed = format!("{FEWEST_ROWS} to {MOST_SAMPLES:e} samples of {period_s} s");
        return wrong("a duration of", duration_s, "s", needed, "ten seconds are plenty: --duration 10");
    }
    if !(rms_v > 0.0 && rms_v.is_finite()) {
        return wrong(
            "an rms voltage of",
            rms_v,
            "V",
            "a positive number".into(),
            "half of the amplifier's limit: --rms 5",
        );
    }
    Ok(white_gaussian(samples as usize, rms_v, parameters.actuator.limit_v, seed))
}

/// A day at 1 kHz; beyond it the CSV file fills memory.
pub(crate) const MOST_SAMPLES: f64 = 1e8;

fn answer(arguments: &cli::Record, signals: &Signals, bytes: &[u8]) {
    let file = arguments.out.display().to_string();
    if arguments.json {
        let voltage_v = signals.data.row(0);
        println!(
            "{}",
            json_text(&RecordResult {
                file,
                sha256: sha256_hex(bytes),
                columns: signals.names.clone(),
                samples: signals.samples(),
                period_s: signals.period_s,
                rms_v: voltage_v.norm() / (signals.samples() as f64).sqrt(),
                seed: arguments.seed,
            })
        );
        return;
    }
    let length_s = signals.samples() as f64 * signals.period_s;
    println!(
        "{file}: {} samples of {} ({} s), columns {}; seed {}",
        signals.samples(),
        flexbeam_report::engineering(signals.period_s, 4, "s"),
        significant(length_s, 4),
        signals.names.join(", "),
        arguments.seed
    );
    // Twenty block rows of 1 ms see too little of a swing at 4 Hz once there is friction and noise.
    println!("next: flexbeam identify {file} {}", if arguments.linear { "--order 4" } else { "--block-rows 50" });
}
