//! Poles as a person reads them: frequency, damping, what kind.

use flexbeam_lti::{C64, StateSpace, Time};
use flexbeam_report::{Cell, Table, significant};

/// A pole this far below the fastest one in magnitude is an integrator for the reader.
const INTEGRATOR: f64 = 1e-9;

/// A row for each real pole and each conjugate pair, slowest first; a sampled model's poles as the s-plane points
/// ln(z)/Ts that they sample.
pub(crate) fn table(model: &StateSpace) -> Table {
    let mut poles: Vec<(C64, &str)> = model.poles().into_iter().map(|pole| in_s_plane(pole, model.time)).collect();
    poles.retain(|(s, _)| s.im >= 0.0);
    poles.sort_by(|(a, _), (b, _)| a.norm().total_cmp(&b.norm()));
    let fastest = poles.iter().map(|(s, _)| s.norm()).filter(|x| x.is_finite()).fold(0.0, f64::max);
    let columns = [("pole", "1/s"), ("frequency", "Hz"), ("damping", ""), ("", "")];
    poles.into_iter().fold(Table::new(&columns), |table, (s, kind)| table.row(row(s, kind, fastest)))
}

/// The pole in the s-plane, and what is peculiar about it: no continuous model has a pole z <= 0.
fn in_s_plane(pole: C64, time: Time) -> (C64, &'static str) {
    let Time::Sampled { period_s } = time else { return (pole, "") };
    let kind = match pole {
        _ if pole.im != 0.0 || pole.re > 0.0 => "",
        _ if pole.re == 0.0 => "gone after one sample",
        _ => "alternates from sample to sample",
    };
    (pole.ln() / period_s, kind)
}

fn row(s: C64, kind: &str, fastest: f64) -> [Cell; 4] {
    let number = |x: f64| significant(x, 5);
    if s.norm() <= INTEGRATOR * fastest {
        return ["0".into(), "".into(), "".into(), "integrator".into()];
    }
    if !s.norm().is_finite() {
        return ["-inf".into(), "".into(), "".into(), kind.into()];
    }
    let single = s.im == 0.0 || !kind.is_empty();
    let text = if single { number(s.re) } else { format!("{} ± {}j", number(s.re), number(s.im)) };
    let (hertz, damping) = (s.norm() / std::f64::consts::TAU, -s.re / s.norm());
    let kind = if s.re > 0.0 { format!("{kind} unstable") } else { kind.into() };
    [text.into(), Cell::number(hertz, 4), Cell::number(damping, 4), kind.trim_start().into()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use flexbeam_lti::Mat;

    fn rows(A: Mat, time: Time) -> Vec<Vec<String>> {
        let n = A.nrows();
        let model = StateSpace::new(A, Mat::zeros(n, 1), Mat::zeros(1, n), Mat::zeros(1, 1), time).unwrap();
        table(&model).rows().iter().map(|row| row.iter().map(|cell| cell.text().to_string()).collect()).collect()
    }

    /// s^2 + 2 zeta omega s + omega^2 with omega = 2 pi, zeta = 0.1; an integrator; e^t.
    #[test]
    fn each_pole_has_its_frequency_damping_and_kind() {
        let omega = std::f64::consts::TAU;
        let block = Mat::from_row_slice(2, 2, &[0.0, 1.0, -omega * omega, -0.2 * omega]);
        let mut A = Mat::zeros(4, 4);
        A.view_mut((0, 0), (2, 2)).copy_from(&block);
        A[(3, 3)] = 1.0;
        let found = rows(A, Time::Continuous);
        assert_eq!(found[0], ["0", "", "", "integrator"]);
        assert_eq!(found[1], ["1.0000", "0.1592", "-1.000", "unstable"]);
        assert_eq!(found[2], ["-0.62832 ± 6.2517j", "1.000", "0.1000", ""]);
    }

    /// z = e^(-1), 0 and -e^(-1) at one sample a second.
    #[test]
    fn sampled_poles_are_told_as_what_they_sample() {
        let z = (-1.0_f64).exp();
        let A = Mat::from_diagonal(&flexbeam_lti::Vector::from_column_slice(&[z, 0.0, -z]));
        let found = rows(A, Time::Sampled { period_s: 1.0 });
        assert_eq!(found[0][..3], ["-1.0000", "0.1592", "1.000"]);
        assert_eq!(found[1], ["-1.0000", "0.5247", "0.3033", "alternates from sample to sample"]);
        assert_eq!(found[2], ["-inf", "", "", "gone after one sample"]);
    }
}
