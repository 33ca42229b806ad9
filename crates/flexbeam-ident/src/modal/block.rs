//! Blocks of columns: modal states, inputs, outputs over 512 samples.
//!
//! Eight lanes walk eight stretches of 64 samples side by side: a first walk from rest finds where each stretch ends, so that the second can start each where
//! the one before it ends. Sample lane 64 + t of a block stands at t 8 + lane in every column.

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

/// w(k+1) = z w(k) + u(k) from `state` on, into `re` and, for a complex pole, `im`; leaves the state after the block.
pub(super) struct Filter<'a, 'b> {
    pub z: C64,
    pub state: C64,
    /// None: no input.
    pub u: Option<&'a [f64]>,
    pub re: &'b mut [f64],
    /// None: the pole is real, and so is the state.
    pub im: Option<&'b mut [f64]>,
}

impl Kernel for Filter<'_, '_> {
    type Output = C64;

    #[inline(always)]
    fn run<L: Lanes>(self) -> C64 {
        let Filter { z, state, u, re, im } = self;
        let (real, up, down) = (L::splat(z.re), L::splat(z.im), L::splat(-z.im));
        let nothing = L::splat(0.0);
        let (mut x, mut y) = (nothing, nothing);
        if let Some(u) = u {
            let u = &u[..BLOCK];
            for t in 0..STEPS {
                let drive = L::load(&u[t * LANES..]);
                let next = real.times_plus(x, down.times_plus(y, drive));
                y = real.times_plus(y, up.times(x));
                x = next;
            }
        }
        let (mut starts_re, mut starts_im) = (x.to_array(), y.to_array());
        // What 64 samples make of a state.
        let mut far = z;
        for _ in 0..6 {
            far *= far;
        }
        let mut start = state;
        for lane in 0..LANES {
            let rest = C64::new(starts_re[lane], starts_im[lane]);
            (starts_re[lane], starts_im[lane]) = (start.re, start.im);
            start = far * start + rest;
        }
        (x, y) = (L::load(&starts_re), L::load(&starts_im));
        let re = &mut re[..BLOCK];
        if let Some(im) = im {
            let im = &mut im[..BLOCK];
            for t in 0..STEPS {
                x.store(&mut re[t * LANES..]);
                y.store(&mut im[t * LANES..]);
                let drive = u.map_or(nothing, |u| L::load(&u[t * LANES..]));
                let next = real.times_plus(x, down.times_plus(y, drive));
                y = real.times_plus(y, up.times(x));
                x = next;
            }
        } else {
            for t in 0..STEPS {
                x.store(&mut re[t * LANES..]);
                x = real.times_plus(x, u.map_or(nothing, |u| L::load(&u[t * LANES..])));
            }
        }
        start
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{Plain, on_widest};

    /// Sample by sample in order of time, for a real and a complex pole, driven and not.
    #[test]
    fn blocks_are_what_a_plain_recursion_gives() {
        let white = crate::excitation::white_gaussian(3 * BLOCK, 1.0, 9.0, 2);
        for z in [C64::new(0.99, 0.0), C64::new(0.95, 0.3), C64::new(-0.2, 0.1)] {
            for driven in [true, false] {
                let (mut state, mut wanted) = (C64::new(1.0, -0.5), C64::new(1.0, -0.5));
                for first in (0..3 * BLOCK).step_by(BLOCK) {
                    let mut block = Block::new(3);
                    block.set(0, &white[first..first + BLOCK]);
                    let (u, rest) = block.columns.split_at_mut(BLOCK);
                    let (re, im) = rest.split_at_mut(BLOCK);
                    let before = state;
                    let u = driven.then_some(&*u);
                    state = on_widest(Filter { z, state: before, u, re, im: Some(im) });
                    let mut plain = vec![0.0; BLOCK];
                    let kernel = Filter { z, state: before, u, re: &mut plain, im: (z.im != 0.0).then_some(im) };
                    let plain_end = kernel.run::<Plain>();
                    assert!((plain_end - state).norm() < 1e-13);
                    for k in 0..BLOCK {
                        let place = k % STEPS * LANES + k / STEPS;
                        let found = C64::new(re[place], im[place]);
                        assert!((found - wanted).norm() < 1e-13 * (1.0 + wanted.norm()), "{z}, sample {k}");
                        assert!((plain[place] - wanted.re).abs() < 1e-13 * (1.0 + wanted.norm()));
                        wanted = z * wanted + if driven { white[first + k] } else { 0.0 };
                    }
                }
                assert!((state - wanted).norm() < 1e-12);
            }
        }
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
