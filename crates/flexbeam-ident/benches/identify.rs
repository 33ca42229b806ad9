//! Time of the identification itself: the paper's plant (18) at 1 ms, i = 20, theta and alpha, 1 % noise.
//!
//! `cargo bench -p flexbeam-ident`

use criterion::{Criterion, criterion_group, criterion_main};
use flexbeam_ident::excitation::white_gaussian;
use flexbeam_ident::{Options, Order, identify};
use flexbeam_lti::{Mat, Signals, Vector, sampling, simulation};
use flexbeam_rig::{Lumped, Output};

fn signals(names: &[&str], data: Mat) -> Signals {
    let names: Vec<String> = names.iter().map(|n| n.to_string()).collect();
    Signals::new(names.clone(), names, 0.001, data).expect("names fit the rows")
}

/// Voltage and the noisy outputs of (18).
fn record(samples: usize, outputs: &[usize]) -> (Signals, Signals) {
    let plant = Lumped::PAPER.state_space(&[Output::Theta, Output::Alpha]).unwrap();
    let sampled = sampling::zoh(&plant, 0.001).expect("a continuous plant");
    let V = Mat::from_row_slice(1, samples, &white_gaussian(samples, 2.0, 10.0, 1));
    let mut Y = simulation::simulate(&sampled, &V, &Vector::zeros(4)).expect("shapes fit").select_rows(outputs);
    for p in 0..Y.nrows() {
        let rms = Y.row(p).norm() / (samples as f64).sqrt();
        let noise = white_gaussian(samples, 0.01 * rms, f64::INFINITY, 2 + p as u64);
        (0..samples).for_each(|k| Y[(p, k)] += noise[k]);
    }
    let names = ["theta_rad", "alpha_rad"];
    (signals(&["voltage_v"], V), signals(&outputs.iter().map(|&p| names[p]).collect::<Vec<_>>(), Y))
}

fn bench(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("identify");
    group.sample_size(10);
    for (name, outputs, order) in [("theta_alpha", &[0, 1][..], 4), ("alpha", &[1][..], 3)] {
        for samples in [10_000, 100_000] {
            let (V, Y) = record(samples, outputs);
            let options = Options { order: Order::Fixed(order), estimate: 1.0, ..Options::default() };
            group.bench_function(format!("{name}/{samples}"), |b| b.iter(|| identify(&V, &Y, &options)));
        }
    }
}

criterion_group!(benches, bench);
criterion_main!(benches);
