//! MATLAB's binary files, level 5, as far as our files need them: matrices of doubles, complex columns, text, cells and
//! structures, uncompressed.
//!
//! Enters: names and values. Leaves: the file's bytes, the same for the same values. Deliberately absent: reading; the date
//! that MATLAB itself writes into the head.
//!
//! By hand, because the crate matrw 0.1 writes the date and keeps the errors of writing to itself.
//! Source: MathWorks, MAT-File Format, "Level 5 MAT-files". Text goes as UTF-16, as MATLAB holds it.

use crate::fault::Fault;
use flexbeam_lti::{C64, Mat, Signals};

/// First bytes of the head.
const HEAD: &str = "MATLAB 5.0 MAT-file, written by flexbeam";

/// Types of a data element.
mod element {
    pub const INT8: u32 = 1;
    pub const UINT16: u32 = 4;
    pub const INT32: u32 = 5;
    pub const UINT32: u32 = 6;
    pub const DOUBLE: u32 = 9;
    pub const MATRIX: u32 = 14;
}

/// Classes of an array.
mod class {
    pub const CELL: u32 = 1;
    pub const STRUCT: u32 = 2;
    pub const CHAR: u32 = 4;
    pub const DOUBLE: u32 = 6;
}

/// Flag of an array with imaginary parts.
const COMPLEX: u32 = 0x0800;

/// Longest name that MATLAB takes.
const LONGEST_NAME: usize = 63;

/// Words of the language, which are no names.
const KEYWORDS: [&str; 20] = [
    "break",
    "case",
    "catch",
    "classdef",
    "continue",
    "else",
    "elseif",
    "end",
    "for",
    "function",
    "global",
    "if",
    "otherwise",
    "parfor",
    "persistent",
    "return",
    "spmd",
    "switch",
    "try",
    "while",
];

/// The value of a variable.
#[derive(Clone, Debug, PartialEq)]
pub enum MatVariable {
    /// n x 1; a number alone is 1 x 1.
    Column(Vec<f64>),
    /// As it stands.
    Matrix(Mat),
    /// n x 1.
    Complex(Vec<C64>),
    /// 1 x n characters.
    Text(String),
    /// n x 1 cells.
    Cells(Vec<MatVariable>),
    /// 1 x 1 structure, its fields by the names of [`mat_name`].
    Struct(Vec<(String, MatVariable)>),
}

/// Variables of these names, in this order, as the bytes of a MATLAB file.
///
/// Assumes: the names are those of [`mat_name`].
/// Errors: [`Fault::DuplicateName`]; [`Fault::Range`] for a variable of 4 GiB or more, which the format cannot hold.
pub fn mat_bytes(variables: &[(String, MatVariable)]) -> Result<Vec<u8>, Fault> {
    different(variables)?;
    let mut bytes = head();
    for (name, value) in variables {
        push_element(&mut bytes, element::MATRIX, &value.array(name)?, name)?;
    }
    Ok(bytes)
}

/// Errors: [`Fault::DuplicateName`].
fn different(named: &[(String, MatVariable)]) -> Result<(), Fault> {
    match (0..named.len()).find(|&k| named[..k].iter().any(|(other, _)| *other == named[k].0)) {
        Some(k) => Err(Fault::DuplicateName { name: named[k].0.clone() }),
        None => Ok(()),
    }
}

/// Whether MATLAB takes it as the name of a variable, a field or a script.
pub fn is_mat_name(name: &str) -> bool {
    mat_name(name) == name
}

/// A name that MATLAB takes: letters, digits and underscores, a letter first, 63 at most, no word of the language.
pub fn mat_name(name: &str) -> String {
    let plain = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' });
    let fits = name.starts_with(|c: char| c.is_ascii_alphabetic()) && !KEYWORDS.contains(&name);
    let first = if fits { "" } else { "x" };
    first.chars().chain(plain).take(LONGEST_NAME).collect()
}

/// The variables of a recording: `time_s`, a column for each channel, `period_s`.
///
/// Shapes: `time_s` has an entry for each sample.
pub fn mat_variables(signals: &Signals, time_s: Vec<f64>) -> Vec<(String, MatVariable)> {
    let channels = signals.names.iter().zip(signals.data.row_iter());
    let channels = channels.map(|(name, row)| (mat_name(name), MatVariable::Column(row.iter().copied().collect())));
    let time = ("time_s".to_string(), MatVariable::Column(time_s));
    let period = ("period_s".to_string(), MatVariable::Column(vec![signals.period_s]));
    std::iter::once(time).chain(channels).chain([period]).collect()
}

/// Whether a file was written here.
pub(crate) fn is_ours(bytes: &[u8]) -> bool {
    bytes.starts_with(HEAD.as_bytes())
}

/// 116 bytes of text, no subsystem, version 1, little-endian.
fn head() -> Vec<u8> {
    const TEXT: usize = 116;
    let mut bytes = HEAD.as_bytes().to_vec();
    bytes.resize(TEXT, b' ');
    bytes.extend_from_slice(&[0; 8]);
    bytes.extend_from_slice(&0x0100u16.to_le_bytes());
    bytes.extend_from_slice(b"IM");
    bytes
}

