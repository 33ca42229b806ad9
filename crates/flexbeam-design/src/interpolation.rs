//! Nevanlinna-Pick interpolation with one optional derivative condition.
//!
//! Enters: points in Re s > 0, values, a derivative. Leaves: the smallest norm of a stable function that takes them, and
//! the all-pass function that reaches it.

use flexbeam_lti::{C64, CMat, Zpk};

use crate::Error;

/// F(p_i) = w_i, and optionally F'(p_r) = w_r', for a stable F that is real on the real axis.
#[derive(Clone, Debug)]
pub struct Interpolation {
    points: Vec<C64>,
    values: Vec<C64>,
    derivative: Option<Derivative>,
}

#[derive(Clone, Copy, Debug)]
struct Derivative {
    index: usize,
    value: C64,
}

/// A stable function that meets the conditions.
#[derive(Clone, Debug)]
pub struct Interpolant {
    /// A bound on sup |F(jw)|: reached at every w by the optimal one, nowhere by the central one.
    pub norm: f64,
    /// F itself, stable; constant when there is one value condition.
    pub function: Zpk,
    /// Largest relative error in the conditions, recomputed from `function`.
    pub residual: f64,
}

impl Interpolation {
    /// F(p_i) = w_i. Points that are not real come in conjugate pairs, with conjugate values.
    ///
    /// Errors: [`Error::RepeatedPole`] when two points coincide to working precision: the value conditions then contradict
    /// or repeat each other, and a derivative condition would be needed.
    pub fn new(points: Vec<C64>, values: Vec<C64>) -> Result<Interpolation, Error> {
        for (k, p) in points.iter().enumerate() {
            if let Some(q) = points[..k].iter().find(|q| (**q - p).norm() <= COINCIDENT * p.norm()) {
                return Err(Error::RepeatedPole { re: q.re, im: q.im });
            }
        }
        Ok(Interpolation { points, values, derivative: None })
    }

    /// w_i.
    pub fn value(&self, index: usize) -> C64 {
        self.values[index]
    }

    /// Adds F'(p_index) = value; p_index is real.
    #[must_use]
    pub fn with_derivative(mut self, index: usize, value: f64) -> Interpolation {
        self.derivative = Some(Derivative { index, value: value.into() });
        self
    }

    /// The interpolant of smallest norm.
    ///
    /// With the conditions written as F(A) b = c, L and M the solutions of A L + L A* = b b* and A M + M A* = c c*, the
    /// smallest norm squared is the largest eigenvalue of M v = g^2 L v, and
    /// F(s) = g^2 b* (s I + A*)^-1 v / c* (s I + A*)^-1 v, which is all-pass.
    ///
    /// Errors: [`Error::PickNotDefinite`] when L is singular to working precision (points too close together).
    /// Numerics: O(n^3). L is a Cauchy matrix: its condition grows as points come close; `residual` tells.
    /// Source: Nevanlinna-Pick in the form of Kimura 1984; the eigenvector form is derived in the book, "The radius, two ways".
    pub fn optimal(&self) -> Result<Interpolant, Error> {
        if self.points.is_empty() {
            let nothing = Zpk { zeros: vec![], poles: vec![], gain: 0.0 };
            return Ok(Interpolant { norm: 0.0, function: nothing, residual: 0.0 });
        }
        let data = self.matrices();
        let L = lyapunov_bidiagonal(&data.A, &data.b);
        let M = lyapunov_bidiagonal(&data.A, &data.c);
        let (norm_squared, v) = largest_generalised_eigenpair(&M, &L)?;
        let norm = norm_squared.max(0.0).sqrt();
        let poles = conjugate_symmetric(zeros_of_strictly_proper(&data.A, &v, &data.c));
        let function = self.all_pass(norm, poles)?;
        let residual = self.residual(&function);
        Ok(Interpolant { norm, function, residual })
    }

