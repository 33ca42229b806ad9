//! SHA-256, by which a file knows its parents.

use crate::error::{Error, Tried};
use crate::write::refused;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// SHA-256 of `bytes` in hexadecimal, lower case.
pub fn sha256_hex(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// SHA-256 of a file of any length, a block at a time.
///
/// Errors: those of [`read_bytes`](crate::read_bytes).
pub(crate) fn sha256_of(path: &Path) -> Result<String, Error> {
    const BLOCK: usize = 1 << 20;
    let refused = |error| refused(Tried::Read, path, &error);
    let mut file = File::open(path).map_err(refused)?;
    let (mut hash, mut block) = (Sha256::new(), vec![0; BLOCK]);
    loop {
        match file.read(&mut block).map_err(refused)? {
            0 => return Ok(hex(&hash.finalize())),
            length => hash.update(&block[..length]),
        }
    }
}

fn hex(digest: &[u8]) -> String {
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_standard_s_own_examples() {
        // FIPS 180-4, the messages "abc" and "".
        assert_eq!(super::sha256_hex(b"abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
        assert_eq!(super::sha256_hex(b""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
        let mut file = tempfile::NamedTempFile::new().unwrap();
        let bytes: Vec<u8> = (0..3_000_000u32).map(|k| (k.wrapping_mul(k) >> 7) as u8).collect();
        std::io::Write::write_all(&mut file, &bytes).unwrap();
        assert_eq!(super::sha256_of(file.path()).unwrap(), super::sha256_hex(&bytes));
    }
}
