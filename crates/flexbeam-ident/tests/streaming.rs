//! Recordings that are read once: chunks, experiments and shards give the model of the whole.

use flexbeam_ident::excitation::white_gaussian;
use flexbeam_ident::streaming::Accumulator;
use flexbeam_ident::validator::Validator;
use flexbeam_ident::{Error, Identified, Method, Options, Order, identify};
use flexbeam_lti::{C64, Mat, Signals, StateSpace, Vector, sampling, simulation};
use flexbeam_rig::{Lumped, Output};

const I: usize = 15;

fn plant() -> StateSpace {
    let continuous = Lumped::PAPER.state_space(&[Output::Alpha]).unwrap();
    sampling::zoh(&continuous, 0.005).unwrap()
}

fn record(samples: usize, noise: f64, seed: u64) -> (Mat, Mat) {
    let u = Mat::from_row_slice(1, samples, &white_gaussian(samples, 2.0, 10.0, seed));
    let mut y = simulation::simulate(&plant(), &u, &Vector::from_element(4, 0.02)).unwrap();
    let rms = y.norm() / (samples as f64).sqrt();
    let e = white_gaussian(samples, 1.0, f64::INFINITY, seed + 1);
    (0..samples).for_each(|k| y[k] += noise * rms * e[k]);
    (u, y)
}

fn accumulator() -> Accumulator {
    Accumulator::new(&["voltage_v".into()], &["alpha_rad".into()], I, 2).unwrap()
}

/// MOESP: a stream lets no weights compete.
fn options() -> Options {
    Options { block_rows: I, order: Order::Fixed(3), estimate: 1.0, method: Method::Moesp, ..Options::default() }
}

fn absorb(to: &mut Accumulator, (u, y): &(Mat, Mat), chunk: usize) {
    for first in (0..u.ncols()).step_by(chunk) {
        let count = chunk.min(u.ncols() - first);
        to.absorb(&u.columns(first, count).into_owned(), &y.columns(first, count).into_owned()).unwrap();
    }
}

fn whole((u, y): &(Mat, Mat)) -> Identified {
    let signals =
        |name: &str, data: &Mat| Signals::new(vec![name.into()], vec!["".into()], 0.005, data.clone()).unwrap();
    identify(&signals("voltage_v", u), &signals("alpha_rad", y), &options()).unwrap()
}

