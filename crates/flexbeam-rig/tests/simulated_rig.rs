//! The simulated rig: equal to the linear model when nothing else is on, and to an event-driven reference when dry
//! friction is.

mod event_driven;

use event_driven::EventDriven;
use flexbeam_lti::{Mat, Vector};
use flexbeam_rig::{
    Actuator, Friction, Link, Output, Physical, RigParameters, Sensors, SimulatedRig, Stribeck, open_loop,
};
use std::f64::consts::TAU;

/// A voltage that keeps the hub sticking and sliding.
fn voltage_v(k: usize) -> f64 {
    let t = k as f64 * 0.001;
    0.25 * (TAU * 1.7 * t).sin() + 0.2 * (TAU * 7.0 * t).sin() + if t > 0.4 { -0.1 } else { 0.1 }
}

fn friction_only(friction: Friction) -> RigParameters {
    RigParameters { friction, ..RigParameters::default().linear() }
}

fn sampled(parameters: &RigParameters, outputs: &[Output]) -> (Mat, Vector, Mat) {
    let model = parameters.linear_model(outputs).unwrap();
    let n = model.order();
    let mut augmented = Mat::zeros(n + 1, n + 1);
    augmented.view_mut((0, 0), (n, n)).copy_from(&model.A);
    augmented.view_mut((0, n), (n, 1)).copy_from(&model.B);
    let exponential = (augmented * parameters.period_s).exp();
    (exponential.view((0, 0), (n, n)).into_owned(), exponential.view((0, n), (n, 1)).column(0).into_owned(), model.C)
}

#[test]
fn with_everything_off_the_rig_is_the_sampled_linear_model() {
    for link in [Link::Lumped, Link::default()] {
        let parameters = RigParameters { link, ..RigParameters::default().linear() };
        let (Phi, Gamma, C) = sampled(&parameters, &[Output::Theta, Output::Alpha]);
        let mut rig = SimulatedRig::new(&parameters, 0).unwrap();
        let voltages: Vec<f64> = (0..2000).map(|k| 10.0 * voltage_v(k)).collect();
        let recorded = open_loop(&mut rig, &voltages).unwrap();
        let mut x = Vector::zeros(Gamma.len());
        let mut worst: f64 = 0.0;
        for (k, voltage) in voltages.iter().enumerate() {
            let y = &C * &x;
            worst = worst.max((recorded.data[(1, k)] - y[0]).abs()).max((recorded.data[(2, k)] - y[1]).abs());
            assert_eq!(recorded.data[(0, k)], *voltage);
            x = &Phi * x + &Gamma * *voltage;
        }
        let largest = recorded.data.row(1).amax();
        assert!(worst < 1e-13 * largest * 2000.0_f64.sqrt(), "{link:?}: {worst:e} of {largest}");
    }
}

/// Largest distance of psi from the reference in 0.8 s, and the reference's number of contact changes.
fn distance(parameters: &RigParameters) -> (f64, usize) {
    let mut rig = SimulatedRig::new(parameters, 0).unwrap();
    let mut reference = EventDriven::new(parameters, 1e-5);
    let mut worst: f64 = 0.0;
    for k in 0..800 {
        rig.apply(voltage_v(k));
        reference.advance(parameters.period_s, voltage_v(k));
        worst = worst.max((rig.truth().psi_rad() - reference.psi()).abs());
    }
    (worst, reference.changes)
}

/// Coulomb friction leaves nothing to approximate but the instants of change: whatever the substeps, the distance is
/// that of the reference's own error.
#[test]
fn coulomb_friction_is_exact_whatever_the_substeps() {
    for link in [Link::Lumped, Link::default()] {
        for substeps in [1, 4] {
            let parameters = RigParameters { link, substeps, ..friction_only(Friction::default()) };
            let (worst, changes) = distance(&parameters);
            assert!(changes > 10, "{changes} changes of contact");
            assert!(worst < 1e-10, "{link:?}, {substeps} substeps: {worst:e}");
        }
    }
}

#[test]
fn a_stribeck_effect_makes_the_scheme_one_of_second_order() {
    let stribeck = Some(Stribeck { extra_nm: 0.006, speed_rad_s: 0.15 });
    let friction = Friction { coulomb_nm: 0.0125, stribeck };
    let error = |substeps: u32| distance(&RigParameters { substeps, ..friction_only(friction) }).0;
    let errors = [1, 2, 4, 8].map(error);
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((1.6..2.6).contains(&order), "{errors:?}: order {order}");
    }
}

