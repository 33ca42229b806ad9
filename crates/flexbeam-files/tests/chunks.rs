//! Recordings in chunks: the numbers of the whole reader to the last bit, in memory that does not depend on the length.

use flexbeam_files::{Chunks, Error, Fault, Layout, Recording};
use flexbeam_lti::Mat;
use proptest::prelude::*;
use std::fmt::Write as _;
use std::io::{BufWriter, Write as _};
use std::path::Path;

/// All chunks side by side; each but the last has `width` columns.
fn collected(chunks: &mut Chunks, width: usize) -> Result<Mat, Error> {
    let mut data = Vec::new();
    let mut samples = 0;
    for chunk in chunks.by_ref() {
        let chunk = chunk?;
        assert!(samples % width == 0 && (1..=width).contains(&chunk.ncols()), "{samples} {}", chunk.ncols());
        samples += chunk.ncols();
        data.extend_from_slice(chunk.as_slice());
    }
    Ok(Mat::from_vec(chunks.names().len(), samples, data))
}

fn bits(data: &Mat) -> Vec<u64> {
    data.iter().map(|x| x.to_bits()).collect()
}

fn named(columns: &str, period_s: Option<f64>) -> Layout {
    Layout { columns: Some(columns.split(',').map(String::from).collect()), period_s, ..Layout::default() }
}

#[test]
fn channels_are_chosen_and_made_si() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.csv");
    let rows: String =
        (0..1000).map(|k| format!("{k},{},{},7\n", 0.37 * f64::from(k), 1.0 / (1.0 + f64::from(k)))).collect();
    std::fs::write(&path, format!("t_ms,theta_deg,voltage_mv,rest\n{rows}")).unwrap();
    let whole = Recording::read(&path, &Layout::default()).unwrap().into_si();
    let names = ["voltage_v", "theta_rad"];
    let wanted = whole.select(&names).unwrap();
    let mut chunks = Chunks::open(&path, &Layout::default()).unwrap().in_si().select(&names).unwrap().of_width(64);
    assert_eq!((chunks.names(), chunks.units()), (&wanted.names[..], &wanted.units[..]));
    assert_eq!(chunks.period_s(), None, "not before the end");
    assert_eq!(bits(&collected(&mut chunks, 64).unwrap()), bits(&wanted.data));
    assert_eq!((chunks.period_s(), chunks.samples()), (Some(whole.signals.period_s), 1000));
    let size = std::fs::metadata(&path).unwrap().len();
    assert_eq!(chunks.progress(), (size, size));
    assert!(chunks.next().is_none());
    let unknown = Chunks::open(&path, &Layout::default()).unwrap().select(&["psi"]).err().unwrap();
    assert!(matches!(*unknown.fault, Fault::UnknownColumn { .. }));
}

#[test]
fn faults_are_those_of_the_whole_reader() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.csv");
    let table = |edit: &dyn Fn(usize) -> Option<String>| {
        let row = |k: usize| edit(k).unwrap_or_else(|| format!("{},1.5", k as f64 / 100.0));
        (0..3000).map(row).fold("time_s,u".to_string(), |text, row| text + "\n" + &row)
    };
    for (text, layout) in [
        (table(&|k| (k == 2500).then(|| "25,NaN".into())), Layout::default()),
        (table(&|k| (k == 2500).then(|| "25.005,1".into())), Layout::default()),
        (table(&|k| (k == 2500).then(|| "25.002,1".into())), Layout::default()),
        (table(&|k| (k == 2500).then(String::new)), Layout::default()),
        (table(&|_| None), named("t,u,y", None)),
        (table(&|_| None), named("_,u", None)),
        ("time_s,u\n0,1\n".into(), Layout::default()),
        (String::new(), Layout::default()),
    ] {
        std::fs::write(&path, &text).unwrap();
        let whole = Recording::read(&path, &layout).unwrap_err();
        let chunked = Chunks::open(&path, &layout).and_then(|chunks| {
            let mut chunks = chunks.of_width(5000);
            let end = collected(&mut chunks, 5000).map(|_| ());
            assert!(chunks.next().is_none(), "after an error there is nothing");
            end
        });
        assert_eq!(chunked.unwrap_err(), whole);
        // Narrow chunks find the same, with fewer steps in the statistics of a jitter.
        let narrow =
            Chunks::open(&path, &layout).and_then(|c| collected(&mut c.of_width(7), 7).map(|_| ())).unwrap_err();
        assert_eq!(narrow.place, whole.place);
    }
    let none = Chunks::open(Path::new("no/such.csv"), &Layout::default()).err().unwrap();
    assert_eq!(*none.fault, Fault::NoFile);
}

