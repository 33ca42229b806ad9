//! Frequency responses without a model, against systems whose responses are known.

use flexbeam_ident::Error;
use flexbeam_ident::excitation::{Plan, Shape, white_gaussian};
use flexbeam_ident::spectrum::{Measured, Segments, averaged, circular_quantile, h1, repeats_after};
use flexbeam_lti::response::frequency_response;
use flexbeam_lti::simulation::simulate;
use flexbeam_lti::{Mat, Signals, StateSpace, Time, Vector};

const PERIOD_S: f64 = 0.01;

fn signals(data: Mat) -> Signals {
    let names: Vec<String> = (0..data.nrows()).map(|k| format!("channel{k}")).collect();
    Signals::new(names.clone(), names, PERIOD_S, data).unwrap()
}

fn white(rows: usize, samples: usize, rms: f64, seed: u64) -> Mat {
    let rows: Vec<Vec<f64>> =
        (0..rows).map(|r| white_gaussian(samples, rms, f64::INFINITY, 1000 * seed + r as u64)).collect();
    Mat::from_fn(rows.len(), samples, |r, t| rows[r][t])
}

/// A mode of 10 % damping at 5 Hz and a lag, two inputs, two outputs.
fn system() -> StateSpace {
    let pole = flexbeam_lti::C64::from_polar(0.97, 0.314);
    let A = Mat::from_row_slice(3, 3, &[pole.re, pole.im, 0.0, -pole.im, pole.re, 0.0, 0.0, 0.0, 0.8]);
    let B = Mat::from_row_slice(3, 2, &[1.0, 0.0, 0.3, 0.5, 0.2, 1.0]);
    let C = Mat::from_row_slice(2, 3, &[0.2, 0.1, 0.0, 0.0, 0.3, 0.4]);
    let D = Mat::from_row_slice(2, 2, &[0.0, 0.1, 0.5, 0.0]);
    StateSpace::new(A, B, C, D, Time::Sampled { period_s: PERIOD_S }).unwrap()
}

fn one_input() -> StateSpace {
    flexbeam_lti::connections::select(&system(), &[0, 1], &[0]).unwrap()
}

/// Errors over their standard deviations, all entries and frequencies.
fn normalised(found: &Measured, system: &StateSpace) -> Vec<f64> {
    let truth = frequency_response(system, &found.omega_rad_s).unwrap();
    let each = found.G.iter().zip(&truth).zip(&found.std);
    each.flat_map(|((G, truth), std)| (0..G.len()).map(|e| (G[e] - truth[e]).norm() / std[e]).collect::<Vec<f64>>())
        .collect()
}

/// With inputs that are correlated with each other: H1 needs their whole spectral matrix.
#[test]
fn h1_of_two_correlated_inputs_errs_as_its_standard_deviations_say() {
    let (mut squares, mut within, mut count) = (0.0_f64, 0.0, 0.0);
    for seed in 0..20 {
        let independent = white(2, 20_000, 1.0, seed);
        let U = Mat::from_row_slice(2, 2, &[1.0, 0.0, 0.8, 0.6]) * independent;
        let Y = simulate(&system(), &U, &Vector::zeros(3)).unwrap() + white(2, 20_000, 0.5, 500 + seed);
        let found = h1(&signals(U), &signals(Y), Segments { samples: 400 }).unwrap();
        assert_eq!(found.omega_rad_s.len(), 199);
        for off in normalised(&found, &system()) {
            squares += off * off;
            within += f64::from(off < circular_quantile(0.95));
            count += 1.0;
        }
    }
    println!(
        "rms of errors over their std {:.3}, {:.2} % within 95 %",
        (squares / count).sqrt(),
        100.0 * within / count
    );
    assert!((0.95..1.05).contains(&(squares / count).sqrt()), "{}", (squares / count).sqrt());
    assert!((0.935..0.965).contains(&(within / count)), "{}", within / count);
}

/// White noise of a tenth of the power beside y = u: coherence 1/(1 + 0.1).
#[test]
fn coherence_is_the_explained_part_of_the_power() {
    let U = white(1, 100_000, 1.0, 1);
    let Y = &U + white(1, 100_000, 0.1f64.sqrt(), 2);
    let found = h1(&signals(U), &signals(Y), Segments { samples: 200 }).unwrap();
    let coherence = found.coherence.unwrap();
    let mean = coherence.iter().map(|at| at[0]).sum::<f64>() / coherence.len() as f64;
    assert!((mean - 1.0 / 1.1).abs() < 3e-3, "{mean}");
    let exact = h1(&signals(white(1, 2000, 1.0, 1)), &signals(2.0 * white(1, 2000, 1.0, 1)), Segments::of_record(2000));
    let exact = exact.unwrap();
    assert!(exact.G.iter().all(|G| (G[0] - 2.0).norm() < 1e-12));
    assert!(exact.coherence.unwrap().iter().all(|at| (at[0] - 1.0).abs() < 1e-12));
}

#[test]
fn inputs_that_are_one_input_are_refused_and_so_are_too_few_pieces() {
    let U = white(1, 1000, 1.0, 1);
    let twice = Mat::from_fn(2, 1000, |_, t| U[(0, t)]);
    let refused = h1(&signals(twice), &signals(U.clone()), Segments { samples: 100 });
    assert_eq!(refused.unwrap_err(), Error::NotExciting { rank: 1, needed: 2, block_rows: 1 });
    let few = h1(&signals(U.clone()), &signals(U.clone()), Segments { samples: 800 });
    assert!(matches!(few, Err(Error::Setting { found: 1.0, .. })), "{few:?}");
    let short = h1(&signals(U.clone()), &signals(U), Segments { samples: 8 });
    assert!(matches!(short, Err(Error::Setting { found: 8.0, .. })), "{short:?}");
}

