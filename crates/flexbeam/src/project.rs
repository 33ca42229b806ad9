//! A project on the command line: its folder, or its `flexbeam.toml`.

use std::path::{Path, PathBuf};

use flexbeam_files::{Controller, Document, Error, Fault, Project, Tried};

use crate::Failure;

/// A folder that is no project.
#[derive(Debug, thiserror::Error)]
#[error(
    "found a folder without flexbeam.toml, needed a project or a file\nhint: flexbeam new DIR makes a project; a controller file runs without one"
)]
struct NoProject;

/// A project that was found and read.
pub struct Opened {
    /// Its folder; empty for the working folder.
    pub folder: PathBuf,
    /// Its file.
    pub file: PathBuf,
    /// What it says, paths joined to the folder.
    pub project: Project,
}

/// The file of a project where `path` is its folder; any other path as it is.
pub fn file_of(path: &Path) -> PathBuf {
    if path.is_dir() { in_folder(path).join(Project::FILE) } else { path.into() }
}

/// The project that `path` is; nothing where it is any other file.
///
/// Errors: a folder that is no project; those of [`Project::open`].
pub fn opened(path: &Path) -> Result<Option<Opened>, Failure> {
    let file = file_of(path);
    if file.file_name() != Some(Project::FILE.as_ref()) {
        return Ok(None);
    }
    if path.is_dir() && !file.is_file() {
        return Err(Failure::while_trying(format!("open the project {}", path.display()))(NoProject));
    }
    let folder = file.parent().unwrap_or(Path::new("")).to_path_buf();
    let project = Project::open(&folder)?;
    Ok(Some(Opened { folder, file, project }))
}

/// The working folder has no name, so that the files in it are called by theirs.
fn in_folder(path: &Path) -> &Path {
    if path == Path::new(".") { Path::new("") } else { path }
}

impl Opened {
    /// Its name; that of its folder where it has none.
    pub fn name(&self) -> String {
        let of_folder = || Some(std::path::absolute(&self.file).ok()?.parent()?.file_name()?.to_string_lossy().into());
        self.project.name.clone().or_else(of_folder).unwrap_or_default()
    }

    /// Its controller file.
    ///
    /// Errors: a project that names none.
    pub fn controller(&self) -> Result<PathBuf, Error> {
        let missing = || Error::new(Tried::Read, &self.file, Fault::MissingKey { key: "controller".into() });
        self.project.controller.clone().ok_or_else(missing)
    }
}

/// The controller that runs, with a project's settings in the place of its own, and the rig file that goes with it.
///
/// Errors: those of [`opened`] and of reading.
pub fn controller_and_rig(path: &Path, rig: Option<&Path>) -> Result<(Controller, Option<PathBuf>), Failure> {
    let rig = rig.map(Path::to_path_buf);
    let Some(opened) = opened(path)? else { return Ok((Controller::read(path)?, rig)) };
    let file = Controller::read(&opened.controller()?)?;
    let settings = file.settings.with(&opened.project.settings);
    Ok((Controller { settings, ..file }, rig.or(opened.project.rig)))
}