/// Peak of the resident memory [bytes].
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux tells");
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).expect("a peak");
    1024 * line.trim().trim_end_matches(" kB").parse::<u64>().expect("kilobytes")
}

/// Not beside the others, which would share its peak: `cargo test` gives each its thread, so only this file's own are small.
#[cfg(target_os = "linux")]
#[test]
fn memory_does_not_depend_on_the_length() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.csv");
    const ROWS: usize = 3_000_000;
    let mut file = BufWriter::new(std::fs::File::create(&path).unwrap());
    file.write_all(b"time_s,u,y\n").unwrap();
    let mut sum = 0.0;
    let mut line = String::new();
    for k in 0..ROWS {
        let (u, y) = ((k as f64 * 0.618).sin(), (k as f64 * 0.0317).cos());
        sum += u + y;
        line.clear();
        writeln!(line, "{},{u:?},{y:?}", k as f64 / 1000.0).unwrap();
        file.write_all(line.as_bytes()).unwrap();
    }
    file.into_inner().unwrap();
    let before = peak();
    let mut chunks = Chunks::open(&path, &Layout::default()).unwrap();
    let mut found = 0.0;
    for chunk in chunks.by_ref() {
        found += chunk.unwrap().iter().fold(0.0, |sum, x| sum + x);
    }
    let grown = peak().saturating_sub(before);
    assert_eq!((chunks.samples(), chunks.period_s()), (ROWS, Some(0.001)));
    assert!((found - sum).abs() < 1e-6, "{found} {sum}");
    let held = (ROWS * 3 * size_of::<f64>()) as u64;
    assert!(grown < 20 << 20 && held > 60 << 20, "{grown} bytes more, where the numbers are {held}");
}

/// A number as programs write it.
fn cell() -> impl Strategy<Value = String> {
    prop_oneof![
        prop::num::f64::NORMAL.prop_map(|x| format!("{x:?}")),
        (-1e6..1e6f64).prop_map(|x| format!("{x:.3}")),
        (-1.0..1.0f64).prop_map(|x| format!("{x:+.7e}")),
        (-1000i32..1000).prop_map(|k| k.to_string()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, rng_seed: prop::test_runner::RngSeed::Fixed(2), ..Default::default() })]

    #[test]
    fn chunks_are_the_whole_to_the_last_bit(
        cells in prop::collection::vec(cell(), 9..200),
        width in 1usize..40,
        spelling in 0usize..4,
    ) {
        let separator = [",", ";", "\t", "  "][spelling];
        let text: String = cells.chunks_exact(3).map(|row| row.join(separator) + "\n").collect();
        // Blanks and decimal commas where they can be told.
        let text = if spelling == 1 { text.replace('.', ",") } else { text };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.txt");
        std::fs::write(&path, &text).unwrap();
        let layout = named("u,_,y", Some(0.01));
        let whole = Recording::read(&path, &layout).unwrap();
        // What the standard library reads in the same cells.
        let wanted: Vec<u64> = cells.chunks_exact(3).flat_map(|row| [&row[0], &row[2]]).map(|cell| cell.parse::<f64>().unwrap().to_bits()).collect();
        prop_assert_eq!(&bits(&whole.signals.data), &wanted);
        let mut chunks = Chunks::open(&path, &layout).unwrap().of_width(width);
        prop_assert_eq!(&bits(&collected(&mut chunks, width).unwrap()), &wanted);
        prop_assert_eq!(chunks.period_s(), Some(0.01));
    }

    #[test]
    fn whatever_the_bytes_there_is_an_answer(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        answered(&bytes);
    }

    #[test]
    fn a_good_file_with_a_few_bytes_changed_is_read_or_refused(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        spelling in 0usize..3,
    ) {
        let good = ["time_s;u [V];y\ns;V;rad\n0;0,5;1\n0,5;1,5;2\n1;2,5;3\n", "# t u y\n0 1 2\n1 2 3\n2 3 4\n\n\n",
            "timestamp,u\n10:00:00,1\n10:00:01,\"2\"\n10:00:02,3\n"][spelling];
        let mut bytes = good.as_bytes().to_vec();
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        answered(&bytes);
    }
}

/// No panic; a fault names the file, and what is read is finite and of one length.
fn answered(bytes: &[u8]) {
    for layout in [Layout::default(), named("t,u,y", None), named("u", Some(1.0))] {
        match Recording::parse(bytes, Path::new("x.csv"), &layout) {
            Ok(recording) => {
                assert!(recording.signals.data.iter().all(|x| x.is_finite()) && recording.signals.period_s > 0.0)
            }
            Err(error) => assert!(error.to_string().starts_with("cannot read x.csv"), "{error}"),
        }
    }
}
