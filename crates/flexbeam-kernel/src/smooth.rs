//! The smooth step: a stepping reference becomes one with bounded velocity, acceleration and jerk (DESIGN section 7).
//!
//! Each change of the reference starts a minimum-jerk polynomial that leaves with the present position, velocity and
//! acceleration and arrives at rest after a given number of ticks. Written about its end,
//!
//!   p(t) = target + (1 - t)^3 (c0 + c1 t + c2 t^2),   t = ticks gone / ticks in all,
//!
//! the triple root makes the arrival exact to the last bit, and only products and sums are needed. Rejected: moving
//! averages in cascade (a running sum drifts by rounding, and memory grows with the duration); time-optimal profiles
//! (square and cube roots in the loop).
//!
//! From rest, a step of D rad in N ticks has at most velocity 15/8 D/N, acceleration 10/sqrt(3) D/N^2 and jerk 60 D/N^3
//! (per tick, per tick^2, per tick^3). Steps above a given size take proportionally longer, so these three bounds hold
//! for steps of any size. A reference that changes on every tick is followed as by the filter 60/(s^3 + 9 s^2 + 36 s +
//! 60) in time s = N ticks.

/// Where the reference is and where it goes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Path {
    target: f64,
    position: f64,
    /// Per tick.
    velocity: f64,
    /// Per tick^2.
    acceleration: f64,
    c: [f64; 3],
    gone: f64,
    ticks: f64,
}

impl Path {
    /// Real-time: yes. The smoothed reference of this tick.
    ///
    /// `ticks` and `largest_step` as in [`crate::Settings`]; they count when the reference changes, not on the way.
    pub(crate) fn follow(&mut self, ticks: f64, largest_step: f64, reference: f64) -> f64 {
        if reference != self.target {
            self.restart(ticks, largest_step, reference);
        }
        self.gone += 1.0;
        if self.gone < self.ticks {
            self.evaluate()
        } else {
            self.rest()
        }
        self.position
    }

    /// Leaves from here, now, for the new target.
    fn restart(&mut self, ticks: f64, largest_step: f64, target: f64) {
        let d = self.position - target;
        let step = if d < 0.0 { -d } else { d };
        self.target = target;
        self.gone = 0.0;
        self.ticks = if largest_step > 0.0 && step > largest_step { ticks * (step / largest_step) } else { ticks };
        let w = self.velocity * self.ticks;
        let g = self.acceleration * self.ticks * self.ticks;
        self.c = [d, w + 3.0 * d, 0.5 * g + 3.0 * w + 6.0 * d];
    }

    fn evaluate(&mut self) {
        let [c0, c1, c2] = self.c;
        let n = self.ticks;
        let t = self.gone / n;
        let s = 1.0 - t;
        let (p, p1, p2) = (c0 + t * (c1 + t * c2), c1 + 2.0 * t * c2, 2.0 * c2);
        self.position = self.target + s * s * s * p;
        self.velocity = s * s * (s * p1 - 3.0 * p) / n;
        self.acceleration = s * (s * s * p2 - 6.0 * s * p1 + 6.0 * p) / (n * n);
    }

