//! The steady voltage against the speed: V = sgn(w) (dry + extra exp(-(w/w_s)^2)) + s w.

use super::Run;
use crate::Error;
use flexbeam_lti::Mat;

/// Chance of taking scatter for a Stribeck effect at one speed; many are tried, and a converter's steps are no Gaussian scatter.
const CHANCE: f64 = 1e-4;
/// The fastest run is at least so many times as fast as w_s: a rise over half of the runs is not told from a slope.
const APART: f64 = 5.0;
/// Speeds w_s that are tried.
const TRIED: usize = 40;
/// Runs that the curve with a Stribeck effect needs at least: its five numbers and three to spare.
const FEWEST_WITH_STRIBECK: usize = 8;

/// The fitted curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    /// Dead zone and Coulomb friction forward [V].
    pub plus_v: f64,
    /// The same backward [V], a magnitude.
    pub minus_v: f64,
    /// s [V s/rad].
    pub slope_v_s: f64,
    /// Stribeck's rise [V]; 0 without one.
    pub extra_v: f64,
    stribeck_speed_rad_s: Option<f64>,
    /// Sum of squares of what is left [V^2].
    left: f64,
}

impl Line {
    /// By least squares; with a Stribeck effect where that lessens the sum of squares by more than chance would.
    ///
    /// Two more numbers lessen it by a factor of P^(-2/nu) with a chance of P, nu what is left of the freedom: the F test with two
    /// degrees of freedom in closed form.
    pub fn through(runs: &[&Run]) -> Result<Line, Error> {
        let plain = Line::with(runs, None)?;
        if runs.len() < FEWEST_WITH_STRIBECK {
            return Ok(plain);
        }
        let curved = Line::best_curve(runs)?;
        let by_chance = CHANCE.powf(-2.0 / (runs.len() - curved.unknowns()) as f64);
        let rises = curved.extra_v > 0.0 && plain.left > by_chance * curved.left;
        Ok(if rises { curved } else { plain })
    }

    /// The same kind of curve through other runs.
    pub fn again(&self, runs: &[&Run]) -> Result<Line, Error> {
        if self.stribeck_speed_rad_s.is_some() { Line::best_curve(runs) } else { Line::with(runs, None) }
    }

    /// Numbers that were fitted.
    pub fn unknowns(&self) -> usize {
        if self.stribeck_speed_rad_s.is_some() { 5 } else { 3 }
    }

    pub fn stribeck_speed_rad_s(&self) -> Option<f64> {
        self.stribeck_speed_rad_s
    }

    pub fn voltage_v(&self, speed_rad_s: f64) -> f64 {
        let dry_v = if speed_rad_s > 0.0 { self.plus_v } else { -self.minus_v };
        let rise = self.stribeck_speed_rad_s.map_or(0.0, |w_s| self.extra_v * rise(speed_rad_s, w_s));
        dry_v + speed_rad_s.signum() * rise + self.slope_v_s * speed_rad_s
    }

    fn best_curve(runs: &[&Run]) -> Result<Line, Error> {
        let speeds = || runs.iter().map(|run| run.speed_rad_s.abs());
        let (slowest, fastest) = (speeds().fold(f64::MAX, f64::min), speeds().fold(0.0, f64::max));
        let tried = (0..TRIED).map(|k| slowest * (fastest / (APART * slowest)).powf(k as f64 / (TRIED - 1) as f64));
        let mut best = Line::with(runs, Some(slowest))?;
        for w_s in tried {
            // A speed at which no run shows the rise apart from the dry friction has no curve.
            if let Ok(line) = Line::with(runs, Some(w_s))
                && line.left < best.left
            {
                best = line;
            }
        }
        Ok(best)
    }

    fn with(runs: &[&Run], stribeck_speed_rad_s: Option<f64>) -> Result<Line, Error> {
        let row = |run: &Run| {
            let w = run.speed_rad_s;
            let forward = f64::from(u8::from(w > 0.0));
            [forward, forward - 1.0, w, stribeck_speed_rad_s.map_or(0.0, |w_s| w.signum() * rise(w, w_s))]
        };
        let columns = if stribeck_speed_rad_s.is_some() { 4 } else { 3 };
        let A = Mat::from_fn(runs.len(), columns, |k, column| row(runs[k])[column]);
        let V = Mat::from_fn(runs.len(), 1, |k, _| runs[k].voltage_v);
        let x = least_squares(&A, &V)?;
        let left = (&V - &A * &x).norm_squared();
        let extra_v = if columns == 4 { x[3] } else { 0.0 };
        Ok(Line { plus_v: x[0], minus_v: x[1], slope_v_s: x[2], extra_v, stribeck_speed_rad_s, left })
    }
}

/// exp(-(w/w_s)^2)
pub(crate) fn rise(speed_rad_s: f64, stribeck_speed_rad_s: f64) -> f64 {
    (-(speed_rad_s / stribeck_speed_rad_s).powi(2)).exp()
}

/// Errors: columns that do not come apart.
fn least_squares(A: &Mat, b: &Mat) -> Result<Mat, Error> {
    let svd = A.clone().svd(true, true);
    let largest = svd.singular_values.max();
    let fewer = A.nrows() < A.ncols();
    let reciprocal = if fewer { 0.0 } else { svd.singular_values.min() / largest };
    if !(reciprocal > 1e-6) {
        return Err(Error::SpeedsAlike { reciprocal });
    }
    Ok(svd.solve(b, 0.0).expect("both factors were asked for"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn runs(extra_v: f64) -> Vec<Run> {
        let speeds = [0.05, 0.08, 0.13, 0.2, 0.35, 0.6, 1.0, 1.7];
        // Two millivolts up and down, as a converter leaves them.
        let scatter = [1.0, -0.7, 0.3, -1.0, 0.8, 0.1, -0.5, 0.6];
        let run = |sign: f64, k: usize| {
            let (w, dry) = (speeds[k], if sign > 0.0 { 0.28 } else { 0.10 });
            let voltage_v = sign * (dry + extra_v * rise(w, 0.1) + 0.5 * w + 0.002 * scatter[k]);
            Run { voltage_v, speed_rad_s: sign * w, first: 0, end: 0 }
        };
        (0..speeds.len()).flat_map(|k| [run(1.0, k), run(-1.0, k)]).collect()
    }

    #[test]
    fn the_curve_is_found_and_a_stribeck_effect_only_where_there_is_one() {
        for (extra_v, found) in [(0.0, false), (0.03, true)] {
            let all = runs(extra_v);
            let line = Line::through(&all.iter().collect::<Vec<_>>()).unwrap();
            assert_eq!(line.stribeck_speed_rad_s().is_some(), found, "{line:?}");
            assert!((line.plus_v - 0.28).abs() < 0.002 && (line.minus_v - 0.10).abs() < 0.002, "{line:?}");
            assert!((line.slope_v_s - 0.5).abs() < 0.003 && (line.extra_v - extra_v).abs() < 0.004, "{line:?}");
        }
    }

    #[test]
    fn one_speed_has_no_line() {
        let all = runs(0.0);
        let alike: Vec<&Run> = all[..2].iter().collect();
        assert!(matches!(Line::through(&alike), Err(Error::SpeedsAlike { .. })));
    }
}
