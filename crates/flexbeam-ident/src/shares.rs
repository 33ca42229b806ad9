//! Work shared among threads, its results in the order of the work.

/// `part` of each thread's share of a range, in the range's order.
pub(crate) fn shared<T: Send>(
    range: std::ops::Range<usize>,
    threads: usize,
    part: impl Fn(std::ops::Range<usize>) -> T + Sync,
) -> Vec<T> {
    let shares = threads.min(range.len()).max(1);
    let share = |k: usize| range.start + range.len() * k / shares..range.start + range.len() * (k + 1) / shares;
    if shares == 1 {
        return vec![part(range)];
    }
    let part = &part;
    std::thread::scope(|scope| {
        let others: Vec<_> = (1..shares).map(|k| scope.spawn(move || part(share(k)))).collect();
        let first = part(share(0));
        let join = |other: std::thread::ScopedJoinHandle<T>| other.join().expect("a share does not panic");
        std::iter::once(first).chain(others.into_iter().map(join)).collect()
    })
}

/// `one` of each number of a range, in the range's order.
pub(crate) fn each<T: Send>(range: std::ops::Range<usize>, threads: usize, one: impl Fn(usize) -> T + Sync) -> Vec<T> {
    shared(range, threads, |range| range.map(&one).collect::<Vec<_>>()).into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_has_its_turn_in_order() {
        for (count, threads) in [(0, 2), (1, 3), (7, 1), (7, 3), (7, 20)] {
            assert_eq!(each(0..count, threads, |k| k * k), (0..count).map(|k| k * k).collect::<Vec<_>>());
        }
    }
}
