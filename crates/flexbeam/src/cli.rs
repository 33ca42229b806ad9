//! The command line as types. Names, defaults and units of DESIGN section 10.

mod export;
mod given;
mod new;
mod record;
mod rig;
mod run;
mod scope;
#[cfg(feature = "foxglove")]
mod viewers;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use flexbeam_ident::{Delay, Order};

use crate::nominal::Nominal;
pub use export::{DEFAULT_NAME, Export, Form, Precision};
pub use given::Given;
pub use new::New;
pub use record::{Record, Waveform};
pub use rig::{Experiment, Rig, RigTest, ServeRig};
pub use run::{RigLink, Run, Signal, Tell, What};
pub use scope::Scope;
#[cfg(feature = "foxglove")]
pub use viewers::Viewers;

/// Model, identify, design, verify and simulate a robust controller for a flexible beam on a servo motor.
#[derive(Debug, Parser)]
#[command(name = "flexbeam", version, max_term_width = 110)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// The paper from end to end on the simulated rig: figures, report, summary
    #[command(allow_negative_numbers = true)]
    Reproduce(Reproduce),
    /// A project: a folder that runs at once, on the simulated rig
    New(New),
    /// Excite the rig and record
    #[command(allow_negative_numbers = true)]
    Record(Record),
    /// Recording -> model
    #[command(allow_negative_numbers = true)]
    Identify(Identify),
    /// Model -> controller and certificate
    #[command(allow_negative_numbers = true)]
    Design(Design),
    /// Recompute a controller's certificate by other formulas; Monte Carlo on the simulated rig
    #[command(allow_negative_numbers = true)]
    Verify(Verify),
    /// Closed loop on the nonlinear rig
    #[command(allow_negative_numbers = true)]
    Simulate(Simulate),
    /// Real time: the controller on the clock, on a rig
    #[command(allow_negative_numbers = true)]
    Run(Given<Run>),
    /// Steer a run over its control socket
    #[command(allow_negative_numbers = true)]
    Tell(Tell),
    /// The simulated rig as a process; experiments on a rig
    #[command(allow_negative_numbers = true)]
    Rig(Rig),
    /// A recording as CSV or for MATLAB; a model or a controller for MATLAB or as JSON; a controller as C, Rust or FMU; a rig as FMU
    Export(Export),
    /// What a file holds and where it came from
    Show(Show),
}

