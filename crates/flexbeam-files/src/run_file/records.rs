//! An MCAP file's records, one after the other, as far as the file goes.
//!
//! The file's own index is at its end, which a power loss takes away; so every file is read from its beginning.

use mcap::MAGIC;
use mcap::records::op;

/// A record outside any chunk.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part<'a> {
    /// Where it begins in the file.
    pub offset: usize,
    /// Its kind.
    pub opcode: u8,
    /// What it holds.
    pub body: &'a [u8],
}

/// The records of a file up to the end of its data.
#[derive(Debug)]
pub(super) struct Parts<'a> {
    /// The records that are there to their last byte.
    pub parts: Vec<Part<'a>>,
    /// Where the file ends within a record, if it does.
    pub cut: Option<usize>,
    /// Whether the writer came to the file's end: then nothing may be missing.
    pub finished: bool,
}

/// Whether the bytes are an MCAP file's.
pub(crate) fn is_mcap(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

impl<'a> Parts<'a> {
    /// Nothing when the bytes are no MCAP file.
    pub fn of(bytes: &'a [u8]) -> Option<Parts<'a>> {
        let finished = bytes.len() > MAGIC.len() && bytes.ends_with(MAGIC);
        let mut parts = Parts { parts: Vec::new(), cut: None, finished };
        let mut rest = bytes.strip_prefix(MAGIC)?;
        while parts.parts.last().is_none_or(|part| part.opcode != op::DATA_END) {
            let offset = bytes.len() - rest.len();
            let Some((opcode, body, after)) = record(rest) else {
                parts.cut = Some(offset);
                break;
            };
            parts.parts.push(Part { offset, opcode, body });
            rest = after;
        }
        parts.cut = parts.cut.or((!finished).then_some(bytes.len()));
        Some(parts)
    }
}

/// The next record's kind and body, and what follows it; nothing where it is incomplete or, as a disk's untouched blocks
/// are, all zero.
fn record(bytes: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let (&opcode, rest) = bytes.split_first()?;
    let (length, rest) = rest.split_first_chunk()?;
    let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
    let (body, after) = rest.split_at_checked(length)?;
    (opcode != 0).then_some((opcode, body, after))
}

/// Name and content of an attachment; nothing when it does not fit its check sum.
///
/// By hand: the crate indexes beyond the end of a damaged one.
pub(super) fn attachment(body: &[u8]) -> Option<(&[u8], &[u8])> {
    const TIMES: usize = size_of::<[u64; 2]>();
    let (checked, sum) = body.split_last_chunk()?;
    let (name, rest) = counted(checked.get(TIMES..)?)?;
    let (_media_type, rest) = counted(rest)?;
    let (length, data) = rest.split_first_chunk()?;
    let sum = u32::from_le_bytes(*sum);
    let fits = u64::from_le_bytes(*length) == data.len() as u64 && (sum == 0 || sum == crc32fast::hash(checked));
    fits.then_some((name, data))
}

/// Bytes behind their number, and what follows.
fn counted(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    rest.split_at_checked(usize::try_from(u32::from_le_bytes(*length)).ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(records: &[(u8, &[u8])]) -> Vec<u8> {
        let written = records
            .iter()
            .flat_map(|(opcode, body)| [&[*opcode][..], &(body.len() as u64).to_le_bytes(), body].concat());
        MAGIC.iter().copied().chain(written).collect()
    }

    #[test]
    fn records_are_found_with_their_places_up_to_a_cut() {
        let bytes = with(&[(op::HEADER, b"abc"), (op::CHUNK, b"de")]);
        let offsets = |bytes: &[u8]| {
            let parts = Parts::of(bytes).unwrap();
            (parts.parts.iter().map(|part| part.offset).collect::<Vec<_>>(), parts.cut)
        };
        assert_eq!(offsets(&bytes), (vec![8, 20], Some(31)), "without an end");
        assert_eq!(offsets(&bytes[..30]), (vec![8], Some(20)));
        assert_eq!(offsets(&bytes[..22]), (vec![8], Some(20)), "within the length");
        assert_eq!(offsets(&[&bytes[..], &[0; 40]].concat()), (vec![8, 20], Some(31)), "zeros after the end");
        let longer = [&bytes[..21], &u64::MAX.to_le_bytes(), b"de"].concat();
        assert_eq!(offsets(&longer), (vec![8], Some(20)));
        assert!(Parts::of(b"time_s,u\n").is_none());
    }

    #[test]
    fn a_file_with_an_end_is_finished() {
        let mut bytes = with(&[(op::HEADER, b"abc"), (op::DATA_END, b"crc_"), (op::FOOTER, b"")]);
        bytes.extend_from_slice(MAGIC);
        let parts = Parts::of(&bytes).unwrap();
        assert_eq!((parts.parts.len(), parts.cut, parts.finished), (2, None, true));
        let parts = Parts::of(&bytes[..bytes.len() - 1]).unwrap();
        assert_eq!((parts.cut, parts.finished), (Some(bytes.len() - 1), false));
    }
}
