//! The report: one HTML file with everything inside, for reading, for printing on A4, without scripts.

use crate::figure::Figure;
use crate::number::typographic;
use crate::svg::escaped;
use crate::table::{Cell, Column, Table, Verdict};
use crate::typeface::{Level, runs};
use std::fmt::Write;

const STYLE: &str = include_str!("page.css");

/// One line of a certificate: a figure, what was required of it, and whether it is met.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// In words: `Stability degree`.
    pub name: String,
    /// As the papers write it: `β`. May be empty.
    pub symbol: String,
    /// The number as text, without unit.
    pub value: String,
    /// Its unit; may be empty.
    pub unit: String,
    /// What was required: `≥ 1.5`. May be empty.
    pub required: String,
    /// Met or not.
    pub verdict: Verdict,
}

impl Check {
    /// The checks as a table, for the terminal as for the page.
    pub fn table(checks: &[Check]) -> Table {
        let heads = [("figure", ""), ("symbol", ""), ("value", ""), ("unit", ""), ("required", ""), ("verdict", "")];
        let row = |check: &Check| -> [Cell; 6] {
            let Check { name, symbol, value, unit, required, verdict } = check.clone();
            [name.into(), symbol.into(), Cell::Number(value), unit.into(), required.into(), verdict.into()]
        };
        checks.iter().map(row).fold(Table::new(&heads), Table::row)
    }
}

/// A report under construction. Sections, figures and tables are numbered as they come; all text is escaped.
///
/// ```
/// use flexbeam_report::{Cell, Figure, Panel, Report, Table};
///
/// let mut report = Report::new("Flexible beam", "From a recording to a controller.");
/// report.section("Identification");
/// report.paragraph("The order follows from the singular values: σ₅ < 10⁻³ σ₄.");
/// report.table("Entries of A", &Table::new(&[("entry", ""), ("found", "1/s")]).row(["c".into(), Cell::number(57.7, 3)]));
/// report.figure(&Figure::new("", "Time [s]").panel(Panel::new("V [V]").line("", &[0.0, 1.0], &[0.0, 1.0])), "Input.");
/// let page = report.html("flexbeam 0.1.0");
/// assert!(page.contains("<b>Table 1.</b> Entries of A"));
/// ```
#[derive(Clone, Debug, Default)]
pub struct Report {
    title: String,
    lead: String,
    body: String,
    contents: Vec<(String, String)>,
    figures: usize,
    tables: usize,
}

impl Report {
    /// An empty report; the lead says in a sentence what it is about, and may be empty.
    pub fn new(title: &str, lead: &str) -> Report {
        Report { title: title.into(), lead: lead.into(), ..Report::default() }
    }

    /// Begins a section; it appears in the contents.
    pub fn section(&mut self, title: &str) {
        let name = format!("section-{}", self.contents.len() + 1);
        self.write(format_args!("<h2 id=\"{name}\">{}</h2>\n", inline(title)));
        self.contents.push((name, title.into()));
    }

    /// A heading within a section.
    pub fn heading(&mut self, title: &str) {
        self.write(format_args!("<h3>{}</h3>\n", inline(title)));
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) {
        self.write(format_args!("<p>{}</p>\n", inline(text)));
    }

    /// A formula on its own line.
    pub fn formula(&mut self, text: &str) {
        self.write(format_args!("<p class=\"formula\">{}</p>\n", inline(text)));
    }

    /// Text as a terminal shows it.
    pub fn verbatim(&mut self, text: &str) {
        self.write(format_args!("<pre>{}</pre>\n", escaped(text)));
    }

    /// A figure with its caption.
    pub fn figure(&mut self, figure: &Figure, caption: &str) {
        self.figures += 1;
        let (k, svg) = (self.figures, figure.svg());
        let caption = format!("<figcaption><b>Figure {k}.</b> {}</figcaption>", inline(caption));
        self.write(format_args!("<figure id=\"figure-{k}\">\n{svg}{caption}\n</figure>\n"));
    }

