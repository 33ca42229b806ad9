//! The order from the singular values, Step 3 of the paper.

/// A singular value below this part of the largest is rounding, not a state: noise-free data leave about 1e-15.
const ROUNDING: f64 = 1e-12;

/// Largest order that the singular values carry: how many stand above rounding.
pub(crate) fn rank(singular_values: &[f64]) -> usize {
    let floor = singular_values.first().copied().unwrap_or(0.0) * ROUNDING;
    singular_values.iter().filter(|&&x| x > floor && x.is_finite()).count()
}

/// Automatic order: the place of the largest drop s_n / s_{n+1} among n <= (number of singular values) / 2.
pub(crate) fn automatic(singular_values: &[f64]) -> usize {
    let floor = singular_values[0] * ROUNDING;
    let drop = |n: usize| singular_values[n - 1].max(floor) / singular_values[n].max(floor);
    (1..=singular_values.len() / 2).max_by(|&a, &b| drop(a).total_cmp(&drop(b)).then(b.cmp(&a))).unwrap_or(1)
}
