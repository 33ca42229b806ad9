//! The uncertainty bound from recordings of the beam with its modes: it must lie above the truth.

use flexbeam_ident::bound::{Band, FromRecording, Settings, bound, from_recording, full, line};
use flexbeam_ident::excitation::white_gaussian;
use flexbeam_ident::{Error, Options};
use flexbeam_lti::sampling::zoh;
use flexbeam_lti::simulation::simulate;
use flexbeam_lti::{C64, Mat, Signals, StateSpace, Vector};
use flexbeam_rig::{Lumped, Output, RigParameters};

/// Two modes beside the lumped one stay below half the sampling frequency; 2500 samples make 50 recordings with 40 estimates each
/// a matter of half a minute.
const PERIOD_S: f64 = 0.004;
const SAMPLES: usize = 2500;
const BETA: f64 = 1.5;
const REPLICATES: usize = 39;

fn beam(outputs: &[Output]) -> StateSpace {
    RigParameters::default().linear().linear_model(outputs).unwrap()
}

fn signals(names: &[&str], data: Mat) -> Signals {
    let names: Vec<String> = names.iter().map(|n| n.to_string()).collect();
    Signals::new(names.clone(), names, PERIOD_S, data).unwrap()
}

/// White voltage of 3 V; theta and alpha with noise of 1 % of their rms.
fn recording(seed: u64) -> (Signals, Signals) {
    let V = Mat::from_row_slice(1, SAMPLES, &white_gaussian(SAMPLES, 3.0, 10.0, seed));
    let sampled = zoh(&beam(&[Output::Theta, Output::Alpha]), PERIOD_S).unwrap();
    let mut Y = simulate(&sampled, &V, &Vector::zeros(sampled.order())).unwrap();
    for p in 0..2 {
        let rms = Y.row(p).norm() / (SAMPLES as f64).sqrt();
        let noise = white_gaussian(SAMPLES, 0.01 * rms, f64::INFINITY, 1000 * seed + 77 + p as u64);
        (0..SAMPLES).for_each(|t| Y[(p, t)] += noise[t]);
    }
    (signals(&["voltage_v"], V), signals(&["theta_rad", "alpha_rad"], Y))
}

/// theta + alpha.
fn psi(system: &StateSpace) -> StateSpace {
    let sum = Mat::from_element(1, 2, 1.0);
    StateSpace::new(system.A.clone(), system.B.clone(), &sum * &system.C, &sum * &system.D, system.time).unwrap()
}

fn nominal() -> StateSpace {
    Lumped::PAPER.state_space(&[Output::Psi]).unwrap()
}

fn difference(G: &StateSpace, G0: &StateSpace, omega: f64) -> f64 {
    let s = C64::new(-BETA, omega);
    (G.at(s)[(0, 0)] - G0.at(s)[(0, 0)]).norm()
}

/// 50 recordings: alpha(s) lies above the true difference everywhere on the line in at least 95 %, the band holds the truth in
/// about that part, and alpha is not larger than the truth asks for by much.
#[test]
fn the_bound_covers_the_true_difference_on_the_shifted_line() {
    const RUNS: u64 = 50;
    let truth = psi(&beam(&[Output::Theta, Output::Alpha]));
    let line = line(&[&truth, &nominal()], BETA, 3.0 * std::f64::consts::PI / PERIOD_S);
    let largest = line.iter().map(|w| difference(&truth, &nominal(), *w)).fold(0.0, f64::max);
    let (mut covered, mut banded, mut contradicted, mut sizes, mut orders) = (0, 0, 0, vec![], vec![]);
    for seed in 1..=RUNS {
        let (inputs, outputs) = recording(seed);
        let settings = Settings { replicates: REPLICATES, seed, ..Settings::new(BETA) };
        let found = from_recording(&inputs, &outputs, &nominal(), &[0, 1], &settings).unwrap();
        let FromRecording { bound, band, full, model } = found;
        let size = |w: f64| bound.alpha.at(C64::new(0.0, w)).norm();
        let above = line.iter().all(|w| difference(&truth, &nominal(), *w) < size(*w));
        let within = line.iter().all(|w| difference(&truth, &model, *w) <= band.radius_at(*w));
        covered += usize::from(above);
        banded += usize::from(within);
        sizes.push(line.iter().map(|w| size(*w)).fold(0.0, f64::max) / largest);
        orders.push(full.identified.order);
        contradicted += usize::from(full.contradicted);
    }
    sizes.sort_by(f64::total_cmp);
    let of_order_8 = orders.iter().filter(|n| **n == 8).count();
    println!(
        "alpha above the truth in {covered} of {RUNS}, the band holds it in {banded}; order 8 in {of_order_8}, contradicted {contradicted}; largest alpha over \
         largest difference {:.4}: median {:.2}, at most {:.2}",
        largest,
        sizes[sizes.len() / 2],
        sizes[sizes.len() - 1]
    );
    assert!(covered as f64 >= 0.95 * RUNS as f64, "{covered} of {RUNS}");
    assert!(banded as f64 >= 0.85 * RUNS as f64, "{banded} of {RUNS}");
    assert!(sizes[sizes.len() / 2] < 1.5, "a bound that is too large is of no use: {sizes:?}");
}

/// A mode is damped by 2.02 and the lumped plant does not have it: at beta = 2.5 no bound makes the two one plant.
#[test]
fn a_mode_beyond_the_line_is_named() {
    let (inputs, outputs) = recording(3);
    let found = full(&inputs, &outputs, &Options::default(), |_| true).unwrap();
    let model = psi(found.identified.continuous.as_ref().unwrap());
    let band = Band { omega_rad_s: vec![1.0], radius: vec![0.0], level: 0.95 };
    match bound(&model, &nominal(), &band, 2.5).unwrap_err() {
        Error::PoleBeyond { beta, re, im } => {
            assert!(beta == 2.5 && re > -2.5 && (100.0..400.0).contains(&im), "{re} {im}");
        }
        other => panic!("{other}"),
    }
    assert!(matches!(bound(&model, &nominal(), &band, 0.0), Err(Error::Setting { .. })));
}

/// Four states cannot answer as the beam with its modes does, and the recording says so.
#[test]
fn the_residuals_of_too_small_a_model_answer_to_the_input() {
    let (inputs, outputs) = recording(1);
    assert!(full(&inputs, &outputs, &Options::default(), |_| true).unwrap().identified.order >= 8);
}