    /// The central interpolant below one: among all with sup |F| < 1 the one of largest entropy at the real point p_index.
    ///
    /// With A P + P A* = b b* - c c*, N(s) = e - b* (s I + A*)^-1 x and D(s) = 1 - c* (s I + A*)^-1 x, x = P^-1 (b e - c),
    /// every constant |e| < 1 gives an interpolant N/D. The e of largest entropy at q is the one with which Theta_21(q)
    /// vanishes; N and D then share the zero -q, and the degree is one less than the number of conditions. It is what the
    /// Schur algorithm gives when it ends at p_index with a constant.
    ///
    /// Errors: [`Error::PickNotDefinite`] when no interpolant stays below one.
    /// Source: derived in the book, "Stiffness".
    pub fn central(&self, index: usize) -> Result<Interpolant, Error> {
        let Matrices { A, b, c } = self.matrices();
        let P = lyapunov_bidiagonal(&A, &b) - lyapunov_bidiagonal(&A, &c);
        let singular = Error::PickNotDefinite { points: self.points.len(), pivot: 0.0 };
        let factor = P.cholesky().ok_or(singular)?;
        let q = self.points[index];
        let pencil = (CMat::from_diagonal_element(A.nrows(), A.nrows(), q) + A.adjoint()).adjoint();
        let reading = pencil.lu().solve(&c).expect("the eigenvalues of A lie in Re s > 0").adjoint();
        let theta_21 = -(&reading * factor.solve(&b))[0];
        let theta_22 = (&reading * factor.solve(&c))[0] + 1.0;
        let e = C64::from(-(theta_21 / theta_22).re);
        let x = factor.solve(&(&b * e - &c));
        let poles = without(eigenvalues(-A.adjoint() + &x * c.adjoint()), -q);
        let zeros = without(eigenvalues(-A.adjoint() + &x * b.adjoint() / e), -q);
        let function = Zpk { zeros: conjugate_symmetric(zeros), poles: conjugate_symmetric(poles), gain: e.re };
        let residual = self.residual(&function);
        Ok(Interpolant { norm: 1.0, function, residual })
    }

    /// F = sign norm prod (s + conj q)/(s - q), the sign from the first condition.
    fn all_pass(&self, norm: f64, poles: Vec<C64>) -> Result<Zpk, Error> {
        if let Some(q) = poles.iter().find(|q| !(q.re < 0.0)) {
            return Err(Error::PickNotDefinite { points: self.points.len(), pivot: q.re });
        }
        let zeros = poles.iter().map(|q| -q.conj()).collect();
        let mut function = Zpk { zeros, poles, gain: norm };
        if (function.at(self.points[0]) / self.values[0]).re < 0.0 {
            function.gain = -norm;
        }
        Ok(function)
    }

    fn residual(&self, F: &Zpk) -> f64 {
        let values = self.points.iter().zip(&self.values).map(|(p, w)| (F.at(*p) - w).norm() / w.norm());
        let slope = self.derivative.iter().map(|d| {
            let p = self.points[d.index];
            let scale = d.value.norm().max(self.values[d.index].norm() / p.norm());
            (F.at(p) * F.logarithmic_derivative(p) - d.value).norm() / scale
        });
        values.chain(slope).fold(0.0, f64::max)
    }

    /// F(A) b = c: A diagonal, with a Jordan block [p 0; 1 p] where the derivative is prescribed.
    fn matrices(&self) -> Matrices {
        let n = self.points.len();
        let size = n + usize::from(self.derivative.is_some());
        let mut A = CMat::zeros(size, size);
        let mut b = CMat::zeros(size, 1);
        let mut c = CMat::zeros(size, 1);
        for k in 0..n {
            A[(k, k)] = self.points[k];
            b[k] = C64::new(1.0, 0.0);
            c[k] = self.values[k];
        }
        if let Some(d) = self.derivative {
            A[(n, n)] = self.points[d.index];
            A[(n, d.index)] = C64::new(1.0, 0.0);
            c[n] = d.value;
        }
        Matrices { A, b, c }
    }
}

/// Points nearer to each other than this, relative to their size, count as one: the Pick matrix loses all digits there.
const COINCIDENT: f64 = 1e-10;

struct Matrices {
    A: CMat,
    b: CMat,
    c: CMat,
}

