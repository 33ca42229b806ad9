//! Blocks of columns: modal states, inputs, outputs over 512 samples.
//!
//! Eight lanes walk eight stretches of 64 samples side by side: a first walk from rest finds where each stretch ends, so that the second can start each where
//! the one before it ends. Sample lane 64 + t of a block stands at t 8 + lane in every column.

use std::borrow::BorrowMut;

use flexbeam_lti::C64;

use crate::lanes::{Kernel, LANES, Lanes};

const STEPS: usize = 64;
/// Samples of a block.
pub(super) const BLOCK: usize = LANES * STEPS;

/// Columns of one block.
pub(super) struct Block {
    /// Column after column, [`BLOCK`] rows each.
    pub columns: Vec<f64>,
}

impl Block {
    pub fn new(columns: usize) -> Block {
        Block { columns: vec![0.0; columns * BLOCK] }
    }

    pub fn column(&self, c: usize) -> &[f64] {
        &self.columns[c * BLOCK..(c + 1) * BLOCK]
    }

    /// Puts up to 512 samples in order of time into a column, zeros after them.
    pub fn set(&mut self, c: usize, samples: &[f64]) {
        let column = &mut self.columns[c * BLOCK..(c + 1) * BLOCK];
        if samples.len() == BLOCK {
            for t in 0..STEPS {
                for lane in 0..LANES {
                    column[t * LANES + lane] = samples[lane * STEPS + t];
                }
            }
            return;
        }
        column.fill(0.0);
        for (k, x) in samples.iter().enumerate() {
            column[k % STEPS * LANES + k / STEPS] = *x;
        }
    }

    /// Zeros behind the first `count` samples of the first `columns` columns.
    pub fn cut(&mut self, columns: usize, count: usize) {
        for column in self.columns.chunks_exact_mut(BLOCK).take(columns) {
            for k in count..BLOCK {
                column[k % STEPS * LANES + k / STEPS] = 0.0;
            }
        }
    }
}

/// w(k+1) = z w(k) + u(k) from `state` on, into `re` and, for a complex pole, `im`; `state` is left as it is after the block.
pub(super) struct Filter<'a> {
    pub z: C64,
    pub state: &'a mut C64,
    pub u: &'a [f64],
    pub re: &'a mut [f64],
    /// None: the pole is real, and so is the state.
    pub im: Option<&'a mut [f64]>,
}

/// Filters that are walked side by side: one alone would wait for its own last sample.
const TOGETHER: usize = 4;

/// Runs all filters over one block.
pub(super) struct Filters<'a, 'b>(pub &'b mut [Filter<'a>]);

impl Kernel for Filters<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let (whole, rest) = self.0.as_chunks_mut::<TOGETHER>();
        for filters in whole {
            walk::<L, TOGETHER>(filters);
        }
        match rest {
            [a, b, c] => walk::<L, 3>(&mut [a, b, c]),
            [a, b] => walk::<L, 2>(&mut [a, b]),
            [a] => walk::<L, 1>(&mut [a]),
            _ => (),
        }
    }
}

#[inline(always)]
fn walk<'a, L: Lanes, const N: usize>(filters: &mut [impl BorrowMut<Filter<'a>>; N]) {
    let zero = L::splat(0.0);
    let (mut x, mut y) = ([zero; N], [zero; N]);
    let mut poles = [(zero, zero, zero); N];
    for n in 0..N {
        let filter: &mut Filter = filters[n].borrow_mut();
        let z = filter.z;
        poles[n] = (L::splat(z.re), L::splat(z.im), L::splat(-z.im));
    }
    for t in 0..STEPS {
        for n in 0..N {
            let filter: &mut Filter = filters[n].borrow_mut();
            (x[n], y[n]) = step(poles[n], (x[n], y[n]), L::load(&filter.u[t * LANES..]));
        }
    }
    for n in 0..N {
        let (starts_re, starts_im) = starts(filters[n].borrow_mut(), x[n].to_array(), y[n].to_array());
        (x[n], y[n]) = (L::load(&starts_re), L::load(&starts_im));
    }
    for t in 0..STEPS {
        for n in 0..N {
            let filter: &mut Filter = filters[n].borrow_mut();
            x[n].store(&mut filter.re[t * LANES..]);
            if let Some(im) = &mut filter.im {
                y[n].store(&mut im[t * LANES..]);
            }
            (x[n], y[n]) = step(poles[n], (x[n], y[n]), L::load(&filter.u[t * LANES..]));
        }
    }
}

