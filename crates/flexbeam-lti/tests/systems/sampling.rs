use crate::plants::{Noise, distance, flexible_link, modes, relative, tip_angle};
use flexbeam_lti::exponential::{exponential, exponential_minus_identity};
use flexbeam_lti::sampling::{from_w, inverse_zoh, to_w, zoh, zoh_with_delay};
use flexbeam_lti::simulation::simulate;
use flexbeam_lti::{C64, Error, Mat, StateSpace, Time, Vector};

const MS: f64 = 1e-3;

#[test]
fn every_entry_of_18_sampled_at_1_ms_is_right_to_the_last_digits() {
    // Taylor series in 60 digits (mpmath).
    let Phi = [
        [1.0, 0.000520280624934851481, 0.000971699461181910489, 1.74266070536942945e-7],
        [0.0, 0.99927754385818955, 0.0000282995777325989164, 0.000999758338832919352],
        [0.0, 1.03052345377521992, 0.943942996242073746, 0.000520280624934851481],
        [0.0, -1.4348257259992525, 0.0560531705154884891, 0.99927754385818955],
    ];
    let Gamma = [0.0000526723546564061111, -0.0000526705659047451928, 0.104332090703010405, -0.104324956354563412];
    let sampled = zoh(&tip_angle(), MS).unwrap();
    let close = |found: f64, wanted: f64| (found - wanted).abs() <= 4e-16 * wanted.abs();
    for (i, row) in Phi.iter().enumerate() {
        assert!(row.iter().enumerate().all(|(j, phi)| close(sampled.A[(i, j)], *phi)), "Phi, row {i}");
        assert!(close(sampled.B[i], Gamma[i]), "Gamma {i}");
    }
    assert_eq!(sampled.time, Time::Sampled { period_s: MS });
}

#[test]
fn sampling_one_period_twice_is_sampling_two_periods() {
    let mut noise = Noise(1);
    for (G, period_s) in [(noise.system(6, 2, 2, Time::Continuous), 0.7), (flexible_link([1., 0., 0., 0.]), 0.02)] {
        let (once, twice) = (zoh(&G, period_s).unwrap(), zoh(&G, 2.0 * period_s).unwrap());
        assert!((&once.A * &once.A - &twice.A).norm() < 1e-14 * twice.A.norm());
        assert!((&once.A * &once.B + &once.B - &twice.B).norm() < 1e-14 * twice.B.norm());
    }
}

/// x' = A x + B u by Runge-Kutta of order 4, u held: independent of every exponential.
fn integrated(G: &StateSpace, u: &Mat, period_s: f64, delay_s: f64, steps: usize) -> Mat {
    let h = period_s / steps as f64;
    let input = |t: f64| match (t / period_s).floor() {
        k if k < 0.0 => Vector::zeros(G.inputs()),
        k => u.column((k as usize).min(u.ncols() - 1)).into_owned(),
    };
    let mut x = Vector::zeros(G.order());
    let mut y = Mat::zeros(G.outputs(), u.ncols());
    for k in 0..u.ncols() * steps {
        // Half a step from the edges, so that a jump at a step's end is on the right side.
        let held = input((k as f64 + 0.5) * h - delay_s);
        if k % steps == 0 {
            y.set_column(k / steps, &(&G.C * &x + &G.D * &held));
        }
        let f = |x: &Vector| &G.A * x + &G.B * &held;
        let k1 = f(&x);
        let k2 = f(&(&x + &k1 * (h / 2.0)));
        let k3 = f(&(&x + &k2 * (h / 2.0)));
        let k4 = f(&(&x + &k3 * h));
        x += (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0);
    }
    y
}

#[test]
fn held_and_delayed_inputs_give_the_integrated_response() {
    let mut noise = Noise(2);
    let G = noise.system(3, 2, 2, Time::Continuous);
    let u = noise.matrix(2, 12);
    for delay_s in [0.0, 0.05, 0.1, 0.13, 0.2, 0.275] {
        let sampled = zoh_with_delay(&G, 0.1, delay_s).unwrap();
        let y = simulate(&sampled, &u, &Vector::zeros(sampled.order())).unwrap();
        let reference = integrated(&G, &u, 0.1, delay_s, 200);
        assert!((&y - &reference).norm() < 1e-11 * reference.norm(), "delay {delay_s}");
    }
}

