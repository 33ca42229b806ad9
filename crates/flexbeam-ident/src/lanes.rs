//! Eight f64 side by side, on whatever the processor has.
//!
//! Enters: a kernel written for eight lanes. Leaves: its result, computed by the widest vectors there are. A kernel gives the same bits on all processors with a
//! fused multiply-add, because lanes are eight everywhere; without one each product is rounded once more. Deliberately absent: shuffles, masks.

/// Lanes of all implementations.
pub(crate) const LANES: usize = 8;

/// Eight numbers.
pub(crate) trait Lanes: Copy {
    /// Sums of two rows that the registers hold beside what they are made of: 3 or 4.
    const TILE: usize;

    fn splat(x: f64) -> Self;
    /// The first eight of a slice, which has them.
    fn load(from: &[f64]) -> Self;
    /// Into the first eight of a slice, which has them.
    fn store(self, to: &mut [f64]);
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    /// self other + sum, rounded once where the processor can.
    fn times_plus(self, other: Self, sum: Self) -> Self;
    /// |self|, where it is above `other`, else `other`; NaN counts as below.
    fn largest_magnitude(self, other: Self) -> Self;

    #[inline(always)]
    fn to_array(self) -> [f64; LANES] {
        let mut array = [0.0; LANES];
        self.store(&mut array);
        array
    }

    /// Sum of the lanes, from the first to the last.
    #[inline(always)]
    fn total(self) -> f64 {
        let mut sum = 0.0;
        for x in self.to_array() {
            sum += x;
        }
        sum
    }
}

/// A computation that is written once for all kinds of lanes. `run` must be `#[inline(always)]`, else it is compiled without the processor's features.
pub(crate) trait Kernel {
    type Output;
    fn run<L: Lanes>(self) -> Self::Output;
}

/// Runs a kernel with the widest lanes of this processor.
pub(crate) fn on_widest<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx512f") {
        // SAFETY: the feature was found on this processor in the line above.
        return unsafe { x86::on_avx512(kernel) };
    } else if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        // SAFETY: the two features were found on this processor in the line above.
        return unsafe { x86::on_avx2(kernel) };
    }
    kernel.run::<Plain>()
}

