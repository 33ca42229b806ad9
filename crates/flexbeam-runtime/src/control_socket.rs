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
use nix::sys::socket::{Shutdown, shutdown};
use nix::sys::stat::{Mode, umask};
use std::collections::VecDeque;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::os::fd::AsRawFd;
use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// A request longer than this is no request [bytes].
const LONGEST_REQUEST: u64 = 64 * 1024;
/// A client that says nothing for so long is let go; it may come again.
const IDLE: Duration = Duration::from_secs(600);
/// A client that does not take its answers for so long is let go.
const SLOW: Duration = Duration::from_secs(10);
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

/// A socket whose place is taken, and that does not listen yet.
#[derive(Debug)]
pub struct BoundSocket {
    path: PathBuf,
    listener: UnixListener,
    /// Device and number of its file, by which it is told from another run's under the same name.
    file: Option<(u64, u64)>,
}

/// A socket that listens; its file, its threads and its clients go with it.
#[derive(Debug)]
pub struct ControlSocket {
    bound: BoundSocket,
    guests: Guests,
}

/// A socket that cannot be opened.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot open the control socket {}: found {reason}, needed a place for a new socket\nhint: the folder must exist, and the name be free and shorter than 108 bytes; --control names another one", .path.display())]
pub struct NoSocket {
    /// Where.
    pub path: PathBuf,
    /// What the system says.
    pub reason: String,
}

impl BoundSocket {
    /// Takes the place, for this user alone. A socket that a dead run left behind is replaced; a living one and any other file are
    /// not.
    ///
    /// Errors: [`NoSocket`].
    pub fn bind(path: &Path) -> Result<BoundSocket, NoSocket> {
        let refused = |error: io::Error| NoSocket { path: path.to_path_buf(), reason: error.to_string() };
        if is_left_behind(path) {
            std::fs::remove_file(path).map_err(refused)?;
        }
        // The file never stands there for others to open, not even before its permissions could be changed.
        let before = umask(Mode::S_IRWXG | Mode::S_IRWXO);
        let listener = UnixListener::bind(path);
        umask(before);
        let listener = listener.map_err(refused)?;
        Ok(BoundSocket { path: path.to_path_buf(), listener, file: identity(path) })
    }

    /// Listens until the value is dropped; each client has a thread of its own.
    ///
    /// Errors: [`NoSocket`] when there is no thread to be had.
    pub fn serve(self, steering: Steering) -> Result<ControlSocket, NoSocket> {
        let refused = |error: io::Error| NoSocket { path: self.path.clone(), reason: error.to_string() };
        let listener = self.listener.try_clone().map_err(refused)?;
        let guests = Guests::default();
        let seats = guests.clone();
        let thread = std::thread::Builder::new().name("flexbeam-control".into());
        thread.spawn(move || listen(&listener, &steering, &seats)).map_err(refused)?;
        Ok(ControlSocket { bound: self, guests })
    }
}

impl ControlSocket {
    /// Takes the place and listens.
    ///
    /// Errors: those of [`BoundSocket::bind`] and [`BoundSocket::serve`].
    pub fn open(path: &Path, steering: Steering) -> Result<ControlSocket, NoSocket> {
        BoundSocket::bind(path)?.serve(steering)
    }
}

fn is_left_behind(path: &Path) -> bool {
    let is_socket = std::fs::symlink_metadata(path).is_ok_and(|file| file.file_type().is_socket());
    is_socket && UnixStream::connect(path).is_err_and(|error| error.kind() == io::ErrorKind::ConnectionRefused)
}

fn identity(path: &Path) -> Option<(u64, u64)> {
    std::fs::symlink_metadata(path).ok().map(|file| (file.dev(), file.ino()))
}

impl Drop for BoundSocket {
    fn drop(&mut self) {
        if self.file.is_some() && identity(&self.path) == self.file {
            // Gone already when somebody tidied up.
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

impl Drop for ControlSocket {
    fn drop(&mut self) {
        self.guests.close();
        // Wakes the thread that waits for the next client.
        let _ = shutdown(self.bound.listener.as_raw_fd(), Shutdown::Both);
    }
}

/// The clients that are there. When all seats are taken the newest gets the oldest one's: an emergency stop always gets in.
#[derive(Clone, Debug, Default)]
struct Guests(Arc<Mutex<Seats>>);

#[derive(Debug, Default)]
struct Seats {
    closed: bool,
    seats: VecDeque<(u64, UnixStream)>,
    next: u64,
}

impl Guests {
    fn lock(&self) -> std::sync::MutexGuard<'_, Seats> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A seat's number; nothing when the house is closed.
    fn seat(&self, stream: &UnixStream) -> Option<u64> {
        let mut seats = self.lock();
        let stream = stream.try_clone().ok().filter(|_| !seats.closed)?;
        if seats.seats.len() >= MOST_CLIENTS
            && let Some((_, oldest)) = seats.seats.pop_front()
        {
            let _ = oldest.shutdown(std::net::Shutdown::Both);
        }
        let number = seats.next;
        seats.next += 1;
        seats.seats.push_back((number, stream));
        Some(number)
    }

    fn leave(&self, number: u64) {
        self.lock().seats.retain(|(seat, _)| *seat != number);
    }

    fn close(&self) {
        let mut seats = self.lock();
        seats.closed = true;
        for (_, stream) in seats.seats.drain(..) {
            let _ = stream.shutdown(std::net::Shutdown::Both);
        }
    }

    fn is_closed(&self) -> bool {
        self.lock().closed
    }
}

fn listen(listener: &UnixListener, steering: &Steering, guests: &Guests) {
    while !guests.is_closed() {
        let Ok((stream, _)) = listener.accept() else {
            // Out of descriptors, say: a short rest, and the next client may have better luck.
            std::thread::sleep(Duration::from_millis(20));
            continue;
        };
        let Some(seat) = guests.seat(&stream) else { continue };
        let (host, steering) = (guests.clone(), steering.clone());
        let thread = std::thread::Builder::new().name("flexbeam-client".into());
        let seated = thread.spawn(move || {
            let _ = serve(stream, &steering);
            host.leave(seat);
        });
        if seated.is_err() {
            guests.leave(seat); // the stream closes, which tells the client
        }
    }
}

/// Until the client leaves, idles for too long or sends a line without end.
fn serve(stream: UnixStream, steering: &Steering) -> io::Result<()> {
    stream.set_read_timeout(Some(IDLE))?;
    stream.set_write_timeout(Some(SLOW))?;
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

/// The reference with a change; what is left out stays. The amplitude of a file is a factor, any other's an angle: a change from one
/// to the other without an amplitude goes on with the file's largest angle, or with the file as it is.
pub fn change_reference(live: &mut Live, change: &ReferenceChange) {
    let reference = &mut live.reference;
    let shape = change.shape.map_or(reference.shape, shape_of_file);
    reference.amplitude_rad = change.amplitude_rad.unwrap_or_else(|| reference.amplitude_as(shape));
    reference.shape = shape;
    reference.period_s = change.period_s.unwrap_or(reference.period_s);
    reference.offset_rad = change.offset_rad.unwrap_or(reference.offset_rad);
}
