//! The scope: a page in the browser that shows a run and steers it, and the server behind it.
//!
//! Enters: what the recorder brings; what viewers with the run's token ask for. Leaves: the page, every sample, the state, events;
//! wishes to the loop, through [`Steering`] alone. Deliberately absent: the loop's thread, which waits for nobody here and shares no
//! lock with the server; encryption: the address is the loopback's unless a person says otherwise.
//!
//! Real-time: no. One thread of plain priority serves everybody. A viewer that is slow queues nothing: each has its place in one
//! ring of bounded length, and learns what it has lost.

mod chronicle;
mod door;
mod hall;
mod history;
mod knobs;
mod page;
mod requests;
mod seats;
mod signals;
mod sink;
mod token;
mod told;
mod viewer;

pub use knobs::knobs;
pub use sink::ScopeSink;
pub use token::{NoToken, Token};

use crate::address::ViewerAddress;
use crate::control_socket::Steering;
use crate::recording::RunContext;
use crate::session::Notes;
use flexbeam_files::{CertificateSummary, LiveSettings, RunHeader, Screen};
use hall::Hall;
use std::fmt;
use std::io;
use std::net::TcpListener;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tokio::runtime::{Builder, Runtime};
use tokio::sync::oneshot;

/// Stack of the thread that serves; all of it is locked with the rest of the memory.
const STACK: usize = 1 << 20;
/// How much the thread stands back behind others of plain priority.
const NICE: i32 = 5;
/// How long viewers have at the end to take the rest of a run.
const LAST_WORDS: Duration = Duration::from_millis(1500);

/// Saves scopes, panels and settings into a project; what is wrong comes back in words.
pub type Save = Box<dyn Fn(&Screen, &LiveSettings) -> Result<(), String> + Send + Sync>;

/// What viewers are told of a run.
pub struct About {
    /// The controller's file.
    pub controller: String,
    /// The project's name.
    pub project: Option<String>,
    /// The rig.
    pub port: String,
    /// Sample period [s].
    pub period_s: f64,
    /// The controller's certificate in short.
    pub certificate: Option<CertificateSummary>,
    /// Where the run is recorded.
    pub recording: Option<PathBuf>,
    /// Scopes and panels at the start.
    pub screen: Screen,
    /// Where to save; nothing: nowhere.
    pub save: Option<Save>,
    /// What a stop sets while the rig is homed, before there is a run to stop.
    pub asked: Arc<AtomicBool>,
}

/// A scope that cannot be served.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "cannot serve the scope at {address}: found {reason}, needed an address of this machine with a free port\nhint: another run may have the port; --scope 0 takes one that is free"
)]
pub struct NoScope {
    /// Where.
    pub address: String,
    /// What the system says.
    pub reason: String,
}

/// A server that listens until it is dropped.
pub struct ScopeServer {
    hall: Arc<Hall>,
    address: ViewerAddress,
    /// Both until it is dropped.
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl ScopeServer {
    /// Real-time: no. Listens at the address, with a thread of its own; viewers are told that the run is not armed yet.
    ///
    /// Errors: [`NoScope`].
    pub fn open(address: &ViewerAddress, token: Token, about: About) -> Result<ScopeServer, NoScope> {
        let refused = |error: io::Error| NoScope { address: address.to_string(), reason: error.to_string() };
        let listener = TcpListener::bind(address.to_string()).map_err(refused)?;
        listener.set_nonblocking(true).map_err(refused)?;
        let port = listener.local_addr().map_err(refused)?.port();
        let address = address.with_port(port);
        let runtime = Builder::new_current_thread().enable_io().enable_time().build().map_err(refused)?;
        let hall = Arc::new(Hall::new(about, token, address.host().into()));
        let (stop, stopped) = oneshot::channel();
        let guests = hall.clone();
        let thread = std::thread::Builder::new().name("flexbeam-scope".into()).stack_size(STACK);
        let thread = thread.spawn(move || serve(&runtime, listener, guests, stopped)).map_err(refused)?;
        Ok(ScopeServer { hall, address, stop: Some(stop), thread: Some(thread) })
    }

    /// Real-time: no. Where it listens, with the port that was taken.
    pub fn address(&self) -> &ViewerAddress {
        &self.address
    }

    /// Real-time: no. What to open in a browser to steer: the token stands behind #, which no browser sends.
    pub fn url(&self) -> String {
        format!("http://{}/#{}", self.address, self.hall.token)
    }

    /// Real-time: no. What brings viewers a run.
    pub fn sink(&self, header: &RunHeader) -> ScopeSink {
        self.hall.chronicle().start_unix_ns = header.start_unix_ns;
        ScopeSink::new(self.hall.clone(), RunContext { port: header.port.clone(), period_s: header.period_s })
    }

    /// Real-time: no. From here on viewers with the token may steer this run; what is refused, and who steers, goes into its
    /// recording.
    pub fn steer(&self, steering: Steering, notes: Notes) {
        self.hall.steer(steering, notes);
    }
}

/// Not the token.
impl fmt::Debug for ScopeServer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ScopeServer").field("address", &self.address).finish_non_exhaustive()
    }
}

/// Viewers that read get the rest of the run; one that does not is left behind.
impl Drop for ScopeServer {
    fn drop(&mut self) {
        self.hall.closing.store(true, Ordering::Relaxed);
        let end = Instant::now() + LAST_WORDS;
        while self.hall.seats(|seats, _| seats.count()) > 0 && Instant::now() < end {
            std::thread::sleep(Duration::from_millis(5));
        }
        self.stop.take().map(|stop| stop.send(()));
        if let Some(thread) = self.thread.take() {
            // A panic of the server is told by the panic itself; the run is over.
            let _ = thread.join();
        }
    }
}

fn serve(runtime: &Runtime, listener: TcpListener, hall: Arc<Hall>, stopped: oneshot::Receiver<()>) {
    stand_back();
    runtime.block_on(async {
        match tokio::net::TcpListener::from_std(listener) {
            Ok(listener) => tokio::select! {
                () = door::admit(listener, hall) => {}
                _ = stopped => {}
            },
            Err(error) => eprintln!("warning: the scope is not served ({error})"),
        }
    });
}

/// Behind other threads of plain priority, where the system permits it: nothing depends on it.
fn stand_back() {
    // SAFETY: no memory is involved; on Linux 0 is the calling thread.
    unsafe { libc::setpriority(libc::PRIO_PROCESS, 0, NICE) };
}
