//! Closed-loop poles counted by the argument principle, without closed-loop eigenvalues.
//!
//! F = 1 + L on the circle |z| = e^(-degree Ts). F(infinity) = 1, so outside the circle
//!
//! ```text
//! poles of the loop = poles of plant and controller - turns of F around 0.
//! ```
//!
//! Enters: a loop gain with its open-loop poles. Leaves: counts, the stability degree. Absent: eigenvalues of the loop.

use crate::feedback::Loop;
use crate::{Error, sweep};
use flexbeam_lti::C64;
use std::f64::consts::PI;

/// How many closed-loop poles lie right of Re s = -degree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Count {
    /// The degree asked about [1/s].
    pub degree: f64,
    /// Closed-loop poles outside the circle.
    pub beyond: usize,
    /// Poles of plant and controller outside the circle.
    pub open_loop: usize,
    /// Smallest |1 + L| met on the circle.
    pub return_difference: f64,
    /// Where it was met [rad/s].
    pub omega_rad_s: f64,
    /// Newton's estimate of the closed-loop pole nearest to the circle.
    pub nearest: C64,
    /// Evaluations of the loop gain.
    pub evaluations: usize,
}

/// An open-loop pole this close to the contour [1/s] is divided out of F: an integrator is known to rounding only (1e-12/s).
const ON_CONTOUR_PER_S: f64 = 1e-7;
/// Largest change of phase in half a step: far below pi, where turns would be lost.
const LARGEST_TURN: f64 = PI / 6.0;
/// F in the middle of a step departs from the mean of its ends by no more than this part of |F|: no loop hides there.
const STRAIGHT: f64 = 0.2;
/// |dF| over half a step, from the slope in its middle, in units of |F|.
const LARGEST_SLOPE: f64 = 0.7;
/// Halvings of a step of the grid before the contour counts as running through a pole: the step is then 1e-14.
const MOST_HALVINGS: usize = 48;
/// Lowest angle [rad]: F is real at 0 and departs from it by less than rounding here.
const LOWEST: f64 = 1e-9;

/// Counts the closed-loop poles right of the line Re s = -degree.
///
/// Errors: [`Error::OnContour`] when one lies on it.
/// Numerics: each step is halved until both halves turn by less than pi/6, F bends by less than a fifth of itself and (where
/// the slope is known) moves by less than 0.7 of itself; the grid is dense around each open-loop pole, so that F is smooth
/// within a step. Some hundred to some thousand evaluations.
/// Source: Nyquist 1932, on the shifted circle.
pub fn count(L: &Loop<'_>, degree: f64) -> Result<Count, Error> {
    let mut contour = Contour::new(L, degree);
    let angles = sweep::angles(&contour.open_poles, contour.radius, LOWEST);
    let points: Vec<Point> = angles.iter().map(|&angle| contour.point(angle)).collect();
    let mut turned = 0.0;
    for w in points.windows(2) {
        turned += contour.turn(w[0], w[1], MOST_HALVINGS)?;
    }
    let turns = (turned / PI).round() as i64; // the lower half of the circle turns as much again: 2 turned/(2 pi)
    let outside = contour.open_poles.iter().filter(|p| p.norm() > contour.radius).count();
    let beyond = usize::try_from(outside as i64 - turns).map_err(|_| contour.undecided())?;
    Ok(Count {
        beyond,
        open_loop: outside + contour.on_circle.iter().filter(|p| p.norm() > contour.radius).count(),
        ..contour.met
    })
}

#[derive(Clone, Copy)]
struct Point {
    angle: f64,
    F: C64,
    /// dF/d(angle).
    slope: Option<C64>,
}

struct Contour<'a> {
    L: &'a Loop<'a>,
    radius: f64,
    /// Poles off the circle.
    open_poles: Vec<C64>,
    /// Poles on it, divided out: F (z - p)/z has the same zeros and no pole there.
    on_circle: Vec<C64>,
    met: Count,
    nearest_step: f64,
}

impl<'a> Contour<'a> {
    fn new(L: &'a Loop<'a>, degree: f64) -> Contour<'a> {
        let timing = L.timing();
        let radius = timing.radius(degree);
        let is_on = |p: &C64| (p.norm() / radius).ln().abs() <= ON_CONTOUR_PER_S * timing.period_s;
        let (on_circle, open_poles): (Vec<C64>, Vec<C64>) = L.open_poles().into_iter().partition(is_on);
        let met = Count {
            degree,
            beyond: 0,
            open_loop: 0,
            return_difference: f64::INFINITY,
            omega_rad_s: 0.0,
            nearest: C64::from(radius),
            evaluations: 0,
        };
        Contour { L, radius, open_poles, on_circle, met, nearest_step: f64::INFINITY }
    }

    fn point(&mut self, angle: f64) -> Point {
        let z = C64::from_polar(self.radius, angle);
        let (gain, slope) = self.L.gain(z);
        let F = gain + 1.0;
        self.remember(angle, z, F, slope);
        let factor: C64 = self.on_circle.iter().map(|p| (z - p) / z).product();
        let bend: C64 = self.on_circle.iter().map(|p| (z - p).inv() - z.inv()).sum();
        let slope = slope.map(|slope| (slope + F * bend) * factor * C64::i() * z);
        Point { angle, F: F * factor, slope }
    }

    fn remember(&mut self, angle: f64, z: C64, F: C64, slope: Option<C64>) {
        self.met.evaluations += 1;
        if F.norm() < self.met.return_difference {
            self.met.return_difference = F.norm();
            self.met.omega_rad_s = angle / self.L.timing().period_s;
        }
        let Some(step) = slope.map(|slope| F / slope) else { return };
        if step.norm() < self.nearest_step {
            self.nearest_step = step.norm();
            self.met.nearest = z - step;
        }
    }

    /// Change of phase of F from a to b.
    fn turn(&mut self, a: Point, b: Point, halvings: usize) -> Result<f64, Error> {
        let m = self.point(0.5 * (a.angle + b.angle));
        let (first, second) = ((m.F / a.F).arg(), (b.F / m.F).arg());
        if is_resolved(a, m, b) && first.abs() < LARGEST_TURN && second.abs() < LARGEST_TURN {
            return Ok(first + second);
        }
        if halvings == 0 {
            return Err(self.undecided());
        }
        Ok(self.turn(a, m, halvings - 1)? + self.turn(m, b, halvings - 1)?)
    }

    fn undecided(&self) -> Error {
        let Count { degree, omega_rad_s, return_difference, .. } = self.met;
        Error::OnContour { degree, omega_rad_s, return_difference }
    }
}

