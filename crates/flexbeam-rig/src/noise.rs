//! White Gaussian noise that a seed decides to the last bit, on every machine.

use crate::elementary::{exp, ln};
use crate::ziggurat::{F, R, X};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Standard normal numbers, drawn from ChaCha8 by the ziggurat.
///
/// Numerics: the numbers of `rand_distr::StandardNormal`, but for the last place of those in the tail (|x| > 3.65, one in
/// 3900), which its logarithm leaves to the system's library.
/// Source: Doornik 2005 (ZIGNOR).
#[derive(Clone, Debug)]
pub struct Noise(ChaCha8Rng);

impl Noise {
    /// The sequence of this seed, from its beginning.
    pub fn new(seed: u64) -> Noise {
        Noise(ChaCha8Rng::seed_from_u64(seed))
    }

    /// The next number.
    pub fn draw(&mut self) -> f64 {
        loop {
            let bits = self.0.next_u64();
            let i = (bits & 0xff) as usize;
            let u = between(bits, 0x400) - 3.0;
            let x = u * X[i];
            if x.abs() < X[i + 1] {
                return x;
            }
            if i == 0 {
                return self.tail(u);
            }
            if F[i + 1] + (F[i] - F[i + 1]) * self.part() < exp(-x * x / 2.0) {
                return x;
            }
        }
    }

    /// Marsaglia's tail beyond R.
    fn tail(&mut self, u: f64) -> f64 {
        loop {
            let x = ln(self.open_part()) / R;
            let y = ln(self.open_part());
            if !(-2.0 * y < x * x) {
                return if u < 0.0 { x - R } else { R - x };
            }
        }
    }

    /// In [0, 1), by 53 bits.
    fn part(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (0.5 * f64::EPSILON)
    }

    /// In (0, 1), by 52 bits.
    fn open_part(&mut self) -> f64 {
        between(self.0.next_u64(), 0x3ff) - (1.0 - f64::EPSILON / 2.0)
    }
}

/// The upper 52 bits behind the point of a number with this exponent.
fn between(bits: u64, biased_exponent: u64) -> f64 {
    f64::from_bits(biased_exponent << 52 | bits >> 12)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rand_distr::StandardNormal;

    #[test]
    fn the_crate_s_numbers_but_for_the_tail_s_last_place() {
        for seed in [0, 1, 2009, u64::MAX] {
            let (mut own, mut others) = (Noise::new(seed), ChaCha8Rng::seed_from_u64(seed));
            let mut in_the_tail = 0;
            for k in 0..300_000 {
                let (x, other): (f64, f64) = (own.draw(), others.sample(StandardNormal));
                if x.abs() > R {
                    in_the_tail += 1;
                    assert!((x - other).abs() <= 1e-15 * other.abs(), "{seed} {k}: {x:e}, {other:e}");
                } else {
                    assert_eq!(x.to_bits(), other.to_bits(), "{seed} {k}: {x:e}, {other:e}");
                }
            }
            // 2.58e-4 of them: 77 +- 9.
            assert!((40..120).contains(&in_the_tail), "{in_the_tail}");
        }
    }
}
