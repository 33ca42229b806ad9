//! TOML documents with a schema: reading with places, writing what reads back.

use crate::emit::toml_text;
use crate::error::{Error, Place, Tried};
use crate::fault::Fault;
use crate::misfit::{Misfit, Step};
use crate::provenance::Provenance;
use crate::run_file::RunOrigin;
use crate::tree::Node;
use crate::write::{Overwrite, Written, check_free_for_schema, read_bytes, refused, write_bytes};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// The key that names a document's kind and version.
pub(crate) const SCHEMA_KEY: &str = "schema";

/// A kind of TOML file.
///
/// ```
/// use flexbeam_files::{Document, Rig};
/// let rig = Rig::parse("schema = \"flexbeam.rig/1\"\n[actuator]\nlimit_v = 8\n", "rig.toml".as_ref())?;
/// assert_eq!(rig.actuator.and_then(|actuator| actuator.limit_v), Some(8.0.into()));
/// # Ok::<(), flexbeam_files::Error>(())
/// ```
pub trait Document: Serialize + DeserializeOwned {
    /// Kind and version: `flexbeam.model/1`.
    const SCHEMA: &'static str;

    /// What the file holds, for the comment at its head.
    const HEAD: &'static str;

    /// Where it came from, if it says so.
    fn provenance(&self) -> Option<&Provenance>;

    /// What serde cannot see: shapes, ranges, lengths.
    #[doc(hidden)]
    fn check(&self) -> Result<(), Misfit>;

    /// Reads the document at `path`.
    ///
    /// Errors: those of [`read_bytes`], [`Fault::NotText`], and those of [`Document::parse`].
    fn read(path: &Path) -> Result<Self, Error> {
        let bytes = read_bytes(path)?;
        match std::str::from_utf8(&bytes) {
            Ok(text) => Self::parse(text, path),
            Err(_) => Err(Error::new(Tried::Read, path, Fault::NotText)),
        }
    }

    /// The document in `text`; `source` is for messages.
    ///
    /// Errors: [`Fault::Syntax`], [`Fault::NoSchema`], [`Fault::Schema`], [`Fault::UnknownKey`],
    /// [`Fault::MissingKey`], [`Fault::WrongType`], [`Fault::Choice`], [`Fault::NotFinite`], [`Fault::Shape`],
    /// [`Fault::Length`], [`Fault::EmptyList`], [`Fault::Range`], [`Fault::OneOf`], [`Fault::DuplicateName`].
    fn parse(text: &str, source: &Path) -> Result<Self, Error> {
        parse(text, source, Tried::Read)
    }

    /// The document as TOML, with its schema.
    ///
    /// Errors: as [`Document::parse`], for what could be written but not read back (NaN, shapes that do not fit).
    fn to_toml(&self, path: &Path) -> Result<String, Error> {
        let table = self.table(path)?;
        let text = format!("# {}\n{SCHEMA_KEY} = {:?}\n{}", Self::HEAD, Self::SCHEMA, toml_text(&table));
        parse::<Self>(&text, path, Tried::Write)?;
        Ok(text)
    }

    /// The document's keys and values, without the schema.
    #[doc(hidden)]
    fn table(&self, path: &Path) -> Result<toml::Table, Error> {
        toml::Table::try_from(self).map_err(|error| {
            let fault = Fault::Syntax { message: error.to_string() };
            Error::new(Tried::Write, path, fault)
        })
    }

    /// Whether a document of this kind could be written to `path`: ask before an hour of computing.
    ///
    /// Errors: [`Fault::Exists`] when `overwrite` refuses what stands there; [`Fault::IsFolder`].
    fn check_free(path: &Path, overwrite: Overwrite) -> Result<(), Error> {
        check_free_for_schema(Self::SCHEMA, path, overwrite)
    }

    /// Writes the document to `path`.
    ///
    /// Errors: those of [`Document::to_toml`] and of [`write_bytes`].
    fn write(&self, path: &Path, overwrite: Overwrite) -> Result<Written, Error> {
        write_bytes(path, self.to_toml(path)?.as_bytes(), overwrite)
    }
}

/// As [`Document::parse`], for a message that says what was tried.
pub(crate) fn parse<T: Document>(text: &str, source: &Path, tried: Tried) -> Result<T, Error> {
    let fault = |fault| Error::new(tried, source, fault);
    let mut table = parse_table(text, source, tried)?;
    match table.remove(SCHEMA_KEY) {
        None => return Err(fault(Fault::NoSchema { needed: T::SCHEMA })),
        Some(schema) if schema.as_ref().as_str() != Some(T::SCHEMA) => {
            let found = schema.as_ref().as_str().unwrap_or(schema.as_ref().type_str()).to_string();
            let fault = fault(Fault::Schema { found, needed: T::SCHEMA });
            return Err(fault.at_offset(text, schema.span().start));
        }
        Some(_) => {}
    }
    let root = DeValue::Table(table);
    let document = T::deserialize(Node::of(&root)).and_then(|document| document.check().map(|()| document));
    document.map_err(|misfit| {
        let offset = misfit.offset.or_else(|| located(&root, &misfit.path));
        let fault = fault(misfit.into_fault());
        match offset {
            Some(offset) => fault.at_offset(text, offset),
            None => fault,
        }
    })
}

