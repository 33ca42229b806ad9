//! How a table is spelt: concluded once, from the head of the file.

use super::LEFT_OUT;
use super::cell::{Decimal, number, unquoted};
use super::header;
use super::separator::Separator;
use super::stamp::is_stamp;

/// Rows from which the spelling is concluded.
const SAMPLE: usize = 100;

/// How a table is spelt.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Dialect {
    pub(super) separator: Separator,
    /// The decimal sign, where one has been seen.
    pub(super) decimal: Option<Decimal>,
    /// Names from the file, units behind them.
    pub(super) names: Option<Vec<String>>,
    /// Cells of most rows.
    pub(super) columns: usize,
    /// First line that holds something, from 1.
    pub(super) first_line: usize,
    /// Line of the first row; one beyond the last line where there is none.
    pub(super) first_row: usize,
    /// Line of the names and of the units, from 1.
    names_line: Option<usize>,
    units_line: Option<usize>,
    /// The names are not those of a plain header: from a comment, or with units from brackets or from a line of their own.
    made_names: bool,
}

/// A line that holds something, with its number.
type Content<'a> = (usize, &'a str);

impl Dialect {
    /// The spelling under which most of the head's rows are numbers; nothing where no line holds anything.
    ///
    /// `given` are names that the user gave.
    pub fn of(head: &str, given: Option<&[String]>) -> Option<Dialect> {
        let lines = head.lines().enumerate().map(|(k, line)| (k + 1, line.trim_ascii_end()));
        let lines: Vec<Content> = lines.filter(|(_, line)| !line.is_empty()).collect();
        let comment = |line: &str| is_comment(line.as_bytes());
        let content = lines.iter().copied().filter(|(_, line)| !comment(line));
        let content: Vec<Content> = content.take(SAMPLE + 2).collect();
        let &(first, text) = content.first()?;
        let above = lines.iter().copied().rfind(|(number, line)| *number < first && comment(line));
        let reading = |separator| Reading::of(separator, &content, above, given);
        // Of equally good ones the first, where `max_by_key` would take the last.
        let readings = Separator::ALL.into_iter().rev().map(reading);
        let best = readings.max_by_key(|reading| (reading.agrees, reading.good, reading.dialect.columns))?;
        if best.good > 0 {
            return Some(best.dialect);
        }
        let plain = Separator::ALL.into_iter().find(|separator| separator.cells(text).len() > 1);
        Some(reading(plain.unwrap_or(Separator::WhiteSpace)).dialect)
    }

    /// In words, what was concluded.
    pub fn words(&self) -> String {
        let mut text = format!("{} between columns", self.separator.words());
        if self.decimal == Some(Decimal::Comma) {
            text += ", decimal commas";
        }
        text += &self.names_line.map_or(", no names".into(), |line| format!(", names in line {line}"));
        text + &self.units_line.map_or(String::new(), |line| format!(", units in line {line}"))
    }

    /// Whether it is spelt so that there is nothing to tell.
    pub fn is_plain(&self) -> bool {
        self.decimal != Some(Decimal::Comma) && !self.made_names
    }
}

/// Whether a line is a comment.
pub(super) fn is_comment(line: &[u8]) -> bool {
    let line = line.trim_ascii_start();
    matches!(line.first(), Some(b'#' | b'%')) || line.starts_with(b"//")
}

/// The head under one separator.
struct Reading {
    dialect: Dialect,
    /// Rows of the sample whose cells are as many as in most and all numbers.
    good: usize,
    /// As many names as columns, and some good rows.
    agrees: bool,
}

