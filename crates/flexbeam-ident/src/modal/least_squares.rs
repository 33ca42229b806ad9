//! Least squares of the simulated output on the recorded one, in modal coordinates.
//!
//! Enters: A, C, what is known of the rest, a recording. Leaves: the rest, and what it misses. Deliberately absent: one-step prediction.

use flexbeam_lti::{C64, Mat, Vector};

use super::block::{BLOCK, Block, Filter, Filters};
use super::modes::Modes;
use crate::columns::Columns;
use crate::correlation::Channels;
use crate::double::Double;
use crate::lanes::on_widest;
use crate::shares::each;

/// How far a mode may grow within the record: beyond this, what earlier samples say drowns.
const LARGEST_GROWTH: f64 = 1e6;
/// A mode that has faded below this is nothing: it could not move the last bit of anything.
const FADED: f64 = 1e-40;
/// Products a sample that the normal matrix may cost; with more columns it comes from every so-many-th block.
const MOST_PRODUCTS: usize = 800;
/// Samples of a part: whole blocks.
const PART: usize = 32 * BLOCK;
/// Blocks of the record that always count: what fades fades there.
const FIRST_BLOCKS: usize = 4;
/// The solution is refined until the next step would be below a hundredth of a standard error,
const STEP: f64 = 1e-4;
/// or moves the output by less than its own rounding.
const ROUNDING: f64 = 2.0 * f64::EPSILON;
/// Each step shrinks by a factor of ten or so; one that needs more than this many is not worth it.
const MOST_STEPS: usize = 8;

/// What is to be found; the rest is taken as given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Free {
    pub B: bool,
    pub D: bool,
    pub offset: bool,
}

/// y = C x + D u + offset with x(k+1) = A x(k) + B u(k): A and C are known, x(0) is not. B, D and offset are found or given.
///
/// Recorded channels are less `mean` and over `scale`: inputs first, then outputs.
#[derive(Clone)]
pub(crate) struct Problem<'a> {
    pub A: &'a Mat,
    pub C: &'a Mat,
    pub B: Mat,
    pub D: Mat,
    pub offset: Vector,
    pub channels: Channels<'a>,
    pub mean: &'a [f64],
    pub scale: &'a [f64],
    /// Share the work; the solution does not depend on their number.
    pub threads: usize,
}

/// The solution, and squares over all samples for each output.
#[derive(Clone, Debug)]
pub(crate) struct ModalFit {
    pub B: Mat,
    pub D: Mat,
    pub offset: Vector,
    pub initial_state: Vector,
    /// Sum of (y - yhat)^2.
    pub missed: Vec<f64>,
    /// Sum of (y - mean of y)^2.
    pub moved: Vec<f64>,
}

