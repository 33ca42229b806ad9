//! How a run went: the answer of `flexbeam run`, and the report at the end of its recording.

use serde::{Deserialize, Serialize};

/// `flexbeam run`, and the topic `/report`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunResult {
    /// `over`, `asked` or `fault`.
    pub cause: String,
    /// The cause in words; of a board, in its own.
    pub text: String,
    /// The rig: `udp:192.168.1.7:4810`.
    pub port: String,
    /// Sample period [s].
    pub period_s: f64,
    /// Ticks.
    pub ticks: u64,
    /// Periods that passed without a tick.
    pub missed: u64,
    /// Ticks without a fresh measurement.
    pub stale: u64,
    /// Samples that are not in the recording.
    pub unrecorded: u64,
    /// What the link lost or threw away.
    pub link: LinkCounts,
    /// From each deadline to the awakening.
    pub lateness: TimeQuantiles,
    /// From the awakening to the end of the tick's work.
    pub execution: TimeQuantiles,
    /// The kernel's tick alone.
    pub tick: TimeQuantiles,
    /// Page faults of the loop's thread between its first tick and its last.
    pub page_faults: u64,
    /// What the system refused to the loop, and whatever else a person should know.
    pub warnings: Vec<String>,
    /// The recording, where there is one.
    pub recording: Option<String>,
}

impl RunResult {
    /// The report of a recording; nothing where another program wrote another one.
    pub fn of_report(report: &serde_json::Value) -> Option<RunResult> {
        RunResult::deserialize(report).ok()
    }
}

/// `flexbeam rig`, at its end.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ServeResult {
    /// Runs that began.
    pub runs: u64,
    /// Commands that were answered with new readings.
    pub answered: u64,
    /// Commands that came twice.
    pub repeated: u64,
    /// Commands older than the newest, or of another run.
    pub ignored: u64,
    /// Frames that could not be read.
    pub malformed: u64,
    /// Times that the rig took itself to 0 V.
    pub timed_out: u64,
    /// Where the hub stands [rad].
    pub theta_rad: f64,
    /// Deflection angle of the tip [rad].
    pub alpha_rad: f64,
}

/// What a link lost or threw away.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LinkCounts {
    /// Exchanges without a valid answer in time.
    pub lost: u64,
    /// Answers for an earlier instant.
    pub late: u64,
    /// Answers that came twice.
    pub duplicate: u64,
    /// Frames with a wrong check sum or length.
    pub corrupt: u64,
    /// Frames of another run or program.
    pub foreign: u64,
}

/// A distribution of times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TimeQuantiles {
    /// Median [s].
    pub median_s: f64,
    /// 99 % are below [s].
    pub p99_s: f64,
    /// 99.9 % are below [s].
    pub p999_s: f64,
    /// The longest [s].
    pub max_s: f64,
}
