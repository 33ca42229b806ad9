//! TOML changed in place: a person's comments, order and spelling stay where nothing changes.
//!
//! Enters: a text, what it says, what it is to say. Leaves: the text that says so. A comment belongs to what stands behind it on
//! its line or right below it, and goes when that goes; a comment with a blank line below it belongs to the place, and stays.
//! Deliberately absent: schemas, files.

mod entries;
mod tables;

use toml::{Table, Value};
use toml_edit::{DocumentMut, Item, RawString, TableLike, TomlError};

/// The text that says `wanted`, made of the one that says `present`.
///
/// Errors: text that is not TOML.
pub(crate) fn changed(text: &str, present: &Table, wanted: &Table) -> Result<String, TomlError> {
    let mut document: DocumentMut = text.replace("\r\n", "\n").parse()?;
    if present == wanted {
        return Ok(text.into());
    }
    let nothing = Table::new();
    for key in keys(present, wanted) {
        match (present.get(key), wanted.get(key)) {
            (was, will) if was == will => {}
            (was, will) if [was, will].into_iter().flatten().any(is_tables) => {
                tables::update(&mut document, key, list(was), list(will));
            }
            (was, Some(Value::Table(will))) => {
                let was = was.and_then(Value::as_table).unwrap_or(&nothing);
                tables::update_section(&mut document, key, was, will);
            }
            (Some(Value::Table(was)), None) => tables::update_section(&mut document, key, was, &nothing),
            (_, Some(will)) => set(document.as_table_mut(), key, will),
            (_, None) => {
                let left = remove(document.as_table_mut(), key);
                tables::leave_behind(&mut document, 0, left);
            }
        }
    }
    let changed = document.to_string();
    Ok(if text.contains("\r\n") { changed.replace('\n', "\r\n") } else { changed })
}

/// Makes a table say what is wanted.
///
/// Returns: comments of the place that no key stands behind any more.
fn update(table: &mut dyn TableLike, present: &Table, wanted: &Table) -> String {
    let nothing = Table::new();
    let mut left = String::new();
    for key in keys(present, wanted) {
        match (present.get(key), wanted.get(key)) {
            (was, will) if was == will => {}
            (_, None) => left += &remove(table, key),
            (was, Some(Value::Table(will))) if table.get(key).is_some_and(Item::is_table_like) => {
                let was = was.and_then(Value::as_table).unwrap_or(&nothing);
                left += &update_item(table.get_mut(key).expect("it was looked at"), was, will);
            }
            (_, Some(will)) => set(table, key, will),
        }
    }
    left
}

fn update_item(item: &mut Item, present: &Table, wanted: &Table) -> String {
    let left = update(item.as_table_like_mut().expect("a table, by the schema"), present, wanted);
    if let Item::Value(toml_edit::Value::InlineTable(table)) = item {
        entries::respace(table);
    }
    left
}

/// All keys, those of `present` first, in their order.
fn keys<'a>(present: &'a Table, wanted: &'a Table) -> Vec<&'a String> {
    present.keys().chain(wanted.keys().filter(|key| !present.contains_key(*key))).collect()
}

fn is_tables(value: &Value) -> bool {
    value.as_array().is_some_and(|entries| !entries.is_empty() && entries.iter().all(Value::is_table))
}

fn list(value: Option<&Value>) -> &[Value] {
    value.and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

/// Puts a value, behind the comments of the one that stood there.
fn set(table: &mut dyn TableLike, key: &str, wanted: &Value) {
    match table.get_mut(key) {
        Some(Item::Value(value)) => entries::set(value, wanted),
        _ => {
            table.insert(key, Item::Value(entries::written(wanted)));
        }
    }
}

/// Takes a key out, with its own comments.
///
/// Returns: the comments of the place, unless another key stands behind them now.
fn remove(table: &mut dyn TableLike, key: &str) -> String {
    let Some((name, item)) = table.get_key_value(key) else { return String::new() };
    let decor = item.as_table().filter(|table| !table.is_dotted()).map_or(name.leaf_decor(), |table| table.decor());
    let of_place = of_place_and_own(text(decor.prefix())).0.to_string();
    let next = table.iter().map(|(name, _)| name.to_string()).skip_while(|name| name != key).nth(1);
    table.remove(key);
    if !of_place.contains('#') {
        return String::new();
    }
    match next.and_then(|next| table.key_mut(&next)) {
        Some(mut next) => {
            let decor = next.leaf_decor_mut();
            let below = text(decor.prefix()).to_string();
            decor.set_prefix(joined(&of_place, &below));
            String::new()
        }
        None => of_place,
    }
}

/// The lines before something: those that belong to the place, up to the last blank one, and its own.
fn of_place_and_own(prefix: &str) -> (&str, &str) {
    let mut at = 0;
    let ends = prefix.split_inclusive('\n').map(|line| {
        at += line.len();
        if line.trim().is_empty() && line.ends_with('\n') { at } else { 0 }
    });
    prefix.split_at(ends.max().unwrap_or(0))
}

/// Comments of a place, and those of the next place below them: one blank line between them is enough.
fn joined(above: &str, below: &str) -> String {
    let rest = if above.is_empty() { below } else { below.strip_prefix('\n').unwrap_or(below) };
    format!("{above}{rest}")
}

fn text(raw: Option<&RawString>) -> &str {
    raw.and_then(RawString::as_str).unwrap_or_default()
}

/// Which entry of `present` becomes which of `wanted`: the same one, else one of the same title, else one with the same list.
fn matched(present: &[Value], wanted: &[Value]) -> Vec<Option<usize>> {
    let mut free = vec![true; present.len()];
    let mut found = vec![None; wanted.len()];
    let alike: [fn(&Value, &Value) -> bool; 4] = [
        |a, b| a == b,
        |a, b| a.get("title").is_some_and(|title| Some(title) == b.get("title")),
        |a, b| a.get("signals").is_some_and(|signals| Some(signals) == b.get("signals")),
        |a, b| a.get("settings").is_some_and(|settings| Some(settings) == b.get("settings")),
    ];
    for alike in alike {
        for (k, new) in wanted.iter().enumerate() {
            if found[k].is_some() {
                continue;
            }
            found[k] = (0..present.len()).find(|&i| free[i] && alike(&present[i], new));
            found[k].into_iter().for_each(|i| free[i] = false);
        }
    }
    found
}
