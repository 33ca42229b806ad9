//! The last minute of samples, in memory that is taken once: the recorder's thread writes, each viewer reads at its own pace.
//!
//! Deliberately absent: the loop's thread. The lock is held while one row is written, or a few hundred are copied: microseconds.

use super::signals::{CHANNELS, SIGNALS};
use flexbeam_files::RunSample;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What is kept, at most [s].
const LONGEST_S: f64 = 60.0;
/// Rows that are kept, at most: less than 5 MB.
const MOST_ROWS: usize = 1 << 16;
/// Rows of one frame, at most.
pub(super) const MOST_IN_FRAME: usize = 4096;
/// Rows that are copied under the lock at a time: 18 kB.
const AT_A_TIME: usize = 256;
/// First bytes of a frame: FBS1.
const MAGIC: u32 = 0x3153_4246;
/// Bytes of a frame before its ticks.
const HEAD: usize = 24;

/// One tick, as viewers get it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Row {
    tick: u64,
    values: [f32; CHANNELS],
}

impl Row {
    pub(super) fn of(sample: &RunSample) -> Row {
        let mut values = [0.0; CHANNELS];
        values.iter_mut().zip(&SIGNALS).for_each(|(value, signal)| *value = (signal.of)(sample) as f32);
        Row { tick: sample.tick, values }
    }
}

/// The ring.
pub(super) struct History(Mutex<Ring>);

struct Ring {
    rows: Box<[Row]>,
    /// Rows ever written; the newest stands before this place, modulo the length.
    written: u64,
}

/// Where a viewer stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Cursor {
    next: u64,
    /// Rows that went by, and that no frame has told yet.
    lost: u64,
}

impl Ring {
    fn oldest(&self) -> u64 {
        self.written.saturating_sub(self.rows.len() as u64)
    }

    fn at(&self, row: u64) -> Row {
        self.rows[(row % self.rows.len() as u64) as usize]
    }

    /// The first row behind this tick. Ticks only grow.
    fn behind(&self, tick: u64) -> u64 {
        let (mut low, mut high) = (self.oldest(), self.written);
        while low < high {
            let middle = low.midpoint(high);
            if self.at(middle).tick > tick { high = middle } else { low = middle + 1 }
        }
        low
    }
}

impl History {
    /// For a run with this period; a minute, or as much of it as 2^16 rows are.
    pub(super) fn new(period_s: f64) -> History {
        let minute = (LONGEST_S / period_s).ceil();
        let rows = if minute < MOST_ROWS as f64 { (minute as usize).max(1) } else { MOST_ROWS };
        History(Mutex::new(Ring { rows: vec![Row::default(); rows].into(), written: 0 }))
    }

    fn lock(&self) -> MutexGuard<'_, Ring> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// One more row, in the place of the oldest.
    pub(super) fn push(&self, row: Row) {
        let mut ring = self.lock();
        let place = (ring.written % ring.rows.len() as u64) as usize;
        ring.rows[place] = row;
        ring.written += 1;
    }

    /// The oldest row; behind `tick`, the first that is newer. A tick that is yet to come is of another run and counts as none.
    pub(super) fn cursor(&self, tick: Option<u64>) -> Cursor {
        let ring = self.lock();
        let oldest = ring.oldest();
        let newest = (ring.written > 0).then(|| ring.at(ring.written - 1).tick);
        let Some(tick) = tick.filter(|tick| newest.is_some_and(|newest| *tick <= newest)) else {
            return Cursor { next: oldest, lost: 0 };
        };
        let next = ring.behind(tick);
        // What lay between is gone; how many of its periods had a sample nobody knows any more.
        let gone = if next == oldest && next < ring.written { ring.at(next).tick - tick - 1 } else { 0 };
        Cursor { next, lost: if ring.oldest() > 0 { gone } else { 0 } }
    }

    /// The next rows for a viewer, `most` of them or as many as a frame holds; `rows` is scratch. Nothing when there are none.
    pub(super) fn frame(&self, cursor: &mut Cursor, rows: &mut Vec<Row>, most: usize) -> Option<Vec<u8>> {
        let most = most.min(MOST_IN_FRAME);
        rows.clear();
        while rows.len() < most && self.copy(cursor, rows, most) {}
        if rows.is_empty() {
            return None;
        }
        let lost = u32::try_from(cursor.lost).unwrap_or(u32::MAX);
        cursor.lost = 0;
        Some(encoded(rows, lost))
    }

