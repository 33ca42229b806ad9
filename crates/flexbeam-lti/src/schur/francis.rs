use std::ops::Range;

use super::Schur;
use super::rotation::standardise;
use crate::{Error, Mat};

/// QR sweeps granted to each eigenvalue before the iteration gives up; LAPACK grants 30, typical use is 3.
const SWEEPS: usize = 60;
/// Every so many sweeps without deflation the shifts are replaced: cyclic matrices stall otherwise.
const EXCEPTIONAL_EVERY: usize = 10;
/// Below this an entry cannot be told from zero by scaled arithmetic.
const TINY: f64 = f64::MIN_POSITIVE / f64::EPSILON;

/// Real Schur form of A by Householder reduction and implicit double-shift QR.
///
/// Source: Francis 1961; deflation as Ahues and Tisseur 1997, which keeps small eigenvalues of graded matrices.
/// Differs from nalgebra's: exceptional shifts, that deflation rule, standard 2 x 2 blocks.
pub(super) fn real_schur(A: &Mat) -> Result<Schur, Error> {
    let mut form = hessenberg(A);
    iterate(&mut form, Wanted::Form)?;
    Ok(form)
}

/// A matrix with the diagonal blocks of the real Schur form of A, the rest of it unfinished: a third of the work.
pub(super) fn eigenvalue_blocks(A: &Mat) -> Result<Mat, Error> {
    let mut form = hessenberg(A);
    form.Q = Mat::zeros(0, A.nrows());
    iterate(&mut form, Wanted::Eigenvalues)?;
    Ok(form.T)
}

/// How far a sweep has to carry its reflections.
#[derive(Clone, Copy, PartialEq)]
enum Wanted {
    Form,
    Eigenvalues,
}

fn iterate(form: &mut Schur, wanted: Wanted) -> Result<(), Error> {
    let mut end = form.T.nrows();
    let mut sweeps = 0;
    while end > 1 {
        let start = active_start(&mut form.T, end);
        match end - start {
            1 => (end, sweeps) = (end - 1, 0),
            2 => {
                standardise(form, start);
                (end, sweeps) = (start, 0);
            }
            _ if sweeps == SWEEPS => return Err(Error::NotConverged { what: "QR iteration", iterations: SWEEPS }),
            _ => {
                sweeps += 1;
                let shifts = Shifts::new(&form.T, start, end, sweeps);
                sweep(form, start, end, &shifts, wanted);
            }
        }
    }
    Ok(())
}

fn hessenberg(A: &Mat) -> Schur {
    let n = A.nrows();
    if n < 3 {
        return Schur { T: A.clone(), Q: Mat::identity(n, n) };
    }
    let (Q, T) = A.clone().hessenberg().unpack();
    Schur { T, Q }
}

/// First row of the last unreduced block of H[..end, ..end]; clears the entry that separates it.
fn active_start(H: &mut Mat, end: usize) -> usize {
    for k in (1..end).rev() {
        if negligible(H, k, end) {
            H[(k, k - 1)] = 0.0;
            return k;
        }
    }
    0
}

/// Whether H(k, k-1) may be dropped without moving an eigenvalue beyond rounding.
fn negligible(H: &Mat, k: usize, end: usize) -> bool {
    let below = H[(k, k - 1)].abs();
    if below <= TINY {
        return true;
    }
    let (h, g) = (H[(k, k)], H[(k - 1, k - 1)]);
    let mut size = h.abs() + g.abs();
    if size == 0.0 {
        size += if k >= 2 { H[(k - 1, k - 2)].abs() } else { 0.0 };
        size += if k + 1 < end { H[(k + 1, k)].abs() } else { 0.0 };
    }
    if below > f64::EPSILON * size {
        return false;
    }
    let above = H[(k - 1, k)].abs();
    let (more, less) = (below.max(above), below.min(above));
    let (wide, narrow) = (h.abs().max((g - h).abs()), h.abs().min((g - h).abs()));
    let sum = wide + more;
    less * (more / sum) <= TINY.max(f64::EPSILON * (narrow * (wide / sum)))
}

/// The two shifts of a sweep: a conjugate pair, or one real number twice.
struct Shifts {
    re: f64,
    im: f64,
}

impl Shifts {
    fn new(H: &Mat, start: usize, end: usize, sweeps: usize) -> Shifts {
        let last = end - 1;
        if sweeps.is_multiple_of(2 * EXCEPTIONAL_EVERY) {
            return Shifts::exceptional(H[(last, last)], H[(last, last - 1)].abs() + H[(last - 1, last - 2)].abs());
        }
        if sweeps.is_multiple_of(EXCEPTIONAL_EVERY) {
            let near = H[(start + 1, start)].abs() + H[(start + 2, start + 1)].abs();
            return Shifts::exceptional(H[(start, start)], near);
        }
        Shifts::of_block(H[(last - 1, last - 1)], H[(last - 1, last)], H[(last, last - 1)], H[(last, last)])
    }

    /// A complex pair off the matrix's symmetry.
    fn exceptional(h: f64, near: f64) -> Shifts {
        Shifts::of_block(h + 0.75 * near, -0.4375 * near, near, h + 0.75 * near)
    }

