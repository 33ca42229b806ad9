//! exp and ln whose last bit no library decides.
//!
//! Enters: numbers of the ranges that noise and friction need. Leaves: the same bits on every machine, made of sums, products
//! and divisions alone, in an order that the simulated rig in C repeats (flexbeam-codegen, `templates/rig/NAME.c`).

/// ln 2 in two parts: the first has 33 bits, so that its products with exponents are exact.
pub const LN_2_HIGH: f64 = f64::from_bits(0x3fe6_2e42_fee0_0000);
/// ln 2 - [`LN_2_HIGH`].
pub const LN_2_LOW: f64 = f64::from_bits(0x3dea_39ef_3579_3c76);

/// Below this exp is 0, subnormal numbers included.
pub const EXP_IS_ZERO: f64 = -745.2;

/// 1/n!, n = 13, 12, .. 0: the first term left out is below 5e-18 for |r| <= ln(2)/2.
pub const EXP_TERMS: [f64; 14] = {
    let mut terms = [1.0; 14];
    let mut n = 1;
    let mut factorial = 1.0;
    while n <= 13 {
        factorial *= n as f64;
        terms[13 - n] = 1.0 / factorial;
        n += 1;
    }
    terms
};

/// 2/(2k + 1), k = 11, 10, .. 1: the first term left out is below 4e-20 for |s| <= 0.172.
pub const LN_TERMS: [f64; 11] = {
    let mut terms = [0.0; 11];
    let mut k = 1;
    while k <= 11 {
        terms[11 - k] = 2.0 / (2 * k + 1) as f64;
        k += 1;
    }
    terms
};

/// exp(x) for x <= 0.
///
/// Returns: what is not a number as it is.
/// Numerics: within 1 unit in the last place (`tests`), but for subnormal answers.
pub fn exp(x: f64) -> f64 {
    if !(x >= EXP_IS_ZERO) {
        return if x < EXP_IS_ZERO { 0.0 } else { x };
    }
    let k = (x * std::f64::consts::LOG2_E - 0.5) as i32; // to the nearest whole number, for x <= 0
    let r = (x - f64::from(k) * LN_2_HIGH) - f64::from(k) * LN_2_LOW;
    let series = EXP_TERMS.iter().fold(0.0, |sum, term| sum * r + term);
    let half = k / 2;
    series * power_of_two(half) * power_of_two(k - half)
}

/// ln(x) for normal x > 0: x = 2^k (1 + f), s = f/(2 + f), ln(1 + f) = 2 artanh(s) = f - (f^2/2 - s (f^2/2 + series)).
///
/// Numerics: within 1 unit in the last place (`tests`): what is rounded is small beside f.
/// Source: the arrangement of sums is that of fdlibm, `e_log.c`.
pub fn ln(x: f64) -> f64 {
    let bits = x.to_bits();
    // The mantissa's top bits above those of sqrt(2) take the exponent above: m lies in [sqrt(1/2), sqrt(2)).
    let k = ((bits.wrapping_add(ABOVE_ROOT_2)) >> 52) as i32 - 1023;
    let m = f64::from_bits(bits.wrapping_sub((k as u64) << 52));
    let f = m - 1.0;
    let s = f / (2.0 + f);
    let square = s * s;
    let series = LN_TERMS.iter().fold(0.0, |sum, term| sum * square + term) * square;
    let half_square = 0.5 * f * f;
    let k = f64::from(k);
    k * LN_2_HIGH - ((half_square - (s * (half_square + series) + k * LN_2_LOW)) - f)
}

/// Bits that a mantissa from sqrt(2) on lacks of the next power of two.
pub const ABOVE_ROOT_2: u64 = 0x0009_5f61_9980_c433;

/// 2^k for a normal number.
fn power_of_two(k: i32) -> f64 {
    f64::from_bits(((1023 + k) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance in units in the last place of the second.
    fn units(found: f64, right: f64) -> f64 {
        (found - right).abs() / (f64::from_bits(right.abs().to_bits() + 1) - right.abs())
    }

    #[test]
    fn the_parts_of_ln_2_make_ln_2() {
        assert_eq!(LN_2_HIGH + LN_2_LOW, std::f64::consts::LN_2);
        assert_eq!(LN_2_HIGH.to_bits() & 0xf_ffff, 0);
        assert_eq!(2f64.sqrt().to_bits() & ((1 << 52) - 1), (1 << 52) - ABOVE_ROOT_2);
    }

    #[test]
    fn exp_is_the_library_s_within_a_unit() {
        let mut worst: f64 = 0.0;
        for k in 0..200_000 {
            let x = -708.0 * (f64::from(k) / 200_000.0).powi(3);
            worst = worst.max(units(exp(x), x.exp()));
        }
        assert!(worst <= 1.0, "{worst}");
        assert_eq!([exp(0.0), exp(-0.0), exp(-746.0), exp(f64::NEG_INFINITY)], [1.0, 1.0, 0.0, 0.0]);
        assert!(exp(f64::NAN).is_nan());
        assert!((exp(-744.0) / (-744.0_f64).exp() - 1.0).abs() < 0.5, "{:e}", exp(-744.0));
    }

    #[test]
    fn ln_is_the_library_s_within_a_unit() {
        let mut worst: f64 = 0.0;
        for k in 1..200_000 {
            let part = f64::from(k) / 200_000.0;
            for x in [part, 1.0 - f64::EPSILON * part * 1e6, part * 2f64.powi(-50), 1e300 * part, part * 1e-290] {
                if x != 1.0 {
                    worst = worst.max(units(ln(x), x.ln()));
                }
            }
        }
        assert!(worst <= 1.0, "{worst}");
        assert_eq!(ln(1.0), 0.0);
    }
}
