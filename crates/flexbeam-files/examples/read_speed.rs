//! How fast a table is read: whole, in chunks, its numbers alone, its bytes alone.
//!
//! `cargo run --release -p flexbeam-files --example read_speed [ROWS]`
//!
//! The file goes into the folder of temporary files: 57 bytes a row. It is read from the system's cache, so that the disk does not
//! count; each figure is the best of three.

use flexbeam_files::{Chunks, Layout, Recording};
use std::fs::File;
use std::hint::black_box;
use std::io::{BufWriter, Read, Write};
use std::path::Path;
use std::time::Instant;

fn main() {
    let rows = std::env::args().nth(1).map_or(1_000_000, |rows| rows.parse().expect("a number of rows"));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("long.csv");
    write(&path, rows);
    let bytes = std::fs::metadata(&path).expect("it was written").len() as f64;
    println!("{rows} rows, {:.1} MB, three columns of 16 digits", bytes / 1e6);
    let report = |what: &str, run: &mut dyn FnMut()| {
        let best = (0..3).map(|_| seconds(run)).fold(f64::MAX, f64::min);
        println!("{what:44} {best:8.3} s {:8.0} MB/s {:6.1} Mrows/s", bytes / best / 1e6, rows as f64 / best / 1e6);
    };
    report("the bytes, 1 MiB at a time", &mut || scan(&path, |_| 0));
    report("as wc -l counts", &mut || scan(&path, |block| memchr::memchr_iter(b'\n', block).count()));
    if rows <= 3_000_000 {
        let text = std::fs::read_to_string(&path).expect("text");
        let cells: Vec<&str> = text.lines().skip(1).flat_map(|line| line.split(',')).collect();
        report("numbers already found: the standard library", &mut || {
            black_box(cells.iter().map(|cell| cell.parse::<f64>().expect("a number")).sum::<f64>());
        });
        report("numbers already found: fast-float2", &mut || {
            black_box(cells.iter().map(|cell| fast_float2::parse::<f64, _>(cell).expect("a number")).sum::<f64>());
        });
        report("Recording::read", &mut || {
            black_box(Recording::read(&path, &Layout::default()).expect("a table"));
        });
    }
    report("Chunks", &mut || {
        let chunks = Chunks::open(&path, &Layout::default()).expect("a table");
        black_box(chunks.map(|chunk| chunk.expect("numbers")[(0, 0)]).sum::<f64>());
    });
    println!("largest resident memory: {}", peak());
}

fn write(path: &Path, rows: usize) {
    let mut file = BufWriter::new(File::create(path).expect("a file"));
    writeln!(file, "time_s,voltage_v,theta_rad").expect("room");
    for k in 0..rows {
        let [u, y] = [7.0, 8.0].map(|r| ((k as f64 * r) * 0.618).sin());
        writeln!(file, "{:?},{u:?},{y:?}", k as f64 / 1000.0).expect("room");
    }
}

fn scan(path: &Path, mut count: impl FnMut(&[u8]) -> usize) {
    let mut file = File::open(path).expect("a file");
    let mut block = vec![0; 1 << 20];
    let mut found = 0;
    loop {
        match file.read(&mut block).expect("bytes") {
            0 => break,
            length => found += count(&block[..length]),
        }
    }
    black_box(found);
}

fn seconds(run: &mut dyn FnMut()) -> f64 {
    let start = Instant::now();
    run();
    start.elapsed().as_secs_f64()
}

fn peak() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or("not told by this system").trim().into()
}
