//! A folder of files: all of them or none, and nothing of a person's is lost.

use crate::error::{Error, Tried};
use crate::fault::Fault;
use crate::write::{Overwrite, refused};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Whether a folder of files could be written to `path`: ask before the work.
///
/// Errors: [`Fault::NotEmpty`] unless `overwrite` allows it, [`Fault::IsFile`], [`Fault::Io`].
pub fn check_free_folder(path: &Path, overwrite: Overwrite) -> Result<(), Error> {
    match fs::read_dir(path).map(|mut entries| entries.next().is_none()) {
        Ok(empty) if empty || overwrite == Overwrite::Allow => Ok(()),
        Ok(_) => Err(Error::new(Tried::Write, path, Fault::NotEmpty)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(error) if error.kind() == io::ErrorKind::NotADirectory => {
            Err(Error::new(Tried::Write, path, Fault::IsFile))
        }
        Err(error) => Err(refused(Tried::Write, path, &error)),
    }
}

/// Writes texts by their paths below `path`, which is made: beside it first, then under its name in one step. Where a folder with
/// something in it may be written to, the files are renamed into it one by one when all are on the disk, and what has other names
/// stays.
///
/// Errors: as [`check_free_folder`], and [`Fault::NoFolder`] for the folder around it. After an error nothing is half-written.
pub fn write_folder(path: &Path, files: &[(&str, &str)], overwrite: Overwrite) -> Result<(), Error> {
    check_free_folder(path, overwrite)?;
    put(path, files).map_err(|error| refused(Tried::Write, path, &error))
}

fn put(path: &Path, files: &[(&str, &str)]) -> io::Result<()> {
    let full = path.read_dir().is_ok_and(|mut entries| entries.next().is_some());
    let around = if full { path } else { around(path) };
    let beside = tempfile::Builder::new().prefix(".flexbeam-").tempdir_in(around)?;
    #[cfg(unix)]
    give_usual_permissions(beside.path())?;
    for (name, text) in files {
        let file = beside.path().join(name);
        fs::create_dir_all(self::around(&file))?;
        fs::write(&file, text)?;
        fs::File::open(&file)?.sync_all()?;
    }
    if full {
        return files.iter().try_for_each(|(name, _)| {
            let target = path.join(name);
            fs::create_dir_all(self::around(&target))?;
            fs::rename(beside.path().join(name), target)
        });
    }
    fs::rename(beside.path(), path)?;
    // It has another name now, so there is nothing to remove.
    let _: PathBuf = beside.keep();
    Ok(())
}

fn around(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A temporary folder is its owner's alone; this one is to be as any new folder, which a probe beside it shows.
#[cfg(unix)]
fn give_usual_permissions(folder: &Path) -> io::Result<()> {
    let probe = folder.join("probe");
    fs::create_dir(&probe)?;
    fs::set_permissions(folder, fs::metadata(&probe)?.permissions())?;
    fs::remove_dir(probe)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILES: [(&str, &str); 2] = [("a.txt", "one\n"), ("src/b.txt", "two\n")];

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|f| f.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_new_or_empty_folder_gets_all_files_and_nothing_else() {
        let place = tempfile::tempdir().unwrap();
        fs::create_dir(place.path().join("empty")).unwrap();
        for name in ["new", "empty"] {
            write_folder(&place.path().join(name), &FILES, Overwrite::Refuse).unwrap();
            assert_eq!(names(&place.path().join(name)), ["a.txt", "src"]);
            assert_eq!(fs::read_to_string(place.path().join(name).join("src/b.txt")).unwrap(), "two\n");
        }
        assert_eq!(names(place.path()), ["empty", "new"], "nothing half-written stays");
    }

    #[test]
    fn a_full_folder_is_left_alone_until_it_is_allowed_and_other_files_stay() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("full");
        fs::create_dir(&path).unwrap();
        fs::write(path.join("mine"), "mine").unwrap();
        fs::write(path.join("a.txt"), "old").unwrap();
        for overwrite in [Overwrite::Refuse, Overwrite::SameKind] {
            assert_eq!(*write_folder(&path, &FILES, overwrite).unwrap_err().fault, Fault::NotEmpty);
        }
        write_folder(&path, &FILES, Overwrite::Allow).unwrap();
        assert_eq!(names(&path), ["a.txt", "mine", "src"]);
        assert_eq!(fs::read_to_string(path.join("a.txt")).unwrap(), "one\n");
    }

    #[test]
    fn a_file_and_a_missing_place_are_told() {
        let place = tempfile::tempdir().unwrap();
        let file = place.path().join("file");
        fs::write(&file, "x").unwrap();
        assert_eq!(*write_folder(&file, &FILES, Overwrite::Allow).unwrap_err().fault, Fault::IsFile);
        let lost = place.path().join("no/such/folder");
        assert_eq!(*write_folder(&lost, &FILES, Overwrite::Allow).unwrap_err().fault, Fault::NoFolder);
        assert_eq!(names(place.path()), ["file"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_new_folder_has_the_permissions_of_any_new_folder() {
        use std::os::unix::fs::PermissionsExt;
        let place = tempfile::tempdir().unwrap();
        let (ours, plain) = (place.path().join("ours"), place.path().join("plain"));
        write_folder(&ours, &FILES, Overwrite::Refuse).unwrap();
        fs::create_dir(&plain).unwrap();
        let mode = |path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }
}
