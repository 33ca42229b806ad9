//! The smooth step: a stepping reference becomes one with bounded velocity, acceleration and jerk (DESIGN section 7).
//!
//! Each change of the reference starts a minimum-jerk polynomial that leaves with the present position, velocity and acceleration and arrives at rest after a
//! given number of ticks. Written about its end,
//!
//!   p(t) = target + (1 - t)^3 (c0 + c1 t + c2 t^2),   t = ticks gone / ticks in all,
//!
//! the triple root makes the arrival exact to the last bit, and only products and sums are needed. Rejected: moving averages in cascade (a running sum drifts by
//! rounding, and memory grows with the duration); time-optimal profiles (square and cube roots in the loop).
//!
//! From rest, a step of D rad in N ticks has at most velocity 15/8 D/N, acceleration 10/sqrt(3) D/N^2 and jerk 60 D/N^3 (per tick, per tick^2, per tick^3). Steps
//! above a given size take proportionally longer, so these three bounds hold for steps of any size. A reference that changes on every tick is followed
//! as by the filter 60/(s^3 + 9 s^2 + 36 s + 60) in time s = N ticks.

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
