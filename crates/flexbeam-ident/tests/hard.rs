//! Systems and records at the edge: correct, or told why not.

use flexbeam_ident::excitation::white_gaussian;
use flexbeam_ident::{Doubt, Identified, Options, Order, identify};
use flexbeam_lti::{C64, Mat, Signals, StateSpace, Time, Vector, sampling, simulation};
use flexbeam_rig::{Lumped, Output};

fn channels(name: &str, period_s: f64, data: Mat) -> Signals {
    Signals::new(vec![name.into()], vec![String::new()], period_s, data).unwrap()
}

/// White input, white noise of `part` of the output's rms.
fn identified(system: &StateSpace, period_s: f64, samples: usize, part: f64, options: Options) -> Identified {
    let U = Mat::from_row_slice(1, samples, &white_gaussian(samples, 1.0, 9.0, 3));
    let Y = simulation::simulate(system, &U, &Vector::zeros(system.order())).unwrap();
    let rms = Y.norm() / (samples as f64).sqrt();
    let noise = Mat::from_row_slice(1, samples, &white_gaussian(samples, 1.0, 9.0, 4)) * (part * rms);
    identify(&channels("u", period_s, U), &channels("y", period_s, Y + noise), &options).unwrap()
}

/// omega = 30 rad/s, zeta = 1e-4: rings for 3000 periods. Two seconds show 10 of them.
#[test]
fn a_mode_damped_by_one_part_in_ten_thousand() {
    let (omega, zeta, period_s) = (30.0_f64, 1e-4, 0.01);
    let s = C64::new(-zeta * omega, omega * (1.0 - zeta * zeta).sqrt());
    let z = (s * period_s).exp();
    let A = Mat::from_row_slice(2, 2, &[z.re, z.im, -z.im, z.re]);
    let one = |a: f64, b: f64| (Mat::from_column_slice(2, 1, &[a, b]), Mat::from_row_slice(1, 2, &[b, a]));
    let (B, C) = one(0.3, 1.0);
    let system = StateSpace::new(A, B, C, Mat::zeros(1, 1), Time::Sampled { period_s }).unwrap();
    for (part, of_omega, of_zeta) in [(0.0, 1e-10, 1e-7), (0.01, 1e-4, 0.3)] {
        let found = identified(&system, period_s, 10_000, part, Options::default());
        assert_eq!(found.order, 2);
        let pole = found.continuous.unwrap().poles()[0];
        let errors = ((pole.norm() / omega - 1.0).abs(), (-pole.re / pole.norm() / zeta - 1.0).abs());
        println!("noise {part}: frequency off by {:.1e}, damping ratio by {:.1e}", errors.0, errors.1);
        assert!(errors.0 < of_omega && errors.1 < of_zeta, "noise {part}: {errors:?}");
    }
}

/// The deflection at 10 us in place of 1 ms: exact without noise, and in any case told that the block rows see nothing move.
#[test]
fn sampling_a_hundred_times_too_fast_is_told() {
    let period_s = 1e-5;
    let plant = sampling::zoh(&Lumped::PAPER.state_space(&[Output::Alpha]).unwrap(), period_s).unwrap();
    let found = identified(&plant, period_s, 100_000, 0.0, Options { order: Order::Fixed(3), ..Options::default() });
    assert!(matches!(found.doubts[..], [Doubt::Slow { .. }]), "{:?}", found.doubts);
    // -34.872, -11.414 +- 23.21j: the slowest of them moves by 3e-4 a sample.
    let poles = found.continuous.unwrap().poles();
    let real = poles.iter().find(|p| p.im == 0.0).expect("one real pole").re;
    println!("100 times too fast, no noise: real pole {real:.6}");
    assert!((real / -34.8717 - 1.0).abs() < 1e-4, "{real}");
    let noisy = identified(&plant, period_s, 100_000, 0.01, Options::default());
    assert!(
        matches!(noisy.doubts[..], [Doubt::Slow { percent, block_rows: 20 }] if percent < 5.0),
        "{:?}",
        noisy.doubts
    );
    let normal = sampling::zoh(&Lumped::PAPER.state_space(&[Output::Alpha]).unwrap(), 0.001).unwrap();
    assert_eq!(identified(&normal, 0.001, 10_000, 0.01, Options::default()).doubts, []);
}

/// (z - 0.8)^3 in one chain: poles scatter by the third root of rounding, the response does not.
#[test]
fn repeated_poles_keep_the_response() {
    let A = Mat::from_row_slice(3, 3, &[0.8, 1.0, 0.0, 0.0, 0.8, 1.0, 0.0, 0.0, 0.8]);
    let (B, C) = (Mat::from_column_slice(3, 1, &[0.2, 0.5, 1.0]), Mat::from_row_slice(1, 3, &[1.0, -0.4, 0.3]));
    let system = StateSpace::new(A, B, C, Mat::zeros(1, 1), Time::Sampled { period_s: 1.0 }).unwrap();
    let found = identified(&system, 1.0, 4000, 0.0, Options::default());
    assert_eq!(found.order, 3);
    let error = |k: i32| {
        let z = C64::from_polar(1.0, 0.0314 * f64::from(k));
        let (G, wanted) = (found.model.at(z)[(0, 0)], system.at(z)[(0, 0)]);
        (G - wanted).norm() / wanted.norm()
    };
    let worst = (0..=100).map(error).fold(0.0, f64::max);
    println!("three poles at 0.8: response within {worst:.1e}");
    assert!(worst < 1e-8, "{worst:e}");
    assert!(found.model.poles().iter().all(|p| (p - 0.8).norm() < 1e-3));
}
