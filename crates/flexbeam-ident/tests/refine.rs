//! Refinement: the five recordings, the tip angle of the paper's plant, and what is promised of any start.

use std::ops::ControlFlow;
use std::path::PathBuf;

use flexbeam_ident::excitation::white_gaussian;
use flexbeam_ident::refine::{Criterion, Errors, Progress, Reason, Refined, Settings, refine, refine_identified};
use flexbeam_ident::validate::validate;
use flexbeam_ident::{Error, Feedthrough, Identified, Method, Options, Order, Poles, identify};
use flexbeam_lti::{C64, Mat, Signals, StateSpace, Time, Vector, sampling, simulation};
use flexbeam_rig::{Lumped, Output};

fn on(_: &Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn signals(period_s: f64, data: &Mat) -> Signals {
    let names: Vec<String> = (0..data.nrows()).map(|k| format!("channel {k}")).collect();
    Signals::new(names.clone(), names, period_s, data.clone()).unwrap()
}

struct Case {
    file: &'static str,
    inputs: &'static [usize],
    outputs: &'static [usize],
    period_s: f64,
    block_rows: usize,
    order: usize,
    /// Best fit on the estimating half of SLICOT (N4SID, MOESP, both with B, D, x0 by simulation), SIPPY and nfoursid, same i and
    /// n, and of our own three weightings: book, Measurements.
    peers_percent: f64,
    /// Validation: a guard against change.
    least_unseen_percent: f64,
}

#[rustfmt::skip]
const CASES: [Case; 5] = [
    Case { file: "robot_arm.dat", inputs: &[0], outputs: &[1], period_s: 1.0, block_rows: 20, order: 4, peers_percent: 97.10, least_unseen_percent: 96.4 },
    Case { file: "CD_player_arm.dat", inputs: &[0, 1], outputs: &[2, 3], period_s: 1.0, block_rows: 15, order: 8, peers_percent: 82.2, least_unseen_percent: 78.0 },
    Case { file: "dryer.dat", inputs: &[0], outputs: &[1], period_s: 0.08, block_rows: 15, order: 4, peers_percent: 89.39, least_unseen_percent: 86.7 },
    Case { file: "evaporator.dat", inputs: &[0, 1, 2], outputs: &[3, 4, 5], period_s: 1.0, block_rows: 10, order: 4, peers_percent: 49.88, least_unseen_percent: 47.0 },
    Case { file: "heating_system.dat", inputs: &[1], outputs: &[2], period_s: 2.0, block_rows: 15, order: 7, peers_percent: 92.88, least_unseen_percent: 90.0 },
];

fn folder() -> PathBuf {
    let workspace = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    std::env::var_os("FLEXBEAM_DATA").map(PathBuf::from).unwrap_or_else(|| workspace.join("../shared/data"))
}

/// None, loudly, when the recording is not there.
fn recording(case: &Case) -> Option<(Signals, Signals)> {
    let path = folder().join(case.file);
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("\n!!! LEFT OUT: {} is missing; set FLEXBEAM_DATA to its folder !!!\n", path.display());
        return None;
    };
    let rows: Vec<Vec<f64>> = text
        .lines()
        .map(|line| line.split_whitespace().map(|cell| cell.parse().expect("a number")).collect())
        .collect();
    let of = |columns: &[usize]| Mat::from_fn(columns.len(), rows.len(), |c, k| rows[k][columns[c]]);
    Some((signals(case.period_s, &of(case.inputs)), signals(case.period_s, &of(case.outputs))))
}

fn mean(fits: &[f64]) -> f64 {
    fits.iter().sum::<f64>() / fits.len() as f64
}

