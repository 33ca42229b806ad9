//! Poles as a person reads them: frequency, damping, what kind.

use flexbeam_lti::{C64, StateSpace, Time};
use flexbeam_report::{Cell, Table};

/// A pole this far below the fastest one in magnitude is an integrator for the reader.
const INTEGRATOR: f64 = 1e-9;

/// A row for each real pole and each conjugate pair, slowest first; a sampled model's poles as the s-plane points
/// ln(z)/Ts that they sample.
pub(crate) fn table(model: &StateSpace) -> Table {
    let mut poles: Vec<C64> = model.poles().into_iter().map(|pole| in_s_plane(pole, model.time)).collect();
    poles.retain(|s| s.im >= 0.0);
    poles.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
    let fastest = poles.last().map_or(0.0, |s| s.norm());
    let columns = [("pole", "1/s"), ("frequency", "Hz"), ("damping", ""), ("", "")];
    poles.into_iter().fold(Table::new(&columns), |table, s| table.row(row(s, fastest)))
}

fn in_s_plane(pole: C64, time: Time) -> C64 {
    match time {
        Time::Continuous => pole,
        Time::Sampled { period_s } => pole.ln() / period_s,
    }
}

fn row(s: C64, fastest: f64) -> [Cell; 4] {
    let number = |x: f64| flexbeam_report::significant(x, 5);
    if s.norm() <= INTEGRATOR * fastest {
        return ["0".into(), "".into(), "".into(), "integrator".into()];
    }
    let text = if s.im == 0.0 { number(s.re) } else { format!("{} ± {}j", number(s.re), number(s.im)) };
    let (hertz, damping) = (s.norm() / std::f64::consts::TAU, -s.re / s.norm());
    let kind = if s.re > 0.0 { "unstable" } else { "" };
    [text.into(), Cell::number(hertz, 4), Cell::number(damping, 4), kind.into()]
}