    /// Passes over what waits for a viewer, if that is more than a twelfth of the history, 5 s: it is lost to it, and the next
    /// frame says so.
    pub(super) fn pass_over(&self, cursor: &mut Cursor) {
        let ring = self.lock();
        let waiting = ring.written.saturating_sub(cursor.next);
        if waiting > ring.rows.len() as u64 / 12 {
            cursor.lost += waiting;
            cursor.next = ring.written;
        }
    }

    /// A few hundred rows; whether there may be more of them for this frame.
    fn copy(&self, cursor: &mut Cursor, rows: &mut Vec<Row>, most: usize) -> bool {
        let ring = self.lock();
        let gone = ring.oldest().saturating_sub(cursor.next);
        if gone > 0 && !rows.is_empty() {
            return false; // rows went by since the last copy: the next frame tells it
        }
        cursor.lost += gone;
        cursor.next += gone;
        let end = ring.written.min(cursor.next + AT_A_TIME.min(most - rows.len()) as u64);
        while cursor.next < end {
            let row = ring.at(cursor.next);
            // A pause of 2^32 periods begins a frame.
            if rows.first().is_some_and(|first| row.tick - first.tick > u32::MAX.into()) {
                return false;
            }
            rows.push(row);
            cursor.next += 1;
        }
        cursor.next < ring.written
    }
}

