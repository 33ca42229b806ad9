//! A run as a picture: what the tip was to do and did, what it took, and how the clock was kept.

use std::path::Path;

use flexbeam_files::{RunColumns, RunRecording};
use flexbeam_report::{Figure, Panel, Series};

use crate::Failure;
use crate::output::{folder, write_figure};
use crate::response::degrees;

/// Draws the run into a folder; the names of the files.
pub fn run(recording: &RunRecording, into: &Path) -> Result<[String; 2], Failure> {
    folder(into)?;
    let title = format!("Run on {}", recording.header.port);
    write_figure(into, "run", &figure(&title, &recording.samples, &recording.time_s(0..recording.samples.samples())))
}

fn figure(title: &str, samples: &RunColumns, t: &[f64]) -> Figure {
    let microseconds = |ns: &[u32]| ns.iter().map(|ns| f64::from(*ns) * 1e-3).collect::<Vec<_>>();
    Figure::new(title, "Time [s]")
        .size(800.0, 760.0)
        .panel(
            Panel::new("Angle [deg]")
                .share(1.6)
                .line("reference", t, &degrees(&samples.smoothed_rad))
                .line("tip ψ", t, &degrees(&samples.psi_rad))
                .line("hub θ", t, &degrees(&samples.theta_rad)),
        )
        .panel(Panel::new("Deflection α [deg]").with(Series::line("deflection α", t, &degrees(&samples.alpha_rad))))
        .panel(
            Panel::new("Voltage [V]")
                .with(Series::step("controller u", t, &samples.u_v))
                .with(Series::step("motor V", t, &samples.voltage_v).width(0.8)),
        )
        .panel(
            Panel::new("Late by [µs]").with(Series::line("late by", t, &microseconds(&samples.lateness_ns)).width(0.6)),
        )
}
