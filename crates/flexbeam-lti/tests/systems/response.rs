use crate::plants::{Noise, flexible_link, modes, relative};
use flexbeam_lti::response::{Hessenberg, frequency_response};
use flexbeam_lti::{C64, Error, Mat, StateSpace, Time};

#[test]
fn values_equal_those_of_the_dense_solution() {
    let mut noise = Noise(1);
    for (n, l, m) in [(0, 1, 2), (1, 1, 1), (2, 3, 1), (5, 2, 3), (12, 1, 4)] {
        for time in [Time::Continuous, Time::Sampled { period_s: 0.3 }] {
            let G = noise.system(n, l, m, time);
            let omega = [0.0, 0.4, 2.0, 9.0];
            let response = frequency_response(&G, &omega).unwrap();
            for (w, value) in omega.iter().zip(&response) {
                let s = if time == Time::Continuous { C64::new(0.0, *w) } else { C64::cis(w * 0.3) };
                assert!(relative(value, &G.at(s)) < 1e-12, "{n} {w}");
            }
        }
    }
}

#[test]
fn twenty_light_modes_have_their_closed_form_response() {
    let omega: Vec<f64> = (1..=20).map(|k| 7.0 * (k * k) as f64).collect();
    let residues: Vec<f64> = (0..20).map(|k| 1.0 + 0.1 * k as f64).collect();
    let G = modes(&omega, 0.002, &residues);
    let at = [1.0, 7.0, 30.0, 700.0, 2800.0, 1e4];
    for (w, value) in at.iter().zip(frequency_response(&G, &at).unwrap()) {
        let s = C64::new(0.0, *w);
        let term = |(o, r): (&f64, &f64)| C64::from(*r) / (s * s + s * (2.0 * 0.002 * o) + o * o);
        let wanted: C64 = omega.iter().zip(&residues).map(term).sum();
        assert!((value[0] - wanted).norm() < 1e-12 * wanted.norm(), "{w}");
    }
}

#[test]
fn a_pole_is_infinite_and_a_bad_frequency_is_refused() {
    let integrator = flexible_link([1.0, 0.0, 0.0, 0.0]);
    assert!(frequency_response(&integrator, &[0.0]).unwrap()[0][0].norm() > 1e12);
    let pure = StateSpace { A: Mat::zeros(4, 4), ..integrator.clone() };
    assert_eq!(Hessenberg::new(&pure).at(C64::ZERO)[0].re, f64::INFINITY);
    let error = frequency_response(&integrator, &[1.0, f64::NAN]).unwrap_err();
    assert!(matches!(error, Error::NotFinite { column: 2, .. }));
}
