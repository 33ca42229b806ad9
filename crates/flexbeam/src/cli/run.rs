//! The command line of real time: `flexbeam run` and `flexbeam tell`, and where a rig is.

use std::path::PathBuf;

use clap::{ArgAction, Args, ValueEnum};

use super::Law;

/// Where the rig is, and the loop's clock on the way to it.
#[derive(Args, Clone, Debug)]
pub struct RigLink {
    /// Where the rig is: simulated, udp:HOST:PORT, serial:DEVICE[:BAUD], hil:BOARD[:ID][?KEY=VALUE,..],
    /// comedi:DEVICE[?KEY=VALUE,..]
    #[arg(long, default_value = "simulated")]
    pub port: String,
    /// Longest time that one voltage may stand, and that measurements may fail to come [s]
    #[arg(long, default_value_t = 0.02)]
    pub hold: f64,
    /// Core of the loop's thread, counted from 0; any by default
    #[arg(long)]
    pub core: Option<usize>,
    /// Highest voltage of the sign check before a real rig runs [V]; 0 leaves the check out
    #[arg(long, default_value_t = 1.5)]
    pub sign_check: f64,
    /// Largest hub angle, either way; beyond it the rig is stopped [degree]
    #[arg(long, default_value_t = 180.0)]
    pub max_angle_deg: f64,
    /// Largest hub speed; beyond it the rig is stopped [degree/s]
    #[arg(long, default_value_t = 2000.0)]
    pub max_speed_deg_s: f64,
}

/// `flexbeam run`
#[derive(Args, Clone, Debug)]
pub struct Run {
    /// Controller file, or a project: its folder or its flexbeam.toml
    #[arg(value_name = "CONTROLLER|PROJECT", default_value = ".")]
    pub controller: PathBuf,
    /// Where the rig is.
    #[command(flatten)]
    pub link: RigLink,
    /// Rig file of the simulated rig; the project's by default, else the paper's
    #[arg(long)]
    pub rig: Option<PathBuf>,
    /// Seed of the simulated rig's sensor noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Length [s]; until it is stopped by default
    #[arg(long)]
    pub duration: Option<f64>,
    /// Reference
    #[arg(long, value_enum, default_value_t = Signal::Step)]
    pub signal: Signal,
    /// Amplitude of the reference, and the size of a step [degree]
    #[arg(long, visible_alias = "step-deg", default_value_t = 30.0)]
    pub amplitude_deg: f64,
    /// Period of a square, sine or sawtooth [s]
    #[arg(long, default_value_t = 4.0)]
    pub signal_period: f64,
    /// What the amplitude is added to [degree]
    #[arg(long, default_value_t = 0.0)]
    pub offset_deg: f64,
    /// CSV file with a column reference_rad or reference_deg, at the controller's period; played once
    #[arg(long)]
    pub signal_file: Option<PathBuf>,
    /// Variable-structure law; the project's by default, else that of the controller file
    #[arg(long, value_enum)]
    pub law: Option<Law>,
    /// Home the simulated rig as a real one: find its zeroes and check its signs; --home=false where a project says so
    #[arg(long, action = ArgAction::Set, num_args = 0..=1, require_equals = true, default_value_t = false,
        default_missing_value = "true", hide_default_value = true, hide_possible_values = true, value_name = "BOOL")]
    pub home: bool,
    /// Stay armed at 0 V until told to start, by key or over the control socket; --wait=false where a project says so
    #[arg(long, action = ArgAction::Set, num_args = 0..=1, require_equals = true, default_value_t = false,
        default_missing_value = "true", hide_default_value = true, hide_possible_values = true, value_name = "BOOL")]
    pub wait: bool,
    /// Listen on this Unix socket for `flexbeam tell`
    #[arg(long)]
    pub control: Option<PathBuf>,
    /// The page in the browser.
    #[command(flatten)]
    pub scope: super::Scope,
    /// Live topics and parameters.
    #[cfg(feature = "foxglove")]
    #[command(flatten)]
    pub viewers: super::Viewers,
    /// Run a controller whose certificate does not match its numbers, for this reason; it goes into the recording
    #[arg(long, value_name = "REASON")]
    pub unverified: Option<String>,
    /// No picture of the run on the terminal, only its events
    #[arg(long)]
    pub plain: bool,
    /// The recording to write; of a project runs/DATE-TIME.mcap in its folder by default
    #[arg(short, long, default_value = "run.mcap")]
    pub out: PathBuf,
    /// Write over a file that is not of the kind to be written
    #[arg(long)]
    pub force: bool,
    /// One JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// Shapes of the reference.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub enum Signal {
    /// A rest of 0.1 s, then the amplitude
    Step,
    /// The amplitude to either side, half a period each
    Square,
    /// Sine
    Sine,
    /// A ramp from side to side, and back at once
    Sawtooth,
    /// The samples of --signal-file
    File,
}

/// `flexbeam tell`
#[derive(Args, Debug)]
pub struct Tell {
    /// The run's control socket
    pub socket: PathBuf,
    /// status | start | stop | emergency | set
    pub what: What,
    /// With set: KEY=VALUE, the keys of a controller file's settings, and reference.shape, .amplitude_rad, .period_s, .offset_rad
    pub changes: Vec<String>,
    /// One JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// What a run can be told.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub enum What {
    /// How does it stand
    Status,
    /// From armed to running
    Start,
    /// To 0 V and to the end
    Stop,
    /// Emergency stop: the run ends as a fault
    Emergency,
    /// Change settings
    Set,
}
