//! One row: its numbers, or what is wrong with it and at which byte.

use super::LEFT_OUT;
use super::cell::{Decimal, number, unquoted};
use super::fault::TableFault;
use super::separator::Separator;
use super::stamp::{NANOSECONDS, nanoseconds};
use crate::fault::Fault;

/// What becomes of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Use {
    LeftOut,
    Time,
    Signal,
}

/// Reads rows that are spelt alike.
pub(super) struct RowReader {
    separator: Separator,
    decimal: Option<Decimal>,
    names: Vec<String>,
    uses: Vec<Use>,
    /// The first time stamp in words, which the others are counted from [ns].
    first_stamp: Option<i64>,
    /// A row with decimal points in place of its commas.
    respelt: Vec<u8>,
}

/// The numbers of rows: signals row after row, and time.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Rows {
    pub time: Vec<f64>,
    pub signals: Vec<f64>,
}

impl Rows {
    /// Room for so many samples of so many signals.
    pub fn with_capacity(samples: usize, signals: usize) -> Rows {
        Rows { time: Vec::with_capacity(samples), signals: Vec::with_capacity(samples * signals) }
    }

    fn cut(&mut self, to: (usize, usize)) {
        self.time.truncate(to.0);
        self.signals.truncate(to.1);
    }
}

/// A fault, and the byte of the line where it stands, from 0.
pub(super) type Found = (Fault, usize);

impl RowReader {
    /// `time` is the index of the time axis in `names`.
    pub fn new(separator: Separator, decimal: Option<Decimal>, names: Vec<String>, time: Option<usize>) -> RowReader {
        let of = |(k, name): (usize, &String)| match name {
            name if name == LEFT_OUT => Use::LeftOut,
            _ if Some(k) == time => Use::Time,
            _ => Use::Signal,
        };
        let uses = names.iter().enumerate().map(of).collect();
        RowReader { separator, decimal, names, uses, first_stamp: None, respelt: Vec::new() }
    }

    /// Appends the numbers of a line that is neither blank nor a comment.
    ///
    /// NUMERICS: both ways are correctly rounded, so they give the same bits; whatever is not plain goes the thorough way.
    pub fn read(&mut self, line: &[u8], rows: &mut Rows) -> Result<(), Found> {
        let before = (rows.time.len(), rows.signals.len());
        if self.plain(line, rows).is_some() {
            return Ok(());
        }
        rows.cut(before);
        self.thorough(line, rows).inspect_err(|_| rows.cut(before))
    }

    /// Nothing where the line is not a number in each column and a separator between two.
    fn plain(&mut self, line: &[u8], rows: &mut Rows) -> Option<()> {
        match self.decimal {
            Some(Decimal::Point) => self.numbers(line, rows),
            None if !line.contains(&b'.') && (self.commas() || !line.contains(&b',')) => self.numbers(line, rows),
            Some(Decimal::Comma) if !self.commas() && !line.contains(&b'.') => {
                let mut respelt = std::mem::take(&mut self.respelt);
                respelt.clear();
                respelt.extend(line.iter().map(|byte| if *byte == b',' { b'.' } else { *byte }));
                let read = self.numbers(&respelt, rows);
                self.respelt = respelt;
                read
            }
            _ => None,
        }
    }

    fn numbers(&self, line: &[u8], rows: &mut Rows) -> Option<()> {
        let mut rest = line;
        for (k, column) in self.uses.iter().enumerate() {
            if k > 0 {
                rest = self.after_separator(rest)?;
            }
            rest = self.after_blanks(rest);
            if *column == Use::LeftOut {
                let end = rest.iter().position(|byte| self.separator.separates(*byte)).unwrap_or(rest.len());
                (!rest[..end].contains(&b'"')).then_some(())?;
                rest = &rest[end..];
                continue;
            }
            let (value, length) = fast_float2::parse_partial::<f64, _>(rest).ok()?;
            value.is_finite().then_some(())?;
            match column {
                Use::Time => rows.time.push(value),
                _ => rows.signals.push(value),
            }
            rest = &rest[length..];
        }
        let behind = self.after_separator(rest).unwrap_or(rest);
        behind.trim_ascii().is_empty().then_some(())
    }

