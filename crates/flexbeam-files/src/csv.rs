//! Tables of numbers in text: comma, semicolon or white-space separated, with or without a header.
//!
//! Enters: text and, for tables without a header, names. Leaves: names and numbers, or a fault with line and column.
//! Deliberately absent: what the columns mean.

use crate::error::{Error, Tried};
use crate::fault::Fault;
use flexbeam_lti::Signals;
use std::fmt::Write;
use std::path::Path;

/// In the place of a name: this column is left out, whatever it holds.
pub const LEFT_OUT: &str = "_";

/// Named columns of numbers, row after row.
#[derive(Debug, PartialEq)]
pub(crate) struct Table {
    /// The columns that were not left out.
    pub names: Vec<String>,
    /// Rows in sequence, each with a number for each name.
    pub values: Vec<f64>,
}

#[derive(Clone, Copy, PartialEq)]
enum Separator {
    Character(u8),
    WhiteSpace,
}

/// The table in `text`; `names` stand in for the header, or replace it.
///
/// Blank lines before the table and after it and lines that begin with `#` or `%` are passed over. A line of words
/// before the numbers is the header.
///
/// Errors: [`Fault::Empty`], [`Fault::NoHeader`], [`Fault::EmptyName`], [`Fault::DuplicateName`],
/// [`Fault::NamesAndColumns`], and for rows [`Fault::Ragged`], [`Fault::MissingValue`], [`Fault::NotANumber`],
/// [`Fault::NotFinite`].
/// Numerics: correctly rounded (`str::parse`), so a number that was written shortest reads back to its bits.
pub(crate) fn parse(text: &str, source: &Path, names: Option<&[String]>) -> Result<Table, Error> {
    let fault = |fault, line| Error::new(Tried::Read, source, fault).at_line(line);
    let mut lines = content(text).skip_while(|(_, line)| line.is_empty()).peekable();
    let Some(&(first, line)) = lines.peek() else {
        return Err(Error::new(Tried::Read, source, Fault::Empty));
    };
    let separator = Separator::of(line);
    let header = header(line, separator);
    let columns = header.as_ref().map_or_else(|| separator.count(line), Vec::len);
    if header.is_some() {
        lines.next();
    }
    let names = match (names, header) {
        (Some(names), _) => names.to_vec(),
        (None, Some(header)) => header,
        (None, None) => return Err(fault(Fault::NoHeader { columns }, first)),
    };
    check_names(&names, columns).map_err(|f| fault(f, first))?;
    let values = rows(lines, separator, &names, source)?;
    Ok(Table { names: names.into_iter().filter(|name| name != LEFT_OUT).collect(), values })
}

/// Line number, from 1, of a row of numbers, from 0.
pub(crate) fn line_of_row(text: &str, row: usize) -> Option<usize> {
    let mut lines = content(text).filter(|(_, line)| !line.is_empty()).peekable();
    let (_, first) = lines.peek()?;
    let header_lines = usize::from(header(first, Separator::of(first)).is_some());
    lines.nth(row + header_lines).map(|(number, _)| number)
}

/// The lines that are not comments, without white space after them, numbered from 1.
fn content(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = text.lines().enumerate().map(|(k, line)| (k + 1, line.trim_ascii_end()));
    lines.filter(|(_, line)| !matches!(line.trim_ascii_start().as_bytes().first(), Some(b'#' | b'%')))
}

fn rows<'a>(
    lines: impl Iterator<Item = (usize, &'a str)>,
    separator: Separator,
    names: &[String],
    source: &Path,
) -> Result<Vec<f64>, Error> {
    let mut values = Vec::new();
    let mut blank = None;
    for (number, line) in lines {
        if line.is_empty() {
            blank = blank.or(Some(number));
            continue;
        }
        if let Some(gap) = blank {
            let fault = Fault::Ragged { found: 0, needed: names.len() };
            return Err(Error::new(Tried::Read, source, fault).at_line(gap));
        }
        row(line, separator, names, &mut values)
            .map_err(|(fault, byte)| Error::new(Tried::Read, source, fault).at_line(number).at_column(byte + 1))?;
    }
    Ok(values)
}

/// Appends one row's numbers; on a fault, says at which byte of the line.
fn row(line: &str, separator: Separator, names: &[String], values: &mut Vec<f64>) -> Result<(), (Fault, usize)> {
    let mut found = 0;
    separator.each(line, |cell| {
        let at = |fault| (fault, cell.as_ptr() as usize - line.as_ptr() as usize);
        found += 1;
        match names.get(found - 1) {
            None => {
                let found = separator.count(line);
                Err(at(Fault::Ragged { found, needed: names.len() }))
            }
            Some(name) if name == LEFT_OUT => Ok(()),
            Some(name) => {
                values.push(number(cell, name).map_err(at)?);
                Ok(())
            }
        }
    })?;
    if found < names.len() {
        return Err((Fault::Ragged { found, needed: names.len() }, line.len()));
    }
    Ok(())
}

