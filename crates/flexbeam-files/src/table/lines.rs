//! Lines of a text of any length, one after the other.

use std::io::{self, Read};

/// Longest line that is read [bytes]: fifty thousand columns. A file without line ends must not fill memory.
pub(super) const LONGEST_LINE: usize = 1 << 20;

/// Where a line stands in the file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Mark {
    /// Line, from 1.
    pub line: usize,
    /// Its first byte, from 0.
    pub byte: u64,
}

/// The lines of `source`, with one buffer of [`LONGEST_LINE`].
pub(super) struct Lines<R> {
    source: R,
    buffer: Vec<u8>,
    /// What of the buffer is not yet taken.
    start: usize,
    end: usize,
    /// The next line.
    next: Mark,
    ended: bool,
}

/// Why there is no next line.
#[derive(Debug)]
pub(super) enum NoLine {
    /// It is longer than [`LONGEST_LINE`].
    Long(Mark),
    /// The operating system refused.
    Io(io::ErrorKind),
}

impl<R: Read> Lines<R> {
    /// The lines of `source`, without its byte order mark.
    pub fn new(source: R) -> Result<Lines<R>, NoLine> {
        const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
        let next = Mark { line: 1, byte: 0 };
        let mut lines = Lines { source, buffer: vec![0; LONGEST_LINE], start: 0, end: 0, next, ended: false };
        lines.fill()?;
        if lines.head().starts_with(BYTE_ORDER_MARK) {
            lines.start = BYTE_ORDER_MARK.len();
            lines.next.byte = BYTE_ORDER_MARK.len() as u64;
        }
        Ok(lines)
    }

    /// What stands in the buffer and is not yet taken: at the beginning, the file's first [`LONGEST_LINE`] bytes.
    pub fn head(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }

    /// Whether [`Lines::head`] reaches to the end of the file.
    pub fn is_whole(&self) -> bool {
        self.ended
    }

    /// The next line without its end, and where it stands.
    pub fn next(&mut self) -> Result<Option<(Mark, &[u8])>, NoLine> {
        let mut searched = 0;
        let length = loop {
            match memchr::memchr(b'\n', &self.head()[searched..]) {
                Some(at) => break searched + at + 1,
                None if !self.ended => {
                    searched = self.end - self.start;
                    self.fill()?;
                }
                None => break self.end - self.start,
            }
        };
        if length == 0 {
            return Ok(None);
        }
        let (mark, start) = (self.next, self.start);
        self.start += length;
        self.next = Mark { line: mark.line + 1, byte: mark.byte + length as u64 };
        let line = &self.buffer[start..start + length];
        Ok(Some((mark, line.strip_suffix(b"\n").unwrap_or(line))))
    }

    /// Bytes of the file that were taken.
    pub fn bytes_done(&self) -> u64 {
        self.next.byte
    }

    /// Reads until the buffer is full or the source at its end.
    fn fill(&mut self) -> Result<(), NoLine> {
        self.buffer.copy_within(self.start..self.end, 0);
        self.end -= self.start;
        self.start = 0;
        if self.end == self.buffer.len() {
            return Err(NoLine::Long(self.next));
        }
        while !self.ended && self.end < self.buffer.len() {
            match self.source.read(&mut self.buffer[self.end..]) {
                Ok(0) => self.ended = true,
                Ok(count) => self.end += count,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(NoLine::Io(error.kind())),
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A source that gives a few bytes at a time.
    struct Sips<'a>(&'a [u8], usize);

    impl Read for Sips<'_> {
        fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
            let count = self.1.min(into.len()).min(self.0.len());
            let (now, after) = self.0.split_at(count);
            into[..count].copy_from_slice(now);
            self.0 = after;
            Ok(count)
        }
    }

    fn all(text: &[u8], sip: usize) -> Vec<(usize, u64, Vec<u8>)> {
        let mut lines = Lines::new(Sips(text, sip)).unwrap();
        let mut found = Vec::new();
        while let Some((mark, line)) = lines.next().unwrap() {
            found.push((mark.line, mark.byte, line.to_vec()));
        }
        assert_eq!(lines.bytes_done(), text.len() as u64);
        found
    }

    #[test]
    fn lines_have_their_places_however_the_bytes_come() {
        let text = b"\xef\xbb\xbfa\n\nbc\r\nlast";
        let wanted: Vec<(usize, u64, Vec<u8>)> = [(1, 3, &b"a"[..]), (2, 5, b""), (3, 6, b"bc\r"), (4, 10, b"last")]
            .map(|(l, b, t)| (l, b, t.to_vec()))
            .into();
        for sip in [1, 2, 3, 100] {
            assert_eq!(all(text, sip), wanted);
        }
        assert_eq!(all(b"", 1), []);
        // Many buffers, lines across their borders.
        let long: Vec<u8> = (0..400_000u32).flat_map(|k| format!("{k}\n").into_bytes()).collect();
        let found = all(&long, 4096);
        assert!(long.len() > 2 * LONGEST_LINE && found.len() == 400_000);
        assert!(
            found.iter().enumerate().all(|(k, (line, _, text))| *line == k + 1 && *text == k.to_string().into_bytes())
        );
    }

    #[test]
    fn a_file_without_line_ends_is_refused_and_not_held() {
        let mut text = b"u\n".to_vec();
        text.resize(2 + LONGEST_LINE + 1, b'7');
        let mut lines = Lines::new(&text[..]).unwrap();
        lines.next().unwrap();
        assert!(matches!(lines.next(), Err(NoLine::Long(Mark { line: 2, byte: 2 }))));
    }
}