impl Problem<'_> {
    /// None when the modes of A are no basis, grow out of the record, or do not determine what is free.
    ///
    /// Numerics: every state is a filter of one pole, shared by all outputs; normal equations in f64 are refined by the residual's gradient, so that the
    /// squared condition slows the iteration down and does not cost digits. Per sample about 8 n m operations to simulate and (n (1 + m) + m + l)^2 / 2, at
    /// most 800, for the normal matrix. The same bits whenever the processor has a fused multiply-add.
    /// Source: Bjoerck 1996, section 2.9.3 (fixed-precision refinement of the normal equations).
    pub fn solve(&self, free: Free) -> Option<ModalFit> {
        let modes = Modes::of(self.A)?;
        let samples = self.channels.samples();
        let growth = modes.poles.iter().map(|z| z.norm()).fold(0.0, f64::max).ln() * samples as f64;
        if growth > LARGEST_GROWTH.ln() || samples == 0 {
            return None;
        }
        let basis = modes.V.clone().lu();
        let shape = Shape { n: self.A.nrows(), m: self.D.ncols(), l: self.D.nrows() };
        let maps: Vec<Mat> = (0..shape.l).map(|p| shape.map(&modes, &(self.C * &modes.V), p)).collect();
        let mut theta = shape.joined(&basis.solve(&self.B)?, &self.D, &self.offset);
        let open = shape.open(free);
        let mut responses = Responses { problem: self, modes: &modes, shape, maps: &maps, starts: Vec::new() };
        let (S, every) = responses.gram(self.threads);
        let equations = Equations::new(&S, &maps, &open, shape)?;
        let square: f64 = (0..shape.l).map(|p| S[(shape.y(p), shape.y(p))]).sum();
        let exact = every == 1;
        let means: Vec<f64> =
            (0..shape.l).map(|p| S[(shape.y(p), shape.ones())] / S[(shape.ones(), shape.ones())]).collect();
        let gradient = |theta: &Vector| -> Vector {
            let of = |p: usize, map: &Mat| {
                map.transpose()
                    * (S.view((0, shape.y(p)), (shape.x(), 1)) - S.view((0, 0), (shape.x(), shape.x())) * (map * theta))
            };
            maps.iter().enumerate().map(|(p, map)| of(p, map).column(0).into_owned()).sum()
        };
        theta += equations.step(&gradient(&theta));
        let tolerance = |missed: f64| {
            STEP * missed * open.len() as f64 / (samples * shape.l) as f64 + (ROUNDING * ROUNDING) * square
        };
        if exact && let Some((missed, moved)) = shape.missed(&S, &maps, &theta) {
            let rounding = (4.0 * f64::EPSILON * shape.x() as f64).powi(2) * square / equations.weakest;
            if rounding < STEP * missed.iter().sum::<f64>() * open.len() as f64 / (samples * shape.l) as f64 {
                return Some(self.fit(&modes, shape, &theta, missed, moved));
            }
        }
        let mut last = 0.0;
        for _ in 0..MOST_STEPS {
            let rest = responses.residual(&theta, &means, self.threads);
            let step = equations.step(&rest.gradient);
            let gain = rest.gradient.dot(&step).max(0.0);
            theta += step;
            // What the next step would gain, if it shrinks as this one did.
            let next = if last > 0.0 { gain * (gain / last).min(1.0) } else { gain };
            if next <= tolerance(rest.missed.iter().sum()) {
                let total: f64 = rest.missed.iter().sum();
                let left = if total > 0.0 { (1.0 - gain / total).max(0.0) } else { 1.0 };
                let missed = rest.missed.iter().map(|x| x * left).collect();
                return Some(self.fit(&modes, shape, &theta, missed, rest.moved));
            }
            if last > 0.0 && gain >= 0.25 * last {
                return None;
            }
            last = gain;
        }
        None
    }

    fn fit(&self, modes: &Modes, shape: Shape, theta: &Vector, missed: Vec<f64>, moved: Vec<f64>) -> ModalFit {
        let Shape { n, m, l } = shape;
        let states = &modes.V * Mat::from_column_slice(n, 1 + m, &theta.as_slice()[..n * (1 + m)]);
        let rest = &theta.as_slice()[n * (1 + m)..];
        ModalFit {
            initial_state: states.column(0).into_owned(),
            B: states.columns(1, m).into_owned(),
            D: Mat::from_column_slice(l, m, &rest[..l * m]),
            offset: Vector::from_column_slice(&rest[l * m..]),
            missed,
            moved,
        }
    }
}

/// States, inputs, outputs. Columns of a block: n for x(0), n for each input, the inputs, ones, the outputs. Unknowns: x(0), B, D, offsets.
#[derive(Clone, Copy)]
struct Shape {
    n: usize,
    m: usize,
    l: usize,
}

impl Shape {
    fn u(self, c: usize) -> usize {
        self.n * (1 + self.m) + c
    }
    fn ones(self) -> usize {
        self.u(self.m)
    }
    /// Columns that explain: all but the outputs.
    fn x(self) -> usize {
        self.ones() + 1
    }
    fn y(self, p: usize) -> usize {
        self.x() + p
    }
    fn columns(self) -> usize {
        self.y(self.l)
    }
    fn unknowns(self) -> usize {
        self.n * (1 + self.m) + self.l * self.m + self.l
    }

    /// Coefficients of the columns in output p, one column an unknown.
    fn map(self, modes: &Modes, C: &Mat, p: usize) -> Mat {
        let mut map = Mat::zeros(self.x(), self.unknowns());
        for family in 0..=self.m {
            let mut k = family * self.n;
            for z in &modes.poles {
                let c = C[(p, k % self.n)];
                map[(k, k)] = c;
                if z.im > 0.0 {
                    // The state (b1, b2) of a pair answers with (b1 - j b2) w, its output with c1 Re - c2 Im of that.
                    let d = C[(p, k % self.n + 1)];
                    (map[(k + 1, k)], map[(k, k + 1)], map[(k + 1, k + 1)]) = (-d, d, c);
                    k += 1;
                }
                k += 1;
            }
        }
        let first = self.n * (1 + self.m);
        (0..self.m).for_each(|c| map[(self.u(c), first + c * self.l + p)] = 1.0);
        map[(self.ones(), first + self.m * self.l + p)] = 1.0;
        map
    }

