//! Generalised eigenvalues: beta A x = alpha B x, finite and infinite, by the QZ algorithm.
//!
//! Enters: two square matrices. Leaves: pairs (alpha, beta). Absent: eigenvectors, deflating subspaces.

use crate::state_space::{expect_finite, expect_shape};
use crate::{C64, CMat, Error, Mat};

/// Sweeps that one eigenvalue may take; the usual number is two or three.
const SWEEPS: usize = 60;

/// After so many sweeps without a deflation the shift is exchanged for one that breaks a cycle, and entries are judged
/// relative to the whole matrix instead of their neighbours.
const PATIENCE: usize = 10;

/// Rounds of balancing. A pattern that cannot be balanced would go on for ever; a few rounds have most of the gain.
const BALANCING_ROUNDS: usize = 6;

/// One solution of beta A x = alpha B x.
///
/// beta is real and not negative. beta = 0, alpha != 0: an infinite eigenvalue. Both 0: the pencil is singular, every number
/// is an eigenvalue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeneralisedEigenvalue {
    /// Numerator.
    pub alpha: C64,
    /// Denominator.
    pub beta: C64,
}

impl GeneralisedEigenvalue {
    /// alpha / beta, or none when it is infinite or undetermined.
    pub fn finite(&self) -> Option<C64> {
        (self.beta.re > 0.0).then(|| self.alpha / self.beta.re)
    }
}

/// All generalised eigenvalues of the pencil A - lambda B.
///
/// Shapes: A, B n x n. Returns n of them; the finite ones are real or in exact conjugate pairs.
/// Errors: [`Error::Shape`], [`Error::NotFinite`], [`Error::NotConverged`].
/// Numerics: rows and columns balanced by powers of two, Hessenberg-triangular form, single-shift complex QZ: backward
/// stable for the balanced pencil; O(n^3). An entry of B's diagonal below rounding counts as zero and is deflated.
/// Source: Moler & Stewart 1973; balancing Lemonnier & Van Dooren 2006. Differs: complex arithmetic, then conjugates are
/// matched.
pub fn generalised_eigenvalues(A: &Mat, B: &Mat) -> Result<Vec<GeneralisedEigenvalue>, Error> {
    let n = A.nrows();
    for (what, M) in [("A of the pencil", A), ("B of the pencil", B)] {
        expect_shape(what, M, n, n)?;
        expect_finite(what, M)?;
    }
    if n == 0 {
        return Ok(Vec::new());
    }
    let (scale_A, scale_B) = (power_of_two(A.amax()), power_of_two(B.amax()));
    let (A, B) = balanced(A / scale_A, B / scale_B);
    let mut pencil = Pencil::hessenberg_triangular(A, &B);
    pencil.deflate()?;
    Ok(conjugate_pairs(pencil.diagonal(scale_A, scale_B)))
}

/// Diagonal scalings of the rows and of the columns, until all of |A|^2 + |B|^2 have about the norm 1.
fn balanced(mut A: Mat, mut B: Mat) -> (Mat, Mat) {
    let n = A.nrows();
    for _ in 0..BALANCING_ROUNDS {
        for k in 0..n {
            let row = power_of_two(A.row(k).norm().hypot(B.row(k).norm()));
            A.row_mut(k).unscale_mut(row);
            B.row_mut(k).unscale_mut(row);
        }
        for k in 0..n {
            let column = power_of_two(A.column(k).norm().hypot(B.column(k).norm()));
            A.column_mut(k).unscale_mut(column);
            B.column_mut(k).unscale_mut(column);
        }
    }
    (A, B)
}

/// The power of two next to x > 0; 1 where there is none.
fn power_of_two(x: f64) -> f64 {
    if x.is_normal() { x.log2().round().exp2() } else { 1.0 }
}

/// H - lambda T, H Hessenberg and T triangular.
struct Pencil {
    H: CMat,
    T: CMat,
    norm_H: f64,
    norm_T: f64,
}

impl Pencil {
    fn hessenberg_triangular(mut A: Mat, B: &Mat) -> Pencil {
        let n = A.nrows();
        let qr = B.clone().qr();
        qr.q_tr_mul(&mut A);
        let (norm_H, norm_T) = (A.norm(), B.norm());
        let mut pencil = Pencil { H: A.map(C64::from), T: qr.r().map(C64::from), norm_H, norm_T };
        for j in 0..n.saturating_sub(2) {
            for i in (j + 2..n).rev() {
                let rows = Rotation::onto_first(pencil.H[(i - 1, j)], pencil.H[(i, j)]);
                rows.rows(&mut pencil.H, i - 1, i, j, n);
                rows.rows(&mut pencil.T, i - 1, i, i - 1, n);
                pencil.H[(i, j)] = C64::ZERO;
                pencil.restore_triangle(i, 0, n);
            }
        }
        pencil
    }