    fn rest(&mut self) {
        *self = Self { target: self.target, position: self.target, ..Self::default() };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Positions of a path through `references`, beginning with the rest before it (four zeros, for differences).
    fn positions(ticks: f64, largest_step: f64, references: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut path = Path::default();
        let moved = references.map(|r| path.follow(ticks, largest_step, r));
        [0.0; 4].into_iter().chain(moved).collect()
    }

    /// Largest velocity, acceleration and jerk, by differences. A difference is a mean of the derivative, so it stays
    /// below the derivative's bound.
    fn largest_differences(positions: &[f64]) -> [f64; 3] {
        let mut series = positions.to_vec();
        [(); 3].map(|()| {
            series = series.windows(2).map(|w| w[1] - w[0]).collect();
            series.iter().fold(0.0, |m: f64, x| m.max(x.abs()))
        })
    }

    /// Velocity, acceleration, jerk of a step from rest, as the head of this file states them.
    fn bounds(step: f64, n: f64) -> [f64; 3] {
        [15.0 / 8.0 * step / n, 10.0 / 3f64.sqrt() * step / (n * n), 60.0 * step / (n * n * n)]
    }

    #[test]
    fn a_step_from_rest_keeps_its_three_bounds_and_touches_them() {
        let n = 400.0;
        let found = largest_differences(&positions(n, f64::INFINITY, [0.5; 450].into_iter()));
        for (found, bound) in found.into_iter().zip(bounds(0.5, n)) {
            assert!(found <= bound * (1.0 + 1e-6) && found >= 0.97 * bound, "{found} against {bound}");
        }
    }

    #[test]
    fn a_larger_step_keeps_the_bounds_of_the_largest() {
        let n = 200.0;
        let path = positions(n, 0.5, [3.1; 1300].into_iter());
        for (found, bound) in largest_differences(&path).into_iter().zip(bounds(0.5, n)) {
            assert!(found <= bound * (1.0 + 1e-6), "{found} against {bound}");
        }
        // 200 ticks * 3.1/0.5 = 1240.
        assert_eq!(path[3 + 1240].to_bits(), 3.1f64.to_bits());
        assert!(path[3 + 1238] < 3.1);
    }

    #[test]
    fn it_arrives_to_the_last_bit_and_rests_wherever_it_was_sent_from() {
        let mut path = Path::default();
        for i in 1..200 {
            let target = 0.7 * f64::from(i * 7919 % 101) / 101.0 - 0.3;
            let on_the_way = i % 37;
            (0..on_the_way).for_each(|_| _ = path.follow(40.0, f64::INFINITY, target));
            if i % 5 == 0 {
                let tail: Vec<f64> = (0..60).map(|_| path.follow(40.0, f64::INFINITY, target)).collect();
                let last = 40 - on_the_way as usize;
                assert!(tail[last - 1..].iter().all(|p| p.to_bits() == target.to_bits()), "step {i}");
                assert_eq!((path.velocity, path.acceleration), (0.0, 0.0));
            }
        }
    }

    #[test]
    fn a_new_target_on_the_way_leaves_velocity_and_acceleration_continuous() {
        // Jerk at a restart is at most 60 |d| + 36 |w| + 9 |g| over N^3; from a motion within its own bounds that is
        // 60 (1 + 1) + 36 * 1.875 + 9 * 5.78 < 240 steps over N^3. A jump of the velocity would show as N^2 times more.
        let n = 100.0;
        for turn in 1..100 {
            let references = (0..300).map(|k| if k < turn { 1.0 } else { 0.0 });
            let [_, _, jerk] = largest_differences(&positions(n, f64::INFINITY, references));
            assert!(jerk <= 240.0 / (n * n * n), "turned at {turn}: jerk {jerk}");
        }
    }

    #[test]
    fn a_ramp_is_followed_with_the_lag_of_the_stated_filter() {
        // 60/(s^3 + 9 s^2 + 36 s + 60) lags a ramp by 36/60 of N ticks.
        let (n, slope) = (50.0, 1e-3);
        let path = positions(n, f64::INFINITY, (1..2000).map(|k| slope * f64::from(k)));
        let lag = (slope * 1999.0 - path[path.len() - 1]) / slope;
        assert!((lag - 0.6 * n).abs() < 1.5, "{lag} ticks");
    }

    #[test]
    fn a_reference_that_never_rests_keeps_the_path_bounded() {
        for n in [1.5, 2.0, 3.0, 7.0, 40.0] {
            let mut seed = 1u32;
            let noise = (0..20_000).map(|_| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                if seed >> 31 == 0 { -1.0 } else { 1.0 }
            });
            let largest = positions(n, f64::INFINITY, noise).into_iter().fold(0.0, |m: f64, p| m.max(p.abs()));
            assert!(largest < 2.0, "{n} ticks: {largest}");
        }
    }

    #[test]
    fn senseless_durations_pass_the_reference() {
        for ticks in [0.0, 1.0, -3.0, f64::NAN, f64::NEG_INFINITY] {
            assert_eq!(Path::default().follow(ticks, f64::INFINITY, 0.3).to_bits(), 0.3f64.to_bits());
        }
        for largest in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let path = positions(10.0, largest, [0.3; 10].into_iter());
            assert_eq!(path[13].to_bits(), 0.3f64.to_bits());
        }
    }
}
