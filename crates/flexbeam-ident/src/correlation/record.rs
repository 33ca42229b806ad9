//! Lagged correlations of one record that arrives in chunks.
//!
//! Enters: chunks of samples, of any length. Leaves: the Gram matrix of the record's block Hankel matrix. Memory: a few thousand samples,
//! whatever the record's length. Deliberately absent: order of rows, scales.

use super::channels::{Channels, NotFinite, STANDS_OFF};
use super::gram::{Ends, Gram};
use super::kernel::{LANES, PIECE, lagged_products};
use super::rounding::{BIAS, FRACTION, LEAST_EXPONENT, exponent, fraction, quantised};
use crate::double::{Double, power_of_two};
use crate::shares::{each, shared};

/// Left samples whose integer sums are turned into double-doubles together: 2^24 products of at most 2^102 stay within an i128.
const MOST_SAMPLES: usize = 1 << 24;
/// Samples that are judged and summed up in one go, for each thread: they stay in a second-level cache in between.
const PART: usize = 1 << 15;

/// Sums over the left samples 2i - 1 <= k of z(k) z(k+d)' for d = 0..2i-1, and what the ends of the record need.
///
/// Numerics: a channel that stands far off zero loses its first sample; then it is rounded once, to 2^-52 of the power of two above the largest sample so far, judged in blocks that are
/// counted from the record's start. The sums are those of the rounded record without further error up to 2^-104 of the sum of magnitudes for each time that
/// the largest doubles. Chunks and threads do not change a bit.
pub(crate) struct Record {
    /// Block rows i.
    i: usize,
    /// Samples of a block: more than both ends of the record together.
    block: usize,
    /// What every sample loses: the first sample of channels that move little beside it, zero of others. Empty until the first block is whole.
    offset: Vec<f64>,
    /// Of each channel: |sample - offset| < 2^exponent so far.
    exponents: Vec<i32>,
    /// Sums since the last flush, units of 2^-102 and 2^-51 of the exponents.
    open: Sums<i128>,
    /// Sums before it, in units of the exponents.
    closed: Sums<Double>,
    /// Samples that later samples are still to be multiplied with, from block `done` on.
    kept: Vec<Vec<f64>>,
    /// Blocks that are summed up.
    done: usize,
    /// The first 4i - 2 samples, rounded, in units of the exponents; empty until the first block is summed.
    head: Vec<Vec<f64>>,
}

/// Products: (d c + a) c + b holds channel a times channel b, d samples later. Firsts: the left samples themselves.
#[derive(Clone)]
pub(super) struct Sums<T> {
    pub products: Vec<T>,
    pub firsts: Vec<T>,
}

impl<T: Clone + Default> Sums<T> {
    pub fn zero(channels: usize, lags: usize) -> Sums<T> {
        Sums { products: vec![T::default(); lags * channels * channels], firsts: vec![T::default(); channels] }
    }
}

impl Sums<i128> {
    fn add(&mut self, other: &Sums<i128>) {
        self.products.iter_mut().zip(&other.products).for_each(|(a, b)| *a += b);
        self.firsts.iter_mut().zip(&other.firsts).for_each(|(a, b)| *a += b);
    }
}

/// What is kept of a record and the chunk that follows it, as one stretch that starts at block `done`.
struct View<'a> {
    kept: &'a [Vec<f64>],
    chunk: &'a Channels<'a>,
    offset: &'a [f64],
}

impl View<'_> {
    fn samples(&self) -> usize {
        self.kept[0].len() + self.chunk.samples()
    }

    /// Samples `first..` of one channel, less the offset.
    fn copy(&self, channel: usize, first: usize, target: &mut [f64]) {
        let kept = &self.kept[channel];
        let old = kept.len().saturating_sub(first).min(target.len());
        let (from_kept, from_chunk) = target.split_at_mut(old);
        let offset = self.offset[channel];
        from_kept.iter_mut().zip(&kept[first.min(kept.len())..]).for_each(|(t, x)| *t = x - offset);
        self.chunk.copy(channel, (first + old).saturating_sub(kept.len()), offset, from_chunk);
    }

    fn largest(&self, channel: usize, range: std::ops::Range<usize>, offset: f64) -> f64 {
        let kept = self.kept[channel].len();
        let old = self.kept[channel][range.start.min(kept)..range.end.min(kept)].iter();
        let new = range.start.max(kept) - kept..range.end.max(kept) - kept;
        let new = self.chunk.largest(channel, new, offset);
        old.fold(0.0, |most: f64, x| most.max((x - offset).abs())).max(new) + new * 0.0
    }
}

