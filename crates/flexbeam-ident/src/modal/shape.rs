//! Which column and which unknown stands where.

use flexbeam_lti::{Mat, Vector};

use super::least_squares::Free;
use super::modes::Modes;

/// States, inputs, outputs. Columns of a block: n for x(0), n for each input, the inputs, ones, the outputs. Unknowns: x(0), B, D, offsets.
#[derive(Clone, Copy)]
pub(super) struct Shape {
    pub n: usize,
    pub m: usize,
    pub l: usize,
}

impl Shape {
    pub fn u(self, c: usize) -> usize {
        self.n * (1 + self.m) + c
    }
    pub fn ones(self) -> usize {
        self.u(self.m)
    }
    /// Columns that explain: all but the outputs.
    pub fn x(self) -> usize {
        self.ones() + 1
    }
    pub fn y(self, p: usize) -> usize {
        self.x() + p
    }
    pub fn columns(self) -> usize {
        self.y(self.l)
    }
    pub fn unknowns(self) -> usize {
        self.n * (1 + self.m) + self.l * self.m + self.l
    }

    /// Coefficients of the columns in output p, one column an unknown.
    pub fn map(self, modes: &Modes, C: &Mat, p: usize) -> Mat {
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

    pub fn joined(self, B: &Mat, D: &Mat, offset: &Vector) -> Vector {
        let start = std::iter::repeat_n(0.0, self.n);
        let all = start.chain(B.iter().copied()).chain(D.iter().copied()).chain(offset.iter().copied());
        Vector::from_iterator(self.unknowns(), all)
    }

    /// Unknowns that are free.
    pub fn open(self, free: Free) -> Vec<usize> {
        let ends = [self.n, self.n * (1 + self.m), self.unknowns() - self.l, self.unknowns()];
        let wanted = [true, free.B, free.D, free.offset];
        (0..self.unknowns()).filter(|k| wanted[ends.iter().position(|end| k < end).expect("an unknown")]).collect()
    }

    /// Squares that a solution misses, and that the outputs move, from a Gram matrix of all samples.
    pub fn missed(self, S: &Mat, maps: &[Mat], theta: &Vector) -> Option<(Vec<f64>, Vec<f64>)> {
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
