//! Whole files in and out: nothing is written over unasked, and no half-written file stays behind.

use crate::document::SCHEMA_KEY;
use crate::error::{Error, Tried};
use crate::fault::Fault;
use crate::json_document::JSON_HEAD;
use crate::mat::is_ours;
use crate::mat_document::SCRIPT_HEAD;
use crate::run_file::RunOrigin;
use std::fs;
use std::io::{self, Write};
use std::path::Path;

/// What to do when a file of that name stands already, with other content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overwrite {
    /// Leave it alone and say so.
    Refuse,
    /// Replace it if it is of the same kind: an older model by a model, a recording by a recording, a run by a run. A file
    /// that a person wrote, or of which flexbeam knows nothing, stays.
    SameKind,
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
/// Errors: [`Fault::NoFile`], [`Fault::IsFolder`], [`Fault::Io`].
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, Error> {
    fs::read(path).map_err(|error| refused(Tried::Read, path, &error))
}

/// Writes `bytes` beside `path`, then renames: readers see the old file or the new one, never a part.
///
/// Errors: [`Fault::Exists`] when a file with other content stands there and `overwrite` refuses; [`Fault::IsFolder`];
/// [`Fault::NoFolder`]; [`Fault::Io`]. After an error the old file stands as it was.
pub fn write_bytes(path: &Path, bytes: &[u8], overwrite: Overwrite) -> Result<Written, Error> {
    let outcome = match standing(path)? {
        None => Written::New,
        Some(old) if old == bytes => return Ok(Written::Unchanged),
        Some(old) if overwrite.permits(&old, bytes) => Written::Replaced,
        Some(_) => return Err(Error::new(Tried::Write, path, Fault::Exists)),
    };
    beside_then_rename(path, bytes, overwrite).map_err(|error| refused(Tried::Write, path, &error))?;
    Ok(outcome)
}