    fn commas(&self) -> bool {
        self.separator == Separator::Character(b',')
    }

    /// Whether the time axis is in words, and so already in seconds.
    pub fn is_stamped(&self) -> bool {
        self.first_stamp.is_some()
    }

    /// Columns, those left out too.
    pub fn width(&self) -> usize {
        self.names.len()
    }

    fn after_blanks<'a>(&self, text: &'a [u8]) -> &'a [u8] {
        // Nearly always there is none.
        if text.first().is_some_and(|byte| *byte > b' ') {
            return text;
        }
        let blank = |byte: &u8| byte.is_ascii_whitespace() && self.separator != Separator::Character(*byte);
        &text[text.iter().position(|byte| !blank(byte)).unwrap_or(text.len())..]
    }

    fn after_separator<'a>(&self, text: &'a [u8]) -> Option<&'a [u8]> {
        match self.separator {
            Separator::WhiteSpace => text.first().is_some_and(u8::is_ascii_whitespace).then_some(text),
            Separator::Character(c) => self.after_blanks(text).strip_prefix(&[c]),
        }
    }

    /// Cell by cell: quotes, decimal commas as they come, time stamps in words, cells to be left out; and every fault.
    fn thorough(&mut self, line: &[u8], rows: &mut Rows) -> Result<(), Found> {
        let line = std::str::from_utf8(line).map_err(|error| (Fault::NotText, error.valid_up_to()))?;
        let cells = self.separator.cells(line);
        let (needed, found) = (self.names.len(), cells.len());
        let at = |cell: &str| cell.as_ptr() as usize - line.as_ptr() as usize;
        if let Some(cell) = cells.get(needed..).and_then(|more| more.iter().find(|cell| !cell.is_empty())) {
            return Err((Fault::Ragged { found, needed }, at(cell)));
        }
        if found > needed + 1 {
            return Err((Fault::Ragged { found, needed }, at(cells[needed])));
        }
        for (k, cell) in cells.iter().take(needed).enumerate() {
            self.cell(k, unquoted(cell), rows).map_err(|fault| (fault, at(cell)))?;
        }
        if found < needed { Err((Fault::Ragged { found, needed }, line.trim_ascii_end().len())) } else { Ok(()) }
    }

    fn cell(&mut self, k: usize, text: &str, rows: &mut Rows) -> Result<(), Fault> {
        match self.uses[k] {
            Use::LeftOut => {}
            Use::Time => {
                let time = match nanoseconds(text) {
                    Some(stamp) => self.seconds(stamp),
                    None => self.number(k, text)?,
                };
                rows.time.push(time);
            }
            Use::Signal => {
                let value = self.number(k, text)?;
                rows.signals.push(value);
            }
        }
        Ok(())
    }

    /// Since the first stamp [s].
    ///
    /// NUMERICS: counted in whole nanoseconds before it becomes a float, so a date costs no digits.
    fn seconds(&mut self, stamp: i64) -> f64 {
        let since = stamp.saturating_sub(*self.first_stamp.get_or_insert(stamp));
        (since / NANOSECONDS) as f64 + (since % NANOSECONDS) as f64 / NANOSECONDS as f64
    }

    fn number(&mut self, k: usize, text: &str) -> Result<f64, Fault> {
        let name = || self.names[k].clone();
        let (value, sign) = match number(text) {
            Some(read) => read,
            None if text.is_empty() => return Err(Fault::MissingValue { name: name() }),
            None => return Err(Fault::NotANumber { name: name(), text: text.into() }),
        };
        if !value.is_finite() {
            return Err(Fault::NotFinite { name: name(), text: text.into() });
        }
        match (self.decimal, sign) {
            (Some(one), Some(other)) if one != other => {
                Err(TableFault::MixedDecimals { name: name(), text: text.into() }.into())
            }
            (None, Some(sign)) => {
                self.decimal = Some(sign);
                Ok(value)
            }
            _ => Ok(value),
        }
    }
}