#[test]
fn a_stuck_hub_stays_to_the_last_bit_while_the_beam_swings() {
    let mut rig = SimulatedRig::new(&friction_only(Friction::default()), 0).unwrap();
    for _ in 0..50 {
        rig.apply(2.0);
    }
    // While it swings strongly the beam breaks the hub loose again and again: wait until it no longer does.
    let (mut at_rest, mut waited) = (0, 0);
    while at_rest < 400 {
        rig.apply(0.0);
        at_rest = if rig.truth().stuck { at_rest + 1 } else { 0 };
        waited += 1;
        assert!(waited < 20_000, "the hub does not come to rest");
    }
    let (theta, mut least, mut most) = (rig.truth().theta_rad, f64::INFINITY, f64::NEG_INFINITY);
    for k in 0..2000 {
        rig.apply(if k % 2 == 0 { 1e-3 } else { -1e-3 });
        assert_eq!(rig.truth().theta_rad.to_bits(), theta.to_bits());
        assert_eq!(rig.truth().theta_rad_s, 0.0);
        least = least.min(rig.truth().alpha_rad);
        most = most.max(rig.truth().alpha_rad);
    }
    assert!(most - least > 1e-4, "the beam swings by {} rad", most - least);
}

/// Lumped and without damping in the link, what friction takes is what the energy loses.
#[test]
fn friction_takes_what_the_energy_loses() {
    let physical = Physical { K_b: 1e-9, ..Physical::paper() };
    let parameters = RigParameters { physical, link: Link::Lumped, ..friction_only(Friction::default()) };
    let mut rig = SimulatedRig::new(&parameters, 0).unwrap();
    // The motor of this rig makes next to no torque per volt and next to no damping, so the voltage is large.
    let per_volt = physical.torque_per_volt();
    for _ in 0..60 {
        rig.apply(0.5 / per_volt);
    }
    let energy = |rig: &SimulatedRig| {
        let t = rig.truth();
        let tip_rate = t.theta_rad_s + t.alpha_rad_s;
        (physical.J_base * t.theta_rad_s.powi(2)
            + physical.J_link * tip_rate.powi(2)
            + physical.K_stiff * t.alpha_rad.powi(2))
            / 2.0
    };
    let (before, start) = (energy(&rig), rig.truth().theta_rad);
    let mut travelled = 0.0;
    let mut last = start;
    for _ in 0..20 {
        rig.apply(0.0);
        travelled += (rig.truth().theta_rad - last).abs();
        last = rig.truth().theta_rad;
    }
    assert!((travelled - (last - start).abs()) < 1e-12, "the hub went one way");
    let lost = before - energy(&rig);
    assert!((lost - 0.0165 * travelled).abs() < 1e-6 * lost, "{lost} J, {} J", 0.0165 * travelled);
}

#[test]
fn breakaway_as_measured_on_real_rigs_in_either_direction() {
    let breakaway = |sign: f64| {
        let mut rig = SimulatedRig::new(&RigParameters::default(), 3).unwrap();
        (0..).map(|k| sign * 1e-5 * f64::from(k)).find(|&v| {
            rig.apply(v);
            !rig.truth().stuck
        })
    };
    // One step of the converter, and the beam's swing that the ramp itself excites.
    let tolerance = 20.0 / 4096.0;
    assert!((breakaway(1.0).unwrap() - 0.28).abs() < tolerance);
    assert!((breakaway(-1.0).unwrap() + 0.10).abs() < tolerance);
}

#[test]
fn one_seed_gives_one_recording_and_reset_repeats_it() {
    let voltages: Vec<f64> = (0..500).map(|k| 5.0 * voltage_v(k)).collect();
    let mut rig = SimulatedRig::new(&RigParameters::default(), 11).unwrap();
    let first = open_loop(&mut rig, &voltages).unwrap();
    rig.reset();
    assert_eq!(open_loop(&mut rig, &voltages).unwrap(), first);
    let mut other = SimulatedRig::new(&RigParameters::default(), 12).unwrap();
    let different = open_loop(&mut other, &voltages).unwrap();
    assert_eq!(different.data.row(1), first.data.row(1), "the seed changes the noise and nothing else");
    assert_ne!(different.data.row(2), first.data.row(2));
    assert_eq!(first.names, ["voltage_v", "theta_rad", "alpha_rad"]);
}

#[test]
fn what_no_rig_can_be_is_refused() {
    let d = RigParameters::default();
    let refused = [
        RigParameters { period_s: 0.0, ..d },
        RigParameters { substeps: 0, ..d },
        RigParameters { friction: Friction { coulomb_nm: -1.0, stribeck: None }, ..d },
        RigParameters { actuator: Actuator { limit_v: f64::NAN, ..d.actuator }, ..d },
        RigParameters { physical: Physical { J_link: -1.0, ..d.physical }, ..d },
    ];
    for parameters in refused {
        assert!(SimulatedRig::new(&parameters, 0).is_err(), "{parameters:?}");
    }
    for count in [0, 17] {
        let Link::Modes { damping, tip_mass_kg, .. } = Link::default() else { unreachable!() };
        let link = Link::Modes { count, damping, tip_mass_kg };
        assert!(SimulatedRig::new(&RigParameters { link, ..d }, 0).is_err());
    }
    assert!(SimulatedRig::new(&RigParameters { sensors: Sensors::IDEAL, ..d }, 0).is_ok());
}
