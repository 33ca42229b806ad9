//! A number in a cell.

/// What stands between the whole part and the fraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Decimal {
    Point,
    Comma,
}

/// A cell's text without the quotes around it.
pub(super) fn unquoted(cell: &str) -> &str {
    cell.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')).map_or(cell, str::trim_ascii)
}

/// The number in an unquoted cell, and the decimal sign where it has one; nothing for what is no number.
///
/// A comma counts as decimal sign only once, between digits, and without a point: `1.234,5` and `1,234,567` are no numbers.
/// Numerics: correctly rounded.
pub(super) fn number(text: &str) -> Option<(f64, Option<Decimal>)> {
    if let Ok(value) = text.parse::<f64>() {
        return Some((value, text.contains('.').then_some(Decimal::Point)));
    }
    let (whole, fraction) = text.split_once(',')?;
    let digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
    let between_digits = digit(whole.chars().next_back()) && digit(fraction.chars().next());
    let only_sign = !whole.contains('.') && !fraction.contains(['.', ',']);
    let value = (between_digits && only_sign).then(|| format!("{whole}.{fraction}").parse::<f64>().ok())??;
    Some((value, Some(Decimal::Comma)))
}

/// Whether a cell holds a number.
pub(super) fn is_number(cell: &str) -> bool {
    number(unquoted(cell)).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_comma_between_digits_is_a_decimal_sign() {
        for (text, value, sign) in [
            ("-1.5e3", -1500.0, Some(Decimal::Point)),
            ("7", 7.0, None),
            ("0,1", 0.1, Some(Decimal::Comma)),
            ("-12,5e-3", -0.0125, Some(Decimal::Comma)),
            ("+1,0", 1.0, Some(Decimal::Comma)),
        ] {
            assert_eq!(number(text), Some((value, sign)), "{text}");
        }
        for text in ["", "1.234,5", "1,234,567", "1,", ",5", "1, 5", "abc", "1,5,", "1.2.3"] {
            assert_eq!(number(text), None, "{text}");
        }
        assert_eq!((unquoted("\" 1,5\""), unquoted("\"1"), is_number("\"1,5\"")), ("1,5", "\"1", true));
    }
}
