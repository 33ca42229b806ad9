//! Poles from the lagged correlations against poles from a dense QR, where squaring would hurt most.

use flexbeam_lti::{C64, Mat, StateSpace, Time, Vector, sampling, simulation};
use flexbeam_rig::{Lumped, Output};

use super::factor::Factor;
use crate::correlation::{Channels, Record, fast_gram};
use crate::excitation::white_gaussian;
use crate::identify::Weighting;
use crate::projection::directions;
use crate::subspace;

/// A recording and the poles that it should give.
struct Case {
    name: &'static str,
    U: Mat,
    Y: Mat,
    i: usize,
    constant: bool,
    poles: Vec<C64>,
}

/// Poles within a rounding error are not told apart.
const FLOOR: f64 = 1e-14;

fn sorted(A: &Mat) -> Vec<C64> {
    let mut poles: Vec<C64> = A.complex_eigenvalues().iter().copied().collect();
    poles.sort_by(|a, b| a.im.total_cmp(&b.im).then(a.re.total_cmp(&b.re)));
    poles
}

impl Case {
    /// White input, x(0) = 0.3, noise of a part of each output's rms.
    fn new(name: &'static str, plant: &StateSpace, i: usize, samples: usize, noise: f64) -> Case {
        let m = plant.inputs();
        let U = Mat::from_column_slice(m, samples, &white_gaussian(m * samples, 1.0, 9.0, 1));
        let mut Y = simulation::simulate(plant, &U, &Vector::from_element(plant.order(), 0.3)).unwrap();
        for p in 0..Y.nrows() {
            let rms = Y.row(p).norm() / (samples as f64).sqrt();
            let e = white_gaussian(samples, 1.0, f64::INFINITY, 50 + p as u64);
            (0..samples).for_each(|k| Y[(p, k)] += noise * rms * e[k]);
        }
        Case { name, U: U.transpose(), Y: Y.transpose(), i, constant: false, poles: sorted(&plant.A) }
    }

    fn pole_error(&self, factor: &Factor) -> f64 {
        let gamma = subspace::gamma(&directions(factor, Weighting::Moesp), self.poles.len());
        let (A, _) = subspace::shift(&gamma, factor.l).expect("a state");
        let each = sorted(&A);
        each.iter().zip(&self.poles).map(|(a, b)| (a - b).norm() / b.norm()).fold(0.0, f64::max)
    }

    /// Errors of the dense QR, of the exact correlations, and of the plain ones where they are offered.
    fn errors(&self) -> (f64, f64, Option<f64>) {
        let m = self.U.ncols();
        let channels = Channels::of_columns(&self.U).beside(Channels::of_columns(&self.Y));
        let mut record = Record::new(channels.count(), self.i);
        record.absorb(&channels, 1).unwrap();
        let of = |gram: crate::correlation::Gram| {
            let gram = if self.constant { gram } else { gram.about(&vec![0.0; gram.channels()]) };
            let scale: Vec<f64> = gram.rms().iter().zip(gram.exponents()).map(|(rms, e)| rms * 2f64.powi(*e)).collect();
            self.pole_error(&Factor::of_gram(&gram, m, &scale, self.constant))
        };
        let rms = |M: &Mat| {
            Mat::from_fn(M.nrows(), M.ncols(), |k, c| M[(k, c)] / (M.column(c).norm() / (M.nrows() as f64).sqrt()))
        };
        let dense = self.pole_error(&Factor::dense(&rms(&self.U), &rms(&self.Y), self.i, self.constant));
        (dense, of(record.finish()), fast_gram(&channels, self.i, 1).map(of))
    }

    fn expect_as_good_as_a_dense_qr(&self) -> Option<f64> {
        let (dense, exact, fast) = self.errors();
        println!("{}: dense QR {dense:.1e}, exact {exact:.1e}, plain {fast:?}", self.name);
        assert!(exact <= 3.0 * dense + FLOOR, "{}: {exact:e} against {dense:e}", self.name);
        if let Some(fast) = fast {
            assert!(fast <= 3.0 * dense + FLOOR, "{}: {fast:e} against {dense:e}", self.name);
        }
        fast
    }
}

/// alpha of the paper's plant, minimal: three states.
fn deflection(period_s: f64) -> StateSpace {
    let plant = Lumped::PAPER.state_space(&[Output::Alpha]).unwrap();
    let reduced = StateSpace::new(
        plant.A.remove_row(0).remove_column(0),
        plant.B.remove_row(0),
        plant.C.remove_column(0),
        plant.D.clone(),
        Time::Continuous,
    );
    sampling::zoh(&reduced.unwrap(), period_s).unwrap()
}

/// Both sides of the choice of precision: noise drowns the rounding of plain sums, or plain sums are not offered.
#[test]
fn noise_from_a_thousandth_to_none() {
    for (noise, plain) in [(1e-2, true), (1e-3, true), (1e-6, false), (1e-9, false), (0.0, false)] {
        let case = Case::new("noise", &deflection(0.005), 15, 10_000, noise);
        assert_eq!(case.expect_as_good_as_a_dense_qr().is_some(), plain, "noise {noise:e}");
    }
}

#[test]
fn an_offset_of_a_million() {
    for noise in [1e-3, 0.0] {
        let mut case = Case::new("offset of 10^6", &deflection(0.005), 15, 10_000, noise);
        let rms = case.Y.norm() / (case.Y.len() as f64).sqrt();
        case.U.add_scalar_mut(1e6);
        case.Y.add_scalar_mut(1e6 * rms);
        // The offset rounds the samples to 10^-10: a system at rest at the offset has them in its input, too.
        case.constant = true;
        case.expect_as_good_as_a_dense_qr();
    }
}

#[test]
fn scales_that_differ_by_a_million_millions() {
    for noise in [1e-3, 0.0] {
        let mut case = Case::new("scales of 10^12", &deflection(0.005), 15, 10_000, noise);
        case.U *= 1e12;
        case.Y *= 1e-12;
        case.expect_as_good_as_a_dense_qr();
    }
}

/// zeta = 1e-4: after 10 000 samples the first one still rings.
#[test]
fn a_mode_that_is_hardly_damped() {
    let (omega, zeta) = (0.3_f64, 1e-4_f64);
    let (s, c) = (omega * (1.0 - zeta * zeta).sqrt()).sin_cos();
    let r = (-zeta * omega).exp();
    let A = Mat::from_row_slice(2, 2, &[r * c, r * s, -r * s, r * c]);
    let one = |rows, columns| Mat::from_element(rows, columns, 1.0);
    let plant = StateSpace::new(A, one(2, 1), one(1, 2), Mat::zeros(1, 1), Time::Sampled { period_s: 1.0 }).unwrap();
    for noise in [1e-2, 1e-6, 0.0] {
        Case::new("damping of 10^-4", &plant, 15, 10_000, noise).expect_as_good_as_a_dense_qr();
    }
}

/// 50 us where 5 ms would do: all poles within 2e-3 of one.
#[test]
fn sampling_a_hundred_times_too_fast() {
    for noise in [1e-6, 0.0] {
        Case::new("100 times too fast", &deflection(5e-5), 15, 10_000, noise).expect_as_good_as_a_dense_qr();
    }
}
