//! Fixed text with marks in it.

/// What the arithmetic of every text in C must be, for the preprocessor.
pub(crate) const ARITHMETIC: &str = include_str!("../templates/arithmetic.c");

/// `template` with its marks filled in.
///
/// Panics: a mark that the template does not have, or one that nothing fills, is our own bug.
pub(crate) fn filled(template: &str, marks: &[(&str, &str)]) -> String {
    let mut text = String::with_capacity(template.len());
    let mut used = vec![false; marks.len()];
    let mut rest = template;
    while let Some((before, mark, after)) = next_mark(rest) {
        let found = marks.iter().position(|(name, _)| *name == mark);
        let k = found.unwrap_or_else(|| panic!("nothing fills the mark @{mark}@"));
        used[k] = true;
        text.push_str(before);
        text.push_str(marks[k].1);
        rest = after;
    }
    let unused = marks.iter().zip(&used).find(|(_, used)| !**used);
    assert!(unused.is_none(), "the template lacks the mark {unused:?}");
    text.push_str(rest);
    text
}

/// What stands before the next `@MARK@`, the mark, and what stands behind it.
fn next_mark(text: &str) -> Option<(&str, &str, &str)> {
    let mark = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_';
    text.match_indices('@').find_map(|(at, _)| {
        let (name, after) = text[at + 1..].split_once('@')?;
        let is_mark = !name.is_empty() && name.chars().all(mark);
        is_mark.then(|| (&text[..at], name, after))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_filled_and_other_signs_stay() {
        let text = filled("a = @A@; b@c, $@: @B_2@@A@", &[("A", "1@B_2@"), ("B_2", "")]);
        assert_eq!(text, "a = 1@B_2@; b@c, $@: 1@B_2@");
    }

    #[test]
    #[should_panic(expected = "nothing fills the mark @B@")]
    fn a_mark_without_text_is_found() {
        filled("@B@", &[]);
    }

    #[test]
    #[should_panic(expected = "lacks the mark")]
    fn a_text_without_a_mark_is_found() {
        filled("text", &[("B", "1")]);
    }
}
