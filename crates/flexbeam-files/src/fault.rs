//! Each thing that can be wrong with a file, as found and needed.

mod hint;
mod words;

use crate::mat_file::MatFault;
use crate::run_file::RunFault;
use crate::table::TableFault;
use std::io;
use words::counted;
pub(crate) use words::six_digits;

/// What is wrong; every variant carries its numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum Fault {
    /// No numbers at all.
    Empty,
    /// Bytes that are not UTF-8 text.
    NotText,
    /// A cell that is not a number.
    NotANumber {
        /// The column's name.
        name: String,
        /// The cell.
        text: String,
    },
    /// An empty cell.
    MissingValue {
        /// The column's name.
        name: String,
    },
    /// A number that is infinite or not a number, in a cell or under a key.
    NotFinite {
        /// The column's name, or the key.
        name: String,
        /// The number as it is written.
        text: String,
    },
    /// A row of another length than the first one.
    Ragged {
        /// Values in this row.
        found: usize,
        /// Values in the first row, or names in the header.
        needed: usize,
    },
    /// Too few samples.
    TooFewRows {
        /// Rows of numbers.
        found: usize,
        /// The smallest number of rows of any use.
        needed: usize,
    },
    /// Columns without names.
    NoHeader {
        /// Columns in the first row.
        columns: usize,
    },
    /// A header cell without text.
    EmptyName {
        /// Column, from 1.
        column: usize,
    },
    /// Two columns, inputs or outputs of one name.
    DuplicateName {
        /// The name.
        name: String,
    },
    /// The names given and the columns there are differ in number.
    NamesAndColumns {
        /// Names given.
        names: usize,
        /// Columns in the first row.
        columns: usize,
    },
    /// A column that the recording does not have.
    UnknownColumn {
        /// The name asked for.
        name: String,
        /// The names there are.
        available: Vec<String>,
        /// The most similar of these.
        nearest: Option<String>,
    },
    /// Nothing besides time.
    NoSignals,
    /// Neither a time column nor a period given.
    NoPeriod,
    /// No time axis where one is needed.
    NoTime,
    /// A period that is not a positive number.
    Period {
        /// The period.
        period_s: f64,
    },
    /// One step of the time column differs from the others.
    UnequalPeriods {
        /// This step.
        found_s: f64,
        /// The median step.
        needed_s: f64,
        /// Relative tolerance.
        tolerance: f64,
    },
    /// The period of the time column and the one given differ.
    PeriodsDiffer {
        /// The time column's.
        in_file_s: f64,
        /// The one given.
        given_s: f64,
        /// Relative tolerance.
        tolerance: f64,
    },
    /// Text that is not TOML.
    Syntax {
        /// What the TOML parser says.
        message: String,
    },
    /// A file without a `schema` key.
    NoSchema {
        /// The schema that this file should have.
        needed: &'static str,
    },
    /// A file of another kind or version.
    Schema {
        /// The schema of this file.
        found: String,
        /// The schema that is read here.
        needed: &'static str,
    },
    /// A key that the schema does not have.
    UnknownKey {
        /// The key.
        key: String,
        /// The keys that may stand there.
        known: Vec<String>,
        /// The most similar of these.
        nearest: Option<String>,
    },
    /// A key that the schema demands.
    MissingKey {
        /// The key, with its tables.
        key: String,
    },
    /// Two keys of which exactly one may stand.
    OneOf {
        /// How many of the two stand there.
        found: usize,
        /// The first key.
        one: &'static str,
        /// The second key.
        other: &'static str,
    },
    /// A value of the wrong type.
    WrongType {
        /// The key, with its tables.
        key: String,
        /// What stands there.
        found: String,
        /// What should stand there.
        needed: String,
    },
    /// A word that is not among the choices.
    Choice {
        /// The key, with its tables.
        key: String,
        /// The word.
        found: String,
        /// The choices.
        choices: Vec<String>,
        /// The most similar of these.
        nearest: Option<String>,
    },
    /// A number outside the range in which it means something.
    Range {
        /// The key, with its tables.
        key: String,
        /// The number.
        found: f64,
        /// The range in words.
        needed: &'static str,
    },
    /// A setting beyond a limit that the same file states.
    Beyond {
        /// The setting's key, with its tables.
        key: String,
        /// The setting.
        found: f64,
        /// The limit.
        most: f64,
        /// The limit's key, with its table.
        limit: &'static str,
    },
    /// The name of a file that is not there.
    NoSuchFile {
        /// The key, with its tables.
        key: String,
        /// The name as it is written.
        path: String,
    },
    /// A matrix whose shape does not fit the others.
    Shape {
        /// The key, with its tables.
        key: String,
        /// Rows found.
        found_rows: usize,
        /// Columns found.
        found_columns: usize,
        /// Rows needed.
        needed_rows: usize,
        /// Columns needed.
        needed_columns: usize,
    },
    /// A list whose length does not fit the rest.
    Length {
        /// The key, with its tables.
        key: String,
        /// Entries found.
        found: usize,
        /// Entries needed.
        needed: usize,
    },
    /// A list that must not be empty.
    EmptyList {
        /// The key, with its tables.
        key: String,
    },
    /// A table whose spelling or clock is wrong.
    Table(TableFault),
    /// A file of MATLAB's in which something is wrong.
    Mat(MatFault),
    /// A recording of a run in which something is wrong.
    Run(RunFault),
    /// A file that stands already, with other content.
    Exists,
    /// A folder where a file was meant.
    IsFolder,
    /// A file where a folder was meant.
    IsFile,
    /// A folder with something in it where a new one was meant.
    NotEmpty,
    /// No file of that name.
    NoFile,
    /// No folder for the file to be written.
    NoFolder,
    /// The operating system refused.
    Io {
        /// In its words.
        kind: io::ErrorKind,
    },
}

