//! The five DaISy recordings of shared/data, by the default method, beside the figures that DESIGN section 5 gives.

use std::path::PathBuf;

use flexbeam_ident::{Options, Order, identify};
use flexbeam_lti::{Mat, Signals};

struct Case {
    file: &'static str,
    inputs: &'static [usize],
    outputs: &'static [usize],
    period_s: f64,
    block_rows: usize,
    order: usize,
    least_fit_percent: f64,
}

const CASES: [Case; 5] = [
    Case {
        file: "robot_arm.dat",
        inputs: &[0],
        outputs: &[1],
        period_s: 1.0,
        block_rows: 20,
        order: 4,
        least_fit_percent: 96.2,
    },
    Case {
        file: "CD_player_arm.dat",
        inputs: &[0, 1],
        outputs: &[2, 3],
        period_s: 1.0,
        block_rows: 15,
        order: 8,
        least_fit_percent: 74.0,
    },
    Case {
        file: "dryer.dat",
        inputs: &[0],
        outputs: &[1],
        period_s: 0.08,
        block_rows: 15,
        order: 4,
        least_fit_percent: 85.5,
    },
    Case {
        file: "evaporator.dat",
        inputs: &[0, 1, 2],
        outputs: &[3, 4, 5],
        period_s: 1.0,
        block_rows: 10,
        order: 4,
        least_fit_percent: 52.5,
    },
    Case {
        file: "heating_system.dat",
        inputs: &[1],
        outputs: &[2],
        period_s: 2.0,
        block_rows: 15,
        order: 7,
        least_fit_percent: 68.0,
    },
];

fn folder() -> PathBuf {
    let workspace = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    std::env::var_os("FLEXBEAM_DATA").map(PathBuf::from).unwrap_or_else(|| workspace.join("../shared/data"))
}

/// None, loudly, when the recording is not there.
fn recording(case: &Case) -> Option<(Signals, Signals)> {
    let path = folder().join(case.file);
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!(
            "\n!!! LEFT OUT: {} is missing; set FLEXBEAM_DATA to the folder of the recordings !!!\n",
            path.display()
        );
        return None;
    };
    let rows: Vec<Vec<f64>> = text
        .lines()
        .map(|line| line.split_whitespace().map(|cell| cell.parse().expect("a number")).collect())
        .collect();
    let signals = |columns: &[usize]| {
        let data = Mat::from_fn(columns.len(), rows.len(), |c, k| rows[k][columns[c]]);
        let names = columns.iter().map(|c| format!("column {c}")).collect();
        Signals::new(names, vec![String::new(); columns.len()], case.period_s, data).expect("shapes fit")
    };
    Some((signals(case.inputs), signals(case.outputs)))
}

fn mean(fits: &[f64]) -> f64 {
    fits.iter().sum::<f64>() / fits.len() as f64
}

#[test]
fn default_method_reaches_the_published_fits() {
    for case in &CASES {
        let Some((inputs, outputs)) = recording(case) else { continue };
        let options = Options {
            block_rows: case.block_rows,
            order: Order::Fixed(case.order),
            remove_mean: true,
            ..Options::default()
        };
        let found = identify(&inputs, &outputs, &options).expect(case.file);
        let fit = mean(&found.fit_percent.expect("half of the record validates"));
        println!("{:20} {fit:6.2} % (needed {})", case.file, case.least_fit_percent);
        assert!(fit >= case.least_fit_percent, "{}: fit {fit:.2} %", case.file);
    }
}

/// The automatic order costs at most one percent against the orders that the comparisons use.
#[test]
fn automatic_order_does_as_well() {
    for case in &CASES {
        let Some((inputs, outputs)) = recording(case) else { continue };
        let options = Options { block_rows: case.block_rows, remove_mean: true, ..Options::default() };
        let found = identify(&inputs, &outputs, &options).expect(case.file);
        let fit = mean(&found.fit_percent.expect("half of the record validates"));
        println!("{:20} order {} by itself: {fit:6.2} %", case.file, found.order);
        assert!(fit >= case.least_fit_percent - 1.0, "{}: order {}, fit {fit:.2} %", case.file, found.order);
    }
}
