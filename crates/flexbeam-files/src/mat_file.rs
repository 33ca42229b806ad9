//! MATLAB's binary files, level 5, as MATLAB (`save -v6`, `-v7`), Octave and scipy write them: read.
//!
//! Enters: bytes. Leaves: the recording in them: which variable is time, which are channels, and what was left out.
//! Deliberately absent: sparse and complex arrays, text, cells, objects, which are no signals; HDF5 (`-v7.3`), which is refused by
//! name; writing, which is `mat`.
//!
//! By hand: the crate matfile 0.5 reads no structures and believes every length that a file states.
//! Source: MathWorks, MAT-File Format, "Level 5 MAT-files".

mod array;
mod channels;
mod element;
mod fault;
mod variables;

pub use fault::MatFault;

use crate::error::{Error, Tried};
use crate::gathered::Gathered;
use crate::recording::Layout;
use std::path::Path;

/// Whether the bytes are a file of MATLAB's, of whatever level, or look like Octave's text in its place.
pub(crate) fn is_mat(bytes: &[u8]) -> bool {
    element::order(bytes).is_some() || refusal(bytes).is_some()
}

/// The signals in a file of MATLAB's.
///
/// Errors: [`Fault::Mat`](crate::Fault::Mat), [`Fault::NamesAndColumns`](crate::Fault::NamesAndColumns) and its like.
pub(crate) fn parse(bytes: &[u8], source: &Path, layout: &Layout) -> Result<Gathered, Error> {
    let gathered = match refusal(bytes) {
        Some(fault) => Err(fault.into()),
        None => variables::read(bytes).map_err(Into::into).and_then(|found| channels::gather(&found, layout)),
    };
    gathered.map_err(|fault| Error::new(Tried::Read, source, fault))
}

/// Kinds of files that are known and not read.
fn refusal(bytes: &[u8]) -> Option<MatFault> {
    const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
    /// Where MATLAB puts HDF5's own beginning, behind its head.
    const BEHIND_HEAD: usize = 512;
    let hdf5 = bytes.starts_with(HDF5) || bytes.get(BEHIND_HEAD..).is_some_and(|rest| rest.starts_with(HDF5));
    if hdf5 || bytes.starts_with(b"MATLAB 7.3 MAT-file") {
        return Some(MatFault::Hdf5);
    }
    bytes.starts_with(b"# Created by Octave").then_some(MatFault::OctaveText)
}
