//! What the design refuses, with the numbers that say why.

use flexbeam_design::{Error, HalfPlane, Reference, Specification, Stiffness, Uncertainty, cover, design};
use flexbeam_lti::{C64, Mat, Rational, StateSpace, Time, Zpk};

fn system(A: &[f64], B: &[f64], C: &[f64], d: f64) -> StateSpace {
    let n = B.len();
    let [A, B, C] = [(n, n, A), (n, 1, B), (1, n, C)].map(|(rows, columns, x)| Mat::from_row_slice(rows, columns, x));
    StateSpace::new(A, B, C, Mat::from_element(1, 1, d), Time::Continuous).unwrap()
}

/// An integrator with a lag: k/(s (s + 10)).
fn motor() -> StateSpace {
    system(&[0., 1., 0., -10.], &[0., 20.], &[1., 0.], 0.0)
}

fn specification(beta: f64) -> Specification {
    Specification {
        stability_degree: beta,
        uncertainty: Uncertainty::constant(0.1).unwrap(),
        stiffness: Stiffness::Optimal,
        reference: Reference::RiseTime { rise_time_s: 0.2, overshoot_percent: 0.0 },
        period_s: 0.001,
        delay_s: 0.001,
        low_pass: 1.0,
    }
}

#[test]
fn feedthrough_and_wrong_shapes() {
    let leaky = system(&[-1.0], &[1.0], &[1.0], 0.5);
    assert_eq!(design(&leaky, &specification(0.5)).unwrap_err(), Error::Feedthrough { value: 0.5 });
    let mut sampled = motor();
    sampled.time = Time::Sampled { period_s: 0.01 };
    assert!(matches!(design(&sampled, &specification(0.5)).unwrap_err(), Error::NotContinuous { .. }));
    let two = StateSpace::new(Mat::zeros(1, 1), Mat::zeros(1, 2), Mat::zeros(1, 1), Mat::zeros(1, 2), Time::Continuous);
    assert_eq!(design(&two.unwrap(), &specification(0.5)).unwrap_err(), Error::NotScalar { inputs: 2, outputs: 1 });
}

#[test]
fn hidden_unstable_modes_are_named() {
    // The mode at +3 is not driven, that at +2 not seen.
    let undriven = system(&[-1., 0., 0., 3.], &[1., 0.], &[1., 1.], 0.0);
    let Error::HiddenMode { re, kind, .. } = design(&undriven, &specification(0.5)).unwrap_err() else { panic!() };
    assert!((re - 3.0).abs() < 1e-9 && kind == "not controllable", "{re} {kind}");
    let unseen = system(&[-1., 0., 0., 2.], &[1., 1.], &[1., 0.], 0.0);
    let Error::HiddenMode { re, kind, .. } = design(&unseen, &specification(0.5)).unwrap_err() else { panic!() };
    assert!((re - 2.0).abs() < 1e-9 && kind == "not observable", "{re} {kind}");
}

#[test]
fn beta_on_a_pole_is_undefined() {
    let Error::PoleOnLine { re, beta, .. } = design(&motor(), &specification(10.0)).unwrap_err() else { panic!() };
    assert!((re + 10.0).abs() < 1e-9 && beta == 10.0);
    let Error::PoleOnLine { re, limit, suggestion, .. } = design(&motor(), &specification(0.0)).unwrap_err() else {
        panic!()
    };
    assert!(
        re.abs() < 1e-9 && limit.contains("k/(2 beta)") && suggestion.contains("1.000 1/s"),
        "{limit} {suggestion}"
    );
}

#[test]
fn bounds_outside_the_theory() {
    let zpk = |zeros: &[f64], poles: &[f64]| {
        let roots = |x: &[f64]| x.iter().map(|x| C64::new(*x, 0.0)).collect();
        Uncertainty::new(Zpk { zeros: roots(zeros), poles: roots(poles), gain: 1.0 })
    };
    assert!(matches!(zpk(&[-1.0], &[2.0]).unwrap_err(), Error::Weight { re: 2.0, .. }));
    assert!(matches!(zpk(&[0.0], &[-2.0]).unwrap_err(), Error::Weight { re: 0.0, .. }));
    assert_eq!(zpk(&[], &[-2.0]).unwrap_err(), Error::WeightDegree { zeros: 0, poles: 1 });
    assert!(Uncertainty::constant(0.0).is_err() && Uncertainty::constant(f64::NAN).is_err());
    let spike = |w: f64| if w > 10.0 { f64::INFINITY } else { 0.1 };
    assert!(matches!(cover(spike, 1.0, 100.0).unwrap_err(), Error::DifferenceNotFinite { .. }));
}

