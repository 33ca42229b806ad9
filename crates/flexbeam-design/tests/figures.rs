//! Figures of DESIGN section 6 on the paper's plant (18), by both roads, and the loops built explicitly.

use flexbeam_design::{
    HalfPlane, Outcome, Reference, Specification, Stiffness, Uncertainty, Unsolvable, design, radius_by_hankel,
    robust_radius, sampled_plant,
};
use flexbeam_lti::{C64, Mat, Rational, StateSpace, Time};

/// (18), V -> psi = theta + alpha.
fn paper_plant() -> StateSpace {
    let A = Mat::from_row_slice(4, 4, &[0., 0., 1., 0., 0., 0., 0., 1., 0., 1060.8, -57.7, 0., 0., -1465.2, 57.7, 0.]);
    let B = Mat::from_column_slice(4, 1, &[0., 0., 107.39, -107.39]);
    let C = Mat::from_row_slice(1, 4, &[1., 1., 0., 0.]);
    StateSpace::new(A, B, C, Mat::zeros(1, 1), Time::Continuous).unwrap()
}

fn specification(beta: f64, uncertainty: Uncertainty, stiffness: Stiffness) -> Specification {
    Specification {
        stability_degree: beta,
        uncertainty,
        stiffness,
        reference: Reference::Fastest { overshoot_percent: 0.0, max_voltage_v: 10.0, max_step_rad: 45f64.to_radians() },
        period_s: 0.001,
        delay_s: 0.001,
        low_pass: 1.0,
    }
}

fn solved(beta: f64, uncertainty: Uncertainty, stiffness: Stiffness) -> flexbeam_design::Design {
    match design(&paper_plant(), &specification(beta, uncertainty, stiffness)).unwrap() {
        Outcome::Solved(design) => *design,
        Outcome::Unsolvable(reason) => panic!("not solvable: {reason}"),
    }
}

fn expect_poles(found: &[C64], expected: &[(f64, f64)], tolerance: f64) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    let mut left = found.to_vec();
    for (re, im) in expected {
        let wanted = C64::new(*re, *im);
        let k =
            (0..left.len()).min_by(|a, b| (left[*a] - wanted).norm().total_cmp(&(left[*b] - wanted).norm())).unwrap();
        assert!((left[k] - wanted).norm() < tolerance, "{wanted}: nearest is {}", left[k]);
        left.swap_remove(k);
    }
}

#[test]
fn radius_has_the_published_figures_by_both_roads() {
    let lead = Uncertainty::rational(&Rational::new(vec![0.001, 0.02], vec![0.0025, 1.0]).unwrap()).unwrap();
    let one = Uncertainty::constant(1.0).unwrap();
    let cases = [
        (2.0, &one, 0.4652946),
        (5.0, &one, 0.1861179),
        (12.0, &one, 0.0709455),
        (15.0, &one, 0.0299731),
        (12.0, &lead, 2.2905406),
    ];
    for (beta, alpha, published) in cases {
        let plant = HalfPlane::new(&paper_plant(), beta).unwrap();
        let hankel = radius_by_hankel(&plant, alpha).unwrap();
        let pick = robust_radius(&plant, alpha).unwrap().unwrap();
        assert!((hankel - published).abs() < 1e-6, "beta {beta}: Hankel {hankel}");
        assert!((pick - published).abs() < 1e-6, "beta {beta}: Pick {pick}");
    }
}

#[test]
fn radius_sampled_with_delay() {
    let alpha = Uncertainty::constant(1.0).unwrap();
    let plant = sampled_plant(&paper_plant(), &specification(12.0, alpha.clone(), Stiffness::Optimal)).unwrap();
    let radius = robust_radius(&HalfPlane::new(&plant, 12.0).unwrap(), &alpha).unwrap().unwrap();
    assert!((radius - 0.0709565).abs() < 1e-6, "{radius}");
}

#[test]
fn optimal_loop_has_the_published_poles_and_level() {
    let found = solved(12.0, Uncertainty::constant(0.06).unwrap(), Stiffness::Optimal);
    let poles = [
        (-12.586, 23.213),
        (-12.586, -23.213),
        (-12.682, 23.234),
        (-12.682, -23.234),
        (-24.0, 0.0),
        (-34.8716, 0.0),
        (-34.8716, 0.0),
    ];
    expect_poles(&found.continuous.poles, &poles, 1e-3);
    assert!((found.continuous.bound_norm - 0.84572).abs() < 1e-5, "{}", found.continuous.bound_norm);
    assert!((found.continuous.stability_degree - 12.586).abs() < 1e-3);
    assert!((found.sampled.bound_norm - 0.8456).abs() < 1e-4, "{}", found.sampled.bound_norm);
    assert!((found.sampled.stability_degree - 12.586).abs() < 1e-3, "{}", found.sampled.stability_degree);
    let level = 1.0 / found.robust_radius.unwrap();
    assert!((found.continuous.bound_norm - level).abs() < 1e-8, "the loop built explicitly reaches the radius's level");
}