#[test]
fn one_period_of_delay_is_one_state_at_the_origin_and_one_sample_of_shift() {
    let G = flexible_link([1.0, 0.0, 0.0, 0.0]);
    let (plain, delayed) = (zoh(&G, MS).unwrap(), zoh_with_delay(&G, MS, MS).unwrap());
    assert_eq!(delayed.order(), 5);
    let mut poles = plain.poles();
    poles.push(C64::new(0.0, 0.0));
    assert!(distance(&delayed.poles(), &poles, 1.0) < 1e-7);
    let z = C64::from_polar(1.1, 0.4);
    assert!(relative(&delayed.at(z), &plain.at(z).map(|g| g / z)) < 1e-12);
    assert_eq!(zoh_with_delay(&G, MS, 0.003).unwrap().order(), 7);
    assert_eq!(zoh_with_delay(&G, MS, 0.0031).unwrap().order(), 8);
}

#[test]
fn a_static_gain_is_only_delayed() {
    let gain = StateSpace::static_gain(Mat::from_element(1, 1, 3.0), Time::Continuous).unwrap();
    let z = C64::new(0.3, 0.8);
    assert!((zoh_with_delay(&gain, 1.0, 1.5).unwrap().at(z)[0] - 3.0 / (z * z)).norm() < 1e-14);
    assert_eq!(zoh(&gain, 1.0).unwrap().at(z)[0], C64::new(3.0, 0.0));
}

#[test]
fn the_w_plane_keeps_values_and_comes_back() {
    let mut noise = Noise(3);
    let period_s = 0.02;
    let G = noise.system(5, 2, 3, Time::Sampled { period_s });
    let image = to_w(&G).unwrap();
    let back = from_w(&image, period_s).unwrap();
    for _ in 0..5 {
        let z = noise.point();
        let w = (z - 1.0) / (z + 1.0) * (2.0 / period_s);
        assert!(relative(&image.at(w), &G.at(z)) < 1e-11);
        assert!(relative(&back.at(z), &G.at(z)) < 1e-11);
    }
    assert_eq!((image.time, back.time), (Time::Continuous, G.time));
}

#[test]
fn poles_on_the_maps_special_points_are_named() {
    let minus_one = StateSpace::new(
        Mat::from_row_slice(2, 2, &[0.5, 1.0, 0.0, -1.0]),
        Mat::from_element(2, 1, 1.0),
        Mat::from_element(1, 2, 1.0),
        Mat::zeros(1, 1),
        Time::Sampled { period_s: 1.0 },
    )
    .unwrap();
    assert!(matches!(to_w(&minus_one), Err(Error::MappedPole { at: -1.0, .. })));
    let two = StateSpace { time: Time::Continuous, A: Mat::from_diagonal_element(2, 2, 2.0), ..minus_one };
    assert!(matches!(from_w(&two, 1.0), Err(Error::MappedPole { at: 2.0, .. })));
}

#[test]
fn questions_on_the_wrong_axis_are_refused() {
    let sampled = zoh(&tip_angle(), MS).unwrap();
    assert!(matches!(zoh(&sampled, MS), Err(Error::WrongTime { .. })));
    assert!(matches!(to_w(&tip_angle()), Err(Error::WrongTime { .. })));
    assert!(matches!(from_w(&sampled, MS), Err(Error::WrongTime { .. })));
    assert!(matches!(zoh(&tip_angle(), 0.0), Err(Error::Period { .. })));
    assert!(matches!(zoh_with_delay(&tip_angle(), MS, -MS), Err(Error::Delay { .. })));
    assert!(matches!(zoh(&StateSpace { A: tip_angle().A * -1e6, ..tip_angle() }, 1.0), Err(Error::NotFinite { .. })));
}