    fn joined(self, B: &Mat, D: &Mat, offset: &Vector) -> Vector {
        let start = std::iter::repeat_n(0.0, self.n);
        let all = start.chain(B.iter().copied()).chain(D.iter().copied()).chain(offset.iter().copied());
        Vector::from_iterator(self.unknowns(), all)
    }

    /// Unknowns that are free.
    fn open(self, free: Free) -> Vec<usize> {
        let ends = [self.n, self.n * (1 + self.m), self.unknowns() - self.l, self.unknowns()];
        let wanted = [true, free.B, free.D, free.offset];
        (0..self.unknowns()).filter(|k| wanted[ends.iter().position(|end| k < end).expect("an unknown")]).collect()
    }

    /// Squares that a solution misses, and that the outputs move, from a Gram matrix of all samples.
    fn missed(self, S: &Mat, maps: &[Mat], theta: &Vector) -> Option<(Vec<f64>, Vec<f64>)> {
        let Sxx = S.view((0, 0), (self.x(), self.x()));
        let each = |p: usize| {
            let (k, y) = (&maps[p] * theta, self.y(p));
            let b = S.view((0, y), (self.x(), 1));
            let missed = S[(y, y)] - 2.0 * b.column(0).dot(&k) + (Sxx * &k).dot(&k);
            let moved = S[(y, y)] - S[(y, self.ones())].powi(2) / S[(self.ones(), self.ones())];
            // Both are differences of sums of this size; half of the digits must be left.
            (missed > 1e-8 * S[(y, y)] && moved > 1e-8 * S[(y, y)]).then_some((missed, moved))
        };
        (0..self.l).map(each).collect::<Option<Vec<_>>>().map(|all| all.into_iter().unzip())
    }
}

/// Normal equations of the free unknowns.
struct Equations {
    open: Vec<usize>,
    unknowns: usize,
    lengths: Vec<f64>,
    cholesky: nalgebra::Cholesky<f64, nalgebra::Dyn>,
    /// Smallest eigenvalue of the scaled matrix, at most.
    weakest: f64,
}

impl Equations {
    fn new(S: &Mat, maps: &[Mat], open: &[usize], shape: Shape) -> Option<Equations> {
        let Sxx = S.view((0, 0), (shape.x(), shape.x()));
        let maps = maps.iter().map(|map| map.select_columns(open));
        let H: Mat = maps.map(|map| map.transpose() * (Sxx * &map)).sum();
        let lengths: Vec<f64> = H.diagonal().iter().map(|x| x.sqrt()).collect();
        if !lengths.iter().all(|x| *x > 0.0 && x.is_finite()) {
            return None;
        }
        let scaled = Mat::from_fn(open.len(), open.len(), |r, c| H[(r, c)] / (lengths[r] * lengths[c]));
        let cholesky = scaled.cholesky()?;
        let inverse = cholesky.l().solve_lower_triangular(&Mat::identity(open.len(), open.len()))?;
        let weakest = inverse.norm_squared().recip();
        Some(Equations { open: open.to_vec(), unknowns: shape.unknowns(), lengths, cholesky, weakest })
    }

    /// H^-1 g on the free unknowns.
    fn step(&self, gradient: &Vector) -> Vector {
        let g = Vector::from_fn(self.open.len(), |k, _| gradient[self.open[k]] / self.lengths[k]);
        let x = self.cholesky.solve(&g);
        let mut step = Vector::zeros(self.unknowns);
        self.open.iter().enumerate().for_each(|(k, place)| step[*place] = x[k] / self.lengths[k]);
        step
    }
}

/// Passes over the recording, in parts of fixed length that do not depend on the number of threads.
struct Responses<'a> {
    problem: &'a Problem<'a>,
    modes: &'a Modes,
    shape: Shape,
    maps: &'a [Mat],
    /// States at the start of each part: those of x(0), which start at one, then each input's. Known after the first pass.
    starts: Vec<Vec<C64>>,
}

struct Residual {
    gradient: Vector,
    missed: Vec<f64>,
    moved: Vec<f64>,
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
    fn gram(&mut self, threads: usize) -> (Mat, usize) {
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
            let W = self.from_rest(&state);
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
    fn from_rest(&self, state: &[C64]) -> Mat {
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
    fn residual(&self, theta: &Vector, means: &[f64], threads: usize) -> Residual {
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