#[test]
fn a_bound_that_is_too_large_is_refused_with_what_would_help() {
    let alpha = Uncertainty::constant(0.08).unwrap();
    let Outcome::Unsolvable(reason) =
        design(&paper_plant(), &specification(12.0, alpha.clone(), Stiffness::Optimal)).unwrap()
    else {
        panic!("0.08 is above the radius 0.0709")
    };
    let Unsolvable::Radius { radius, largest_beta: Some(beta), .. } = reason else { panic!("{reason:?}") };
    assert!((radius - 0.0709455 / 0.08).abs() < 1e-5);
    let at_limit = HalfPlane::new(&paper_plant(), beta).unwrap();
    assert!((robust_radius(&at_limit, &alpha).unwrap().unwrap() - 1.0).abs() < 1e-4);
}

#[test]
fn integral_action_fits_into_the_level() {
    let alpha = Uncertainty::constant(0.2).unwrap();
    let soft = solved(1.5, alpha.clone(), Stiffness::Optimal);
    let stiff = solved(1.5, alpha, Stiffness::Integral);
    assert!((soft.continuous.bound_norm - 0.32).abs() < 0.005, "{}", soft.continuous.bound_norm);
    assert!((stiff.continuous.bound_norm - 0.66).abs() < 0.005, "{}", stiff.continuous.bound_norm);
    let plant = (-11.41420, 23.21321);
    let poles = [
        (-3.0, 0.0),
        (-2.64, 0.0),
        plant,
        plant,
        (plant.0, -plant.1),
        (plant.0, -plant.1),
        (-34.8716, 0.0),
        (-34.8716, 0.0),
    ];
    expect_poles(&stiff.continuous.poles, &poles, 5e-3);
    assert_eq!((stiff.continuous.stiffness, stiff.sampled.stiffness), (f64::INFINITY, f64::INFINITY));
    assert!(stiff.sampled.bound_norm <= 1.0);
}

#[test]
fn stiffness_is_what_was_asked_for() {
    let alpha = Uncertainty::constant(0.2).unwrap();
    for k in [2.0, 7.0, 50.0] {
        let found = solved(1.5, alpha.clone(), Stiffness::Exactly(k));
        assert!((found.continuous.stiffness / k - 1.0).abs() < 1e-8, "{}", found.continuous.stiffness);
        assert!((found.sampled.stiffness / k - 1.0).abs() < 1e-6, "{}", found.sampled.stiffness);
    }
}

/// The overshoot asked for is that of the whole M, its fast poles included.
#[test]
fn overshoot_and_rise_time_are_what_was_asked_for() {
    for (overshoot_percent, rise_time_s) in [(0.0, 0.3), (4.0, 0.3), (20.0, 0.2), (60.0, 0.1)] {
        let alpha = Uncertainty::constant(0.2).unwrap();
        let reference = Reference::RiseTime { rise_time_s, overshoot_percent };
        let asked = Specification { reference, ..specification(1.5, alpha, Stiffness::Optimal) };
        let Outcome::Solved(found) = design(&paper_plant(), &asked).unwrap() else { panic!() };
        let M = found.prefilter.model.zpk.to_state_space(Time::Continuous).unwrap();
        let sampled = flexbeam_lti::sampling::zoh(&M, 1e-4).unwrap();
        let ones = Mat::from_element(1, 40_000, 1.0);
        let y = flexbeam_lti::simulation::simulate(&sampled, &ones, &flexbeam_lti::Vector::zeros(M.order())).unwrap();
        let overshoot = 100.0 * (y.max() - 1.0);
        assert!((overshoot - overshoot_percent).abs() < 0.01, "{overshoot_percent} % asked, {overshoot} found");
        let at = |level: f64| y.iter().position(|y| *y >= level).unwrap() as f64 * 1e-4;
        assert!((at(0.9) - at(0.1) - rise_time_s).abs() < 2e-4, "{rise_time_s} s asked");
    }
}

/// R D + S N = 1 leaves y = N T v: the response to a command is that of M, whatever the feedback.
#[test]
fn the_loop_follows_the_reference_model() {
    let found = solved(1.5, Uncertainty::constant(0.2).unwrap(), Stiffness::Exactly(7.0));
    let spec = specification(1.5, Uncertainty::constant(0.2).unwrap(), Stiffness::Exactly(7.0));
    let plant = sampled_plant(&paper_plant(), &spec).unwrap();
    let K = &found.controller;
    let (mut x, mut q) = (flexbeam_lti::Vector::zeros(plant.order()), flexbeam_lti::Vector::zeros(K.order()));
    let mut peak: f64 = 0.0;
    for _ in 0..3000 {
        let y = (&plant.C * &x)[0];
        let outputs = &K.C * &q + K.D.columns(0, 2) * flexbeam_lti::Vector::from_vec(vec![1.0, y]);
        assert!((outputs[1] - y).abs() < 1e-7, "{} {y}", outputs[1]);
        peak = peak.max(outputs[0].abs());
        q = &K.A * &q + &K.B * flexbeam_lti::Vector::from_vec(vec![1.0, y, outputs[0]]);
        x = &plant.A * &x + &plant.B * outputs[0];
    }
    assert!(((&plant.C * &x)[0] - 1.0).abs() < 1e-6);
    assert!((peak - found.prefilter.peak_voltage_per_rad).abs() < 1e-6 * peak);
    assert!((peak * 45f64.to_radians() - 10.0).abs() < 0.02, "{peak}");
}