/// z (x + j y) + u with z as (Re z, Im z, -Im z).
#[inline(always)]
fn step<L: Lanes>(z: (L, L, L), (x, y): (L, L), u: L) -> (L, L) {
    (z.0.times_plus(x, z.2.times_plus(y, u)), z.0.times_plus(y, z.1.times(x)))
}

/// Where each lane starts, from where each would end if it started from rest; the filter's state goes on to the block's end.
#[inline(always)]
fn starts(filter: &mut Filter, mut re: [f64; LANES], mut im: [f64; LANES]) -> ([f64; LANES], [f64; LANES]) {
    // What 64 samples make of a state.
    let mut far = filter.z;
    for _ in 0..STEPS.ilog2() {
        far *= far;
    }
    for lane in 0..LANES {
        let rest = C64::new(re[lane], im[lane]);
        (re[lane], im[lane]) = (filter.state.re, filter.state.im);
        *filter.state = far * *filter.state + rest;
    }
    (re, im)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{Plain, on_widest};

    /// Sample by sample in order of time, for real and complex poles, driven and not, on every kind of lanes; six filters make a four and a two.
    #[test]
    fn blocks_are_what_a_plain_recursion_gives() {
        let white = crate::excitation::white_gaussian(3 * BLOCK, 1.0, 9.0, 2);
        let mut drive = Block::new(2);
        let poles =
            [(0.99, 0.0), (0.95, 0.3), (-0.2, 0.1), (0.5, 0.0), (0.0, 0.9), (1.0, 0.0)].map(|z| C64::new(z.0, z.1));
        let start = |z: C64| C64::new(1.0, if z.im > 0.0 { -0.5 } else { 0.0 });
        let (mut states, mut wanted) = (poles.map(start), poles.map(start));
        for first in (0..3 * BLOCK).step_by(BLOCK) {
            drive.set(0, &white[first..first + BLOCK]);
            let mut ends = Vec::new();
            let mut last = Vec::new();
            for (name, run) in kinds() {
                let mut now = states;
                let mut columns = vec![0.0; 2 * poles.len() * BLOCK];
                let mut filters: Vec<Filter> = Vec::new();
                for ((k, columns), state) in columns.chunks_exact_mut(2 * BLOCK).enumerate().zip(&mut now) {
                    let (re, im) = columns.split_at_mut(BLOCK);
                    let im = (poles[k].im > 0.0).then_some(im);
                    filters.push(Filter { z: poles[k], state, u: drive.column(k % 2), re, im });
                }
                run(Filters(&mut filters));
                ends.push((name, now));
                last = columns;
            }
            for k in 0..BLOCK {
                let place = k % STEPS * LANES + k / STEPS;
                for (n, w) in wanted.iter_mut().enumerate() {
                    let found = C64::new(last[2 * n * BLOCK + place], last[(2 * n + 1) * BLOCK + place]);
                    assert!((found - *w).norm() < 1e-12 * (1.0 + w.norm()), "{}, sample {k}", poles[n]);
                    *w = poles[n] * *w + if n % 2 == 0 { white[first + k] } else { 0.0 };
                }
            }
            for (name, end) in &ends {
                let missed = end.iter().zip(&wanted).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
                assert!(missed < 1e-11, "{name}: {missed:e}");
            }
            states = ends.last().unwrap().1;
        }
    }

    type Run = fn(Filters);

    fn kinds() -> Vec<(&'static str, Run)> {
        vec![("plain", |filters| filters.run::<Plain>()), ("widest", |filters| on_widest(filters))]
    }

    #[test]
    fn short_blocks_end_in_zeros() {
        let mut block = Block::new(2);
        block.columns.fill(7.0);
        block.set(0, &[1.0; 70]);
        block.cut(2, 70);
        assert_eq!(block.column(0).iter().sum::<f64>(), 70.0);
        assert_eq!(block.column(1).iter().sum::<f64>(), 490.0);
    }
}