/// A X + X A* = b b* for a lower bidiagonal A, by forward substitution.
fn lyapunov_bidiagonal(A: &CMat, b: &CMat) -> CMat {
    let n = A.nrows();
    let mut X = CMat::zeros(n, n);
    for i in 0..n {
        for j in 0..n {
            let mut right = b[i] * b[j].conj();
            for k in 0..i {
                right -= A[(i, k)] * X[(k, j)];
            }
            for k in 0..j {
                right -= X[(i, k)] * A[(j, k)].conj();
            }
            X[(i, j)] = right / (A[(i, i)] + A[(j, j)].conj());
        }
    }
    X
}

/// The largest g with M v = g L v, and v; L positive definite.
fn largest_generalised_eigenpair(M: &CMat, L: &CMat) -> Result<(f64, CMat), Error> {
    let n = L.nrows();
    // Equilibrate: the Cholesky factor of a matrix with unit diagonal breaks down at the true condition only.
    let scale: Vec<f64> = (0..n).map(|k| 1.0 / L[(k, k)].re.sqrt()).collect();
    let scaled = |X: &CMat| CMat::from_fn(n, n, |i, j| X[(i, j)] * scale[i] * scale[j]);
    let R = scaled(L).cholesky().ok_or(Error::PickNotDefinite { points: n, pivot: 0.0 })?.l();
    let half = R.solve_lower_triangular(&scaled(M)).expect("a Cholesky factor has a nonzero diagonal");
    let whole = R.solve_lower_triangular(&half.adjoint()).expect("a Cholesky factor has a nonzero diagonal");
    let eigen = ((&whole + whole.adjoint()) * C64::new(0.5, 0.0)).symmetric_eigen();
    let best = eigen.eigenvalues.imax();
    let y = eigen.eigenvectors.columns(best, 1).into_owned();
    let mut v = R.adjoint().solve_upper_triangular(&y).expect("a Cholesky factor has a nonzero diagonal");
    for k in 0..n {
        v[k] *= C64::from(scale[k]);
    }
    Ok((eigen.eigenvalues[best], v))
}

/// Zeros of c* (s I + A*)^-1 v, which has relative degree one: the pencil -A* - s I seen from the complements of v and c.
fn zeros_of_strictly_proper(A: &CMat, v: &CMat, c: &CMat) -> Vec<C64> {
    let left = complement(v);
    let right = complement(c);
    let pencil_s = left.adjoint() * &right;
    let pencil_1 = left.adjoint() * (-A.adjoint()) * &right;
    let dynamics = pencil_s.lu().solve(&pencil_1);
    dynamics.map_or_else(Vec::new, eigenvalues)
}

fn eigenvalues(A: CMat) -> Vec<C64> {
    A.schur().unpack().1.diagonal().iter().copied().collect()
}

/// All roots but the nearest to `root`.
fn without(mut roots: Vec<C64>, root: C64) -> Vec<C64> {
    let distance = |k: &usize| (roots[*k] - root).norm();
    if let Some(k) = (0..roots.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))) {
        roots.swap_remove(k);
    }
    roots
}

/// Orthonormal basis of what is orthogonal to x, from one Householder reflection.
fn complement(x: &CMat) -> CMat {
    let n = x.nrows();
    let phase = if x[0].norm() == 0.0 { C64::new(1.0, 0.0) } else { x[0] / x[0].norm() };
    let mut u = x / C64::from(x.norm());
    u[0] += phase;
    let length = u.norm_squared();
    let reflection = CMat::identity(n, n) - &u * u.adjoint() * C64::from(2.0 / length);
    reflection.columns(1, n - 1).into_owned()
}

/// Rounds a set that is closed under conjugation in exact arithmetic to one that is so in floating point.
fn conjugate_symmetric(roots: Vec<C64>) -> Vec<C64> {
    let mut left = roots;
    let mut symmetric = Vec::with_capacity(left.len());
    while let Some(q) = left.pop() {
        let partner = (0..left.len()).min_by(|a, b| {
            let distance = |k: &usize| (left[*k] - q.conj()).norm();
            distance(a).total_cmp(&distance(b))
        });
        match partner {
            Some(k) if (left[k] - q.conj()).norm() < 2.0 * q.im.abs() => {
                let mean = (q + left.swap_remove(k).conj()) * 0.5;
                symmetric.extend([mean, mean.conj()]);
            }
            _ => symmetric.push(C64::new(q.re, 0.0)),
        }
    }
    symmetric
}
