//! Bad input: what is refused, with which numbers.

use flexbeam_ident::excitation::white_gaussian;
use flexbeam_ident::{Delay, Error, Options, Order, identify};
use flexbeam_lti::{Mat, Signals};

fn channel(name: &str, period_s: f64, data: Vec<f64>) -> Signals {
    let data = Mat::from_row_slice(1, data.len(), &data);
    Signals::new(vec![name.into()], vec!["v".into()], period_s, data).unwrap()
}

/// y(k) = 0.5 y(k-1) + u(k-1).
fn answer(u: &[f64]) -> Vec<f64> {
    let next = |y: &mut f64, u: &f64| {
        let now = *y;
        *y = 0.5 * now + u;
        Some(now)
    };
    u.iter().scan(0.0, next).collect()
}

fn white(samples: usize) -> Vec<f64> {
    white_gaussian(samples, 1.0, 9.0, 1)
}

fn refused(u: Signals, y: Signals, options: Options) -> Error {
    identify(&u, &y, &options).expect_err("this input is bad")
}

#[test]
fn a_missing_value_is_named_by_channel_and_sample() {
    let u = white(1000);
    let mut y = answer(&u);
    y[417] = f64::NAN;
    let error = refused(channel("voltage_v", 0.1, u), channel("theta_rad", 0.1, y), Options::default());
    assert!(matches!(&error, Error::NotFinite { channel, sample: 417, .. } if channel == "theta_rad"), "{error}");
}

/// A delay takes the first outputs and the last inputs out of the equations, not out of sight.
#[test]
fn a_missing_value_is_named_where_a_delay_passes_over_it() {
    for delay in [Delay::Samples(5), Delay::Auto] {
        for (first, sample) in [(false, 2), (true, 998)] {
            let (mut u, mut y) = (white(1000), answer(&white(1000)));
            (if first { &mut u } else { &mut y })[sample] = f64::NAN;
            let options = Options { delay, ..Options::default() };
            let error = refused(channel("voltage_v", 0.1, u), channel("theta_rad", 0.1, y), options);
            assert!(matches!(&error, Error::NotFinite { sample: found, .. } if *found == sample), "{delay:?}: {error}");
        }
    }
}

#[test]
fn a_constant_input_is_not_exciting() {
    for level in [0.0, 3.0, 0.1] {
        let u = vec![level; 1000];
        let y = answer(&u);
        let error =
            refused(channel("u", 0.1, u), channel("y", 0.1, y), Options { remove_mean: true, ..Options::default() });
        assert_eq!(error, Error::NotExciting { rank: 0, needed: 40, block_rows: 20 });
    }
    let u = vec![3.0; 1000];
    let error = refused(channel("u", 0.1, u.clone()), channel("y", 0.1, answer(&u)), Options::default());
    assert_eq!(error, Error::NotExciting { rank: 1, needed: 40, block_rows: 20 });
}

/// k sines excite to order 2k.
#[test]
fn three_sines_have_rank_six() {
    let u: Vec<f64> = (0..1000).map(|k| [0.3, 0.9, 1.7].iter().map(|w| (w * f64::from(k)).sin()).sum()).collect();
    let y = answer(&u);
    let error = refused(channel("u", 0.1, u), channel("y", 0.1, y), Options::default());
    assert_eq!(error, Error::NotExciting { rank: 6, needed: 40, block_rows: 20 });
}

#[test]
fn too_few_samples_say_how_many_are_needed() {
    let u = white(200);
    let y = answer(&u);
    let error = refused(channel("u", 0.1, u), channel("y", 0.1, y), Options::default());
    assert_eq!(error, Error::TooFewSamples { what: "estimation", found: 100, needed: 119, block_rows: 20 });
    for samples in [0, 1, 2] {
        let u = white(samples);
        let error = refused(
            channel("u", 0.1, u.clone()),
            channel("y", 0.1, u),
            Options { estimate: 1.0, ..Options::default() },
        );
        assert_eq!(error, Error::TooFewSamples { what: "estimation", found: samples, needed: 119, block_rows: 20 });
    }
    let u = white(1000);
    let y = answer(&u);
    let error = refused(channel("u", 0.1, u), channel("y", 0.1, y), Options { estimate: 0.99, ..Options::default() });
    assert_eq!(error, Error::TooFewSamples { what: "validation", found: 10, needed: 40, block_rows: 20 });
}

