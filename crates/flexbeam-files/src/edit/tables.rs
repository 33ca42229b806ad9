//! Sections and arrays of tables changed in place: added, removed, reordered.

use super::entries::{set_entries, written};
use super::{joined, matched, of_place_and_own, text, update_item};
use toml::Value;
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table};

/// Makes the table `key` say what is wanted; a new one comes before the first array of tables.
pub(super) fn update_section(document: &mut DocumentMut, key: &str, present: &toml::Table, wanted: &toml::Table) {
    let new = position_of_new(document);
    let item = document.as_table_mut().entry(key).or_insert_with(|| {
        let mut table = Table::new();
        table.decor_mut().set_prefix("\n");
        table.set_position(Some(new));
        Item::Table(table)
    });
    let left = update_item(item, present, wanted);
    let position = item.as_table().and_then(Table::position).unwrap_or(0);
    leave_behind(document, position, left);
}

/// Behind everything that stands before the first array of tables.
fn position_of_new(document: &DocumentMut) -> isize {
    let arrays = document.iter().filter_map(|(_, item)| item.as_array_of_tables());
    let first = arrays.filter_map(|array| array.get(0)?.position()).min();
    let positions = positions(document.as_table());
    match first {
        Some(first) => positions.into_iter().filter(|position| *position < first).max().unwrap_or(0),
        None => 1 + positions.into_iter().max().unwrap_or(0),
    }
}

/// Makes the array of tables `key` hold the wanted ones; those that stay keep their text.
pub(super) fn update(document: &mut DocumentMut, key: &str, present: &[Value], wanted: &[Value]) {
    if let Some(Item::Value(toml_edit::Value::Array(array))) = document.get_mut(key) {
        return set_entries(array, present, wanted);
    }
    let end = 1 + positions(document.as_table()).into_iter().max().unwrap_or(0);
    let old: Vec<Table> = match document.remove(key) {
        Some(Item::ArrayOfTables(tables)) => tables.into_iter().collect(),
        _ => Vec::new(),
    };
    let found = matched(present, wanted);
    let moves = found.len() != old.len() || found.iter().enumerate().any(|(k, i)| *i != Some(k));
    let mut array = Rows::of(old, end, moves);
    for (k, (wanted, i)) in wanted.iter().zip(found).enumerate() {
        let wanted = wanted.as_table().expect("the caller has looked");
        match i {
            Some(i) => array.keep(i, k, present[i].as_table().expect("the caller has looked"), wanted),
            None => array.add(k, wanted),
        }
    }
    let Rows { places, mut carried, of_places, new, .. } = array;
    let unused = of_places.iter().skip(wanted.len()).filter(|comments| comments.contains('#'));
    carried = unused.fold(carried, |above, below| joined(&above, below));
    if !new.is_empty() {
        document.insert(key, Item::ArrayOfTables(new.into_iter().collect::<ArrayOfTables>()));
    }
    leave_behind(document, places.last().copied().unwrap_or(end), carried);
}

/// An array of tables under way from the old one to the new one.
struct Rows {
    old: Vec<Option<Table>>,
    /// Where the old ones stand in the text.
    places: Vec<isize>,
    /// Where a new one stands if there was none.
    end: isize,
    /// Comments of those places.
    of_places: Vec<String>,
    /// Comments that look for something to stand before.
    carried: String,
    new: Vec<Table>,
    /// Whether any of them comes to stand elsewhere.
    moves: bool,
}

impl Rows {
    fn of(old: Vec<Table>, end: isize, moves: bool) -> Rows {
        Rows {
            places: old.iter().filter_map(Table::position).collect(),
            of_places: old.iter().map(|table| of_place_and_own(text(table.decor().prefix())).0.into()).collect(),
            old: old.into_iter().map(Some).collect(),
            end,
            carried: String::new(),
            new: Vec::new(),
            moves,
        }
    }

    fn keep(&mut self, i: usize, k: usize, present: &toml::Table, wanted: &toml::Table) {
        let mut item = Item::Table(self.old[i].take().expect("each is matched once"));
        let left = update_item(&mut item, present, wanted);
        let table = item.into_table().expect("it was put there as one");
        self.put(k, table, i != k);
        self.carried += &left;
    }

    fn add(&mut self, k: usize, wanted: &toml::Table) {
        let table = wanted.iter().map(|(key, value)| (key, Item::Value(written(value)))).collect();
        self.put(k, table, true);
    }

    fn put(&mut self, k: usize, mut table: Table, elsewhere: bool) {
        let own = of_place_and_own(text(table.decor().prefix())).1;
        let carried = std::mem::take(&mut self.carried);
        let mut of_place = joined(&carried, self.of_places.get(k).map_or("", String::as_str));
        if elsewhere && !of_place.ends_with('\n') {
            of_place.push('\n');
        }
        let prefix = of_place + own;
        table.decor_mut().set_prefix(prefix);
        if self.moves {
            place(&mut table, self.places.get(k).or(self.places.last()).copied().unwrap_or(self.end));
        }
        self.new.push(table);
    }
}

/// A table and those in it, at one place of the text: they keep their order there.
fn place(table: &mut Table, position: isize) {
    table.set_position(Some(position));
    for (_, item) in table.iter_mut() {
        if let Item::Table(inner) = item {
            place(inner, position);
        }
    }
}

/// The places of all tables below this one.
fn positions(table: &Table) -> Vec<isize> {
    let mut found = Vec::new();
    for (_, item) in table.iter() {
        let tables: Vec<&Table> = match item {
            Item::Table(table) => vec![table],
            Item::ArrayOfTables(tables) => tables.iter().collect(),
            _ => Vec::new(),
        };
        for table in tables {
            found.extend(table.position().filter(|_| !table.is_dotted()));
            found.extend(positions(table));
        }
    }
    found
}

/// Comments before the next table behind this place, or at the end of the text.
pub(super) fn leave_behind(document: &mut DocumentMut, after: isize, comments: String) {
    if comments.is_empty() {
        return;
    }
    let next = positions(document.as_table()).into_iter().filter(|position| *position > after).min();
    match next.and_then(|position| at(document.as_table_mut(), position)) {
        Some(table) => {
            let below = text(table.decor().prefix()).to_string();
            table.decor_mut().set_prefix(joined(&comments, &below));
        }
        None => {
            let below = document.trailing().as_str().unwrap_or_default().to_string();
            document.set_trailing(joined(&comments, &below));
        }
    }
}

fn at(table: &mut Table, position: isize) -> Option<&mut Table> {
    for (_, item) in table.iter_mut() {
        let tables: Vec<&mut Table> = match item {
            Item::Table(table) => vec![table],
            Item::ArrayOfTables(tables) => tables.iter_mut().collect(),
            _ => Vec::new(),
        };
        for table in tables {
            if table.position() == Some(position) && !table.is_dotted() {
                return Some(table);
            }
            if let Some(found) = at(table, position) {
                return Some(found);
            }
        }
    }
    None
}
