//! What carries frames: the one thing that UDP, a serial line and a pseudo-terminal must be able to do.
//!
//! Enters: frames to send. Leaves: frames as they came, unread. Deliberately absent: what the frames mean.

use nix::errno::Errno;
use nix::poll::{PollFd, PollFlags, ppoll};
use nix::sys::time::TimeSpec;
use std::io;
use std::os::fd::BorrowedFd;
use std::time::Duration;

/// Longest frame that a wire takes in [bytes]: more than version 1 needs, so that frames of other versions are named.
pub const LONGEST_FRAME: usize = 256;

/// Where a wire puts the frame that came.
pub type FrameBuffer = [u8; LONGEST_FRAME];

/// A road for frames, in both directions. Neither call waits.
pub trait Wire: Send {
    /// Real-time: yes. The whole frame, or none of it when the road is full at the moment: a lost frame then.
    ///
    /// Errors: [`Broken`].
    fn send(&self, frame: &[u8]) -> Result<(), Broken>;

    /// Real-time: yes. The next frame, if one is there; one system call at most.
    ///
    /// Errors: [`Broken`].
    fn receive(&mut self, buffer: &mut FrameBuffer) -> Result<Received, Broken>;

    /// Real-time: yes. What becomes readable when something comes.
    fn descriptor(&self) -> BorrowedFd<'_>;
}

/// A wire from the host's end, which a second thread may have to use.
pub trait HostWire: Wire + Sized + 'static {
    /// Real-time: no. A second sender on the same road.
    fn second(&self) -> Self;
}

/// What was there to receive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Received {
    /// Nothing, or not yet the whole of it.
    Nothing,
    /// So many bytes of the buffer are a frame. 0: bytes came that are none.
    Frame(usize),
}

/// The other end is gone, with the system's error number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Broken {
    /// The system's error number.
    pub errno: i32,
}

impl Broken {
    /// Real-time: yes. `Ok` with `otherwise` for what passes by itself: no room, nothing there, a signal.
    pub(crate) fn unless_passing<T>(error: &io::Error, otherwise: T) -> Result<T, Broken> {
        match error.raw_os_error().map(Errno::from_raw) {
            Some(Errno::EAGAIN | Errno::EINTR | Errno::ENOBUFS | Errno::ENOMEM) => Ok(otherwise),
            Some(errno) => Err(Broken { errno: errno as i32 }),
            None => Err(Broken { errno: Errno::EIO as i32 }),
        }
    }
}

/// Real-time: yes. Sleeps until something comes or `longest` is over, a signal or not; says whether something came.
pub(crate) fn wait(descriptor: BorrowedFd<'_>, longest: Duration) -> bool {
    let mut watched = [PollFd::new(descriptor, PollFlags::POLLIN)];
    // An interrupted sleep is an early look: the caller counts the time itself.
    !matches!(ppoll(&mut watched, Some(TimeSpec::from_duration(longest)), None), Ok(0))
}
