//! Blocks of columns: modal states, inputs, outputs over 512 samples.
//!
//! Eight lanes walk eight stretches of 64 samples side by side: a first walk from rest finds where each stretch ends, so that the second can start each where
//! the one before it ends. Sample lane 64 + t of a block stands at t 8 + lane in every column.

use flexbeam_lti::C64;

pub(super) const LANES: usize = 8;
const STEPS: usize = 64;
/// Samples of a block.
pub(super) const BLOCK: usize = LANES * STEPS;

type Lanes = [f64; LANES];

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

/// w(k+1) = z w(k) + u(k) from `state` on, into `re` and, for a complex pole, `im`; returns the state after the block.
///
/// `u` None: no input.
pub(super) fn filter(z: C64, state: C64, u: Option<&[f64]>, re: &mut [f64], im: Option<&mut [f64]>) -> C64 {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx512f") {
        // SAFETY: the feature was found on this processor in the line above.
        return unsafe { filter_avx512(z, state, u, re, im) };
    } else if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        // SAFETY: the two features were found on this processor in the line above.
        return unsafe { filter_avx2(z, state, u, re, im) };
    }
    walk::<false>(z, state, u, re, im)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn filter_avx512(z: C64, state: C64, u: Option<&[f64]>, re: &mut [f64], im: Option<&mut [f64]>) -> C64 {
    walk::<true>(z, state, u, re, im)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn filter_avx2(z: C64, state: C64, u: Option<&[f64]>, re: &mut [f64], im: Option<&mut [f64]>) -> C64 {
    walk::<true>(z, state, u, re, im)
}

#[inline(always)]
fn walk<const FUSED: bool>(z: C64, state: C64, u: Option<&[f64]>, re: &mut [f64], im: Option<&mut [f64]>) -> C64 {
    // What 64 samples make of a state.
    let far = (0..6).fold(z, |power, _| power * power);
    let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
    if let Some(u) = u {
        let (drive, _) = u.as_chunks::<LANES>();
        for u in drive {
            (x, y) = step::<FUSED>(z, x, y, u);
        }
    }
    let mut start = state;
    for lane in 0..LANES {
        let rest = C64::new(x[lane], y[lane]);
        (x[lane], y[lane]) = (start.re, start.im);
        start = far * start + rest;
    }
    let nothing = [0.0; LANES];
    let drive: &[Lanes] = u.map_or(&[], |u| u.as_chunks::<LANES>().0);
    let (re, _) = re.as_chunks_mut::<LANES>();
    if let Some(im) = im {
        let (im, _) = im.as_chunks_mut::<LANES>();
        for t in 0..STEPS {
            (re[t], im[t]) = (x, y);
            (x, y) = step::<FUSED>(z, x, y, drive.get(t).unwrap_or(&nothing));
        }
    } else {
        for t in 0..STEPS {
            re[t] = x;
            (x, y) = step::<FUSED>(z, x, y, drive.get(t).unwrap_or(&nothing));
        }
    }
    start
}

/// z (x + j y) + u, lane by lane.
#[inline(always)]
fn step<const FUSED: bool>(z: C64, x: Lanes, y: Lanes, u: &Lanes) -> (Lanes, Lanes) {
    let (mut re, mut im) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        re[lane] = fused::<FUSED>(z.re, x[lane], fused::<FUSED>(-z.im, y[lane], u[lane]));
        im[lane] = fused::<FUSED>(z.re, y[lane], z.im * x[lane]);
    }
    (re, im)
}

#[inline(always)]
fn fused<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

#[cfg(test)]
mod tests {
    use super::*;

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
                    state = filter(z, before, driven.then_some(u), re, Some(im));
                    let mut plain = vec![0.0; BLOCK];
                    let plain_end = walk::<false>(z, before, driven.then_some(u), &mut plain, None);
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
