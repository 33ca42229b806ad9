//! Bytes of a terminal in raw mode as keys.
//!
//! Read here and not by crossterm: its reader never returns once the terminal hangs up, and the run would have no end.

use std::io;
use std::os::fd::{AsFd, AsRawFd};
use std::time::{Duration, Instant};

use nix::errno::Errno;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};

/// An arrow's bytes come in pieces over a slow line; an ESC that stays alone for so long was the key itself.
const ESCAPE_ALONE: Duration = Duration::from_millis(100);
const ESCAPE: u8 = 0x1b;

/// A key that the view knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Key {
    /// A character, a space among them.
    Char(char),
    /// Enter.
    Enter,
    /// Esc.
    Escape,
    /// Ctrl-C, which is no signal in raw mode.
    Interrupt,
    /// An arrow, with or without Shift.
    Arrow(Arrow, Shift),
}

/// Arrow keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrow {
    Up,
    Down,
    Left,
    Right,
}

/// The Shift key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shift {
    Held,
    Free,
}

/// Standard input, and the bytes of a key that is not complete.
#[derive(Debug, Default)]
pub struct Keyboard {
    pending: Vec<u8>,
    since: Option<Instant>,
}

impl Keyboard {
    /// The keys that were pressed; waits no longer than `patience` for the first.
    ///
    /// Errors: the terminal is gone.
    pub fn pressed(&mut self, patience: Duration) -> io::Result<Vec<Key>> {
        if readable(patience)? {
            let mut bytes = [0; 256];
            let count = nix::unistd::read(io::stdin().as_fd(), &mut bytes)?;
            if count == 0 {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            self.pending.extend_from_slice(&bytes[..count]);
            self.since = Some(Instant::now());
        }
        let (mut keys, used) = parsed(&self.pending);
        self.pending.drain(..used);
        if self.since.is_some_and(|since| since.elapsed() >= ESCAPE_ALONE) {
            // The beginning of an arrow that never came to its end asks for nothing.
            keys.extend((self.pending == [ESCAPE]).then_some(Key::Escape));
            self.pending.clear();
        }
        Ok(keys)
    }
}

/// Whether there is something to read.
fn readable(patience: Duration) -> io::Result<bool> {
    let stdin = io::stdin();
    let mut fds = [PollFd::new(stdin.as_fd(), PollFlags::POLLIN)];
    let patience = PollTimeout::try_from(patience).unwrap_or(PollTimeout::MAX);
    match poll(&mut fds, patience) {
        // A signal: what it wants stands in the session's flag.
        Err(Errno::EINTR) => return Ok(false),
        done => done?,
    };
    let found = fds[0].revents().unwrap_or(PollFlags::empty());
    if found.intersects(PollFlags::POLLHUP | PollFlags::POLLERR | PollFlags::POLLNVAL) {
        let gone = format!("standard input ({}) hung up", stdin.as_raw_fd());
        return Err(io::Error::new(io::ErrorKind::BrokenPipe, gone));
    }
    Ok(found.contains(PollFlags::POLLIN))
}

/// The keys in the bytes, and how many bytes they took; what is left may become a key.
fn parsed(bytes: &[u8]) -> (Vec<Key>, usize) {
    let (mut keys, mut rest) = (Vec::new(), bytes);
    while let Some((key, length)) = first(rest) {
        keys.extend(key);
        rest = &rest[length..];
    }
    (keys, bytes.len() - rest.len())
}

/// The first key, if it is one that the view knows, and its length; nothing when it is not complete.
fn first(bytes: &[u8]) -> Option<(Option<Key>, usize)> {
    match bytes {
        [ESCAPE, b'[', after @ ..] => sequence(after).map(|(key, length)| (key, length + 2)),
        [ESCAPE, b'O', last, ..] => Some((arrow(*last, Shift::Free), 3)),
        [ESCAPE] | [ESCAPE, b'O'] => None,
        [ESCAPE, ..] => Some((Some(Key::Escape), 1)),
        [0x03, ..] => Some((Some(Key::Interrupt), 1)),
        [b'\r' | b'\n', ..] => Some((Some(Key::Enter), 1)),
        [byte @ 0x20..0x7f, ..] => Some((Some(Key::Char(char::from(*byte))), 1)),
        [_, ..] => Some((None, 1)),
        [] => None,
    }
}

/// What follows ESC [: numbers, then one byte that says what it was. `1;2` is Shift.
fn sequence(after: &[u8]) -> Option<(Option<Key>, usize)> {
    let end = after.iter().position(|byte| (0x40..0x7f).contains(byte))?;
    let shift = if after[..end].ends_with(b";2") { Shift::Held } else { Shift::Free };
    Some((arrow(after[end], shift), end + 1))
}

fn arrow(last: u8, shift: Shift) -> Option<Key> {
    let arrow = match last {
        b'A' => Arrow::Up,
        b'B' => Arrow::Down,
        b'C' => Arrow::Right,
        b'D' => Arrow::Left,
        _ => return None,
    };
    Some(Key::Arrow(arrow, shift))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_keys() {
        let keys: &[(&[u8], &[Key])] = &[
            (b" q", &[Key::Char(' '), Key::Char('q')]),
            (b"\r\n", &[Key::Enter, Key::Enter]),
            (b"\x03", &[Key::Interrupt]),
            (b"\x1b[A\x1b[B", &[Key::Arrow(Arrow::Up, Shift::Free), Key::Arrow(Arrow::Down, Shift::Free)]),
            (b"\x1bOC", &[Key::Arrow(Arrow::Right, Shift::Free)]),
            (b"\x1b[1;2D", &[Key::Arrow(Arrow::Left, Shift::Held)]),
            (b"\x1b[3~\x1b[200~x", &[Key::Char('x')]),
            ("ü".as_bytes(), &[]),
        ];
        for (bytes, expected) in keys {
            assert_eq!(parsed(bytes), (expected.to_vec(), bytes.len()), "{bytes:?}");
        }
    }

    /// Somebody in a hurry hits Esc and then everything else.
    #[test]
    fn escape_before_another_key_is_escape() {
        assert_eq!(parsed(b"\x1b ").0, [Key::Escape, Key::Char(' ')]);
        assert_eq!(parsed(b"\x1b\x1bq").0, [Key::Escape, Key::Escape, Key::Char('q')]);
    }

    /// On a slow line an arrow must not be taken for Esc, which would stop the run.
    #[test]
    fn an_arrow_in_pieces_is_one_arrow() {
        let whole = b"\x1b[1;2C";
        for cut in 1..whole.len() {
            assert_eq!(parsed(&whole[..cut]), (vec![], 0), "{cut}");
        }
        assert_eq!(parsed(b"\x1bO"), (vec![], 0));
    }

    #[test]
    fn no_bytes_are_too_odd() {
        let odd = (0..=255u8).flat_map(|a| (0..=255u8).map(move |b| [ESCAPE, a, b, ESCAPE, b'[', a, b]));
        for bytes in odd {
            let (_, used) = parsed(&bytes);
            assert!(used <= bytes.len());
        }
    }
}
