//! A project's file during a run: what is shown and set goes into it, what a person wrote stays.
//!
//! Enters: scopes, panels and settings as they are now. Leaves: `flexbeam.toml` that begins the next run with them. What did not
//! change since the last save is left as it stands in the file, edits of that time included.

use crate::Document;
use crate::document::parse;
use crate::edit;
use crate::error::{Error, Tried};
use crate::fault::Fault;
use crate::project::Project;
use crate::provenance::relative;
use crate::run_file::{LiveSettings, RunShape};
use crate::screen::Screen;
use crate::write::{Written, read_bytes, replace_bytes};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use toml::{Table, Value};

/// The file of a project, for a run that saves into it.
pub struct ProjectFile {
    path: PathBuf,
    /// What the file said when the run began.
    said: Table,
    /// What a run begins with by that alone.
    begun: Table,
    /// The reference file of this run.
    reference: Option<String>,
    last: Mutex<Saved>,
}

/// What the file was last brought to agree with.
struct Saved {
    screen: Screen,
    live: Table,
}

impl ProjectFile {
    /// The file at `path`. `begun` is what the run began with, of which the keys `stated` come from the command line: they are
    /// saved, too. `reference` is the file that the run's reference comes from.
    ///
    /// Errors: those of [`Document::read`].
    pub fn open(
        path: &Path,
        begun: &LiveSettings,
        stated: &[&str],
        reference: Option<&Path>,
    ) -> Result<ProjectFile, Error> {
        let project = Project::read(path)?;
        let mut begun = table_of_live(begun);
        for key in stated {
            let (table, key) = key.split_once('.').unwrap_or(("settings", key));
            begun.get_mut(table).and_then(Value::as_table_mut).and_then(|table| table.remove(key));
        }
        Ok(ProjectFile {
            path: path.into(),
            said: table(&project),
            reference: reference.map(|reference| relative(reference, path)),
            last: Mutex::new(Saved { screen: project.screen(), live: begun.clone() }),
            begun,
        })
    }

    /// Saves scopes, panels and settings.
    ///
    /// Errors: a file that does not read any more; a screen or a setting that would not read; those of writing. Then the file stands
    /// as it was.
    pub fn save(&self, screen: &Screen, live: &LiveSettings) -> Result<Written, Error> {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let saving = |error: Error| Error { tried: Tried::Save, ..error };
        let bytes = read_bytes(&self.path).map_err(saving)?;
        let not_text = |_| Error::new(Tried::Save, &self.path, Fault::NotText);
        let text = str::from_utf8(&bytes).map_err(not_text)?;
        let present: Project = parse(text, &self.path, Tried::Save)?;
        let now = Saved { screen: screen.clone(), live: table_of_live(live) };
        let wanted = self.wanted(&present, &last, &now)?;
        let changed = edit::changed(text, &table(&present), &table(&wanted)).map_err(|error| {
            let message = error.message().replace('\n', ", ");
            Error::new(Tried::Save, &self.path, Fault::Syntax { message })
        })?;
        let written = replace_bytes(&self.path, changed.as_bytes())?;
        *last = now;
        Ok(written)
    }

    /// What the file is to say, checked.
    fn wanted(&self, present: &Project, last: &Saved, now: &Saved) -> Result<Project, Error> {
        let mut wanted = present.clone();
        if now.screen.scopes != last.screen.scopes {
            wanted.scopes.clone_from(&now.screen.scopes);
        }
        if now.screen.panels != last.screen.panels {
            wanted.panels.clone_from(&now.screen.panels);
        }
        let settings = Changes { said: &self.said, begun: &self.begun, last: &last.live, now: &now.live };
        let table = settings.onto(&table(&wanted));
        let refused = |fault| Error::new(Tried::Save, &self.path, fault);
        let mut wanted: Project = table.try_into().map_err(|error: toml::de::Error| {
            refused(Fault::Syntax { message: error.message().replace('\n', ", ") })
        })?;
        if wanted.reference.shape == Some(RunShape::File) && wanted.reference.file.is_none() {
            wanted.reference.file = self.reference.as_ref().map(PathBuf::from);
        }
        wanted.check().map_err(|misfit| refused(misfit.into_fault()))?;
        Ok(wanted)
    }
}

/// The tables `settings` and `reference` of a project and of a run.
struct Changes<'a> {
    said: &'a Table,
    begun: &'a Table,
    last: &'a Table,
    now: &'a Table,
}

impl Changes<'_> {
    /// The table with what changed since the last save; what is again as at the beginning, as the file said it then,
    /// or not at all.
    fn onto(&self, table: &Table) -> Table {
        let mut table = table.clone();
        let nothing = Value::Table(Table::new());
        for (key, value) in self.now {
            if value.is_table() {
                let below = |of: &Table| of.get(key).unwrap_or(&nothing).as_table().cloned().unwrap_or_default();
                let [said, begun, last, now] = [self.said, self.begun, self.last, self.now].map(below);
                let inner = Changes { said: &said, begun: &begun, last: &last, now: &now }.onto(&below(&table));
                put(&mut table, key, (!inner.is_empty()).then_some(Value::Table(inner)));
            } else if self.last.get(key) != Some(value) {
                let as_begun = self.begun.get(key) == Some(value);
                let wanted = if as_begun { self.said.get(key) } else { Some(value) };
                put(&mut table, key, wanted.cloned());
            }
        }
        table
    }
}

/// Nothing: what the file does not say.
fn put(table: &mut Table, key: &str, wanted: Option<Value>) {
    match wanted {
        Some(value) => table.insert(key.into(), value),
        None => table.remove(key),
    };
}

fn table(project: &Project) -> Table {
    Table::try_from(project).expect("a project has string keys only")
}

fn table_of_live(live: &LiveSettings) -> Table {
    let settings = Value::try_from(&live.settings).expect("settings have string keys only");
    let reference = Value::try_from(live.reference).expect("a reference has string keys only");
    [("settings".to_string(), settings), ("reference".to_string(), reference)].into_iter().collect()
}