#[test]
fn lengths_periods_and_settings_that_do_not_fit() {
    let u = white(1000);
    let y = answer(&u);
    let both = |input_s: f64, output_s: f64, cut: usize| {
        (channel("u", input_s, u.clone()), channel("y", output_s, y[cut..].to_vec()))
    };
    let (a, b) = both(0.1, 0.1, 1);
    assert_eq!(refused(a, b, Options::default()), Error::Length { inputs: 1000, outputs: 999 });
    let (a, b) = both(0.1, 0.2, 0);
    assert_eq!(refused(a, b, Options::default()), Error::Period { input_s: 0.1, output_s: 0.2 });
    let settings = [
        ("block_rows", Options { block_rows: 1, ..Options::default() }),
        ("order", Options { order: Order::Fixed(0), ..Options::default() }),
        ("estimate", Options { estimate: 0.0, ..Options::default() }),
        ("estimate", Options { estimate: f64::NAN, ..Options::default() }),
        ("estimate", Options { estimate: 1.5, ..Options::default() }),
    ];
    for (name, options) in settings {
        let (a, b) = both(0.1, 0.1, 0);
        let error = refused(a, b, options);
        assert!(matches!(&error, Error::Setting { setting, .. } if *setting == name), "{error}");
    }
    let nobody = Signals::new(vec![], vec![], 0.1, Mat::zeros(0, 1000)).unwrap();
    let (a, _) = both(0.1, 0.1, 0);
    assert_eq!(refused(a, nobody, Options::default()), Error::NoChannel { inputs: 1, outputs: 0 });
}

#[test]
fn orders_that_the_data_cannot_carry() {
    let u = white(1000);
    let y = answer(&u);
    let asked = |order| {
        refused(
            channel("u", 0.1, u.clone()),
            channel("y", 0.1, y.clone()),
            Options { order: Order::Fixed(order), ..Options::default() },
        )
    };
    assert!(matches!(asked(20), Error::Order { order: 20, largest: 19, .. }));
    assert!(
        matches!(asked(5), Error::Order { order: 5, largest: 1, .. }),
        "noise-free data of order one: {}",
        asked(5)
    );
    let still = |level: f64| channel("y", 0.1, vec![level; 1000]);
    assert_eq!(refused(channel("u", 0.1, u.clone()), still(0.0), Options::default()), Error::NoState);
    let options = Options { remove_mean: true, ..Options::default() };
    assert_eq!(refused(channel("u", 0.1, u.clone()), still(0.1), options), Error::NoState);
}

/// A pole at -0.5 has no continuous counterpart; the sampled model stands all the same.
#[test]
fn a_negative_pole_leaves_the_continuous_form_out_with_a_reason() {
    let u = white(1000);
    let y: Vec<f64> = answer(&u).iter().enumerate().map(|(k, y)| if k % 2 == 0 { *y } else { -y }).collect();
    let flipped: Vec<f64> = u.iter().enumerate().map(|(k, u)| if k % 2 == 0 { -u } else { *u }).collect();
    let found = identify(&channel("u", 0.1, flipped), &channel("y", 0.1, y), &Options::default()).unwrap();
    assert_eq!(found.order, 1);
    assert!((found.model.A[(0, 0)] + 0.5).abs() < 1e-12);
    let reason = found.continuous.expect_err("no real logarithm").to_string();
    assert!(reason.contains("-0.5"), "{reason}");
}
