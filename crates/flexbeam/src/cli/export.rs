//! The arguments of `flexbeam export`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// `flexbeam export`
#[derive(Args, Debug)]
pub struct Export {
    /// A recording (the MCAP file of a run, or a table) as csv or mat; a model as mat or json; a controller as mat, json, c,
    /// rust or fmu; a rig file, or the word `paper` for the paper's rig, as fmu
    pub file: PathBuf,
    /// Form to write
    #[arg(long = "as", value_enum)]
    pub form: Form,
    /// The file to write; for c and rust, the folder
    #[arg(short, long)]
    pub out: PathBuf,
    /// Names of a table's columns, in order, in place of those in the file; _ leaves one out
    #[arg(long, value_delimiter = ',')]
    pub columns: Vec<String>,
    /// Sample period [s] of a table without a time column
    #[arg(long)]
    pub period: Option<f64>,
    /// Interpolate a jittered time column of a table to this period [s]
    #[arg(long)]
    pub resample: Option<f64>,
    /// Precision of a controller's arithmetic: f64 (as simulated and verified) or f32
    #[arg(long, value_enum)]
    pub precision: Option<Precision>,
    /// Name of the files, types and functions of a controller (`controller` by default) or a rig (`rig`)
    #[arg(long)]
    pub name: Option<String>,
    /// Version of the functional mock-up interface: 2 or 3
    #[arg(long, value_enum)]
    pub fmi: Option<Fmi>,
    /// Leave the binary out of an FMU: whoever imports it compiles the sources
    #[arg(long)]
    pub sources_only: bool,
    /// Write a controller whose certificate does not match its numbers, for this reason
    #[arg(long, value_name = "REASON")]
    pub unverified: Option<String>,
    /// Write over a file that is not of the kind to be written, or into a folder that is not empty
    #[arg(long)]
    pub force: bool,
    /// One JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

impl Export {
    /// The name given, or this one.
    pub fn name_or<'a>(&'a self, default: &'a str) -> &'a str {
        self.name.as_deref().unwrap_or(default)
    }
}

/// The name of a controller that nobody named.
pub const DEFAULT_NAME: &str = "controller";

/// Forms in which other tools read.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub enum Form {
    /// CSV with a header, all samples; a note beside it says where it came from
    Csv,
    /// MATLAB's level 5, a variable for each column or key, with a script that rebuilds the loop; also read by scipy, Octave and
    /// Julia
    Mat,
    /// A model or a controller as JSON, with the keys of its file
    Json,
    /// The controller as C99: header, source, test vectors, a program for the UDP frame
    C,
    /// The controller as a no_std crate, with test vectors
    Rust,
    /// A controller or a rig as a functional mock-up unit for co-simulation: one archive with sources and a binary
    Fmu,
}

/// Version of the functional mock-up interface.
#[derive(Clone, Copy, Debug, Default, PartialEq, ValueEnum)]
pub enum Fmi {
    /// FMI 2.0, which most tools read
    #[default]
    #[value(name = "2")]
    Two,
    /// FMI 3.0
    #[value(name = "3")]
    Three,
}

impl From<Fmi> for flexbeam_codegen::fmu::Version {
    fn from(fmi: Fmi) -> Self {
        match fmi {
            Fmi::Two => flexbeam_codegen::fmu::Version::Two,
            Fmi::Three => flexbeam_codegen::fmu::Version::Three,
        }
    }
}

/// Precision of all arithmetic of a controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, ValueEnum)]
pub enum Precision {
    /// 64 bits: every bit as in simulation and verification
    #[default]
    F64,
    /// 32 bits: for processors without 64-bit arithmetic
    F32,
}

impl From<Precision> for flexbeam_codegen::Precision {
    fn from(precision: Precision) -> Self {
        match precision {
            Precision::F64 => flexbeam_codegen::Precision::F64,
            Precision::F32 => flexbeam_codegen::Precision::F32,
        }
    }
}
