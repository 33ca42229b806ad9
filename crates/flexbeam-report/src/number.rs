//! Numbers as text, for the terminal, the page and the picture.

/// Exponents in this range are written out, others as powers of ten.
const PLAIN_EXPONENTS: std::ops::Range<i32> = -4..6;

/// `x` with `digits` significant digits: `0.4653`, `-12.59`, `1.240e-7`, `inf`, `nan`.
///
/// Numerics: rounded once, from the binary value; trailing zeros stay, because they are significant. A zero has no
/// significant digit and is written `0`.
pub fn significant(x: f64, digits: usize) -> String {
    if x == 0.0 {
        return "0".into();
    }
    if !x.is_finite() {
        return format!("{x}").to_lowercase();
    }
    let places = digits.max(1) - 1;
    let scientific = format!("{x:.places$e}");
    let exponent = exponent_of(&scientific);
    if !PLAIN_EXPONENTS.contains(&exponent) {
        return scientific;
    }
    let decimals = (places as i32 - exponent).max(0) as usize;
    if exponent > places as i32 {
        // Digits that are not significant become zeros: 123456 with 3 digits is 123000.
        let rounded: f64 = scientific.parse().expect("a float that format! wrote parses");
        return format!("{rounded:.0}");
    }
    format!("{x:.decimals$}")
}

/// `x` with an SI prefix before the unit: `engineering(0.00123, 3, "s")` is `1.23 ms`.
///
/// Prefixes from pico to giga; beyond them [`significant`] writes the power of ten.
pub fn engineering(x: f64, digits: usize, unit: &str) -> String {
    const PREFIXES: [&str; 8] = ["p", "n", "µ", "m", "", "k", "M", "G"];
    const FIRST: i32 = -12;
    let group = match x.is_finite() && x != 0.0 {
        true => exponent_of(&format!("{x:.*e}", digits.max(1) - 1)).div_euclid(3),
        false => 0,
    };
    let prefix = usize::try_from(group - FIRST / 3).ok().and_then(|k| PREFIXES.get(k));
    match prefix {
        Some(prefix) => format!("{} {prefix}{unit}", significant(x / 1000f64.powi(group), digits)),
        None => format!("{} {unit}", significant(x, digits)),
    }
}

/// The number as print sets it: a true minus sign, `1.24e-7` as `1.24 × 10⁻⁷`, `1e5` as `10⁵`.
pub fn typographic(number: &str) -> String {
    let (mantissa, exponent) = match number.split_once('e') {
        Some((mantissa, exponent)) if exponent.parse::<i32>().is_ok() => (mantissa, exponent),
        _ => return number.replace('-', "\u{2212}"),
    };
    let raised: String = exponent.chars().map(superscript).collect();
    match mantissa {
        "1" => format!("10{raised}"),
        _ => format!("{} × 10{raised}", mantissa.replace('-', "\u{2212}")),
    }
}

fn superscript(c: char) -> char {
    match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        _ => char::from_u32('⁰' as u32 + c.to_digit(10).unwrap_or(0)).expect("superscript digits are contiguous"),
    }
}

fn exponent_of(scientific: &str) -> i32 {
    let (_, exponent) = scientific.split_once('e').expect("{:e} writes an exponent");
    exponent.parse().expect("{:e} writes an integer exponent")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn significant_digits_are_kept_and_counted() {
        for (x, digits, text) in [
            (0.4652946, 4, "0.4653"),
            (-12.586, 4, "-12.59"),
            (1.24e-7, 4, "1.240e-7"),
            (9.9996, 4, "10.00"),
            (123456.0, 3, "123000"),
            (999999.0, 3, "1.00e6"),
            (30.0, 2, "30"),
            (0.0, 3, "0"),
            (f64::NEG_INFINITY, 3, "-inf"),
            (f64::NAN, 3, "nan"),
        ] {
            assert_eq!(significant(x, digits), text);
        }
    }

    #[test]
    fn engineering_chooses_the_prefix_after_rounding() {
        for (x, text) in [
            (0.00123, "1.23 ms"),
            (0.9999, "1.00 s"),
            (-4700.0, "-4.70 ks"),
            (0.0, "0 s"),
            (5e-11, "50.0 ps"),
            (3e-20, "3.00e-20 s"),
            (2e15, "2.00e15 s"),
        ] {
            assert_eq!(engineering(x, 3, "s"), text);
        }
    }

    #[test]
    fn print_has_true_minus_signs_and_raised_exponents() {
        assert_eq!(typographic("1e-3"), "10⁻³");
        assert_eq!(typographic("-1.24e-17"), "−1.24 × 10⁻¹⁷");
        assert_eq!(typographic("-12.59"), "−12.59");
        assert_eq!(typographic("one"), "one");
    }

    proptest::proptest! {
        #[test]
        fn significant_parses_back_within_half_a_digit(x in -1e300f64..1e300, scale in -300i32..0, digits in 1usize..15) {
            let x = x * 10f64.powi(scale);
            let read: f64 = significant(x, digits).parse().unwrap();
            proptest::prop_assert!((read - x).abs() <= x.abs() * 0.5001 * 10f64.powi(1 - digits as i32));
        }
    }
}
