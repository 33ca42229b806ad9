//! `tick` answers whatever it is given: finite numbers, a voltage within the limit, and 0 V from the first fault on.

use flexbeam_kernel::{Channel, Commanded, Controller, Error, Fault, Law, Measured, Settings, State, tick};

/// A proportional controller with a reference model of 1: u = 2 (v - y).
const PROPORTIONAL: [f64; 4] = [2.0, 1.0, -2.0, 0.0];

const SENSELESS: [f64; 12] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    5e-324,
    -0.0,
    0.0,
    -1.0,
    1.0,
    0.3,
];

fn is_finite(c: &Commanded) -> bool {
    [c.voltage_v, c.u_v, c.reference_rad, c.y_rad, c.y_model_rad, c.error_rad].iter().all(|x| x.is_finite())
}

/// A choice that depends on nothing but the run.
fn pick(seed: &mut u32, among: &[f64]) -> f64 {
    *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    among[(*seed >> 16) as usize % among.len()]
}

#[test]
fn any_settings_and_any_measurement_give_a_bounded_voltage() {
    let mut seed = 1;
    let mut faults = [0; 5];
    for run in 0..20_000 {
        let sensible = [0.3, 0.3, 0.3, 1.0];
        let mut some = || if run % 2 == 0 { pick(&mut seed, &SENSELESS) } else { pick(&mut seed, &sensible) };
        let mut channel = || Channel { scale: some(), offset_rad: some(), low_pass: some() };
        let (theta, alpha) = (channel(), channel());
        let settings = Settings {
            theta,
            alpha,
            smooth_ticks: some(),
            smooth_step_rad: some(),
            law: [Law::None, Law::Switched, Law::Inverse][run % 3],
            u_p_plus_v: some(),
            u_p_minus_v: some(),
            eps_u_v: some(),
            eps_e_rad: some(),
            hysteresis_u: some(),
            hysteresis_e: some(),
            breakaway_plus_v: some(),
            breakaway_minus_v: some(),
            voltage_limit_v: some(),
            deflection_limit_rad: some(),
            theta_limit_rad: some(),
            theta_step_limit_rad: some(),
        };
        let coefficients: Vec<f64> = (0..18).map(|_| Some(some()).filter(|c| c.is_finite()).unwrap_or(0.5)).collect();
        let controller = Controller::new(2, &coefficients).unwrap();
        let mut memory = [0.0; 7];
        let mut state = State::new(&controller, &mut memory).unwrap();
        for _ in 0..5 {
            let measured = Measured { reference_rad: some(), theta_rad: some(), alpha_rad: some() };
            let before = state.fault();
            let commanded = tick(&settings, &controller, &mut state, measured);
            assert!(is_finite(&commanded), "{settings:?} {measured:?} {commanded:?}");
            assert_eq!(commanded.fault, state.fault());
            assert!(before == Fault::None || before == commanded.fault, "the first fault stays");
            let limit = settings.voltage_limit_v;
            assert!(commanded.voltage_v.abs() <= limit || commanded.voltage_v == 0.0);
            assert!(commanded.fault == Fault::None || commanded.voltage_v == 0.0);
        }
        faults[state.fault() as usize] += 1;
    }
    assert!(faults.iter().all(|&count| count > 100), "every outcome was met: {faults:?}");
}

#[test]
fn what_is_no_number_stops_the_rig_until_reset() {
    let controller = Controller::new(0, &PROPORTIONAL).unwrap();
    let mut memory = [0.0; 3];
    let mut state = State::new(&controller, &mut memory).unwrap();
    let s = Settings::default();
    let good = Measured { reference_rad: 0.1, theta_rad: 0.02, alpha_rad: 0.01 };
    for bad in [
        Measured { reference_rad: f64::NAN, ..good },
        Measured { theta_rad: f64::INFINITY, ..good },
        Measured { alpha_rad: f64::NAN, ..good },
    ] {
        assert!(tick(&s, &controller, &mut state, good).voltage_v > 0.1);
        let stopped = tick(&s, &controller, &mut state, bad);
        assert_eq!((stopped.voltage_v, stopped.fault), (0.0, Fault::NonFinite));
        let after = tick(&s, &controller, &mut state, good);
        assert_eq!((after.voltage_v, after.u_v, after.fault), (0.0, 0.0, Fault::NonFinite), "latched");
        assert_eq!(after.y_rad, 0.03, "the beam is still seen");
        state.reset();
    }
    assert!(tick(&s, &controller, &mut state, good).voltage_v > 0.1);
}

