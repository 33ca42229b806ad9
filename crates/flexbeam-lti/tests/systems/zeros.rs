use crate::plants::{Noise, distance, flexible_link, modes, relative, tip_angle};
use flexbeam_lti::connections::{append, inverse, parallel, series};
use flexbeam_lti::minimal::minimal;
use flexbeam_lti::sampling::zoh;
use flexbeam_lti::zeros::{invariant_zeros, normal_rank, transmission_zeros};
use flexbeam_lti::{C64, CMat, Error, Mat, StateSpace, Time, Zpk};

/// Smallest singular value of [A - z I, B; C, D] with that many rows or columns less, relative to its norm.
fn rank_drop(G: &StateSpace, z: C64) -> f64 {
    let (n, l, m) = (G.order(), G.outputs(), G.inputs());
    let mut P = CMat::zeros(n + l, n + m);
    P.view_mut((0, 0), (n, n)).copy_from(&(G.A.map(C64::from) - CMat::from_diagonal_element(n, n, z)));
    P.view_mut((0, n), (n, m)).copy_from(&G.B.map(C64::from));
    P.view_mut((n, 0), (l, n)).copy_from(&G.C.map(C64::from));
    P.view_mut((n, n), (l, m)).copy_from(&G.D.map(C64::from));
    let sigma = P.singular_values();
    sigma.min() / sigma.max()
}

#[test]
fn the_flexible_link_of_18() {
    assert!(transmission_zeros(&tip_angle()).unwrap().is_empty());
    let alpha = transmission_zeros(&flexible_link([0.0, 1.0, 0.0, 0.0])).unwrap();
    assert_eq!(alpha.len(), 1, "{alpha:?}");
    assert!(alpha[0].norm() < 1e-12);
    // theta: s^2 + k2 - k1 by elimination of alpha.
    let theta = transmission_zeros(&flexible_link([1.0, 0.0, 0.0, 0.0])).unwrap();
    let wanted = [C64::new(0.0, 404.4_f64.sqrt()), C64::new(0.0, -404.4_f64.sqrt())];
    assert!(distance(&theta, &wanted, 1.0) < 1e-13, "{theta:?}");
    assert!(theta[0] == theta[1].conj());
}

#[test]
fn hidden_modes_are_invariant_zeros_only() {
    let alpha = invariant_zeros(&flexible_link([0.0, 1.0, 0.0, 0.0])).unwrap();
    assert_eq!(alpha.len(), 2);
    assert!(alpha.iter().all(|z| z.norm() < 1e-7));
}

#[test]
fn sampling_zeros_of_the_tip_angle_at_1_ms() {
    // det [zI - Phi, -Gamma; C, 0] in 60 digits (mpmath); Euler-Frobenius limits are -5 -+ 2 sqrt 6 and -1.
    let wanted = [-9.78532169742897857, -0.988526397313944199, -0.0998622529848451526].map(C64::from);
    let found = transmission_zeros(&zoh(&tip_angle(), 1e-3).unwrap()).unwrap();
    assert!(distance(&found, &wanted, 0.1) < 1e-10, "{found:?}");
}

#[test]
fn sampling_zeros_are_not_lost_when_sampling_is_very_fast() {
    // At 10 us C Gamma is 1e-17, beside a Phi of 1.
    let limit = [-5.0 - 24_f64.sqrt(), -1.0, -5.0 + 24_f64.sqrt()].map(C64::from);
    let found = transmission_zeros(&zoh(&tip_angle(), 1e-5).unwrap()).unwrap();
    assert!(distance(&found, &limit, 0.1) < 2e-4, "{found:?}");
}

#[test]
fn a_relative_degree_of_forty() {
    // Twenty masses and springs in a row, pushed at one end and watched at the other.
    let n = 20;
    let spring = |i: usize, j: usize| if i == j { -2.0 + f64::from(i == n - 1) } else { f64::from(i.abs_diff(j) == 1) };
    let A = Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, _) => f64::from(j == i + n),
        (false, true) => spring(i - n, j),
        (false, false) => -0.01 * f64::from(i == j),
    });
    let B = Mat::from_fn(2 * n, 1, |i, _| f64::from(i == n));
    let C = Mat::from_fn(1, 2 * n, |_, j| f64::from(j == n - 1));
    let chain = StateSpace::new(A, B, C, Mat::zeros(1, 1), Time::Continuous).unwrap();
    let G = Zpk::from_state_space(&chain).unwrap();
    assert!(G.zeros.is_empty(), "{:?}", G.zeros);
    assert!((G.gain - 1.0).abs() < 1e-12);
    assert_eq!(minimal(&chain).order(), 2 * n);
}

