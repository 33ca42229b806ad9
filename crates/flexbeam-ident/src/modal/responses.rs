//! Passes over a recording: the Gram matrix of all modal columns, and the residual of a solution.

use flexbeam_lti::{C64, Mat, Vector};

use super::block::{BLOCK, Block, Filter, Filters};
use super::least_squares::Problem;
use super::modes::Modes;
use super::shape::Shape;
use crate::columns::Columns;
use crate::double::Double;
use crate::lanes::on_widest;
use crate::shares::each;

/// A mode that has faded below this is nothing: it could not move the last bit of anything.
const FADED: f64 = 1e-40;
/// Products a sample that the normal matrix may cost; with more columns it comes from every so-many-th block.
const MOST_PRODUCTS: usize = 800;
/// Samples of a part: whole blocks.
const PART: usize = 32 * BLOCK;
/// Blocks of the record that always count: what fades fades there.
const FIRST_BLOCKS: usize = 4;

/// Passes over the recording, in parts of fixed length that do not depend on the number of threads.
pub(super) struct Responses<'a> {
    pub problem: &'a Problem<'a>,
    pub modes: &'a Modes,
    pub shape: Shape,
    pub maps: &'a [Mat],
    /// States at the start of each part: those of x(0), which start at one, then each input's. Known after the first pass.
    pub starts: Vec<Vec<C64>>,
}

/// What a solution misses in each output, how far each moves, and the gradient.
pub(super) struct Residual {
    pub gradient: Vector,
    pub missed: Vec<f64>,
    pub moved: Vec<f64>,
}

/// Sums over one part.
struct Sums {
    /// Column by column of each output's residual.
    along: Vec<Vec<Double>>,
    missed: Vec<Double>,
    moved: Vec<Double>,
}

