//! The command line of live topics and parameters.

use clap::Args;
use flexbeam_runtime::ViewerAddress;

/// Viewers of a run.
#[derive(Args, Clone, Debug)]
pub struct Viewers {
    /// Serve live topics and parameters over the Foxglove WebSocket protocol: PORT or HOST:PORT, such as 127.0.0.1:8765; port 0
    /// takes one that is free
    #[arg(long, value_name = "ADDRESS")]
    pub foxglove: Option<ViewerAddress>,
    /// Samples that go out to viewers, at most [1/s]
    #[arg(long, default_value_t = 1000.0, requires = "foxglove", value_name = "RATE")]
    pub foxglove_rate: f64,
    /// Let every viewer change settings, without a token
    #[arg(long, requires = "foxglove")]
    pub foxglove_set: bool,
}
