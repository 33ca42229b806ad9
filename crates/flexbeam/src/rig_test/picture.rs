//! The picture of `--plots`: voltage against hub speed.

use std::path::Path;

use flexbeam_ident::friction::{Estimate, FrictionTest};
use flexbeam_report::{Colour, Figure, Marker, Panel, Series};

use crate::Failure;
use crate::output::{folder, write_figure};

/// Voltage against speed: runs, curve, 95 % band.
pub(super) fn draw(path: &Path, test: &FrictionTest) -> Result<(), Failure> {
    folder(path)?;
    let written = write_figure(path, "friction", &figure(test))?;
    eprintln!("{}: {}", path.display(), written.join(", "));
    Ok(())
}

/// Points of the curve, each way.
const POINTS: usize = 60;

fn figure(test: &FrictionTest) -> Figure {
    let column = |of: fn(&flexbeam_ident::friction::Run) -> f64| test.runs.iter().map(of).collect::<Vec<f64>>();
    let (speeds, voltages) = (column(|run| run.speed_rad_s), column(|run| run.voltage_v));
    let fitted: Vec<f64> = speeds.iter().map(|&w| test.voltage_at(w).value).collect();
    let left_mv: Vec<f64> = voltages.iter().zip(&fitted).map(|(v, f)| 1e3 * (v - f)).collect();
    let fastest = speeds.iter().fold(0.0, |most: f64, w| most.max(w.abs()));
    let (mut above, mut below) = (Panel::new("Voltage [V]").share(2.0), Panel::new("Run - curve [mV]"));
    for (name, band, sign) in [("fitted", "95 % band", 1.0), ("", "", -1.0)] {
        let w: Vec<f64> = (1..=POINTS).map(|k| sign * fastest * k as f64 / POINTS as f64).collect();
        let at: Vec<Estimate> = w.iter().map(|&w| test.voltage_at(w)).collect();
        let of = |f: &dyn Fn(&Estimate) -> f64| at.iter().map(f).collect::<Vec<f64>>();
        let value = of(&|e| e.value);
        let (low, high) = (of(&|e| e.value - e.half_width_95()), of(&|e| e.value + e.half_width_95()));
        let width_mv = of(&|e| 1e3 * e.half_width_95());
        let under_mv: Vec<f64> = width_mv.iter().map(|x| -x).collect();
        above = above.with(Series::band(band, &w, &low, &high).colour(Colour::Blue));
        above = above.with(Series::line(name, &w, &value).colour(Colour::Blue));
        below = below.with(Series::band("", &w, &under_mv, &width_mv).colour(Colour::Blue));
    }
    let above = above.with(Series::markers("runs", &speeds, &voltages, Marker::Circle).colour(Colour::Grey));
    let below = below.with(Series::markers("", &speeds, &left_mv, Marker::Circle).colour(Colour::Grey));
    Figure::new("Voltage at constant speed", "Hub speed [rad/s]")
        .size(800.0, 560.0)
        .panel(above)
        .panel(below.horizontal(0.0, ""))
}