fn is_resolved(a: Point, m: Point, b: Point) -> bool {
    let least = a.F.norm().min(m.F.norm()).min(b.F.norm());
    let bend = (m.F - (a.F + b.F) * 0.5).norm();
    let half = 0.5 * (b.angle - a.angle);
    let moved = m.slope.map_or(0.0, |slope| slope.norm() * half);
    bend <= STRAIGHT * least && moved <= LARGEST_SLOPE * m.F.norm()
}

/// Bracket in which Newton's estimate is tried, relative to the degree.
const COARSE: f64 = 1e-3;
/// Distance, relative to the degree, at which the two counts beside the estimate must differ.
const PROOF: f64 = 1e-8;
/// Width of the bracket at which bisection ends when Newton's estimate found no proof, relative to the degree.
const FINE: f64 = 1e-9;
/// Smallest scale of a degree [1/s]: a loop with a slower pole is integrating for all that a rig can show.
const SLOWEST_PER_S: f64 = 1e-4;
/// A degree beyond this many periods^-1 is that of a dead-beat loop: no finite degree is found.
const DEAD_BEAT: f64 = 20.0;

/// The stability degree, -max ln|z|/Ts over the closed-loop poles, by counts on circles.
///
/// Returns a negative degree for an unstable loop.
/// Errors: [`Error::NotSettled`] when no circle up to e^-20 has a pole outside it; those of [`count`].
/// Numerics: bisection on the circle's radius; then Newton's iteration on 1 + L from the point nearest to the circle, and its
/// result proven by two counts 1e-8 to either side. A multiple pole spoils Newton's estimate and is bisected instead.
pub fn stability_degree(L: &Loop<'_>) -> Result<f64, Error> {
    let (mut low, mut high) = bracket(L)?;
    let scale = |low: f64, high: f64| low.abs().max(high.abs()).max(SLOWEST_PER_S);
    let mut tried = false;
    while high - low > FINE * scale(low, high) {
        if !tried && high - low <= COARSE * scale(low, high) {
            tried = true;
            if let Some(degree) = polished(L, low, high)? {
                return Ok(degree);
            }
        }
        let middle = 0.5 * (low + high);
        if settled(L, middle)?.beyond == 0 { low = middle } else { high = middle }
    }
    Ok(0.5 * (low + high))
}

/// low with no closed-loop pole beyond, high with some.
fn bracket(L: &Loop<'_>) -> Result<(f64, f64), Error> {
    let limit = DEAD_BEAT / L.timing().period_s;
    let is_clear = |degree: f64| Ok::<bool, Error>(settled(L, degree)?.beyond == 0);
    let sign = if is_clear(0.0)? { 1.0 } else { -1.0 };
    let (mut near, mut far) = (0.0, sign);
    while is_clear(far)? == (sign > 0.0) {
        (near, far) = (far, 2.0 * far);
        if far.abs() > limit {
            return Err(Error::NotSettled { what: "the stability degree [1/s]", from: -limit, to: limit });
        }
    }
    Ok(if sign > 0.0 { (near, far) } else { (far, near) })
}

/// A count at the degree, or a hair beside it when a closed-loop pole lies on the contour.
fn settled(L: &Loop<'_>, degree: f64) -> Result<Count, Error> {
    match count(L, degree) {
        Err(Error::OnContour { .. }) => count(L, degree + FINE * degree.abs().max(SLOWEST_PER_S)),
        other => other,
    }
}

/// Newton's iteration settles in a handful of steps from a start that is good to a thousandth.
const NEWTON_STEPS: usize = 12;

fn polished(L: &Loop<'_>, low: f64, high: f64) -> Result<Option<f64>, Error> {
    let mut z = settled(L, high)?.nearest;
    for _ in 0..NEWTON_STEPS {
        let (gain, Some(slope)) = L.gain(z) else { return Ok(None) };
        z -= (gain + 1.0) / slope;
    }
    let degree = -z.norm().ln() / L.timing().period_s;
    if !(low <= degree && degree <= high) {
        return Ok(None);
    }
    let beside = PROOF * degree.abs().max(SLOWEST_PER_S);
    let (Ok(inner), Ok(outer)) = (count(L, degree - beside), count(L, degree + beside)) else { return Ok(None) };
    Ok((inner.beyond == 0 && outer.beyond > 0).then_some(degree))
}
