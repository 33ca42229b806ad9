//! Data elements: a type, a length, bytes.

use super::fault::MatFault;
use std::io::Read;

/// Types of a data element.
pub(super) mod kind {
    pub const INT8: u32 = 1;
    pub const INT32: u32 = 5;
    pub const UINT32: u32 = 6;
    pub const MATRIX: u32 = 14;
    pub const COMPRESSED: u32 = 15;
}

/// Length of a file's head [bytes].
pub(super) const HEAD: usize = 128;

/// Which byte of a number comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    Little,
    Big,
}

impl Order {
    pub fn u32(self, bytes: [u8; 4]) -> u32 {
        match self {
            Order::Little => u32::from_le_bytes(bytes),
            Order::Big => u32::from_be_bytes(bytes),
        }
    }
}

/// The order in which a file of level 5 is written; nothing for any other file.
pub(super) fn order(bytes: &[u8]) -> Option<Order> {
    const VERSION: usize = HEAD - 4;
    match bytes.get(VERSION..HEAD)? {
        [0, 1, b'I', b'M'] => Some(Order::Little),
        [1, 0, b'M', b'I'] => Some(Order::Big),
        _ => None,
    }
}

/// A data element.
#[derive(Clone, Copy, Debug)]
pub(super) struct Element<'a> {
    pub kind: u32,
    pub data: &'a [u8],
    /// Where it begins.
    pub at: usize,
}

/// Elements one after the other.
#[derive(Clone, Copy)]
pub(super) struct Elements<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Where these bytes stand in the file, and whether they stand there as they are: of compressed ones, each is where the first is.
    origin: usize,
    plain: bool,
    pub order: Order,
}

impl<'a> Elements<'a> {
    /// Those of a file, behind its head.
    pub fn of_file(bytes: &'a [u8], order: Order) -> Elements<'a> {
        Elements { bytes, at: HEAD, origin: 0, plain: true, order }
    }

    /// Those that were unpacked from the compressed element at `origin`.
    pub fn unpacked(bytes: &'a [u8], origin: usize, order: Order) -> Elements<'a> {
        Elements { bytes, at: 0, origin, plain: false, order }
    }

    /// Those within an element.
    pub fn within(&self, element: Element<'a>) -> Elements<'a> {
        const TAG: usize = 8;
        let origin = if self.plain { element.at + TAG } else { self.origin };
        Elements { bytes: element.data, at: 0, origin, ..*self }
    }

    pub fn malformed(&self, what: &'static str) -> MatFault {
        MatFault::Malformed { byte: self.place(), what }
    }

    fn place(&self) -> usize {
        if self.plain { self.origin + self.at } else { self.origin }
    }

    /// The next element; nothing at the end.
    ///
    /// NUMERICS: no length is believed beyond the bytes that are there.
    pub fn next(&mut self) -> Result<Option<Element<'a>>, MatFault> {
        let rest = &self.bytes[self.at.min(self.bytes.len())..];
        let Some((tag, behind)) = rest.split_first_chunk::<8>() else {
            return if rest.is_empty() { Ok(None) } else { Err(self.malformed("half a tag")) };
        };
        let [first, second] = [0, 4].map(|k| self.order.u32([tag[k], tag[k + 1], tag[k + 2], tag[k + 3]]));
        let at = self.place();
        if first >> 16 != 0 {
            let (kind, length) = (first & 0xffff, (first >> 16) as usize);
            let data =
                rest[4..8].get(..length).ok_or_else(|| self.malformed("a short element longer than four bytes"))?;
            self.at += 8;
            return Ok(Some(Element { kind, data, at }));
        }
        let length = second as usize;
        let data = behind.get(..length).ok_or_else(|| self.malformed("an element longer than what holds it"))?;
        self.at += 8 + if first == kind::COMPRESSED { length } else { length.next_multiple_of(8) };
        Ok(Some(Element { kind: first, data, at }))
    }

    /// The next element, which must be there and of this type.
    pub fn needed(&mut self, kind: u32, what: &'static str) -> Result<Element<'a>, MatFault> {
        let before = *self;
        self.next()?.filter(|element| element.kind == kind).ok_or_else(|| before.malformed(what))
    }
}

/// The bytes in a compressed element, at most `most`.
///
/// NUMERICS: memory grows with what is really unpacked, whatever the lengths in it say.
pub(super) fn unpacked(element: Element<'_>, most: u64) -> Result<Vec<u8>, MatFault> {
    let mut bytes = Vec::new();
    let unpacked = flate2::read::ZlibDecoder::new(element.data).take(most + 1).read_to_end(&mut bytes);
    if unpacked.is_err() {
        return Err(MatFault::Malformed { byte: element.at, what: "compressed data that cannot be unpacked" });
    }
    if bytes.len() as u64 > most {
        return Err(MatFault::Bomb { byte: element.at, most });
    }
    Ok(bytes)
}