#[test]
fn exponential_of_a_chain_of_integrators_is_exact() {
    let mut M = Mat::zeros(8, 8);
    for k in 0..7 {
        M[(k, k + 1)] = MS;
    }
    let E = exponential_minus_identity(&M);
    let mut wanted = 1.0;
    for k in 1..8 {
        wanted *= MS / k as f64;
        assert!((E[(0, k)] - wanted).abs() <= 1e-15 * wanted, "{k}");
    }
}

#[test]
fn exponential_of_a_rotation_and_of_fast_modes() {
    let t = 100.25_f64;
    let R = exponential(&Mat::from_row_slice(2, 2, &[0.0, -t, t, 0.0]));
    assert!((R[(0, 0)] - t.cos()).abs() < 1e-13 && (R[(1, 0)] - t.sin()).abs() < 1e-13);
    let G = modes(&[1.0, 30.0, 1000.0], 0.01, &[1.0; 3]);
    let Phi = exponential(&(&G.A * 0.1));
    for (k, w) in [1.0_f64, 30.0, 1000.0].into_iter().enumerate() {
        let damped = w * (1.0_f64 - 1e-4).sqrt();
        let wanted = (-0.01 * w * 0.1).exp() * (damped * 0.1).sin() / damped;
        assert!((Phi[(2 * k, 2 * k + 1)] - wanted).abs() < 1e-13 / w, "{w}");
    }
}

#[test]
fn the_inverse_of_sampling_returns_18() {
    for period_s in [1e-4, 1e-3, 1e-2, 0.05] {
        let G = flexible_link([1.0, 0.0, 0.0, 0.0]);
        let back = inverse_zoh(&zoh(&G, period_s).unwrap()).unwrap();
        assert!((&back.A - &G.A).norm() < 1e-11 * G.A.norm(), "{period_s}");
        assert!((&back.B - &G.B).norm() < 1e-11 * G.B.norm(), "{period_s}");
        assert_eq!(back.time, Time::Continuous);
    }
}

#[test]
fn the_inverse_of_sampling_keeps_the_samples_of_any_system_with_slow_modes() {
    let mut noise = Noise(4);
    for (n, l, m) in [(0, 1, 1), (1, 1, 2), (5, 2, 3), (9, 1, 1)] {
        let G = noise.system(n, l, m, Time::Continuous);
        let sampled = zoh(&G, 0.2).unwrap();
        let again = zoh(&inverse_zoh(&sampled).unwrap(), 0.2).unwrap();
        assert!((&again.A - &sampled.A).norm() <= 1e-13 * sampled.A.norm());
        assert!((&again.B - &sampled.B).norm() <= 1e-13 * sampled.B.norm());
        let s = noise.point();
        assert!(relative(&inverse_zoh(&sampled).unwrap().at(s), &G.at(s)) < 1e-11);
    }
}

#[test]
fn poles_without_continuous_counterpart_are_named() {
    let A = Mat::from_row_slice(3, 3, &[-0.5, 1.0, 0.0, 0.0, 0.9, 0.0, 0.0, 0.0, -0.25]);
    let time = Time::Sampled { period_s: 1.0 };
    let G =
        StateSpace::new(A, Mat::from_element(3, 1, 1.0), Mat::from_element(1, 3, 1.0), Mat::zeros(1, 1), time).unwrap();
    let Err(Error::NoContinuousEquivalent { mut poles }) = inverse_zoh(&G) else { panic!("accepted") };
    poles.sort_by(f64::total_cmp);
    assert!((poles[0] + 0.5).abs() < 1e-15 && (poles[1] + 0.25).abs() < 1e-15 && poles.len() == 2);
    let delayed = zoh_with_delay(&tip_angle(), MS, MS).unwrap();
    assert_eq!(inverse_zoh(&delayed).unwrap_err(), Error::NoContinuousEquivalent { poles: vec![0.0] });
    assert!(matches!(inverse_zoh(&tip_angle()), Err(Error::WrongTime { .. })));
}
