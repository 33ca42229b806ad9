//! Counts, norm and margins against eigenvalues and dense sweeps of a loop made by hand.

use crate::by_hand::{TIMING, closed_loop_poles, controller, degree, feedback_part, nominal, sampled_plant};
use flexbeam_lti::{C64, Mat, StateSpace, Zpk};
use flexbeam_verify::{Error, Feedback, Loop, Plant, Timing, bound_norm, count, margins, stability_degree};

struct Made {
    plant: Plant,
    feedback: Feedback,
    controller: StateSpace,
}

fn made(timing: Timing, degree: f64) -> Made {
    let controller = controller(timing, degree);
    Made { plant: Plant::new(&nominal(), timing).unwrap(), feedback: Feedback::new(&controller).unwrap(), controller }
}

#[test]
fn every_circle_counts_what_the_eigenvalues_say() {
    let made = made(TIMING, 1.5);
    let L = Loop::new(&made.plant, &made.feedback).unwrap();
    let poles = closed_loop_poles(TIMING, &made.controller);
    let degrees: Vec<f64> = poles.iter().map(|z| -z.norm().ln() / TIMING.period_s).collect();
    let mut evaluations = 0;
    for beta in [0.0, 1.0, 1.5, 3.0, 7.0, 11.0, 12.5, 20.0, 40.0, 100.0, 300.0] {
        let wanted = degrees.iter().filter(|d| **d < beta).count();
        let found = count(&L, beta).unwrap();
        assert_eq!(found.beyond, wanted, "{beta}: {degrees:?}");
        evaluations += found.evaluations;
    }
    assert!(evaluations < 11 * 6000, "{evaluations} evaluations");
}

#[test]
fn stability_degree_is_that_of_the_eigenvalues() {
    for (low_pass, beta) in [(0.6, 1.5), (1.0, 5.0), (0.3, 0.0)] {
        let timing = Timing { low_pass, ..TIMING };
        let made = made(timing, beta);
        let L = Loop::new(&made.plant, &made.feedback).unwrap();
        let wanted = degree(&closed_loop_poles(timing, &made.controller), timing.period_s);
        let found = stability_degree(&L).unwrap();
        assert!((found / wanted - 1.0).abs() < 1e-7, "{found} {wanted}");
    }
}

#[test]
fn an_unstable_loop_has_a_negative_degree() {
    let mut made = made(TIMING, 1.5);
    made.controller.B.column_mut(1).scale_mut(20.0);
    made.feedback = Feedback::new(&made.controller).unwrap();
    let L = Loop::new(&made.plant, &made.feedback).unwrap();
    let poles = closed_loop_poles(TIMING, &made.controller);
    let wanted = degree(&poles, TIMING.period_s);
    assert!(wanted < 0.0);
    assert_eq!(count(&L, 0.0).unwrap().beyond, poles.iter().filter(|z| z.norm() > 1.0).count());
    assert!((stability_degree(&L).unwrap() / wanted - 1.0).abs() < 1e-7);
}

#[test]
fn a_contour_through_a_closed_loop_pole_is_refused() {
    let made = made(TIMING, 1.5);
    let L = Loop::new(&made.plant, &made.feedback).unwrap();
    let degree = stability_degree(&L).unwrap();
    let hit = (-3..=3).map(|k| count(&L, degree * (1.0 + 1e-15 * f64::from(k))));
    for answer in hit {
        match answer {
            Ok(found) => assert!(found.return_difference < 1e-6),
            Err(Error::OnContour { return_difference, .. }) => assert!(return_difference < 1e-6),
            Err(other) => panic!("{other}"),
        }
    }
}

fn dense(points: usize, f: impl Fn(f64) -> f64) -> f64 {
    (1..=points).map(|k| f(std::f64::consts::PI * (k as f64 / points as f64).powi(4))).fold(0.0, f64::max)
}

#[test]
fn bound_norm_is_the_supremum_of_a_dense_sweep_and_the_hamiltonians() {
    let made = made(TIMING, 3.0);
    let L = Loop::new(&made.plant, &made.feedback).unwrap();
    let alpha = Zpk { zeros: vec![C64::from(-20.0)], poles: vec![C64::from(-400.0)], gain: 0.2 };
    let beta = 1.5;
    let found = bound_norm(&L, &alpha, beta);
    let W = |angle: f64| {
        let z = C64::from_polar((-beta * 1e-3_f64).exp(), angle);
        let (gain, _) = L.gain(z);
        let v = 2e3 * (angle / 2.0).tan();
        (made.feedback.at(z).0 / (gain + 1.0) * alpha.at(C64::new(0.0, v))).norm()
    };
    let swept = dense(30_000, W);
    assert!(swept <= found.value * (1.0 + 1e-12) && found.value < swept * (1.0 + 1e-5), "{swept} {found:?}");
    assert!((W(found.omega_rad_s * 1e-3) / found.value - 1.0).abs() < 1e-9);
    let hamiltonian = hamiltonian_norm(&made.controller, &alpha, beta);
    assert!((found.value / hamiltonian - 1.0).abs() < 1e-8, "{} {hamiltonian}", found.value);
}

