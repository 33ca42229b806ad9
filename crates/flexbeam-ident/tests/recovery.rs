//! Systems with many channels, extreme scales, unstable poles: what comes back is compared by what coordinates cannot change.

use flexbeam_ident::excitation::white_gaussian;
use flexbeam_ident::{Identified, Method, Options, Order, identify};
use flexbeam_lti::{C64, Mat, Signals, StateSpace, Time, Vector, simulation};

const SAMPLES: usize = 4000;

/// Five states: an oscillation, a slow and two quick modes, mixed into `inputs` and `outputs` channels.
fn system(inputs: usize, outputs: usize) -> StateSpace {
    let mix = |r: usize, c: usize| (((r + 1) * (c + 2)) as f64 * 1.7).sin();
    #[rustfmt::skip]
    let A = Mat::from_row_slice(5, 5, &[
        0.8,  0.5, 0.0,  0.0, 0.1,
       -0.5,  0.8, 0.0,  0.0, 0.0,
        0.0,  0.0, 0.95, 0.0, 0.0,
        0.0,  0.0, 0.0,  0.4, 0.3,
        0.0,  0.0, 0.0, -0.3, 0.4,
    ]);
    let B = Mat::from_fn(5, inputs, mix);
    let C = Mat::from_fn(outputs, 5, |r, c| mix(c + 2, r));
    let D = Mat::from_fn(outputs, inputs, |r, c| 0.3 * mix(r + 4, c));
    StateSpace::new(A, B, C, D, Time::Sampled { period_s: 0.1 }).unwrap()
}

fn channels(letter: &str, data: Mat) -> Signals {
    let names: Vec<String> = (0..data.nrows()).map(|c| format!("{letter}{c}")).collect();
    Signals::new(names, vec![String::new(); data.nrows()], 0.1, data).unwrap()
}

/// White inputs; outputs with white noise of this part of each output's rms.
fn record(system: &StateSpace, noise: f64, seed: u64) -> (Mat, Mat) {
    let m = system.inputs();
    let U = Mat::from_column_slice(m, SAMPLES, &white_gaussian(m * SAMPLES, 1.0, 9.0, seed));
    let x0 = Vector::from_element(system.order(), 0.7);
    let mut Y = simulation::simulate(system, &U, &x0).unwrap();
    for p in 0..Y.nrows() {
        let rms = Y.row(p).norm() / (SAMPLES as f64).sqrt();
        let e = white_gaussian(SAMPLES, noise * rms, f64::INFINITY, seed + 100 + p as u64);
        (0..SAMPLES).for_each(|k| Y[(p, k)] += e[k]);
    }
    (U, Y)
}

fn identified(U: Mat, Y: Mat, method: Method, order: Order) -> Identified {
    let options = Options { block_rows: 8, method, order, ..Options::default() };
    identify(&channels("u", U), &channels("y", Y), &options).unwrap()
}

/// Largest |G - G0| over the unit circle, relative to the largest |G0|, entries weighted by the channels' scales.
fn response_error(found: &StateSpace, wanted: &StateSpace, u: &[f64], y: &[f64]) -> f64 {
    let (mut missed, mut size) = (0.0_f64, 0.0_f64);
    for k in 0..=100 {
        let z = C64::from_polar(1.0, std::f64::consts::PI * f64::from(k) / 100.0);
        let (G, G0) = (found.at(z), wanted.at(z));
        for r in 0..G.nrows() {
            for c in 0..G.ncols() {
                size = size.max(G0[(r, c)].norm());
                missed = missed.max((G[(r, c)] * u[c] / y[r] - G0[(r, c)]).norm());
            }
        }
    }
    missed / size
}

#[test]
fn many_channels_without_noise_are_exact_by_every_method() {
    for (m, l) in [(1, 1), (3, 1), (1, 3), (2, 3)] {
        let wanted = system(m, l);
        let (U, Y) = record(&wanted, 0.0, 5);
        for method in [Method::Auto, Method::Paper, Method::N4sid, Method::Moesp, Method::Cva] {
            let found = identified(U.clone(), Y.clone(), method, Order::Auto);
            assert_eq!(found.order, 5, "{method:?}, {m} inputs, {l} outputs");
            let error = response_error(&found.model, &wanted, &vec![1.0; m], &vec![1.0; l]);
            assert!(error < 1e-9, "{method:?}, {m} inputs, {l} outputs: {error:e}");
            assert!(found.fit_percent.unwrap().iter().all(|fit| *fit > 100.0 - 1e-6));
        }
    }
}

