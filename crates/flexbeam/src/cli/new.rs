//! The command line of `flexbeam new`.

use std::path::PathBuf;

use clap::Args;

/// `flexbeam new`
#[derive(Args, Debug)]
pub struct New {
    /// The project's folder: not there yet, or empty
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// What the project is called; like its folder by default
    #[arg(long)]
    pub name: Option<String>,
    /// Rig file that goes into it; the paper's rig by default
    #[arg(long)]
    pub rig: Option<PathBuf>,
    /// One JSON object on standard output
    #[arg(long)]
    pub json: bool,
}