impl Record {
    /// Assumes: at least one channel and one block row.
    pub fn new(channels: usize, i: usize) -> Record {
        assert!(channels > 0 && i > 0, "{channels} channels, {i} block rows");
        Record {
            i,
            block: PIECE * (4 * i).div_ceil(PIECE),
            offset: Vec::new(),
            exponents: vec![LEAST_EXPONENT; channels],
            open: Sums::zero(channels, 2 * i),
            closed: Sums::zero(channels, 2 * i),
            kept: vec![Vec::new(); channels],
            done: 0,
            head: Vec::new(),
        }
    }

    /// Samples so far.
    pub fn samples(&self) -> usize {
        self.done * self.block + self.kept[0].len()
    }

    /// Continues the record by a chunk. `threads` share the work; the sums do not depend on their number.
    ///
    /// Errors: [`NotFinite`]; what came before it may have been taken, so that the record is of no more use.
    pub fn absorb(&mut self, chunk: &Channels, threads: usize) -> Result<(), NotFinite> {
        assert_eq!(chunk.count(), self.kept.len(), "a chunk has the record's channels");
        let part = PART.next_multiple_of(self.block) * threads.max(1);
        for first in (0..chunk.samples()).step_by(part) {
            let samples = chunk.part(first..chunk.samples().min(first + part));
            let bad = self.absorb_part(&samples, threads);
            bad.map_err(|bad| NotFinite { sample: first + bad.sample, ..bad })?;
        }
        Ok(())
    }

    fn absorb_part(&mut self, chunk: &Channels, threads: usize) -> Result<(), NotFinite> {
        let kept = std::mem::replace(&mut self.kept, vec![Vec::new(); chunk.count()]);
        let nothing = vec![0.0; chunk.count()];
        self.settle_offset(&View { kept: &kept, chunk, offset: &nothing }, self.block);
        let offset = if self.offset.is_empty() { nothing } else { self.offset.clone() };
        let view = View { kept: &kept, chunk, offset: &offset };
        let whole = view.samples() / self.block;
        let judged = (whole * self.block).saturating_sub(kept[0].len()).min(chunk.samples());
        if let Some(bad) = chunk.part(judged..chunk.samples()).not_finite() {
            return Err(NotFinite { sample: judged + bad.sample, ..bad });
        }
        let Some(exponents) = self.block_exponents(&view, whole, threads) else {
            return Err(chunk.not_finite().expect("a sample that is not finite was met"));
        };
        let blocks = whole.saturating_sub(1);
        self.sum_up(&view, &exponents, blocks, usize::MAX, threads);
        let rest = view.samples() - blocks * self.block;
        let raw = View { offset: &vec![0.0; chunk.count()], ..view };
        self.kept = (0..chunk.count())
            .map(|c| {
                let mut samples = vec![0.0; rest];
                raw.copy(c, blocks * self.block, &mut samples);
                samples
            })
            .collect();
        self.done += blocks;
        Ok(())
    }

    /// Decides what the samples lose, once the first `needed` samples are there.
    fn settle_offset(&mut self, view: &View, needed: usize) {
        if !self.offset.is_empty() || view.samples() < needed {
            return;
        }
        let settle = |channel: usize| {
            let mut first = [0.0];
            if needed > 0 {
                view.copy(channel, 0, &mut first);
            }
            let moves = view.largest(channel, 0..needed, first[0]);
            if first[0].abs() > STANDS_OFF * moves { first[0] } else { 0.0 }
        };
        self.offset = (0..view.kept.len()).map(settle).collect();
    }

