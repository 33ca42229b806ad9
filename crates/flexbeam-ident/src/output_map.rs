//! The output of x(k+1) = A x(k) + B u(k), y = C x + D u + d as a linear map of B, D, x(0) and the offset d.
//!
//! Enters: A, C, inputs, outputs, what is known. Leaves: the B, D, x(0), d whose simulated output is nearest to the recorded one.
//! Deliberately absent: one-step prediction.

use flexbeam_lti::{Mat, Vector, schur};

use crate::identify::Feedthrough;
use crate::singular::basic_solution;
use crate::triangle::{CHUNK_ROWS, Triangle};

/// How far a response may grow within a stretch: beyond this, what earlier samples say about x(0) drowns.
const LARGEST_GROWTH: f64 = 1e6;
/// A combination of unknowns that moves the output by less than this part of the strongest is not determined by the data.
const UNKNOWN_RANK: f64 = 1e-14;

/// A response below this is nothing beside any other.
const FADED: f64 = 1e-200;

/// What is unknown beside B and x(0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Unknowns {
    /// D; zero where it is known to be.
    pub feedthrough: Feedthrough,
    /// A constant added to each output: the mean of a finite record is not the rest position. Zero where it is not asked for.
    pub offset: bool,
}

/// B, D, the outputs' offsets and the initial state.
pub(crate) struct InputMatrices {
    pub B: Mat,
    pub D: Mat,
    pub offset: Vector,
    pub initial_state: Vector,
}

/// Least squares of the simulated output on the recorded one, A and C given.
///
/// Shapes: U s x m, Y s x l.
/// Numerics: the responses to every entry of B come from the dual system: C_p (zI - A)^-1 e_r u_c is component r of the state of
/// (A', C_p') driven by u_c, so lm simulations serve all n m l of them. QR in chunks, memory independent of s.
/// A with a pole outside the unit circle is kept as it is: the record is cut into stretches in which no response grows by more
/// than 10^6, each with a free initial state, which the QR of that stretch eliminates.
/// Source: McKelvey, Akcay and Ljung 1996 for the least squares; SLICOT IB01CD solves the same problem.
pub(crate) fn input_matrices(A: &Mat, C: &Mat, U: &Mat, Y: &Mat, unknowns: Unknowns) -> InputMatrices {
    let (n, m, l) = (A.nrows(), U.ncols(), C.nrows());
    // The offset is the feedthrough of an input that is one.
    let driven = if unknowns.offset { U.clone().insert_column(m, 1.0) } else { U.clone() };
    let columns = columns(n, m, l, unknowns);
    let stretch = stretch(A, U.nrows());
    let mut shared = Triangle::new(columns.len() - n);
    let mut first = None;
    for start in (0..U.nrows()).step_by(stretch) {
        let width = stretch.min(U.nrows() - start);
        let all = responses(A, C, &driven.rows(start, width).into_owned(), &Y.rows(start, width).into_owned());
        let mut part = Triangle::new(columns.len());
        part.absorb(&mut all.select_columns(&columns));
        shared.absorb(&mut part.R.view((n, n), (columns.len() - n, columns.len() - n)).into_owned());
        first.get_or_insert(part.R);
    }
    let top = first.expect("a record has samples").rows(0, n).into_owned();
    let known = solved(&shared.R);
    let rest = top.column(top.ncols() - 1) - top.columns(n, known.len()) * &known;
    let mut initial = top.columns(0, n).insert_column(n, 0.0);
    initial.set_column(n, &rest);
    let (B, rest) = known.as_slice().split_at(n * m);
    let feedthrough = if unknowns.feedthrough == Feedthrough::Free { l * m } else { 0 };
    let (D, offset) = rest.split_at(feedthrough);
    InputMatrices {
        B: Mat::from_column_slice(n, m, B),
        D: Mat::from_fn(l, m, |r, c| D.get(c * l + r).copied().unwrap_or(0.0)),
        offset: Vector::from_fn(l, |p, _| offset.get(p).copied().unwrap_or(0.0)),
        initial_state: solved(&initial),
    }
}

/// Columns of [x(0) | B | D | y] that belong to unknowns, and y; with an offset, B and D have a last column for the input one.
fn columns(n: usize, m: usize, l: usize, unknowns: Unknowns) -> Vec<usize> {
    let driven = m + usize::from(unknowns.offset);
    let D = n + n * driven;
    let mut columns: Vec<usize> = (0..n + n * m).collect();
    if unknowns.feedthrough == Feedthrough::Free {
        columns.extend(D..D + l * m);
    }
    columns.extend(D + l * m..=D + l * driven);
    columns
}