    /// A table with its caption.
    pub fn table(&mut self, caption: &str, table: &Table) {
        let numeric = |k: usize| table.rows().iter().any(|row| matches!(row[k], Cell::Number(_)));
        let class: Vec<&str> =
            (0..table.columns().len()).map(|k| if numeric(k) { " class=\"number\"" } else { "" }).collect();
        self.tables += 1;
        let (number, caption) = (self.tables, inline(caption));
        self.write(format_args!("<div class=\"scroll\"><table id=\"table-{number}\">"));
        self.write(format_args!("<caption><b>Table {number}.</b> {caption}</caption>\n"));
        self.write(format_args!("{}<tbody>\n", heads(table.columns(), &class)));
        for row in table.rows() {
            let cells: String =
                row.iter().zip(&class).map(|(cell, class)| format!("<td{class}>{}</td>", set(cell))).collect();
            self.write(format_args!("<tr>{cells}</tr>\n"));
        }
        self.write(format_args!("</tbody></table></div>\n"));
    }

    /// Names and values, one pair a line.
    pub fn facts(&mut self, caption: &str, facts: &[(&str, &str)]) {
        let cells = facts.iter().map(|(name, value)| [Cell::from(*name), Cell::from(*value)]);
        self.table(caption, &cells.fold(Table::new(&[("", ""), ("", "")]), Table::row));
    }

    /// A certificate: figures beside what was required of them, met or not.
    pub fn certificate(&mut self, caption: &str, checks: &[Check]) {
        self.table(caption, &Check::table(checks));
    }

    /// The finished page; the footer tells where it came from (tool, version, seed).
    pub fn html(&self, footer: &str) -> String {
        let title = inline(&self.title);
        let lead =
            if self.lead.is_empty() { String::new() } else { format!("<p class=\"lead\">{}</p>", inline(&self.lead)) };
        let item = |(name, title): &(String, String)| format!("<li><a href=\"#{name}\">{}</a></li>\n", inline(title));
        let contents: String = self.contents.iter().map(item).collect();
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
             <title>{}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
             <header><h1>{title}</h1>\n{lead}</header>\n\
             <nav aria-label=\"Contents\"><ol>\n{contents}</ol></nav>\n\
             <main>\n{}</main>\n<footer>{}</footer>\n</body>\n</html>\n",
            escaped(&self.title),
            self.body,
            inline(footer),
        )
    }

    fn write(&mut self, text: std::fmt::Arguments) {
        self.body.write_fmt(text).expect("a String takes all that is written");
    }
}

/// The head of a table; none where no column has a title.
fn heads(columns: &[Column], class: &[&str]) -> String {
    if columns.iter().all(|column| column.title.is_empty()) {
        return String::new();
    }
    let unit = |unit: &str| if unit.is_empty() { String::new() } else { format!("<span>[{}]</span>", inline(unit)) };
    let head = |(column, class): (&Column, &&str)| {
        format!("<th scope=\"col\"{class}>{}{}</th>", inline(&column.title), unit(&column.unit))
    };
    let heads: String = columns.iter().zip(class).map(head).collect();
    format!("<thead><tr>{heads}</tr></thead>\n")
}

fn set(cell: &Cell) -> String {
    match cell {
        Cell::Text(text) => inline(text),
        Cell::Number(text) => inline(&typographic(text)),
        Cell::Verdict(Verdict::Pass) => "<span class=\"pass\">✓ pass</span>".into(),
        Cell::Verdict(Verdict::Fail) => "<span class=\"fail\">✗ fail</span>".into(),
        Cell::Verdict(Verdict::Info) => String::new(),
    }
}

/// Escaped text with raised and lowered characters as the page's own.
fn inline(text: &str) -> String {
    let run = |(run, level): (String, Level)| match level {
        Level::Base => escaped(&run),
        Level::Raised => format!("<sup>{}</sup>", escaped(&run)),
        Level::Lowered => format!("<sub>{}</sub>", escaped(&run)),
    };
    runs(text).into_iter().map(run).collect()
}
