//! What counts as little left over, when there are several outputs.
//!
//! Enters: second moments of the residuals. Leaves: a cost, and weights with which least squares goes down in it.

use flexbeam_lti::Mat;

/// How the residuals of several outputs become one cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Criterion {
    /// Mean over the outputs of |y - yhat| / |y - mean y|: what the fit in percent counts. With one output all criteria agree.
    #[default]
    Fit,
    /// Determinant of the residuals' covariance: maximum likelihood for Gaussian noise that is white in time, whatever its
    /// covariance between the outputs.
    Likelihood,
}

/// Residuals below this part of an output are rounding of the simulation; weights do not rise above it.
const RESIDUAL_FLOOR: f64 = 1e-14;

/// The criterion with the outputs' own movement.
pub(crate) struct Measure {
    criterion: Criterion,
    /// Standard deviation of each output.
    moved: Vec<f64>,
}

/// Residuals judged.
#[derive(Clone)]
pub(crate) struct Judged {
    /// To be lowered.
    pub cost: f64,
    /// Part of the outputs that is missed: 0 nothing, 1 as much as by their means.
    pub missed: f64,
    /// M with cost(S) <= cost(S0) + trace M (S - S0) M', equal at S0: lowering the squares of M e lowers the cost.
    pub weight: Mat,
}

impl Measure {
    pub fn new(criterion: Criterion, Y: &Mat) -> Measure {
        let moved = Y.row_iter().map(|y| y.variance().sqrt()).map(|x| if x > 0.0 { x } else { 1.0 }).collect();
        Measure { criterion, moved }
    }

    /// Assumes: S symmetric and finite.
    pub fn judge(&self, S: &Mat) -> Judged {
        let l = S.nrows();
        let floor = |p: usize| (RESIDUAL_FLOOR * self.moved[p]).powi(2);
        match self.criterion {
            Criterion::Fit => {
                let rms: Vec<f64> = (0..l).map(|p| (S[(p, p)] + floor(p)).sqrt()).collect();
                let cost: f64 = (0..l).map(|p| rms[p] / self.moved[p]).sum();
                // The square root lies below its tangent.
                let weight =
                    Mat::from_fn(l, l, |r, c| if r == c { (2.0 * rms[r] * self.moved[r]).sqrt().recip() } else { 0.0 });
                Judged { cost, missed: cost / l as f64, weight }
            }
            Criterion::Likelihood => {
                let relative = Mat::from_fn(l, l, |r, c| S[(r, c)] / (self.moved[r] * self.moved[c]))
                    + Mat::identity(l, l) * RESIDUAL_FLOOR.powi(2);
                // The logarithm of the determinant is concave: it lies below its tangent trace S0^-1 S.
                let Some(factor) = relative.cholesky() else {
                    return Judged { cost: f64::INFINITY, missed: f64::INFINITY, weight: Mat::identity(l, l) };
                };
                let cost: f64 = factor.l_dirty().diagonal().iter().map(|d| 2.0 * d.ln()).sum();
                let scale = Mat::from_fn(l, l, |r, c| if r == c { self.moved[r].recip() } else { 0.0 });
                let weight = factor.l().solve_lower_triangular(&scale).expect("a Cholesky factor is regular");
                Judged { cost, missed: (cost / (2 * l) as f64).exp(), weight }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bound on which every step rests, for random covariances, and equality at S0.
    #[test]
    fn cost_lies_below_its_weighted_squares() {
        let Y = Mat::from_fn(3, 50, |r, k| ((r + 2) as f64) * (((k * (r + 3)) as f64) * 0.7).sin());
        let factor = |seed: f64| {
            let F = Mat::from_fn(3, 3, |r, c| (seed * ((1 + r + 3 * c) as f64)).sin());
            &F * F.transpose() + Mat::identity(3, 3) * 0.1
        };
        for criterion in [Criterion::Fit, Criterion::Likelihood] {
            let measure = Measure::new(criterion, &Y);
            for (a, b) in [(1.0, 2.0), (0.3, 5.1), (4.0, 0.2)] {
                let (S0, S) = (factor(a), factor(b));
                let at = measure.judge(&S0);
                let squares = (&at.weight * (&S - &S0) * at.weight.transpose()).trace();
                assert!(measure.judge(&S).cost <= at.cost + squares + 1e-12, "{criterion:?}");
                let near = &S0 + (&S - &S0) * 1e-6;
                let slope = (measure.judge(&near).cost - at.cost) / 1e-6;
                assert!((slope / squares - 1.0).abs() < 1e-4, "{criterion:?}: {slope} {squares}");
            }
        }
    }

    #[test]
    fn missed_is_one_minus_the_fit() {
        let Y = Mat::from_row_slice(1, 4, &[1.0, 2.0, 4.0, 5.0]);
        // All residuals as large as those about the mean: S is the variance about it (over s).
        let S = Mat::from_element(1, 1, 10.0 / 4.0);
        for criterion in [Criterion::Fit, Criterion::Likelihood] {
            let missed = Measure::new(criterion, &Y).judge(&S).missed;
            assert!((missed - 1.0).abs() < 1e-12, "{criterion:?}: {missed}");
        }
    }
}
