//! The voltages of an experiment: spectrum, crest factor, period, peak; judged by sums over their samples.

use flexbeam_ident::Error;
use flexbeam_ident::excitation::{Excitation, Plan, Shape, binary_sequence, white_gaussian};
use flexbeam_lti::C64;

const PLAN: Plan = Plan {
    shape: Shape::Multisine,
    band_hz: Some([1.0, 100.0]),
    rms_v: 3.0,
    peak_v: 10.0,
    periods: 3,
    samples: 6000,
    period_s: 0.001,
    seed: 7,
};

/// Amplitude [V] of harmonic k of one period, by its defining sum.
fn amplitude(one: &[f64], k: usize) -> f64 {
    let n = one.len();
    let turn = |t: usize| C64::cis(-std::f64::consts::TAU * (k * t % n) as f64 / n as f64);
    let sum: C64 = one.iter().enumerate().map(|(t, v)| turn(t) * *v).sum();
    2.0 * sum.norm() / n as f64
}

fn one_period(found: &Excitation) -> Vec<f64> {
    let period = found.period_samples.expect("it repeats");
    let one = found.voltage_v[..period].to_vec();
    assert!(found.voltage_v.chunks(period).all(|chunk| chunk == one), "each period is the first one");
    one
}

/// 2 s a period: harmonic k lies at k/2 Hz, the band from 1 to 100 Hz is 2 to 200.
#[test]
fn a_multisine_is_flat_in_its_band_and_has_a_low_crest() {
    let found = PLAN.excitation().unwrap();
    assert_eq!((found.voltage_v.len(), found.period_samples), (6000, Some(2000)));
    let one = one_period(&found);
    let flat = 3.0 * (2.0 / 199.0f64).sqrt();
    for k in 0..=1000 {
        let wanted = if (2..=200).contains(&k) { flat } else { 0.0 };
        assert!((amplitude(&one, k) - wanted).abs() < 1e-10, "harmonic {k}");
    }
    assert!((found.rms_v() - 3.0).abs() < 1e-12);
    // Schroeder's phases alone give 1.7; random ones 3.
    println!("crest factor {:.3}", found.crest_factor());
    assert!(found.crest_factor() < 1.5, "{}", found.crest_factor());
    assert_eq!(found.band_hz, Some([1.0, 100.0]));
}

#[test]
fn an_odd_multisine_leaves_even_and_some_odd_harmonics_out() {
    let plan = Plan { shape: Shape::OddMultisine, ..PLAN };
    let one = one_period(&plan.excitation().unwrap());
    let excited: Vec<usize> = (0..=1000).filter(|k| amplitude(&one, *k) > 1e-9).collect();
    assert!(excited.iter().all(|k| k % 2 == 1 && (2..=200).contains(k)));
    // 99 odd harmonics from 3 to 199: 24 groups of four, each without one, and three more.
    assert_eq!(excited.len(), 24 * 3 + 3);
    for group in 0..24 {
        let first = 3 + 8 * group;
        assert_eq!(excited.iter().filter(|k| (first..first + 8).contains(&**k)).count(), 3, "group from {first}");
    }
    let flat = 3.0 * (2.0 / excited.len() as f64).sqrt();
    assert!(excited.iter().all(|k| (amplitude(&one, *k) - flat).abs() < 1e-10));
    let other = Plan { seed: 8, ..plan }.excitation().unwrap();
    let others: Vec<usize> = (0..=1000).filter(|k| amplitude(&other.voltage_v[..2000], *k) > 1e-9).collect();
    assert_ne!(excited, others, "another seed draws another grid");
}

/// Every register of the table runs through all its states: a sequence of maximal length has autocorrelation -1 off zero.
#[test]
fn binary_sequences_have_maximal_length() {
    for stages in 3..=24 {
        let one = binary_sequence(stages, 5).unwrap();
        let n = (1usize << stages) - 1;
        assert_eq!(one.len(), n);
        assert!((one.iter().sum::<f64>().abs() - 1.0).abs() < 0.5, "{stages} stages");
        let lags = if stages <= 9 { (1..n).collect() } else { vec![1, 2, stages as usize, n / 3, n / 2] };
        for lag in lags {
            let r: f64 = (0..n).map(|t| one[t] * one[(t + lag) % n]).sum();
            assert_eq!(r, -1.0, "{stages} stages, lag {lag}");
        }
    }
    assert_eq!((binary_sequence(2, 1), binary_sequence(25, 1)), (None, None));
}

#[test]
fn a_binary_signal_has_two_voltages_its_clock_and_a_length_near_to_what_was_asked() {
    let plan = Plan { shape: Shape::Prbs, band_hz: Some([0.5, 40.0]), ..PLAN };
    let found = plan.excitation().unwrap();
    let one = one_period(&found);
    assert!(one.iter().all(|v| v.abs() == 3.0));
    assert!((found.crest_factor() - 1.0).abs() < 1e-12);
    // 0.443/(40 Hz 1 ms) = 11.1 samples a clock; 2000/11 = 182 clocks: 127 and 255 are the choice.
    assert_eq!((found.clock_samples, found.period_samples), (Some(11), Some(255 * 11)));
    assert!(one.chunks(11).all(|clock| clock.iter().all(|v| *v == clock[0])));
    // Half of the power is left at the band's end.
    let power = |hz: f64| amplitude(&one, (hz * 0.001 * one.len() as f64).round() as usize).powi(2);
    let ratio = power(40.0) / power(1.0);
    assert!((0.45..0.60).contains(&ratio), "{ratio}");
}