impl Responses<'_> {
    /// Gram matrix of all columns, from every so-many-th block, and how many that is.
    ///
    /// Each part starts from rest; what the true start adds is a combination of its decaying columns, which are there anyway.
    pub fn gram(&mut self, threads: usize) -> (Mat, usize) {
        let q = self.shape.columns();
        let every = (q * q / 2).div_ceil(MOST_PRODUCTS);
        let every = if self.problem.channels.samples() < 4 * every * BLOCK { 1 } else { every };
        let poles = self.modes.poles.len();
        let mut state = vec![C64::new(0.0, 0.0); poles * (1 + self.shape.m)];
        state[..poles].fill(C64::new(1.0, 0.0));
        let rest = state.clone();
        let parts = each(0..self.parts(), threads, |part| self.part_gram(part, &rest, every));
        let mut S = Mat::zeros(q, q);
        for (local, ends) in parts {
            let W = self.combinations(&state);
            S += W.transpose() * local * W;
            let next = |k: usize| if k < poles { ends[k] * state[k] } else { ends[k] + ends[k % poles] * state[k] };
            let next = (0..state.len()).map(next).collect();
            self.starts.push(std::mem::replace(&mut state, next));
        }
        (S, every)
    }

    fn parts(&self) -> usize {
        self.problem.channels.samples().div_ceil(PART)
    }

    fn part_gram(&self, part: usize, rest: &[C64], every: usize) -> (Mat, Vec<C64>) {
        let q = self.shape.columns();
        let mut sums = vec![Double::ZERO; q * q];
        let mut found = vec![0.0; q * q];
        let ends = self.each_block(part, rest, |index, block, alive| {
            let first = part == 0 && index < FIRST_BLOCKS;
            if !first && index % every != 0 {
                return;
            }
            let weight = if first { 1.0 } else { every as f64 };
            Columns { data: &block.columns, rows: BLOCK, alive }.gram(&mut found);
            for c in (0..q).filter(|c| alive[*c]) {
                for r in (c..q).filter(|r| alive[*r]) {
                    sums[c * q + r] += Double::new(found[c * q + r] * weight);
                }
            }
        });
        (Mat::from_fn(q, q, |r, c| sums[r.min(c) * q + r.max(c)].value()), ends)
    }

    /// The columns of a part with these states at its start, as combinations of those that start from rest.
    fn combinations(&self, state: &[C64]) -> Mat {
        let n = self.shape.n;
        let mut W = Mat::identity(self.shape.columns(), self.shape.columns());
        let mut column = 0;
        for (k, w) in state.iter().enumerate() {
            let z = self.modes.poles[k % self.modes.poles.len()];
            let decay = column % n;
            if column < n {
                W[(column, column)] = 0.0;
            }
            W[(decay, column)] += w.re;
            column += 1;
            if z.im > 0.0 {
                if column < n {
                    W[(column, column)] = 0.0;
                }
                // (re + j im) of the decay times w.
                W[(decay + 1, column - 1)] -= w.im;
                W[(decay, column)] += w.im;
                W[(decay + 1, column)] += w.re;
                column += 1;
            }
        }
        W
    }

    /// What a solution misses, and its gradient.
    pub fn residual(&self, theta: &Vector, means: &[f64], threads: usize) -> Residual {
        let (l, x) = (self.shape.l, self.shape.x());
        let weights: Vec<Vector> = self.maps.iter().map(|map| map * theta).collect();
        let nothing = || vec![Double::ZERO; l];
        let mut all = Sums { along: vec![vec![Double::ZERO; x]; l], missed: nothing(), moved: nothing() };
        for part in each(0..self.parts(), threads, |part| self.part_residual(part, &weights, means)) {
            for p in 0..l {
                all.missed[p] += part.missed[p];
                all.moved[p] += part.moved[p];
                all.along[p].iter_mut().zip(&part.along[p]).for_each(|(a, b)| *a += *b);
            }
        }
        let along = all.along.iter().map(|along| Vector::from_iterator(x, along.iter().map(|x| x.value())));
        let gradient = self.maps.iter().zip(along).map(|(map, along)| map.transpose() * along).sum();
        let values = |sums: Vec<Double>| sums.iter().map(|x| x.value()).collect();
        Residual { gradient, missed: values(all.missed), moved: values(all.moved) }
    }

    fn part_residual(&self, part: usize, weights: &[Vector], means: &[f64]) -> Sums {
        let (shape, l, x) = (self.shape, self.shape.l, self.shape.x());
        let nothing = || vec![Double::ZERO; l];
        let mut sums = Sums { along: vec![vec![Double::ZERO; x]; l], missed: nothing(), moved: nothing() };
        let mut rest = vec![0.0; BLOCK];
        let mut found = vec![0.0; x];
        self.each_block(part, &self.starts[part], |_, block, alive| {
            let explaining = Columns { data: &block.columns, rows: BLOCK, alive: &alive[..x] };
            for p in 0..l {
                rest.copy_from_slice(block.column(shape.y(p)));
                let ones = block.column(shape.ones());
                let square = |y: (&f64, &f64)| (y.0 - means[p] * y.1).powi(2);
                sums.moved[p] += Double::new(rest.iter().zip(ones).map(square).sum());
                explaining.take_from(weights[p].as_slice(), &mut rest);
                sums.missed[p] += Double::new(rest.iter().map(|e| e * e).sum());
                explaining.products(&rest, &mut found);
                (0..x).filter(|c| alive[*c]).for_each(|c| sums.along[p][c] += Double::new(found[c]));
            }
        });
        sums
    }

    /// Shows every block of a part, with the columns that are not zero throughout; returns the states at its end.
    fn each_block(&self, part: usize, starts: &[C64], mut show: impl FnMut(usize, &Block, &[bool])) -> Vec<C64> {
        let Shape { n, m, l } = self.shape;
        let (problem, shape) = (self.problem, self.shape);
        let samples = PART * part..problem.channels.samples().min(PART * (part + 1));
        let mut block = Block::new(shape.columns());
        let mut alive = vec![true; shape.columns()];
        let mut states = starts.to_vec();
        let mut raw = [0.0; BLOCK];
        let nothing = [0.0; BLOCK];
        for (index, first) in samples.clone().step_by(BLOCK).enumerate() {
            let count = BLOCK.min(samples.end - first);
            let recorded = (0..m).map(|c| (c, shape.u(c))).chain((0..l).map(|p| (m + p, shape.y(p))));
            for (channel, column) in recorded {
                problem.channels.copy(channel, first, problem.mean[channel], &mut raw[..count]);
                let by = problem.scale[channel].recip();
                raw[..count].iter_mut().for_each(|x| *x *= by);
                block.set(column, &raw[..count]);
            }
            block.set(shape.ones(), &[1.0; BLOCK][..count]);
            let (responses, recorded) = block.columns.split_at_mut(n * (1 + m) * BLOCK);
            let poles = &self.modes.poles;
            let mut filters = Vec::with_capacity(states.len());
            let (mut column, mut rest) = (0, responses);
            for (k, state) in states.iter_mut().enumerate() {
                let (z, family) = (poles[k % poles.len()], k / poles.len());
                let width = if z.im > 0.0 { 2 } else { 1 };
                let (columns, after) = rest.split_at_mut(width * BLOCK);
                rest = after;
                let faded = family == 0 && state.norm() < FADED;
                alive[column..column + width].fill(!faded);
                column += width;
                if faded {
                    *state = C64::new(0.0, 0.0);
                    columns.fill(0.0);
                    continue;
                }
                let u = if family == 0 { &nothing[..] } else { &recorded[(family - 1) * BLOCK..family * BLOCK] };
                let (re, im) = columns.split_at_mut(BLOCK);
                filters.push(Filter { z, state, u, re, im: (width == 2).then_some(im) });
            }
            on_widest(Filters(&mut filters));
            if count < BLOCK {
                block.cut(n * (1 + m), count);
            }
            show(index, &block, &alive);
        }
        states
    }
}
