use crate::plants::Noise;
use flexbeam_lti::simulation::simulate;
use flexbeam_lti::{Error, Mat, StateSpace, Time, Vector};

const TIME: Time = Time::Sampled { period_s: 0.1 };

#[test]
fn the_response_is_the_sum_of_free_response_and_convolution() {
    let mut noise = Noise(1);
    let G = noise.system(4, 2, 3, TIME);
    let (u, x0) = (noise.matrix(3, 10), Vector::from_fn(4, |_, _| noise.next()));
    let y = simulate(&G, &u, &x0).unwrap();
    for k in 0..10 {
        let power = |p: usize| (0..p).fold(Mat::identity(4, 4), |M, _| M * &G.A);
        let mut wanted = &G.C * power(k) * &x0 + &G.D * u.column(k);
        for i in 0..k {
            wanted += &G.C * power(k - 1 - i) * &G.B * u.column(i);
        }
        assert!((y.column(k) - &wanted).norm() < 1e-13 * wanted.norm());
    }
}

#[test]
fn empty_states_and_empty_signals_are_allowed() {
    let D = Mat::from_row_slice(1, 2, &[2.0, 3.0]);
    let gain = StateSpace::static_gain(D, TIME).unwrap();
    let y = simulate(&gain, &Mat::from_element(2, 3, 1.0), &Vector::zeros(0)).unwrap();
    assert_eq!(y, Mat::from_element(1, 3, 5.0));
    assert_eq!(simulate(&gain, &Mat::zeros(2, 0), &Vector::zeros(0)).unwrap().shape(), (1, 0));
}

#[test]
fn wrong_shapes_and_continuous_time_are_refused() {
    let mut noise = Noise(2);
    let G = noise.system(2, 1, 1, TIME);
    assert!(matches!(simulate(&G, &Mat::zeros(2, 5), &Vector::zeros(2)), Err(Error::Shape { .. })));
    assert!(matches!(simulate(&G, &Mat::zeros(1, 5), &Vector::zeros(3)), Err(Error::Shape { .. })));
    let continuous = StateSpace { time: Time::Continuous, ..G };
    assert!(matches!(simulate(&continuous, &Mat::zeros(1, 5), &Vector::zeros(2)), Err(Error::WrongTime { .. })));
}
