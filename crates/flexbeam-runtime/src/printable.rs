//! What a viewer wrote, made fit for terminals and recordings.

/// Longest text [characters].
const LONGEST: usize = 800;

/// Real-time: no. Without what would move a terminal's cursor, and not longer than [`LONGEST`].
pub(crate) fn fit_to_print(text: &str) -> String {
    text.chars().filter(|c| *c == '\n' || !c.is_control()).take(LONGEST).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_viewer_cannot_write_on_the_terminal() {
        let text = fit_to_print(&format!("a\u{1b}[2Jb\r{}", "x".repeat(100_000)));
        assert!(text.starts_with("a[2Jbx") && text.chars().count() == LONGEST, "{text}");
    }
}
