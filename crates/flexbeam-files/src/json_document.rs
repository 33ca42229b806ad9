//! Documents as JSON, for programs that read no TOML: the same keys in the same order, the schema first.
//!
//! Enters: a document. Leaves: its text. Deliberately absent: reading; the TOML file stays the document.

use crate::document::{Document, SCHEMA_KEY};
use crate::error::Error;
use serde_json::Value;
use std::path::Path;

/// How every such text begins.
pub(crate) const JSON_HEAD: &str = "{\n  \"schema\": \"flexbeam.";

/// The document as a JSON object: what the TOML leaves out is left out, infinity is null, a row of a matrix a line.
///
/// Errors: as [`Document::to_toml`]; `path` is for messages.
pub fn json_document<D: Document>(document: &D, path: &Path) -> Result<String, Error> {
    let mut text = format!("{{\n  \"{SCHEMA_KEY}\": {:?}", D::SCHEMA);
    for (key, value) in &document.table(path)? {
        text.push_str(",\n");
        push_entry(&mut text, key, value, 2);
    }
    text.push_str("\n}\n");
    Ok(text)
}

fn push_entry(text: &mut String, key: &str, value: &toml::Value, indent: usize) {
    text.push_str(&" ".repeat(indent));
    text.push_str(&Value::from(key).to_string());
    text.push_str(": ");
    push_value(text, value, indent);
}

fn push_value(text: &mut String, value: &toml::Value, indent: usize) {
    match value {
        toml::Value::Table(table) => {
            let entries = table.iter().map(|(key, value)| {
                let mut entry = String::new();
                push_entry(&mut entry, key, value, indent + 2);
                entry
            });
            push_lines(text, ['{', '}'], entries, indent);
        }
        toml::Value::Array(entries) if entries.iter().any(|entry| entry.is_array() || entry.is_table()) => {
            let rows = entries.iter().map(|entry| {
                let mut row = " ".repeat(indent + 2);
                push_value(&mut row, entry, indent + 2);
                row
            });
            push_lines(text, ['[', ']'], rows, indent);
        }
        toml::Value::Array(entries) => {
            let entries: Vec<String> = entries.iter().map(plain).collect();
            text.push_str(&format!("[{}]", entries.join(", ")));
        }
        value => text.push_str(&plain(value)),
    }
}

fn push_lines(text: &mut String, [open, close]: [char; 2], lines: impl Iterator<Item = String>, indent: usize) {
    let lines: Vec<String> = lines.collect();
    text.push(open);
    if !lines.is_empty() {
        text.push_str(&format!("\n{}\n{}", lines.join(",\n"), " ".repeat(indent)));
    }
    text.push(close);
}

/// A value that has no parts. Numbers read back to their bits.
fn plain(value: &toml::Value) -> String {
    match value {
        toml::Value::Float(x) => Value::from(*x).to_string(),
        toml::Value::Integer(k) => k.to_string(),
        toml::Value::Boolean(b) => b.to_string(),
        toml::Value::String(text) => Value::from(text.as_str()).to_string(),
        other => Value::from(other.to_string()).to_string(),
    }
}
