//! A rig behind a serial line, from both ends; a pseudo-terminal is one, too.
//!
//! Enters: the path of a device. Leaves: a back end for the host ([`SerialRig`]), a wire for the rig ([`SerialWire`]).
//! Deliberately absent: flow control. At the baud rates that a loop needs, waiting is losing.

use crate::back_end::OpenError;
use crate::framed::FramedRig;
use crate::line::{LineReader, Stuffed};
use crate::wire::{Broken, FrameBuffer, HostWire, Received, Wire};
use nix::errno::Errno;
use nix::sys::termios::{self, ControlFlags, FlushArg, SetArg, SpecialCharacterIndices};
use std::cell::Cell;
use std::fs::File;
use std::io::{self, Read, Write};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, OwnedFd};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Baud rate where none is named.
pub const DEFAULT_BAUD: u32 = 921_600;

/// The speeds that a line may have [baud].
pub const SPEEDS: [u32; 18] = [
    9_600, 19_200, 38_400, 57_600, 115_200, 230_400, 460_800, 500_000, 576_000, 921_600, 1_000_000, 1_152_000,
    1_500_000, 2_000_000, 2_500_000, 3_000_000, 3_500_000, 4_000_000,
];

/// How far from the speed asked for a device may be: with more, the last of a byte's bits is read in its neighbour's place.
const SPEED_TOLERANCE: f64 = 0.02;

const HINT: &str = "start the rig first, then check the device, the cable, and that both ends have one baud rate";

/// Bytes that one system call takes from the line.
const CHUNK: usize = 512;

/// A rig at a serial device.
///
/// The line is raw: 8 data bits, no parity, one stop bit, no flow control. What lay in it when it was opened is thrown away.
pub type SerialRig = FramedRig<SerialWire>;

impl SerialRig {
    /// Real-time: no. `device` is a path such as `/dev/ttyUSB0`, `baud` one of [`SPEEDS`]; the seed has to differ from
    /// run to run, see [`FramedRig`].
    ///
    /// Errors: no such device, no permission, another program on it, not a serial line, a speed that it has not.
    pub fn open(device: &Path, baud: u32, seed: u64) -> Result<SerialRig, OpenError> {
        let name = format!("serial:{}:{baud}", device.display());
        Ok(FramedRig::new(SerialWire::open(device, baud)?, name, HINT, seed))
    }
}

/// One end of a serial line.
pub struct SerialWire {
    file: Arc<File>,
    reader: LineReader,
    chunk: [u8; CHUNK],
    /// What of the chunk has not been read yet.
    unread: std::ops::Range<usize>,
    /// Whether half a frame may lie on the line.
    torn: Cell<bool>,
    /// Keeps a pseudo-terminal alive between two hosts.
    _other_end: Option<OwnedFd>,
}

impl SerialWire {
    /// Real-time: no. The line at `device`, cleared and for this program alone.
    ///
    /// Errors: as [`SerialRig::open`].
    pub fn open(device: &Path, baud: u32) -> Result<SerialWire, OpenError> {
        check_speed(baud)?;
        let tried = |error: io::Error| OpenError {
            found: format!("no way to use {} ({error})", device.display()),
            needed: "a serial line that this user may read and write, and no other program has".into(),
            hint: "`ls -l /dev/serial/by-id` shows what is plugged in; most systems let the group dialout use it"
                .into(),
        };
        let file = opened(device).map_err(tried)?;
        made_raw(&file).and_then(|()| set_speed(&file, baud)).map_err(tried)?;
        termios::tcflush(&file, FlushArg::TCIOFLUSH).map_err(|errno| tried(errno.into()))?;
        Ok(SerialWire::over(file, None))
    }

    /// Real-time: no. The rig's end of a new pseudo-terminal, and the device at which a host opens the other.
    ///
    /// Errors: the system has no pseudo-terminal left.
    pub fn pseudo_terminal() -> Result<(SerialWire, PathBuf), OpenError> {
        pseudo_terminal().map_err(|error| OpenError {
            found: format!("no pseudo-terminal to be had ({error})"),
            needed: "one".into(),
            hint: "is /dev/pts mounted? UDP needs nothing of the kind".into(),
        })
    }

    /// Real-time: no.
    fn over(file: File, other_end: Option<OwnedFd>) -> SerialWire {
        SerialWire {
            file: Arc::new(file),
            reader: LineReader::default(),
            chunk: [0; CHUNK],
            unread: 0..0,
            torn: Cell::new(true),
            _other_end: other_end,
        }
    }

    /// Real-time: yes. The next frame that ends within what has been taken from the line.
    fn next_frame(&mut self, buffer: &mut FrameBuffer) -> Option<usize> {
        for at in self.unread.by_ref() {
            let Some(frame) = self.chunk.get(at).and_then(|&byte| self.reader.push(byte)) else { continue };
            for (to, from) in buffer.iter_mut().zip(frame) {
                *to = *from;
            }
            return Some(frame.len());
        }
        None
    }
}

impl Wire for SerialWire {
    /// Real-time: yes. Where half a frame may lie on the line, a zero closes it first.
    fn send(&self, frame: &[u8]) -> Result<(), Broken> {
        let Some(stuffed) = Stuffed::new(frame) else { return Ok(()) };
        let bytes = if self.torn.get() { stuffed.closing() } else { stuffed.plain() };
        let written = (&*self.file).write(bytes).or_else(|error| Broken::unless_passing(&error, 0))?;
        self.torn.set(written != bytes.len() && (written > 0 || self.torn.get()));
        Ok(())
    }

