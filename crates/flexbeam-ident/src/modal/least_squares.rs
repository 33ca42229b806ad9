//! Least squares of the simulated output on the recorded one, in modal coordinates.
//!
//! Enters: A, C, what is known of the rest, a recording. Leaves: the rest, and what it misses. Deliberately absent: one-step prediction.

use flexbeam_lti::{Mat, Vector};

use super::modes::Modes;
use super::responses::Responses;
use super::shape::Shape;
use crate::correlation::Channels;

/// How far a mode may grow within the record: beyond this, what earlier samples say drowns.
const LARGEST_GROWTH: f64 = 1e6;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::white_gaussian;
    use crate::identify::Feedthrough;
    use crate::output_map::{Unknowns, input_matrices};

    /// A pair, a slow mode, an integrator; two inputs, two outputs with an offset each.
    fn system() -> [Mat; 4] {
        #[rustfmt::skip]
        let A = Mat::from_row_slice(4, 4, &[
            0.7, 0.5, 0.1, 0.0,
            -0.5, 0.7, 0.0, 0.2,
            0.0, 0.0, 0.98, 0.0,
            0.0, 0.0, 0.0, 1.0,
        ]);
        let mix = |r: usize, c: usize| (((r + 1) * (c + 2)) as f64).sin();
        [A, Mat::from_fn(4, 2, mix), Mat::from_fn(2, 4, |r, c| mix(c, r + 1)), Mat::from_fn(2, 2, mix)]
    }

    fn problem<'a>(A: &'a Mat, C: &'a Mat, U: &'a Mat, Y: &'a Mat) -> Problem<'a> {
        Problem {
            A,
            C,
            B: Mat::zeros(A.nrows(), 2),
            D: Mat::zeros(2, 2),
            offset: Vector::zeros(2),
            channels: Channels::of_rows(U).beside(Channels::of_rows(Y)),
            mean: &[0.0; 4],
            scale: &[1.0; 4],
            threads: 1,
        }
    }

    fn record(samples: usize, noise: f64) -> (Mat, Mat) {
        let [A, B, C, D] = system();
        let (white, e) =
            (white_gaussian(2 * samples, 1.0, 9.0, 3), white_gaussian(2 * samples, noise.max(1e-300), 9.0, 4));
        let U = Mat::from_column_slice(2, samples, &white);
        let mut x = Vector::from_column_slice(&[1.0, -1.0, 2.0, 0.5]);
        let mut Y = Mat::zeros(2, samples);
        for k in 0..samples {
            let u = U.column(k).into_owned();
            Y.set_column(k, &(&C * &x + &D * &u + Vector::from_column_slice(&[3.0 + e[2 * k], -7.0 + e[2 * k + 1]])));
            x = &A * x + &B * u;
        }
        (U, Y)
    }

    #[test]
    fn everything_is_recovered_across_parts() {
        let (U, Y) = record(40_000, 0.0);
        let [A, B, C, D] = system();
        let problem = Problem { offset: Vector::from_column_slice(&[3.0, -7.0]), ..problem(&A, &C, &U, &Y) };
        let found = problem.solve(Free { B: true, D: true, offset: false }).unwrap();
        let errors = [(found.B - B).norm(), (found.D - D).norm()];
        assert!(errors.iter().all(|e| *e < 1e-11), "{errors:?}");
        assert!((found.initial_state - Vector::from_column_slice(&[1.0, -1.0, 2.0, 0.5])).norm() < 1e-10);
        assert!(found.missed.iter().zip(&found.moved).all(|(a, b)| *a < 1e-22 * b), "{:?}", found.missed);
    }

    /// Against a dense QR of the very same columns, by the general routine; noise, so that the solution is one of many.
    #[test]
    fn noisy_solutions_are_those_of_a_qr_and_threads_change_no_bit() {
        let (U, Y) = record(36_000, 0.3);
        let Y = Mat::from_fn(2, 36_000, |p, k| Y[(p, k)] - [3.0, -7.0][p]);
        let [A, _, C, _] = system();
        let unknowns = Unknowns { feedthrough: Feedthrough::Free, offset: false };
        let wanted = input_matrices(&A, &C, &U.transpose(), &Y.transpose(), unknowns);
        let solve = |threads| {
            let problem = Problem { threads, ..problem(&A, &C, &U, &Y) };
            problem.solve(Free { B: true, D: true, offset: false }).unwrap()
        };
        let (found, shared) = (solve(1), solve(3));
        assert!((&found.B - wanted.B).norm() < 1e-9 && (&found.D - wanted.D).norm() < 1e-9);
        assert!((&found.initial_state - wanted.initial_state).norm() < 1e-7);
        assert_eq!((found.B, found.D, found.missed), (shared.B, shared.D, shared.missed));
    }

    #[test]
    fn what_is_not_determined_or_grows_is_left_to_others() {
        let (U, Y) = record(4000, 0.0);
        let [A, _, C, _] = system();
        let solve = |A: &Mat, U: &Mat| problem(A, &C, U, &Y).solve(Free { B: true, D: true, offset: false });
        assert!(solve(&A, &U).is_some());
        assert!(solve(&(&A * 1.02), &U).is_none(), "1.02^4000 = 10^34");
        assert!(solve(&A, &Mat::from_fn(2, 4000, |_, k| U[(0, k)])).is_none(), "one input twice");
    }

    #[test]
    fn offsets_are_found_beside_modes_that_fade() {
        // Without the integrator: an offset and its x(0) are nearly the same thing.
        let (U, _) = record(3000, 0.0);
        let [A, B, C, D] = system();
        let (A, B, C) = (A.remove_row(3).remove_column(3), B.remove_row(3), C.remove_column(3));
        let mut x = Vector::from_column_slice(&[1.0, -1.0, 2.0]);
        let mut Y = Mat::zeros(2, 3000);
        for k in 0..3000 {
            let u = U.column(k).into_owned();
            Y.set_column(k, &(&C * &x + &D * &u + Vector::from_column_slice(&[3.0, -7.0])));
            x = &A * x + &B * u;
        }
        let found = problem(&A, &C, &U, &Y).solve(Free { B: true, D: true, offset: true }).unwrap();
        assert!((found.offset - Vector::from_column_slice(&[3.0, -7.0])).norm() < 1e-9);
        assert!((found.B - B).norm() < 1e-9);
    }
}
