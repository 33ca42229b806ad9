//! `flexbeam record`: a planned voltage through a rig. The simulated rig takes no time and leaves a CSV file with a note beside
//! it; a rig at another port, and every recording whose name ends in .mcap, is driven on the clock.

mod on_clock;
mod planned;

use std::path::{Path, PathBuf};

use flexbeam_files::{
    Document, Excitation, Note, Overwrite, Physical, RecordResult, check_free, csv_text, json_text, sha256_hex,
    write_bytes,
};
use flexbeam_lti::Signals;
use flexbeam_report::significant;
use flexbeam_rig::{RigParameters, SimulatedRig, open_loop};
use flexbeam_runtime::port::Port;

use crate::output::{overwrite, provenance, waiting};
use crate::port::port;
use crate::response::linear_rig;
use crate::rig_file::rig_parameters;
use crate::{Failure, cli};

/// `flexbeam record`.
pub fn run(arguments: &cli::Record) -> Result<(), Failure> {
    if arguments.out.extension().is_some_and(|extension| extension == "mcap") {
        let (port, parameters) = (port(&arguments.link.port)?, parameters(arguments)?);
        let Promised { excitation, planned, .. } = Promised::of(arguments, &parameters)?;
        let voltage_v = &excitation.voltage_v;
        return on_clock::Recording { arguments, port: &port, parameters: &parameters, voltage_v }.as_run(planned);
    }
    answer(arguments, recorded_as_planned(arguments)?);
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
    let Recorded { signals, bytes, .. } = recorded_as_planned(arguments)?;
    Ok((signals, bytes))
}

/// A table of signals, and what was promised of it.
struct Recorded {
    signals: Signals,
    bytes: Vec<u8>,
    planned: Excitation,
    expected: Option<Physical>,
}

fn recorded_as_planned(arguments: &cli::Record) -> Result<Recorded, Failure> {
    let (port, parameters) = (port(&arguments.link.port)?, parameters(arguments)?);
    let place = Place::free(&arguments.out, arguments.force)?;
    let Promised { excitation, planned, expected } = Promised::of(arguments, &parameters)?;
    let signals = if port == Port::Simulated {
        let _sign = waiting("recording");
        driven(&parameters, &excitation.voltage_v, arguments.seed)
            .map_err(|error| Failure::Input { tried: tried(arguments), error })?
    } else {
        on_clock::Recording { arguments, port: &port, parameters: &parameters, voltage_v: &excitation.voltage_v }
            .as_signals()?
    };
    let parents: Vec<&Path> = arguments.rig.iter().map(|path| path.as_path()).collect();
    let bytes = place.write(&signals, &parents, Some(&planned))?;
    Ok(Recorded { signals, bytes, planned, expected })
}

fn tried(arguments: &cli::Record) -> String {
    format!("record {}", arguments.out.display())
}

/// A voltage, and what its recording is expected to tell of the rig.
struct Promised {
    excitation: flexbeam_ident::excitation::Excitation,
    planned: Excitation,
    expected: Option<Physical>,
}

impl Promised {
    /// Makes the voltage, and says on standard error what to expect of it.
    ///
    /// Errors: settings of which no recording can be made.
    fn of(arguments: &cli::Record, parameters: &RigParameters) -> Result<Promised, Failure> {
        let promised = || -> Result<Promised, Box<dyn std::error::Error>> {
            let excitation = planned::voltage(&planned::plan(arguments, parameters)?)?;
            let expected = planned::expected(parameters, &excitation.voltage_v)?;
            Ok(Promised { planned: planned::table(arguments, &excitation), excitation, expected })
        };
        let promised = promised().map_err(|error| Failure::Input { tried: tried(arguments), error })?;
        if let Some(expected) = &promised.expected {
            planned::say_expected(expected, parameters.sensors.noise_rad());
        }
        Ok(promised)
    }
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

    /// `excitation` is what the voltage was made of, where it was planned.
    ///
    /// Returns: the table's bytes.
    pub fn write(
        &self,
        signals: &Signals,
        parents: &[&Path],
        excitation: Option<&Excitation>,
    ) -> Result<Vec<u8>, Failure> {
        let bytes = csv_text(signals, None).into_bytes();
        let about = Note::new(signals, &bytes, provenance(parents, &self.note)?);
        let text = Note { excitation: excitation.cloned(), ..about }.to_toml(&self.note)?;
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
    let plan = planned::white(parameters, duration_s, rms_v, seed)?;
    driven(parameters, &planned::voltage(&plan)?.voltage_v, seed)
}

/// What the simulated rig's sensors read under these voltages.
fn driven(parameters: &RigParameters, voltage_v: &[f64], seed: u64) -> Result<Signals, Box<dyn std::error::Error>> {
    // The sensors' noise must not be the excitation once more: another seed, as far from this one as can be.
    let mut rig = SimulatedRig::new(parameters, !seed)?;
    Ok(open_loop(&mut rig, voltage_v)?)
}

/// A day at 1 kHz; beyond it the CSV file fills memory.
pub(crate) const MOST_SAMPLES: f64 = 1e8;

fn answer(arguments: &cli::Record, recorded: Recorded) {
    let Recorded { signals, bytes, planned, expected } = recorded;
    let file = arguments.out.display().to_string();
    if arguments.json {
        let voltage_v = signals.data.row(0);
        println!(
            "{}",
            json_text(&RecordResult {
                file,
                sha256: sha256_hex(&bytes),
                columns: signals.names.clone(),
                samples: signals.samples(),
                period_s: signals.period_s,
                rms_v: voltage_v.norm() / (signals.samples() as f64).sqrt(),
                seed: arguments.seed,
                excitation: planned,
                expected,
            })
        );
        return;
    }
    let periods = match planned.period_samples {
        Some(samples) => format!(", {} periods of {samples} samples, ", planned.periods),
        None => ", ".into(),
    };
    let length_s = signals.samples() as f64 * signals.period_s;
    println!(
        "{file}: {} samples of {} ({} s), columns {}; {}{}{} V rms; seed {}",
        signals.samples(),
        flexbeam_report::engineering(signals.period_s, 4, "s"),
        significant(length_s, 4),
        signals.names.join(", "),
        arguments.signal.name(),
        periods,
        significant(planned.rms_v, 3),
        arguments.seed
    );
    // Twenty block rows of 1 ms see too little of a swing at 4 Hz once there is friction and noise.
    println!("next: flexbeam identify {file} {}", if arguments.linear { "--order 4" } else { "--block-rows 50" });
}