    /// H H' of the whole record.
    pub fn finish(mut self) -> Gram {
        let (c, i, s) = (self.kept.len(), self.i, self.samples());
        let kept = std::mem::take(&mut self.kept);
        let nothing = flexbeam_lti::Mat::zeros(c, 0);
        let nothing = Channels::of_rows(&nothing);
        self.settle_offset(&View { kept: &kept, chunk: &nothing, offset: &vec![0.0; c] }, s.min(self.block));
        let offset = self.offset.clone();
        let view = View { kept: &kept, chunk: &nothing, offset: &offset };
        let blocks = view.samples().div_ceil(self.block);
        let exponents = self.block_exponents(&view, blocks, 1).expect("kept samples are finite");
        let columns = (s + 1).saturating_sub(2 * i);
        self.sum_up(&view, &exponents, blocks, columns, 1);
        self.flush();
        let tail = columns.max(2 * i - 1).min(s);
        let tail = self.rounded(&view, &exponents, tail - self.done * self.block..view.samples());
        let head = if self.head.is_empty() { vec![Vec::new(); c] } else { self.head };
        let ends = Ends { head, tail };
        Gram::of_record(i, s, self.offset, self.exponents, self.closed, ends)
    }

    /// Running exponents of the first blocks of a view; None when a sample is not finite.
    fn block_exponents(&self, view: &View, blocks: usize, threads: usize) -> Option<Vec<Vec<i32>>> {
        let (c, block, samples) = (self.exponents.len(), self.block, view.samples());
        let largest = |b: usize| -> Vec<f64> {
            (0..c).map(|a| view.largest(a, b * block..samples.min((b + 1) * block), view.offset[a])).collect()
        };
        let largest = each(0..blocks, threads, largest);
        let mut running = self.exponents.clone();
        let mut next = |largest: Vec<f64>| {
            let all = largest.iter().all(|x| x.is_finite());
            running.iter_mut().zip(largest).for_each(|(e, x)| *e = if all { exponent(x).max(*e) } else { *e });
            all.then(|| running.clone())
        };
        largest.into_iter().map(&mut next).collect()
    }

    /// Adds the left samples of the first `blocks` blocks of the view, those of the record before `end` only.
    ///
    /// Assumes: `exponents` has one entry more than `blocks` unless the record ends with the view.
    fn sum_up(&mut self, view: &View, exponents: &[Vec<i32>], blocks: usize, end: usize, threads: usize) {
        let (block, base, reach) = (self.block, self.done * self.block, 2 * self.i - 1);
        let most_blocks = (MOST_SAMPLES / block).max(1);
        if self.head.is_empty() && blocks > 0 {
            self.raise(&exponents[0]);
            self.head = self.rounded(view, exponents, 0..view.samples().min(2 * reach));
        }
        let mut b = 0;
        while b < blocks {
            self.raise(&exponents[b]);
            let run = exponents[b..].iter().take_while(|e| **e == exponents[b]).count();
            let until_flush = most_blocks - (self.done + b) % most_blocks;
            let last = blocks.min(b + run.min(until_flush));
            let louder = exponents.get(last).filter(|e| **e != exponents[b]);
            let first = (b * block).max(reach.saturating_sub(base));
            let stop = (last * block).min(end.saturating_sub(base));
            let same = if louder.is_some() { stop.min(last * block - reach) } else { stop };
            self.add_uniform(view, first..same.max(first), threads);
            if let Some(louder) = louder {
                self.raise(louder);
                self.add_mixed(view, exponents, first.max(same)..stop.max(first));
            } else if (self.done + last).is_multiple_of(most_blocks) {
                self.flush();
            }
            b = last;
        }
    }

    /// Left samples whose right samples all have the present exponents.
    fn add_uniform(&mut self, view: &View, range: std::ops::Range<usize>, threads: usize) {
        let pieces = range.len().div_ceil(PIECE);
        let (i, exponents) = (self.i, &self.exponents);
        let parts = shared(0..pieces, threads, |pieces| {
            let mut worker = Worker::new(exponents, 2 * i);
            for piece in pieces {
                let first = range.start + piece * PIECE;
                worker.add(view, first, PIECE.min(range.end - first));
            }
            worker.sums
        });
        parts.iter().for_each(|part| self.open.add(part));
    }

    /// Left samples near a block that is louder: one product at a time.
    fn add_mixed(&mut self, view: &View, exponents: &[Vec<i32>], range: std::ops::Range<usize>) {
        let (c, lags) = (self.exponents.len(), 2 * self.i);
        if range.is_empty() {
            return;
        }
        let z = self.rounded(view, exponents, range.start..range.end + lags - 1);
        for k in 0..range.len() {
            for d in 0..lags {
                for a in 0..c {
                    for b in 0..c {
                        self.closed.products[(d * c + a) * c + b] += Double::product(z[a][k], z[b][k + d]);
                    }
                }
            }
            (0..c).for_each(|a| self.closed.firsts[a] += Double::new(z[a][k]));
        }
    }

