//! TOML for people: a row of a matrix a line, numbers in the shortest form that reads back to their bits.

use std::fmt::Write;
use toml::{Table, Value};

/// The table as a TOML document.
pub(crate) fn toml_text(table: &Table) -> String {
    let mut text = String::new();
    write_table(&mut text, "", table);
    text
}

/// A table's plain values first, then its tables, as TOML demands.
fn write_table(text: &mut String, path: &str, table: &Table) {
    for (name, value) in table.iter().filter(|(_, value)| !is_tables(value)) {
        push(text, format_args!("{} = ", key(name)));
        write_value(text, value);
        text.push('\n');
    }
    for (name, value) in table {
        let path = if path.is_empty() { key(name) } else { format!("{path}.{}", key(name)) };
        match value {
            Value::Table(inner) => write_section(text, &path, ["[", "]"], inner),
            Value::Array(tables) if is_tables(value) => {
                for inner in tables.iter().filter_map(Value::as_table) {
                    write_section(text, &path, ["[[", "]]"], inner);
                }
            }
            _ => {}
        }
    }
}

fn write_section(text: &mut String, path: &str, [open, close]: [&str; 2], table: &Table) {
    push(text, format_args!("\n{open}{path}{close}\n"));
    write_table(text, path, table);
}

/// Whether a value is written as sections of its own.
fn is_tables(value: &Value) -> bool {
    match value {
        Value::Table(_) => true,
        Value::Array(entries) => !entries.is_empty() && entries.iter().all(Value::is_table),
        _ => false,
    }
}

fn write_value(text: &mut String, value: &Value) {
    match value {
        Value::Array(rows) if rows.iter().any(Value::is_array) => {
            text.push_str("[\n");
            for row in rows {
                text.push_str("  ");
                write_value(text, row);
                text.push_str(",\n");
            }
            text.push(']');
        }
        Value::Array(entries) => {
            text.push('[');
            for (k, entry) in entries.iter().enumerate() {
                text.push_str(if k == 0 { "" } else { ", " });
                write_value(text, entry);
            }
            text.push(']');
        }
        Value::Float(x) if x.is_nan() => text.push_str("nan"),
        Value::Float(x) => push(text, format_args!("{x:?}")),
        Value::String(x) => text.push_str(&quoted(x)),
        other => push(text, format_args!("{other}")),
    }
}

fn key(name: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !name.is_empty() && name.chars().all(bare) { name.into() } else { quoted(name) }
}

/// A TOML basic string, with its quotes: JSON's escapes are TOML's, but JSON leaves DEL alone and TOML does not allow it.
pub fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string().replace('\u{7f}', "\\u007F")
}

fn push(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    text.write_fmt(arguments).expect("a String takes any text");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_what_a_toml_parser_reads() {
        let text = r#"
            words = "a \"b\" \\ \n \u007f ü"
            "odd key" = 1
            numbers = [1.0, -0.0, 5e-324, 1.7976931348623157e308, inf, 1]
            rows = [[1.0, 2.0], []]
            none = []
            [a.b]
            c = true
            [[a.d]]
            e = 1
            [[a.d]]
            e = [[[1]]]
        "#;
        let table: Table = text.parse().unwrap();
        let again: Table = toml_text(&table).parse().unwrap();
        assert_eq!(again, table);
        let zero = again["numbers"][1].as_float().unwrap();
        assert!(zero == 0.0 && zero.is_sign_negative());
    }

    #[test]
    fn a_row_of_a_matrix_is_a_line() {
        let table: Table = "A = [[1.0, 2.5], [1e-7, 0.1]]".parse().unwrap();
        assert_eq!(toml_text(&table), "A = [\n  [1.0, 2.5],\n  [1e-7, 0.1],\n]\n");
    }
}
