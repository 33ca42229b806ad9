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
    /// Slow-ramp breakaway test: breakaway voltages, and the thresholds and u_p that follow
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
    /// Sample period of a rig that is not simulated [s]
    #[arg(long, default_value_t = 0.001)]
    pub period: f64,
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