impl Fault {
    /// What was found there.
    pub fn found(&self) -> String {
        match self {
            Fault::Empty => "no rows of numbers".into(),
            Fault::NotText => "bytes that are not UTF-8 text".into(),
            Fault::NotANumber { name, text } => format!("{text:?} in column {name}"),
            Fault::MissingValue { name } => format!("an empty cell in column {name}"),
            Fault::NotFinite { name, text } => format!("{name} = {text}"),
            Fault::Ragged { found, .. } => counted(*found, "value", "in this row"),
            Fault::TooFewRows { found, .. } => counted(*found, "row", "of numbers"),
            Fault::NoHeader { columns } => counted(*columns, "column", "without a name"),
            Fault::EmptyName { column } => format!("no name for column {column}"),
            Fault::DuplicateName { name } => format!("the name {name} twice"),
            Fault::NamesAndColumns { names, columns } => {
                format!("{} and {}", counted(*names, "name", "given"), counted(*columns, "column", "in the file"))
            }
            Fault::UnknownColumn { name, .. } => format!("no column {name}"),
            Fault::NoSignals => "a time column and nothing else".into(),
            Fault::NoPeriod => "neither a time column nor a period".into(),
            Fault::NoTime => "no time axis".into(),
            Fault::Period { period_s } => format!("a sample period of {period_s} s"),
            Fault::UnequalPeriods { found_s, .. } => {
                format!("unequal sample periods: {} s to this row from the one before", six_digits(*found_s))
            }
            Fault::PeriodsDiffer { in_file_s, given_s, .. } => {
                format!("a period of {in_file_s} s in the time column and {given_s} s given")
            }
            Fault::Syntax { message } => format!("text that is not TOML ({message})"),
            Fault::NoSchema { .. } => "no schema".into(),
            Fault::Schema { found, .. } => format!("schema {found:?}"),
            Fault::UnknownKey { key, .. } => format!("an unknown key {key}"),
            Fault::MissingKey { key } => format!("no key {key}"),
            Fault::OneOf { found: 0, one, other } => format!("neither {one} nor {other}"),
            Fault::OneOf { one, other, .. } => format!("both {one} and {other}"),
            Fault::WrongType { key, found, .. } => format!("{key}: {found}"),
            Fault::Choice { key, found, .. } => format!("{key} = {found:?}"),
            Fault::Range { key, found, .. } => format!("{key} = {found}"),
            Fault::Beyond { key, found, .. } => format!("{key} = {found}"),
            Fault::NoSuchFile { key, path } => format!("{key} = {path:?}, where no file is"),
            Fault::Shape { key, found_rows, found_columns, .. } => format!("{key} is {found_rows} x {found_columns}"),
            Fault::Length { key, found, .. } => format!("{key} has {}", counted(*found, "entry", "")),
            Fault::EmptyList { key } => format!("nothing in {key}"),
            Fault::Table(fault) => fault.found(),
            Fault::Mat(fault) => fault.found(),
            Fault::Run(fault) => fault.found(),
            Fault::Exists => "a file of that name with other content".into(),
            Fault::IsFolder => "a folder".into(),
            Fault::IsFile => "a file".into(),
            Fault::NotEmpty => "a folder that is not empty".into(),
            Fault::NoFile => "no file of that name".into(),
            Fault::NoFolder => "no folder to write it into".into(),
            Fault::Io { kind } => kind.to_string(),
        }
    }