#[test]
fn zeros_do_not_depend_on_coordinates_or_units() {
    let mut noise = Noise(1);
    let theta = flexible_link([1.0, 0.0, 0.0, 0.0]);
    let wanted = transmission_zeros(&theta).unwrap();
    let T = noise.matrix(4, 4) + Mat::identity(4, 4) * 2.0;
    let lu = T.clone().lu();
    let moved = StateSpace {
        A: lu.solve(&(&theta.A * &T)).unwrap(),
        B: lu.solve(&theta.B).unwrap() * 1e7,
        C: &theta.C * &T * 1e-9,
        ..theta.clone()
    };
    assert!(distance(&transmission_zeros(&moved).unwrap(), &wanted, 1.0) < 1e-10);
    assert!(transmission_zeros(&StateSpace { C: &tip_angle().C * &T, ..moved }).unwrap().is_empty());
}

#[test]
fn zeros_are_poles_of_the_inverse() {
    let mut noise = Noise(2);
    for n in 1..12 {
        let G = noise.system(n, 2, 2, Time::Continuous);
        let found = transmission_zeros(&G).unwrap();
        assert!(distance(&found, &inverse(&G).unwrap().poles(), 0.1) < 1e-9, "{n}");
        assert!(found.iter().all(|z| rank_drop(&G, *z) < 1e-14));
    }
}

#[test]
fn systems_without_feedthrough_lose_rank_at_their_zeros() {
    let mut noise = Noise(3);
    for (n, m) in [(3, 1), (6, 1), (6, 2), (9, 3), (10, 2)] {
        let G = StateSpace { D: Mat::zeros(m, m), ..noise.system(n, m, m, Time::Continuous) };
        let found = transmission_zeros(&G).unwrap();
        // C B is regular: n - m zeros.
        assert_eq!(found.len(), n - m);
        assert!(found.iter().all(|z| rank_drop(&G, *z) < 1e-14));
    }
}

#[test]
fn random_rectangular_systems_have_no_zeros_and_planted_ones_are_found() {
    let mut noise = Noise(4);
    for (l, m) in [(1, 2), (3, 2), (2, 1)] {
        let tall = noise.system(4, l, m, Time::Continuous);
        assert!(transmission_zeros(&tall).unwrap().is_empty(), "{l} {m}");
        // A square factor on the narrow side puts its zeros into the product.
        let square = noise.system(3, l.min(m), l.min(m), Time::Continuous);
        let product = if l > m { series(&square, &tall) } else { series(&tall, &square) }.unwrap();
        let wanted = inverse(&square).unwrap().poles();
        assert!(distance(&transmission_zeros(&product).unwrap(), &wanted, 0.1) < 1e-8, "{l} {m}");
    }
}

#[test]
fn twenty_light_modes_with_one_actuator_and_sensor() {
    let omega: Vec<f64> = (1..=20).map(|k| 10.0 * k as f64).collect();
    let G = modes(&omega, 0.001, &[1.0; 20]);
    let found = transmission_zeros(&G).unwrap();
    assert_eq!(found.len(), 38);
    let above: Vec<&C64> = found.iter().filter(|z| z.im > 0.0).collect();
    assert_eq!(above.len(), 19);
    // Collocated: one zero between each two modes, where the sum of the modes vanishes.
    for k in 0..19 {
        let z = above.iter().find(|z| z.norm() > omega[k] && z.norm() < omega[k + 1]).expect("interlacing");
        let terms = omega.iter().map(|o| (*z * *z + *z * (0.002 * o) + o * o).inv());
        let (sum, size) = terms.fold((C64::ZERO, 0.0), |(sum, size), t| (sum + t, size + t.norm()));
        assert!(sum.norm() < 1e-10 * size, "{z}");
    }
}

#[test]
fn gains_and_zero_functions() {
    let gain = |D: Mat| StateSpace::static_gain(D, Time::Continuous).unwrap();
    assert!(transmission_zeros(&gain(Mat::from_element(1, 1, 2.0))).unwrap().is_empty());
    assert!(transmission_zeros(&gain(Mat::zeros(2, 1))).unwrap().is_empty());
    let nothing = StateSpace { C: Mat::zeros(1, 4), ..tip_angle() };
    assert!(transmission_zeros(&nothing).unwrap().is_empty());
    let mut noise = Noise(5);
    let (G, one) = (noise.system(3, 1, 2, Time::Continuous), gain(Mat::from_column_slice(2, 1, &[1.0, -2.0])));
    let both = series(&G, &one).unwrap();
    assert_eq!([normal_rank(&both), normal_rank(&nothing), normal_rank(&tip_angle())], [1, 0, 1]);
}

