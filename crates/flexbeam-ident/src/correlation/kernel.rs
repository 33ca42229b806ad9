//! Lagged products of integers of 52 bits, without any rounding.
//!
//! Enters: biased integers. Leaves: sums of products over a stretch, as integers. Because integer sums have no order, every
//! processor and every number of threads gives the same bits. Deliberately absent: signs, scales, floating point.

/// Left samples of one call: 2^10 products below 2^104 stay within 128 bits, and 2^7 a lane within 64.
pub(crate) const PIECE: usize = 1024;
/// Lanes of the widest vector unit; stretches are padded with zeros to a multiple of it.
pub(crate) const LANES: usize = 8;
/// Lags that one pass over the samples serves.
const TILE: usize = 4;

/// found\[a\]\[d\] = sum over k of left\[a\]\[k\] right\[k + d\] for d below `lags`.
///
/// Shapes: each left channel K samples, K a multiple of 8 and at most 1024; right K + lags - 1 samples or more; `found` has `lags` entries a left channel,
/// one channel after the other.
/// Assumes: all integers are below 2^52.
pub(crate) fn lagged_products(left: &[&[u64]], right: &[u64], lags: usize, found: &mut [u128]) {
    check(left, right, lags, found.len());
    #[cfg(target_arch = "x86_64")]
    if wide() {
        // SAFETY: `wide` found the features on this processor; `check` has seen that every load stays inside its slice.
        unsafe { x86::all_lags(left, right, lags, found) };
        return;
    }
    plain(left, right, lags, found);
}

/// Whether this processor multiplies 52-bit integers eight at a time.
pub(crate) fn wide() -> bool {
    #[cfg(target_arch = "x86_64")]
    return is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512ifma");
    #[cfg(not(target_arch = "x86_64"))]
    false
}

fn check(left: &[&[u64]], right: &[u64], lags: usize, found: usize) {
    let samples = left.first().map_or(0, |channel| channel.len());
    assert!(left.iter().all(|channel| channel.len() == samples), "left channels of one length");
    assert!(samples.is_multiple_of(LANES) && samples <= PIECE, "{samples} samples in a piece");
    assert!(lags > 0 && right.len() + 1 >= samples + lags, "the right channel reaches to the last lag");
    assert_eq!(found, left.len() * lags, "a sum for each left channel and lag");
}