/// `flexbeam reproduce`
#[derive(Args, Debug)]
pub struct Reproduce {
    /// Folder for summary.json, report.html and the figures
    #[arg(long, default_value = "reproduce")]
    pub out: PathBuf,
    /// Seed of excitation and sensor noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// One JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// `flexbeam identify`
#[derive(Args, Debug)]
pub struct Identify {
    /// Recording: a table in text (columns without names are named by --columns), a MATLAB file, or the MCAP file of a run
    pub recording: PathBuf,
    /// Input columns
    #[arg(long, value_delimiter = ',', default_value = "voltage_v")]
    pub inputs: Vec<String>,
    /// Output columns
    #[arg(long, value_delimiter = ',', default_value = "theta_rad,alpha_rad")]
    pub outputs: Vec<String>,
    /// Names of the columns, in order, in place of those in the file; _ leaves one out
    #[arg(long, value_delimiter = ',')]
    pub columns: Vec<String>,
    /// Sample period [s], where the file has no time column
    #[arg(long)]
    pub period: Option<f64>,
    /// Interpolate a jittered time column to this period [s]
    #[arg(long)]
    pub resample: Option<f64>,
    /// Block rows i of the Hankel matrices; several compete on the estimating part [default: 20, with integrators 20,40,60]
    #[arg(long, value_delimiter = ',')]
    pub block_rows: Vec<usize>,
    /// Order n, or `auto` for the rule on the singular values
    #[arg(long, default_value = "auto", value_parser = order)]
    pub order: Order,
    /// Subspace method
    #[arg(long, value_enum, default_value_t = Method::Auto)]
    pub method: Method,
    /// Part of the recording that estimates; the rest validates
    #[arg(long, default_value_t = 0.5)]
    pub estimate: f64,
    /// Remove the means of the estimating part, and estimate what is left of an offset on each output
    #[arg(long)]
    pub remove_mean: bool,
    /// Poles known to be exactly 1: a motor's angle has one. D is zero then
    #[arg(long, default_value_t = 0)]
    pub integrators: usize,
    /// D is known to be zero
    #[arg(long)]
    pub no_feedthrough: bool,
    /// Whole samples that the inputs are late, or `auto`; the model carries them as states
    #[arg(long, default_value = "0", value_parser = delay)]
    pub delay: Delay,
    /// Poles inside the unit circle, by constrained least squares
    #[arg(long)]
    pub stable: bool,
    /// Compare all orders up to this one: fits, information criterion, stabilisation diagram with --plots
    #[arg(long)]
    pub orders: Option<usize>,
    /// Refine the model by the errors of the simulated output, or by those of a one-step prediction
    #[arg(long, value_enum, value_name = "ERRORS", num_args = 0..=1, require_equals = true, default_missing_value = "simulated")]
    pub refine: Option<Refinement>,
    /// beta [1/s]: bound what the nominal plant leaves out on s = jw - beta, for design --uncertainty model
    #[arg(long)]
    pub stability_degree: Option<f64>,
    /// Draw singular values, measured and simulated outputs and frequency responses into this folder
    #[arg(long)]
    pub plots: Option<PathBuf>,
    /// The model file to write
    #[arg(short, long, default_value = "model.toml")]
    pub out: PathBuf,
    /// Write over a file that is not of the kind to be written
    #[arg(long)]
    pub force: bool,
    /// One JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// `auto`, or a whole number from 1.
fn order(text: &str) -> Result<Order, String> {
    match text.parse::<usize>() {
        _ if text == "auto" => Ok(Order::Auto),
        Ok(order) if order > 0 => Ok(Order::Fixed(order)),
        _ => Err("needed `auto` or a whole number from 1".into()),
    }
}

/// `auto`, or a whole number from 0.
fn delay(text: &str) -> Result<Delay, String> {
    match text.parse::<usize>() {
        _ if text == "auto" => Ok(Delay::Auto),
        Ok(samples) => Ok(Delay::Samples(samples)),
        _ => Err("needed `auto` or a whole number of samples".into()),
    }
}

/// Subspace methods.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub enum Method {
    /// The weighting whose simulated output is best on the estimating part; B, D and x0 by least squares on that output
    Auto,
    /// Equations (13)-(17) of the paper: exact without noise only
    Paper,
    /// N4SID weighting
    N4sid,
    /// MOESP weighting
    Moesp,
    /// Canonical variate weighting
    Cva,
}

/// Errors that `--refine` makes small.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub enum Refinement {
    /// Of the output simulated from the input alone
    Simulated,
    /// Of the output predicted one sample ahead, with an innovations gain K
    Predicted,
}

impl Refinement {
    /// The name that files carry.
    pub fn name(self) -> &'static str {
        match self {
            Refinement::Simulated => "simulated",
            Refinement::Predicted => "predicted",
        }
    }
}