#[test]
fn reference_models_that_cannot_be_followed() {
    let ask = |reference| design(&motor(), &Specification { reference, ..specification(1.0) }).unwrap_err();
    let M = |num: &[f64], den: &[f64]| Reference::Model(Rational::new(num.to_vec(), den.to_vec()).unwrap());
    assert_eq!(ask(M(&[5.0], &[1.0, 5.0])), Error::ReferenceDegree { found: 1, needed: 2 });
    assert!(matches!(ask(M(&[0.25], &[1.0, 1.0, 0.25])), Error::ReferencePole { .. }));
    let fast = |max_voltage_v| Reference::Fastest { overshoot_percent: 0.0, max_voltage_v, max_step_rad: 1.0 };
    assert!(matches!(ask(fast(1e-6)), Error::Voltage { .. }));
    let overshoot = Reference::RiseTime { rise_time_s: 0.2, overshoot_percent: 100.0 };
    assert!(matches!(ask(overshoot), Error::Setting { name: "overshoot [percent]", .. }));
}

#[test]
fn a_plant_without_integrator_has_no_stiffness_to_choose() {
    let lag = system(&[0.5], &[1.0], &[1.0], 0.0);
    let asked = Specification { stiffness: Stiffness::Exactly(7.0), ..specification(1.0) };
    assert!(matches!(design(&lag, &asked).unwrap_err(), Error::NoIntegrator { requested: 7.0, .. }));
}

/// One state, and a loop whose gain is largest where no crossing is: at s = 0.
#[test]
fn the_smallest_loops_have_figures() {
    let integrator = system(&[0.0], &[1.0], &[1.0], 0.0);
    let asked = Specification { uncertainty: Uncertainty::constant(0.05).unwrap(), ..specification(1.0) };
    let flexbeam_design::Outcome::Solved(found) = design(&integrator, &asked).unwrap() else { panic!() };
    assert!((found.continuous.stiffness - 2.0).abs() < 1e-12, "K = 2 beta moves the pole from 0 to -2 beta");
    let lag = system(&[-1.0], &[-0.5], &[1.0], 0.0);
    let one = StateSpace::static_gain(Mat::from_element(1, 1, 1.0), Time::Continuous).unwrap();
    assert!((flexbeam_design::margins(&lag, &one).unwrap().gain - 2.0).abs() < 1e-12);
    let leaky = system(&[0.0], &[1.0], &[1.0], 5.0);
    assert_eq!(design(&leaky, &asked).unwrap_err(), Error::Feedthrough { value: 5.0 });
}

#[test]
fn every_message_has_one_hint() {
    let errors = [
        design(&motor(), &specification(10.0)).unwrap_err(),
        design(&motor(), &specification(-1.0)).unwrap_err(),
        design(&system(&[-1.0], &[1.0], &[1.0], 0.5), &specification(0.5)).unwrap_err(),
        Uncertainty::constant(0.0).unwrap_err(),
    ];
    for error in errors {
        assert_eq!(error.to_string().matches("hint:").count(), 1, "{error}");
    }
}

#[test]
fn a_cover_lies_above_what_it_covers() {
    let resonance = |w: f64| 0.05 / ((1.0 - (w / 130.0).powi(2)).hypot(0.02 * w / 130.0)) * 0.02;
    let found = cover(resonance, 1.5, 130.0).unwrap();
    for k in 0..20_000 {
        let omega = 0.1 * 1.0004f64.powi(k);
        assert!(resonance(omega) < found.magnitude(omega), "at {omega}");
    }
}

#[test]
fn nothing_unstable_needs_no_feedback() {
    let damped = system(&[-5.0], &[1.0], &[1.0], 0.0);
    let plant = HalfPlane::new(&damped, 1.0).unwrap();
    assert!(plant.unstable_poles().is_empty());
    let flexbeam_design::Outcome::Solved(found) = design(&damped, &specification(1.0)).unwrap() else { panic!() };
    assert_eq!(found.robust_radius, None);
    assert_eq!(found.continuous.bound_norm, 0.0);
    assert_eq!(found.sampled.stiffness, 0.0);
}