    /// What was needed instead.
    pub fn needed(&self) -> String {
        match self {
            Fault::Empty | Fault::NoSignals => "at least one column of samples".into(),
            Fault::NotText => "a text file in UTF-8".into(),
            Fault::NotANumber { .. } | Fault::MissingValue { .. } => "a number".into(),
            Fault::NotFinite { .. } => "a finite number".into(),
            Fault::Ragged { needed, .. } => counted(*needed, "value", "as in the first row"),
            Fault::TooFewRows { needed, .. } => format!("at least {needed}"),
            Fault::NoHeader { .. } | Fault::EmptyName { .. } => "a name for each column".into(),
            Fault::DuplicateName { .. } => "names that differ".into(),
            Fault::NamesAndColumns { .. } => "one name for each column".into(),
            Fault::UnknownColumn { available, .. } => format!("one of {}", available.join(", ")),
            Fault::NoPeriod => "the sample period".into(),
            Fault::NoTime => "the instants to resample from".into(),
            Fault::Period { .. } => "a positive number of seconds".into(),
            Fault::UnequalPeriods { needed_s, tolerance, .. } => {
                format!("{} s within {} %", six_digits(*needed_s), 100.0 * tolerance)
            }
            Fault::PeriodsDiffer { tolerance, .. } => format!("two equal ones, within {} %", 100.0 * tolerance),
            Fault::Syntax { .. } => "TOML".into(),
            Fault::NoSchema { needed } => format!("schema = {needed:?}"),
            Fault::Schema { needed, .. } => format!("schema {needed:?}, which this version reads"),
            Fault::UnknownKey { known, .. } => format!("one of {}", known.join(", ")),
            Fault::MissingKey { .. } => "it, as the schema demands".into(),
            Fault::OneOf { .. } => "exactly one of the two".into(),
            Fault::WrongType { needed, .. } => needed.clone(),
            Fault::Choice { choices, .. } => format!("one of {}", choices.join(", ")),
            Fault::Range { needed, .. } => (*needed).into(),
            Fault::Beyond { most, limit, .. } => format!("at most {most}, as {limit} says"),
            Fault::NoSuchFile { .. } => "an existing file, as seen from the folder of this one".into(),
            Fault::Shape { needed_rows, needed_columns, .. } => format!("{needed_rows} x {needed_columns}"),
            Fault::Length { needed, .. } => needed.to_string(),
            Fault::EmptyList { .. } => "at least one entry".into(),
            Fault::Table(fault) => fault.needed(),
            Fault::Mat(fault) => fault.needed(),
            Fault::Run(fault) => fault.needed(),
            Fault::Exists => "a name that is free".into(),
            Fault::IsFolder => "a file".into(),
            Fault::IsFile => "a folder, or a name that is free".into(),
            Fault::NotEmpty => "a new or an empty folder".into(),
            Fault::NoFile => "an existing file".into(),
            Fault::NoFolder => "an existing folder".into(),
            Fault::Io { .. } => "the permission and the space to do it".into(),
        }
    }
}
