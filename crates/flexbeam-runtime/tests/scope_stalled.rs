//! Ten viewers, one of which never reads: no growth, nothing lost for the others. In a process of its own, whose memory is counted.

mod scripted;
#[path = "support/scope.rs"]
#[allow(dead_code, reason = "each test uses a part")]
mod support;

use flexbeam_runtime::{Sample, Sink};
use serde_json::json;
use std::time::{Duration, Instant};
use support::{Said, Viewer, about, header, server};

/// Memory of this process [bytes].
fn resident() -> usize {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap();
    pages.split(' ').nth(1).unwrap().parse::<usize>().unwrap() * 4096
}

/// At 25 kHz, four times what the ring holds: 18 MB of frames, which is more than ring and sockets hold together.
const SAMPLES: u64 = 4 << 16;

#[test]
fn ten_viewers_and_one_of_them_stalled() {
    let server = server(about(None));
    let mut sink = server.sink(&header(1e-3));
    let mut stalled = Viewer::enter(&server, json!({}));
    let readers: Vec<_> = (0..9)
        .map(|_| {
            let mut viewer = Viewer::enter(&server, json!({}));
            std::thread::spawn(move || {
                let (mut next, mut lost) = (0, 0);
                while next < SAMPLES {
                    let frame = viewer.frame();
                    assert_eq!(frame.ticks[0], next + u64::from(frame.lost));
                    lost += u64::from(frame.lost);
                    next = frame.ticks.last().unwrap() + 1;
                }
                lost
            })
        })
        .collect();

    let began = Instant::now();
    let mut at_first = 0;
    for instant in 0..SAMPLES {
        sink.sample(&Sample { instant, voltage_v: instant as f64, ..Sample::default() }).unwrap();
        if instant % 500 == 499 {
            let due = Duration::from_millis(20 * (instant / 500 + 1));
            std::thread::sleep(due.saturating_sub(began.elapsed()));
        }
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
