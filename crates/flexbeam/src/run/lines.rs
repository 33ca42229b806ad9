//! A run told in lines on standard error: its events as they happen.

use std::io::{self, Write};
use std::time::Duration;

use flexbeam_runtime::{Session, Steering};

/// How often it looks.
const PAUSE: Duration = Duration::from_millis(50);

/// Tells the events until the run is over.
pub fn watch(session: &Session, steering: &Steering) {
    let mut told = 0;
    loop {
        let over = session.is_over();
        for event in steering.latest.events_after(told) {
            told += 1;
            let time_s = event.instant as f64 * steering.period_s;
            // A terminal that hung up must not keep the run from its end: the recording has the events, too.
            let _ = writeln!(io::stderr(), "{time_s:9.3} s  {}: {}", event.kind.name(), event.text);
        }
        if over {
            return;
        }
        std::thread::sleep(PAUSE);
    }
}