    /// These samples of a view as the integers say, in units of the record's present exponents.
    fn rounded(&self, view: &View, exponents: &[Vec<i32>], range: std::ops::Range<usize>) -> Vec<Vec<f64>> {
        let mut found = vec![vec![0.0; range.len()]; self.exponents.len()];
        for (a, z) in found.iter_mut().enumerate() {
            view.copy(a, range.start, z);
            let mut integer = [0];
            for (k, x) in z.iter_mut().enumerate() {
                let e = exponents[(range.start + k) / self.block][a];
                quantised(&[*x], e, &mut integer);
                *x = Double::new(fraction(integer[0])).shifted(e - self.exponents[a]).hi;
            }
        }
        found
    }

    /// Goes over to exponents that are at least the present ones.
    fn raise(&mut self, exponents: &[i32]) {
        if self.exponents == exponents {
            return;
        }
        self.flush();
        let c = exponents.len();
        let down: Vec<i32> = self.exponents.iter().zip(exponents).map(|(old, new)| old - new).collect();
        for (place, sum) in self.closed.products.iter_mut().enumerate() {
            *sum = sum.shifted(down[place / c % c]).shifted(down[place % c]);
        }
        self.closed.firsts.iter_mut().zip(&down).for_each(|(sum, down)| *sum = sum.shifted(*down));
        for (z, down) in self.head.iter_mut().zip(&down) {
            z.iter_mut().for_each(|x| *x = Double::new(*x).shifted(*down).hi);
        }
        self.exponents = exponents.to_vec();
    }

    /// Turns the integer sums into double-doubles.
    fn flush(&mut self) {
        let close = |closed: &mut Vec<Double>, open: &mut Vec<i128>, unit: f64| {
            for (sum, integer) in closed.iter_mut().zip(open) {
                if *integer != 0 {
                    *sum += Double::from_integer(*integer).scaled(unit);
                    *integer = 0;
                }
            }
        };
        close(&mut self.closed.products, &mut self.open.products, power_of_two(-2 * FRACTION));
        close(&mut self.closed.firsts, &mut self.open.firsts, power_of_two(-FRACTION));
    }
}

/// Integer sums of one thread, and the room for one piece.
struct Worker<'a> {
    exponents: &'a [i32],
    lags: usize,
    sums: Sums<i128>,
    samples: Vec<f64>,
    /// Channel after channel: a piece, and the lags that follow it.
    window: Vec<u64>,
    /// Channel after channel: a piece, then zeros.
    left: Vec<u64>,
    products: Vec<u128>,
}