/// Replaces a file's bytes, as [`write_bytes`] does; the file keeps its permissions, and a link to it stays one.
///
/// Errors: [`Fault::NoFile`]; [`Fault::Io`], for a file that may only be read, too. Then the old file stands as it was.
pub(crate) fn replace_bytes(path: &Path, bytes: &[u8]) -> Result<Written, Error> {
    let refused = |error: io::Error| refused(Tried::Save, path, &error);
    let path = fs::canonicalize(path).map_err(refused)?;
    if fs::read(&path).map_err(refused)? == bytes {
        return Ok(Written::Unchanged);
    }
    let permissions = fs::metadata(&path).map_err(refused)?.permissions();
    if permissions.readonly() {
        return Err(refused(io::ErrorKind::PermissionDenied.into()));
    }
    let mut beside = tempfile::Builder::new().prefix(".flexbeam-").tempfile_in(folder_of(&path)).map_err(refused)?;
    beside.write_all(bytes).map_err(refused)?;
    beside.as_file().set_permissions(permissions).map_err(refused)?;
    beside.as_file().sync_all().map_err(refused)?;
    beside.persist(&path).map_err(|error| refused(error.error))?;
    Ok(Written::Replaced)
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Whether a recording, or a file of no kind of flexbeam's, could be written to `path`: ask before an hour of computing.
/// For documents there is [`Document::check_free`](crate::Document::check_free).
///
/// Errors: [`Fault::Exists`] when `overwrite` refuses what stands there; [`Fault::IsFolder`].
pub fn check_free(path: &Path, overwrite: Overwrite) -> Result<(), Error> {
    check_free_for(Kind::Recording, path, overwrite)
}

/// As [`check_free`], for a document of this schema.
pub(crate) fn check_free_for_schema(schema: &str, path: &Path, overwrite: Overwrite) -> Result<(), Error> {
    check_free_for(Kind::of_schema(schema), path, overwrite)
}

/// As [`check_free`], for the recording of a run.
pub(crate) fn check_free_for_run(path: &Path, overwrite: Overwrite) -> Result<(), Error> {
    check_free_for(Kind::Run, path, overwrite)
}

/// As [`check_free`], for a MATLAB file.
pub fn check_free_for_mat(path: &Path, overwrite: Overwrite) -> Result<(), Error> {
    check_free_for(Kind::Mat, path, overwrite)
}

/// As [`check_free`], for a document in JSON.
pub fn check_free_for_json(path: &Path, overwrite: Overwrite) -> Result<(), Error> {
    check_free_for(Kind::Json, path, overwrite)
}

/// As [`check_free`], for a script of MATLAB's language.
pub fn check_free_for_script(path: &Path, overwrite: Overwrite) -> Result<(), Error> {
    check_free_for(Kind::Script, path, overwrite)
}

/// Gives the complete recording of a run at `part` its name.
///
/// Errors: as [`write_bytes`]; the part then stays.
pub(crate) fn rename_run(part: &Path, path: &Path, overwrite: Overwrite) -> Result<Written, Error> {
    check_free_for_run(path, overwrite)?;
    let outcome = if path.exists() { Written::Replaced } else { Written::New };
    let renamed = match overwrite {
        Overwrite::Refuse => rename_to_free_name(part, path),
        Overwrite::SameKind | Overwrite::Allow => fs::rename(part, path),
    };
    renamed.map_err(|error| refused(Tried::Write, path, &error))?;
    Ok(outcome)
}

/// Errors: [`io::ErrorKind::AlreadyExists`] where a file has come to stand there since it was asked.
fn rename_to_free_name(part: &Path, path: &Path) -> io::Result<()> {
    let part = tempfile::TempPath::try_from_path(part)?;
    part.persist_noclobber(path).map_err(|refused| match refused.path.keep() {
        Ok(_) => refused.error,
        Err(kept) => kept.error,
    })
}

fn check_free_for(new: Kind<'_>, path: &Path, overwrite: Overwrite) -> Result<(), Error> {
    let permitted = standing(path)?.is_none_or(|old| overwrite.permits_kind(Kind::of(&old), Some(new)));
    if permitted { Ok(()) } else { Err(Error::new(Tried::Write, path, Fault::Exists)) }
}

impl Overwrite {
    fn permits(self, old: &[u8], new: &[u8]) -> bool {
        self.permits_kind(Kind::of(old), Kind::of(new))
    }

    fn permits_kind(self, old: Option<Kind<'_>>, new: Option<Kind<'_>>) -> bool {
        match self {
            Overwrite::Refuse => false,
            Overwrite::SameKind => old.is_some() && old == new,
            Overwrite::Allow => true,
        }
    }
}

/// What flexbeam recognises as its own.
#[derive(PartialEq)]
enum Kind<'a> {
    /// CSV with the time first, as recordings are written.
    Recording,
    /// MCAP with our metadata. Apart from CSV, so that an export cannot take the place of what it was made from.
    Run,
    /// A MATLAB file that says in its head that it is ours.
    Mat,
    /// A document in JSON, its schema first.
    Json,
    /// A script that says in its first line that it is ours.
    Script,
    /// A document of this schema, whatever its version.
    Document(&'a str),
}

impl<'a> Kind<'a> {
    fn of(bytes: &'a [u8]) -> Option<Kind<'a>> {
        if RunOrigin::of(bytes).is_some() {
            return Some(Kind::Run);
        }
        if is_ours(bytes) {
            return Some(Kind::Mat);
        }
        let text = std::str::from_utf8(bytes).ok()?;
        if text.starts_with(JSON_HEAD) {
            return Some(Kind::Json);
        }
        if text.starts_with(SCRIPT_HEAD) {
            return Some(Kind::Script);
        }
        let first = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#'))?;
        match first.split_once('=') {
            None => first.starts_with("time_s,").then_some(Kind::Recording),
            Some((key, value)) if key.trim() == SCHEMA_KEY => Some(Kind::of_schema(value.trim().trim_matches('"'))),
            Some(_) => None,
        }
    }

    fn of_schema(schema: &'a str) -> Kind<'a> {
        Kind::Document(schema.split('/').next().unwrap_or(schema))
    }
}

/// The bytes at `path`; nothing when there is no file.
fn standing(path: &Path) -> Result<Option<Vec<u8>>, Error> {
    match fs::read(path) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(refused(Tried::Write, path, &error)),
    }
}

fn beside_then_rename(path: &Path, bytes: &[u8], overwrite: Overwrite) -> io::Result<()> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666)); // less the umask, as for any new file
    let mut beside = builder.prefix(".flexbeam-").tempfile_in(folder_of(path))?;
    beside.write_all(bytes)?;
    beside.as_file().sync_all()?;
    match overwrite {
        Overwrite::Refuse => beside.persist_noclobber(path)?,
        Overwrite::SameKind | Overwrite::Allow => beside.persist(path)?,
    };
    Ok(())
}

