//! Projects: a folder with `flexbeam.toml`, which names its files.

use crate::document::Document;
use crate::error::Error;
use crate::misfit::Misfit;
use crate::provenance::Provenance;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// `flexbeam.project/1`: paths as seen from the project's folder.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Project {
    /// What the project is called.
    pub name: Option<String>,
    /// Rig file.
    pub rig: Option<PathBuf>,
    /// Recording.
    pub recording: Option<PathBuf>,
    /// Model file.
    pub model: Option<PathBuf>,
    /// Controller file.
    pub controller: Option<PathBuf>,
    /// Where it came from.
    pub provenance: Option<Provenance>,
}

impl Project {
    /// The file that makes a folder a project.
    pub const FILE: &'static str = "flexbeam.toml";

    /// The project in a folder, its paths joined to the folder.
    ///
    /// Errors: those of [`Document::read`].
    pub fn open(folder: &Path) -> Result<Project, Error> {
        let project = Project::read(&folder.join(Project::FILE))?;
        let join = |path: Option<PathBuf>| path.map(|path| folder.join(path));
        Ok(Project {
            rig: join(project.rig),
            recording: join(project.recording),
            model: join(project.model),
            controller: join(project.controller),
            ..project
        })
    }
}

impl Document for Project {
    const SCHEMA: &'static str = "flexbeam.project/1";
    const HEAD: &'static str = "flexbeam project: the files of this folder.";

    fn provenance(&self) -> Option<&Provenance> {
        self.provenance.as_ref()
    }

    fn check(&self) -> Result<(), Misfit> {
        Ok(())
    }
}