    /// Rotates columns i-1 and i so that T[i, i-1] = 0 again; rows first..end of H take part.
    fn restore_triangle(&mut self, i: usize, first: usize, end: usize) {
        let columns = Rotation::onto_first(self.T[(i, i)], self.T[(i, i - 1)]);
        columns.columns(&mut self.H, i, i - 1, first, end);
        columns.columns(&mut self.T, i, i - 1, first, i + 1);
        self.T[(i, i - 1)] = C64::ZERO;
    }

    /// Splits eigenvalues off at the bottom until none is left.
    fn deflate(&mut self) -> Result<(), Error> {
        let mut last = self.H.nrows() - 1;
        let mut sweeps = 0;
        while last > 0 {
            let first = (1..=last).rev().find(|&k| self.split(k, sweeps)).unwrap_or(0);
            let infinite = (first..=last).find(|&k| self.T[(k, k)].norm() <= f64::EPSILON * self.norm_T);
            if first == last {
                (last, sweeps) = (last - 1, 0);
            } else if let Some(k) = infinite {
                self.split_infinite(k, first, last);
                (last, sweeps) = (last - 1, 0);
            } else if sweeps == SWEEPS {
                return Err(Error::NotConverged { what: "QZ", iterations: SWEEPS });
            } else {
                sweeps += 1;
                self.sweep(first, last, self.shift(last, sweeps));
            }
        }
        for k in 0..self.T.nrows() {
            if self.T[(k, k)].norm() <= f64::EPSILON * self.norm_T {
                self.T[(k, k)] = C64::ZERO;
            }
        }
        Ok(())
    }

    /// Whether H[k, k-1] is negligible; if so it becomes zero.
    fn split(&mut self, k: usize, sweeps: usize) -> bool {
        let neighbours = self.H[(k, k)].norm() + self.H[(k - 1, k - 1)].norm();
        let scale = if neighbours == 0.0 || sweeps > PATIENCE { self.norm_H } else { neighbours };
        let negligible = self.H[(k, k - 1)].norm() <= f64::EPSILON * scale;
        if negligible {
            self.H[(k, k - 1)] = C64::ZERO;
        }
        negligible
    }

    /// Moves the zero T[k, k] down to T[last, last] and frees it from H.
    fn split_infinite(&mut self, k: usize, first: usize, last: usize) {
        self.T[(k, k)] = C64::ZERO;
        for j in k..last {
            let rows = Rotation::onto_first(self.T[(j, j + 1)], self.T[(j + 1, j + 1)]);
            rows.rows(&mut self.T, j, j + 1, j + 1, last + 1);
            self.T[(j + 1, j + 1)] = C64::ZERO;
            rows.rows(&mut self.H, j, j + 1, j.max(first + 1) - 1, last + 1);
            if j > first {
                let columns = Rotation::onto_first(self.H[(j + 1, j)], self.H[(j + 1, j - 1)]);
                columns.columns(&mut self.H, j, j - 1, first, j + 2);
                columns.columns(&mut self.T, j, j - 1, first, j);
                self.H[(j + 1, j - 1)] = C64::ZERO;
            }
        }
        let columns = Rotation::onto_first(self.H[(last, last)], self.H[(last, last - 1)]);
        columns.columns(&mut self.H, last, last - 1, first, last + 1);
        columns.columns(&mut self.T, last, last - 1, first, last);
        self.H[(last, last - 1)] = C64::ZERO;
    }

    /// The eigenvalue of the last 2 x 2 block of H T^-1 that lies closer to its last entry.
    fn shift(&self, last: usize, sweeps: usize) -> C64 {
        let (h, t, k) = (&self.H, &self.T, last - 1);
        let (t11, t12, t22) = (t[(k, k)], t[(k, last)], t[(last, last)]);
        let (m11, m21) = (h[(k, k)] / t11, h[(last, k)] / t11);
        let m12 = (h[(k, last)] - m11 * t12) / t22;
        let m22 = (h[(last, last)] - m21 * t12) / t22;
        if sweeps.is_multiple_of(PATIENCE) {
            return m22 + m21 * C64::new(0.75, 0.4);
        }
        let half = (m11 - m22) * 0.5;
        let root = (half * half + m12 * m21).sqrt();
        let far = if (half.conj() * root).re < 0.0 { half - root } else { half + root };
        if far == C64::ZERO { m22 } else { m22 - m12 * m21 / far }
    }