fn number(cell: &str, name: &str) -> Result<f64, Fault> {
    let text = unquoted(cell);
    let name = || name.to_string();
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(Fault::NotFinite { name: name(), text: text.into() }),
        Err(_) if text.is_empty() => Err(Fault::MissingValue { name: name() }),
        Err(_) => Err(Fault::NotANumber { name: name(), text: text.into() }),
    }
}

fn unquoted(cell: &str) -> &str {
    cell.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')).unwrap_or(cell)
}

impl Separator {
    /// The first of semicolon and comma that stands outside quotes, else white space.
    fn of(line: &str) -> Separator {
        let outside_quotes = |c: &u8| line.split('"').step_by(2).any(|piece| piece.as_bytes().contains(c));
        [b';', b','].into_iter().find(outside_quotes).map_or(Separator::WhiteSpace, Separator::Character)
    }

    fn each<E>(self, line: &str, mut take: impl FnMut(&str) -> Result<(), E>) -> Result<(), E> {
        match self {
            Separator::Character(c) => line.split(char::from(c)).try_for_each(|cell| take(cell.trim_ascii())),
            Separator::WhiteSpace => line.split_ascii_whitespace().try_for_each(take),
        }
    }

    fn count(self, line: &str) -> usize {
        match self {
            Separator::Character(c) => 1 + line.bytes().filter(|&b| b == c).count(),
            Separator::WhiteSpace => line.split_ascii_whitespace().count(),
        }
    }
}

/// The names in `line`, or nothing when a number stands in it.
fn header(line: &str, separator: Separator) -> Option<Vec<String>> {
    let mut names = vec![String::new()];
    let mut quoted = false;
    for c in line.trim_ascii().chars() {
        let separates = match separator {
            Separator::Character(s) => c == char::from(s),
            Separator::WhiteSpace => c.is_ascii_whitespace(),
        };
        match c {
            '"' => quoted = !quoted,
            _ if separates && !quoted => names.push(String::new()),
            _ => names.last_mut()?.push(c),
        }
    }
    let mut names: Vec<String> = names.iter().map(|name| name.trim().to_string()).collect();
    if separator == Separator::WhiteSpace {
        names.retain(|name| !name.is_empty());
    }
    let words = names.iter().all(|name| name.parse::<f64>().is_err()) && names.iter().any(|name| !name.is_empty());
    words.then_some(names)
}

fn check_names(names: &[String], columns: usize) -> Result<(), Fault> {
    if names.len() != columns {
        return Err(Fault::NamesAndColumns { names: names.len(), columns });
    }
    if let Some(empty) = names.iter().position(String::is_empty) {
        return Err(Fault::EmptyName { column: empty + 1 });
    }
    let twice = |k: usize| names[k] != LEFT_OUT && names[..k].contains(&names[k]);
    match (0..names.len()).find(|&k| twice(k)) {
        Some(k) => Err(Fault::DuplicateName { name: names[k].clone() }),
        None => Ok(()),
    }
}

/// Signals as CSV: `time_s` first, then the channels; every number in the shortest form that reads back to its bits.
///
/// `time_s` defaults to k `period_s`. Shapes: `time_s` has an entry for each sample.
pub fn csv_text(signals: &Signals, time_s: Option<&[f64]>) -> String {
    /// Bytes that a number takes, roughly; for the allocation only.
    const CELL: usize = 20;
    let mut text = String::with_capacity(CELL * (signals.channels() + 1) * (signals.samples() + 1));
    text.push_str("time_s");
    for name in &signals.names {
        let quotes = if name.contains([',', ';']) { "\"" } else { "" };
        push(&mut text, format_args!(",{quotes}{name}{quotes}"));
    }
    text.push('\n');
    for k in 0..signals.samples() {
        let time = time_s.map_or_else(|| instant(k as u64, signals.period_s), |time_s| time_s[k]);
        push(&mut text, format_args!("{time:?}"));
        for value in signals.data.column(k) {
            push(&mut text, format_args!(",{value:?}"));
        }
        text.push('\n');
    }
    text
}

fn push(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    text.write_fmt(arguments).expect("a String takes any text");
}

/// k Ts.
///
/// NUMERICS: where a whole number of samples makes a second, k / rate is the correctly rounded instant (0.009, where
/// 9 * 0.001 is 0.009000000000000001) and prints short.
pub(crate) fn instant(k: u64, period_s: f64) -> f64 {
    let rate = period_s.recip().round();
    if rate > 0.0 && rate.recip() == period_s { k as f64 / rate } else { k as f64 * period_s }
}
