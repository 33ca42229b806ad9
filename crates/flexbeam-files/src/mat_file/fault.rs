//! What can be wrong with a MATLAB file, as found and needed.

use crate::fault::Fault;

/// What is wrong; every variant carries its numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum MatFault {
    /// HDF5, as MATLAB's `save -v7.3` writes it.
    Hdf5,
    /// The text form that Octave's `save` writes unless told otherwise.
    OctaveText,
    /// Bytes that do not fit the format.
    Malformed {
        /// Where, from 0: in the file, or where the compressed variable begins in which they stand.
        byte: usize,
        /// What is wrong there.
        what: &'static str,
    },
    /// Compressed data that grow beyond what a file of that length can sensibly hold.
    Bomb {
        /// Where they begin, from 0.
        byte: usize,
        /// The most that is unpacked [bytes].
        most: u64,
    },
    /// No array of numbers that could be a recording.
    NoSignals {
        /// What is there instead.
        there: String,
    },
    /// Arrays of different lengths, or square ones, or several time axes: what the samples are cannot be told.
    Ambiguous {
        /// What is there.
        there: String,
    },
}

impl MatFault {
    /// What was found there.
    pub fn found(&self) -> String {
        match self {
            MatFault::Hdf5 => "a MATLAB file of version 7.3, which is HDF5".into(),
            MatFault::OctaveText => "Octave's own text format".into(),
            MatFault::Malformed { byte, what } => format!("{what} at byte {byte}"),
            MatFault::Bomb { byte, most } => {
                format!("more than {most} bytes unpacked from the variable at byte {byte}")
            }
            MatFault::NoSignals { there } => format!("no signals in the MATLAB file: {there}"),
            MatFault::Ambiguous { there } => format!("more than one way to take the MATLAB file: {there}"),
        }
    }

    /// What was needed instead.
    pub fn needed(&self) -> String {
        match self {
            MatFault::Hdf5 | MatFault::OctaveText => "a MATLAB file of level 5".into(),
            MatFault::Malformed { .. } => "a whole MATLAB file of level 5".into(),
            MatFault::Bomb { .. } => "a recording that fits into memory".into(),
            MatFault::NoSignals { .. } => "real arrays of numbers with the samples one after the other".into(),
            MatFault::Ambiguous { .. } => "one time axis, or arrays that share one length".into(),
        }
    }

    /// What the user may do about it.
    pub fn hint(&self) -> String {
        match self {
            MatFault::Hdf5 | MatFault::OctaveText => "in MATLAB or Octave: save -v7 recording.mat time u y".into(),
            MatFault::Malformed { .. } => "copy the file again, or save it anew with save -v7".into(),
            MatFault::Bomb { .. } => "is it the right file? save -v6 does without compression".into(),
            MatFault::NoSignals { .. } => "of a timeseries object x save time = x.Time and u = x.Data".into(),
            MatFault::Ambiguous { .. } => "save what belongs together alone: save -v7 recording.mat time u y".into(),
        }
    }
}

impl From<MatFault> for Fault {
    fn from(fault: MatFault) -> Fault {
        Fault::Mat(fault)
    }
}