/// The document's keys with their places, whatever its schema.
pub(crate) fn parse_table<'a>(text: &'a str, source: &Path, tried: Tried) -> Result<DeTable<'a>, Error> {
    DeTable::parse(text).map(|table| table.into_inner()).map_err(|error| {
        let message = error.message().replace('\n', ", ").replace('`', "'");
        let fault = Error::new(tried, source, Fault::Syntax { message });
        match error.span() {
            Some(span) => fault.at_offset(text, span.start),
            None => fault,
        }
    })
}

/// The byte at which the value under `path` stands, or the last one on the way to it that exists.
fn located(root: &DeValue<'_>, path: &[Step]) -> Option<usize> {
    let mut value = root;
    let mut offset = None;
    for step in path {
        let next = match step {
            Step::Key(key) => value.get(key.as_str()),
            Step::Entry(k) => value.get(*k),
        };
        let Some(next) = next else { break };
        offset = Some(next.span().start);
        value = next.as_ref();
    }
    offset
}

/// Where the value under these keys stands in a document on disk; the file alone where it cannot be found.
///
/// ```
/// use flexbeam_files::place_of;
/// let folder = tempfile::tempdir()?;
/// let file = folder.path().join("flexbeam.toml");
/// std::fs::write(&file, "[run]\nport = \"nowhere\"\n")?;
/// assert!(place_of(&file, &["run", "port"]).to_string().ends_with("flexbeam.toml:2:8"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn place_of(source: &Path, keys: &[&str]) -> Place {
    fault_under(source, keys, Fault::Empty).place
}

/// A fault of the value under these keys of a document on disk, with its place while it can be found.
pub(crate) fn fault_under(source: &Path, keys: &[&str], fault: Fault) -> Error {
    let fault = Error::new(Tried::Read, source, fault);
    let Ok(text) = std::fs::read_to_string(source) else { return fault };
    let Ok(table) = parse_table(&text, source, Tried::Read) else { return fault };
    let path: Vec<Step> = keys.iter().map(|key| Step::Key((*key).into())).collect();
    match located(&DeValue::Table(table), &path) {
        Some(offset) => fault.at_offset(&text, offset),
        None => fault,
    }
}

/// The schema that a file names; nothing for a recording in CSV or any other file that names none.
///
/// Errors: those of [`read_bytes`]; [`Fault::Syntax`] for a document that is damaged.
pub fn schema_of(path: &Path) -> Result<Option<String>, Error> {
    match document_text(path)? {
        Some(text) => {
            let table = parse_table(&text, path, Tried::Read)?;
            Ok(table.get(SCHEMA_KEY).and_then(|schema| schema.as_ref().as_str()).map(String::from))
        }
        None => Ok(RunOrigin::of_file(path).map(|run| run.schema)),
    }
}

/// The text of a document; nothing for any other file, which may be of any length and is not held.
///
/// Errors: those of [`read_bytes`].
pub(crate) fn document_text(path: &Path) -> Result<Option<String>, Error> {
    /// Longer comments before the first key no document has.
    const HEAD: u64 = 1 << 16;
    let refused = |error| refused(Tried::Read, path, &error);
    let mut head = Vec::new();
    File::open(path).map_err(refused)?.take(HEAD).read_to_end(&mut head).map_err(refused)?;
    let text = match std::str::from_utf8(&head) {
        Ok(text) => text,
        // The head may end within a character.
        Err(error) if error.error_len().is_none() => str::from_utf8(&head[..error.valid_up_to()]).unwrap_or_default(),
        Err(_) => return Ok(None),
    };
    match looks_like_toml(text) {
        true => Ok(String::from_utf8(read_bytes(path)?).ok()),
        false => Ok(None),
    }
}

/// Whether the first line that is neither blank nor a comment is a key or a section: spares parsing a long recording.
pub(crate) fn looks_like_toml(text: &str) -> bool {
    let first = text.lines().map(str::trim_start).find(|line| !line.is_empty() && !line.starts_with('#'));
    first.is_some_and(|line| line.starts_with('[') || line.contains('='))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_documents_are_parsed_as_toml() {
        assert!(looks_like_toml("# head\n\nschema = \"x/1\"\n"));
        assert!(looks_like_toml("[provenance]\n"));
        assert!(!looks_like_toml("# schema = 1\ntime_s,u\n0,1\n"));
        assert!(!looks_like_toml(""));
    }
}