    /// One implicit single-shift QZ sweep over rows and columns first..=last.
    fn sweep(&mut self, first: usize, last: usize, shift: C64) {
        let mut bulge = (self.H[(first, first)] - shift * self.T[(first, first)], self.H[(first + 1, first)]);
        for j in first..last {
            let rows = Rotation::onto_first(bulge.0, bulge.1);
            rows.rows(&mut self.H, j, j + 1, j.max(first + 1) - 1, last + 1);
            rows.rows(&mut self.T, j, j + 1, j, last + 1);
            if j > first {
                self.H[(j + 1, j - 1)] = C64::ZERO;
            }
            self.restore_triangle(j + 1, first, (j + 3).min(last + 1));
            if j + 2 <= last {
                bulge = (self.H[(j + 1, j)], self.H[(j + 2, j)]);
            }
        }
    }

    fn diagonal(&self, scale_A: f64, scale_B: f64) -> Vec<GeneralisedEigenvalue> {
        let pair = |k: usize| {
            let (alpha, beta) = (self.H[(k, k)] * scale_A, self.T[(k, k)] * scale_B);
            let turn = if beta == C64::ZERO { C64::ONE } else { beta.conj() / beta.norm() };
            GeneralisedEigenvalue { alpha: alpha * turn, beta: C64::from(beta.norm()) }
        };
        (0..self.H.nrows()).map(pair).collect()
    }
}

/// [c s; -conj(s) c], unitary.
struct Rotation {
    c: f64,
    s: C64,
}

impl Rotation {
    /// Takes (a, b) to (r, 0).
    fn onto_first(a: C64, b: C64) -> Rotation {
        let (size_a, r) = (a.norm(), a.norm().hypot(b.norm()));
        if b == C64::ZERO || r == 0.0 {
            return Rotation { c: 1.0, s: C64::ZERO };
        }
        if size_a == 0.0 {
            return Rotation { c: 0.0, s: b.conj() / r };
        }
        Rotation { c: size_a / r, s: (a / size_a) * (b.conj() / r) }
    }

    /// Rows i and k, columns first..end.
    fn rows(&self, M: &mut CMat, i: usize, k: usize, first: usize, end: usize) {
        for j in first..end {
            let (x, y) = (M[(i, j)], M[(k, j)]);
            M[(i, j)] = x * self.c + self.s * y;
            M[(k, j)] = y * self.c - self.s.conj() * x;
        }
    }

    /// Columns i and k, rows first..end.
    fn columns(&self, M: &mut CMat, i: usize, k: usize, first: usize, end: usize) {
        for j in first..end {
            let (x, y) = (M[(j, i)], M[(j, k)]);
            M[(j, i)] = x * self.c + self.s * y;
            M[(j, k)] = y * self.c - self.s.conj() * x;
        }
    }
}

/// A real pencil's eigenvalues are real or conjugate: each takes its nearest mirror image as partner, or itself.
fn conjugate_pairs(mut found: Vec<GeneralisedEigenvalue>) -> Vec<GeneralisedEigenvalue> {
    let imaginary = |e: &GeneralisedEigenvalue| e.finite().map_or(0.0, |v| v.im.abs());
    found.sort_by(|a, b| imaginary(b).total_cmp(&imaginary(a)));
    let mut paired = Vec::with_capacity(found.len());
    while !found.is_empty() {
        let first = found.remove(0);
        let Some(value) = first.finite() else {
            paired.push(first);
            continue;
        };
        let miss = |e: &GeneralisedEigenvalue| e.finite().map_or(f64::INFINITY, |v| (v - value.conj()).norm());
        let partner = (0..found.len()).min_by(|&i, &k| miss(&found[i]).total_cmp(&miss(&found[k])));
        match partner.filter(|&k| miss(&found[k]) < 2.0 * value.im.abs()) {
            None => paired.push(GeneralisedEigenvalue { alpha: C64::from(first.alpha.re), ..first }),
            Some(k) => {
                let other = found.remove(k);
                let mean = (value + other.finite().expect("a partner is finite").conj()) * 0.5;
                paired.push(GeneralisedEigenvalue { alpha: mean * first.beta.re, ..first });
                paired.push(GeneralisedEigenvalue { alpha: mean.conj() * first.beta.re, ..first });
            }
        }
    }
    paired
}
