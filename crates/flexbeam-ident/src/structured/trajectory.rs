//! The linear link, sampled, with the derivatives of its state by everything that may be unknown.
//!
//! Enters: parameters, period, voltages. Leaves: theta and alpha and their derivatives, sample after sample.
//! Deliberately absent: what is measured of them.

use flexbeam_lti::Mat;
use flexbeam_lti::exponential::exponential_minus_identity;

/// k1, k2, c, b, and the beam's damping time eta.
pub(super) const PARAMETERS: usize = 5;
/// theta, alpha, theta', alpha'.
pub(super) const STATES: usize = 4;

/// Sampled link with its derivatives by the parameters.
///
/// The matrices act on differences: x(k+1) - x(k) = E [x(k); u(k)], so that positions do not lose the digits of a small step.
pub(super) struct Sensitive {
    E: Step,
    by_parameter: [Step; PARAMETERS],
}

/// One row of [Phi - I, Gamma] for each state.
type Step = [[f64; STATES + 1]; STATES];

impl Sensitive {
    pub fn new(point: &[f64; PARAMETERS], period_s: f64) -> Sensitive {
        let M = held(point) * period_s;
        let E = rows_of(&exponential_minus_identity(&M));
        let by_parameter = std::array::from_fn(|p| {
            let dM = derivative(point, p) * period_s;
            let mut block = Mat::zeros(2 * (STATES + 1), 2 * (STATES + 1));
            block.view_mut((0, 0), M.shape()).copy_from(&M);
            block.view_mut((STATES + 1, STATES + 1), M.shape()).copy_from(&M);
            block.view_mut((0, STATES + 1), M.shape()).copy_from(&dM);
            rows_of(&exponential_minus_identity(&block).columns(STATES + 1, STATES + 1).into_owned())
        });
        Sensitive { E, by_parameter }
    }
}

/// [A B; 0 0] of (18), the beam's stiffness torque K_stiff (alpha + eta alpha').
pub(super) fn held(&[k1, k2, c, b, eta]: &[f64; PARAMETERS]) -> Mat {
    #[rustfmt::skip]
    let rows = [
        0.0, 0.0, 1.0,       0.0, 0.0,
        0.0, 0.0, 0.0,       1.0, 0.0,
        0.0,  k1,  -c,  k1 * eta,   b,
        0.0, -k2,   c, -k2 * eta,  -b,
        0.0, 0.0, 0.0,       0.0, 0.0,
    ];
    Mat::from_row_slice(STATES + 1, STATES + 1, &rows)
}

/// Of [`held`] by one parameter.
fn derivative(&[k1, k2, .., eta]: &[f64; PARAMETERS], p: usize) -> Mat {
    let mut direction = [0.0; PARAMETERS];
    if p < PARAMETERS - 1 {
        direction[p] = 1.0;
        direction[PARAMETERS - 1] = eta;
        // Linear but for the two fixed ones.
        return held(&direction) - held(&[0.0; PARAMETERS]);
    }
    [direction[0], direction[1], direction[4]] = [k1, k2, 1.0];
    let mut by_eta = held(&direction) - held(&[0.0; PARAMETERS]);
    by_eta.column_mut(1).fill(0.0);
    by_eta
}

fn rows_of(M: &Mat) -> Step {
    std::array::from_fn(|r| std::array::from_fn(|c| M[(r, c)]))
}

/// State and its derivatives by every unknown.
pub(super) struct Trajectory {
    pub x: [f64; STATES],
    pub by_parameter: [[f64; STATES]; PARAMETERS],
    pub by_initial: [[f64; STATES]; STATES],
    pub by_voltage: [f64; STATES],
}

impl Trajectory {
    pub fn new(initial: &[f64]) -> Trajectory {
        let mut by_initial = [[0.0; STATES]; STATES];
        (0..STATES).for_each(|q| by_initial[q][q] = 1.0);
        Trajectory {
            x: std::array::from_fn(|k| initial[k]),
            by_parameter: [[0.0; STATES]; PARAMETERS],
            by_initial,
            by_voltage: [0.0; STATES],
        }
    }

    /// A sample on.
    pub fn advance(&mut self, sampled: &Sensitive, u: f64) {
        for (p, by) in self.by_parameter.iter_mut().enumerate() {
            let through = increment(&sampled.E, by, 0.0);
            let direct = increment(&sampled.by_parameter[p], &self.x, u);
            (0..STATES).for_each(|k| by[k] += through[k] + direct[k]);
        }
        for by in &mut self.by_initial {
            let through = increment(&sampled.E, by, 0.0);
            (0..STATES).for_each(|k| by[k] += through[k]);
        }
        let through = increment(&sampled.E, &self.by_voltage, 1.0);
        (0..STATES).for_each(|k| self.by_voltage[k] += through[k]);
        let step = increment(&sampled.E, &self.x, u);
        (0..STATES).for_each(|k| self.x[k] += step[k]);
    }
}

fn increment(step: &Step, x: &[f64; STATES], u: f64) -> [f64; STATES] {
    std::array::from_fn(|r| (0..STATES).map(|c| step[r][c] * x[c]).sum::<f64>() + step[r][STATES] * u)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every derivative beside central differences, after 50 samples.
    #[test]
    fn derivatives_are_exact() {
        let point = [1060.8, 1465.2, 57.7, 107.39, 0.002];
        let voltage = |k: usize| ((k * k) as f64).sin();
        let run = |point: &[f64; PARAMETERS], initial: &[f64], offset: f64| {
            let sampled = Sensitive::new(point, 0.005);
            let mut at = Trajectory::new(initial);
            (0..50).for_each(|k| at.advance(&sampled, voltage(k) + offset));
            at
        };
        let initial = [0.1, -0.02, 0.3, 0.5];
        let at = run(&point, &initial, 0.2);
        let check = |high: [f64; STATES], low: [f64; STATES], h: f64, exact: [f64; STATES], what: &str| {
            for k in 0..STATES {
                let numeric = (high[k] - low[k]) / (2.0 * h);
                let size = exact.iter().fold(1e-9, |most: f64, x| most.max(x.abs()));
                assert!((numeric - exact[k]).abs() < 1e-6 * size, "{what} {k}: {numeric} {}", exact[k]);
            }
        };
        for p in 0..PARAMETERS {
            let h = 1e-5 * point[p];
            let [high, low] = [h, -h].map(|h| {
                let mut moved = point;
                moved[p] += h;
                run(&moved, &initial, 0.2).x
            });
            check(high, low, h, at.by_parameter[p], "parameter");
        }
        for q in 0..STATES {
            let [high, low] = [1e-3, -1e-3].map(|h| {
                let mut moved = initial;
                moved[q] += h;
                run(&point, &moved, 0.2).x
            });
            check(high, low, 1e-3, at.by_initial[q], "initial");
        }
        check(run(&point, &initial, 0.3).x, run(&point, &initial, 0.1).x, 0.1, at.by_voltage, "voltage");
    }
}
