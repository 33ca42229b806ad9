//! Double-double numbers: the unevaluated sum of two f64, some 32 decimal digits.
//!
//! Enters: f64 and integers. Leaves: sums, products, quotients and roots of twice the precision.
//! Deliberately absent: transcendental functions, infinities.

use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// hi + lo with |lo| at most half a unit in the last place of hi.
///
/// Numerics: sums are within 2^-105 of |a| + |b|, products within 2^-102 of |a b|, relative. No operation needs a fused multiply-add:
/// the same bits on every processor. Assumes magnitudes between 1e-140 and 1e140, where no product of halves under- or overflows.
/// Source: Dekker 1971; Joldes, Muller and Popescu 2017 for the bounds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Double {
    pub hi: f64,
    pub lo: f64,
}

impl Double {
    pub const ZERO: Double = Double { hi: 0.0, lo: 0.0 };

    pub fn new(x: f64) -> Double {
        Double { hi: x, lo: 0.0 }
    }

    /// a b without error, up to underflow.
    pub fn product(a: f64, b: f64) -> Double {
        let (hi, lo) = two_product::<false>(a, b);
        Double { hi, lo }
    }

    /// The nearest, within 2^-106 of its magnitude.
    pub fn from_integer(x: i128) -> Double {
        let hi = x as f64;
        let (hi, lo) = quick_two_sum(hi, (x - hi as i128) as f64);
        Double { hi, lo }
    }

    /// x 2^power, exact while nothing underflows.
    pub fn shifted(self, power: i32) -> Double {
        let half = power / 2;
        let (a, b) = (power_of_two(half), power_of_two(power - half));
        Double { hi: self.hi * a * b, lo: self.lo * a * b }
    }

    /// x by a power of two, exact while nothing underflows.
    pub fn scaled(self, by: f64) -> Double {
        Double { hi: self.hi * by, lo: self.lo * by }
    }

    pub fn value(self) -> f64 {
        self.hi + self.lo
    }

    /// One Newton step from the f64 root: within 2^-100, relative. Zero for what is not positive.
    pub fn sqrt(self) -> Double {
        if !(self.hi > 0.0) {
            return Double::ZERO;
        }
        let root = self.hi.sqrt();
        let rest = self - Double::product(root, root);
        let (hi, lo) = quick_two_sum(root, rest.hi / (2.0 * root));
        Double { hi, lo }
    }

    /// 1 / x by one Newton step: within 2^-100, relative.
    pub fn reciprocal(self) -> Double {
        let first = 1.0 / self.hi;
        let rest = Double::new(1.0) - self * Double::new(first);
        let (hi, lo) = quick_two_sum(first, rest.hi * first);
        Double { hi, lo }
    }
}

impl Add for Double {
    type Output = Double;
    fn add(self, other: Double) -> Double {
        let (hi, lo) = sum((self.hi, self.lo), (other.hi, other.lo));
        Double { hi, lo }
    }
}

impl Neg for Double {
    type Output = Double;
    fn neg(self) -> Double {
        Double { hi: -self.hi, lo: -self.lo }
    }
}

impl Sub for Double {
    type Output = Double;
    fn sub(self, other: Double) -> Double {
        self + -other
    }
}

impl Mul for Double {
    type Output = Double;
    fn mul(self, other: Double) -> Double {
        let (hi, lo) = product::<false>((self.hi, self.lo), (other.hi, other.lo));
        Double { hi, lo }
    }
}

impl AddAssign for Double {
    fn add_assign(&mut self, other: Double) {
        *self = *self + other;
    }
}

impl SubAssign for Double {
    fn sub_assign(&mut self, other: Double) {
        *self = *self - other;
    }
}

/// 2^power for -1022 <= power <= 1023.
pub(crate) fn power_of_two(power: i32) -> f64 {
    debug_assert!((-1022..=1023).contains(&power));
    f64::from_bits(((power + 1023) as u64) << 52)
}

/// s + e = a + b without error, s = fl(a + b).
#[inline(always)]
pub(crate) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    let t = s - a;
    (s, (a - (s - t)) + (b - t))
}

/// As [`two_sum`] for |a| >= |b| or a = 0.
#[inline(always)]
fn quick_two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    (s, b - (s - a))
}

/// p + e = a b without error, p = fl(a b). Fused or by Dekker's halves: the same bits.
#[inline(always)]
pub(crate) fn two_product<const FUSED: bool>(a: f64, b: f64) -> (f64, f64) {
    let p = a * b;
    if FUSED {
        return (p, a.mul_add(b, -p));
    }
    let ((ah, al), (bh, bl)) = (halves(a), halves(b));
    (p, ((ah * bh - p) + ah * bl + al * bh) + al * bl)
}

/// 26 and 27 bits of x (Veltkamp).
#[inline(always)]
fn halves(x: f64) -> (f64, f64) {
    let c = 134_217_729.0 * x;
    let h = c - (c - x);
    (h, x - h)
}

/// Sum of two double-doubles.
#[inline(always)]
pub(crate) fn sum(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    let (s, e) = two_sum(a.0, b.0);
    let (t, f) = two_sum(a.1, b.1);
    let (s, e) = quick_two_sum(s, e + t);
    quick_two_sum(s, e + f)
}

/// Product of two double-doubles; the same bits fused or not.
#[inline(always)]
pub(crate) fn product<const FUSED: bool>(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    let (p, e) = two_product::<FUSED>(a.0, b.0);
    quick_two_sum(p, e + (a.0 * b.1 + a.1 * b.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::white_gaussian;

    /// Integers of 100 bits, in which every sum and product of halves is known exactly.
    #[test]
    fn sums_and_products_keep_the_promised_digits() {
        let draws = white_gaussian(400, 1.0, 9.0, 4);
        let integer = |k: usize| (draws[k] * 2f64.powi(45)) as i128 * ((draws[k + 1] * 2f64.powi(14)) as i128) + 1;
        for k in (0..396).step_by(4) {
            let (a, b) = (integer(k), integer(k + 2));
            let (x, y) = (Double::from_integer(a), Double::from_integer(b));
            assert_eq!(x.hi as i128 + x.lo as i128, a);
            let missed = (x + y) - Double::from_integer(a + b);
            assert!(missed.value().abs() <= 2f64.powi(-104) * (a.abs() + b.abs()) as f64);
            let product = Double::from_integer(a * b);
            assert!((x * y - product).value().abs() <= 2f64.powi(-101) * product.hi.abs());
            let back = x.reciprocal() * x - Double::new(1.0);
            assert!(back.value().abs() < 2f64.powi(-98), "{back:?}");
            let square = x * x;
            let root = square.sqrt() * square.sqrt() - square;
            assert!(root.value().abs() < 2f64.powi(-98) * square.hi);
        }
    }

    #[test]
    fn halves_and_fused_products_have_the_same_bits() {
        let draws = white_gaussian(1000, 1.0, 9.0, 5);
        for pair in draws.windows(2) {
            assert_eq!(two_product::<true>(pair[0], pair[1]), two_product::<false>(pair[0], pair[1]));
        }
    }

    #[test]
    fn shifts_are_exact() {
        let x = Double { hi: 1.5, lo: 2f64.powi(-60) };
        assert_eq!(x.shifted(200).shifted(-200), x);
    }
}
