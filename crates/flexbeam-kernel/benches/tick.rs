//! Time of one tick against the order of the controller.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use flexbeam_kernel::{Controller, Measured, Settings, State, tick};
use std::hint::black_box;

/// A = 0.9 I with small couplings (all states stay normal numbers and bounded), B, C, D full.
fn coefficients(n: usize) -> Vec<f64> {
    let a = (0..n * n).map(|k| if k % (n + 1) == 0 { 0.9 } else { 0.05 / n as f64 });
    let others = (0..5 * n + 4).map(|k| 0.01 * (1.0 + (k % 7) as f64));
    a.chain(others).collect()
}

fn time_of_tick(c: &mut Criterion) {
    let mut group = c.benchmark_group("tick");
    let settings = Settings { u_p_plus_v: 0.28, u_p_minus_v: 0.1, smooth_ticks: 300.0, ..Settings::default() };
    for n in [8, 16, 32] {
        let coefficients = coefficients(n);
        let controller = Controller::new(n, &coefficients).expect("the length is that of the order");
        let mut memory = vec![0.0; controller.state_len()];
        let mut state = State::new(&controller, &mut memory).expect("the controller named the length");
        let mut k = 0u32;
        group.bench_function(BenchmarkId::from_parameter(n), |b| {
            b.iter(|| {
                k = k.wrapping_add(1);
                // A square wave of 1000 ticks, so that the smooth step moves now and then rests.
                let reference_rad = if (k / 500).is_multiple_of(2) { 0.5 } else { -0.5 };
                let measured = Measured { reference_rad, theta_rad: 0.3 * reference_rad, alpha_rad: 0.01 };
                tick(&settings, &controller, &mut state, black_box(measured))
            });
        });
        assert_eq!(state.fault(), flexbeam_kernel::Fault::None, "the loop that was timed ran to the end");
    }
    group.finish();
}

criterion_group!(benches, time_of_tick);
criterion_main!(benches);
