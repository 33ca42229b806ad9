//! What stands between two cells of a line.

/// Between two cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Separator {
    /// This character, with or without blanks around it.
    Character(u8),
    /// Blanks and tabs, as many as there are.
    WhiteSpace,
}

impl Separator {
    /// Every one that is known; where two read a table alike, the earlier.
    pub const ALL: [Separator; 4] =
        [Separator::Character(b';'), Separator::Character(b','), Separator::Character(b'\t'), Separator::WhiteSpace];

    /// In words, for several of them.
    pub fn words(self) -> &'static str {
        match self {
            Separator::Character(b';') => "semicolons",
            Separator::Character(b'\t') => "tabs",
            Separator::Character(_) => "commas",
            Separator::WhiteSpace => "white space",
        }
    }

    /// The cells of a line, trimmed; separators within quotes do not count.
    pub fn cells(self, line: &str) -> Vec<&str> {
        let mut cells = Vec::new();
        let (mut quoted, mut start) = (false, 0);
        for (k, byte) in line.bytes().enumerate() {
            match byte {
                b'"' => quoted = !quoted,
                _ if !quoted && self.separates(byte) => {
                    cells.push(line[start..k].trim_ascii());
                    start = k + 1;
                }
                _ => {}
            }
        }
        cells.push(line[start..].trim_ascii());
        if self == Separator::WhiteSpace {
            cells.retain(|cell| !cell.is_empty());
        }
        cells
    }

    pub fn separates(self, byte: u8) -> bool {
        match self {
            Separator::Character(c) => byte == c,
            Separator::WhiteSpace => byte.is_ascii_whitespace(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_trimmed_and_quotes_hold_separators() {
        let comma = Separator::Character(b',');
        assert_eq!(comma.cells("a , \"b, c\",,d "), ["a", "\"b, c\"", "", "d"]);
        assert_eq!(Separator::WhiteSpace.cells("  a\t\t\"b c\"  d\t"), ["a", "\"b c\"", "d"]);
        assert_eq!(Separator::Character(b'\t').cells("a\t\tb"), ["a", "", "b"]);
        assert_eq!((comma.cells(""), Separator::WhiteSpace.cells(" ")), (vec![""], vec![]));
    }
}