impl Reading {
    /// `above` is the last comment before the first line of content.
    fn of(separator: Separator, content: &[Content], above: Option<Content>, given: Option<&[String]>) -> Reading {
        let head = Head::of(separator, content, above);
        let rows: Vec<Vec<&str>> = content[head.lines..].iter().map(|(_, line)| separator.cells(line)).collect();
        let in_file = |names: &Vec<String>| names.iter().rposition(|name| !name.is_empty()).map_or(0, |last| last + 1);
        let named = given.map(<[String]>::len).or(head.names.as_ref().map(in_file));
        let (columns, trailing) = columns(&rows, named, separator);
        let names = head.names.map(|names| without_trailing(names, columns, trailing || rows.is_empty()));
        let left_out = |k: usize| given.and_then(|names| names.get(k)).is_some_and(|name| name == LEFT_OUT);
        let values = |cells: &[&str]| cells.iter().enumerate().all(|(k, cell)| left_out(k) || is_value(cell));
        let fits = |cells: &[&str]| cells.len() >= columns && cells[columns..].iter().all(|cell| cell.is_empty());
        let good = rows.iter().filter(|cells| fits(cells) && values(&cells[..columns])).count();
        let named = given.map(<[String]>::len).or(names.as_ref().map(Vec::len));
        let columns = if rows.is_empty() { named.unwrap_or(columns) } else { columns };
        let decimal = rows.iter().flatten().find_map(|cell| number(unquoted(cell))?.1);
        // One name over `1,2`: one column with decimal commas, or one name too few? Only the file itself can say.
        let unsure = columns == 1 && decimal == Some(Decimal::Comma) && names.is_none();
        Reading {
            good,
            agrees: good > 0 && !unsure && named.is_none_or(|named| named == columns),
            dialect: Dialect {
                separator,
                decimal,
                names,
                columns,
                first_line: content[0].0,
                first_row: content.get(head.lines).or(content.last()).map_or(1, |(line, _)| *line)
                    + usize::from(rows.is_empty()),
                names_line: head.names_line,
                units_line: head.units_line,
                made_names: head.made,
            },
        }
    }
}

fn is_value(cell: &str) -> bool {
    let text = unquoted(cell);
    number(text).is_some() || is_stamp(text)
}

/// The cells of most rows, the first of equals, and whether an empty one more stands behind each.
fn columns(rows: &[Vec<&str>], named: Option<usize>, separator: Separator) -> (usize, bool) {
    let count = |length: usize| rows.iter().filter(|cells| cells.len() == length).count();
    let lengths = rows.iter().map(Vec::len).rev();
    let Some(most) = lengths.max_by_key(|length| count(*length)) else { return (named.unwrap_or(0), false) };
    let usual = rows.iter().filter(|cells| cells.len() == most);
    let empty_ends = usual.into_iter().all(|cells| cells.last().is_some_and(|cell| cell.is_empty()));
    let trailing = separator != Separator::WhiteSpace && empty_ends && most > 1 && named != Some(most);
    (most - usize::from(trailing), trailing)
}

/// Names without the empty one behind a separator at the line's end.
fn without_trailing(mut names: Vec<String>, columns: usize, rows_trail: bool) -> Vec<String> {
    let empty = names.len() > 1 && names.last().is_some_and(String::is_empty);
    if empty && (rows_trail || names.len() == columns + 1) {
        names.pop();
    }
    names
}

/// What stands above the rows.
struct Head {
    names: Option<Vec<String>>,
    names_line: Option<usize>,
    units_line: Option<usize>,
    made: bool,
    /// Lines of content that are no rows.
    lines: usize,
}

impl Head {
    fn of(separator: Separator, content: &[Content], above: Option<Content>) -> Head {
        match header::names(content[0].1, separator) {
            Some(names) => Head::with_units(names, separator, content),
            None => Head::from_comment(separator, content, above),
        }
    }

    fn with_units(names: Vec<String>, separator: Separator, content: &[Content]) -> Head {
        let bare = |name: &String| content[0].1.contains(name.as_str());
        let plain = Head {
            made: !names.iter().all(bare),
            names: Some(names.clone()),
            names_line: Some(content[0].0),
            units_line: None,
            lines: 1,
        };
        let Some(&(line, text)) = content.get(1) else { return plain };
        match header::units(text, separator).filter(|units| units.len() == names.len()) {
            None => plain,
            Some(units) => {
                let named = names.iter().zip(units).map(|(name, unit)| match unit {
                    "" => name.clone(),
                    unit => header::with_unit(name, unit),
                });
                Head { names: Some(named.collect()), units_line: Some(line), made: true, lines: 2, ..plain }
            }
        }
    }

    /// As numpy and gnuplot have it: `# time_s u y` above rows of three numbers.
    fn from_comment(separator: Separator, content: &[Content], above: Option<Content>) -> Head {
        let none = Head { names: None, names_line: None, units_line: None, made: false, lines: 0 };
        let Some((line, comment)) = above else { return none };
        let text = comment.trim_ascii_start().trim_start_matches(['#', '%', '/']);
        let columns = separator.cells(content[0].1).len();
        match header::names(text, separator).filter(|names| names.len() == columns && !names.contains(&String::new())) {
            Some(names) => Head { names: Some(names), names_line: Some(line), made: true, ..none },
            None => none,
        }
    }
}
