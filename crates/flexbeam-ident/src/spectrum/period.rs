//! After how many samples a record repeats itself, to the bit.

/// Smallest p with x(t + p) = x(t) for all t, where the record holds at least two whole periods.
///
/// A commanded voltage that repeats does so exactly; a measured one does not, and then somebody must say the period.
/// Returns nothing for a record that does not repeat, or is constant.
/// Numerics: the prefix function of Knuth, Morris and Pratt; O(N).
pub fn repeats_after(x: &[f64]) -> Option<usize> {
    if x.iter().all(|v| *v == x[0]) {
        return None;
    }
    let mut border = vec![0usize; x.len()];
    for t in 1..x.len() {
        let mut length = border[t - 1];
        while length > 0 && x[t] != x[length] {
            length = border[length - 1];
        }
        border[t] = length + usize::from(x[t] == x[length]);
    }
    let period = x.len() - border[x.len() - 1];
    (2 * period <= x.len()).then_some(period)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_repeats_after_its_period_or_never() {
        let one = [1.0, 2.0, 1.0, 2.0, 3.0];
        assert_eq!(repeats_after(&one.repeat(4)), Some(5));
        let mut cut = one.repeat(4);
        cut.truncate(17);
        assert_eq!(repeats_after(&cut), Some(5), "the last period may be cut off");
        assert_eq!(repeats_after(&one), None);
        assert_eq!(repeats_after(&[2.0; 9]), None);
        assert_eq!(repeats_after(&[]), None);
        let mut jump = one.repeat(4);
        jump[12] += 1e-15;
        assert_eq!(repeats_after(&jump), None);
    }
}