/// x(0) whose response is nearest to Y, the forced response taken away already.
pub(crate) fn initial_state(A: &Mat, C: &Mat, Y: &Mat) -> Vector {
    let nothing = Mat::zeros(Y.nrows(), 0);
    solved(&responses(A, C, &nothing, Y))
}

/// Triangular factor of [x(0) | B | D | y] over one stretch.
fn responses(A: &Mat, C: &Mat, U: &Mat, Y: &Mat) -> Mat {
    let (n, m, l, s) = (A.nrows(), U.ncols(), C.nrows(), U.nrows());
    let columns = n + n * m + l * m + 1;
    let mut triangle = Triangle::new(columns);
    let mut dual = DualStates::new(A, C, m);
    for first in (0..s).step_by(CHUNK_ROWS) {
        let width = CHUNK_ROWS.min(s - first);
        let mut chunk = Mat::zeros(width * l, columns);
        for k in 0..width {
            for p in 0..l {
                let row = k * l + p;
                for (c, value) in dual.of_output(p).iter().enumerate() {
                    chunk[(row, c)] = *value;
                }
                for c in 0..m {
                    chunk[(row, n + n * m + c * l + p)] = U[(first + k, c)];
                }
                chunk[(row, columns - 1)] = Y[(first + k, p)];
            }
            dual.advance((0..m).map(|c| U[(first + k, c)]));
        }
        triangle.absorb(&mut chunk);
    }
    triangle.R
}

/// States of (A', C_p'): undriven from C_p', and at rest driven by each input.
struct DualStates {
    A: Mat,
    C_t: Mat,
    /// n x l(1 + m), for each output: undriven, then one column an input.
    states: Mat,
    next: Mat,
}

impl DualStates {
    fn new(A: &Mat, C: &Mat, m: usize) -> DualStates {
        let (n, l) = (A.nrows(), C.nrows());
        let mut states = Mat::zeros(n, l * (1 + m));
        (0..l).for_each(|p| states.set_column(p * (1 + m), &C.row(p).transpose()));
        DualStates { A: A.clone(), C_t: C.transpose(), next: states.clone(), states }
    }

    /// [C_p A^k | responses to u_1 | .. | responses to u_m], n each.
    fn of_output(&self, p: usize) -> &[f64] {
        let size = self.states.len() / self.C_t.ncols();
        &self.states.as_slice()[p * size..(p + 1) * size]
    }

    fn advance(&mut self, inputs: impl Iterator<Item = f64> + Clone) {
        let (n, columns) = self.states.shape();
        let per_output = columns / self.C_t.ncols();
        let A = self.A.as_slice();
        // What has faded would go on as subnormal numbers, a hundred times slower.
        for mut undriven in self.states.column_iter_mut().step_by(columns / self.C_t.ncols()) {
            if undriven.amax() < FADED {
                undriven.fill(0.0);
            }
        }
        for (column, (x, next)) in
            self.states.as_slice().chunks_exact(n).zip(self.next.as_mut_slice().chunks_exact_mut(n)).enumerate()
        {
            // Component r of A' x is column r of A times x.
            for (a, y) in A.chunks_exact(n).zip(next.iter_mut()) {
                *y = a.iter().zip(x).map(|(a, x)| a * x).sum();
            }
            let (p, c) = (column / per_output, column % per_output);
            if c > 0 {
                let u = inputs.clone().nth(c - 1).expect("one value an input");
                self.C_t.column(p).iter().zip(next.iter_mut()).for_each(|(c, y)| *y += c * u);
            }
        }
        std::mem::swap(&mut self.states, &mut self.next);
    }
}

/// Samples in which no response of A grows by more than [`LARGEST_GROWTH`], at least as many as x(0) and some equations need.
fn stretch(A: &Mat, s: usize) -> usize {
    let poles = schur::spectrum(A).unwrap_or_default();
    let radius = poles.iter().map(|z| z.norm()).fold(0.0, f64::max);
    let limit = LARGEST_GROWTH.ln() / radius.ln().max(f64::MIN_POSITIVE);
    let least = 4 * (A.nrows() + 1);
    (limit.min(s as f64) as usize).max(least).min(s.max(1))
}

