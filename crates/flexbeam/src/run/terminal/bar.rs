//! A bar that grows from the middle to either side, in half cells.

const MIDDLE: char = '│';

/// A bar of a part between -1 and 1, `width` cells wide. More fills its side; what is no number leaves both empty.
pub fn bar(part: f64, width: usize) -> String {
    let side = width.saturating_sub(1) / 2;
    let part = if part.is_nan() { 0.0 } else { part.clamp(-1.0, 1.0) };
    let halves = (part.abs() * 2.0 * side as f64).round() as usize;
    let (full, half) = (halves / 2, halves % 2);
    let empty = " ".repeat(side - full - half);
    let filled = "━".repeat(full);
    let nothing = " ".repeat(side);
    if part < 0.0 {
        format!("{empty}{}{filled}{MIDDLE}{nothing}", "╺".repeat(half))
    } else {
        format!("{nothing}{MIDDLE}{filled}{}{empty}", "╸".repeat(half))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_grow_from_the_middle() {
        for (x, expected) in [
            (0.0, "    │    "),
            (2.0, "    │━   "),
            (3.0, "    │━╸  "),
            (-3.0, "  ╺━│    "),
            (8.0, "    │━━━━"),
            (80.0, "    │━━━━"),
            (-80.0, "━━━━│    "),
            (f64::NAN, "    │    "),
        ] {
            assert_eq!(bar(x / 8.0, 9), expected, "{x}");
        }
        assert_eq!(bar(1.0, 10).chars().count(), 9, "a bar has a middle");
        assert_eq!(bar(f64::INFINITY, 3), " │━");
        assert_eq!(bar(1.0, 0), "│");
    }
}
