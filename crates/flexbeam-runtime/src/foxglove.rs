//! Live topics and settings for Foxglove, and for whatever else speaks its protocol over a WebSocket.
//!
//! Enters: what the recorder brings; changes that viewers ask for. Leaves: the topics of a recording while they come, each message
//! with the bytes and the time that it has in the file; every live setting as a parameter.
//! Deliberately absent: the loop, which hears of a viewer only through [`LiveControl`](crate::LiveControl); a token, which the
//! protocol has no place for, so that viewers look and do not touch unless a person says otherwise.
//!
//! Real-time: no. A viewer that is slow loses its oldest messages, and nobody waits for it.

mod parameters;
mod refusal;
mod topics;

use crate::address::ViewerAddress;
use crate::control_socket::Steering;
use crate::session::Notes;
use ::foxglove::{Context, FoxgloveError, WebSocketServerHandle};
use flexbeam_files::RunHeader;
use parameters::Parameters;
use std::io;
use std::sync::Arc;
use std::time::Duration;
use tokio::runtime::{Builder, Runtime};
use topics::{Decimation, Topics};

pub use topics::ViewerSink;

/// Messages that wait for a viewer before its oldest are thrown away: two seconds of samples, a third of a megabyte. As many
/// answers may wait; a viewer that lets more of them lie is let go.
const BACKLOG: usize = 2048;
/// How long the last messages of a run may be on their way.
const LAST_WORDS: Duration = Duration::from_millis(200);
/// How long a viewer may take to say goodbye.
const FAREWELL: Duration = Duration::from_millis(500);
/// Stack of the thread that serves viewers; all of it is locked with the rest of the memory.
const STACK: usize = 1 << 20;

/// What viewers get, and what they may.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewerOptions {
    /// Samples that go out, at most [1/s]. Default 1000.
    pub most_per_s: f64,
    /// Default [`ViewersMay::Look`].
    pub may: ViewersMay,
}

/// What whoever reaches the address may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ViewersMay {
    /// Topics and parameters, to read.
    Look,
    /// Besides, every live setting, to change.
    Set,
}

impl Default for ViewerOptions {
    fn default() -> ViewerOptions {
        ViewerOptions { most_per_s: 1000.0, may: ViewersMay::Look }
    }
}

/// Viewers that cannot be served.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoViewers {
    /// The rate.
    #[error("found {0} samples a second for viewers, needed a positive number\nhint: 1000 by default")]
    Rate(f64),
    /// The system.
    #[error(
        "cannot serve viewers at {address}: found {reason}, needed an address of this machine with a free port\nhint: another run may have the port; 0 takes one that is free"
    )]
    Refused {
        /// Where.
        address: String,
        /// What the system says.
        reason: String,
    },
}

/// A server that viewers connect to, until it is dropped.
pub struct Viewers {
    /// Until it is dropped.
    runtime: Option<Runtime>,
    topics: Arc<Topics>,
    parameters: Arc<Parameters>,
    address: ViewerAddress,
    options: ViewerOptions,
}

impl Viewers {
    /// Real-time: no. Listens at the address, with a thread of its own.
    ///
    /// Errors: [`NoViewers::Rate`], [`NoViewers::Refused`].
    pub fn open(address: &ViewerAddress, options: ViewerOptions) -> Result<Viewers, NoViewers> {
        if !(options.most_per_s > 0.0 && options.most_per_s.is_finite()) {
            return Err(NoViewers::Rate(options.most_per_s));
        }
        let refused = |reason: String| NoViewers::Refused { address: address.to_string(), reason };
        let runtime = runtime().map_err(|error| refused(error.to_string()))?;
        let context = Context::new();
        let topics = Arc::new(Topics::new(&context).map_err(|error| refused(error.to_string()))?);
        let parameters = Arc::new(Parameters::new(options.may));
        let server = context.websocket_server().name("flexbeam").bind(address.host(), address.port());
        let server = server.message_backlog_size(BACKLOG);
        let server = server.listener(topics.clone()).parameter_handler(parameters.clone());
        let server = runtime.block_on(server.start()).map_err(|error| refused(reason(error)))?;
        let address = address.with_port(server.port());
        parameters.serve(server);
        Ok(Viewers { runtime: Some(runtime), topics, parameters, address, options })
    }

    /// Real-time: no. Where they connect, with the port that was taken.
    pub fn address(&self) -> &ViewerAddress {
        &self.address
    }

    /// Real-time: no. What they may.
    pub fn may(&self) -> ViewersMay {
        self.options.may
    }

    /// Real-time: no. What brings them a run, with the recording's times.
    pub fn sink(&self, header: &RunHeader) -> ViewerSink {
        let decimation = Decimation::new(header.period_s, self.options.most_per_s);
        ViewerSink::new(self.topics.clone(), self.parameters.clone(), header, decimation)
    }

    /// Real-time: no. From here on parameters are those of this run; refused changes go into its recording, some of them.
    pub fn steer(&self, steering: Steering, notes: Notes) {
        self.parameters.steer(steering, notes);
    }
}

/// Waits for viewers that read, for a moment; one that does not is left behind.
impl Drop for Viewers {
    fn drop(&mut self) {
        let Some(runtime) = self.runtime.take() else { return };
        if let Some(server) = self.parameters.close() {
            farewell(&runtime, server);
        }
        runtime.shutdown_timeout(FAREWELL);
    }
}

fn farewell(runtime: &Runtime, server: WebSocketServerHandle) {
    if server.client_count() > 0 {
        std::thread::sleep(LAST_WORDS);
    }
    let stopped = server.stop();
    // A viewer that takes longer is cut off with the threads.
    let _ = runtime.block_on(async { tokio::time::timeout(FAREWELL, stopped.wait()).await });
}

/// One thread: it has little to do, and the loop may need the other cores.
fn runtime() -> io::Result<Runtime> {
    let mut threads = Builder::new_multi_thread();
    threads.worker_threads(1).thread_name("flexbeam-viewers").thread_stack_size(STACK);
    threads.enable_io().enable_time().build()
}

fn reason(error: FoxgloveError) -> String {
    match error {
        FoxgloveError::Bind(error) => error.to_string(),
        other => other.to_string(),
    }
}
