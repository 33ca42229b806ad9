//! Tables: columns with units, rows of cells, set as text for a terminal or (in a report) as HTML.

use crate::number::significant;

/// What a check came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The requirement is met.
    Pass,
    /// It is not.
    Fail,
    /// Nothing was required; the figure is for information.
    Info,
}

impl Verdict {
    /// One word.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Pass => "pass",
            Verdict::Fail => "FAIL",
            Verdict::Info => "",
        }
    }
}

impl From<bool> for Verdict {
    fn from(met: bool) -> Verdict {
        if met { Verdict::Pass } else { Verdict::Fail }
    }
}

/// One cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words, set to the left.
    Text(String),
    /// A number as [`significant`] writes it, or any other that is to stand by its decimal point.
    Number(String),
    /// Met or not.
    Verdict(Verdict),
}

impl Cell {
    /// `value` with so many significant digits.
    pub fn number(value: f64, digits: usize) -> Cell {
        Cell::Number(significant(value, digits))
    }

    /// A whole number.
    pub fn count(value: usize) -> Cell {
        Cell::Number(value.to_string())
    }

    /// The cell as plain text.
    pub fn text(&self) -> &str {
        match self {
            Cell::Text(text) | Cell::Number(text) => text,
            Cell::Verdict(verdict) => verdict.word(),
        }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Cell {
        Cell::Text(text.into())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Cell {
        Cell::Text(text)
    }
}

impl From<Verdict> for Cell {
    fn from(verdict: Verdict) -> Cell {
        Cell::Verdict(verdict)
    }
}

/// The head of a column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// What stands below.
    pub title: String,
    /// Its unit; empty for none.
    pub unit: String,
}

impl Column {
    /// A column; an empty unit means none.
    pub fn new(title: &str, unit: &str) -> Column {
        Column { title: title.into(), unit: unit.into() }
    }
}

/// A table. Invariant: each row has a cell for every column.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    columns: Vec<Column>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// An empty table with these columns, given as (title, unit).
    pub fn new(columns: &[(&str, &str)]) -> Table {
        Table { columns: columns.iter().map(|(title, unit)| Column::new(title, unit)).collect(), rows: vec![] }
    }

    /// Adds a row; panics unless it has a cell for every column.
    pub fn push(&mut self, row: impl IntoIterator<Item = Cell>) {
        let row: Vec<Cell> = row.into_iter().collect();
        assert_eq!(row.len(), self.columns.len(), "a table row has a cell for every column");
        self.rows.push(row);
    }

    /// Adds a row, for building in one expression.
    pub fn row(mut self, row: impl IntoIterator<Item = Cell>) -> Table {
        self.push(row);
        self
    }

    /// Heads.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Rows, from the top.
    pub fn rows(&self) -> &[Vec<Cell>] {
        &self.rows
    }

    /// The table for a terminal: columns aligned, numbers by their decimal points, no colour, no line longer than its
    /// content.
    pub fn text(&self) -> String {
        let columns: Vec<Vec<String>> = (0..self.columns.len()).map(|k| self.column_text(k)).collect();
        let height = columns.first().map_or(0, Vec::len);
        let line = |row: usize| columns.iter().map(|column| column[row].as_str()).collect::<Vec<_>>().join("  ");
        (0..height).map(|row| line(row).trim_end().to_string() + "\n").collect()
    }

    /// Title, unit (if any column has one), rule and cells of a column, all equally wide.
    fn column_text(&self, k: usize) -> Vec<String> {
        let cells: Vec<&Cell> = self.rows.iter().map(|row| &row[k]).collect();
        let numbers = cells.iter().any(|cell| matches!(cell, Cell::Number(_)));
        let body = aligned(&cells);
        let Column { title, unit } = &self.columns[k];
        let unit = if unit.is_empty() { String::new() } else { format!("[{unit}]") };
        let head = match self.columns.iter().all(|column| column.unit.is_empty()) {
            true => vec![title.clone()],
            false => vec![title.clone(), unit],
        };
        let width = head.iter().chain(&body).map(|text| text.chars().count()).max().unwrap_or(0);
        let set = |text: String| if numbers { format!("{text:>width$}") } else { format!("{text:<width$}") };
        head.into_iter().chain(["─".repeat(width)]).chain(body).map(set).collect()
    }
}

/// Cells of one column, numbers padded so that their decimal points stand below one another.
fn aligned(cells: &[&Cell]) -> Vec<String> {
    let fraction = |cell: &&Cell| match cell {
        Cell::Number(text) => text.len() - text.find(['.', 'e']).unwrap_or(text.len()),
        Cell::Text(_) | Cell::Verdict(_) => 0,
    };
    let longest = cells.iter().map(fraction).max().unwrap_or(0);
    let padded = |cell: &&Cell| match cell {
        Cell::Number(text) => text.clone() + &" ".repeat(longest - fraction(cell)),
        Cell::Text(_) | Cell::Verdict(_) => cell.text().into(),
    };
    cells.iter().map(padded).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_align_and_decimal_points_stand_below_one_another() {
        let table = Table::new(&[("pole", "1/s"), ("name", ""), ("", "")])
            .row([Cell::number(-12.586, 5), "mode β".into(), Verdict::Pass.into()])
            .row([Cell::number(-0.5, 2), "integrator".into(), Verdict::Fail.into()])
            .row([Cell::count(1234), "".into(), Verdict::Info.into()]);
        let text = table.text();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(
            lines,
            [
                "    pole  name",
                "   [1/s]",
                "────────  ──────────  ────",
                " -12.586  mode β      pass",
                "  -0.50   integrator  FAIL",
                "1234",
            ]
        );
    }

    #[test]
    fn a_table_without_units_has_one_line_of_heads() {
        assert_eq!(Table::new(&[("a", ""), ("b", "")]).text(), "a  b\n─  ─\n");
        assert_eq!(Table::new(&[]).text(), "");
    }

    #[test]
    #[should_panic(expected = "a cell for every column")]
    fn a_short_row_is_refused() {
        Table::new(&[("a", ""), ("b", "")]).push(["x".into()]);
    }
}
