//! What is to be run: the command line, then the project where the command line says nothing, then the defaults.

use std::error::Error;
use std::io;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use flexbeam_files::{Controller, ProjectLimits, RunFile, Screen, place_of};
use flexbeam_kernel as kernel;
use flexbeam_runtime::Live;
use flexbeam_runtime::port::Port;
use flexbeam_runtime::scope::Save;

use super::reference::AskedReference;
use super::saving::Saving;
use crate::port::now_unix_ns;
use crate::project::{Opened, opened};
use crate::{Failure, cli};

/// Everything that a run is asked to do.
pub struct Asked {
    /// The command line, with the project's word where it says nothing.
    pub arguments: cli::Run,
    /// The reference, likewise.
    pub reference: AskedReference,
    /// The project.
    pub project: Option<InRun>,
}

/// A project that runs.
pub struct InRun {
    /// What was read.
    pub opened: Opened,
    saving: Saving,
}

impl Asked {
    /// Errors: a folder that is no project, a project that cannot be read or names no controller.
    pub fn of(given: &cli::Given<cli::Run>) -> Result<Asked, Failure> {
        let mut arguments = given.arguments.clone();
        let flags = AskedReference::of(&arguments);
        let Some(opened) = opened(&arguments.controller)? else {
            return Ok(Asked { arguments, reference: flags, project: None });
        };
        arguments.controller = opened.controller()?;
        adopt(&mut arguments, &opened, given)?;
        let reference = flags.or_project(&opened.project.reference, given);
        let saving = Saving::of(&opened, given);
        Ok(Asked { arguments, reference, project: Some(InRun { opened, saving }) })
    }

    /// The project's name; that of its folder where it has none.
    pub fn name(&self) -> Option<String> {
        self.project.as_ref().map(|project| project.opened.name())
    }

    /// Its scopes and panels, if it has any.
    pub fn screen(&self) -> Option<Screen> {
        let screen = self.project.as_ref().map(|project| project.opened.project.screen());
        screen.filter(|screen| *screen != Screen::default())
    }

    /// What a viewer saves with.
    pub fn save(&self) -> Option<Save> {
        self.project.as_ref().map(|project| project.saving.save())
    }

    /// From now on there is something to save: these are the run's first settings.
    ///
    /// Errors: a project file that does not read any more.
    pub fn saves_from(&self, live: &Live) -> Result<(), Failure> {
        let Some(project) = &self.project else { return Ok(()) };
        Ok(project.saving.begin(live, self.reference.file())?)
    }

    /// The controller file with the project's settings in the place of its own.
    pub fn over(&self, file: Controller) -> Controller {
        match &self.project {
            None => file,
            Some(InRun { opened, .. }) => Controller { settings: file.settings.with(&opened.project.settings), ..file },
        }
    }

    /// The settings within the project's limits on voltage and deflection; those on the hub's angle and speed stand in the arguments.
    pub fn limited(&self, settings: kernel::Settings) -> kernel::Settings {
        let Some(InRun { opened, .. }) = &self.project else { return settings };
        let ProjectLimits { voltage_v, deflection_rad, .. } = opened.project.limits;
        let least = |present: f64, limit: Option<f64>| limit.map_or(present, |limit| present.min(limit));
        kernel::Settings {
            voltage_limit_v: least(settings.voltage_limit_v, voltage_v),
            deflection_limit_rad: least(settings.deflection_limit_rad, deflection_rad),
            ..settings
        }
    }

    /// Makes the folder of the project's runs, where the recording goes there and it is not there yet.
    ///
    /// Returns: the folder, if it was made.
    /// Errors: a folder that cannot be made.
    pub fn make_folder(&self) -> Result<Option<PathBuf>, Failure> {
        let of_project = self.project.as_ref().map(|project| project.opened.folder.join(RUNS));
        let Some(folder) = of_project.filter(|folder| self.arguments.out.parent() == Some(folder) && !folder.is_dir())
        else {
            return Ok(None);
        };
        let tried = format!("make the folder {}", folder.display());
        std::fs::create_dir(&folder).map_err(NoRuns).map_err(Failure::while_trying(tried))?;
        Ok(Some(folder))
    }
}

/// Folder of a project's runs.
const RUNS: &str = "runs";

/// A folder that cannot be made.
#[derive(Debug, thiserror::Error)]
#[error("found {0}, needed a folder for the recording\nhint: -o FILE puts it elsewhere")]
struct NoRuns(io::Error);

