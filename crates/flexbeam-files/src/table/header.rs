//! Names of columns, as people write them over a table.

use super::LEFT_OUT;
use super::cell::{is_number, unquoted};
use super::separator::Separator;
use super::stamp::is_stamp;
use crate::columns::{ColumnName, unit_written};
use crate::fault::Fault;

/// The names in a line, or nothing when a number or a time stamp stands in it.
pub(super) fn names(line: &str, separator: Separator) -> Option<Vec<String>> {
    let cells = match separator {
        Separator::WhiteSpace => with_their_units(separator.cells(line)),
        Separator::Character(_) => separator.cells(line).into_iter().map(String::from).collect(),
    };
    let words = cells.iter().all(|cell| !is_value(cell)) && cells.iter().any(|cell| !cell.is_empty());
    words.then(|| cells.iter().map(|cell| name(unquoted(cell))).collect())
}

fn is_value(cell: &str) -> bool {
    is_number(cell) || is_stamp(unquoted(cell))
}

/// White-space cells with `(V)` and `[deg]` joined to the name before them.
fn with_their_units(cells: Vec<&str>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for cell in cells {
        match names.last_mut() {
            Some(name) if in_brackets(cell).is_some() => *name += &format!(" {cell}"),
            _ => names.push(cell.into()),
        }
    }
    names
}

/// The units in a line: under the header of some programs. Nothing when a cell is neither a unit nor empty, or all are empty.
pub(super) fn units(line: &str, separator: Separator) -> Option<Vec<&'static str>> {
    let cells = separator.cells(line);
    let some = cells.iter().any(|cell| !unquoted(cell).is_empty());
    let units = cells.into_iter().map(unquoted).map(|cell| match in_brackets(cell).unwrap_or(cell) {
        "" => Some(""),
        unit => unit_written(unit),
    });
    units.collect::<Option<Vec<_>>>().filter(|_| some)
}

/// `Voltage (V)`, `Voltage [V]` and `Voltage / V` as `Voltage_v`: the unit behind the name, as everywhere here. What is in the
/// brackets and no unit stays.
fn name(cell: &str) -> String {
    let parted = [cell.find('('), cell.find('['), cell.find(" / ")].into_iter().flatten().find_map(|at| {
        let (quantity, rest) = cell.split_at(at);
        let unit = unit_written(in_brackets(rest).or_else(|| rest.strip_prefix(" / "))?)?;
        Some((quantity.trim(), unit)).filter(|(quantity, _)| !quantity.is_empty())
    });
    parted.map_or_else(|| cell.to_string(), |(quantity, unit)| with_unit(quantity, unit))
}

/// A name with the unit that stands elsewhere in the file.
pub(super) fn with_unit(quantity: &str, unit: &str) -> String {
    let said = ColumnName::of(quantity).unit == unit;
    let quantity = quantity.replace(char::is_whitespace, "_");
    if said { quantity } else { format!("{quantity}_{unit}") }
}

fn in_brackets(text: &str) -> Option<&str> {
    let pairs = [('(', ')'), ('[', ']')];
    let inner = pairs.into_iter().find_map(|(open, close)| text.strip_prefix(open)?.strip_suffix(close));
    inner.map(str::trim)
}

/// Errors: [`Fault::NamesAndColumns`], [`Fault::EmptyName`], [`Fault::DuplicateName`].
pub(crate) fn check_names(names: &[String], columns: usize) -> Result<(), Fault> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_come_behind_the_name() {
        for (cell, expected) in [
            ("Voltage (V)", "Voltage_v"),
            ("theta [deg]", "theta_deg"),
            ("Hub angle [°]", "Hub_angle_deg"),
            ("speed / rad/s", "speed_rad_s"),
            ("time_s [s]", "time_s"),
            ("t(µs)", "t_us"),
            ("y (filtered)", "y (filtered)"),
            ("y; filtered, twice", "y; filtered, twice"),
            ("(V)", "(V)"),
            ("a [m/s²]", "a_m_s2"),
            ("theta_rad", "theta_rad"),
        ] {
            assert_eq!(name(cell), expected, "{cell}");
        }
    }

    #[test]
    fn a_header_has_words_only() {
        let tab = Separator::WhiteSpace;
        assert_eq!(names("Time (ms)  u [V]\t y", tab).unwrap(), ["Time_ms", "u_v", "y"]);
        assert_eq!(names("\"a, b\",c", Separator::Character(b',')).unwrap(), ["a, b", "c"]);
        assert_eq!(names("u 1", tab), None);
        assert_eq!(names("u;0,5", Separator::Character(b';')), None);
        assert_eq!(names(";", Separator::Character(b';')), None);
        assert_eq!(names("12:00:00.0,u", Separator::Character(b',')), None);
        assert_eq!(units("s;(mV);;[rad/s]", Separator::Character(b';')).unwrap(), ["s", "mv", "", "rad_s"]);
        assert_eq!(units("s;furlong", Separator::Character(b';')), None);
    }
}
