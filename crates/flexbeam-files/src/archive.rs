//! A zip archive that depends on its files alone: fixed times, the order in which they are given.

use std::io::{Cursor, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// The bytes of an archive with these files, by their paths with slashes.
///
/// Assumes: no path stands twice; all together they are below 4 GiB.
/// Panics: where that is not so, which is our own bug.
pub fn zip_bytes(files: &[(&str, &[u8])]) -> Vec<u8> {
    archive(files).expect("an archive in memory takes few files with paths of their own")
}

fn archive(files: &[(&str, &[u8])]) -> zip::result::ZipResult<Vec<u8>> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (path, bytes) in files {
        archive.start_file(*path, options())?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish()?.into_inner())
}

/// Of every file: no time but the format's first, readable by all, the same on every system.
fn options() -> SimpleFileOptions {
    let first = DateTime::default();
    let plain = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    plain.last_modified_time(first).unix_permissions(0o644)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    const FILES: [(&str, &[u8]); 2] = [("b/two.txt", b"two two two two"), ("a.txt", b"")];

    #[test]
    fn files_come_back_in_their_order_without_a_date() {
        let bytes = zip_bytes(&FILES);
        let mut archive = zip::ZipArchive::new(Cursor::new(&bytes)).unwrap();
        for (k, (path, content)) in FILES.iter().enumerate() {
            let mut file = archive.by_index(k).unwrap();
            let mut found = Vec::new();
            file.read_to_end(&mut found).unwrap();
            assert_eq!((file.name().unwrap().as_ref(), found.as_slice()), (*path, *content));
            assert_eq!(file.last_modified().map(|time| time.year()), Some(1980));
        }
        assert_eq!(bytes, zip_bytes(&FILES));
    }
}