/// 64 by 64 bits, one product at a time.
fn plain(left: &[&[u64]], right: &[u64], lags: usize, found: &mut [u128]) {
    for (channel, sums) in left.iter().zip(found.chunks_exact_mut(lags)) {
        for (d, sum) in sums.iter_mut().enumerate() {
            *sum = channel.iter().zip(&right[d..]).map(|(x, y)| u128::from(*x) * u128::from(*y)).sum();
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::{
        __m512i, _mm512_loadu_si512, _mm512_madd52hi_epu64, _mm512_madd52lo_epu64, _mm512_setzero_si512,
        _mm512_storeu_si512,
    };

    use super::{LANES, TILE};

    #[target_feature(enable = "avx512f,avx512ifma")]
    pub(super) fn all_lags(left: &[&[u64]], right: &[u64], lags: usize, found: &mut [u128]) {
        for (pair, sums) in left.chunks(2).zip(found.chunks_mut(2 * lags)) {
            let mut d = 0;
            while d < lags {
                let wide = if lags - d >= TILE { TILE } else { 1 };
                match (pair, wide) {
                    ([a, b], TILE) => store(tile::<2, TILE>([a, b], &right[d..]), lags, d, sums),
                    ([a, b], _) => store(tile::<2, 1>([a, b], &right[d..]), lags, d, sums),
                    ([a], TILE) => store(tile::<1, TILE>([a], &right[d..]), lags, d, sums),
                    ([a], _) => store(tile::<1, 1>([a], &right[d..]), lags, d, sums),
                    _ => unreachable!("chunks of two"),
                }
                d += wide;
            }
        }
    }

    #[inline(always)]
    fn store<const A: usize, const D: usize>(tile: [[u128; D]; A], lags: usize, d: usize, sums: &mut [u128]) {
        for (a, found) in tile.iter().enumerate() {
            sums[a * lags + d..a * lags + d + D].copy_from_slice(found);
        }
    }

    /// D lags of A left channels: low and high halves of the products are summed apart.
    #[target_feature(enable = "avx512f,avx512ifma")]
    fn tile<const A: usize, const D: usize>(left: [&[u64]; A], right: &[u64]) -> [[u128; D]; A] {
        let zero = _mm512_setzero_si512();
        let (mut low, mut high) = ([[zero; D]; A], [[zero; D]; A]);
        for k in (0..left[0].len()).step_by(LANES) {
            let mut x = [zero; A];
            for a in 0..A {
                x[a] = load(left[a], k);
            }
            for d in 0..D {
                let y = load(right, k + d);
                for a in 0..A {
                    low[a][d] = _mm512_madd52lo_epu64(low[a][d], x[a], y);
                    high[a][d] = _mm512_madd52hi_epu64(high[a][d], x[a], y);
                }
            }
        }
        let mut found = [[0; D]; A];
        for a in 0..A {
            for d in 0..D {
                found[a][d] = total(low[a][d]) + (total(high[a][d]) << 52);
            }
        }
        found
    }

    #[inline]
    #[target_feature(enable = "avx512f")]
    fn load(channel: &[u64], k: usize) -> __m512i {
        debug_assert!(k + LANES <= channel.len());
        // SAFETY: `lagged_products` checked that K + lags - 1 samples are there, and k + LANES is at most K + lags - 1.
        unsafe { _mm512_loadu_si512(channel.as_ptr().add(k).cast()) }
    }

    #[inline]
    #[target_feature(enable = "avx512f")]
    fn total(lanes: __m512i) -> u128 {
        let mut each = [0u64; LANES];
        // SAFETY: eight lanes of eight bytes fill the array; the store needs no alignment.
        unsafe { _mm512_storeu_si512(each.as_mut_ptr().cast(), lanes) };
        each.iter().map(|x| u128::from(*x)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn integers(seed: u64, count: usize) -> Vec<u64> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            state >> 12
        };
        (0..count).map(|_| next()).collect()
    }

    /// Every remainder of channels and lags, on slices that end where the last load ends: a load beyond is the sanitizer's to find.
    #[test]
    fn both_kernels_have_the_same_bits() {
        for (channels, lags, samples) in [(1, 1, 8), (1, 4, 16), (2, 7, 64), (3, 40, 1024), (5, 2, 1024), (4, 9, 0)] {
            let left: Vec<Vec<u64>> = (0..channels).map(|c| integers(c as u64, samples)).collect();
            let left: Vec<&[u64]> = left.iter().map(Vec::as_slice).collect();
            let right = integers(77, samples + lags - 1).into_boxed_slice();
            let (mut found, mut wanted) = (vec![1; channels * lags], vec![2; channels * lags]);
            lagged_products(&left, &right, lags, &mut found);
            plain(&left, &right, lags, &mut wanted);
            assert_eq!(found, wanted, "{channels} channels, {lags} lags, {samples} samples");
        }
    }

    /// The largest integers there are, in the longest piece: no lane overflows.
    #[test]
    fn the_largest_integers_fit() {
        let largest = (1u64 << 52) - 1;
        let (left, right) = (vec![largest; PIECE], vec![largest; PIECE + 2]);
        let mut found = [0; 3];
        lagged_products(&[&left], &right, 3, &mut found);
        assert_eq!(found, [u128::from(largest) * u128::from(largest) * PIECE as u128; 3]);
    }

    #[test]
    #[should_panic(expected = "reaches to the last lag")]
    fn a_right_channel_that_is_too_short_is_our_own_bug() {
        lagged_products(&[&[1; 8]], &[1; 8], 2, &mut [0; 2]);
    }
}
