//! Samples as integers of 52 bits.
//!
//! Enters: a sample and the power of two above the largest. Leaves: q with sample = (q - 2^51) 2^(exponent - 51) to half a unit, 0 <= q < 2^52.

use crate::double::power_of_two;

/// Bits right of the binary point of the largest sample.
pub(crate) const FRACTION: i32 = 51;
/// What is added to a signed integer to make it unsigned.
pub(crate) const BIAS: u64 = 1 << FRACTION;
/// Below this exponent a channel is rounded to multiples of 2^-951, which no recording resolves: the powers of two stay normal numbers.
pub(crate) const LEAST_EXPONENT: i32 = -900;

/// 2^52 + 2^51: an f64 next to it has units of one, so that adding it rounds to nearest and leaves the biased integer in the last 52 bits.
const MAGIC: f64 = 6_755_399_441_055_744.0;
/// The largest signed integer, and its mask.
const LARGEST: f64 = (BIAS - 1) as f64;
const MASK: u64 = (1 << 52) - 1;

/// The least exponent with |x| < 2^exponent for all |x| <= `largest`.
pub(crate) fn exponent(largest: f64) -> i32 {
    debug_assert!(largest.is_finite());
    let biased = (largest.abs().to_bits() >> 52) as i32;
    (biased - 1022).max(LEAST_EXPONENT)
}

/// Assumes: |x| < 2^exponent.
pub(crate) fn quantised(samples: &[f64], exponent: i32, integers: &mut [u64]) {
    let up = power_of_two(FRACTION - exponent);
    for (x, q) in samples.iter().zip(integers) {
        let scaled = x * up;
        let clamped = if scaled < LARGEST { scaled } else { LARGEST };
        *q = (clamped + MAGIC).to_bits() & MASK;
    }
}

/// The sample that an integer stands for, in units of 2^exponent.
pub(crate) fn fraction(q: u64) -> f64 {
    (q as i64 - BIAS as i64) as f64 * power_of_two(-FRACTION)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rounded(x: f64, e: i32) -> f64 {
        let mut q = [0];
        quantised(&[x], e, &mut q);
        assert!(q[0] < 1 << 52);
        fraction(q[0]) * power_of_two(e)
    }

    #[test]
    fn samples_are_rounded_to_half_a_unit_of_the_largest() {
        let samples = crate::excitation::white_gaussian(1000, 1.0, 9.0, 3);
        let e = exponent(samples.iter().fold(0.0, |a, x| a.max(x.abs())));
        for x in samples {
            assert!((rounded(x, e) - x).abs() <= power_of_two(e - FRACTION - 1));
        }
    }

    #[test]
    fn powers_of_two_and_their_neighbours() {
        for (x, e) in [(1.0, 1), (0.999, 0), (0.0, LEAST_EXPONENT), (1e300, 997), (1e-300, LEAST_EXPONENT), (2.0, 2)] {
            assert_eq!(exponent(x), e, "{x}");
            assert_eq!(exponent(-x), e, "{x}");
        }
        let below = 1.0f64.next_down();
        assert_eq!(exponent(below), 0);
        // The one value that does not fit is rounded down instead of over the edge.
        assert_eq!(rounded(below, 0), 1.0 - power_of_two(-FRACTION));
        assert_eq!(rounded(-below, 0), -1.0);
        assert_eq!(exponent(f64::MAX), 1024);
        assert!((rounded(8e307, 1023) - 8e307).abs() < 1e293);
    }
}