impl Worker<'_> {
    fn new(exponents: &[i32], lags: usize) -> Worker<'_> {
        let c = exponents.len();
        Worker {
            exponents,
            lags,
            sums: Sums::zero(c, lags),
            samples: vec![0.0; PIECE + lags],
            window: vec![0; c * (PIECE + lags)],
            left: vec![0; c * PIECE],
            products: vec![0; c * lags],
        }
    }

    /// Adds `count` left samples, at most a piece.
    fn add(&mut self, view: &View, first: usize, count: usize) {
        let (c, lags) = (self.exponents.len(), self.lags);
        let padded = count.next_multiple_of(LANES);
        let long = PIECE + lags;
        for a in 0..c {
            let samples = &mut self.samples[..count + lags - 1];
            view.copy(a, first, samples);
            quantised(samples, self.exponents[a], &mut self.window[a * long..]);
            let left = &mut self.left[a * PIECE..][..padded];
            left[..count].copy_from_slice(&self.window[a * long..][..count]);
            left[count..].fill(0);
        }
        let left: Vec<&[u64]> = self.left.chunks_exact(PIECE).map(|channel| &channel[..padded]).collect();
        let firsts: Vec<i128> = left.iter().map(|q| i128::from(q.iter().sum::<u64>())).collect();
        let (bias, n) = (i128::from(BIAS), count as i128);
        for b in 0..c {
            let window = &self.window[b * long..][..padded + lags - 1];
            lagged_products(&left, window, lags, &mut self.products);
            let mut right = firsts[b];
            for d in 0..lags {
                for (a, first) in firsts.iter().enumerate() {
                    // (x + bias)(y + bias) = x y + bias (x + y + 2 bias) - bias^2.
                    let biased = self.products[a * lags + d] as i128;
                    self.sums.products[(d * c + a) * c + b] += biased - bias * (first + right) + n * bias * bias;
                }
                right += i128::from(window.get(count + d).copied().unwrap_or(0)) - i128::from(window[d]);
            }
            self.sums.firsts[b] += firsts[b] - n * bias;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::white_gaussian;
    use flexbeam_lti::Mat;

    /// Three channels: one that grows, one with an offset, one that is still at first.
    fn samples(count: usize) -> Mat {
        let white = white_gaussian(3 * count, 1.0, 9.0, 11);
        Mat::from_fn(count, 3, |k, c| {
            let x = white[3 * k + c];
            match c {
                0 => x * (1.0 + k as f64 / 300.0),
                1 => 1e6 + x,
                _ => {
                    if k > 1500 {
                        1e-9 * x
                    } else {
                        0.0
                    }
                }
            }
        })
    }

    fn gram(data: &Mat, i: usize, cuts: &[usize], threads: usize) -> Gram {
        let mut record = Record::new(data.ncols(), i);
        let channels = Channels::of_columns(data);
        let mut first = 0;
        for cut in cuts.iter().copied().chain([data.nrows()]) {
            record.absorb(&channels.part(first..cut), threads).unwrap();
            first = cut;
        }
        record.finish()
    }

    fn expect_same_bits(a: &Gram, b: &Gram) {
        let n = 2 * a.i * a.channels();
        for r in 0..n {
            assert_eq!(a.sum(r), b.sum(r), "sum {r}");
            (0..n).for_each(|q| assert_eq!(a.product(r, q), b.product(r, q), "({r},{q})"));
        }
        assert_eq!((a.columns, a.exponents()), (b.columns, b.exponents()));
    }

    /// H H' with H formed and multiplied in double-double, sample by sample; the record's own rounding is all that may differ.
    fn expect_printed(data: &Mat, i: usize, tolerance: f64) {
        let c = data.ncols();
        let gram = gram(data, i, &[], 1).about(&vec![0.0; c]);
        let j = data.nrows() - 2 * i + 1;
        let n = 2 * i * c;
        let entry = |r: usize, q: usize| {
            let products = (0..j).map(|k| Double::product(data[(r / c + k, r % c)], data[(q / c + k, q % c)]));
            products.fold(Double::ZERO, |sum, x| sum + x)
        };
        let found = |r: usize, q: usize| gram.product(r, q).shifted(gram.exponents()[r % c] + gram.exponents()[q % c]);
        for r in 0..n {
            for q in 0..n {
                let size = (entry(r, r).hi * entry(q, q).hi).sqrt();
                let error = (found(r, q) - entry(r, q)).value().abs();
                assert!(error <= tolerance * size, "({r},{q}): {:e}", error / size);
            }
        }
    }

    #[test]
    fn gram_matrix_is_the_printed_one_at_every_length() {
        for (count, i) in [(20, 4), (7, 4), (8, 4), (29, 4), (30, 4), (31, 4), (400, 3), (3000, 2)] {
            if count >= 2 * i {
                expect_printed(&samples(count), i, 4e-15);
            }
        }
    }

    /// Integers of fewer than 52 bits are not rounded at all: every entry is right to the digits of a double-double.
    #[test]
    fn integers_have_an_exact_gram_matrix() {
        let data = samples(5000).map(|x| (x * 1024.0).round());
        expect_printed(&data, 3, 1e-30);
    }

    #[test]
    fn chunks_and_threads_change_no_bit() {
        let data = samples(9000);
        let whole = gram(&data, 5, &[], 1);
        for cuts in [&[1][..], &[4000], &[10, 1023, 1024, 1025, 2047, 2048, 5000, 5001], &[8999]] {
            for threads in [1, 3] {
                expect_same_bits(&whole, &gram(&data, 5, cuts, threads));
            }
        }
        let mut single = Record::new(3, 5);
        let channels = Channels::of_columns(&data);
        (0..9000).for_each(|k| single.absorb(&channels.part(k..k + 1), 2).unwrap());
        expect_same_bits(&whole, &single.finish());
    }

    /// Shards with 2i - 1 samples in common hold all columns once. Each is rounded by its own largest sample.
    #[test]
    fn overlapping_shards_add_up_to_the_whole() {
        let (data, i) = (samples(7000), 4);
        let whole = gram(&data, i, &[], 1).about(&[0.0; 3]);
        let shard = |range: std::ops::Range<usize>| gram(&data.rows(range.start, range.len()).into_owned(), i, &[], 1);
        let mut sum = shard(0..2500);
        sum.add(&shard(2500 - 7..2520));
        sum.add(&shard(2520 - 7..7000));
        assert_eq!(sum.columns, whole.columns);
        let sum = sum.about(&[0.0; 3]);
        let n = 2 * i * 3;
        let entry = |gram: &Gram, r: usize, q: usize| {
            gram.product(r, q).shifted(gram.exponents()[r % 3] + gram.exponents()[q % 3]).value()
        };
        for r in 0..n {
            for q in 0..n {
                let size = (entry(&whole, r, r) * entry(&whole, q, q)).sqrt();
                assert!((entry(&sum, r, q) - entry(&whole, r, q)).abs() < 1e-15 * size, "({r},{q})");
            }
        }
    }

    #[test]
    fn means_and_lengths_of_the_channels() {
        let data = samples(6000);
        let gram = gram(&data, 3, &[], 1);
        for (c, mean) in gram.means().iter().enumerate() {
            let wanted = data.column(c).mean();
            let size = data.column(c).amax();
            assert!((mean - wanted).abs() < 1e-13 * size, "{mean} for {wanted}");
        }
        let about = gram.about(&gram.means());
        for (c, rms) in about.rms().iter().enumerate() {
            let mean = data.column(c).mean();
            let wanted = (data.column(c).add_scalar(-mean).norm_squared() / 6000.0).sqrt();
            let found = rms * 2f64.powi(about.exponents()[c]);
            assert!((found / wanted - 1.0).abs() < 1e-9, "{found:e} for {wanted:e}");
        }
    }

    #[test]
    fn a_bad_sample_is_named() {
        let good = samples(40_000);
        for (sample, channel) in [(0, 1), (1500, 0), (39_999, 2), (2047, 1), (33_000, 0)] {
            let mut bad = good.clone();
            bad[(sample, channel)] = f64::NAN;
            let mut record = Record::new(3, 4);
            let refused = record.absorb(&Channels::of_columns(&bad), 1);
            assert_eq!(refused, Err(NotFinite { channel, sample }));
        }
    }

    #[test]
    fn a_record_without_a_column_is_nothing() {
        assert_eq!(Record::new(2, 3).finish().columns, 0);
        let mut sum = Record::new(3, 4).finish();
        let other = gram(&samples(500), 4, &[], 1);
        sum.add(&other);
        expect_same_bits(&sum, &other);
        assert_eq!(gram(&samples(7), 4, &[], 1).columns, 0);
    }

    /// From 1e300 to 1e-300 and from a record that begins at the largest number there is.
    #[test]
    fn extreme_magnitudes() {
        for unit in [1e300, 1e-200] {
            let plain = samples(2000).columns(0, 1).into_owned();
            let data = &plain * unit;
            let (a, b) = (gram(&data, 3, &[], 1), gram(&plain, 3, &[], 1));
            let ratio = |g: &Gram| g.product(3, 1).value() / g.product(0, 0).value();
            assert!((ratio(&a) / ratio(&b) - 1.0).abs() < 1e-12);
        }
        let mut data = samples(2000).columns(0, 1).into_owned();
        (data[0], data[1]) = (f64::MAX, -f64::MAX);
        assert!(gram(&data, 3, &[], 1).product(0, 0).value().is_finite());
        // Zeros stay zeros, whatever the first sample.
        (data[0], data[1]) = (0.1, 0.0);
        data.rows_mut(2, 1998).fill(0.0);
        let impulse = gram(&data, 3, &[], 1);
        assert_eq!((impulse.product(1, 1), impulse.product(0, 1)), (Double::ZERO, Double::ZERO));
    }
}
