//! The typeface: Noto Sans, shipped as bytes, so that measuring and drawing never depend on the system.
//!
//! Raised and lowered characters (10⁻⁵, G₀, uₚ) are set as smaller plain ones: few typefaces have them all, and those
//! that do draw them unevenly.

use skrifa::instance::{LocationRef, Size};
use skrifa::{FontRef, MetadataProvider};
use std::sync::LazyLock;

/// What the SVG asks for; a browser that lacks Noto Sans takes the next, all of them narrower or nearly as wide.
pub(crate) const FAMILIES: &str = "'Noto Sans', 'Segoe UI', 'Helvetica Neue', Arial, 'Liberation Sans', sans-serif";

/// The faces that the PNG writer draws with.
pub(crate) const FACES: [&[u8]; 2] = [notosans::REGULAR_TTF, notosans::BOLD_TTF];

/// Size of raised and lowered characters, relative.
pub(crate) const SCRIPT_SIZE: f64 = 0.72;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Weight {
    Regular,
    Bold,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Level {
    Base,
    Raised,
    Lowered,
}

impl Level {
    /// How far above the base line, in sizes of the text.
    pub(crate) fn rise(self) -> f64 {
        match self {
            Level::Base => 0.0,
            Level::Raised => 0.38,
            Level::Lowered => -0.18,
        }
    }
}

static REGULAR: LazyLock<FontRef<'static>> = LazyLock::new(|| parsed(notosans::REGULAR_TTF));
static BOLD: LazyLock<FontRef<'static>> = LazyLock::new(|| parsed(notosans::BOLD_TTF));

fn parsed(bytes: &'static [u8]) -> FontRef<'static> {
    FontRef::new(bytes).expect("the shipped typeface parses")
}

/// Width of a line of text [px]: the sum of its advances, kerning left out.
pub(crate) fn width(text: &str, size: f64, weight: Weight) -> f64 {
    let font = match weight {
        Weight::Regular => &*REGULAR,
        Weight::Bold => &*BOLD,
    };
    let (glyphs, metrics) = (font.charmap(), font.glyph_metrics(Size::new(size as f32), LocationRef::default()));
    let advance = |c: char| f64::from(metrics.advance_width(glyphs.map(c).unwrap_or_default()).unwrap_or(0.0));
    text.chars().map(levelled).map(|(c, level)| advance(c) * if level == Level::Base { 1.0 } else { SCRIPT_SIZE }).sum()
}

/// The text cut where its level changes, raised and lowered characters replaced by plain ones.
pub(crate) fn runs(text: &str) -> Vec<(String, Level)> {
    let mut runs: Vec<(String, Level)> = vec![];
    for (c, level) in text.chars().map(levelled) {
        match runs.last_mut() {
            Some((run, same)) if *same == level => run.push(c),
            _ => runs.push((c.into(), level)),
        }
    }
    runs
}

fn levelled(c: char) -> (char, Level) {
    const RAISED: &str = "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻";
    const LOWERED: &str = "₀₁₂₃₄₅₆₇₈₉₊₋ₐₑₕᵢⱼₖₗₘₙₒₚᵣₛₜᵤᵥₓ";
    const PLAIN: &str = "0123456789+\u{2212}aehijklmnoprstuvx";
    let find = |set: &str| set.chars().position(|raised| raised == c).and_then(|k| PLAIN.chars().nth(k));
    match (find(RAISED), find(LOWERED)) {
        (Some(plain), _) => (plain, Level::Raised),
        (_, Some(plain)) => (plain, Level::Lowered),
        _ => (c, Level::Base),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_that_the_reports_use_has_a_glyph() {
        let letters = "αβγδεζηθκλμνξπρστφχψωΓΔΘΛΠΣΦΨΩ−×±·°µ≤≥≈–—′“”…√∞∂‖∑∫←→½† G₀ 10⁻⁵ uₚ vᵣₑₛ s²";
        for font in [&*REGULAR, &*BOLD] {
            let drawn: String = runs(letters).into_iter().map(|(run, _)| run).collect();
            let missing: String = drawn.chars().filter(|c| font.charmap().map(*c).is_none()).collect();
            assert_eq!(missing, "");
        }
    }

    #[test]
    fn levels_cut_the_text() {
        let expected = [("|G", Level::Base), ("0", Level::Lowered), ("| 10", Level::Base), ("−12", Level::Raised)];
        assert_eq!(runs("|G₀| 10⁻¹²"), expected.map(|(run, level)| (run.to_string(), level)));
    }

    #[test]
    fn widths_add_and_grow_with_the_size() {
        let regular = |text: &str| width(text, 12.0, Weight::Regular);
        assert!(regular("MM") > 2.0 * regular("il"));
        assert!((width("MM", 24.0, Weight::Regular) / regular("MM") - 2.0).abs() < 1e-3);
        assert!((regular("abc") - regular("a") - regular("bc")).abs() < 1e-4);
        assert!((regular("₀") / regular("0") - SCRIPT_SIZE).abs() < 1e-6);
    }
}
