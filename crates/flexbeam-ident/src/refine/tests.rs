use std::ops::ControlFlow;

use super::*;
use crate::excitation::white_gaussian;
use flexbeam_lti::Time;
use sensitivity::{Record, jacobian, second_moment};

fn mix(r: usize, c: usize, salt: usize) -> f64 {
    (((r + 2) * (c + 3)) as f64 * 1.7 + salt as f64).sin()
}

/// Three states, the first an integrator; two inputs, two outputs.
fn point(gain: bool) -> Point {
    #[rustfmt::skip]
    let A = Mat::from_row_slice(3, 3, &[
        1.0, 0.0, 0.0,
        0.0, 0.8, 0.4,
        0.0, -0.3, 0.7,
    ]);
    Point {
        A,
        B: Mat::from_fn(3, 2, |r, c| mix(r, c, 1)),
        C: Mat::from_fn(2, 3, |r, c| mix(r, c, 2)),
        D: Mat::from_fn(2, 2, |r, c| mix(r, c, 3)),
        K: gain.then(|| Mat::from_fn(3, 2, |r, c| 0.2 * mix(r, c, 4))),
        initial_state: Vector::from_column_slice(&[0.3, -0.2, 0.1]),
    }
}

fn record(gain: bool) -> Record {
    let white = |seed: u64| Mat::from_row_slice(2, 300, &white_gaussian(600, 1.0, 9.0, seed));
    let (U, Y) = (white(1), white(2));
    let errors = if gain { Errors::Predicted(None) } else { Errors::Simulated };
    start::record(U, Y, &Settings { errors, ..Settings::default() })
}

fn going() -> impl FnMut() -> ControlFlow<()> {
    || ControlFlow::Continue(())
}

fn squares(point: &Point, record: &Record, weight: &Mat) -> f64 {
    let ControlFlow::Continue(Some(S)) = second_moment(&point.predictor(), record, &mut going()) else { panic!() };
    (weight * S * weight.transpose()).trace() * 300.0
}

/// -2 J'e from the factor beside central differences, in every local direction and the initial state.
#[test]
fn gradients_are_exact_for_simulation_and_prediction() {
    let weight = Mat::from_row_slice(2, 2, &[1.0, 0.0, 0.6, 0.4]);
    for (gain, integrators) in [(false, 0), (false, 1), (true, 0), (true, 1)] {
        let structure = Structure { integrators, no_feedthrough: false, offset: false };
        let (point, record) = (point(gain), record(gain));
        let basis = point.basis(structure);
        let predictor = point.predictor();
        let directions = point.predictor_directions(&basis, &predictor);
        let d = directions.nrows();
        let ControlFlow::Continue(R) = jacobian(&predictor, &record, &weight, &directions, &mut going()) else {
            panic!()
        };
        // n(m + l) + m l parameters, n l more with a gain, one less for an integrator; and x(0).
        assert_eq!(d, 3 * 4 + 4 + if gain { 6 } else { 0 } - integrators + 3, "{gain} {integrators}");
        assert!(
            (R[(d, d)].powi(2) + R.column(d).rows(0, d).norm_squared() - squares(&point, &record, &weight)).abs()
                < 1e-9
        );
        for k in 0..d {
            let at = |h: f64| {
                squares(&point.moved(&basis, &(Vector::from_fn(d, |r, _| f64::from(r == k)) * h)), &record, &weight)
            };
            let h = 1e-6;
            let numeric = (at(h) - at(-h)) / (2.0 * h);
            let exact = -2.0 * R.column(k).rows(0, d).dot(&R.column(d).rows(0, d));
            let size = R.column(k).norm() * R.column(d).norm();
            assert!((numeric - exact).abs() < 1e-6 * size, "gain {gain}, {integrators}, {k}: {numeric} {exact}");
        }
    }
}

/// Along every change of basis the output does not change: such a direction stands at right angles to all of the basis.
#[test]
fn a_change_of_basis_is_no_direction() {
    let point = point(true);
    let record = record(true);
    let before = squares(&point, &record, &Mat::identity(2, 2));
    let balanced = balance::balanced(&point, 1, 300);
    let after = squares(&balanced, &record, &Mat::identity(2, 2));
    assert!((before / after - 1.0).abs() < 1e-10, "balancing changed the output: {before} {after}");
    assert!((&balanced.A - &point.A).norm() > 1e-3 && balanced.A[(0, 0)] == 1.0);
    let structure = Structure { integrators: 1, no_feedthrough: true, offset: false };
    assert!(balanced.basis(structure).is_orthonormal(1e-12));
}

/// Poles near 1 become 1 to the last bit, a conjugate pair included, the others stay.
#[test]
fn block_form_moves_the_nearest_poles_to_one() {
    let poles_of = |rows: [f64; 9]| {
        let A = Mat::from_row_slice(3, 3, &rows);
        let one = |r: usize, c: usize| Mat::from_fn(r, c, |r, c| mix(r, c, 5));
        StateSpace::new(A, one(3, 1), one(1, 3), Mat::zeros(1, 1), Time::Sampled { period_s: 1.0 }).unwrap()
    };
    let real = poles_of([0.98, 0.3, 0.1, 0.0, 0.5, 0.4, 0.0, -0.4, 0.5]);
    let form = block_form::block_form(&real, &Vector::zeros(3), 1).unwrap();
    assert!((form.moved - 0.02).abs() < 1e-12);
    assert_eq!(form.model.A[(0, 0)], 1.0);
    assert_eq!(form.model.A.view((0, 1), (1, 2)).amax() + form.model.A.view((1, 0), (2, 1)).amax(), 0.0);
    assert!((form.model.A.view((1, 1), (2, 2)).determinant() - 0.41).abs() < 1e-12);
    let pair = poles_of([0.99, 0.02, 0.0, -0.02, 0.99, 0.0, 0.1, 0.2, 0.4 + 0.0]);
    // The only real pole is 0.4: nearer real ones are there after the pair has become 1 and 0.99.
    let form = block_form::block_form(&pair, &Vector::zeros(3), 1).unwrap();
    assert!((form.model.A.trace() - form.model.A[(0, 0)]).is_finite() && form.model.A[(0, 0)] == 1.0);
    // What was in block form already is only turned.
    let exact = poles_of([1.0, 0.3, 0.1, 0.0, 0.5, 0.4, 0.0, -0.4, 0.5]);
    let form = block_form::block_form(&exact, &Vector::zeros(3), 1).unwrap();
    assert!(!form.was_moved());
    let z = flexbeam_lti::C64::new(0.3, 1.1);
    assert!((form.model.at(z) - exact.at(z)).norm() < 1e-12 * exact.at(z).norm());
}
