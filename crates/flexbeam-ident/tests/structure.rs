//! What is known or asked of a model beside its order: delay, D = 0, stable poles, innovations.

use flexbeam_ident::excitation::white_gaussian;
use flexbeam_ident::{Delay, Doubt, Error, Feedthrough, Identified, Options, Order, Poles, identify};
use flexbeam_lti::{C64, Mat, Signals, StateSpace, Time, Vector, simulation};

const SAMPLES: usize = 4000;

/// Two inputs, two outputs, three states, no feedthrough.
fn system() -> StateSpace {
    let A = Mat::from_row_slice(3, 3, &[0.8, 0.5, 0.0, -0.5, 0.8, 0.0, 0.0, 0.0, 0.6]);
    let B = Mat::from_row_slice(3, 2, &[1.0, 0.2, -0.5, 1.0, 0.7, 0.7]);
    let C = Mat::from_row_slice(2, 3, &[1.0, 0.4, 0.5, 0.3, -1.0, 1.0]);
    StateSpace::new(A, B, C, Mat::zeros(2, 2), Time::Sampled { period_s: 0.1 }).unwrap()
}

fn channels(letter: &str, data: Mat) -> Signals {
    let names = (0..data.nrows()).map(|c| format!("{letter}{c}")).collect();
    Signals::new(names, vec![String::new(); data.nrows()], 0.1, data).unwrap()
}

fn white(channels: usize, rms: f64, seed: u64) -> Mat {
    Mat::from_column_slice(channels, SAMPLES, &white_gaussian(channels * SAMPLES, rms, f64::INFINITY, seed))
}

fn identified(U: &Mat, Y: &Mat, options: Options) -> Result<Identified, Error> {
    let options = Options { block_rows: 8, ..options };
    identify(&channels("u", U.clone()), &channels("y", Y.clone()), &options)
}

/// Largest |G - G0| over the unit circle, relative to the largest |G0|.
fn response_error(found: &StateSpace, wanted: &StateSpace) -> f64 {
    let at = |k: i32| C64::from_polar(1.0, std::f64::consts::PI * f64::from(k) / 100.0);
    let norm = |M: flexbeam_lti::CMat| M.iter().map(|g| g.norm()).fold(0.0, f64::max);
    let missed = (0..=100).map(|k| norm(found.at(at(k)) - wanted.at(at(k)))).fold(0.0, f64::max);
    missed / (0..=100).map(|k| norm(wanted.at(at(k)))).fold(0.0, f64::max)
}

/// u1 five samples late, u2 two: found, carried as states, exact without noise, initial state and all.
#[test]
fn delays_are_found_and_carried() {
    let wanted = system();
    let delayed = |U: &Mat, delays: [usize; 2]| {
        Mat::from_fn(2, SAMPLES, |c, k| if k >= delays[c] { U[(c, k - delays[c])] } else { 0.1 })
    };
    let U = white(2, 1.0, 3);
    let Y = simulation::simulate(&wanted, &delayed(&U, [5, 2]), &Vector::from_element(3, 0.4)).unwrap();
    let found = identified(&U, &Y, Options { delay: Delay::Auto, ..Options::default() }).unwrap();
    assert_eq!((found.input_delay.as_slice(), found.order), (&[5, 2][..], 10));
    assert!(
        found.estimation_fit_percent.iter().chain(found.fit_percent.as_ref().unwrap()).all(|fit| *fit > 100.0 - 1e-8)
    );
    assert_eq!(found.estimation_samples, SAMPLES / 2);
    // z^-5 and z^-2 in front of the system.
    let error = |k: i32| {
        let z = C64::from_polar(1.0, 0.05 * f64::from(k));
        let mut G = wanted.at(z);
        G.column_mut(0).iter_mut().for_each(|g| *g /= z.powi(5));
        G.column_mut(1).iter_mut().for_each(|g| *g /= z.powi(2));
        (found.model.at(z) - G).norm()
    };
    assert!((1..60).map(error).fold(0.0, f64::max) < 1e-9);
    // From the state at the first sample the recording follows, inputs of before the recording included.
    let simulated = simulation::simulate(&found.model, &U, &found.initial_state).unwrap();
    assert!((simulated - &Y).norm() < 1e-9 * Y.norm());
    let reason = found.continuous.unwrap_err().to_string();
    assert!(reason.contains('0'), "{reason}");
    let known = identified(&U, &Y, Options { delay: Delay::Samples(2), ..Options::default() }).unwrap();
    assert_eq!(known.input_delay, [2, 2]);
    assert!(known.fit_percent.unwrap().iter().all(|fit| *fit > 100.0 - 1e-6), "three more states make up for it");
    let alone = identified(&U, &white(2, 1.0, 8), Options { delay: Delay::Auto, ..Options::default() });
    assert_eq!(alone.unwrap_err(), Error::NoAnswer { input: 0, lags: 8 });
}

