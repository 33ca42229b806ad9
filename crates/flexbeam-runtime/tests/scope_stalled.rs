//! Ten viewers, one of which never reads: no growth, nothing lost for the others. In a process of its own, whose memory is counted.

mod scripted;
#[path = "support/scope.rs"]
#[allow(dead_code, reason = "each test uses a part")]
mod support;

use flexbeam_runtime::{Sample, Sink};
use serde_json::json;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use support::{Said, about, enter, header, server};

/// Memory of this process [bytes].
fn resident() -> usize {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap();
    pages.split(' ').nth(1).unwrap().parse::<usize>().unwrap() * 4096
}

/// Four times what the ring holds: 18 MB of frames, which is more than ring and sockets hold together.
const SAMPLES: u64 = 4 << 16;
/// The feed runs no further ahead of the slowest reader, so that this machine may be as slow as it likes: half of the ring.
const AHEAD: u64 = 30_000;

#[test]
fn ten_viewers_and_one_of_them_stalled() {
    let server = server(about(None));
    let mut sink = server.sink(&header(1e-3));
    let mut stalled = enter(&server, json!({}));
    let places: Arc<Vec<AtomicU64>> = Arc::new((0..9).map(|_| AtomicU64::new(0)).collect());
    let readers: Vec<_> = (0..places.len())
        .map(|k| {
            let (mut viewer, places) = (enter(&server, json!({})), places.clone());
            std::thread::spawn(move || {
                let (mut next, mut lost) = (0, 0);
                while next < SAMPLES {
                    let frame = viewer.frame();
                    assert_eq!(frame.ticks[0], next + u64::from(frame.lost));
                    lost += u64::from(frame.lost);
                    next = frame.ticks.last().unwrap() + 1;
                    places[k].store(next, Ordering::Relaxed);
                }
                lost
            })
        })
        .collect();

    let end = Instant::now() + Duration::from_secs(120);
    let slowest = || places.iter().map(|place| place.load(Ordering::Relaxed)).min().unwrap();
    let mut at_first = 0;
    for instant in 0..SAMPLES {
        while instant > slowest() + AHEAD && Instant::now() < end {
            std::thread::sleep(Duration::from_millis(5));
        }
        sink.sample(&Sample { instant, voltage_v: instant as f64, ..Sample::default() }).unwrap();
        if instant == SAMPLES / 8 {
            at_first = resident();
        }
    }
    let grown = resident().saturating_sub(at_first);
    let lost: Vec<u64> = readers.into_iter().map(|reader| reader.join().unwrap()).collect();
    assert_eq!(lost, [0; 9], "who reads has every sample");
    assert!(grown < 8 << 20, "{grown} bytes more for a viewer that does not read");

    // It reads again: first what the system kept, then a gap that it is told of, then the newest; or it was let go after ten
    // seconds.
    let (mut seen, mut lost, mut last) = (0, 0, None);
    let told = stalled.wait_for("the newest or the end", |said| match said {
        Said::Frame(frame) => {
            assert_eq!(frame.ticks[0], last.map_or(0, |last| last + 1) + u64::from(frame.lost));
            (seen, lost) = (seen + frame.ticks.len() as u64, lost + u64::from(frame.lost));
            last = frame.ticks.last().copied();
            (last == Some(SAMPLES - 1)).then_some(true)
        }
        Said::Closed(_) => Some(false),
        Said::Text(_) => None,
    });
    assert!(!told || (seen + lost == SAMPLES && lost > 0), "{seen} seen, {lost} lost");
}
