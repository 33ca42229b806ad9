//! What the user may do about each fault.

use super::Fault;
use super::words::schema_hint;

impl Fault {
    /// What the user may do about it.
    pub fn hint(&self) -> String {
        match self {
            Fault::Empty => "is it the right file?".into(),
            Fault::NotText => "save it again as plain text, UTF-8".into(),
            Fault::NotANumber { text, .. } if text.contains(',') => {
                "a decimal comma stands between digits, once; signs between thousands are not read".into()
            }
            Fault::NotANumber { .. } | Fault::MissingValue { .. } => {
                "cut the recording before or after this row; a gap cannot be filled by guessing".into()
            }
            Fault::NotFinite { .. } => "something went wrong where this number was made; make the file again".into(),
            Fault::Ragged { found, needed } if *found == 2 * needed => {
                "are these decimal commas? Then save with semicolons between the columns".into()
            }
            Fault::Ragged { .. } => "complete the row, or remove it if it is the last one".into(),
            Fault::TooFewRows { .. } => "record for longer".into(),
            Fault::NoHeader { .. } => "name them: --columns time,u,y (_ leaves a column out)".into(),
            Fault::EmptyName { .. } => "name it, or take the column out".into(),
            Fault::DuplicateName { .. } => "rename one of the two".into(),
            Fault::NamesAndColumns { names, columns } if names > columns => "name only what the file has".into(),
            Fault::NamesAndColumns { .. } => "_ in the place of a name leaves a column out".into(),
            Fault::UnknownColumn { nearest, .. }
            | Fault::UnknownKey { nearest, .. }
            | Fault::Choice { nearest, .. } => nearest
                .as_ref()
                .map_or_else(|| "names are spelt as in the file".into(), |n| format!("did you mean {n}?")),
            Fault::NoSignals => "record what goes in and what comes out beside the time".into(),
            Fault::NoPeriod | Fault::Period { .. } => "give it in seconds: --period 0.001".into(),
            Fault::NoTime => "leave --resample out: what has no time axis has --period".into(),
            Fault::UnequalPeriods { .. } => "a sample is missing or doubled here; cut there".into(),
            Fault::PeriodsDiffer { .. } => "leave --period out to use the time column's".into(),
            Fault::Syntax { .. } => "words stand in quotes, numbers do not, arrays in [ ] with commas".into(),
            Fault::NoSchema { .. } => "is it the right kind of file? Its first line names the schema".into(),
            Fault::Schema { found, needed } => schema_hint(found, needed),
            Fault::MissingKey { .. } | Fault::EmptyList { .. } => "add it, or make the file again".into(),
            Fault::OneOf { found: 0, .. } => "add the one that fits".into(),
            Fault::OneOf { .. } => "take one of the two out".into(),
            Fault::WrongType { .. } => "compare with a file that flexbeam wrote".into(),
            Fault::Range { .. } => "check the sign and the unit in the key's name".into(),
            Fault::Beyond { .. } => "tighten the setting, or loosen the limit as far as the rig permits".into(),
            Fault::NoSuchFile { .. } => "make it, or name the one that is meant".into(),
            Fault::Shape { .. } | Fault::Length { .. } => {
                "A has a row for each state, B a column for each input, C a row for each output; rows are equally long"
                    .into()
            }
            Fault::Table(fault) => fault.hint(),
            Fault::Mat(fault) => fault.hint(),
            Fault::Run(fault) => fault.hint(),
            Fault::Exists => "choose another name, or allow replacing it with --force".into(),
            Fault::IsFolder => "name a file in it".into(),
            Fault::IsFile => "choose another name".into(),
            Fault::NotEmpty => "choose another name, or replace the files of the same names in it with --force".into(),
            Fault::NoFile => "paths count from the folder where the command runs".into(),
            Fault::NoFolder => "make the folder first".into(),
            Fault::Io { .. } => "look at the file's permissions and the free space".into(),
        }
    }
}