/// Required: better than every peer on the estimating half.
#[test]
fn recordings_are_met_better_than_by_any_peer() {
    for case in &CASES {
        let Some((inputs, outputs)) = recording(case) else { continue };
        let (block_rows, order) = (case.block_rows, Order::Fixed(case.order));
        let options = Options { block_rows, order, remove_mean: true, ..Options::default() };
        let found = identify(&inputs, &outputs, &options).expect(case.file);
        let settings = Settings { offset: true, ..Settings::default() };
        let (better, refined) = refine_identified(&found, &inputs, &outputs, &settings, &mut on).unwrap();
        let [before, after] = [&found, &better].map(|model| mean(&model.estimation_fit_percent));
        let unseen = |model: &Identified| mean(model.fit_percent.as_ref().unwrap());
        println!(
            "{:20} estimating {before:.2} -> {after:.2} % (peers {}), unseen {:.2} -> {:.2} %; {:?} after {}",
            case.file,
            case.peers_percent,
            unseen(&found),
            unseen(&better),
            refined.reason,
            refined.iterations
        );
        assert!(after > case.peers_percent && after >= before, "{}: {before} -> {after}", case.file);
        assert!(unseen(&better) > case.least_unseen_percent, "{}: {}", case.file, unseen(&better));
        // The promise, by the simulation that the refinement did not use.
        assert!(refined.missed_after <= refined.missed_before);
        assert!((refined.missed_after - (1.0 - after / 100.0)).abs() < 2e-3, "{}: {}", case.file, refined.missed_after);
    }
}

/// Voltage, tip angle, and tip angle with 1 % noise.
fn tip_angle(period_s: f64, samples: usize, seed: u64) -> (Mat, Mat, Mat) {
    let plant = Lumped::PAPER.state_space(&[Output::Psi]).unwrap();
    let U = Mat::from_row_slice(1, samples, &white_gaussian(samples, 2.0, 10.0, seed));
    let clean = simulation::simulate(&sampling::zoh(&plant, period_s).unwrap(), &U, &Vector::zeros(4)).unwrap();
    let rms = clean.norm() / (samples as f64).sqrt();
    let noise = white_gaussian(samples, 0.01 * rms, f64::INFINITY, 1000 + seed);
    let noisy = &clean + Mat::from_row_slice(1, samples, &noise);
    (U, clean, noisy)
}

/// Against the output without noise.
fn fit(model: &StateSpace, U: &Mat, Y: &Mat) -> f64 {
    validate(model, U, Y).unwrap().mean_fit_percent()
}

const INTEGRATING: Settings = Settings {
    errors: Errors::Simulated,
    criterion: Criterion::Fit,
    integrators: 1,
    feedthrough: Feedthrough::Zero,
    poles: Poles::Free,
    offset: false,
    most_iterations: 200,
    tolerance: 1e-3,
};

fn median_and_worst(fits: &[f64]) -> (f64, f64) {
    let mut sorted = fits.to_vec();
    sorted.sort_by(f64::total_cmp);
    ((sorted[sorted.len() / 2] + sorted[(sorted.len() - 1) / 2]) / 2.0, sorted[0])
}

/// Required: above 99.8 % for each of 25 seeds. Whether the subspace method knows the integrator or not: then its model is often
/// useless (fits far below zero at 1 ms), and idle poles must find their places.
#[test]
fn the_tip_angle_with_one_percent_noise() {
    for (period_s, integrators) in [(0.001, 1), (0.005, 1), (0.001, 0), (0.005, 0)] {
        let (mut before, mut after) = (Vec::new(), Vec::new());
        for seed in 1..=25 {
            let (U, clean, noisy) = tip_angle(period_s, 10_000, seed);
            let (order, method) = (Order::Fixed(4), if integrators == 0 { Method::Moesp } else { Method::Auto });
            let options = Options { order, method, integrators, estimate: 1.0, ..Options::default() };
            let found = identify(&signals(period_s, &U), &signals(period_s, &noisy), &options).unwrap();
            let refined = refine(&found.model, &U, &noisy, &INTEGRATING, &mut on).unwrap();
            before.push(fit(&found.model, &U, &clean));
            after.push(fit(&refined.model, &U, &clean));
            assert!(refined.model.poles().contains(&C64::new(1.0, 0.0)) && refined.model.D[(0, 0)] == 0.0);
            assert_eq!(refined.reason, Reason::Settled, "{period_s}, seed {seed}");
        }
        let ((start, worst_start), (median, worst)) = (median_and_worst(&before), median_and_worst(&after));
        println!(
            "{period_s} s, {integrators} integrators known to the start: median {start:.2}, worst {worst_start:.2e}; \
             refined median {median:.3}, worst {worst:.3} %"
        );
        assert!(worst > 99.8, "{period_s}: {after:?}");
    }
}