/// Whether this processor multiplies and adds in one, without which f64 kernels are slow and round otherwise.
pub(crate) fn fused() -> bool {
    #[cfg(target_arch = "x86_64")]
    return is_x86_feature_detected!("avx512f")
        || (is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"));
    #[cfg(not(target_arch = "x86_64"))]
    cfg!(target_arch = "aarch64")
}

/// What every processor has.
#[derive(Clone, Copy)]
pub(crate) struct Plain([f64; LANES]);

impl Plain {
    #[inline(always)]
    fn zip(self, other: Plain, f: impl Fn(f64, f64) -> f64) -> Plain {
        let mut lanes = [0.0; LANES];
        for (lane, (a, b)) in lanes.iter_mut().zip(self.0.into_iter().zip(other.0)) {
            *lane = f(a, b);
        }
        Plain(lanes)
    }
}

impl Lanes for Plain {
    const TILE: usize = 3;
    #[inline(always)]
    fn splat(x: f64) -> Plain {
        Plain([x; LANES])
    }
    #[inline(always)]
    fn load(from: &[f64]) -> Plain {
        Plain(*from.first_chunk().expect("eight numbers"))
    }
    #[inline(always)]
    fn store(self, to: &mut [f64]) {
        to[..LANES].copy_from_slice(&self.0);
    }
    #[inline(always)]
    fn plus(self, other: Plain) -> Plain {
        self.zip(other, |a, b| a + b)
    }
    #[inline(always)]
    fn minus(self, other: Plain) -> Plain {
        self.zip(other, |a, b| a - b)
    }
    #[inline(always)]
    fn times(self, other: Plain) -> Plain {
        self.zip(other, |a, b| a * b)
    }
    #[inline(always)]
    fn times_plus(self, other: Plain, sum: Plain) -> Plain {
        if cfg!(target_arch = "aarch64") {
            let mut lanes = sum.0;
            for (lane, (a, b)) in lanes.iter_mut().zip(self.0.into_iter().zip(other.0)) {
                *lane = a.mul_add(b, *lane);
            }
            Plain(lanes)
        } else {
            self.times(other).plus(sum)
        }
    }
    #[inline(always)]
    fn largest_magnitude(self, other: Plain) -> Plain {
        self.zip(other, |a, b| if a.abs() > b { a.abs() } else { b })
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::*;

    use super::{Kernel, LANES, Lanes};

    #[target_feature(enable = "avx512f")]
    pub(super) fn on_avx512<K: Kernel>(kernel: K) -> K::Output {
        kernel.run::<Wide>()
    }

    #[target_feature(enable = "avx2,fma")]
    pub(super) fn on_avx2<K: Kernel>(kernel: K) -> K::Output {
        kernel.run::<Pair>()
    }

    /// One register of AVX-512. Nothing outside [`on_avx512`] can name it.
    #[derive(Clone, Copy)]
    pub(super) struct Wide(__m512d);

    /// Two registers of AVX2. Nothing outside [`on_avx2`] can name it.
    #[derive(Clone, Copy)]
    pub(super) struct Pair(__m256d, __m256d);

    // SAFETY of every block below: `Wide` exists only within `on_avx512`, which runs only where AVX-512F was found; loads and stores go through slices
    // whose length is checked, and need no alignment.
    impl Lanes for Wide {
        const TILE: usize = 4;
        #[inline(always)]
        fn splat(x: f64) -> Wide {
            // SAFETY: see above.
            Wide(unsafe { _mm512_set1_pd(x) })
        }
        #[inline(always)]
        fn load(from: &[f64]) -> Wide {
            assert!(from.len() >= LANES);
            // SAFETY: see above.
            Wide(unsafe { _mm512_loadu_pd(from.as_ptr()) })
        }
        #[inline(always)]
        fn store(self, to: &mut [f64]) {
            assert!(to.len() >= LANES);
            // SAFETY: see above.
            unsafe { _mm512_storeu_pd(to.as_mut_ptr(), self.0) }
        }
        #[inline(always)]
        fn plus(self, other: Wide) -> Wide {
            // SAFETY: see above.
            Wide(unsafe { _mm512_add_pd(self.0, other.0) })
        }
        #[inline(always)]
        fn minus(self, other: Wide) -> Wide {
            // SAFETY: see above.
            Wide(unsafe { _mm512_sub_pd(self.0, other.0) })
        }
        #[inline(always)]
        fn times(self, other: Wide) -> Wide {
            // SAFETY: see above.
            Wide(unsafe { _mm512_mul_pd(self.0, other.0) })
        }
        #[inline(always)]
        fn times_plus(self, other: Wide, sum: Wide) -> Wide {
            // SAFETY: see above.
            Wide(unsafe { _mm512_fmadd_pd(self.0, other.0, sum.0) })
        }
        #[inline(always)]
        fn largest_magnitude(self, other: Wide) -> Wide {
            // SAFETY: see above. The maximum of the instruction is its second operand where one is NaN.
            Wide(unsafe { _mm512_max_pd(_mm512_abs_pd(self.0), other.0) })
        }
    }

    // SAFETY of every block below: `Pair` exists only within `on_avx2`, which runs only where AVX2 and FMA were found; loads and stores go through slices
    // whose length is checked, and need no alignment.
    impl Lanes for Pair {
        const TILE: usize = 3;
        #[inline(always)]
        fn splat(x: f64) -> Pair {
            // SAFETY: see above.
            let half = unsafe { _mm256_set1_pd(x) };
            Pair(half, half)
        }
        #[inline(always)]
        fn load(from: &[f64]) -> Pair {
            assert!(from.len() >= LANES);
            // SAFETY: see above.
            unsafe { Pair(_mm256_loadu_pd(from.as_ptr()), _mm256_loadu_pd(from.as_ptr().add(4))) }
        }
        #[inline(always)]
        fn store(self, to: &mut [f64]) {
            assert!(to.len() >= LANES);
            // SAFETY: see above.
            unsafe {
                _mm256_storeu_pd(to.as_mut_ptr(), self.0);
                _mm256_storeu_pd(to.as_mut_ptr().add(4), self.1);
            }
        }
        #[inline(always)]
        fn plus(self, other: Pair) -> Pair {
            // SAFETY: see above.
            unsafe { Pair(_mm256_add_pd(self.0, other.0), _mm256_add_pd(self.1, other.1)) }
        }
        #[inline(always)]
        fn minus(self, other: Pair) -> Pair {
            // SAFETY: see above.
            unsafe { Pair(_mm256_sub_pd(self.0, other.0), _mm256_sub_pd(self.1, other.1)) }
        }
        #[inline(always)]
        fn times(self, other: Pair) -> Pair {
            // SAFETY: see above.
            unsafe { Pair(_mm256_mul_pd(self.0, other.0), _mm256_mul_pd(self.1, other.1)) }
        }
        #[inline(always)]
        fn times_plus(self, other: Pair, sum: Pair) -> Pair {
            // SAFETY: see above.
            unsafe { Pair(_mm256_fmadd_pd(self.0, other.0, sum.0), _mm256_fmadd_pd(self.1, other.1, sum.1)) }
        }
        #[inline(always)]
        fn largest_magnitude(self, other: Pair) -> Pair {
            // SAFETY: see above. The maximum of the instruction is its second operand where one is NaN.
            unsafe {
                let sign = _mm256_set1_pd(-0.0);
                let most = |a, b| _mm256_max_pd(_mm256_andnot_pd(sign, a), b);
                Pair(most(self.0, other.0), most(self.1, other.1))
            }
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Runs a kernel on every kind of lanes that this processor has.
    pub(crate) fn on_each<K: Kernel + Clone>(kernel: K) -> Vec<(&'static str, K::Output)> {
        let mut found = vec![("plain", kernel.clone().run::<Plain>())];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                // SAFETY: the two features were found on this processor in the line above.
                found.push(("avx2", unsafe { x86::on_avx2(kernel.clone()) }));
            }
            if is_x86_feature_detected!("avx512f") {
                // SAFETY: the feature was found on this processor in the line above.
                found.push(("avx512", unsafe { x86::on_avx512(kernel) }));
            }
        }
        found
    }

    #[derive(Clone)]
    struct All;

    impl Kernel for All {
        type Output = Vec<f64>;
        #[inline(always)]
        fn run<L: Lanes>(self) -> Vec<f64> {
            let a = L::load(&[1.5, -2.0, 3.0, f64::NAN, 5.0, -6.0, 7.0, -0.0]);
            let b = L::load(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
            let c = L::splat(2.0);
            let results = [a.plus(b), a.minus(b), a.times(b), a.times_plus(b, c), a.largest_magnitude(c), b];
            let mut all: Vec<f64> = results.iter().flat_map(|x| x.to_array()).collect();
            all.push(b.total());
            all
        }
    }

    #[test]
    fn every_kind_of_lanes_does_the_same() {
        let all = on_each(All);
        let bits = |x: &[f64]| x.iter().map(|x| if x.is_nan() { 0 } else { x.to_bits() }).collect::<Vec<_>>();
        for (name, found) in &all {
            assert_eq!(bits(found), bits(&all[0].1), "{name}");
        }
        let plain = &all[0].1;
        assert_eq!(plain[0..2], [2.5, 0.0]);
        assert_eq!(plain[24..27], [3.5, -2.0, 11.0]);
        assert_eq!(plain[32..36], [2.0, 2.0, 3.0, 2.0]);
        assert_eq!(plain.last(), Some(&36.0));
    }
}
