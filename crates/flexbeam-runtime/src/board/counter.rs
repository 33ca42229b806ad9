//! A counter that wraps, made one that does not.

/// Counts since the zero was taken, from readings modulo some width.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Counter {
    modulus: i64,
    last: i64,
    counts: i64,
}

impl Counter {
    /// Real-time: no. A counter that holds `greatest` at most and stands at `reading`, which becomes its zero.
    pub(crate) fn new(greatest: u32, reading: u32) -> Counter {
        Counter { modulus: i64::from(greatest) + 1, last: i64::from(reading), counts: 0 }
    }

    /// Real-time: yes. Counts since the zero, for a new reading.
    ///
    /// Assumes: fewer than half of the counter's range since the last reading. Bits above its width are ignored, so that a
    /// signed reading, and one of a wider counter, may be given as they come.
    pub(crate) fn counts(&mut self, reading: u32) -> i64 {
        let now = i64::from(reading);
        let forward = (now - self.last).rem_euclid(self.modulus);
        let step = if forward > self.modulus / 2 { forward - self.modulus } else { forward };
        self.last = now;
        self.counts = self.counts.wrapping_add(step);
        self.counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_signed_counter_of_32_bits_passes_both_of_its_ends() {
        let mut counter = Counter::new(u32::MAX, i32::MAX as u32);
        assert_eq!(counter.counts(i32::MIN as u32), 1);
        assert_eq!(counter.counts(i32::MAX as u32 - 1), -1);
        let mut counter = Counter::new(u32::MAX, 0);
        assert_eq!(counter.counts(-1_i32 as u32), -1);
        assert_eq!(counter.counts(2), 2);
    }

    proptest! {
        /// Whatever the width and wherever it starts, small steps add up; a wider counter read as a narrower one agrees.
        #[test]
        fn steps_add_up(start: u32, bits in 16_u32..=32, steps in proptest::collection::vec(-30_000_i64..30_000, 1..200)) {
            let greatest = (u64::from(u32::MAX) >> (32 - bits)) as u32;
            let mut counter = Counter::new(greatest, start & greatest);
            let mut wide = Counter::new(greatest, start);
            let mut position = 0;
            for step in steps {
                position += step;
                let reading = (i64::from(start) + position) as u32;
                prop_assert_eq!(counter.counts(reading & greatest), position);
                prop_assert_eq!(wide.counts(reading), position);
            }
        }
    }
}