/// Required: the error of the estimate is that of the noise alone: missed 1 % noise leaves (d/s)^1/2 of it, d = 11 with x(0).
#[test]
fn the_tip_angle_from_the_truth_perturbed_reaches_the_statistical_limit() {
    let truth = Lumped::PAPER;
    let mut errors = Vec::new();
    for seed in 1..=20 {
        let (U, clean, noisy) = tip_angle(0.001, 10_000, seed);
        let off = |k: usize, x: f64| x * (1.0 + 0.3 * ((seed as usize * 7 + k) as f64).sin());
        let [k1, k2, c, b] = truth.to_array();
        let start = Lumped { k1: off(1, k1), k2: off(2, k2) + 500.0, c: off(3, c), b: off(4, b) };
        let start = sampling::zoh(&start.state_space(&[Output::Psi]).unwrap(), 0.001).unwrap();
        let refined = refine(&start, &U, &noisy, &INTEGRATING, &mut on).unwrap();
        let simulated = simulation::simulate(&refined.model, &U, &refined.initial_state).unwrap();
        let noise = (&noisy - &clean).norm();
        errors.push((simulated - &clean).norm() / noise / (refined.parameters as f64 / 10_000.0).sqrt());
        // Required: within twice the limit for all, around it on the average.
        assert!(errors.last().unwrap() < &2.0, "seed {seed}: {errors:?}");
    }
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    println!("error over its statistical limit: {rms:.2}");
    assert!((0.7..1.3).contains(&rms), "{rms}");
}

fn system(seed: u64, n: usize, m: usize, l: usize) -> StateSpace {
    let random = white_gaussian(n * n + n * m + n * l + l * m, 1.0, 9.0, seed);
    let (A, rest) = random.split_at(n * n);
    let (B, rest) = rest.split_at(n * m);
    let (C, D) = rest.split_at(n * l);
    let A = Mat::from_row_slice(n, n, A);
    let radius = A.complex_eigenvalues().iter().map(|z| z.norm()).fold(0.0, f64::max);
    let matrices = [Mat::from_row_slice(n, m, B), Mat::from_row_slice(l, n, C), Mat::from_row_slice(l, m, D)];
    let [B, C, D] = matrices;
    StateSpace::new(A * (0.9 / radius), B, C, D, Time::Sampled { period_s: 1.0 }).unwrap()
}

fn perturbed(model: &StateSpace, part: f64, seed: u64) -> StateSpace {
    let StateSpace { A, B, C, D, time } = model.clone();
    let off = |M: Mat, salt: u64| {
        let noise = white_gaussian(M.len(), part * M.norm() / (M.len() as f64).sqrt(), 9.0, seed + salt);
        let noise = Mat::from_column_slice(M.nrows(), M.ncols(), &noise);
        M + noise
    };
    StateSpace::new(off(A, 1), off(B, 2), off(C, 3), off(D, 4), time).unwrap()
}

/// Part missed by a model from its own initial state, and by the best initial state: simulated here, not by the refinement.
fn missed(model: &StateSpace, x0: &Vector, U: &Mat, Y: &Mat) -> f64 {
    let rest = Y - simulation::simulate(model, U, x0).unwrap();
    let part = |p: usize| rest.row(p).norm() / Y.row(p).add_scalar(-Y.row(p).mean()).norm();
    (0..Y.nrows()).map(part).sum::<f64>() / Y.nrows() as f64
}

/// Whatever the start, the settings and the data, even data that no system made.
#[test]
fn never_worse_than_its_start() {
    for seed in 1..=30 {
        let (n, m, l) = (1 + seed as usize % 4, 1 + seed as usize % 2, 1 + seed as usize % 3);
        let white =
            |rows: usize, seed: u64| Mat::from_row_slice(rows, 400, &white_gaussian(rows * 400, 1.0, 9.0, seed));
        let (U, truth) = (white(m, seed), system(seed, n, m, l));
        let made = simulation::simulate(&truth, &U, &Vector::zeros(n)).unwrap() + white(l, seed + 50) * 0.3;
        let Y = if seed % 5 == 0 { white(l, seed + 90) } else { made };
        let start = perturbed(&truth, 0.1, 200 + seed);
        let poles = if seed % 2 == 0 { Poles::Stable } else { Poles::Free };
        let settings = Settings { poles, ..Settings::default() };
        let refined = refine(&start, &U, &Y, &settings, &mut on).unwrap();
        let (before, after) = (
            missed(&start, &validate(&start, &U, &Y).unwrap().initial_state, &U, &Y),
            missed(&refined.model, &refined.initial_state, &U, &Y),
        );
        assert!(after <= before * (1.0 + 1e-12), "seed {seed}: {before} -> {after}");
        assert!((refined.missed_after / after - 1.0).abs() < 1e-9, "seed {seed}: {} {after}", refined.missed_after);
        let stable = refined.model.poles().iter().all(|z| z.norm() < 1.0);
        let began_stable = start.poles().iter().all(|z| z.norm() < 1.0);
        assert!(stable || poles == Poles::Free || !began_stable, "seed {seed}");
    }
}