/// 28 outputs make 600 rows; the signal-to-noise ratio differs from output to output.
#[test]
fn twenty_eight_outputs_with_noise_of_ten_percent_have_five_states() {
    let wanted = system(2, 28);
    let (U, Y) = record(&wanted, 0.1, 3);
    let found = identified(U, Y, Method::Auto, Order::Auto);
    assert_eq!(found.order, 5, "{:?}", &found.singular_values[..8]);
    let error = response_error(&found.model, &wanted, &[1.0; 2], &[1.0; 28]);
    println!("28 outputs, 10 % noise: {error:.1e}");
    assert!(error < 0.02, "{error:e}");
}

#[test]
fn many_channels_with_noise_are_close() {
    let wanted = system(2, 3);
    let mut errors: Vec<f64> = (0..8)
        .map(|seed| {
            let (U, Y) = record(&wanted, 0.01, 50 * seed);
            let found = identified(U, Y, Method::Auto, Order::Auto);
            assert_eq!(found.order, 5, "seed {seed}: {:?}", &found.singular_values[..8]);
            assert!(found.fit_percent.unwrap().iter().all(|fit| *fit > 98.5), "seed {seed}");
            response_error(&found.model, &wanted, &[1.0; 2], &[1.0; 3])
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    println!("response errors, 1 % noise: {errors:?}");
    assert!(errors[3] < 0.005 && errors[7] < 0.01, "{errors:?}");
}

/// Other units change rounding only; by powers of two not even that.
#[test]
fn extreme_channel_scales_change_nothing() {
    let wanted = system(2, 3);
    let (U, Y) = record(&wanted, 0.01, 7);
    let plain = identified(U.clone(), Y.clone(), Method::Auto, Order::Fixed(5));
    let (u, y) = ([1e12, 1e-12], [1e-12, 1e12, 3.0]);
    let scaled = |data: &Mat, by: &[f64]| Mat::from_fn(data.nrows(), data.ncols(), |r, k| data[(r, k)] * by[r]);
    let found = identified(scaled(&U, &u), scaled(&Y, &y), Method::Auto, Order::Fixed(5));
    let error = response_error(&found.model, &plain.model, &u, &y);
    println!("scales of 1e12: {error:.1e}");
    assert!(error < 1e-11, "{error:e}");
    let binary = identified(scaled(&U, &[2f64.powi(40), 2f64.powi(-40)]), Y, Method::Auto, Order::Fixed(5));
    assert_eq!(binary.model.A, plain.model.A);
}

#[test]
fn an_unstable_pole_is_found_in_closed_loop_and_kept() {
    let (s, pole) = (2000, 1.1);
    let white = white_gaussian(s, 1.0, 9.0, 3);
    let (mut U, mut Y, mut x) = (Mat::zeros(1, s), Mat::zeros(1, s), 0.0);
    for k in 0..s {
        let u = white[k] - 0.6 * x;
        (U[(0, k)], Y[(0, k)]) = (u, x);
        x = pole * x + u;
    }
    let found = identified(U, Y, Method::Auto, Order::Fixed(1));
    assert!((found.model.A[(0, 0)] - pole).abs() < 1e-10);
    assert!((found.model.B[0] * found.model.C[0] - 1.0).abs() < 1e-8);
}

/// Offsets that would pass for a slow state: the means go, and so do the Hankel rows' own.
#[test]
fn offsets_are_removed_on_request() {
    let wanted = system(2, 2);
    let (U, Y) = record(&wanted, 0.0, 9);
    for constant_row in [false, true] {
        let options =
            Options { block_rows: 8, order: Order::Fixed(5), remove_mean: true, constant_row, ..Options::default() };
        let found =
            identify(&channels("u", U.add_scalar(30.0)), &channels("y", Y.add_scalar(-50.0)), &options).unwrap();
        let error = response_error(&found.model, &wanted, &[1.0; 2], &[1.0; 2]);
        assert!(found.input_means.iter().all(|mean| (mean - 30.0).abs() < 0.2));
        // The means of a finite record are not the offsets themselves; the row of ones needs not know them.
        let tolerance = if constant_row { 2e-3 } else { 2e-2 };
        println!("offsets, row of ones {constant_row}: {error:.1e}");
        assert!(error < tolerance, "row of ones {constant_row}: {error:e}");
    }
}