fn poles_differ(a: &Identified, b: &Identified) -> f64 {
    let sorted = |x: &Identified| {
        let mut poles: Vec<C64> = x.model.A.complex_eigenvalues().iter().copied().collect();
        poles.sort_by(|a, b| a.im.total_cmp(&b.im));
        poles
    };
    sorted(a).iter().zip(&sorted(b)).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// Largest |G - G0| over the unit circle, relative to the largest |G0|.
fn response_error(found: &StateSpace) -> f64 {
    let (mut missed, mut size) = (0.0_f64, 0.0_f64);
    for k in 1..=100 {
        let z = C64::from_polar(1.0, std::f64::consts::PI * f64::from(k) / 100.0);
        let (G, G0) = (found.at(z)[(0, 0)], plant().at(z)[(0, 0)]);
        (missed, size) = (missed.max((G - G0).norm()), size.max(G0.norm()));
    }
    missed / size
}

#[test]
fn chunks_give_the_poles_of_the_whole_to_the_last_bit() {
    let data = record(20_000, 0.01, 1);
    let wanted = whole(&data);
    for chunk in [1, 777, 4096, 20_000] {
        let mut accumulator = accumulator();
        absorb(&mut accumulator, &data, chunk);
        assert_eq!(accumulator.samples(), 20_000);
        let found = accumulator.identify(0.005, &options()).unwrap();
        assert_eq!(found.model.A, wanted.model.A, "chunks of {chunk}");
    }
}

#[test]
fn data_without_noise_are_exact_in_one_pass() {
    let mut accumulator = accumulator();
    absorb(&mut accumulator, &record(20_000, 0.0, 3), 5000);
    let found = accumulator.identify(0.005, &options()).unwrap();
    let error = response_error(&found.model);
    assert!(error < 1e-9, "{error:e}");
    assert!(found.estimation_fit_percent[0] > 100.0 - 1e-7);
}

/// B and D from the factor cost something against the simulated output, and not much.
#[test]
fn noise_costs_one_pass_little() {
    let data = record(50_000, 0.01, 5);
    let mut accumulator = accumulator();
    absorb(&mut accumulator, &data, 10_000);
    let found = accumulator.identify(0.005, &options()).unwrap();
    let (once, twice) = (response_error(&found.model), response_error(&whole(&data).model));
    println!("response errors: read once {once:.1e}, read twice {twice:.1e}");
    assert!(once < 3.0 * twice && once < 0.01, "{once:e} against {twice:e}");
}

#[test]
fn shards_that_overlap_are_the_whole_and_experiments_add() {
    let data = record(30_000, 0.001, 7);
    let wanted = whole(&data);
    let cut = |first: usize, last: usize| {
        (data.0.columns(first, last - first).into_owned(), data.1.columns(first, last - first).into_owned())
    };
    let shard = |first: usize, last: usize| {
        let mut shard = accumulator();
        absorb(&mut shard, &cut(first, last), 3000);
        shard
    };
    let mut sum = shard(0, 11_111);
    sum.merge(shard(11_111 - (2 * I - 1), 20_000));
    sum.merge(shard(20_000 - (2 * I - 1), 30_000));
    let found = sum.identify(0.005, &options()).unwrap();
    let apart = poles_differ(&found, &wanted);
    assert!(apart < 1e-11, "{apart:e}");

    let mut both = accumulator();
    absorb(&mut both, &record(10_000, 0.0, 11), 1000);
    both.next_experiment();
    absorb(&mut both, &record(12_000, 0.0, 13), 5000);
    assert_eq!(both.samples(), 22_000);
    let found = both.identify(0.005, &options()).unwrap();
    assert!(response_error(&found.model) < 1e-9);
}

#[test]
fn the_validator_agrees_with_the_validation_in_memory() {
    let (estimate, rest) = (record(20_000, 0.01, 17), record(9000, 0.01, 19));
    let found = whole(&estimate);
    let wanted = flexbeam_ident::validate::validate(&found.model, &rest.0, &rest.1).unwrap();
    for chunk in [9000, 100, 257] {
        let mut validator = Validator::new(&found);
        for first in (0..9000).step_by(chunk) {
            let count = chunk.min(9000 - first);
            validator
                .absorb(&rest.0.columns(first, count).into_owned(), &rest.1.columns(first, count).into_owned())
                .unwrap();
        }
        assert_eq!(validator.samples(), 9000);
        let apart = (validator.fit_percent()[0] - wanted.fit_percent[0]).abs();
        assert!(apart < 1e-6, "chunks of {chunk}: {apart:e}");
    }
}

#[test]
fn bad_samples_and_short_records_are_refused() {
    let (u, mut y) = record(9000, 0.01, 23);
    y[8123] = f64::NAN;
    let mut accumulator = accumulator();
    accumulator.absorb(&u.columns(0, 5000).into_owned(), &y.columns(0, 5000).into_owned()).unwrap();
    let refused = accumulator.absorb(&u.columns(5000, 4000).into_owned(), &y.columns(5000, 4000).into_owned());
    assert!(
        matches!(&refused, Err(Error::NotFinite { channel, sample: 8123, .. }) if channel == "alpha_rad"),
        "{refused:?}"
    );
    let mut short = self::accumulator();
    absorb(&mut short, &record(60, 0.0, 1), 7);
    let refused = short.identify(0.005, &options()).map(|_| ());
    assert_eq!(refused, Err(Error::TooFewSamples { what: "estimation", found: 60, needed: 89, block_rows: I }));
    assert_eq!(Accumulator::new(&[], &["y".into()], 5, 1).err(), Some(Error::NoChannel { inputs: 0, outputs: 1 }));
}