#[test]
fn a_narrow_peak_is_found_beside_a_broad_one_that_outshines_it_on_the_grid() {
    let made = made(TIMING, 3.0);
    let L = Loop::new(&made.plant, &made.feedback).unwrap();
    let degree = stability_degree(&L).unwrap();
    // Flat, then a hump at high frequency; the nearer the circle to the closed-loop pole, the narrower the peak there.
    for (nearness, hump) in [(1e-3, 40.0), (1e-4, 200.0), (1e-5, 1e3)] {
        let corner = |s: f64| C64::from(-s);
        let alpha = Zpk { zeros: vec![corner(200.0)], poles: vec![corner(200.0 * hump)], gain: hump };
        let beta = degree * (1.0 - nearness);
        let found = bound_norm(&L, &alpha, beta).value;
        let hamiltonian = hamiltonian_norm(&made.controller, &alpha, beta);
        assert!((found / hamiltonian - 1.0).abs() < 1e-3 * nearness.sqrt(), "{nearness}: {found} {hamiltonian}");
    }
}

/// The same by lti's level-set iteration on an explicit closed loop in the w-plane.
fn hamiltonian_norm(controller: &StateSpace, alpha: &Zpk, beta: f64) -> f64 {
    use flexbeam_lti::{Time, connections, norm, sampling};
    let K = feedback_part(controller);
    let W = connections::feedback(&K, &sampled_plant(TIMING)).unwrap();
    let in_w = sampling::to_w(&W.shifted(beta)).unwrap();
    let weight = alpha.to_state_space(Time::Continuous).unwrap();
    norm::hinf_norm(&connections::series(&in_w, &weight).unwrap()).unwrap().norm
}

#[test]
fn margins_are_where_a_perturbed_loop_loses_its_stability() {
    let made = made(TIMING, 1.5);
    let L = Loop::new(&made.plant, &made.feedback).unwrap();
    let margins = margins(&L);
    let beyond = |gain: f64, extra_delay_s: f64| {
        let mut plant = nominal();
        plant.B *= gain;
        let timing = Timing { delay_s: TIMING.delay_s + extra_delay_s, ..TIMING };
        let plant = Plant::new(&plant, timing).unwrap();
        count(&Loop::new(&plant, &made.feedback).unwrap(), 0.0).unwrap().beyond
    };
    assert_eq!((beyond(margins.gain * (1.0 - 1e-6), 0.0), beyond(margins.gain * (1.0 + 1e-6), 0.0)), (0, 2));
    let delay_s = margins.delay_s;
    assert_eq!(beyond(1.0, delay_s * (1.0 - 1e-3)), 0);
    assert_eq!(beyond(1.0, delay_s * (1.0 + 1e-3)), 2);
    // Disk: gains between (2 - d)/(2 + d) and its inverse are survived, and it is reached at some angle by a dense sweep.
    let swept = dense(30_000, |angle| {
        let (gain, _) = L.gain(C64::from_polar(1.0, angle));
        ((1.0 - gain) / (1.0 + gain)).norm()
    });
    assert!((margins.disk * swept / 2.0 - 1.0).abs() < 1e-5, "{} {swept}", margins.disk);
    assert!(margins.disk < 2.0 * (margins.phase_rad / 2.0).tan());
    assert!(margins.disk < 2.0 * (margins.gain - 1.0) / (margins.gain + 1.0));
}

#[test]
fn compliance_is_the_static_gain_where_there_is_one_and_zero_with_integral_action() {
    let made = made(TIMING, 1.5);
    let K = feedback_part(&made.controller);
    let wanted = 1.0 / K.at(C64::from(1.0))[(0, 0)].re;
    let found = made.feedback.compliance_rad_per_v();
    assert!((found / wanted - 1.0).abs() < 1e-8, "{found} {wanted}");
    // u = -(p + i Ts/(z - 1)) y as a controller: one state that sums y.
    let mut summing = StateSpace {
        A: Mat::identity(1, 1),
        B: Mat::from_row_slice(1, 3, &[0.0, 1e-3, 0.0]),
        C: Mat::from_column_slice(2, 1, &[-2.0, 0.0]),
        D: Mat::from_row_slice(2, 3, &[0.0, -0.5, 0.0, 0.0, 0.0, 0.0]),
        time: made.controller.time,
    };
    let integral = Feedback::new(&summing).unwrap().compliance_rad_per_v();
    assert!(integral.abs() < 1e-12, "{integral}");
    summing.A[(0, 0)] = 1.0 - 1e-3; // a leak of 1/s: K(0) = 0.5 + 2
    let leaking = Feedback::new(&summing).unwrap().compliance_rad_per_v();
    assert!((leaking - 0.4).abs() < 1e-10, "{leaking}");
}

#[test]
fn what_is_no_controller_is_refused() {
    let made = made(TIMING, 1.5);
    let mut through = made.controller.clone();
    through.D[(0, 2)] = 0.1;
    assert!(matches!(Feedback::new(&through), Err(Error::Feedthrough { value: 0.1 })));
    let other = Plant::new(&nominal(), Timing { period_s: 2e-3, ..TIMING }).unwrap();
    assert!(matches!(Loop::new(&other, &made.feedback), Err(Error::Setting { .. })));
    assert!(matches!(Plant::new(&nominal(), Timing { low_pass: 0.0, ..TIMING }), Err(Error::Setting { .. })));
    assert!(matches!(Feedback::new(&nominal()), Err(Error::Shape { .. })));
}
