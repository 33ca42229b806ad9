//! The tip angle of the paper's plant: an integrator that is known, 1 % of white noise, where other tools fail.

use flexbeam_ident::excitation::white_gaussian;
use flexbeam_ident::{Error, Feedthrough, Identified, Method, Options, Order, Poles, identify};
use flexbeam_lti::{C64, Mat, Signals, StateSpace, Time, Vector, sampling, simulation};
use flexbeam_rig::{Lumped, Output};

const SAMPLES: usize = 10_000;
/// 96 identifications with up to 60 block rows: some ten seconds, for a worst case that means something.
const SEEDS: u64 = 24;

fn psi(period_s: f64) -> StateSpace {
    let plant = Lumped::PAPER.state_space(&[Output::Theta, Output::Alpha]).unwrap();
    let sampled = sampling::zoh(&plant, period_s).unwrap();
    let sum = Mat::from_row_slice(1, 2, &[1.0, 1.0]);
    StateSpace { C: &sum * &sampled.C, D: &sum * &sampled.D, ..sampled }
}

struct Record {
    V: Signals,
    psi: Signals,
    noise_free: Mat,
}

fn signals(name: &str, period_s: f64, data: Mat) -> Signals {
    Signals::new(vec![name.into()], vec!["".into()], period_s, data).unwrap()
}

/// White Gaussian voltage of 2 V; white noise of `part` of the angle's rms.
fn record(period_s: f64, part: f64, seed: u64) -> Record {
    let V = Mat::from_row_slice(1, SAMPLES, &white_gaussian(SAMPLES, 2.0, 10.0, seed));
    let noise_free = simulation::simulate(&psi(period_s), &V, &Vector::zeros(4)).unwrap();
    let rms = noise_free.norm() / (SAMPLES as f64).sqrt();
    let noise = white_gaussian(SAMPLES, part * rms, f64::INFINITY, 7000 + seed);
    let noisy = Mat::from_fn(1, SAMPLES, |_, k| noise_free[(0, k)] + noise[k]);
    Record { V: signals("voltage_v", period_s, V), psi: signals("psi_rad", period_s, noisy), noise_free }
}

/// Fit on the second half against the noise-free output, started from the state that suits the *noisy* second half.
fn fit_percent(record: &Record, found: &Identified) -> f64 {
    let second = |M: &Mat| M.columns(SAMPLES / 2, SAMPLES / 2).into_owned();
    let (U, Y) = (second(&record.V.data), second(&record.psi.data));
    let simulated = flexbeam_ident::validate::validate(&found.model, &U, &Y).unwrap().simulated;
    let truth = second(&record.noise_free);
    100.0 * (1.0 - (&truth - simulated).norm() / truth.add_scalar(-truth.mean()).norm())
}

fn fits(period_s: f64, order: Order) -> Vec<f64> {
    let options = Options { integrators: 1, more_block_rows: vec![40, 60], order, ..Options::default() };
    let mut fits: Vec<f64> = (1..=SEEDS)
        .map(|seed| {
            let record = record(period_s, 0.01, seed);
            let found = identify(&record.V, &record.psi, &options).unwrap();
            assert!(found.model.poles().iter().any(|p| p.re == 1.0 && p.im == 0.0), "{:?}", found.model.poles());
            let fit = fit_percent(&record, &found);
            println!("  seed {seed}: order {}, i = {}, {:?}: {fit:.2} %", found.order, found.block_rows, found.method);
            fit
        })
        .collect();
    fits.sort_by(f64::total_cmp);
    fits
}

/// Required: 95 % at 1 ms, 98 % at 5 ms. Measured: medians 99.8 and 99.9, worst 97.2 and 99.1.
#[test]
fn the_tip_angle_is_found_through_its_noise() {
    for (period_s, needed) in [(0.001, 95.0), (0.005, 98.0)] {
        for order in [Order::Fixed(4), Order::Auto] {
            let fits = fits(period_s, order);
            let (worst, median) = (fits[0], (fits[11] + fits[12]) / 2.0);
            println!("{period_s} s, {order:?}: median {median:.2} %, worst {worst:.2} %");
            assert!(worst > needed, "{period_s} s, {order:?}: {fits:?}");
        }
    }
}

