//! Time of the radius alone, and of a whole design: continuous and sampled problem, prefilter, certificate.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use flexbeam_design::{HalfPlane, Reference, Specification, Stiffness, Uncertainty, design, robust_radius};
use flexbeam_lti::{Mat, StateSpace, Time};

/// (18), V -> psi.
fn plant() -> StateSpace {
    let A = [0., 0., 1., 0., 0., 0., 0., 1., 0., 1060.8, -57.7, 0., 0., -1465.2, 57.7, 0.];
    let B = Mat::from_column_slice(4, 1, &[0., 0., 107.39, -107.39]);
    let C = Mat::from_row_slice(1, 4, &[1., 1., 0., 0.]);
    StateSpace::new(Mat::from_row_slice(4, 4, &A), B, C, Mat::zeros(1, 1), Time::Continuous).expect("shapes fit")
}

fn benches(criterion: &mut Criterion) {
    let plant = plant();
    let alpha = Uncertainty::constant(0.06).expect("a positive bound");
    criterion.bench_function("robust radius, (18), beta = 12", |b| {
        b.iter(|| HalfPlane::new(black_box(&plant), 12.0).and_then(|shifted| robust_radius(&shifted, &alpha)));
    });
    let specification = Specification {
        stability_degree: 1.5,
        uncertainty: alpha.clone(),
        stiffness: Stiffness::Exactly(7.0),
        reference: Reference::RiseTime { rise_time_s: 0.25, overshoot_percent: 0.0 },
        period_s: 0.001,
        delay_s: 0.001,
        low_pass: 0.6,
    };
    criterion.bench_function("whole design, (18), beta = 1.5, 1 kHz", |b| {
        b.iter(|| design(black_box(&plant), &specification));
    });
}

criterion_group!(group, benches);
criterion_main!(group);