/// `flexbeam design`
#[derive(Args, Debug)]
pub struct Design {
    /// Model file
    pub model: PathBuf,
    /// Controlled output; psi is theta + alpha unless an output has that name
    #[arg(long = "output", default_value = "psi")]
    pub output_name: String,
    /// Which description of the model is the nominal plant
    #[arg(long, value_enum, default_value_t = Nominal::Auto)]
    pub nominal: Nominal,
    /// Rig file that describes the distributed beam for --uncertainty beam; the paper's by default
    #[arg(long)]
    pub rig: Option<PathBuf>,
    /// beta [1/s]: every closed-loop pole gets a real part below -beta
    #[arg(long)]
    pub stability_degree: f64,
    /// Bound alpha(s) on the neglected dynamics: a number [rad/V], `model` for the model file's own, or `beam` to cover the distributed beam
    #[arg(long, conflicts_with_all = ["uncertainty_num", "uncertainty_den"])]
    pub uncertainty: Option<String>,
    /// Numerator of alpha(s) in the shifted plane, highest power first [rad/V]
    #[arg(long, value_delimiter = ',', requires = "uncertainty_den")]
    pub uncertainty_num: Vec<f64>,
    /// Denominator of alpha(s), highest power first
    #[arg(long, value_delimiter = ',', requires = "uncertainty_num")]
    pub uncertainty_den: Vec<f64>,
    /// Answer only whether (22) is solvable
    #[arg(long)]
    pub robust_only: bool,
    /// needed | optimal | integral | K(0) in V/rad
    #[arg(long, default_value = "needed")]
    pub stiffness: String,
    /// Residual voltage v_res that `needed` stiffness answers [V]; from `rig test`
    #[arg(long, default_value_t = 0.0183)]
    pub residual_voltage: f64,
    /// Rise time of the reference model, 10 to 90 percent [s]; as fast as --max-voltage permits by default
    #[arg(long)]
    pub rise_time: Option<f64>,
    /// Overshoot of the reference model [percent]
    #[arg(long, default_value_t = 0.0)]
    pub overshoot: f64,
    /// Numerator of the reference model M(s), highest power first
    #[arg(long, value_delimiter = ',', requires = "reference_den", conflicts_with_all = ["rise_time"])]
    pub reference_num: Vec<f64>,
    /// Denominator of the reference model M(s)
    #[arg(long, value_delimiter = ',', requires = "reference_num")]
    pub reference_den: Vec<f64>,
    /// Voltage that the largest step may take [V]
    #[arg(long, default_value_t = 10.0)]
    pub max_voltage: f64,
    /// Largest step [degree]
    #[arg(long, default_value_t = 45.0)]
    pub max_step_deg: f64,
    /// Sample period [s]
    #[arg(long, default_value_t = 0.001)]
    pub period: f64,
    /// Time over which a step of the reference is smoothed [s]
    #[arg(long, default_value_t = 0.2)]
    pub smooth_step: f64,
    /// Cut-off of the measurement's low-pass filter [Hz]; none by default
    #[arg(long)]
    pub low_pass_hz: Option<f64>,
    /// The controller file to write
    #[arg(short, long, default_value = "controller.toml")]
    pub out: PathBuf,
    /// Write over a file that is not of the kind to be written
    #[arg(long)]
    pub force: bool,
    /// One JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// `flexbeam verify`
#[derive(Args, Debug)]
pub struct Verify {
    /// Controller file, or a project
    pub controller: PathBuf,
    /// Runs of the Monte Carlo on the simulated rig; 0 leaves it out
    #[arg(long, default_value_t = 1000)]
    pub runs: usize,
    /// Seed of the Monte Carlo
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Rig file; the project's by default, else the paper's rig
    #[arg(long)]
    pub rig: Option<PathBuf>,
    /// One JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// `flexbeam simulate`
#[derive(Args, Debug)]
pub struct Simulate {
    /// Controller file, or a project
    pub controller: PathBuf,
    /// Rig file; the project's by default, else the paper's rig with three modes
    #[arg(long)]
    pub rig: Option<PathBuf>,
    /// Step of the tip angle [degree]
    #[arg(long, default_value_t = 30.0)]
    pub step_deg: f64,
    /// Length [s]
    #[arg(long, default_value_t = 5.0)]
    pub duration: f64,
    /// Variable-structure law; that of the controller file by default
    #[arg(long, value_enum)]
    pub law: Option<Law>,
    /// The rig's linear lumped model: no modes, friction, dead zone, delay of sensors, quantisation or noise
    #[arg(long)]
    pub linear: bool,
    /// Seed of the sensor noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Folder for response.csv and the figures
    #[arg(short, long, default_value = "simulation")]
    pub out: PathBuf,
    /// One JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// Variable-structure laws of DESIGN section 7.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub enum Law {
    /// The controller's voltage goes to the rig as it is
    None,
    /// Figure 8 of the paper
    Switched,
    /// Inverse of the dead zone
    Inverse,
}

/// `flexbeam show`
#[derive(Args, Clone, Debug)]
pub struct Show {
    /// A recording, model, controller, certificate or rig file, or a project
    pub file: PathBuf,
    /// Names of a recording's columns, in order, in place of those in the file; _ leaves one out
    #[arg(long, value_delimiter = ',')]
    pub columns: Vec<String>,
    /// Sample period [s] of a recording without a time column
    #[arg(long)]
    pub period: Option<f64>,
    /// Interpolate a jittered time column to this period [s]
    #[arg(long)]
    pub resample: Option<f64>,
    /// Draw a run into this folder: angles, deflection, voltages, lateness
    #[arg(long)]
    pub plots: Option<PathBuf>,
    /// One JSON object on standard output
    #[arg(long)]
    pub json: bool,
}
