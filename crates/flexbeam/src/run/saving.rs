//! A project that a run saves into.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use flexbeam_files::{Error, ProjectFile};
use flexbeam_runtime::scope::Save;
use flexbeam_runtime::{Live, run_settings};

use crate::cli;
use crate::project::Opened;

/// A run that has not begun.
#[derive(Debug, thiserror::Error)]
#[error("found a run that is not armed yet, needed its first settings\nhint: save when the rig is homed")]
struct NotArmedYet;

/// The project's file: from the moment on when the run's first settings are known.
pub struct Saving {
    path: PathBuf,
    /// Keys that the command line states.
    stated: Vec<&'static str>,
    file: Arc<OnceLock<ProjectFile>>,
}

impl Saving {
    /// Of a project, and a command line that may say more.
    pub fn of(opened: &Opened, given: &cli::Given<cli::Run>) -> Saving {
        let keys = [
            ("law", "law"),
            ("signal", "reference.shape"),
            ("signal", "reference.amplitude_rad"),
            ("amplitude_deg", "reference.amplitude_rad"),
            ("signal_period", "reference.period_s"),
            ("offset_deg", "reference.offset_rad"),
        ];
        let stated = keys.into_iter().filter(|(field, _)| given.states(field)).map(|(_, key)| key).collect();
        Saving { path: opened.file.clone(), stated, file: Arc::default() }
    }

    /// The settings at the beginning, and the file of the reference.
    ///
    /// Errors: those of [`ProjectFile::open`].
    pub fn begin(&self, live: &Live, reference: Option<&Path>) -> Result<(), Error> {
        let file = ProjectFile::open(&self.path, &run_settings(0, live), &self.stated, reference)?;
        self.file.get_or_init(|| file);
        Ok(())
    }

    /// What the scope saves with.
    pub fn save(&self) -> Save {
        let file = self.file.clone();
        Box::new(move |screen, live| {
            let file = file.get().ok_or_else(|| NotArmedYet.to_string())?;
            file.save(screen, live).map(|_| ()).map_err(|error| error.to_string())
        })
    }
}