const PLAN: Plan = Plan {
    shape: Shape::OddMultisine,
    band_hz: Some([0.1, 20.0]),
    rms_v: 1.0,
    peak_v: 10.0,
    periods: 10,
    samples: 10_000,
    period_s: PERIOD_S,
    seed: 1,
};

fn voltage(plan: Plan) -> Mat {
    let found = plan.excitation().unwrap();
    assert_eq!(repeats_after(&found.voltage_v), found.period_samples);
    Mat::from_row_slice(1, found.voltage_v.len(), &found.voltage_v)
}

/// The response is exact without noise, once the transient is over; with noise it errs as it says.
#[test]
fn averaged_periods_err_as_their_standard_deviations_say() {
    let U = voltage(PLAN);
    let Y = simulate(&one_input(), &U, &Vector::zeros(3)).unwrap();
    let clean = averaged(&signals(U.clone()), &signals(Y.clone()), 1000, 1).unwrap();
    assert_eq!(clean.periods, 9);
    let truth = frequency_response(&one_input(), &clean.measured.omega_rad_s).unwrap();
    let worst = clean.measured.G.iter().zip(&truth).map(|(G, truth)| (G - truth).norm()).fold(0.0, f64::max);
    assert!(worst < 1e-10, "{worst}");

    let (mut squares, mut count, mut silent) = (0.0_f64, 0.0, 0.0);
    for seed in 0..10 {
        let noisy = &Y + white(2, Y.ncols(), 0.3, seed);
        let found = averaged(&signals(U.clone()), &signals(noisy), 1000, 1).unwrap();
        for off in normalised(&found.measured, &one_input()) {
            squares += off * off;
            count += 1.0;
        }
        silent += 0.1 * found.even.over_noise(0);
    }
    // The variance comes from nine periods: |t|^2 of 8 complex degrees of freedom has the mean 8/7.
    let ratio = (squares / count * 7.0 / 8.0).sqrt();
    println!("rms of errors over their std {ratio:.3}; silent lines over their noise {silent:.3}");
    assert!((0.93..1.07).contains(&ratio), "{ratio}");
    assert!((0.93..1.07).contains(&silent), "{silent}");
}

/// A square answers on even harmonics and a cube on odd ones that were not sent, each at the level of its own Fourier lines.
#[test]
fn squares_and_cubes_are_told_apart() {
    let U = voltage(PLAN);
    let with = |square: f64, cube: f64| {
        let Y = U.map(|u| u + square * u * u + cube * u * u * u) + white(1, U.ncols(), 1e-3, 3);
        averaged(&signals(U.clone()), &signals(Y), 1000, 0).unwrap()
    };
    let (none, square, cube) = (with(0.0, 0.0), with(0.01, 0.0), with(0.0, 0.01));
    let levels = |found: &flexbeam_ident::spectrum::Averaged| (found.odd.over_noise(0), found.even.over_noise(0));
    println!(
        "odd and even over noise: linear {:?}, square {:?}, cube {:?}",
        levels(&none),
        levels(&square),
        levels(&cube)
    );
    assert!(levels(&none).0 < 1.5 && levels(&none).1 < 1.5);
    assert!(levels(&square).0 < 1.5 && levels(&square).1 > 10.0);
    assert!(levels(&cube).0 > 10.0 && levels(&cube).1 < 1.5);
    // Parseval: the even lines up to the band's end hold what the square of the input has there.
    let squared = U.map(|u| 0.01 * u * u);
    let power: f64 = (2..200usize)
        .step_by(2)
        .map(|k| {
            let turn = |t: usize| flexbeam_lti::C64::cis(-std::f64::consts::TAU * (k * t % 1000) as f64 / 1000.0);
            let line: flexbeam_lti::C64 = (0..1000).map(|t| turn(t) * squared[(0, t)]).sum();
            (2.0 / 1000.0 * line.norm()).powi(2)
        })
        .sum();
    let found: f64 = square.even.amplitude.iter().map(|at| at[0] * at[0]).sum();
    assert!((found / power - 1.0).abs() < 0.02, "{found} {power}");
}

/// An integrator carries the transient along as an offset, an even drift as a line.
#[test]
fn an_integrator_s_drift_is_no_response() {
    let U = voltage(PLAN);
    let mut sum = 0.0;
    let Y = Mat::from_fn(1, U.ncols(), |_, t| {
        let y = sum + 0.02 * t as f64;
        sum += U[(0, t)];
        y
    });
    let found = averaged(&signals(U), &signals(Y), 1000, 1).unwrap().measured;
    for (omega, G) in found.omega_rad_s.iter().zip(&found.G) {
        let truth = (flexbeam_lti::C64::cis(omega * PERIOD_S) - 1.0).inv();
        assert!((G[0] - truth).norm() < 1e-9 * truth.norm(), "at {omega} rad/s: {} {truth}", G[0]);
    }
}

#[test]
fn what_has_no_periods_to_average_is_refused() {
    let U = voltage(PLAN);
    let of = |inputs: Mat, period: usize, run_in: usize| {
        averaged(&signals(inputs.clone()), &signals(inputs), period, run_in).unwrap_err()
    };
    assert!(matches!(of(U.clone(), 1000, 9), Error::Setting { found: 1.0, .. }));
    assert!(matches!(of(U.clone(), 4, 0), Error::Setting { found: 4.0, .. }));
    assert!(matches!(of(white(2, 100, 1.0, 1), 10, 0), Error::Setting { found: 2.0, .. }));
    assert!(matches!(of(Mat::zeros(1, 100), 10, 0), Error::NotExciting { .. }));
}
