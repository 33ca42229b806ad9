//! Values and arrays changed in place.

use super::{matched, of_place_and_own, text, update_item};
use crate::emit::quoted;
use toml::Value;
use toml_edit::{Array, Decor, InlineTable, Item};

/// A value as it is written where none stood.
pub(super) fn written(value: &Value) -> toml_edit::Value {
    match value {
        Value::String(text) => on_one_line(text),
        Value::Integer(number) => (*number).into(),
        Value::Float(number) => (*number).into(),
        Value::Boolean(truth) => (*truth).into(),
        Value::Datetime(time) => time.to_string().into(),
        Value::Array(entries) => toml_edit::Value::Array(entries.iter().map(written).collect()),
        Value::Table(table) => {
            toml_edit::Value::InlineTable(table.iter().map(|(key, value)| (key, written(value))).collect())
        }
    }
}

/// Without line ends of its own, which are not the text's to have.
fn on_one_line(text: &str) -> toml_edit::Value {
    quoted(text).parse().expect("a basic string of TOML")
}

/// Puts another value, with the comments of the old one.
pub(super) fn set(value: &mut toml_edit::Value, wanted: &Value) {
    if let (toml_edit::Value::Array(array), Value::Array(entries)) = (&mut *value, wanted) {
        let present: Vec<Value> = array.iter().map(said).collect();
        return set_entries(array, &present, entries);
    }
    let decor = value.decor().clone();
    *value = written(wanted);
    *value.decor_mut() = decor;
}

/// What a value of an array says; a number is a number, however it is written.
fn said(value: &toml_edit::Value) -> Value {
    match value {
        toml_edit::Value::String(text) => Value::String(text.value().clone()),
        toml_edit::Value::Integer(number) => Value::Float(*number.value() as f64),
        toml_edit::Value::Float(number) => Value::Float(*number.value()),
        toml_edit::Value::Boolean(truth) => Value::Boolean(*truth.value()),
        toml_edit::Value::Datetime(time) => Value::String(time.value().to_string()),
        toml_edit::Value::Array(entries) => Value::Array(entries.iter().map(said).collect()),
        toml_edit::Value::InlineTable(table) => {
            let entries = table.iter().map(|(key, value)| (key.to_string(), said(value)));
            Value::Table(entries.collect())
        }
    }
}

/// An entry of an array with what stands before it, and behind its comma on the same line.
struct Entry {
    before: String,
    value: toml_edit::Value,
    behind: String,
}

/// Makes an array hold the wanted entries; those that stay keep their comments.
pub(super) fn set_entries(array: &mut Array, present: &[Value], wanted: &[Value]) {
    let (mut old, end) = taken_apart(array);
    let before: Vec<String> = old.iter().flatten().map(|entry| entry.before.clone()).collect();
    let lines = before.iter().find(|before| before.contains('\n')).map(|before| indentation(before));
    let places = before.iter().map(|before| if lines.is_some() { of_place_and_own(before).0 } else { before });
    let mut places = places.map(String::from).chain(std::iter::repeat_with(|| new_place(lines)));
    let mut found = matched(present, wanted);
    if present.len() == wanted.len() {
        let free: Vec<usize> = (0..present.len()).filter(|i| !found.contains(&Some(*i))).collect();
        let numbers = found.iter_mut().zip(wanted).filter(|(found, new)| found.is_none() && new.is_float());
        numbers.zip(free).for_each(|((found, _), i)| *found = Some(i));
    }
    array.clear();
    let mut behind = String::new();
    for (new, i) in wanted.iter().zip(found) {
        let mut entry = match i.and_then(|i| Some((i, old[i].take()?))) {
            Some((i, entry)) => renewed(entry, &present[i], new),
            None => Entry { before: lines.unwrap_or_default().into(), value: written(new), behind: String::new() },
        };
        let own = if lines.is_some() { of_place_and_own(&entry.before).1 } else { "" };
        let place = places.next().expect("there is no end of places");
        entry.value.decor_mut().set_prefix(on_new_line(behind, &(place + own)));
        behind = entry.behind;
        array.push_formatted(entry.value);
    }
    let left: String = places.take(present.len().saturating_sub(wanted.len())).filter(|c| c.contains('#')).collect();
    array.set_trailing(on_new_line(behind, &(left + &end)));
}

/// Before an entry that is put behind all others.
fn new_place(lines: Option<&str>) -> String {
    if lines.is_some() { "\n" } else { " " }.into()
}

/// What comes behind a comment begins on a new line.
fn on_new_line(comment: String, rest: &str) -> String {
    let joint = if comment.is_empty() || rest.starts_with('\n') { "" } else { "\n" };
    comment + joint + rest
}

fn renewed(mut entry: Entry, present: &Value, wanted: &Value) -> Entry {
    match (present, wanted) {
        _ if present == wanted => {}
        (Value::Table(was), Value::Table(will)) => {
            let mut item = Item::Value(entry.value);
            let left = update_item(&mut item, was, will);
            entry.value = item.into_value().expect("it was put there as a value");
            entry.before = left + &entry.before;
        }
        _ => set(&mut entry.value, wanted),
    }
    entry
}

/// The entries, and what stands before the closing bracket.
fn taken_apart(array: &Array) -> (Vec<Option<Entry>>, String) {
    let mut entries: Vec<Option<Entry>> = Vec::new();
    let mut before = String::new();
    for value in array.iter() {
        let (behind, rest) = end_of_line(text(value.decor().prefix()));
        before.push_str(rest);
        give_back(&mut entries, behind, &mut before);
        entries.push(Some(Entry { before: std::mem::take(&mut before), value: value.clone(), behind: String::new() }));
    }
    let mut end = text(Some(array.trailing())).to_string();
    if let Some(last) = entries.last_mut().and_then(Option::as_mut).filter(|_| !array.trailing_comma()) {
        // Without a comma behind it, what stands before the bracket is taken for the entry's.
        end.insert_str(0, text(last.value.decor().suffix()));
        last.value.decor_mut().set_suffix("");
    }
    let (behind, rest) = end_of_line(&end);
    before.push_str(rest);
    give_back(&mut entries, behind, &mut before);
    (entries, before)
}

/// A comment on the line of the last entry is that entry's; before the first one it is nobody's.
fn give_back(entries: &mut [Option<Entry>], behind: &str, before: &mut String) {
    match entries.last_mut().and_then(Option::as_mut) {
        Some(last) => last.behind = behind.into(),
        None => before.insert_str(0, behind),
    }
}

/// A comment up to the end of its line, and the rest with the line's end.
fn end_of_line(text: &str) -> (&str, &str) {
    match text.split_once('\n') {
        Some((line, _)) if line.contains('#') => text.split_at(line.len()),
        _ => ("", text),
    }
}

/// The blanks of the last line.
fn indentation(before: &str) -> &str {
    before.rsplit('\n').next().unwrap_or_default()
}

/// Evens out the blanks of a table on one line, into which a key was put or out of which one was taken.
pub(super) fn respace(table: &mut InlineTable) {
    let text = table.to_string();
    if !text.contains(['#', '\n']) {
        let decor: Decor = table.decor().clone();
        table.fmt();
        *table.decor_mut() = decor;
    }
}