impl MatVariable {
    /// The array's element without its own tag: flags, dimensions, name, contents.
    fn array(&self, name: &str) -> Result<Vec<u8>, Fault> {
        let (class, [rows, columns]) = match self {
            MatVariable::Column(values) => (class::DOUBLE, [values.len(), 1]),
            MatVariable::Matrix(M) => (class::DOUBLE, [M.nrows(), M.ncols()]),
            MatVariable::Complex(values) => (class::DOUBLE | COMPLEX, [values.len(), 1]),
            MatVariable::Text(text) => (class::CHAR, [1, text.encode_utf16().count()]),
            MatVariable::Cells(cells) => (class::CELL, [cells.len(), 1]),
            MatVariable::Struct(_) => (class::STRUCT, [1, 1]),
        };
        let mut bytes = Vec::new();
        push_element(&mut bytes, element::UINT32, &[class.to_le_bytes(), [0; 4]].concat(), name)?;
        let dimensions = [(rows as u32).to_le_bytes(), (columns as u32).to_le_bytes()].concat();
        push_element(&mut bytes, element::INT32, &dimensions, name)?;
        push_element(&mut bytes, element::INT8, name.as_bytes(), name)?;
        self.push_contents(&mut bytes, name)?;
        Ok(bytes)
    }

    fn push_contents(&self, bytes: &mut Vec<u8>, name: &str) -> Result<(), Fault> {
        let mut doubles = |values: &mut dyn Iterator<Item = f64>| {
            let data: Vec<u8> = values.flat_map(f64::to_le_bytes).collect();
            push_element(bytes, element::DOUBLE, &data, name)
        };
        match self {
            MatVariable::Column(values) => doubles(&mut values.iter().copied()),
            MatVariable::Matrix(M) => doubles(&mut M.iter().copied()),
            MatVariable::Complex(values) => {
                doubles(&mut values.iter().map(|z| z.re))?;
                doubles(&mut values.iter().map(|z| z.im))
            }
            MatVariable::Text(text) => {
                let data: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
                push_element(bytes, element::UINT16, &data, name)
            }
            MatVariable::Cells(cells) => cells.iter().try_for_each(|cell| push_nameless(bytes, cell, name)),
            MatVariable::Struct(fields) => {
                different(fields)?;
                let longest = fields.iter().map(|(field, _)| field.len()).max().unwrap_or(0);
                let room = (longest + 1).next_multiple_of(8);
                push_element(bytes, element::INT32, &(room as u32).to_le_bytes(), name)?;
                let names = fields.iter().flat_map(|(field, _)| field.bytes().chain(vec![0; room - field.len()]));
                push_element(bytes, element::INT8, &names.collect::<Vec<u8>>(), name)?;
                fields.iter().try_for_each(|(_, value)| push_nameless(bytes, value, name))
            }
        }
    }
}

/// A cell, or the value of a field: an array without a name.
fn push_nameless(bytes: &mut Vec<u8>, value: &MatVariable, within: &str) -> Result<(), Fault> {
    push_element(bytes, element::MATRIX, &value.array("")?, within)
}

/// Type, length, data, and zeros up to a multiple of eight; up to four bytes of data share the eight of the tag, as in the files
/// that MATLAB writes.
fn push_element(bytes: &mut Vec<u8>, kind: u32, data: &[u8], name: &str) -> Result<(), Fault> {
    let too_long = |_| Fault::Range {
        key: format!("the size of {name} in bytes"),
        found: data.len() as f64,
        needed: "below 4 GiB, which is what a MATLAB file of level 5 holds",
    };
    let length = u32::try_from(data.len()).map_err(too_long)?;
    if (1..=4).contains(&length) {
        bytes.extend_from_slice(&(kind | length << 16).to_le_bytes());
    } else {
        bytes.extend_from_slice(&kind.to_le_bytes());
        bytes.extend_from_slice(&length.to_le_bytes());
    }
    bytes.extend_from_slice(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_are_whole_eights() {
        let column = MatVariable::Column(vec![1.0, -0.0, f64::NAN]);
        let bytes =
            mat_bytes(&[("theta_rad".into(), column), ("tool".into(), MatVariable::Text("é!".into()))]).unwrap();
        assert_eq!((bytes.len() % 8, &bytes[124..128], is_ours(&bytes)), (0, &[0, 1, b'I', b'M'][..], true));
        assert_eq!(bytes[128..132], 14u32.to_le_bytes());
        // Tags of the array and its parts, flags, dimensions, the padded name, three doubles.
        let length = u32::from_le_bytes(bytes[132..136].try_into().unwrap()) as usize;
        assert_eq!(length, (8 + 8) + (8 + 8) + (8 + 16) + (8 + 24));
        assert_eq!(bytes[136 + length..][..4], 14u32.to_le_bytes(), "the next variable follows at once");
        let end = &bytes[136 + length - 24..136 + length];
        assert_eq!(end, [1.0f64, -0.0, f64::NAN].map(f64::to_le_bytes).concat());
    }

    #[test]
    fn names_are_made_acceptable_and_must_differ() {
        for (name, expected) in [
            ("theta_rad", "theta_rad"),
            ("y; filtered", "y__filtered"),
            ("3rd", "x3rd"),
            ("_", "x_"),
            ("end", "xend"),
            ("ends", "ends"),
        ] {
            assert_eq!(mat_name(name), expected);
        }
        assert_eq!(mat_name(&"a".repeat(100)).len(), 63);
        let twice = [("a".to_string(), MatVariable::Column(vec![])), ("a".to_string(), MatVariable::Column(vec![]))];
        assert_eq!(mat_bytes(&twice), Err(Fault::DuplicateName { name: "a".into() }));
        let within = [("s".to_string(), MatVariable::Struct(twice.to_vec()))];
        assert_eq!(mat_bytes(&within), Err(Fault::DuplicateName { name: "a".into() }));
    }
}
