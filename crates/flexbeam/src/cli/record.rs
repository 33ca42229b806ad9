//! The command line of `flexbeam record`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::run::RigLink;

/// `flexbeam record`
#[derive(Args, Debug)]
pub struct Record {
    /// The file to write: CSV, or a run recording where it ends in .mcap
    #[arg(short, long, default_value = "recording.csv")]
    pub out: PathBuf,
    /// Where the rig is.
    #[command(flatten)]
    pub link: RigLink,
    /// Rig file of the simulated rig; the paper's by default
    #[arg(long)]
    pub rig: Option<PathBuf>,
    /// Length [s]; a voltage that repeats ends with its last whole period
    #[arg(long, default_value_t = 10.0)]
    pub duration: f64,
    /// Sample period [s]; the rig file's by default, else 0.001
    #[arg(long)]
    pub period: Option<f64>,
    /// Voltage that excites the rig
    #[arg(long, value_enum, default_value_t = Waveform::White)]
    pub signal: Waveform,
    /// Lowest and highest frequency of the voltage [Hz]; all up to half the sampling frequency by default
    #[arg(long, value_delimiter = ',', num_args = 1, value_name = "F1,F2")]
    pub band: Vec<f64>,
    /// Root mean square of the voltage [V]
    #[arg(long, default_value_t = 5.0)]
    pub rms: f64,
    /// Largest voltage [V]; the amplifier's limit by default. White noise is clipped there, the others become smaller as a whole
    #[arg(long)]
    pub peak: Option<f64>,
    /// How often the voltage repeats within the length
    #[arg(long, default_value_t = 1)]
    pub periods: usize,
    /// The linear lumped rig without friction, quantisation, noise and delay
    #[arg(long)]
    pub linear: bool,
    /// Seed of excitation and sensor noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Write over a file that is not of the kind to be written
    #[arg(long)]
    pub force: bool,
    /// One JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// Shapes of the excitation.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub enum Waveform {
    /// White Gaussian noise
    White,
    /// Binary sequence of maximal length, between +rms and -rms
    Prbs,
    /// All harmonics in the band, phases for a low crest factor
    Multisine,
    /// Some odd harmonics at random phases: tells noise and nonlinear distortion apart
    OddMultisine,
    /// Sine whose frequency rises by as many hertz in each second
    Chirp,
    /// Sine whose frequency rises by as many octaves in each second
    LogChirp,
}

impl Waveform {
    /// As it stands on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Waveform::White => "white",
            Waveform::Prbs => "prbs",
            Waveform::Multisine => "multisine",
            Waveform::OddMultisine => "odd-multisine",
            Waveform::Chirp => "chirp",
            Waveform::LogChirp => "log-chirp",
        }
    }
}