/// The energy of a chirp lies in its band, and a logarithmic one falls by 3 dB an octave.
#[test]
fn chirps_stay_in_their_band_and_repeat_without_a_jump() {
    for shape in [Shape::Chirp, Shape::LogChirp] {
        let plan = Plan { shape, band_hz: Some([5.0, 50.0]), samples: 30_000, ..PLAN };
        let found = plan.excitation().unwrap();
        let one = one_period(&found);
        assert!((found.rms_v() / 3.0 - 1.0).abs() < 1e-9, "{shape:?}: {}", found.rms_v());
        assert!((found.crest_factor() - 2f64.sqrt()).abs() < 0.01, "{shape:?}");
        let power: Vec<f64> = (0..=5000).map(|k| amplitude(&one, k).powi(2)).collect();
        let part = |from_hz: usize, to_hz: usize| power[from_hz * 10..to_hz * 10].iter().sum::<f64>();
        assert!(part(5, 50) > 0.96 * power.iter().sum::<f64>(), "{shape:?}: {}", part(5, 50));
        let ratio = part(10, 15) / part(35, 40);
        let wanted = if shape == Shape::Chirp { 1.0 } else { 1.5f64.ln() / (40.0f64 / 35.0).ln() };
        assert!((ratio / wanted - 1.0).abs() < 0.1, "{shape:?}: {ratio} for {wanted}");
        let steepest = std::f64::consts::TAU * 50.0 * 0.001 * found.peak_v();
        let jump = one[0] - one[one.len() - 1];
        assert!(jump.abs() < 1.05 * steepest, "{shape:?}: {jump}");
    }
}

#[test]
fn white_noise_keeps_its_bits_without_a_band_and_its_band_with_one() {
    let plan = Plan { shape: Shape::White, band_hz: None, periods: 1, ..PLAN };
    let found = plan.excitation().unwrap();
    assert_eq!(found.voltage_v, white_gaussian(6000, 3.0, 10.0, 7));
    assert_eq!(found.period_samples, None);
    let banded = Plan { band_hz: Some([10.0, 30.0]), peak_v: 100.0, ..plan }.excitation().unwrap();
    assert!((banded.rms_v() - 3.0).abs() < 1e-12);
    for k in (1..2990).step_by(7) {
        let inside = (60..=180).contains(&k);
        assert_eq!(amplitude(&banded.voltage_v, k) > 1e-9, inside, "harmonic {k}");
    }
    let repeated = Plan { periods: 2, ..plan }.excitation().unwrap();
    assert_eq!(repeated.period_samples, Some(3000));
    one_period(&repeated);
}

/// The whole signal becomes smaller, so its spectrum stays; white noise alone is clipped.
#[test]
fn no_voltage_stands_above_the_peak() {
    for shape in [Shape::White, Shape::Prbs, Shape::Multisine, Shape::OddMultisine, Shape::Chirp, Shape::LogChirp] {
        let found = Plan { shape, peak_v: 2.0, ..PLAN }.excitation().unwrap();
        assert!((1.999_999_999..=2.0).contains(&found.peak_v()), "{shape:?}: {}", found.peak_v());
        assert!(found.rms_v() <= 2.0);
    }
    let found = Plan { shape: Shape::OddMultisine, peak_v: 2.0, ..PLAN }.excitation().unwrap();
    assert!(amplitude(&one_period(&found), 4) < 1e-10, "nothing was clipped");
}

#[test]
fn numbers_of_which_no_signal_can_be_made_are_refused() {
    let refused = |plan: Plan| match plan.excitation().unwrap_err() {
        Error::Setting { setting, found, .. } => (setting, found),
        other => panic!("{other:?}"),
    };
    assert_eq!(refused(Plan { rms_v: -1.0, ..PLAN }), ("rms_v", -1.0));
    assert_eq!(refused(Plan { peak_v: 0.0, ..PLAN }), ("peak_v", 0.0));
    assert_eq!(refused(Plan { band_hz: Some([1.0, 501.0]), ..PLAN }).1, 501.0);
    assert_eq!(refused(Plan { band_hz: Some([-1.0, 50.0]), ..PLAN }).1, -1.0);
    assert_eq!(refused(Plan { band_hz: Some([50.0, 10.0]), ..PLAN }).1, 10.0);
    assert!(refused(Plan { band_hz: Some([f64::NAN, 10.0]), ..PLAN }).1.is_nan());
    assert_eq!(refused(Plan { periods: 0, ..PLAN }).1, 0.0);
    assert_eq!(refused(Plan { periods: 1000, ..PLAN }).1, 6.0);
    assert_eq!(refused(Plan { band_hz: Some([1.1, 1.4]), ..PLAN }).1, 0.0);
    let slow = Plan { shape: Shape::Prbs, band_hz: Some([0.01, 100.0]), ..PLAN };
    assert_eq!(refused(slow).1, 100.0);
}