/// Largest |G - G0| over the unit circle without its neighbourhood of 1, relative to the largest |G0| there.
fn response_error(found: &StateSpace, wanted: &StateSpace) -> f64 {
    let at = |k: i32| C64::from_polar(1.0, std::f64::consts::PI * (f64::from(k) + 0.5) / 100.0);
    let norm = |M: flexbeam_lti::CMat| M.iter().map(|g| g.norm()).fold(0.0, f64::max);
    let missed = (0..100).map(|k| norm(found.at(at(k)) - wanted.at(at(k)))).fold(0.0, f64::max);
    missed / (0..100).map(|k| norm(wanted.at(at(k)))).fold(0.0, f64::max)
}

/// One integrator behind two inputs and before three outputs, two behind two; no noise: exact, the eigenvalues 1 to the last bit.
#[test]
fn many_channels_share_the_known_integrators() {
    let mix = |r: usize, c: usize| (((r + 1) * (c + 2)) as f64 * 1.7).sin();
    for integrators in [1, 2] {
        let n = 3 + integrators;
        let mut A = Mat::identity(n, n);
        let rest = Mat::from_row_slice(3, 3, &[0.8, 0.5, 0.0, -0.5, 0.8, 0.0, 0.0, 0.0, 0.4]);
        A.view_mut((integrators, integrators), (3, 3)).copy_from(&rest);
        let (B, C) = (Mat::from_fn(n, 2, mix), Mat::from_fn(3, n, |r, c| mix(c + 2, r)));
        let wanted = StateSpace::new(A, B, C, Mat::zeros(3, 2), Time::Sampled { period_s: 1.0 }).unwrap();
        let U = Mat::from_column_slice(2, 2000, &white_gaussian(4000, 1.0, 9.0, 4));
        let Y = simulation::simulate(&wanted, &U, &Vector::from_element(n, 0.5)).unwrap();
        let channels = |letter: &str, data: Mat| {
            let names = (0..data.nrows()).map(|c| format!("{letter}{c}")).collect();
            Signals::new(names, vec![String::new(); data.nrows()], 1.0, data).unwrap()
        };
        let options = Options { integrators, block_rows: 6, ..Options::default() };
        let found = identify(&channels("u", U), &channels("y", Y), &options).unwrap();
        assert_eq!(found.order, n);
        let ones =
            (0..n).filter(|&k| found.model.A.row(k).iter().enumerate().all(|(c, a)| *a == f64::from(u8::from(c == k))));
        assert_eq!(ones.count(), integrators);
        let error = response_error(&found.model, &wanted);
        println!("{integrators} integrators: {error:.1e}");
        assert!(error < 1e-9, "{error:e}");
        assert!(found.fit_percent.unwrap().iter().all(|fit| *fit > 100.0 - 1e-6));
        assert_eq!(found.model.D, Mat::zeros(3, 2));
    }
}

/// The paper's own case: psi without noise, poles and physical numbers to rounding.
#[test]
fn the_tip_angle_without_noise_is_exact() {
    let record = record(0.001, 0.0, 1);
    let found = identify(&record.V, &record.psi, &Options { integrators: 1, ..Options::default() }).unwrap();
    assert_eq!(found.order, 4);
    let error = response_error(&found.model, &psi(0.001));
    println!("tip angle without noise: {error:.1e}");
    assert!(error < 1e-9, "{error:e}");
}

#[test]
fn structure_that_cannot_be_is_refused() {
    let record = record(0.005, 0.01, 1);
    let refused = |options: Options| identify(&record.V, &record.psi, &options).expect_err("structure that cannot be");
    let two = refused(Options { integrators: 2, ..Options::default() });
    assert!(matches!(two, Error::Setting { setting: "integrators", found: 2.0, .. }), "{two}");
    let alone = refused(Options { integrators: 1, order: Order::Fixed(1), ..Options::default() });
    assert!(matches!(alone, Error::Setting { setting: "order", found: 1.0, .. }), "{alone}");
    for options in [
        Options { integrators: 1, ..Options::default() },
        Options { feedthrough: Feedthrough::Zero, ..Options::default() },
        Options { poles: Poles::Stable, ..Options::default() },
        Options { more_block_rows: vec![30], ..Options::default() },
    ] {
        let printed = refused(Options { method: Method::Paper, ..options });
        assert!(matches!(printed, Error::Structure { .. }), "{printed}");
    }
}
