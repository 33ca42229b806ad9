//! The five DaISy recordings of shared/data, by the default method, beside the figures that DESIGN section 5 gives.

use std::path::PathBuf;

use flexbeam_ident::validate::validate;
use flexbeam_ident::{Doubt, Identified, Options, Order, identify};
use flexbeam_lti::{Mat, Signals};

struct Case {
    file: &'static str,
    inputs: &'static [usize],
    outputs: &'static [usize],
    period_s: f64,
    block_rows: usize,
    order: usize,
    /// The best of five other programs, shared/data/README.md.
    best_peer_percent: f64,
}

const CASES: [Case; 5] = [
    Case {
        file: "robot_arm.dat",
        inputs: &[0],
        outputs: &[1],
        period_s: 1.0,
        block_rows: 20,
        order: 4,
        best_peer_percent: 96.40,
    },
    Case {
        file: "CD_player_arm.dat",
        inputs: &[0, 1],
        outputs: &[2, 3],
        period_s: 1.0,
        block_rows: 15,
        order: 8,
        best_peer_percent: 74.91,
    },
    Case {
        file: "dryer.dat",
        inputs: &[0],
        outputs: &[1],
        period_s: 0.08,
        block_rows: 15,
        order: 4,
        best_peer_percent: 85.86,
    },
    Case {
        file: "evaporator.dat",
        inputs: &[0, 1, 2],
        outputs: &[3, 4, 5],
        period_s: 1.0,
        block_rows: 10,
        order: 4,
        best_peer_percent: 53.11,
    },
    Case {
        file: "heating_system.dat",
        inputs: &[1],
        outputs: &[2],
        period_s: 2.0,
        block_rows: 15,
        order: 7,
        best_peer_percent: 74.82,
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

/// Fit on the second half by the peers' protocol: means of the first half removed, initial state by least squares, no offset.
fn peers_fit(inputs: &Signals, outputs: &Signals, found: &Identified) -> f64 {
    let second = |signals: &Signals| {
        let (half, s) = (signals.samples() / 2, signals.samples());
        let mut part = signals.data.columns(half, s - half).into_owned();
        for (c, mut row) in part.row_iter_mut().enumerate() {
            row.add_scalar_mut(-signals.data.row(c).columns(0, half).mean());
        }
        part
    };
    mean(&validate(&found.model, &second(inputs), &second(outputs)).unwrap().fit_percent)
}

/// Within 0.3 of the best peer, both with the offset that the estimating half shows and without, as the peers are measured.
#[test]
fn default_method_is_as_good_as_the_best_peer() {
    for case in &CASES {
        let Some((inputs, outputs)) = recording(case) else { continue };
        let options = Options {
            block_rows: case.block_rows,
            order: Order::Fixed(case.order),
            remove_mean: true,
            ..Options::default()
        };
        let found = identify(&inputs, &outputs, &options).expect(case.file);
        let fit = mean(found.fit_percent.as_ref().expect("half of the record validates"));
        let alike = peers_fit(&inputs, &outputs, &found);
        let (best, method) = (case.best_peer_percent, found.method);
        println!("{:20} {method:?}: {fit:6.2} %, without offset {alike:6.2} % (best peer {best})", case.file);
        assert!(fit.min(alike) >= best - 0.3, "{}: fit {fit:.2} %, without offset {alike:.2} %", case.file);
    }
}

/// Nothing set but the means: i = 20, order by the rule. It costs at most one percent.
#[test]
fn plain_defaults_do_nearly_as_well() {
    for case in &CASES {
        let Some((inputs, outputs)) = recording(case) else { continue };
        let found = identify(&inputs, &outputs, &Options { remove_mean: true, ..Options::default() }).expect(case.file);
        let fit = mean(found.fit_percent.as_ref().expect("half of the record validates"));
        let alike = peers_fit(&inputs, &outputs, &found);
        let (order, method) = (found.order, found.method);
        println!("{:20} {method:?}, order {order}: {fit:6.2} %, without offset {alike:6.2} %", case.file);
        assert!(fit >= case.best_peer_percent - 1.0, "{}: order {order}, fit {fit:.2} %", case.file);
    }
}

/// What makes the real recordings doubtful; the disc player's arm was measured in closed loop.
#[test]
fn doubts_about_real_recordings() {
    for case in &CASES {
        let Some((inputs, outputs)) = recording(case) else { continue };
        let found = identify(&inputs, &outputs, &Options { remove_mean: true, ..Options::default() }).expect(case.file);
        println!("{:20} {:?}", case.file, found.doubts);
        let feedback = found.doubts.iter().any(|doubt| matches!(doubt, Doubt::Feedback { .. }));
        assert!(feedback || case.file != "CD_player_arm.dat");
        assert!(found.innovations.is_some(), "{}", case.file);
    }
}
