//! Projects: a folder with `flexbeam.toml`, which names its files and says how they run and what is watched.

use crate::document::{Document, fault_under};
use crate::error::Error;
use crate::fault::Fault;
use crate::misfit::Misfit;
use crate::model::{out_of_range, positive};
use crate::provenance::Provenance;
use crate::run_file::{RunShape, SettingValue, by_key};
use crate::screen::{Panel, Scope, Screen};
use crate::settings::Settings;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// `flexbeam.project/1`: paths as seen from the project's folder, numbers in SI. What is left out is as on the command line.
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
    /// How it runs.
    #[serde(default, skip_serializing_if = "is_default")]
    pub run: ProjectRun,
    /// What the tip is to do.
    #[serde(default, skip_serializing_if = "is_default")]
    pub reference: ProjectReference,
    /// Live settings that differ from those of the controller file.
    #[serde(default, skip_serializing_if = "is_default")]
    pub settings: Settings,
    /// What no setting may exceed.
    #[serde(default, skip_serializing_if = "is_default")]
    pub limits: ProjectLimits,
    /// Scopes, in the order of the page.
    #[serde(default, rename = "scope", skip_serializing_if = "Vec::is_empty")]
    pub scopes: Vec<Scope>,
    /// Control panels, in the order of the page.
    #[serde(default, rename = "panel", skip_serializing_if = "Vec::is_empty")]
    pub panels: Vec<Panel>,
    /// Where it came from.
    pub provenance: Option<Provenance>,
}

/// The table `run`: options of `flexbeam run`, with their units in the names.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProjectRun {
    /// Where the rig is, as `--port` says it.
    pub port: Option<String>,
    /// Longest time that one voltage may stand [s].
    pub hold_s: Option<f64>,
    /// Core of the loop's thread.
    pub core: Option<usize>,
    /// Highest voltage of the sign check [V]; 0 leaves it out.
    pub sign_check_v: Option<f64>,
    /// Home the simulated rig as a real one.
    pub home: Option<bool>,
    /// Stay armed until told to start.
    pub wait: Option<bool>,
    /// Length [s].
    pub duration_s: Option<f64>,
    /// Seed of the simulated rig's sensor noise.
    pub seed: Option<u64>,
    /// Address of the scope, as `--scope` says it.
    pub scope: Option<String>,
    /// File with the scope's token.
    pub scope_token_file: Option<PathBuf>,
}

/// The table `reference`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProjectReference {
    /// Shape.
    pub shape: Option<RunShape>,
    /// Amplitude [rad]; of a file, what it is multiplied by.
    pub amplitude_rad: Option<f64>,
    /// Period of a repeating shape [s].
    pub period_s: Option<f64>,
    /// What the amplitude is added to [rad].
    pub offset_rad: Option<f64>,
    /// CSV file with a column `reference_rad` or `reference_deg`.
    pub file: Option<PathBuf>,
}

/// The table `limits`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProjectLimits {
    /// Largest hub angle, either way; beyond it the rig is stopped [rad].
    pub angle_rad: Option<f64>,
    /// Largest hub speed; beyond it the rig is stopped [rad/s].
    pub speed_rad_s: Option<f64>,
    /// Largest deflection angle, either way; beyond it the rig is stopped [rad].
    pub deflection_rad: Option<f64>,
    /// Largest voltage, either way [V].
    pub voltage_v: Option<f64>,
}

fn is_default<T: Default + PartialEq>(table: &T) -> bool {
    *table == T::default()
}

impl Project {
    /// The file that makes a folder a project.
    pub const FILE: &'static str = "flexbeam.toml";

