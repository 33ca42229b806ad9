//! A bar that grows from the middle to either side, in half cells.

const MIDDLE: char = '│';

/// The bar of `x` between `-end` and `end`, `width` cells wide; a value beyond its end fills its side.
pub fn bar(x: f64, end: f64, width: usize) -> String {
    let side = width.saturating_sub(1) / 2;
    let part = if end > 0.0 && x.is_finite() { (x / end).clamp(-1.0, 1.0) } else { 0.0 };
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
            assert_eq!(bar(x, 8.0, 9), expected, "{x}");
        }
        assert_eq!(bar(1.0, 1.0, 10).chars().count(), 9, "a bar has a middle");
        assert_eq!(bar(1.0, 0.0, 3), " │ ");
        assert_eq!(bar(1.0, 1.0, 0), "│");
    }
}