pub(crate) fn refused(tried: Tried, path: &Path, error: &io::Error) -> Error {
    let fault = match error.kind() {
        io::ErrorKind::IsADirectory => Fault::IsFolder,
        io::ErrorKind::AlreadyExists => Fault::Exists,
        io::ErrorKind::NotFound if tried == Tried::Write => Fault::NoFolder,
        io::ErrorKind::NotFound => Fault::NoFile,
        kind => Fault::Io { kind },
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
    fn a_file_of_the_same_kind_may_be_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let model: &[u8] = b"# flexbeam model\nschema = \"flexbeam.model/1\"\nA = 1\n";
        let newer: &[u8] = b"schema = \"flexbeam.model/2\"\n";
        let (recording, longer): (&[u8], &[u8]) = (b"time_s,u\n0,1\n", b"time_s,u\n0,1\n1,2\n");
        let (notes, table): (&[u8], &[u8]) = (b"buy milk\n", b"a = 1\nschema = \"flexbeam.model/1\"\n");
        for (old, new, schema, permitted) in [
            (model, newer, Some("flexbeam.model/1"), true),
            (recording, longer, None, true),
            (model, recording, None, false),
            (recording, model, Some("flexbeam.model/1"), false),
            (notes, model, Some("flexbeam.model/1"), false),
            (table, model, Some("flexbeam.model/1"), false),
            (notes, longer, None, false),
        ] {
            fs::write(&path, old).unwrap();
            let free = match schema {
                Some(schema) => check_free_for_schema(schema, &path, Overwrite::SameKind),
                None => check_free(&path, Overwrite::SameKind),
            };
            assert_eq!(free.is_ok(), permitted);
            assert_eq!(write_bytes(&path, new, Overwrite::SameKind).is_ok(), permitted);
            assert_eq!(fs::read(&path).unwrap(), if permitted { new } else { old });
        }
        fs::remove_file(&path).unwrap();
        check_free(&path, Overwrite::Refuse).unwrap();
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
        assert_eq!(*error.fault, Fault::NoFolder);
        assert_eq!(names(folder.path()), [] as [&str; 0]);
    }

    #[cfg(unix)]
    #[test]
    fn a_replaced_file_keeps_its_permissions_and_its_links() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        assert_eq!(*replace_bytes(&file, b"x").unwrap_err().fault, Fault::NoFile);
        fs::write(&file, b"one").unwrap();
        std::os::unix::fs::symlink("file", &link).unwrap();
        let mode = |mode| fs::set_permissions(&file, fs::Permissions::from_mode(mode)).unwrap();
        mode(0o640);
        assert_eq!(replace_bytes(&link, b"two").unwrap(), Written::Replaced);
        assert_eq!(replace_bytes(&link, b"two").unwrap(), Written::Unchanged);
        assert_eq!((fs::read(&file).unwrap(), fs::read_link(&link).is_ok()), (b"two".to_vec(), true));
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
        mode(0o440);
        let refused = replace_bytes(&file, b"three").unwrap_err();
        assert_eq!(*refused.fault, Fault::Io { kind: io::ErrorKind::PermissionDenied });
        assert_eq!(fs::read(&file).unwrap(), b"two");
        assert_eq!(names(folder.path()).len(), 2, "no half-written file stays behind");
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
