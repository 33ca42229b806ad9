//! The command line of the scope.

use std::path::PathBuf;

use clap::Args;
use flexbeam_runtime::ViewerAddress;

/// Where the scope is served.
#[derive(Args, Clone, Debug)]
pub struct Scope {
    /// Serve the scope, a page in the browser, at this address; a port alone is on this machine only
    #[arg(long, value_name = "HOST:PORT", num_args = 0..=1, default_missing_value = "127.0.0.1:8787")]
    pub scope: Option<ViewerAddress>,
    /// File with the token that lets a viewer steer; made for you alone when it is missing, and a new one for each run by default
    #[arg(long, value_name = "FILE")]
    pub scope_token_file: Option<PathBuf>,
}