    fn of_block(a: f64, b: f64, c: f64, d: f64) -> Shifts {
        let size = a.abs() + b.abs() + c.abs() + d.abs();
        if size == 0.0 {
            return Shifts { re: 0.0, im: 0.0 };
        }
        let (mean, p) = (0.5 * (a / size + d / size), 0.5 * (a / size - d / size));
        let square = p * p + (b / size) * (c / size);
        let root = square.abs().sqrt();
        if square < 0.0 {
            return Shifts { re: mean * size, im: root * size };
        }
        // Of two real eigenvalues, the one nearer to the corner.
        let nearer = if p > 0.0 { mean - root } else { mean + root };
        Shifts { re: nearer * size, im: 0.0 }
    }

    /// First column of (H - s1)(H - s2) seen from row m, scaled.
    fn first_column(&self, H: &Mat, m: usize) -> [f64; 3] {
        let (a, d, c) = (H[(m, m)] - self.re, H[(m + 1, m + 1)] - self.re, H[(m + 1, m)]);
        let size = a.abs() + self.im.abs() + c.abs();
        let c = c / size;
        let v = [c * H[(m, m + 1)] + a * (a / size) + self.im * (self.im / size), c * (a + d), c * H[(m + 2, m + 1)]];
        let sum = v[0].abs() + v[1].abs() + v[2].abs();
        if sum == 0.0 { v } else { v.map(|x| x / sum) }
    }
}

/// One implicit double-shift sweep over rows start..end, begun at two consecutive small subdiagonals if there are.
fn sweep(form: &mut Schur, start: usize, end: usize, shifts: &Shifts, wanted: Wanted) {
    let (first_row, last_column) = if wanted == Wanted::Form { (0, form.T.ncols()) } else { (start, end) };
    let (m, column) = sweep_start(&form.T, start, end, shifts);
    for k in m..end - 1 {
        let rows = 3.min(end - k);
        let mut x = column;
        if k > m {
            x = [0.0; 3];
            for (i, x) in x.iter_mut().enumerate().take(rows) {
                *x = form.T[(k + i, k - 1)];
            }
        }
        let (v, tau, beta) = reflector(&x[..rows]);
        if k > m {
            form.T[(k, k - 1)] = beta;
            for i in 1..rows {
                form.T[(k + i, k - 1)] = 0.0;
            }
        } else if m > start {
            form.T[(k, k - 1)] *= 1.0 - tau;
        }
        let rest = first_row..(k + 4).min(end);
        reflect_rows(&mut form.T, k, k..last_column, &v[..rows], tau);
        reflect_columns(&mut form.T, k, rest, &v[..rows], tau);
        let all = 0..form.Q.nrows();
        reflect_columns(&mut form.Q, k, all, &v[..rows], tau);
    }
}

fn sweep_start(H: &Mat, start: usize, end: usize, shifts: &Shifts) -> (usize, [f64; 3]) {
    let mut m = end - 3;
    loop {
        let v = shifts.first_column(H, m);
        if m == start {
            return (m, v);
        }
        let dropped = H[(m, m - 1)].abs() * (v[1].abs() + v[2].abs());
        let kept = v[0].abs() * (H[(m - 1, m - 1)].abs() + H[(m, m)].abs() + H[(m + 1, m + 1)].abs());
        if dropped <= f64::EPSILON * kept {
            return (m, v);
        }
        m -= 1;
    }
}

/// (v, tau, beta) with (I - tau v v') x = beta e1, v(1) = 1.
fn reflector(x: &[f64]) -> ([f64; 3], f64, f64) {
    let mut v = [1.0, 0.0, 0.0];
    let tail = x[1..].iter().fold(0f64, |norm, x| norm.hypot(*x));
    if tail == 0.0 {
        return (v, 0.0, x[0]);
    }
    let beta = -x[0].hypot(tail).copysign(x[0]);
    for (v, x_i) in v.iter_mut().zip(x).skip(1) {
        *v = x_i / (x[0] - beta);
    }
    (v, (beta - x[0]) / beta, beta)
}

/// M <- (I - tau v v') M in the given columns, v starting at row k.
fn reflect_rows(M: &mut Mat, k: usize, columns: Range<usize>, v: &[f64], tau: f64) {
    for j in columns {
        let sum: f64 = tau * v.iter().enumerate().map(|(i, v)| v * M[(k + i, j)]).sum::<f64>();
        for (i, v) in v.iter().enumerate() {
            M[(k + i, j)] -= sum * v;
        }
    }
}

/// M <- M (I - tau v v') in the given rows, v starting at column k.
fn reflect_columns(M: &mut Mat, k: usize, rows: Range<usize>, v: &[f64], tau: f64) {
    for i in rows {
        let sum: f64 = tau * v.iter().enumerate().map(|(j, v)| v * M[(i, k + j)]).sum::<f64>();
        for (j, v) in v.iter().enumerate() {
            M[(i, k + j)] -= sum * v;
        }
    }
}
