//! The variables of a file.

use super::array::Array;
use super::element::{Elements, HEAD, kind, order, unpacked};
use super::fault::MatFault;

/// What a file may unpack to, beyond a multiple of its own length [bytes].
const ROOM: u64 = 1 << 28;

/// Zeros shrink a thousandfold, measured signals hardly at all.
const LARGEST_GROWTH: u64 = 16;

/// Every variable, in the file's order.
pub(super) fn read(bytes: &[u8]) -> Result<Vec<Array>, MatFault> {
    let order = order(bytes).ok_or(MatFault::Malformed { byte: HEAD - 4, what: "no version of level 5" })?;
    let mut elements = Elements::of_file(bytes, order);
    let mut room = ROOM + LARGEST_GROWTH * bytes.len() as u64;
    let mut found = Vec::new();
    while let Some(element) = elements.next()? {
        match element.kind {
            kind::MATRIX => found.push(Array::of(&elements, element)?),
            kind::COMPRESSED => {
                let bytes = unpacked(element, room)?;
                room -= bytes.len() as u64;
                let mut inner = Elements::unpacked(&bytes, element.at, order);
                while let Some(element) = inner.next()? {
                    if element.kind == kind::MATRIX {
                        found.push(Array::of(&inner, element)?);
                    }
                }
            }
            _ => return Err(MatFault::Malformed { byte: element.at, what: "an element that is no variable" }),
        }
    }
    Ok(found)
}