/// Without noise the truth comes back from a perturbed start, several inputs and outputs.
#[test]
fn without_noise_the_truth_comes_back() {
    for (seed, criterion) in [(1, Criterion::Fit), (2, Criterion::Likelihood), (3, Criterion::Fit)] {
        let truth = system(seed, 4, 2, 2);
        let U = Mat::from_row_slice(2, 500, &white_gaussian(1000, 1.0, 9.0, seed));
        let Y = simulation::simulate(&truth, &U, &Vector::from_element(4, 0.5)).unwrap();
        let settings = Settings { criterion, offset: seed == 3, ..Settings::default() };
        let offset = Vector::from_column_slice(if seed == 3 { &[2.0, -0.5] } else { &[0.0, 0.0] });
        let Y = Mat::from_fn(2, 500, |p, k| Y[(p, k)] + offset[p]);
        let refined = refine(&perturbed(&truth, 0.05, seed), &U, &Y, &settings, &mut on).unwrap();
        assert!((&refined.offset - offset).norm() < 1e-9, "{}", refined.offset);
        let error = |angle: f64| {
            let z = C64::from_polar(1.0, angle);
            (refined.model.at(z) - truth.at(z)).norm() / truth.at(z).norm()
        };
        let worst = (0..=20).map(|k| error(0.157 * f64::from(k))).fold(0.0, f64::max);
        println!("{criterion:?}: {worst:.1e}, {:?} after {}", refined.reason, refined.iterations);
        assert!(worst < 1e-9, "{criterion:?}: {worst:e} {:?}", refined.reason);
    }
}

/// x+ = A x + B u + K e: prediction finds K, and the poles with less variance than simulation does.
#[test]
fn prediction_finds_the_gain_and_is_the_better_estimate_of_coloured_noise() {
    let matrix = |rows: usize, columns: usize, x: &[f64]| Mat::from_row_slice(rows, columns, x);
    let (A, B, C) = (matrix(2, 2, &[0.9, 0.3, -0.3, 0.8]), matrix(2, 1, &[1.0, 0.5]), matrix(1, 2, &[1.0, 0.0]));
    let truth = StateSpace::new(A, B, C, Mat::zeros(1, 1), Time::Sampled { period_s: 1.0 }).unwrap();
    let K = matrix(2, 1, &[0.8, -0.2]);
    let mut squares = [0.0; 2];
    let mut markov_errors = Vec::new();
    for seed in 1..=20 {
        let (u, e) = (white_gaussian(2000, 1.0, 9.0, seed), white_gaussian(2000, 1.0, 9.0, 500 + seed));
        let (mut x, mut y) = (Vector::zeros(2), Vec::new());
        for (u, e) in u.iter().zip(&e) {
            y.push((&truth.C * &x)[0] + e);
            x = &truth.A * &x + truth.B.column(0) * *u + K.column(0) * *e;
        }
        let (U, Y) = (matrix(1, 2000, &u), matrix(1, 2000, &y));
        let start = perturbed(&truth, 0.05, seed);
        for (k, errors) in [Errors::Simulated, Errors::Predicted(None)].into_iter().enumerate() {
            let settings = Settings { errors, feedthrough: Feedthrough::Zero, ..Settings::default() };
            let refined: Refined = refine(&start, &U, &Y, &settings, &mut on).unwrap();
            // s^2 - 1.7 s + 0.81.
            squares[k] += (refined.model.A.trace() - 1.7).powi(2) + (refined.model.A.determinant() - 0.81).powi(2);
            if let Some(found) = &refined.K {
                // C K and C A K do not depend on the coordinates: 0.8 and 0.66.
                let (StateSpace { A, C, .. }, K) = (&refined.model, found);
                markov_errors.push([(C * K)[0] - 0.8, (C * A * K)[0] - 0.66]);
            }
        }
    }
    let ratio = squares[1] / squares[0];
    let rms = |k: usize| (markov_errors.iter().map(|e| e[k] * e[k]).sum::<f64>() / 20.0).sqrt();
    println!(
        "variance of the poles, prediction over simulation: {ratio:.2}; C K and C A K off by {:.3}, {:.3}",
        rms(0),
        rms(1)
    );
    assert!(ratio < 0.7, "{ratio}");
    assert!(rms(0) < 0.04 && rms(1) < 0.06, "{} {}", rms(0), rms(1));
}

