//! Numbers as source text that every compiler reads back to the last bit.

use crate::Precision;

impl Precision {
    /// The nearest number of this precision.
    pub(crate) fn nearest(self, x: f64) -> f64 {
        match self {
            Precision::F64 => x,
            Precision::F32 => f64::from(x as f32),
        }
    }

    /// A small subnormal number.
    pub(crate) fn subnormal(self) -> f64 {
        match self {
            Precision::F64 => f64::from_bits(0x5_0003_0001),     // about 1e-313
            Precision::F32 => f64::from(f32::from_bits(0x1801)), // about 1e-41
        }
    }
}

/// A hexadecimal floating-point constant of C99; infinities and NaN by the names of <math.h>.
///
/// Assumes: x is a number of that precision.
pub(crate) fn hexadecimal(x: f64, precision: Precision) -> String {
    let sign = if x.is_sign_negative() && !x.is_nan() { "-" } else { "" };
    let suffix = if precision == Precision::F32 { "f" } else { "" };
    if x.is_nan() {
        "NAN".to_owned()
    } else if x.is_infinite() {
        format!("{sign}INFINITY")
    } else if x == 0.0 {
        format!("{sign}0x0p+0{suffix}")
    } else {
        let (exponent, fraction) = parts(x);
        let digits = format!("{fraction:013x}");
        let digits = digits.trim_end_matches('0');
        let point = if digits.is_empty() { "" } else { "." };
        format!("{sign}0x1{point}{digits}p{exponent:+}{suffix}")
    }
}

/// |x| = (1 + fraction 2^-52) 2^exponent, for subnormal numbers, too.
fn parts(x: f64) -> (i32, u64) {
    const FRACTION: u64 = (1 << 52) - 1;
    let bits = x.abs().to_bits();
    let (biased, fraction) = ((bits >> 52) as i32, bits & FRACTION);
    if biased > 0 {
        return (biased - 1023, fraction);
    }
    let shift = fraction.leading_zeros() - 11;
    (-1022 - shift as i32, (fraction << shift) & FRACTION)
}

/// The shortest decimal constant of Rust that reads back.
pub(crate) fn decimal(x: f64, precision: Precision) -> String {
    if x.is_infinite() {
        return if x > 0.0 { "Real::INFINITY" } else { "Real::NEG_INFINITY" }.to_owned();
    }
    if x.is_nan() {
        return "Real::NAN".to_owned();
    }
    match precision {
        Precision::F64 => format!("{x:?}"),
        Precision::F32 => format!("{:?}", x as f32),
    }
}

/// The bits as a whole number of Rust.
pub(crate) fn bits(x: f64, precision: Precision) -> String {
    match precision {
        Precision::F64 => format!("{:#x}", x.to_bits()),
        Precision::F32 => format!("{:#x}", (x as f32).to_bits()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the definition of C99 6.4.4.2, in exact steps: a whole number of at most 53 bits times a power of two.
    fn read(text: &str) -> f64 {
        let (mantissa, exponent) = text.trim_start_matches("-0x").trim_start_matches("0x").split_once('p').unwrap();
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let digits = u64::from_str_radix(&format!("{whole}{fraction}"), 16).unwrap();
        let power: i32 = exponent.parse::<i32>().unwrap() - 4 * fraction.len() as i32;
        let half = power / 2;
        let size = digits as f64 * 2f64.powi(half) * 2f64.powi(power - half);
        if text.starts_with('-') { -size } else { size }
    }

    #[test]
    fn hexadecimal_constants_read_back() {
        let mut bits = 1_u64;
        let mut drawn: Vec<f64> = vec![0.0, -0.0, 1.0, -0.1, f64::MAX, f64::MIN_POSITIVE, 5e-324, 3e-310];
        drawn.extend((0..2000).map(|_| {
            bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            f64::from_bits(bits)
        }));
        for x in drawn.into_iter().filter(|x| x.is_finite()) {
            assert_eq!(read(&hexadecimal(x, Precision::F64)).to_bits(), x.to_bits(), "{x:e}");
            assert_eq!(decimal(x, Precision::F64).parse::<f64>().unwrap().to_bits(), x.to_bits());
        }
        assert_eq!(hexadecimal(0.15625, Precision::F32), "0x1.4p-3f");
        assert_eq!(hexadecimal(f64::NEG_INFINITY, Precision::F64), "-INFINITY");
        assert_eq!(hexadecimal(-f64::NAN, Precision::F64), "NAN");
    }

    #[test]
    fn the_subnormal_numbers_are_subnormal() {
        assert!(Precision::F64.subnormal().is_subnormal());
        let single = Precision::F32.subnormal() as f32;
        assert!(single.is_subnormal() && f64::from(single) == Precision::F32.subnormal());
    }
}