    /// Real-time: yes.
    fn receive(&mut self, buffer: &mut FrameBuffer) -> Result<Received, Broken> {
        if let Some(length) = self.next_frame(buffer) {
            return Ok(Received::Frame(length));
        }
        match (&*self.file).read(&mut self.chunk) {
            // The line was hung up: a terminal without data answers EAGAIN.
            Ok(0) => Err(Broken { errno: Errno::EIO as i32 }),
            Ok(length) => {
                self.unread = 0..length;
                Ok(self.next_frame(buffer).map_or(Received::Nothing, Received::Frame))
            }
            Err(error) => Broken::unless_passing(&error, Received::Nothing),
        }
    }

    /// Real-time: yes.
    fn descriptor(&self) -> BorrowedFd<'_> {
        self.file.as_fd()
    }
}

impl HostWire for SerialWire {
    /// Real-time: no. Closes whatever the first was about to send.
    fn second(&self) -> SerialWire {
        SerialWire {
            file: Arc::clone(&self.file),
            reader: LineReader::default(),
            chunk: [0; CHUNK],
            unread: 0..0,
            torn: Cell::new(true),
            _other_end: None,
        }
    }
}

/// Real-time: no.
fn check_speed(baud: u32) -> Result<(), OpenError> {
    if SPEEDS.contains(&baud) {
        return Ok(());
    }
    Err(OpenError {
        found: format!("a speed of {baud} baud"),
        needed: format!("one of {}", SPEEDS.map(|speed| speed.to_string()).join(", ")),
        hint: "921600 is enough for 500 Hz, 2000000 for 1 kHz".into(),
    })
}

/// Real-time: no. Opened without waiting for a carrier, without becoming this process's terminal, and locked.
fn opened(device: &Path) -> io::Result<File> {
    let flags = libc::O_NOCTTY | libc::O_NONBLOCK;
    let file = File::options().read(true).write(true).custom_flags(flags).open(device)?;
    file.try_lock()?;
    if !is_pseudo_terminal(&file)? {
        // SAFETY: the descriptor is open for the whole call, and the request takes no argument.
        let answer = unsafe { libc::ioctl(file.as_raw_fd(), libc::TIOCEXCL) };
        Errno::result(answer)?;
    }
    Ok(file)
}

/// Real-time: no. Exclusive mode lasts until the last descriptor is closed, and a pseudo-terminal's other end holds one open:
/// it would lock the next host out. There the file's lock has to do.
fn is_pseudo_terminal(file: &File) -> io::Result<bool> {
    const UNIX98_SLAVES: std::ops::RangeInclusive<u32> = 136..=143;
    let device = std::os::unix::fs::MetadataExt::rdev(&file.metadata()?);
    Ok(UNIX98_SLAVES.contains(&libc::major(device)))
}

/// Real-time: no. Bytes as they are: 8 data bits, no parity, one stop bit, no flow control; a read without data fails at once.
fn made_raw(line: impl AsFd) -> io::Result<()> {
    let mut settings = termios::tcgetattr(&line)?;
    termios::cfmakeraw(&mut settings);
    settings.control_flags.remove(ControlFlags::CSTOPB | ControlFlags::PARENB | ControlFlags::CRTSCTS);
    settings.control_flags.insert(ControlFlags::CLOCAL | ControlFlags::CREAD);
    settings.control_chars[SpecialCharacterIndices::VMIN as usize] = 1;
    settings.control_chars[SpecialCharacterIndices::VTIME as usize] = 0;
    Ok(termios::tcsetattr(&line, SetArg::TCSANOW, &settings)?)
}

/// Real-time: no. By number, past the C library: the meaning of its speed constants depends on its version.
fn set_speed(line: &File, baud: u32) -> io::Result<()> {
    let mut settings = settings_by_number(line)?;
    settings.c_cflag = settings.c_cflag & !libc::CBAUD & !libc::CIBAUD | libc::BOTHER;
    (settings.c_ispeed, settings.c_ospeed) = (baud, baud);
    // SAFETY: the descriptor is open, and the kernel reads a structure that outlives the call.
    Errno::result(unsafe { libc::ioctl(line.as_raw_fd(), libc::TCSETS2, &raw const settings) })?;
    let taken = settings_by_number(line)?.c_ospeed;
    if (f64::from(taken) / f64::from(baud) - 1.0).abs() > SPEED_TOLERANCE {
        return Err(io::Error::other(format!("the device takes {taken} baud in place of {baud}")));
    }
    Ok(())
}

/// Real-time: no.
fn settings_by_number(line: &File) -> io::Result<libc::termios2> {
    let mut settings = MaybeUninit::<libc::termios2>::uninit();
    // SAFETY: the descriptor is open, and the kernel writes the whole of a structure that outlives the call.
    Errno::result(unsafe { libc::ioctl(line.as_raw_fd(), libc::TCGETS2, settings.as_mut_ptr()) })?;
    // SAFETY: the call has succeeded, so the kernel has written it.
    Ok(unsafe { settings.assume_init() })
}

/// Real-time: no.
fn pseudo_terminal() -> io::Result<(SerialWire, PathBuf)> {
    let pair = nix::pty::openpty(None, None)?;
    made_raw(&pair.slave)?;
    let device = nix::unistd::ttyname(&pair.slave)?;
    let flags = nix::fcntl::OFlag::O_RDWR | nix::fcntl::OFlag::O_NONBLOCK;
    nix::fcntl::fcntl(&pair.master, nix::fcntl::FcntlArg::F_SETFL(flags))?;
    Ok((SerialWire::over(File::from(pair.master), Some(pair.slave)), device))
}