    /// The project in a folder, its paths joined to the folder.
    ///
    /// Errors: those of [`Document::read`]; [`Fault::NoSuchFile`] for a rig, controller or reference that is not there. A model
    /// or a recording may be missing: nothing runs on them.
    pub fn open(folder: &Path) -> Result<Project, Error> {
        let file = folder.join(Project::FILE);
        let project = Project::read(&file)?;
        let needed = [
            (&["rig"][..], &project.rig),
            (&["controller"], &project.controller),
            (&["reference", "file"], &project.reference.file),
        ];
        for (keys, path) in needed.into_iter().filter_map(|(keys, path)| Some((keys, path.as_ref()?))) {
            if !folder.join(path).is_file() {
                let fault = Fault::NoSuchFile { key: keys.join("."), path: path.display().to_string() };
                return Err(fault_under(&file, keys, fault));
            }
        }
        let join = |path: Option<PathBuf>| path.map(|path| folder.join(path));
        Ok(Project {
            rig: join(project.rig),
            recording: join(project.recording),
            model: join(project.model),
            controller: join(project.controller),
            run: ProjectRun { scope_token_file: join(project.run.scope_token_file), ..project.run },
            reference: ProjectReference { file: join(project.reference.file), ..project.reference },
            ..project
        })
    }

    /// What its tables `run`, `reference`, `settings` and `limits` say, each by its full key: `run.seed`.
    pub fn stated(&self) -> Vec<(String, SettingValue)> {
        let (run, reference) = (by_key(&self.run, "run"), by_key(&self.reference, "reference"));
        [run, reference, by_key(&self.settings, "settings"), by_key(&self.limits, "limits")].concat()
    }

    /// Its scopes and panels.
    pub fn screen(&self) -> Screen {
        Screen { scopes: self.scopes.clone(), panels: self.panels.clone() }
    }
}

impl Document for Project {
    const SCHEMA: &'static str = "flexbeam.project/1";
    const HEAD: &'static str = "flexbeam project. SI units; paths as seen from this folder.";

    fn provenance(&self) -> Option<&Provenance> {
        self.provenance.as_ref()
    }

    fn check(&self) -> Result<(), Misfit> {
        self.run.check().map_err(|misfit| misfit.under("run"))?;
        self.reference.check().map_err(|misfit| misfit.under("reference"))?;
        self.settings.check().map_err(|misfit| misfit.under("settings"))?;
        self.limits.check().map_err(|misfit| misfit.under("limits"))?;
        self.limits.keep(&self.settings).map_err(|misfit| misfit.under("settings"))?;
        self.screen().check()
    }
}

impl ProjectRun {
    fn check(&self) -> Result<(), Misfit> {
        all_positive([("hold_s", self.hold_s), ("duration_s", self.duration_s)])?;
        match self.sign_check_v {
            Some(found) if found < 0.0 => Err(out_of_range("sign_check_v", found, "zero or a positive number")),
            _ => Ok(()),
        }
    }
}

impl ProjectReference {
    fn check(&self) -> Result<(), Misfit> {
        all_positive([("period_s", self.period_s)])?;
        match (self.shape, &self.file) {
            (Some(RunShape::File), None) => Err(Misfit::new(Fault::MissingKey { key: "file".into() })),
            _ => Ok(()),
        }
    }
}

impl ProjectLimits {
    fn check(&self) -> Result<(), Misfit> {
        all_positive([
            ("angle_rad", self.angle_rad),
            ("speed_rad_s", self.speed_rad_s),
            ("deflection_rad", self.deflection_rad),
            ("voltage_v", self.voltage_v),
        ])
    }

    /// Errors: [`Fault::Beyond`] for a setting that exceeds its limit.
    fn keep(&self, settings: &Settings) -> Result<(), Misfit> {
        let pairs = [
            ("theta_limit_rad", settings.theta_limit_rad, "limits.angle_rad", self.angle_rad),
            ("deflection_limit_rad", settings.deflection_limit_rad, "limits.deflection_rad", self.deflection_rad),
            ("voltage_limit_v", settings.voltage_limit_v, "limits.voltage_v", self.voltage_v),
        ];
        for (key, found, limit, most) in pairs {
            if let (Some(found), Some(most)) = (found, most)
                && found > most
            {
                return Err(Misfit::new(Fault::Beyond { key: String::new(), found, most, limit }).under(key));
            }
        }
        Ok(())
    }
}

fn all_positive<const N: usize>(numbers: [(&str, Option<f64>); N]) -> Result<(), Misfit> {
    numbers.into_iter().try_for_each(|(key, found)| found.map_or(Ok(()), |found| positive(key, found)))
}
