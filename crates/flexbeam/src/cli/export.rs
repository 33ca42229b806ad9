//! The arguments of `flexbeam export`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// `flexbeam export`
#[derive(Args, Debug)]
pub struct Export {
    /// A recording: the MCAP file of a run, or a table
    pub file: PathBuf,
    /// Form of the file to write
    #[arg(long = "as", value_enum)]
    pub form: Form,
    /// The file to write
    #[arg(short, long)]
    pub out: PathBuf,
    /// Names of a table's white-space columns, in order
    #[arg(long, value_delimiter = ',')]
    pub columns: Vec<String>,
    /// Sample period [s] of a table without a time column
    #[arg(long)]
    pub period: Option<f64>,
    /// Write over a file that is not of the kind to be written
    #[arg(long)]
    pub force: bool,
    /// One JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// Forms in which other tools read.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub enum Form {
    /// CSV with a header, all samples; a note beside it says where it came from
    Csv,
    /// MATLAB's level 5, a variable for each column; also read by scipy, Octave and Julia
    Mat,
}