#[test]
fn a_relative_degree_hidden_by_differences_is_seen() {
    // 1/(s+1) - 1/(s+2) = 1/((s+1)(s+2)): C B cancels.
    let lag = |pole: f64, gain: f64| {
        let one = |x| Mat::from_element(1, 1, x);
        StateSpace::new(one(-pole), one(1.0), one(gain), one(0.0), Time::Continuous).unwrap()
    };
    assert!(transmission_zeros(&parallel(&lag(1.0, 1.0), &lag(2.0, -1.0)).unwrap()).unwrap().is_empty());
    let found = transmission_zeros(&parallel(&lag(1.0, 1.0), &lag(2.0, -0.999)).unwrap()).unwrap();
    // (s + 2) - 0.999 (s + 1) = 0.001 s + 1.001
    assert!(distance(&found, &[C64::from(-1001.0)], 1.0) < 1e-11);
}

#[test]
fn minimal_keeps_the_function_and_drops_what_is_hidden() {
    let mut noise = Noise(6);
    let (G, hidden) = (noise.system(4, 2, 2, Time::Continuous), noise.system(3, 2, 2, Time::Continuous));
    let unreached = StateSpace { B: Mat::zeros(3, 2), D: Mat::zeros(2, 2), ..hidden.clone() };
    let unseen = StateSpace { C: Mat::zeros(2, 3), D: Mat::zeros(2, 2), ..hidden };
    let both = parallel(&parallel(&unreached, &G).unwrap(), &unseen).unwrap();
    let T = noise.matrix(10, 10);
    let lu = T.clone().lu();
    let mixed =
        StateSpace { A: lu.solve(&(&both.A * &T)).unwrap(), B: lu.solve(&both.B).unwrap(), C: &both.C * &T, ..both };
    let (least, s) = (minimal(&mixed), noise.point());
    assert_eq!([least.order(), minimal(&G).order()], [4, 4]);
    assert!(relative(&least.at(s), &G.at(s)) < 1e-11);
    assert!(distance(&least.poles(), &G.poles(), 0.1) < 1e-9);
    assert_eq!(minimal(&flexible_link([0.0, 1.0, 0.0, 0.0])).order(), 3);
    assert_eq!(minimal(&append(&tip_angle(), &tip_angle()).unwrap()).order(), 8);
}

#[test]
fn zeros_poles_and_gain_give_the_systems_values() {
    let mut noise = Noise(7);
    let lightly_damped = modes(&(1..=20).map(|k| 10.0 * k as f64).collect::<Vec<_>>(), 0.001, &[1.0; 20]);
    let systems = [
        tip_angle(),
        flexible_link([0.0, 1.0, 0.0, 0.0]),
        zoh(&tip_angle(), 1e-3).unwrap(),
        lightly_damped,
        noise.system(7, 1, 1, Time::Continuous),
        noise.system(0, 1, 1, Time::Continuous),
    ];
    for G in systems {
        let H = Zpk::from_state_space(&G).unwrap();
        for s in [C64::new(0.4, 0.9), C64::new(2.0, 35.0), C64::new(-1.0, 120.0)] {
            let G_s = G.at(s)[0];
            assert!((H.at(s) - G_s).norm() < 1e-8 * G_s.norm(), "{s} {} {G_s}", H.at(s));
        }
    }
    let psi = Zpk::from_state_space(&tip_angle()).unwrap();
    // b (k2 - k1), DESIGN section 2.
    assert!((psi.gain - 107.39 * 404.4).abs() < 1e-9 * psi.gain && psi.zeros.is_empty());
}

#[test]
fn zero_and_rectangular_functions_as_zeros_poles_and_gain() {
    let nothing = StateSpace { C: Mat::zeros(1, 4), ..tip_angle() };
    assert_eq!(Zpk::from_state_space(&nothing).unwrap().gain, 0.0);
    let wide = Noise(8).system(2, 1, 2, Time::Continuous);
    assert!(matches!(Zpk::from_state_space(&wide), Err(Error::Shape { .. })));
}
