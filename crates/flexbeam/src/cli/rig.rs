//! The command line of `flexbeam rig`: the simulated rig as a process, and experiments on a rig.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::Law;
use super::run::RigLink;
use crate::rig_test::RAMP;

/// `flexbeam rig`
#[derive(Args, Debug)]
#[command(args_conflicts_with_subcommands = true)]
pub struct Rig {
    /// An experiment, in place of serving.
    #[command(subcommand)]
    pub command: Option<Experiment>,
    /// The rig as a process.
    #[command(flatten)]
    pub serve: ServeRig,
}

/// Experiments on a rig.
#[derive(Debug, Subcommand)]
pub enum Experiment {
    /// Breakaway voltages by slow ramps, and the thresholds and u_p that follow; friction from constant-speed runs
    #[command(allow_negative_numbers = true)]
    Test(RigTest),
}

/// `flexbeam rig`
#[derive(Args, Debug)]
pub struct ServeRig {
    /// Where to listen: udp:ADDRESS:PORT, pty (makes a pseudo-terminal and says its name), serial:DEVICE[:BAUD]
    #[arg(long, default_value = "udp:127.0.0.1:4810")]
    pub listen: String,
    /// Rig file; the paper's rig by default
    #[arg(long)]
    pub rig: Option<PathBuf>,
    /// Seed of the sensor noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Leave the beam where it is when a new run begins; by default it is put back to rest, so that runs repeat
    #[arg(long)]
    pub carry_on: bool,
    /// Length [s]; until it is stopped by default
    #[arg(long)]
    pub duration: Option<f64>,
    /// One JSON object on standard output, at the end
    #[arg(long)]
    pub json: bool,
}

/// `flexbeam rig test`
#[derive(Args, Debug)]
pub struct RigTest {
    /// Where the rig is.
    #[command(flatten)]
    pub link: RigLink,
    /// Rig file of the simulated rig; the paper's by default
    #[arg(long)]
    pub rig: Option<PathBuf>,
    /// Sample period of a rig that is not simulated, 0.001 by default, or of a --from without a time column [s]
    #[arg(long)]
    pub period: Option<f64>,
    /// Coulomb torque, dead zone and viscous friction, too, from runs at constant speed
    #[arg(long)]
    pub friction: bool,
    /// Slow ramps each way; from two on with a standard error. One by default, three with --friction
    #[arg(long)]
    pub repeats: Option<usize>,
    /// Largest turn of a constant-speed run [degree]
    #[arg(long, default_value_t = 120.0)]
    pub travel_deg: f64,
    /// There is no viscous friction besides the motor's own: the rig file's R_ohm alone makes newton metres of volts
    #[arg(long)]
    pub no_viscous: bool,
    /// Take this recording of such a test (voltage_v, theta_rad, alpha_rad) in place of a rig
    #[arg(long, conflicts_with_all = ["port", "seed", "repeats", "keep"])]
    pub from: Option<PathBuf>,
    /// Names of a --from recording's white-space columns, in order
    #[arg(long, value_delimiter = ',', requires = "from")]
    pub columns: Vec<String>,
    /// Write what was recorded into this CSV file
    #[arg(long)]
    pub keep: Option<PathBuf>,
    /// Write a rig file with the friction found: that of --rig, else the paper's, with these numbers
    #[arg(long, requires = "friction")]
    pub write_rig: Option<PathBuf>,
    /// Draw voltage against speed with its 95 % band into this folder
    #[arg(long, requires = "friction")]
    pub plots: Option<PathBuf>,
    /// Write over files that are not of the kind to be written
    #[arg(long)]
    pub force: bool,
    /// Slope of the ramp [V/s]
    #[arg(long, default_value_t = RAMP.rate_v_s)]
    pub slope: f64,
    /// Highest voltage of the ramp [V]
    #[arg(long, default_value_t = RAMP.peak_v)]
    pub highest: f64,
    /// Rest before each ramp [s]: a beam that still swings breaks the hub loose early
    #[arg(long, default_value_t = RAMP.rest_s)]
    pub rest: f64,
    /// Law that the settings are for; that of --apply-to's controller by default, else the inverse law
    #[arg(long, value_enum)]
    pub law: Option<Law>,
    /// Controller file whose law settings are replaced by the ones found
    #[arg(long)]
    pub apply_to: Option<PathBuf>,
    /// Seed of the simulated rig's sensor noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// One JSON object on standard output
    #[arg(long)]
    pub json: bool,
}