/// Solution of R x = r, R and r the columns of a triangular factor; unknowns scaled to columns of unit norm.
fn solved(factor: &Mat) -> Vector {
    let n = factor.ncols() - 1;
    let mut R = factor.columns(0, n).into_owned();
    let norms: Vec<f64> = R.column_iter().map(|c| if c.norm() > 0.0 { c.norm() } else { 1.0 }).collect();
    norms.iter().enumerate().for_each(|(c, norm)| R.column_mut(c).unscale_mut(*norm));
    let x = basic_solution(&R, &factor.columns(n, 1).into_owned(), UNKNOWN_RANK);
    Vector::from_fn(n, |c, _| x[c] / norms[c])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::white_gaussian;

    struct Case {
        A: Mat,
        B: Mat,
        C: Mat,
        D: Mat,
    }

    impl Case {
        /// Two inputs, two outputs, the first pole at `pole`.
        fn new(pole: f64) -> Case {
            let mix = |r: usize, c: usize| (((r + 1) * (c + 2)) as f64).sin();
            #[rustfmt::skip]
            let A = Mat::from_row_slice(3, 3, &[
                pole, 0.2, 0.0,
                0.0, 0.7, 0.5,
                0.0, -0.5, 0.7,
            ]);
            Case {
                A,
                B: Mat::from_fn(3, 2, mix),
                C: Mat::from_fn(2, 3, |r, c| mix(c, r + 1)),
                D: Mat::from_fn(2, 2, mix),
            }
        }

        /// Record of the loop u = white - K x, which keeps an unstable pole's state bounded.
        fn record(&self, K: &Mat, x0: &Vector, s: usize) -> (Mat, Mat) {
            let white = white_gaussian(2 * s, 1.0, 9.0, 8);
            let (mut U, mut Y, mut x) = (Mat::zeros(s, 2), Mat::zeros(s, 2), x0.clone());
            for k in 0..s {
                let u = Vector::from_column_slice(&white[2 * k..2 * k + 2]) - K * &x;
                let y = &self.C * &x + &self.D * &u;
                U.set_row(k, &u.transpose());
                Y.set_row(k, &y.transpose());
                x = &self.A * &x + &self.B * &u;
            }
            (U, Y)
        }

        fn expect_recovered(&self, K: &Mat, tolerance: f64) {
            let x0 = Vector::from_column_slice(&[1.0, -2.0, 0.5]);
            let (U, Y) = self.record(K, &x0, 3000);
            assert!(Y.amax() < 1e3, "the loop must be stable: {:e}", Y.amax());
            for (feedthrough, offset) in [
                (Feedthrough::Free, 0.0),
                (Feedthrough::Free, 0.7),
                (Feedthrough::Zero, 0.0),
                (Feedthrough::Zero, -3.0),
            ] {
                let known = feedthrough == Feedthrough::Zero;
                let D = if known { Mat::zeros(2, 2) } else { self.D.clone() };
                let Y = if known { &Y - &U * self.D.transpose() } else { Y.clone() }.add_scalar(offset);
                let unknowns = Unknowns { feedthrough, offset: offset != 0.0 };
                let found = input_matrices(&self.A, &self.C, &U, &Y, unknowns);
                let mut errors =
                    vec![(found.B - &self.B).norm(), (found.D - D).norm(), found.offset.add_scalar(-offset).norm()];
                errors.push((found.initial_state - &x0).norm());
                // An integrator's state takes what it likes of an offset.
                if offset != 0.0 && self.A[(0, 0)] == 1.0 {
                    errors.truncate(2);
                }
                assert!(errors.iter().all(|e| *e < tolerance), "{feedthrough:?}, offset {offset}: {errors:?}");
            }
        }
    }

    #[test]
    fn stable_and_integrating_systems_are_recovered() {
        for pole in [0.9, 1.0] {
            let case = Case::new(pole);
            let K =
                if pole < 1.0 { Mat::zeros(2, 3) } else { Mat::from_row_slice(2, 3, &[0.3, 0.0, 0.0, 0.0, 0.0, 0.0]) };
            case.expect_recovered(&K, 1e-11);
        }
    }

    /// 1.1^3000 = 10^124: one stretch could not hold it.
    #[test]
    fn an_unstable_pole_is_kept_and_answered_in_stretches() {
        let case = Case::new(1.1);
        let K = Mat::from_row_slice(2, 3, &[0.5, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert!(stretch(&case.A, 3000) < 200);
        case.expect_recovered(&K, 1e-8);
    }
}