fn encoded(rows: &[Row], lost: u32) -> Vec<u8> {
    let first = rows.first().map_or(0, |row| row.tick);
    let mut bytes = Vec::with_capacity(HEAD + rows.len() * 4 * (1 + CHANNELS));
    bytes.extend(MAGIC.to_le_bytes());
    bytes.extend((rows.len() as u32).to_le_bytes());
    bytes.extend((first as f64).to_le_bytes());
    bytes.extend((CHANNELS as u32).to_le_bytes());
    bytes.extend(lost.to_le_bytes());
    rows.iter().for_each(|row| bytes.extend(((row.tick - first) as u32).to_le_bytes()));
    for channel in 0..CHANNELS {
        rows.iter().for_each(|row| bytes.extend(row.values[channel].to_le_bytes()));
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame as a page reads it: lost, ticks, first channel.
    fn read(bytes: &[u8]) -> (u32, Vec<u64>, Vec<f32>) {
        let u32_at = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        let (n, m) = (u32_at(4) as usize, u32_at(16) as usize);
        assert_eq!((&bytes[..4], m, bytes.len()), (&b"FBS1"[..], CHANNELS, 24 + 4 * n * (1 + m)));
        let first = f64::from_le_bytes(bytes[8..16].try_into().unwrap()) as u64;
        let ticks = (0..n).map(|k| first + u64::from(u32_at(24 + 4 * k))).collect();
        let values = (0..n).map(|k| f32::from_bits(u32_at(24 + 4 * (n + k)))).collect();
        (u32_at(20), ticks, values)
    }

    fn push(history: &History, ticks: impl IntoIterator<Item = u64>) {
        for tick in ticks {
            let sample = RunSample { tick, reference_rad: tick as f64 * 0.1, ..RunSample::default() };
            history.push(Row::of(&sample));
        }
    }

    fn all(history: &History, cursor: &mut Cursor) -> Vec<(u32, Vec<u64>)> {
        let mut rows = Vec::new();
        let next = || history.frame(cursor, &mut rows, MOST_IN_FRAME).map(|bytes| read(&bytes));
        std::iter::from_fn(next).map(|(lost, ticks, _)| (lost, ticks)).collect()
    }

    #[test]
    fn every_row_comes_once_in_order_with_its_values() {
        let history = History::new(1e-3);
        push(&history, (0..10_000).filter(|tick| tick % 7 != 3));
        let (mut cursor, mut rows) = (history.cursor(None), Vec::new());
        let (lost, ticks, values) = read(&history.frame(&mut cursor, &mut rows, MOST_IN_FRAME).unwrap());
        assert_eq!((lost, ticks.len()), (0, MOST_IN_FRAME));
        assert!(ticks.iter().zip(&values).all(|(tick, value)| *value == (*tick as f64 * 0.1) as f32));
        let rest: Vec<u64> = all(&history, &mut cursor).into_iter().flat_map(|(_, ticks)| ticks).collect();
        let whole: Vec<u64> = ticks.into_iter().chain(rest).collect();
        assert!(whole.iter().copied().eq((0..10_000).filter(|tick| tick % 7 != 3)));
        assert_eq!(history.frame(&mut cursor, &mut rows, MOST_IN_FRAME), None);
    }

    #[test]
    fn a_slow_viewer_learns_what_it_lost() {
        let history = History::new(0.1); // 600 rows
        push(&history, 0..100);
        let mut cursor = history.cursor(None);
        all(&history, &mut cursor);
        push(&history, 100..1000);
        assert_eq!(all(&history, &mut cursor), [(300, (400..1000).collect())]);
        push(&history, 1000..1001);
        assert_eq!(all(&history, &mut cursor), [(0, vec![1000])], "it is told once");
    }

    #[test]
    fn who_comes_back_goes_on_behind_its_last_tick() {
        let history = History::new(0.1);
        assert_eq!(history.cursor(Some(0)), Cursor::default());
        push(&history, [0, 1, 5, 6]);
        let after = |tick| all(&history, &mut history.cursor(Some(tick)));
        assert_eq!(after(1), [(0, vec![5, 6])]);
        assert_eq!(after(3), [(0, vec![5, 6])], "between two rows");
        assert_eq!(after(6), []);
        assert_eq!(after(7), [(0, vec![0, 1, 5, 6])], "of another run");
        push(&history, 7..1000);
        let after = |tick| all(&history, &mut history.cursor(Some(tick)));
        assert_eq!(after(995), [(0, (996..1000).collect())]);
        assert_eq!(after(399), [(0, (400..1000).collect())], "just not too late");
        assert_eq!(after(300), [(99, (400..1000).collect())]);
    }

    #[test]
    fn a_pause_that_no_offset_holds_begins_a_frame() {
        let history = History::new(1e-3);
        let far = 1 + u64::from(u32::MAX);
        push(&history, [0, far - 1, far, far + 1]);
        let mut cursor = history.cursor(None);
        assert_eq!(all(&history, &mut cursor), [(0, vec![0, far - 1]), (0, vec![far, far + 1])]);
    }

    #[test]
    fn the_memory_is_a_minute_or_less() {
        let rows = |period_s| History::new(period_s).lock().rows.len();
        assert_eq!((rows(1e-3), rows(1e-4), rows(0.01), rows(1e9)), (60_000, MOST_ROWS, 6000, 1));
        assert!(MOST_ROWS * size_of::<Row>() < 5_000_000);
    }

    /// A writer that never rests: frames hold whole rows, in order, and what is missing is told.
    #[test]
    fn no_row_is_ever_seen_half() {
        const ROWS: u64 = 200_000;
        let history = std::sync::Arc::new(History::new(0.1));
        let writer = history.clone();
        let writing = std::thread::spawn(move || {
            for tick in 0..ROWS {
                let sample = RunSample { tick, reference_rad: tick as f64, stale: 1, ..RunSample::default() };
                writer.push(Row::of(&sample));
            }
        });
        let (mut cursor, mut rows, mut seen, mut lost, mut last) = (Cursor::default(), Vec::new(), 0, 0, None);
        while seen + lost < ROWS {
            let Some(bytes) = history.frame(&mut cursor, &mut rows, MOST_IN_FRAME) else { continue };
            let (gone, ticks, values) = read(&bytes);
            assert!(ticks.iter().zip(&values).all(|(tick, value)| *tick as f32 == *value));
            assert!(ticks.windows(2).all(|pair| pair[1] == pair[0] + 1));
            assert_eq!(ticks[0], last.map_or(0, |last| last + 1) + u64::from(gone));
            (seen, lost, last) = (seen + ticks.len() as u64, lost + u64::from(gone), ticks.last().copied());
        }
        writing.join().unwrap();
    }

    #[test]
    fn what_waited_too_long_is_passed_over_and_told() {
        let history = History::new(1e-3);
        push(&history, 0..5000);
        let mut cursor = Cursor::default();
        history.pass_over(&mut cursor);
        assert_eq!(cursor, Cursor::default(), "five seconds may wait");
        push(&history, 5000..5001);
        history.pass_over(&mut cursor);
        push(&history, 5001..5004);
        assert_eq!(all(&history, &mut cursor), [(5001, vec![5001, 5002, 5003])]);
    }
}
