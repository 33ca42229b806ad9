//! Where a file came from: the tool, the command, and the files it was made of by their hashes.
//!
//! Enters: paths. Leaves: [`Provenance`] to put into a file, and [`trace`], the walk back to the recording.
//! Deliberately absent: the clock.

use crate::Document;
use crate::document::{SCHEMA_KEY, document_text, parse_table};
use crate::error::{Error, Tried};
use crate::hash::sha256_of;
use crate::note::Note;
use crate::run_file::RunOrigin;
use crate::tree::Node;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::path::{Component, Path, PathBuf};

/// The table `provenance` of every file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Tool and version: `flexbeam 0.1.0`.
    pub tool: String,
    /// The command line that made the file.
    pub command: Option<String>,
    /// When, in the caller's words; nobody reads the clock here.
    pub time: Option<String>,
    /// The files it was made of.
    #[serde(default)]
    pub parents: Vec<Parent>,
}

/// A file that another one was made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parent {
    /// Path as seen from the child's folder, with `/`.
    pub path: String,
    /// SHA-256 of its bytes at the time, in hexadecimal.
    pub sha256: String,
    /// Its schema, where it has one.
    pub schema: Option<String>,
}

impl Parent {
    /// The file at `path` as the parent of the file at `child`.
    ///
    /// Errors: those of [`read_bytes`](crate::read_bytes).
    pub fn of(path: &Path, child: &Path) -> Result<Parent, Error> {
        let sha256 = sha256_of(path)?;
        Ok(Parent { path: relative(path, child), schema: Origin::of(path, &sha256).schema, sha256 })
    }
}

/// What became of a file since its child was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// The file at which the walk began: no child states its hash.
    Start,
    /// The same bytes.
    Same,
    /// Other bytes.
    Changed,
    /// Not there any more, or not readable.
    Missing,
}

/// One file on the way back to the recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Step {
    /// Generations above the start: 0 the start itself, 1 its parents.
    pub generation: usize,
    /// The file, as seen from the working folder.
    pub path: PathBuf,
    /// The schema found in it, or the one that its child states.
    pub schema: Option<String>,
    /// The hash found.
    pub sha256_found: Option<String>,
    /// The hash that its child states.
    pub sha256_expected: Option<String>,
    /// What became of it.
    pub state: State,
    /// The command that made it, where it says so.
    pub command: Option<String>,
}

/// Walks from a file back to what it was made of, depth first: a controller, its model, the model's recording.
///
/// Reads any version of any schema that has the tables `provenance`. A file that changed is walked on from as it stands
/// now; a file that was met already is listed, but not walked on from again. The parents of a recording in CSV stand in the
/// [`Note`] beside it, which counts only while the recording is the one it was written for; those of a run, in its metadata.
///
/// Errors: those of [`read_bytes`](crate::read_bytes), for the start only.
pub fn trace(path: &Path) -> Result<Vec<Step>, Error> {
    let sha256 = sha256_of(path)?;
    let mut walk = Walk { met: HashSet::new(), steps: Vec::new() };
    walk.visit(0, path.to_path_buf(), Some(sha256), None);
    Ok(walk.steps)
}

struct Walk {
    met: HashSet<PathBuf>,
    steps: Vec<Step>,
}

impl Walk {
    /// `stated` is what the child says of this file.
    fn visit(&mut self, generation: usize, path: PathBuf, sha256_found: Option<String>, stated: Option<&Parent>) {
        let origin = sha256_found.as_ref().map(|sha256| Origin::of(&path, sha256)).unwrap_or_default();
        let sha256_expected = stated.map(|parent| parent.sha256.clone());
        let provenance = origin.provenance.unwrap_or_default();
        let first_time = self.met.insert(path.canonicalize().unwrap_or_else(|_| path.clone()));
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        self.steps.push(Step {
            generation,
            path,
            schema: origin.schema.or_else(|| stated.and_then(|parent| parent.schema.clone())),
            state: State::of(sha256_found.as_deref(), sha256_expected.as_deref()),
            sha256_found,
            sha256_expected,
            command: provenance.command,
        });
        for parent in provenance.parents.iter().filter(|_| first_time) {
            let path = folder.join(&parent.path);
            let sha256 = sha256_of(&path).ok();
            self.visit(generation + 1, path, sha256, Some(parent));
        }
    }
}

impl State {
    fn of(found: Option<&str>, expected: Option<&str>) -> State {
        match (found, expected) {
            (None, _) => State::Missing,
            (Some(_), None) => State::Start,
            (Some(found), Some(expected)) if found.eq_ignore_ascii_case(expected) => State::Same,
            (Some(_), Some(_)) => State::Changed,
        }
    }
}

/// What a file says about itself, whatever else is in it.
#[derive(Default)]
struct Origin {
    schema: Option<String>,
    provenance: Option<Provenance>,
}

impl Origin {
    /// What the file says, or the note beside it when it is a recording that cannot.
    fn of(path: &Path, sha256: &str) -> Origin {
        if let Some(RunOrigin { schema, provenance }) = RunOrigin::of_file(path) {
            return Origin { schema: Some(schema), provenance };
        }
        match document_text(path) {
            Ok(Some(text)) => Origin::in_document(&text, path),
            _ => Origin::in_note(path, sha256),
        }
    }

    fn in_document(text: &str, path: &Path) -> Origin {
        let Ok(table) = parse_table(text, path, Tried::Read) else { return Origin::default() };
        let schema = table.get(SCHEMA_KEY).and_then(|value| value.as_ref().as_str()).map(String::from);
        let provenance = table.get("provenance").map(|value| Provenance::deserialize(Node::of(value.as_ref())));
        Origin { schema, provenance: provenance.and_then(Result::ok) }
    }

    fn in_note(path: &Path, sha256: &str) -> Origin {
        match Note::read(&Note::path_for(path)) {
            Ok(note) if note.sha256 == sha256 => {
                Origin { schema: Some(Note::SCHEMA.into()), provenance: note.provenance }
            }
            _ => Origin::default(),
        }
    }
}

/// `path` as seen from the folder of `child`, with `/`; absolute when the two have nothing in common.
pub(crate) fn relative(path: &Path, child: &Path) -> String {
    let (path, child) = (plain(path), plain(child));
    let folder = child.parent().unwrap_or(Path::new(""));
    let shared = path.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    if shared == 0 {
        return path.to_string_lossy().into_owned();
    }
    let up = folder.components().skip(shared).map(|_| Component::ParentDir);
    let steps = up.chain(path.components().skip(shared));
    steps.map(|step| step.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// Absolute, without `.` and `..`.
fn plain(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let mut plain = PathBuf::new();
    for step in absolute.components() {
        match step {
            Component::ParentDir => {
                plain.pop();
            }
            Component::CurDir => {}
            step => plain.push(step),
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parents_are_named_from_the_child_s_folder() {
        for (path, child, seen) in [
            ("a/recording.csv", "a/model.toml", "recording.csv"),
            ("a/recording.csv", "model.toml", "a/recording.csv"),
            ("recording.csv", "a/b/model.toml", "../../recording.csv"),
            ("./x/../a/recording.csv", "a/models/model.toml", "../recording.csv"),
        ] {
            assert_eq!(relative(Path::new(path), Path::new(child)), seen);
        }
    }
}