#[test]
fn a_known_absent_feedthrough_is_absent_and_helps() {
    let wanted = system();
    let U = white(2, 1.0, 5);
    let (mut free, mut known) = (0.0, 0.0);
    for seed in 0..10 {
        let Y = simulation::simulate(&wanted, &U, &Vector::zeros(3)).unwrap() + white(2, 0.5, 50 + seed);
        let with = |feedthrough| {
            let found =
                identified(&U, &Y, Options { feedthrough, order: Order::Fixed(3), ..Options::default() }).unwrap();
            assert_eq!(found.model.D == Mat::zeros(2, 2), feedthrough == Feedthrough::Zero);
            response_error(&found.model, &wanted)
        };
        free += with(Feedthrough::Free);
        known += with(Feedthrough::Zero);
    }
    println!("mean error of the response over ten seeds: D estimated {:.2e}, D = 0 {:.2e}", free / 10.0, known / 10.0);
    assert!(known < free);
}

/// A hardly damped swing in noise: half of the estimates come out unstable; asked for, none does, and the fits are better.
#[test]
fn stable_poles_are_stable_on_request() {
    let (c, s) = (0.3_f64.cos(), 0.3_f64.sin());
    let A = Mat::from_row_slice(2, 2, &[c, s, -s, c]) * 0.9999;
    let wanted = StateSpace {
        A,
        B: Mat::from_row_slice(2, 1, &[1.0, 0.3]),
        C: Mat::from_row_slice(1, 2, &[1.0, 0.0]),
        D: Mat::zeros(1, 1),
        ..system()
    };
    let radius = |found: &Identified| found.model.poles().iter().map(|p| p.norm()).fold(0.0, f64::max);
    let (mut unstable, mut sums) = (0, [0.0; 2]);
    for seed in 0..12 {
        let U = white(1, 1.0, 700 + seed);
        let Y = simulation::simulate(&wanted, &U, &Vector::zeros(2)).unwrap() + white(1, 20.0, 900 + seed);
        let with = |poles| identified(&U, &Y, Options { poles, order: Order::Fixed(2), ..Options::default() }).unwrap();
        let (free, stable) = (with(Poles::Free), with(Poles::Stable));
        if radius(&free) < 1.0 {
            assert_eq!(free.model, stable.model, "a stable model stays as it is");
            continue;
        }
        unstable += 1;
        assert!(radius(&stable) < 1.0);
        let fit = |found: &Identified| found.fit_percent.as_ref().unwrap()[0];
        sums = [sums[0] + fit(&free), sums[1] + fit(&stable)];
        println!(
            "seed {seed}: radius {:.5} -> {:.5}, fit {:.1} -> {:.1} %",
            radius(&free),
            radius(&stable),
            fit(&free),
            fit(&stable)
        );
    }
    assert!(sums[1] > sums[0], "{sums:?}");
    assert!(unstable >= 3, "{unstable} unstable estimates do not test anything");
}

