//! The local control socket: a Unix socket that only its owner may open, one JSON request a line.
//!
//! Real-time: no. It talks to the loop through [`Controls`] and [`LiveControl`] alone, like every other view.

use crate::controls::Controls;
use crate::kernel_settings::{table_of, with_table};
use crate::lifecycle::Phase;
use crate::live::{Live, LiveControl};
use crate::recording::{shape_of_file, shape_of_run};
use crate::sample::Sample;
use crate::view::Latest;
use flexbeam_files::{Reading, ReferenceChange, Reply, Request, json_text};
use std::fs::Permissions;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A request longer than this is no request [bytes].
const LONGEST_REQUEST: u64 = 64 * 1024;
/// A client that says nothing for so long is let go; it may come again.
const IDLE: Duration = Duration::from_secs(600);
/// Clients at a time.
const MOST_CLIENTS: usize = 16;

/// What the socket speaks for.
#[derive(Clone)]
pub struct Steering {
    /// To start and stop.
    pub controls: Controls,
    /// To change settings.
    pub live: LiveControl,
    /// To say how it stands.
    pub latest: Latest,
    /// Sample period [s].
    pub period_s: f64,
}

/// A socket that listens; its file goes with it.
#[derive(Debug)]
pub struct ControlSocket {
    path: PathBuf,
}

/// A socket that cannot be opened.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot open the control socket {}: found {reason}, needed a place for a new socket\nhint: another run may use that name; --control names another one", .path.display())]
pub struct NoSocket {
    /// Where.
    pub path: PathBuf,
    /// What the system says.
    pub reason: String,
}

impl ControlSocket {
    /// Listens until it is dropped; each client has a thread of its own.
    ///
    /// Errors: [`NoSocket`]. A socket that a dead run left behind is replaced, a living one is not.
    pub fn open(path: &Path, steering: Steering) -> Result<ControlSocket, NoSocket> {
        let refused = |error: io::Error| NoSocket { path: path.to_path_buf(), reason: error.to_string() };
        if UnixStream::connect(path).is_err_and(|error| error.kind() == io::ErrorKind::ConnectionRefused) {
            std::fs::remove_file(path).map_err(refused)?;
        }
        let listener = UnixListener::bind(path).map_err(refused)?;
        let socket = ControlSocket { path: path.to_path_buf() };
        std::fs::set_permissions(path, Permissions::from_mode(0o600)).map_err(refused)?;
        let thread = std::thread::Builder::new().name("flexbeam-control".into());
        thread.spawn(move || listen(&listener, &steering)).map_err(refused)?;
        Ok(socket)
    }
}

impl Drop for ControlSocket {
    fn drop(&mut self) {
        // Gone already when somebody tidied up.
        let _ = std::fs::remove_file(&self.path);
    }
}

fn listen(listener: &UnixListener, steering: &Steering) {
    let clients = std::sync::Arc::new(());
    for stream in listener.incoming().flatten() {
        if std::sync::Arc::strong_count(&clients) > MOST_CLIENTS {
            continue; // the stream closes, which tells the client
        }
        let (guest, steering) = (clients.clone(), steering.clone());
        let thread = std::thread::Builder::new().name("flexbeam-client".into());
        // Without a thread the client sees a closed stream.
        let _ = thread.spawn(move || {
            let _guest = guest;
            let _ = serve(stream, &steering);
        });
    }
}

/// Until the client leaves, idles for too long or sends a line without end.
fn serve(stream: UnixStream, steering: &Steering) -> io::Result<()> {
    stream.set_read_timeout(Some(IDLE))?;
    let mut answers = stream.try_clone()?;
    let mut requests = BufReader::new(stream);
    let mut line = String::new();
    while (&mut requests).take(LONGEST_REQUEST).read_line(&mut line)? > 0 {
        if !line.ends_with('\n') && line.len() as u64 == LONGEST_REQUEST {
            let told = format!("found a request of more than {LONGEST_REQUEST} bytes, needed a short one");
            return writeln!(answers, "{}", json_text(&refusal(steering, told)));
        }
        writeln!(answers, "{}", json_text(&steering.answer(line.trim_end())))?;
        line.clear();
    }
    Ok(())
}

fn refusal(steering: &Steering, error: String) -> Reply {
    Reply { ok: false, error: Some(error), ..steering.plain() }
}

impl Steering {
    /// The reply to a line.
    pub fn answer(&self, line: &str) -> Reply {
        match Request::parse(line) {
            Ok(request) => self.obey(&request),
            Err(error) => {
                let hint = "hint: {\"do\":\"status\"}, or set, start, stop, emergency; the book lists the keys";
                refusal(self, format!("found a request that is none ({error}), needed one JSON object a line\n{hint}"))
            }
        }
    }

    /// Does what is asked.
    pub fn obey(&self, request: &Request) -> Reply {
        match request {
            Request::Status => return self.status(),
            Request::Start => self.controls.start(),
            Request::Stop => self.controls.stop(),
            Request::Emergency => self.controls.emergency(),
            Request::Set { settings, reference } => {
                let change = |live: &mut Live| {
                    live.settings = with_table(&live.settings, settings);
                    change_reference(live, reference);
                };
                if let Err(refused) = self.live.change(change) {
                    return refusal(self, refused.to_string());
                }
            }
        }
        self.plain()
    }

    fn plain(&self) -> Reply {
        let (phase, revision) = (self.controls.phase().name().into(), self.live.current().revision);
        Reply { ok: true, phase, revision, ..Reply::default() }
    }

    fn status(&self) -> Reply {
        let live = self.live.current();
        let last = self.latest.get().filter(|s| s.phase != Phase::Configured).map(|s| self.reading(&s));
        Reply { last, settings: Some(table_of(&live.settings)), reference: Some(reference_of(&live)), ..self.plain() }
    }

    fn reading(&self, sample: &Sample) -> Reading {
        Reading {
            time_s: sample.instant as f64 * self.period_s,
            reference_rad: sample.reference_rad,
            psi_rad: sample.commanded.y_rad,
            alpha_rad: sample.measured.alpha_rad,
            voltage_v: sample.voltage_v,
        }
    }
}

fn reference_of(live: &Live) -> ReferenceChange {
    ReferenceChange {
        shape: Some(shape_of_run(live.reference.shape)),
        amplitude_rad: Some(live.reference.amplitude_rad),
        period_s: Some(live.reference.period_s),
        offset_rad: Some(live.reference.offset_rad),
    }
}

/// The reference with a change; what is left out stays.
pub fn change_reference(live: &mut Live, change: &ReferenceChange) {
    let reference = &mut live.reference;
    reference.shape = change.shape.map_or(reference.shape, shape_of_file);
    reference.amplitude_rad = change.amplitude_rad.unwrap_or(reference.amplitude_rad);
    reference.period_s = change.period_s.unwrap_or(reference.period_s);
    reference.offset_rad = change.offset_rad.unwrap_or(reference.offset_rad);
}
