//! Where a new project comes to stand: made beside it, then moved there.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use flexbeam_files::Project;
use tempfile::TempDir;

use crate::Failure;

/// A place where no project can be made.
#[derive(Debug, thiserror::Error)]
enum NoPlace {
    #[error(
        "found {found} in it, needed a folder that is empty or not there yet\nhint: nothing was made; choose another name"
    )]
    Occupied { found: String },
    #[error(
        "found a file of that name, needed a folder that is empty or not there yet\nhint: nothing was made; choose another name"
    )]
    File,
    #[error(
        "found {0}, needed a folder to make it in\nhint: nothing was made; does the folder above it exist, and may you write there?"
    )]
    Refused(io::Error),
}

/// An empty folder, or the name of one.
pub struct Place {
    /// Absolute.
    folder: PathBuf,
    /// As it was typed.
    typed: PathBuf,
    exists: bool,
}

impl Place {
    /// Errors: a folder that is not empty, a file, a place that cannot be looked at.
    pub fn of(typed: &Path) -> Result<Place, Failure> {
        Place::looked_at(typed).map_err(Failure::while_trying(tried(typed)))
    }

    fn looked_at(typed: &Path) -> Result<Place, NoPlace> {
        let exists = typed.symlink_metadata().is_ok();
        if exists && !typed.is_dir() {
            return Err(NoPlace::File);
        }
        let folder = if exists { typed.canonicalize() } else { std::path::absolute(typed) };
        let folder = folder.map_err(NoPlace::Refused)?;
        if exists && let Some(entry) = fs::read_dir(&folder).map_err(NoPlace::Refused)?.next() {
            let found = entry.map_err(NoPlace::Refused)?.file_name().to_string_lossy().into_owned();
            return Err(NoPlace::Occupied { found });
        }
        Ok(Place { folder, typed: typed.into(), exists })
    }

    /// The folder's own name.
    pub fn name(&self) -> String {
        self.folder.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// A folder beside it, which goes when it is dropped.
    ///
    /// Errors: a folder above that is not there, or may not be written to.
    pub fn beside(&self) -> Result<TempDir, Failure> {
        let above = self.folder.parent().unwrap_or(&self.folder);
        let mut builder = tempfile::Builder::new();
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777)); // less the umask, as for any new folder
        let refused = Failure::while_trying(tried(&self.typed));
        builder.prefix(".flexbeam-new-").tempdir_in(above).map_err(NoPlace::Refused).map_err(refused)
    }

    /// Moves what was made there, `flexbeam.toml` last: it makes the folder a project.
    ///
    /// Errors: those of the system; then nothing stays behind.
    pub fn take(&self, made: TempDir) -> Result<(), Failure> {
        let moved = if self.exists { self.take_each(made.path()) } else { fs::rename(made.path(), &self.folder) };
        moved.map_err(NoPlace::Refused).map_err(Failure::while_trying(tried(&self.typed)))
    }

    /// The folder may be one in which somebody stands: it stays the same one.
    fn take_each(&self, made: &Path) -> io::Result<()> {
        let mut names = fs::read_dir(made)?.map(|entry| Ok(entry?.file_name())).collect::<io::Result<Vec<_>>>()?;
        names.sort_by_key(|name| name == Project::FILE);
        for (k, name) in names.iter().enumerate() {
            if let Err(error) = fs::rename(made.join(name), self.folder.join(name)) {
                names[..k].iter().for_each(|name| drop(fs::remove_file(self.folder.join(name))));
                return Err(error);
            }
        }
        Ok(())
    }
}

fn tried(typed: &Path) -> String {
    format!("make the project {}", typed.display())
}