#[test]
fn whoever_watches_can_end_it_and_keeps_what_was_reached() {
    let (U, _, noisy) = tip_angle(0.005, 2000, 3);
    let plant = Lumped { k1: 900.0, ..Lumped::PAPER }.state_space(&[Output::Psi]).unwrap();
    let start = sampling::zoh(&plant, 0.005).unwrap();
    let full = refine(&start, &U, &noisy, &INTEGRATING, &mut on).unwrap();
    let mut until = |progress: &Progress| {
        if progress.iterations < 2 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let ended = refine(&start, &U, &noisy, &INTEGRATING, &mut until).unwrap();
    assert_eq!((ended.reason, ended.iterations), (Reason::Asked, 2));
    assert!(full.missed_after < ended.missed_after && ended.missed_after < ended.missed_before);
    assert!((missed(&ended.model, &ended.initial_state, &U, &noisy) / ended.missed_after - 1.0).abs() < 1e-9);
}

#[test]
fn what_cannot_be_refined_is_refused() {
    let truth = system(1, 2, 1, 1);
    let U = Mat::from_row_slice(1, 300, &white_gaussian(300, 1.0, 9.0, 1));
    let Y = simulation::simulate(&truth, &U, &Vector::zeros(2)).unwrap();
    let refused = |model: &StateSpace, U: &Mat, Y: &Mat, settings: Settings| refine(model, U, Y, &settings, &mut on);
    let short = |M: &Mat| M.columns(0, 5).into_owned();
    assert!(matches!(refused(&truth, &short(&U), &Y, Settings::default()), Err(Error::Length { .. })));
    assert!(matches!(
        refused(&truth, &short(&U), &short(&Y), Settings::default()),
        Err(Error::TooFewSamples { found: 5, needed: 8, .. })
    ));
    let settings = Settings { tolerance: 0.0, ..Settings::default() };
    assert!(matches!(refused(&truth, &U, &Y, settings), Err(Error::Setting { setting: "tolerance", .. })));
    let settings = Settings { integrators: 3, ..Settings::default() };
    assert!(matches!(refused(&truth, &U, &Y, settings), Err(Error::Order { order: 3, largest: 2, .. })));
    let settings = Settings { errors: Errors::Predicted(Some(Mat::zeros(1, 1))), ..Settings::default() };
    assert!(matches!(refused(&truth, &U, &Y, settings), Err(Error::Linear(_))));
    let continuous = StateSpace { time: Time::Continuous, ..truth.clone() };
    assert!(matches!(refused(&continuous, &U, &Y, Settings::default()), Err(Error::Linear(_))));
    let not = Y.map(|y| if y > 1.0 { f64::NAN } else { y });
    assert!(matches!(refused(&truth, &U, &not, Settings::default()), Err(Error::NotFinite { .. })));
}

/// 10^5 samples, four states: printed, with a generous limit, because the machine is shared.
#[test]
fn a_hundred_thousand_samples() {
    let (U, _, noisy) = tip_angle(0.001, 100_000, 1);
    let plant = Lumped { k1: 900.0, ..Lumped::PAPER }.state_space(&[Output::Psi]).unwrap();
    let start = sampling::zoh(&plant, 0.001).unwrap();
    let time = std::time::Instant::now();
    let refined = refine(&start, &U, &noisy, &INTEGRATING, &mut on).unwrap();
    let seconds = time.elapsed().as_secs_f64();
    println!("10^5 samples: {seconds:.2} s, {} linearisations, {:?}", refined.iterations, refined.reason);
    assert_eq!(refined.reason, Reason::Settled);
    assert!(seconds < 30.0);
}
