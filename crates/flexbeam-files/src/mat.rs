//! MATLAB's binary files, level 5, as far as a recording needs them: columns of doubles, numbers and text, uncompressed.
//!
//! Enters: names and values. Leaves: the file's bytes, the same for the same values. Deliberately absent: reading; the date
//! that MATLAB itself writes into the head.
//!
//! By hand, because the crate matrw 0.1 writes the date and keeps the errors of writing to itself.
//! Source: MathWorks, MAT-File Format, "Level 5 MAT-files". Text goes as UTF-16, as MATLAB holds it.

use crate::fault::Fault;
use flexbeam_lti::Signals;

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
    pub const CHAR: u32 = 4;
    pub const DOUBLE: u32 = 6;
}

/// Longest name that MATLAB takes.
const LONGEST_NAME: usize = 63;

/// The value of a variable.
#[derive(Clone, Debug, PartialEq)]
pub enum MatVariable {
    /// n x 1; a number alone is 1 x 1.
    Column(Vec<f64>),
    /// 1 x n characters.
    Text(String),
}

/// Variables of these names, in this order, as the bytes of a MATLAB file.
///
/// Assumes: the names are those of [`mat_name`].
/// Errors: [`Fault::DuplicateName`]; [`Fault::Range`] for a variable of 4 GiB or more, which the format cannot hold.
pub fn mat_bytes(variables: &[(String, MatVariable)]) -> Result<Vec<u8>, Fault> {
    let mut bytes = head();
    for (k, (name, value)) in variables.iter().enumerate() {
        if variables[..k].iter().any(|(other, _)| other == name) {
            return Err(Fault::DuplicateName { name: name.clone() });
        }
        let array = value.array(name)?;
        push_element(&mut bytes, element::MATRIX, &array, name)?;
    }
    Ok(bytes)
}

/// A name that MATLAB takes: letters, digits and underscores, a letter first, 63 at most.
pub fn mat_name(name: &str) -> String {
    let plain = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' });
    let first = if name.starts_with(|c: char| c.is_ascii_alphabetic()) { "" } else { "x" };
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
    fn array(&self, name: &str) -> Result<Vec<u8>, Fault> {
        let (class, kind, [rows, columns], data) = match self {
            MatVariable::Column(values) => {
                let data = values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
                (class::DOUBLE, element::DOUBLE, [values.len(), 1], data)
            }
            MatVariable::Text(text) => {
                let units: Vec<u16> = text.encode_utf16().collect();
                let data = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
                (class::CHAR, element::UINT16, [1, units.len()], data)
            }
        };
        let flags = [class.to_le_bytes(), [0; 4]].concat();
        let dimensions = [(rows as u32).to_le_bytes(), (columns as u32).to_le_bytes()].concat();
        let mut bytes = Vec::with_capacity(data.len() + 2 * LONGEST_NAME);
        push_element(&mut bytes, element::UINT32, &flags, name)?;
        push_element(&mut bytes, element::INT32, &dimensions, name)?;
        push_element(&mut bytes, element::INT8, name.as_bytes(), name)?;
        push_element(&mut bytes, kind, &data, name)?;
        Ok(bytes)
    }
}

/// Type, length, data, and zeros up to a multiple of eight.
fn push_element(bytes: &mut Vec<u8>, kind: u32, data: &[u8], name: &str) -> Result<(), Fault> {
    let too_long = |_| Fault::Range {
        key: format!("the size of {name} in bytes"),
        found: data.len() as f64,
        needed: "below 4 GiB, which is what a MATLAB file of level 5 holds",
    };
    let length = u32::try_from(data.len()).map_err(too_long)?;
    bytes.extend_from_slice(&kind.to_le_bytes());
    bytes.extend_from_slice(&length.to_le_bytes());
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
        for (name, expected) in
            [("theta_rad", "theta_rad"), ("y; filtered", "y__filtered"), ("3rd", "x3rd"), ("_", "x_")]
        {
            assert_eq!(mat_name(name), expected);
        }
        assert_eq!(mat_name(&"a".repeat(100)).len(), 63);
        let twice = [("a".to_string(), MatVariable::Column(vec![])), ("a".to_string(), MatVariable::Column(vec![]))];
        assert_eq!(mat_bytes(&twice), Err(Fault::DuplicateName { name: "a".into() }));
    }
}
