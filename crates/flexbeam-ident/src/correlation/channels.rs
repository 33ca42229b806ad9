//! Samples of several channels in one view, whichever of channel and sample runs faster in memory.

use flexbeam_lti::Mat;

use crate::lanes::{Kernel, LANES, Lanes, on_widest};

/// A channel that stands this far from zero, against how far it moves, is a small signal on a large offset.
pub(super) const STANDS_OFF: f64 = 8.0;

/// A sample that is infinite or not a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NotFinite {
    pub channel: usize,
    /// Sample, from 0, of the stretch that was looked at.
    pub sample: usize,
}

/// Channels of one stretch of samples.
#[derive(Clone)]
pub(crate) struct Channels<'a> {
    /// First sample of the channel on, and how far apart its samples stand.
    channels: Vec<(&'a [f64], usize)>,
    samples: usize,
}

impl<'a> Channels<'a> {
    /// Rows of `data` are channels.
    pub fn of_rows(data: &'a Mat) -> Channels<'a> {
        let (count, samples) = data.shape();
        Channels { channels: (0..count).map(|c| (data.as_slice().get(c..).unwrap_or(&[]), count)).collect(), samples }
    }

    /// Columns of `data` are channels.
    pub fn of_columns(data: &'a Mat) -> Channels<'a> {
        let s = data.nrows();
        Channels {
            channels: (0..data.ncols()).map(|c| (&data.as_slice()[c * s..(c + 1) * s], 1)).collect(),
            samples: s,
        }
    }

    /// These channels and then those of `other`, as many samples as both have.
    pub fn beside(mut self, other: Channels<'a>) -> Channels<'a> {
        self.samples = self.samples.min(other.samples);
        self.channels.extend(other.channels);
        self
    }

    /// The samples of this range.
    pub fn part(&self, range: std::ops::Range<usize>) -> Channels<'a> {
        assert!(range.end <= self.samples, "a part of {} samples", self.samples);
        let from = |&(data, stride): &(&'a [f64], usize)| (data.get(range.start * stride..).unwrap_or(&[]), stride);
        Channels { channels: self.channels.iter().map(from).collect(), samples: range.len() }
    }

    /// Channels of which the first ones come as many samples later as `delays` says; the first samples, which then lack one, fall away.
    pub fn later(&self, delays: &[usize]) -> Channels<'a> {
        let longest = delays.iter().copied().max().unwrap_or(0).min(self.samples);
        let start = |c: usize| longest - delays.get(c).copied().unwrap_or(0).min(longest);
        let from =
            |(c, &(data, stride)): (usize, &(&'a [f64], usize))| (data.get(start(c) * stride..).unwrap_or(&[]), stride);
        Channels { channels: self.channels.iter().enumerate().map(from).collect(), samples: self.samples - longest }
    }

    /// The channels from this one on.
    pub fn from(&self, first: usize) -> Channels<'a> {
        Channels { channels: self.channels[first..].to_vec(), samples: self.samples }
    }

    pub fn count(&self) -> usize {
        self.channels.len()
    }

    pub fn samples(&self) -> usize {
        self.samples
    }

    pub fn at(&self, channel: usize, sample: usize) -> f64 {
        let (data, stride) = self.channels[channel];
        data[sample * stride]
    }

    /// Samples `first..` of one channel, less `offset`, into `target`.
    pub fn copy(&self, channel: usize, first: usize, offset: f64, target: &mut [f64]) {
        let (data, stride) = self.channels[channel];
        assert!(first + target.len() <= self.samples, "{} samples", self.samples);
        if stride == 1 {
            let data = &data[first..first + target.len()];
            target.iter_mut().zip(data).for_each(|(t, x)| *t = x - offset);
        } else if !target.is_empty() {
            let data = data[first * stride..].iter().step_by(stride);
            target.iter_mut().zip(data).for_each(|(t, x)| *t = x - offset);
        }
    }

    /// What a channel may lose before it is rounded: its first sample if it moves little beside it within the first `count` samples, else nothing.
    pub fn standing(&self, channel: usize, count: usize) -> f64 {
        let first = self.at(channel, 0);
        let moves = self.largest(channel, 0..count, first);
        if first.abs() > STANDS_OFF * moves { first } else { 0.0 }
    }

    /// The first sample that is not finite.
    pub fn not_finite(&self) -> Option<NotFinite> {
        if (0..self.count()).all(|c| self.largest(c, 0..self.samples, 0.0).is_finite()) {
            return None;
        }
        let bad = |sample: usize| (0..self.count()).find(|&channel| !self.at(channel, sample).is_finite());
        (0..self.samples).find_map(|sample| bad(sample).map(|channel| NotFinite { channel, sample }))
    }

    /// Largest |x - offset| of these samples of one channel; not finite if one of them is not.
    pub fn largest(&self, channel: usize, range: std::ops::Range<usize>, offset: f64) -> f64 {
        let (data, stride) = self.channels[channel];
        assert!(range.end <= self.samples, "{} samples", self.samples);
        if stride == 1 {
            return on_widest(Largest { data: &data[range], offset });
        }
        let data = data.get(range.start * stride..).unwrap_or(&[]);
        let data = data.iter().step_by(stride).take(range.len());
        let (mut largest, mut poison) = (0.0, 0.0);
        for x in data {
            let moved: f64 = (x - offset).abs();
            largest = if moved > largest { moved } else { largest };
            poison += x * 0.0;
        }
        largest + poison
    }
}

/// Largest |x - offset|; NaN when an x is infinite or NaN, which comparisons alone would pass over.
#[derive(Clone)]
struct Largest<'a> {
    data: &'a [f64],
    offset: f64,
}

impl Kernel for Largest<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f64 {
        let nothing = L::splat(0.0);
        let (mut largest, mut poison) = (nothing, nothing);
        let offset = L::splat(self.offset);
        let whole = self.data.len() - self.data.len() % LANES;
        let mut k = 0;
        while k < whole {
            let x = L::load(&self.data[k..]);
            largest = x.minus(offset).largest_magnitude(largest);
            poison = x.times_plus(nothing, poison);
            k += LANES;
        }
        let mut most = 0.0;
        for x in largest.to_array() {
            most = if x > most { x } else { most };
        }
        let mut poison = poison.total();
        for x in &self.data[whole..] {
            let moved = (x - self.offset).abs();
            most = if moved > most { moved } else { most };
            poison += x * 0.0;
        }
        most + poison
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_columns_are_one_view() {
        let tall = Mat::from_fn(23, 3, |k, c| ((k * 7 + c) as f64).sin() - 0.3);
        let wide = tall.transpose();
        let (a, b) = (Channels::of_columns(&tall), Channels::of_rows(&wide));
        let (a, b) = (a.part(2..22), b.part(2..22));
        for c in 0..3 {
            let (mut x, mut y) = ([0.0; 11], [0.0; 11]);
            a.copy(c, 4, 0.5, &mut x);
            b.copy(c, 4, 0.5, &mut y);
            assert_eq!(x, y);
            assert_eq!(x[2], tall[(8, c)] - 0.5);
            let wanted = tall.column(c).rows(5, 14).iter().map(|x| (x + 0.1).abs()).fold(0.0, f64::max);
            assert_eq!(a.largest(c, 3..17, -0.1), wanted);
            assert_eq!(b.largest(c, 3..17, -0.1), wanted);
        }
    }

    #[test]
    fn what_is_not_finite_is_not_passed_over() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for at in [0, 5, 18] {
                let mut data = Mat::from_element(19, 1, 1.0);
                data[at] = bad;
                assert!(!Channels::of_columns(&data).largest(0, 0..19, 0.0).is_finite(), "{bad} at {at}");
                assert!(!Channels::of_rows(&data.transpose()).largest(0, 0..19, 0.0).is_finite());
            }
        }
    }
}
