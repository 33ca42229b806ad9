//! Seconds that a recording of 10^6 rows and 3 columns takes to write and to read.
//!
//! `cargo run --release -p flexbeam-files --example read_speed`

use flexbeam_files::{Layout, Recording, csv_text};
use flexbeam_lti::{Mat, Signals};
use std::path::Path;
use std::time::Instant;

fn main() {
    const ROWS: usize = 1_000_000;
    let data = Mat::from_fn(2, ROWS, |r, k| ((k * (r + 7)) as f64 * 0.618).sin());
    let names = vec!["voltage_v".to_string(), "theta_rad".to_string()];
    let units = vec!["v".to_string(), "rad".to_string()];
    let signals = Signals::new(names, units, 1e-3, data).expect("two names, two rows");
    let start = Instant::now();
    let text = csv_text(&signals, None);
    println!("write: {:.3} s, {:.1} MB", start.elapsed().as_secs_f64(), text.len() as f64 / 1e6);
    let start = Instant::now();
    let read =
        Recording::parse(text.as_bytes(), Path::new("memory.csv"), &Layout::default()).expect("what was written");
    println!("read:  {:.3} s, the same bits: {}", start.elapsed().as_secs_f64(), read.signals == signals);
}
