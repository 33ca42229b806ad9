//! A table, row after row.

use super::LEFT_OUT;
use super::dialect::{Dialect, is_comment};
use super::fault::TableFault;
use super::header::check_names;
use super::lines::{Lines, Mark, NoLine};
use super::row::{RowReader, Rows};
use crate::columns::ColumnName;
use crate::error::{Error, Tried};
use crate::fault::Fault;
use std::io::Read;
use std::path::{Path, PathBuf};

/// A table that is being read.
pub(crate) struct Table<R> {
    lines: Lines<R>,
    reader: RowReader,
    dialect: Dialect,
    /// Names of the signals, in order.
    pub names: Vec<String>,
    /// The time axis, as it is called.
    pub time: Option<String>,
    /// Blank lines after rows: a gap, if another row follows. The first of them.
    blank: Option<Mark>,
    begun: bool,
    source: PathBuf,
}

impl<R: Read> Table<R> {
    /// Settles names and spelling; no row is read yet. `given` stand in for the header, or replace it.
    ///
    /// Errors: [`Fault::NotText`], [`Fault::Empty`], [`Fault::NoHeader`], [`Fault::EmptyName`], [`Fault::DuplicateName`],
    /// [`Fault::NamesAndColumns`], [`Fault::Io`].
    pub fn open(reader: R, source: &Path, given: Option<&[String]>) -> Result<Table<R>, Error> {
        let error = |fault| Error::new(Tried::Read, source, fault);
        let lines = Lines::new(reader).map_err(|why| no_line(why, source))?;
        let head = text_of(lines.head(), lines.is_whole(), source)?;
        let dialect = Dialect::of(head, given).ok_or_else(|| error(Fault::Empty))?;
        let columns = dialect.columns;
        let at_first_line = |fault| error(fault).at_line(dialect.first_line);
        let names = match (given, &dialect.names) {
            (Some(names), _) => names.to_vec(),
            (None, Some(names)) => names.clone(),
            (None, None) => return Err(at_first_line(Fault::NoHeader { columns })),
        };
        // Rows of another width than the header are faults of their own, with their places.
        let columns = if given.is_some() { columns } else { names.len() };
        check_names(&names, columns).map_err(at_first_line)?;
        let time = names.iter().position(|name| ColumnName::of(name).is_time());
        let signals = names.iter().enumerate().filter(|(k, name)| Some(*k) != time && *name != LEFT_OUT);
        Ok(Table {
            names: signals.map(|(_, name)| name.clone()).collect(),
            time: time.map(|t| names[t].clone()),
            reader: RowReader::new(dialect.separator, dialect.decimal, names, time),
            lines,
            dialect,
            blank: None,
            begun: false,
            source: source.to_path_buf(),
        })
    }

    /// Appends the next row; where it stands, or nothing at the end.
    ///
    /// Errors: [`Fault::Ragged`], [`Fault::MissingValue`], [`Fault::NotANumber`], [`Fault::NotFinite`], [`Fault::Table`],
    /// [`Fault::NotText`], [`Fault::Io`].
    pub fn next(&mut self, rows: &mut Rows) -> Result<Option<Mark>, Error> {
        loop {
            let line = self.lines.next().map_err(|why| no_line(why, &self.source))?;
            let Some((mark, line)) = line else { return Ok(None) };
            if mark.line < self.dialect.first_row || is_comment(line) {
                continue;
            }
            if line.trim_ascii().is_empty() {
                self.blank = self.blank.or(self.begun.then_some(mark));
                continue;
            }
            if let Some(gap) = self.blank {
                let fault = Fault::Ragged { found: 0, needed: self.reader.width() };
                return Err(Error::new(Tried::Read, &self.source, fault).at(gap));
            }
            self.begun = true;
            let read = self.reader.read(line, rows);
            return read.map(|()| Some(mark)).map_err(|(fault, byte)| {
                let mark = Mark { byte: mark.byte + byte as u64, ..mark };
                Error::new(Tried::Read, &self.source, fault).at(mark).at_column(byte + 1)
            });
        }
    }

    /// Bytes of the file that were read.
    pub fn bytes_done(&self) -> u64 {
        self.lines.bytes_done()
    }

    /// Whether the time axis is in words, and so already in seconds.
    pub fn is_stamped(&self) -> bool {
        self.reader.is_stamped()
    }

    /// What was concluded from the file's head, where a person should know: the spelling is not the plain one.
    pub fn notice(&self) -> Option<String> {
        (!self.dialect.is_plain() || self.is_stamped()).then(|| self.understood())
    }

    /// What was concluded from the file's head.
    pub fn understood(&self) -> String {
        let time = self.time.as_ref().map_or("no time axis".to_string(), |time| format!("time axis {time}"));
        format!("{}; {time}; columns {}", self.dialect.words(), self.names.join(", "))
    }
}

fn no_line(why: NoLine, source: &Path) -> Error {
    match why {
        NoLine::Long(mark) => Error::new(Tried::Read, source, TableFault::LongLine.into()).at(mark),
        NoLine::Io(kind) => Error::new(Tried::Read, source, Fault::Io { kind }),
    }
}

/// The head's whole lines as text.
///
/// Errors: [`Fault::NotText`].
fn text_of<'a>(head: &'a [u8], whole: bool, source: &Path) -> Result<&'a str, Error> {
    let lines = if whole { head.len() } else { memchr::memrchr(b'\n', head).map_or(head.len(), |at| at + 1) };
    let head = &head[..lines];
    std::str::from_utf8(head).map_err(|error| {
        let readable = String::from_utf8_lossy(&head[..error.valid_up_to()]);
        Error::new(Tried::Read, source, Fault::NotText).at_offset(&readable, readable.len())
    })
}
