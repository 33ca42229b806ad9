use crate::plants::{Noise, relative};
use flexbeam_lti::connections::{append, feedback, inverse, parallel, select, series};
use flexbeam_lti::{CMat, Error, Mat, StateSpace, Time};

const ROUNDING: f64 = 1e-12;

fn identity(n: usize) -> CMat {
    CMat::identity(n, n)
}

#[test]
fn series_is_the_product_and_parallel_the_sum() {
    let mut noise = Noise(1);
    for (n1, n2) in [(3, 2), (0, 2), (3, 0), (0, 0)] {
        let (G, H) = (noise.system(n1, 2, 3, Time::Continuous), noise.system(n2, 4, 2, Time::Continuous));
        let (J, s) = (noise.system(n2, 2, 3, Time::Continuous), noise.point());
        assert!(relative(&series(&G, &H).unwrap().at(s), &(H.at(s) * G.at(s))) < ROUNDING);
        assert!(relative(&parallel(&G, &J).unwrap().at(s), &(G.at(s) + J.at(s))) < ROUNDING);
    }
}

#[test]
fn feedback_solves_the_loop_equation() {
    let mut noise = Noise(2);
    for (n1, n2) in [(3, 2), (0, 2), (3, 0), (0, 0)] {
        let (G, K) = (noise.system(n1, 2, 3, Time::Continuous), noise.system(n2, 3, 2, Time::Continuous));
        let (closed, s) = (feedback(&G, &K).unwrap(), noise.point());
        // y = G (u - K y) for u = each unit vector.
        let y = closed.at(s);
        assert!(relative(&(G.at(s) * (identity(3) - K.at(s) * &y)), &y) < ROUNDING);
        assert_eq!(closed.order(), n1 + n2);
    }
}

#[test]
fn closed_loop_poles_are_roots_of_the_return_difference() {
    let mut noise = Noise(3);
    let (G, K) = (noise.system(3, 2, 2, Time::Continuous), noise.system(2, 2, 2, Time::Continuous));
    for p in feedback(&G, &K).unwrap().poles() {
        let difference = identity(2) + K.at(p) * G.at(p);
        assert!(difference.determinant().norm() < 1e-9 * (K.at(p) * G.at(p)).norm().powi(2));
    }
}

#[test]
fn a_singular_loop_is_refused() {
    let one = StateSpace::static_gain(Mat::from_element(1, 1, 2.0), Time::Continuous).unwrap();
    let minus = StateSpace::static_gain(Mat::from_element(1, 1, -0.5), Time::Continuous).unwrap();
    assert!(matches!(feedback(&one, &minus), Err(Error::AlgebraicLoop { .. })));
    // 1 + D_K D_G is rounding, not zero.
    let third = StateSpace { D: Mat::from_element(1, 1, 3.0), ..one.clone() };
    let almost = StateSpace { D: Mat::from_element(1, 1, -1.0 / 3.0 * (1.0 + 4e-16)), ..minus.clone() };
    assert!(matches!(feedback(&third, &almost), Err(Error::AlgebraicLoop { .. })));
}

#[test]
fn inverse_times_system_is_the_identity() {
    let mut noise = Noise(4);
    let G = noise.system(3, 2, 2, Time::Sampled { period_s: 0.1 });
    let s = noise.point();
    assert!(relative(&(inverse(&G).unwrap().at(s) * G.at(s)), &identity(2)) < ROUNDING);
    let strictly_proper = StateSpace { D: Mat::zeros(2, 2), ..G.clone() };
    assert!(matches!(inverse(&strictly_proper), Err(Error::SingularFeedthrough { .. })));
    assert!(matches!(inverse(&noise.system(1, 2, 3, Time::Continuous)), Err(Error::Shape { .. })));
}

#[test]
fn append_and_select_return_what_went_in() {
    let mut noise = Noise(5);
    let (G, H) = (noise.system(3, 2, 1, Time::Continuous), noise.system(2, 1, 2, Time::Continuous));
    let (both, s) = (append(&G, &H).unwrap(), noise.point());
    assert!(relative(&select(&both, &[0, 1], &[0]).unwrap().at(s), &G.at(s)) < ROUNDING);
    assert!(relative(&select(&both, &[2], &[1, 2]).unwrap().at(s), &H.at(s)) < ROUNDING);
    assert_eq!(select(&both, &[0, 1], &[1, 2]).unwrap().at(s).norm(), 0.0);
    assert_eq!(select(&G, &[2], &[0]).unwrap_err(), Error::NoSuchChannel { what: "output", index: 2, count: 2 });
}

#[test]
fn shapes_and_periods_that_do_not_fit_are_refused() {
    let mut noise = Noise(6);
    let G = noise.system(1, 2, 1, Time::Continuous);
    assert!(matches!(series(&G, &G), Err(Error::Shape { found_columns: 1, needed_columns: 2, .. })));
    assert!(matches!(feedback(&G, &G), Err(Error::Shape { .. })));
    let H = noise.system(1, 2, 1, Time::Sampled { period_s: 0.1 });
    assert!(matches!(parallel(&G, &H), Err(Error::TimeMismatch { .. })));
    assert!(matches!(append(&G, &H), Err(Error::TimeMismatch { .. })));
}