#[test]
fn a_result_that_overflows_is_a_fault_and_not_full_voltage() {
    let coefficients = [f64::MAX, 1.0, 0.0, 0.0];
    let controller = Controller::new(0, &coefficients).unwrap();
    let mut memory = [0.0; 3];
    let mut state = State::new(&controller, &mut memory).unwrap();
    let measured = Measured { reference_rad: 10.0, ..Measured::default() };
    let commanded = tick(&Settings::default(), &controller, &mut state, measured);
    assert_eq!((commanded.voltage_v, commanded.fault), (0.0, Fault::NonFinite));
}

#[test]
fn deflection_and_speed_beyond_their_limits_stop_the_rig() {
    let controller = Controller::new(0, &PROPORTIONAL).unwrap();
    let s =
        Settings { deflection_limit_rad: 0.2, theta_limit_rad: 0.5, theta_step_limit_rad: 0.02, ..Settings::default() };
    let still = Measured { reference_rad: 0.5, theta_rad: 0.3, alpha_rad: 0.1 };
    for (next, fault) in [
        (Measured { alpha_rad: 0.21, ..still }, Fault::Deflection),
        (Measured { theta_rad: 0.27, ..still }, Fault::Speed),
        (Measured { theta_rad: 0.501, ..still }, Fault::Angle),
        (Measured { theta_rad: 0.31, ..still }, Fault::None),
    ] {
        let mut memory = [0.0; 3];
        let mut state = State::new(&controller, &mut memory).unwrap();
        assert_eq!(tick(&s, &controller, &mut state, still).fault, Fault::None, "the first tick knows no speed");
        let commanded = tick(&s, &controller, &mut state, next);
        assert_eq!(commanded.fault, fault);
        assert_eq!(commanded.voltage_v == 0.0, fault != Fault::None);
        assert_eq!(tick(&s, &controller, &mut state, still).fault, fault, "latched");
    }
}

#[test]
fn measurements_are_scaled_then_filtered() {
    let controller = Controller::new(0, &PROPORTIONAL).unwrap();
    let mut memory = [0.0; 3];
    let mut state = State::new(&controller, &mut memory).unwrap();
    let theta = Channel { scale: 2.0, offset_rad: 0.1, low_pass: 0.25 };
    let s = Settings { theta, ..Settings::default() };
    let mut y = |theta_rad, alpha_rad| {
        tick(&s, &controller, &mut state, Measured { reference_rad: 0.0, theta_rad, alpha_rad }).y_rad
    };
    assert!((y(0.1, 0.05) - 0.05).abs() < 1e-15);
    assert!((y(0.3, 0.0) - 0.25 * 0.4).abs() < 1e-15);
    assert!((y(0.3, 0.0) - (0.1 + 0.25 * 0.3)).abs() < 1e-15);
}

#[test]
fn a_state_of_another_order_is_a_fault() {
    let coefficients = [0.5; 18];
    let second = Controller::new(2, &coefficients).unwrap();
    let zeroth = Controller::new(0, &PROPORTIONAL).unwrap();
    let mut memory = [0.0; 7];
    let mut state = State::new(&second, &mut memory).unwrap();
    let measured = Measured { reference_rad: 0.1, ..Measured::default() };
    let commanded = tick(&Settings::default(), &zeroth, &mut state, measured);
    assert_eq!((commanded.voltage_v, commanded.fault), (0.0, Fault::Order));
}

#[test]
fn wrong_lengths_and_coefficients_that_are_no_numbers_are_refused() {
    assert_eq!(Controller::new(1, &[0.0; 9]), Err(Error::Coefficients { order: 1, needed: 10, found: 9 }));
    assert!(Controller::new(usize::MAX, &[0.0; 4]).is_err());
    assert_eq!(Controller::new(0, &[0.0, 0.0, f64::NAN, 0.0]), Err(Error::NotFinite { index: 2 }));
    let controller = Controller::new(0, &PROPORTIONAL).unwrap();
    for found in [0, 2, 4] {
        let mut memory = vec![0.0; found];
        assert_eq!(State::new(&controller, &mut memory).unwrap_err(), Error::Memory { needed: 3, found });
    }
}
