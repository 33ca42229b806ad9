//! The table of orders and the stabilisation diagram.

use flexbeam_ident::excitation::white_gaussian;
use flexbeam_ident::orders::orders;
use flexbeam_ident::{Error, Method, Options, identify};
use flexbeam_lti::{Mat, Signals, StateSpace, Time, Vector, simulation};

const SAMPLES: usize = 6000;
const PERIOD_S: f64 = 0.01;
/// Natural frequencies [rad/s] and damping ratios.
const SWINGS: [(f64, f64); 2] = [(20.0, 0.02), (90.0, 0.005)];

/// Two swings seen by two outputs.
fn system() -> StateSpace {
    let mut A = Mat::zeros(4, 4);
    for (k, (omega, zeta)) in SWINGS.iter().enumerate() {
        let radius = (-zeta * omega * PERIOD_S).exp();
        let (sin, cos) = (omega * (1.0 - zeta * zeta).sqrt() * PERIOD_S).sin_cos();
        let block = Mat::from_row_slice(2, 2, &[cos, sin, -sin, cos]) * radius;
        A.view_mut((2 * k, 2 * k), (2, 2)).copy_from(&block);
    }
    let B = Mat::from_row_slice(4, 1, &[0.3, 0.5, 0.4, -0.2]);
    let C = Mat::from_row_slice(2, 4, &[1.0, 0.2, 0.5, 0.1, 0.3, 1.0, -0.8, 0.4]);
    StateSpace::new(A, B, C, Mat::zeros(2, 1), Time::Sampled { period_s: PERIOD_S }).unwrap()
}

fn record() -> (Signals, Signals) {
    let U = Mat::from_row_slice(1, SAMPLES, &white_gaussian(SAMPLES, 1.0, 9.0, 3));
    let Y = simulation::simulate(&system(), &U, &Vector::zeros(4)).unwrap();
    let noise = Mat::from_column_slice(2, SAMPLES, &white_gaussian(2 * SAMPLES, 1.0, 9.0, 4));
    let signals = |names: &[&str], data: Mat| {
        let names: Vec<String> = names.iter().map(|n| n.to_string()).collect();
        Signals::new(names.clone(), names, PERIOD_S, data).unwrap()
    };
    (signals(&["u"], U), signals(&["y1", "y2"], Y + noise * 0.3))
}

#[test]
fn the_true_order_is_the_criterion_s_and_its_swings_are_stable() {
    let (U, Y) = record();
    let rows = orders(&U, &Y, &Options::default(), 12).unwrap();
    assert_eq!(rows.iter().map(|row| row.order).collect::<Vec<_>>(), (1..=12).collect::<Vec<_>>());
    let least = rows.iter().min_by(|a, b| a.criterion.total_cmp(&b.criterion)).unwrap();
    assert_eq!(least.order, 4);
    for row in &rows {
        println!("order {:2}: criterion {:9.1}, fit {:?}", row.order, row.criterion, row.fit_percent.as_ref().unwrap());
        for (omega, zeta) in SWINGS {
            let near = row.modes.iter().find(|(mode, _)| (mode.frequency_rad_s / omega - 1.0).abs() < 0.01);
            if row.order >= 4 {
                let (mode, stable) = near.expect("the swing stays");
                assert!((mode.damping / zeta - 1.0).abs() < 0.2, "order {}: {mode:?}", row.order);
                assert!(row.order == 4 || (stable.frequency && stable.shape), "order {}: {stable:?}", row.order);
            }
        }
    }
    // What noise invents is stable in everything at few orders.
    let invented = |row: &&flexbeam_ident::orders::OrderRow| {
        row.modes.iter().any(|(mode, s)| {
            s.frequency
                && s.damping
                && s.shape
                && SWINGS.iter().all(|w| (mode.frequency_rad_s / w.0 - 1.0).abs() > 0.02)
        })
    };
    assert!(rows.iter().filter(invented).count() <= 4);
}

/// The row of an order is the model that `identify` finds.
#[test]
fn a_row_is_the_model_of_that_order() {
    let (U, Y) = record();
    let options = Options { method: Method::Moesp, ..Options::default() };
    let row = orders(&U, &Y, &options, 6).unwrap().pop().unwrap();
    let alone = identify(&U, &Y, &Options { order: flexbeam_ident::Order::Fixed(6), ..options.clone() }).unwrap();
    assert_eq!(row.fit_percent, alone.fit_percent);
    let refused = orders(&U, &Y, &Options { method: Method::Paper, ..options }, 6);
    assert!(matches!(refused, Err(Error::Structure { .. })));
}
