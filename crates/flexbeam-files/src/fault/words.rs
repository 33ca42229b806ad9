//! Numbers and schemas in the words of a message.

/// Six digits are plenty to recognise a number by.
pub(crate) fn six_digits(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}

/// "1 row of numbers", "2 rows of numbers".
pub(super) fn counted(number: usize, noun: &str, rest: &str) -> String {
    let plural = match (number, noun.strip_suffix('y')) {
        (1, _) => noun.to_string(),
        (_, Some(stem)) => format!("{stem}ies"),
        (_, None) => format!("{noun}s"),
    };
    format!("{number} {plural} {rest}").trim_end().to_string()
}

/// Another version, or another kind.
pub(super) fn schema_hint(found: &str, needed: &str) -> String {
    let kind = |schema: &str| schema.split('/').next().unwrap_or_default().to_string();
    if kind(found) == kind(needed) {
        "another version of flexbeam wrote it: use that one, or make the file again".into()
    } else {
        format!("it is a {} file; name a {} file here", kind(found), kind(needed))
    }
}
