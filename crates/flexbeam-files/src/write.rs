//! Whole files in and out: nothing is written over unasked, and no half-written file stays behind.

use crate::error::{Error, Tried};
use crate::fault::Fault;
use std::fs;
use std::io::{self, Write};
use std::path::Path;

/// What to do when a file of that name stands already, with other content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overwrite {
    /// Leave it alone and say so (the default on the command line).
    Refuse,
    /// Replace it (`--force`).
    Allow,
}

/// What became of a write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Written {
    /// A file that was not there before.
    New,
    /// A file in place of another one.
    Replaced,
    /// The same bytes stood there already; nothing was touched.
    Unchanged,
}

/// All bytes of a file.
///
/// Errors: [`Fault::IsFolder`], [`Fault::Io`].
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, Error> {
    fs::read(path).map_err(|error| refused(Tried::Read, path, &error))
}

/// Writes `bytes` beside `path`, then renames: readers see the old file or the new one, never a part.
///
/// Errors: [`Fault::Exists`] when a file with other content stands there and `overwrite` refuses; [`Fault::IsFolder`];
/// [`Fault::Io`]. After an error the old file stands as it was.
pub fn write_bytes(path: &Path, bytes: &[u8], overwrite: Overwrite) -> Result<Written, Error> {
    let outcome = match standing(path, bytes)? {
        Some(true) => return Ok(Written::Unchanged),
        Some(false) if overwrite == Overwrite::Refuse => return Err(Error::new(Tried::Write, path, Fault::Exists)),
        Some(false) => Written::Replaced,
        None => Written::New,
    };
    beside_then_rename(path, bytes, overwrite).map_err(|error| refused(Tried::Write, path, &error))?;
    Ok(outcome)
}

/// Whether a write to `path` would be refused, without writing: ask before an hour of computing.
///
/// Errors: [`Fault::Exists`] when `overwrite` refuses and anything stands there; [`Fault::IsFolder`].
pub fn check_free(path: &Path, overwrite: Overwrite) -> Result<(), Error> {
    let fault = match fs::metadata(path) {
        Ok(found) if found.is_dir() => Fault::IsFolder,
        Ok(_) if overwrite == Overwrite::Refuse => Fault::Exists,
        _ => return Ok(()),
    };
    Err(Error::new(Tried::Write, path, fault))
}

/// Whether the file at `path` has exactly these bytes; nothing when there is no file.
fn standing(path: &Path, bytes: &[u8]) -> Result<Option<bool>, Error> {
    match fs::metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Ok(found) if found.len() != bytes.len() as u64 && !found.is_dir() => Ok(Some(false)),
        _ => match fs::read(path) {
            Ok(found) => Ok(Some(found == bytes)),
            Err(error) => Err(refused(Tried::Write, path, &error)),
        },
    }
}

fn beside_then_rename(path: &Path, bytes: &[u8], overwrite: Overwrite) -> io::Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666)); // less the umask, as for any new file
    let mut beside = builder.prefix(".flexbeam-").tempfile_in(folder)?;
    beside.write_all(bytes)?;
    beside.as_file().sync_all()?;
    match overwrite {
        Overwrite::Refuse => beside.persist_noclobber(path)?,
        Overwrite::Allow => beside.persist(path)?,
    };
    Ok(())
}

fn refused(tried: Tried, path: &Path, error: &io::Error) -> Error {
    let fault = match error.kind() {
        io::ErrorKind::IsADirectory => Fault::IsFolder,
        io::ErrorKind::AlreadyExists => Fault::Exists,
        kind => Fault::Io { kind, message: error.to_string() },
    };
    Error::new(tried, path, fault)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        fs::read_dir(folder).unwrap().map(|f| f.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn nothing_is_written_over_unasked() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.toml");
        assert_eq!(write_bytes(&path, b"one", Overwrite::Refuse).unwrap(), Written::New);
        assert_eq!(write_bytes(&path, b"one", Overwrite::Refuse).unwrap(), Written::Unchanged);
        let error = write_bytes(&path, b"two", Overwrite::Refuse).unwrap_err();
        assert_eq!(*error.fault, Fault::Exists);
        assert_eq!(check_free(&path, Overwrite::Refuse).unwrap_err(), error);
        assert_eq!(fs::read(&path).unwrap(), b"one");
        assert_eq!(write_bytes(&path, b"two", Overwrite::Allow).unwrap(), Written::Replaced);
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(names(folder.path()), ["model.toml"], "no half-written file stays behind");
    }

    #[test]
    fn a_folder_is_not_a_file() {
        let folder = tempfile::tempdir().unwrap();
        for overwrite in [Overwrite::Refuse, Overwrite::Allow] {
            assert_eq!(*write_bytes(folder.path(), b"x", overwrite).unwrap_err().fault, Fault::IsFolder);
            assert_eq!(*check_free(folder.path(), overwrite).unwrap_err().fault, Fault::IsFolder);
        }
        assert_eq!(*read_bytes(folder.path()).unwrap_err().fault, Fault::IsFolder);
    }

    #[test]
    fn a_missing_folder_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let error = write_bytes(&folder.path().join("no/such/model.toml"), b"x", Overwrite::Allow).unwrap_err();
        assert!(matches!(*error.fault, Fault::Io { kind: io::ErrorKind::NotFound, .. }), "{error}");
        assert_eq!(names(folder.path()), [] as [&str; 0]);
    }

    #[cfg(unix)]
    #[test]
    fn a_new_file_has_the_permissions_of_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
        write_bytes(&ours, b"x", Overwrite::Refuse).unwrap();
        fs::write(&plain, b"x").unwrap();
        let mode = |path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }
}