/// The project's word where the command line says nothing.
///
/// Errors: a port or an address that is none.
fn adopt(arguments: &mut cli::Run, opened: &Opened, given: &cli::Given<cli::Run>) -> Result<(), Failure> {
    let (project, run, limits) = (&opened.project, &opened.project.run, &opened.project.limits);
    let link = &mut arguments.link;
    let degrees = |rad: Option<f64>| rad.map(f64::to_degrees);
    if let Some(text) = run.port.as_ref().filter(|_| !given.states("port")) {
        parsed::<Port>(opened, "port", text)?;
        link.port.clone_from(text);
    }
    if let Some(text) = run.scope.as_ref().filter(|_| !given.states("scope")) {
        arguments.scope.scope = Some(parsed(opened, "scope", text)?);
    }
    fill(given, "scope_token_file", &mut arguments.scope.scope_token_file, run.scope_token_file.clone().map(Some));
    fill(given, "hold", &mut link.hold, run.hold_s);
    fill(given, "core", &mut link.core, run.core.map(Some));
    fill(given, "sign_check", &mut link.sign_check, run.sign_check_v);
    fill(given, "max_angle_deg", &mut link.max_angle_deg, degrees(limits.angle_rad));
    fill(given, "max_speed_deg_s", &mut link.max_speed_deg_s, degrees(limits.speed_rad_s));
    fill(given, "rig", &mut arguments.rig, project.rig.clone().map(Some));
    fill(given, "seed", &mut arguments.seed, run.seed);
    fill(given, "duration", &mut arguments.duration, run.duration_s.map(Some));
    fill(given, "home", &mut arguments.home, run.home);
    fill(given, "wait", &mut arguments.wait, run.wait);
    fill(given, "out", &mut arguments.out, Some(free_name(&opened.folder.join(RUNS), now_unix_ns())));
    Ok(())
}

/// A word of the table `run`.
///
/// Errors: one that is none, with its place.
fn parsed<T: FromStr<Err: Error + 'static>>(opened: &Opened, key: &str, text: &str) -> Result<T, Failure> {
    let tried = || format!("use run.{key} at {}", place_of(&opened.file, &["run", key]));
    text.parse().map_err(|error| Failure::while_trying(tried())(error))
}

/// Puts the project's value where the command line has none.
fn fill<T>(given: &cli::Given<cli::Run>, field: &str, place: &mut T, said: Option<T>) {
    if let Some(said) = said.filter(|_| !given.states(field)) {
        *place = said;
    }
}

/// DATE-TIME.mcap, with a number behind it where a run began in the same second.
fn free_name(folder: &Path, unix_ns: u64) -> PathBuf {
    let time = utc(unix_ns / 1_000_000_000);
    let names = (1..).map(|k| if k == 1 { format!("{time}.mcap") } else { format!("{time}-{k}.mcap") });
    let mut paths = names.map(|name| folder.join(name));
    let free = paths.find(|path| !path.exists() && !RunFile::part_path(path).exists());
    free.expect("there are more numbers than files")
}

/// `2026-11-26T23-07-14Z`: no colons, which some file systems do not take.
///
/// Source: Howard Hinnant, "chrono-compatible low-level date algorithms", `civil_from_days`. Differs: no days before 1970.
fn utc(unix_s: u64) -> String {
    let (days, second) = (unix_s / 86_400, unix_s % 86_400);
    let shifted = days + 719_468; // from 1 March of year 0
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = 400 * era + year_of_era + u64::from(month <= 2);
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}-{minute:02}-{second:02}Z")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `date -u -d @N`.
    #[test]
    fn times_are_those_of_the_calendar() {
        for (unix_s, text) in [
            (0, "1970-01-01T00-00-00Z"),
            (951_782_399, "2000-02-28T23-59-59Z"),
            (951_782_400, "2000-02-29T00-00-00Z"),
            (951_868_800, "2000-03-01T00-00-00Z"),
            (1_795_734_434, "2026-11-26T23-07-14Z"),
            (4_107_542_399, "2100-02-28T23-59-59Z"),
            (4_107_542_400, "2100-03-01T00-00-00Z"),
        ] {
            assert_eq!(utc(unix_s), text);
        }
    }

    #[test]
    fn no_run_takes_the_name_of_another() {
        let folder = tempfile::tempdir().unwrap();
        let name = |path: PathBuf| path.file_name().unwrap().to_str().unwrap().to_string();
        let next = || free_name(folder.path(), 1_500_000_000);
        assert_eq!(name(next()), "1970-01-01T00-00-01Z.mcap");
        std::fs::write(next(), "").unwrap();
        assert_eq!(name(next()), "1970-01-01T00-00-01Z-2.mcap");
        std::fs::write(RunFile::part_path(&next()), "").unwrap();
        assert_eq!(name(next()), "1970-01-01T00-00-01Z-3.mcap");
    }
}
