//! What can be wrong with a file, with the place and one hint.
//!
//! Enters: a [`Fault`] with its numbers and a [`Place`]. Leaves: one message of the form tried, found, needed, hint.
//! Deliberately absent: exit codes and colours (the command line's matter).

use crate::fault::Fault;
use crate::table::Mark;
use std::fmt;
use std::path::{Path, PathBuf};

/// Why a file could not be read, used or written.
///
/// Displays as `cannot read recording.csv:12:3: found "abc", needed a number`, then a line `hint: ..`.
#[derive(Clone, Debug, PartialEq)]
pub struct Error {
    /// What was tried.
    pub tried: Tried,
    /// Where the fault stands.
    pub place: Place,
    /// What is wrong, with its numbers; boxed because a `Result` should stay small.
    pub fault: Box<Fault>,
}

/// What was tried when the fault showed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tried {
    /// To read a file.
    Read,
    /// To pick columns out of a recording.
    Select,
    /// To write a file.
    Write,
    /// To save into a file that a person may have edited meanwhile.
    Save,
}

/// A file, and a line, column and byte in it where they are known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub file: PathBuf,
    /// Line, from 1.
    pub line: Option<usize>,
    /// Byte in the line, from 1.
    pub column: Option<usize>,
    /// Byte in the file, from 0: shown from [`FAR`] on, where editors do not go.
    pub byte: Option<u64>,
}

/// From this byte on a place is shown with its byte: `tail -c +N` goes there at once.
pub const FAR: u64 = 1 << 20;

impl Error {
    /// A fault in `file`, line and column not known.
    pub fn new(tried: Tried, file: &Path, fault: Fault) -> Error {
        Error {
            tried,
            place: Place { file: file.to_path_buf(), line: None, column: None, byte: None },
            fault: Box::new(fault),
        }
    }

    /// The same fault, with its line (from 1).
    pub fn at_line(mut self, line: usize) -> Error {
        self.place.line = Some(line);
        self
    }

    /// The same fault, with its line and its byte in the file.
    pub(crate) fn at(mut self, mark: Mark) -> Error {
        self.place.line = Some(mark.line);
        self.place.byte = Some(mark.byte);
        self
    }

    /// The same fault, with its byte in the line (from 1).
    pub fn at_column(mut self, column: usize) -> Error {
        self.place.column = Some(column);
        self
    }

    /// The same fault, located by its byte offset in the file's `text`.
    pub fn at_offset(self, text: &str, offset: usize) -> Error {
        let before = &text.as_bytes()[..offset.min(text.len())];
        let line_start = before.iter().rposition(|&b| b == b'\n').map_or(0, |k| k + 1);
        let line = 1 + before.iter().filter(|&&b| b == b'\n').count();
        self.at_line(line).at_column(before.len() - line_start + 1)
    }

    /// What was found there.
    pub fn found(&self) -> String {
        self.fault.found()
    }

    /// What was needed instead.
    pub fn needed(&self) -> String {
        self.fault.needed()
    }

    /// What the user may do about it.
    pub fn hint(&self) -> String {
        self.fault.hint()
    }
}

impl fmt::Display for Tried {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Tried::Read => "read",
            Tried::Select => "take columns from",
            Tried::Write => "write",
            Tried::Save => "save into",
        })
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        for number in [self.line, self.column].into_iter().flatten() {
            write!(f, ":{number}")?;
        }
        match self.byte {
            Some(byte) if byte >= FAR => write!(f, " (byte {byte})"),
            _ => Ok(()),
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot {} {}: found {}, needed {}", self.tried, self.place, self.found(), self.needed())?;
        write!(f, "\nhint: {}", self.hint())?;
        if self.tried == Tried::Save { write!(f, "; nothing was written") } else { Ok(()) }
    }
}

impl std::error::Error for Error {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_says_tried_place_found_needed_and_hint() {
        let fault = Fault::NotANumber { name: "theta_rad".into(), text: "abc".into() };
        let error = Error::new(Tried::Read, Path::new("recording.csv"), fault).at_line(12).at_column(3);
        let message = error.to_string();
        assert!(message.starts_with("cannot read recording.csv:12:3: found \"abc\""), "{message}");
        assert!(message.contains(", needed a number\nhint: "), "{message}");
    }

    #[test]
    fn an_offset_becomes_line_and_column() {
        let text = "ab\ncde\n\nf";
        for (offset, line, column) in [(0, 1, 1), (2, 1, 3), (3, 2, 1), (5, 2, 3), (7, 3, 1), (8, 4, 1), (99, 4, 2)] {
            let error = Error::new(Tried::Read, Path::new("x"), Fault::Empty).at_offset(text, offset);
            assert_eq!((error.place.line, error.place.column), (Some(line), Some(column)), "offset {offset}");
        }
    }
}
