//! Frames on a serial line: consistent overhead byte stuffing (COBS), a zero behind each frame.
//!
//! Enters: frames, or bytes as they come. Leaves: bytes without a zero but the last, or frames. After lost or changed bytes the
//! next zero puts the reader right again: what is damaged costs its own frame, or two where the zero between them is lost.
//! Deliberately absent: the line itself.
//!
//! Source: Cheshire and Baker 1999, Consistent overhead byte stuffing.

use crate::wire::{FrameBuffer, LONGEST_FRAME};
use cobs::{DecodeResult, DecoderState};

/// A frame on the line, a zero before and behind it.
///
/// The zero in front closes whatever lies half-sent on the line; where nothing does it may be left out.
pub struct Stuffed {
    bytes: [u8; Stuffed::ROOM],
    length: usize,
}

impl Stuffed {
    /// Longest frame of version 1, one byte of overhead, two zeros.
    const ROOM: usize = flexbeam_files::frame::MEASUREMENT_BYTES + 3;

    /// Real-time: yes. Nothing for a frame longer than any of version 1.
    pub fn new(frame: &[u8]) -> Option<Stuffed> {
        let mut bytes = [0; Stuffed::ROOM];
        let length = cobs::try_encode(frame, bytes.get_mut(1..Stuffed::ROOM - 1)?).ok()?;
        Some(Stuffed { bytes, length: length + 2 })
    }

    /// Real-time: yes. With the zero in front.
    pub fn closing(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }

    /// Real-time: yes. Without it.
    pub fn plain(&self) -> &[u8] {
        self.closing().get(1..).unwrap_or_default()
    }
}

/// Finds frames in the bytes of a line, fed one by one.
pub struct LineReader {
    state: DecoderState,
    frame: FrameBuffer,
    length: usize,
}

impl Default for LineReader {
    /// Real-time: no.
    fn default() -> LineReader {
        LineReader { state: DecoderState::Idle, frame: [0; LONGEST_FRAME], length: 0 }
    }
}

impl LineReader {
    /// Real-time: yes. The frame that ends with this byte: empty when what lay before the zero is none.
    pub fn push(&mut self, byte: u8) -> Option<&[u8]> {
        match self.state.feed(byte) {
            Ok(DecodeResult::NoData) => None,
            Ok(DecodeResult::DataStart) => {
                self.length = 0;
                None
            }
            Ok(DecodeResult::DataContinue(byte)) => {
                self.keep(byte);
                None
            }
            // Longer than the buffer: what is kept is not the whole.
            Ok(DecodeResult::DataComplete) => Some(self.frame.get(..self.length).unwrap_or_default()),
            Err(_) => Some(&[]),
        }
    }

    /// Real-time: yes.
    fn keep(&mut self, byte: u8) {
        if let Some(place) = self.frame.get_mut(self.length) {
            *place = byte;
        }
        self.length = self.length.saturating_add(1);
    }
}
