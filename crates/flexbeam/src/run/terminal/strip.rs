//! The last seconds of the motion, for a strip of it.

use std::collections::VecDeque;

/// How far back the strip goes [s].
pub const LENGTH_S: f64 = 10.0;

/// Reference and tip at some instants.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strip {
    points: VecDeque<Point>,
}

/// One instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// Since the run was armed [s].
    pub time_s: f64,
    /// Reference [rad].
    pub reference_rad: f64,
    /// Tip angle [rad].
    pub psi_rad: f64,
}

impl Strip {
    /// Adds a point that is newer than the newest, and lets go of what is too old.
    pub fn push(&mut self, point: Point) {
        if self.points.back().is_some_and(|last| last.time_s >= point.time_s) {
            return;
        }
        self.points.push_back(point);
        while self.points.front().is_some_and(|first| first.time_s < point.time_s - LENGTH_S) {
            self.points.pop_front();
        }
    }

    /// A curve: seconds before the newest point, degrees.
    pub fn curve(&self, angle_rad: impl Fn(&Point) -> f64) -> Vec<(f64, f64)> {
        let now_s = self.points.back().map_or(0.0, |last| last.time_s);
        self.points.iter().map(|point| (point.time_s - now_s, angle_rad(point).to_degrees())).collect()
    }
}

/// Round numbers around all of the curves [degree], so that the scale moves seldom.
pub fn bounds(curves: &[&[(f64, f64)]]) -> [f64; 2] {
    const ROUND: [f64; 6] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0];
    /// Round numbers between the bounds, at most.
    const MOST: f64 = 14.0;
    let angles = curves.iter().flat_map(|curve| curve.iter().map(|point| point.1)).filter(|angle| angle.is_finite());
    let (low, high) = angles.fold((0f64, 0f64), |(low, high), angle| (low.min(angle), high.max(angle)));
    let round = ROUND.into_iter().find(|round| (high - low) / round <= MOST).unwrap_or(100.0);
    let (low, high) = ((low / round).floor() * round, (high / round).ceil() * round);
    if low < high { [low, high] } else { [-1.0, 1.0] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(time_s: f64) -> Point {
        Point { time_s, reference_rad: time_s.to_radians(), psi_rad: 0.0 }
    }

    #[test]
    fn a_strip_keeps_ten_seconds_and_no_instant_twice() {
        let mut strip = Strip::default();
        (0..=120).flat_map(|k| [k, k]).for_each(|k| strip.push(at(f64::from(k) * 0.25)));
        let curve = strip.curve(|point| point.reference_rad);
        assert_eq!((curve.len(), curve[0].0, curve[40].0), (41, -10.0, 0.0));
        assert!((curve[40].1 - 30.0).abs() < 1e-12);
    }

    #[test]
    fn bounds_are_round_and_hold_everything() {
        assert_eq!(bounds(&[&[(0.0, 30.0), (1.0, -0.4)], &[(0.0, 31.2)]]), [-5.0, 35.0]);
        assert_eq!(bounds(&[&[(0.0, 0.3)]]), [0.0, 1.0]);
        assert_eq!(bounds(&[&[(0.0, 690.0)]]), [0.0, 700.0]);
        assert_eq!(bounds(&[&[], &[(0.0, f64::NAN)]]), [-1.0, 1.0]);
    }
}
