//! The secret that lets a viewer steer: 128 bits from the system, as a text that a person can copy.

use std::fmt;
use std::io::{self, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

/// Letters of RFC 4648's base 32, small ones.
const ALPHABET: &[u8; 32] = b"abcdefghijklmnopqrstuvwxyz234567";
/// Letters of a token: five bits each.
const LETTERS: usize = 26;

/// What a viewer shows to steer.
#[derive(Clone, PartialEq, Eq)]
pub struct Token(String);

/// A token that cannot be had.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoToken {
    /// The system has no random numbers.
    #[error("found no random numbers ({0}), needed 128 bits for the scope's token\nhint: is /dev/urandom there?")]
    Random(String),
    /// Its file.
    #[error(
        "cannot use the token file {path}: found {reason}, needed a file that can be read, or be made\nhint: a missing one is made, for you alone"
    )]
    File {
        /// Where.
        path: String,
        /// What the system says.
        reason: String,
    },
    /// What stands in it.
    #[error(
        "found a token file {path} without a token, needed one line of 26 letters and digits a-z, 2-7\nhint: remove the file, and a new one is made"
    )]
    Malformed {
        /// Where.
        path: String,
    },
    /// Who may read it.
    #[error(
        "found a token file {path} that others may read (mode {mode:o}), needed one for you alone\nhint: chmod 600, and remove it when others were there: a new one is made"
    )]
    Open {
        /// Where.
        path: String,
        /// Its permissions.
        mode: u32,
    },
}

impl Token {
    /// Real-time: no. A new one.
    ///
    /// Errors: [`NoToken::Random`].
    pub fn new() -> Result<Token, NoToken> {
        let mut bytes = [0; 16];
        getrandom::fill(&mut bytes).map_err(|error| NoToken::Random(error.to_string()))?;
        Ok(Token::of(u128::from_le_bytes(bytes)))
    }

    fn of(bits: u128) -> Token {
        let letter = |k: usize| char::from(ALPHABET[(bits >> (5 * k)) as usize % 32]);
        Token((0..LETTERS).map(letter).collect())
    }

    /// Real-time: no. That of a file, which is made, for its owner alone, where there is none.
    ///
    /// Errors: [`NoToken`].
    pub fn of_file(path: &Path) -> Result<Token, NoToken> {
        use std::os::unix::fs::PermissionsExt;
        let shown = || path.display().to_string();
        let failed = |error: io::Error| NoToken::File { path: shown(), reason: error.to_string() };
        match std::fs::read_to_string(path) {
            Ok(text) => {
                let mode = std::fs::metadata(path).map_err(failed)?.permissions().mode() & 0o777;
                if mode & 0o077 != 0 {
                    return Err(NoToken::Open { path: shown(), mode });
                }
                let text = text.trim();
                let is_token = text.len() == LETTERS && text.bytes().all(|letter| ALPHABET.contains(&letter));
                if is_token { Ok(Token(text.into())) } else { Err(NoToken::Malformed { path: shown() }) }
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let token = Token::new()?;
                let file = std::fs::OpenOptions::new().write(true).create_new(true).mode(0o600).open(path);
                file.and_then(|mut file| writeln!(file, "{token}")).map_err(failed)?;
                Ok(token)
            }
            Err(error) if error.kind() == io::ErrorKind::InvalidData => Err(NoToken::Malformed { path: shown() }),
            Err(error) => Err(failed(error)),
        }
    }

    /// Real-time: no. Whether this is it. How long that takes does not tell how much of it is right.
    pub(super) fn is(&self, offered: &str) -> bool {
        let (mine, theirs) = (self.0.as_bytes(), offered.as_bytes());
        let different = mine.iter().zip(theirs).fold(0, |different, (a, b)| std::hint::black_box(different | (a ^ b)));
        mine.len() == theirs.len() && different == 0
    }
}

/// The token itself.
impl fmt::Display for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Not the token: what is debugged is logged.
impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token(..)")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn a_token_is_26_letters_and_every_bit_counts() {
        let shown = |bits: u128| Token::of(bits).to_string();
        assert_eq!((shown(0), shown(31)), ("a".repeat(26), format!("7{}", "a".repeat(25))));
        let all: std::collections::BTreeSet<String> = (0..128).map(|k| shown(1 << k)).collect();
        assert_eq!(all.len(), 128);
        assert_ne!(Token::new().unwrap(), Token::new().unwrap());
    }

    #[test]
    fn nothing_but_the_whole_token_is_it() {
        let token = Token::of(0x0123_4567_89ab_cdef_0123_4567_89ab_cdef);
        let text = token.to_string();
        assert!(token.is(&text));
        for wrong in ["", &text[1..], &text[..25], &format!("{text}a"), &text.to_uppercase(), &format!(" {text}")] {
            assert!(!token.is(wrong), "{wrong}");
        }
        for k in 0..26 {
            let mut other = text.clone().into_bytes();
            other[k] = if other[k] == b'a' { b'b' } else { b'a' };
            assert!(!token.is(std::str::from_utf8(&other).unwrap()));
        }
        assert_eq!(format!("{token:?}"), "Token(..)");
    }

    #[test]
    fn a_file_is_made_once_for_its_owner_and_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("token");
        let token = Token::of_file(&path).unwrap();
        assert_eq!(std::fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
        assert_eq!(Token::of_file(&path), Ok(token));
        std::fs::set_permissions(&path, PermissionsExt::from_mode(0o640)).unwrap();
        assert!(matches!(Token::of_file(&path), Err(NoToken::Open { mode: 0o640, .. })));
        std::fs::set_permissions(&path, PermissionsExt::from_mode(0o600)).unwrap();
        for text in [&b""[..], b"short", b"abcdefghijklmnopqrstuvwxy1", b"ABCDEFGHIJKLMNOPQRSTUVWXYZ", b"\xff\xff"] {
            std::fs::write(&path, text).unwrap();
            assert!(matches!(Token::of_file(&path), Err(NoToken::Malformed { .. })), "{text:?}");
        }
        assert!(matches!(Token::of_file(folder.path()), Err(NoToken::File { .. })));
        assert!(matches!(Token::of_file(&folder.path().join("none/token")), Err(NoToken::File { .. })));
    }
}