/// Innovations form with a known K: its impulse response and the covariance come back, in any coordinates.
#[test]
fn innovations_come_back() {
    let wanted = system();
    let K = Mat::from_row_slice(3, 2, &[0.52, -0.16, 0.05, -0.43, 0.14, 0.14]);
    let root = Mat::from_row_slice(2, 2, &[0.3, 0.0, 0.1, 0.2]);
    let (U, e) = (white(2, 1.0, 5), &root * white(2, 1.0, 6));
    let (mut x, mut Y) = (Vector::zeros(3), Mat::zeros(2, SAMPLES));
    for k in 0..SAMPLES {
        Y.set_column(k, &(&wanted.C * &x + e.column(k)));
        x = &wanted.A * &x + &wanted.B * U.column(k) + &K * e.column(k);
    }
    let found = identified(&U, &Y, Options { estimate: 1.0, order: Order::Fixed(3), ..Options::default() }).unwrap();
    let innovations = found.innovations.unwrap();
    let response = |A: &Mat, C: &Mat, K: &Mat| (0..10).map(|k| C * A.pow(k) * K).collect::<Vec<Mat>>();
    let (ours, theirs) = (response(&found.model.A, &found.model.C, &innovations.K), response(&wanted.A, &wanted.C, &K));
    let missed = ours.iter().zip(&theirs).map(|(a, b)| (a - b).norm_squared()).sum::<f64>().sqrt();
    let size = theirs.iter().map(|b| b.norm_squared()).sum::<f64>().sqrt();
    let covariance = &root * root.transpose();
    let off = (&innovations.covariance - &covariance).norm() / covariance.norm();
    println!("innovations: response within {:.1} %, covariance within {:.1} %", 100.0 * missed / size, 100.0 * off);
    assert!(missed < 0.1 * size && off < 0.1);
    let predictor = &found.model.A - &innovations.K * &found.model.C;
    assert!(predictor.complex_eigenvalues().iter().all(|z| z.norm() < 1.0));
    // Other units of the outputs: K over them, the covariance times their squares.
    let scaled = Mat::from_fn(2, SAMPLES, |p, k| Y[(p, k)] * [1e6, 1e-6][p]);
    let other =
        identified(&U, &scaled, Options { estimate: 1.0, order: Order::Fixed(3), ..Options::default() }).unwrap();
    let ratio = other.innovations.unwrap().covariance[(0, 1)] / innovations.covariance[(0, 1)];
    assert!((ratio - 1.0).abs() < 1e-6, "{ratio}");
}

#[test]
fn without_noise_there_are_no_innovations_and_no_doubts() {
    let U = white(2, 1.0, 5);
    let Y = simulation::simulate(&system(), &U, &Vector::from_element(3, 1.0)).unwrap();
    let found = identified(&U, &Y, Options::default()).unwrap();
    assert_eq!(found.innovations, None);
    assert_eq!(found.doubts, []);
}

/// u = -K y and nothing from outside: refused with the reason; with a test signal: identified, with a word.
#[test]
fn a_closed_loop_needs_something_from_outside() {
    let wanted = StateSpace { B: system().B.columns(0, 1).into_owned(), D: Mat::zeros(2, 1), ..system() };
    let K = Mat::from_row_slice(1, 2, &[0.2, 0.1]);
    let looped = |outside: f64, outputs: usize, options: Options| {
        let (r, e, disturbance) = (white(1, outside, 21), white(2, 0.3, 22), white(3, 0.3, 23));
        let (mut x, mut U, mut Y) = (Vector::from_element(3, 1.0), Mat::zeros(1, SAMPLES), Mat::zeros(2, SAMPLES));
        for k in 0..SAMPLES {
            let mut y = &wanted.C * &x + e.column(k);
            x += disturbance.column(k);
            if outputs == 1 {
                y[1] = 0.0;
            }
            let u = r.column(k) - &K * &y;
            x = &wanted.A * &x + &wanted.B * &u;
            U.set_column(k, &u);
            Y.set_column(k, &y);
        }
        identified(&U, &Y.rows(0, outputs).into_owned(), options)
    };
    let three = || Options { order: Order::Fixed(3), ..Options::default() };
    let refused = looped(0.0, 2, three()).unwrap_err();
    assert!(matches!(refused, Error::ClosedLoop { .. }), "{refused}");
    let told = looped(0.3, 2, three()).unwrap().doubts;
    assert!(matches!(told[..], [Doubt::Feedback { percent }] if percent > 5.0), "{told:?}");
    // One output and a proportional controller: y = -u/K without remainder, as a static system would have it.
    assert_eq!(looped(0.0, 1, three()).unwrap_err(), Error::NoState);
}
