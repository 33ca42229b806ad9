//! A fault under a key of a document, before its line and column are known.

use crate::columns::nearest;
use crate::fault::Fault;
use serde::de;
use std::fmt;

/// One step down into a document.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Step {
    /// Into a table.
    Key(String),
    /// Into an array, from 0.
    Entry(usize),
}

/// A fault, and the way from the document's top to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Misfit {
    pub(crate) path: Vec<Step>,
    pub(crate) offset: Option<usize>,
    pub(crate) fault: Box<Fault>,
}

impl Misfit {
    pub(crate) fn new(fault: Fault) -> Misfit {
        Misfit { path: Vec::new(), offset: None, fault: Box::new(fault) }
    }

    /// Nothing under `key`, where something must be.
    pub(crate) fn empty(key: &str) -> Misfit {
        Misfit::new(Fault::EmptyList { key: String::new() }).under(key)
    }

    /// A word that is none of the choices.
    pub(crate) fn not_among(found: &str, choices: &[&str]) -> Misfit {
        Misfit::new(Fault::Choice {
            key: String::new(),
            found: found.into(),
            choices: choices.iter().map(|c| (*c).into()).collect(),
            nearest: nearest(found, choices),
        })
    }

    /// A key that is none of the known ones.
    pub(crate) fn unknown_key(key: &str, known: &[&str]) -> Misfit {
        Misfit::new(Fault::UnknownKey {
            key: key.into(),
            known: known.iter().map(|k| (*k).into()).collect(),
            nearest: nearest(key, known),
        })
    }

    /// The same, seen from one table further up.
    pub(crate) fn under(mut self, key: &str) -> Misfit {
        self.path.insert(0, Step::Key(key.into()));
        self
    }

    /// The same, seen from one array further up.
    pub(crate) fn in_entry(mut self, entry: usize) -> Misfit {
        self.path.insert(0, Step::Entry(entry));
        self
    }

    /// The byte in the text, unless a place further down is known already.
    pub(crate) fn at(mut self, offset: usize) -> Misfit {
        self.offset.get_or_insert(offset);
        self
    }

    /// The fault with its full key: `continuous.A(2,3)`, entries counted from 1.
    pub(crate) fn into_fault(mut self) -> Fault {
        let mut full = written(&self.path);
        if let Some(key) = self.fault.key_mut() {
            if !full.is_empty() && !key.is_empty() {
                full.push('.');
            }
            full.push_str(key);
            *key = full;
        }
        *self.fault
    }
}

fn written(path: &[Step]) -> String {
    let mut text = String::new();
    for step in path {
        match step {
            Step::Key(key) if text.is_empty() => text.push_str(key),
            Step::Key(key) => text.extend([".", key]),
            Step::Entry(k) => match text.strip_suffix(')') {
                Some(open) => text = format!("{open},{})", k + 1),
                None => text.push_str(&format!("({})", k + 1)),
            },
        }
    }
    text
}

impl Fault {
    /// The key that the fault is about, where it is about one.
    fn key_mut(&mut self) -> Option<&mut String> {
        match self {
            Fault::NotFinite { name: key, .. }
            | Fault::UnknownKey { key, .. }
            | Fault::MissingKey { key }
            | Fault::WrongType { key, .. }
            | Fault::Choice { key, .. }
            | Fault::Range { key, .. }
            | Fault::Beyond { key, .. }
            | Fault::NoSuchFile { key, .. }
            | Fault::Shape { key, .. }
            | Fault::EmptyList { key }
            | Fault::Length { key, .. } => Some(key),
            _ => None,
        }
    }
}

impl fmt::Display for Misfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let fault = self.clone().into_fault();
        write!(f, "found {}, needed {}", fault.found(), fault.needed())
    }
}

impl std::error::Error for Misfit {}

/// What serde's derived code has to complain about, with nothing lost to a sentence.
impl de::Error for Misfit {
    fn custom<T: fmt::Display>(message: T) -> Misfit {
        wrong_type(message.to_string(), "a value that this schema allows".into())
    }

    fn invalid_type(found: de::Unexpected<'_>, needed: &dyn de::Expected) -> Misfit {
        wrong_type(plain(&found.to_string()), plain(&needed.to_string()))
    }

    fn invalid_value(found: de::Unexpected<'_>, needed: &dyn de::Expected) -> Misfit {
        wrong_type(plain(&found.to_string()), plain(&needed.to_string()))
    }

    fn invalid_length(found: usize, needed: &dyn de::Expected) -> Misfit {
        wrong_type(format!("{found} entries"), plain(&needed.to_string()))
    }

    fn unknown_variant(found: &str, choices: &'static [&'static str]) -> Misfit {
        Misfit::not_among(found, choices)
    }

    fn unknown_field(key: &str, known: &'static [&'static str]) -> Misfit {
        Misfit::unknown_key(key, known)
    }

    fn missing_field(key: &'static str) -> Misfit {
        Misfit::new(Fault::MissingKey { key: key.into() })
    }
}

fn wrong_type(found: String, needed: String) -> Misfit {
    Misfit::new(Fault::WrongType { key: String::new(), found, needed })
}

/// serde's words for types in a user's words.
fn plain(words: &str) -> String {
    let word = match words {
        "f64" => "a number",
        "usize" | "u64" | "u32" => "a whole number, not negative",
        "a sequence" | "sequence" => "an array",
        "map" | "a map" => "a table",
        _ if words.starts_with("struct ") => "a table",
        _ => words,
    };
    word.replace("floating point ", "the number ").replace("integer `", "the number `").replace('`', "")
}
