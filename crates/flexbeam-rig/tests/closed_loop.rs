//! Simulated time around the kernel's tick.

use flexbeam_kernel::{Controller, Fault, Settings};
use flexbeam_lti::{Mat, Vector};
use flexbeam_rig::{Link, Output, RigParameters, SimulatedRig, StepMetrics, closed_loop};

/// u = 0.8 (v - y), y_model = v.
const PROPORTIONAL: [f64; 4] = [0.8, 1.0, -0.8, 0.0];

fn step(_: f64) -> f64 {
    0.5
}

/// The loop by hand: x(k+1) = Phi x(k) + Gamma u(k-d).
fn by_hand(parameters: &RigParameters, samples: usize) -> Vec<f64> {
    let model = parameters.linear_model(&[Output::Psi]).unwrap();
    let n = model.order();
    let mut augmented = Mat::zeros(n + 1, n + 1);
    augmented.view_mut((0, 0), (n, n)).copy_from(&model.A);
    augmented.view_mut((0, n), (n, 1)).copy_from(&model.B);
    let sampled = (augmented * parameters.period_s).exp();
    let (mut x, mut psi, mut u) = (Vector::zeros(n), Vec::new(), Vec::new());
    for k in 0..samples {
        psi.push((&model.C * &x)[0]);
        u.push(0.8 * (0.5 - psi[k]));
        let applied = k.checked_sub(parameters.computing_delay_periods).map_or(0.0, |k| u[k]);
        x = sampled.view((0, 0), (n, n)) * x + sampled.view((0, n), (n, 1)).column(0) * applied;
    }
    psi
}

#[test]
fn a_linear_loop_is_what_the_recursion_gives_with_any_delay() {
    let controller = Controller::new(0, &PROPORTIONAL).unwrap();
    for link in [Link::Lumped, Link::default()] {
        for computing_delay_periods in [0, 1, 3] {
            let parameters = RigParameters { link, computing_delay_periods, ..RigParameters::default().linear() };
            let mut rig = SimulatedRig::new(&parameters, 0).unwrap();
            let record = closed_loop(&mut rig, &Settings::default(), &controller, step, 3000);
            let wanted = by_hand(&parameters, 3000);
            let worst = record.psi_rad.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-12, "{link:?}, delay {computing_delay_periods}: {worst:e}");
            let sum = |k: usize| record.theta_rad[k] + record.alpha_rad[k];
            assert!((0..3000).all(|k| record.psi_rad[k] == sum(k)));
        }
    }
}

#[test]
fn the_dead_zone_leaves_a_proportional_loop_short_of_its_reference() {
    let controller = Controller::new(0, &PROPORTIONAL).unwrap();
    let run = |parameters: RigParameters| {
        let mut rig = SimulatedRig::new(&parameters, 1).unwrap();
        StepMetrics::of(&closed_loop(&mut rig, &Settings::default(), &controller, step, 8000)).unwrap()
    };
    let nonlinear = run(RigParameters::default());
    let linear = run(RigParameters::default().linear());
    // At rest |e| lies between nothing and breakaway/K(0).
    assert!(nonlinear.stationary_error_rad > 0.02, "{nonlinear:?}");
    assert!(nonlinear.stationary_error_rad < 0.28 / 0.8 + 0.005, "{nonlinear:?}");
    assert!(linear.stationary_error_rad < 1e-3, "{linear:?}");
    assert!(!nonlinear.limit_cycle && !linear.limit_cycle);
}

/// u = 200 (v - y) on a plant of relative degree four.
#[test]
fn an_unstable_loop_ends_in_a_limit_cycle_between_the_amplifiers_limits() {
    let coefficients = [200.0, 1.0, -200.0, 0.0];
    let controller = Controller::new(0, &coefficients).unwrap();
    let settings = Settings { deflection_limit_rad: f64::INFINITY, ..Settings::default() };
    let mut rig = SimulatedRig::new(&RigParameters::default(), 1).unwrap();
    let metrics = StepMetrics::of(&closed_loop(&mut rig, &settings, &controller, step, 5000)).unwrap();
    assert!(metrics.limit_cycle && metrics.settling_time_s.is_none(), "{metrics:?}");
    assert_eq!(metrics.peak_voltage_v, 10.0);
}

#[test]
fn a_fault_holds_zero_volts_and_is_recorded() {
    let coefficients = [20.0, 1.0, -20.0, 0.0];
    let controller = Controller::new(0, &coefficients).unwrap();
    let settings = Settings { deflection_limit_rad: 0.05, ..Settings::default() };
    let mut rig = SimulatedRig::new(&RigParameters::default(), 1).unwrap();
    let record = closed_loop(&mut rig, &settings, &controller, step, 1000);
    let (time_s, fault) = record.first_fault().unwrap();
    assert_eq!(fault, Fault::Deflection);
    let k = record.time_s.iter().position(|&t| t == time_s).unwrap();
    assert!(k > 0 && record.alpha_measured_rad[k].abs() > 0.05 && record.alpha_measured_rad[k - 1].abs() <= 0.05);
    assert!(record.voltage_v[k..].iter().all(|&v| v == 0.0));
    assert_eq!(record.samples(), 1000);
}

#[test]
fn the_record_as_signals_has_the_columns_by_name() {
    let controller = Controller::new(0, &PROPORTIONAL).unwrap();
    let mut rig = SimulatedRig::new(&RigParameters::default(), 1).unwrap();
    let record = closed_loop(&mut rig, &Settings::default(), &controller, step, 50);
    let signals = record.signals();
    assert_eq!((signals.channels(), signals.samples(), signals.period_s), (10, 50, 0.001));
    let row = signals.row("psi_rad").unwrap();
    assert!((0..50).all(|k| signals.data[(row, k)] == record.psi_rad[k]));
    let row = signals.row("alpha_measured_rad").unwrap();
    assert!((0..50).all(|k| signals.data[(row, k)] == record.alpha_measured_rad[k]));
}
