//! The order from the singular values, Step 3 of the paper.
//!
//! Enters: singular values of the MOESP-weighted projection. Leaves: a number of states.
//! Deliberately absent: the models themselves; the person who looks at the plot may know better.

/// A singular value below this part of the largest is rounding, not a state: noise-free data leave about 1e-15.
const ROUNDING: f64 = 1e-12;
/// A drop by this factor has no noise behind it: data without noise fall from their last state to rounding. The cleanest real
/// recording at hand drops by 95.
const NOISE_FREE_DROP: f64 = 1e4;
/// Margin over the threshold for white noise of one variance: block Hankel rows share their samples, real noise is coloured, and
/// each output has its own.
const MARGIN: f64 = 2.0;

/// Largest order that the singular values carry: how many stand above rounding.
pub(crate) fn rank(singular_values: &[f64]) -> usize {
    let floor = singular_values.first().copied().unwrap_or(0.0) * ROUNDING;
    singular_values.iter().filter(|&&x| x > floor && x.is_finite()).count()
}

/// Automatic order.
///
/// 1. If the singular values drop by 10^4 or more somewhere, to rounding say, the order is the place of the largest drop.
/// 2. Else it is the number of singular values above 2 omega(aspect) times their median: noise alone stays below omega times
///    the median, and states are the exceptions. So at most half of the singular values are states.
///
/// `aspect`: rows over columns of the weighted projection, at most 1.
/// Source: Gavish and Donoho 2014, eq. 11 (unknown noise level) with its cubic for omega; the margin is ours.
pub(crate) fn automatic(singular_values: &[f64], aspect: f64) -> usize {
    if let Some(n) = drop_to_rounding(singular_values) {
        return n;
    }
    let omega = ((0.56 * aspect - 0.95) * aspect + 1.82) * aspect + 1.43;
    let median = singular_values[singular_values.len() / 2];
    let threshold = MARGIN * omega * median;
    singular_values.iter().filter(|&&x| x > threshold).count().max(1)
}

/// Whether a drop shows that there is no noise.
pub(crate) fn noise_free(singular_values: &[f64]) -> bool {
    drop_to_rounding(singular_values).is_some()
}

/// Place of the largest drop, when it is 10^4 or more.
fn drop_to_rounding(singular_values: &[f64]) -> Option<usize> {
    let floor = singular_values.first()? * ROUNDING;
    let drop = |n: usize| singular_values[n - 1].max(floor) / singular_values[n].max(floor);
    let last = rank(singular_values).min(singular_values.len() - 1);
    let largest = (1..=last).max_by(|&a, &b| drop(a).total_cmp(&drop(b)));
    largest.filter(|&n| drop(n) >= NOISE_FREE_DROP)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_free_data_end_at_the_drop_to_rounding() {
        let s = [800.0, 503.0, 85.0, 11.7, 1.35e-13, 1.3e-13, 1e-14, 0.0];
        assert_eq!((rank(&s), automatic(&s, 2.0 / 3.0)), (4, 4));
    }

    /// More states than half of the singular values: the drop still shows.
    #[test]
    fn few_block_rows_without_noise() {
        assert_eq!(automatic(&[10.0, 3.0, 0.1, 1e-3, 1e-16], 0.5), 4);
    }

    #[test]
    fn states_stand_above_a_floor_of_noise() {
        let noise = (0..36).map(|k| 0.234 - 0.0055 * f64::from(k));
        let s: Vec<f64> = [800.0, 503.0, 85.0, 11.7].into_iter().chain(noise).collect();
        assert_eq!(automatic(&s, 2.0 / 3.0), 4);
    }

    #[test]
    fn one_singular_value_is_one_state() {
        assert_eq!(automatic(&[2.0], 0.5), 1);
    }
}
