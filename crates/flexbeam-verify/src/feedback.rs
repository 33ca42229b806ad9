//! The controller as the loop sees it, u = -K y, and the part of it that only the reference reaches.
//!
//! Enters: the kernel's controller, inputs (v, y, u_applied), outputs (u, y_model). Leaves: K, its poles, K(0).

use crate::{Error, Sampled, Timing, response::Response};
use flexbeam_lti::zeros::transmission_zeros;
use flexbeam_lti::{C64, Mat, StateSpace, Time};

/// A controller closed over u_applied = u.
#[derive(Clone, Debug)]
pub struct Feedback {
    K: Response,
    T: Response,
    M: Response,
    poles: Vec<C64>,
    /// Poles of what y and u_applied do not reach: the prefilter T and the model M.
    pub prefilter_poles: Vec<C64>,
    /// Poles of what y and u_applied do reach, with u_applied cut: what remains of the loop while the voltage is limited.
    pub saturated_poles: Vec<C64>,
    period_s: f64,
    /// First step of the extrapolation of 1/K to z = 1.
    first_step: f64,
}

impl Feedback {
    /// u = -K y of the kernel's controller, v = 0.
    ///
    /// Shapes: inputs (v, y, u_applied), outputs (u, y_model), sampled.
    /// Errors: [`Error::Shape`], [`Error::Feedthrough`].
    /// Numerics: states that y and u_applied cannot reach are told by exact zeros, so a controller that went through a change
    /// of coordinates keeps all of them in K (its prefilter's poles then count as poles of the loop, which they are).
    pub fn new(controller: &StateSpace) -> Result<Feedback, Error> {
        let (inputs, outputs, time) = (controller.inputs(), controller.outputs(), controller.time);
        let Time::Sampled { period_s } = time else {
            return Err(Error::Shape { what: "controller", inputs, outputs, time, needed: "sampled time" });
        };
        if (inputs, outputs) != (3, 2) {
            let needed = "inputs (v, y, u_applied), outputs (u, y_model)";
            return Err(Error::Shape { what: "controller", inputs, outputs, time, needed });
        }
        if let Some(&value) = controller.D.column(2).iter().find(|d| **d != 0.0) {
            return Err(Error::Feedthrough { value });
        }
        let (reached, beyond) = by_reach(controller);
        let saturated = controller.A.select_rows(&reached).select_columns(&reached);
        let C = controller.C.rows(0, 1).select_columns(&reached);
        let through = controller.D[(0, 1)];
        let [y, applied] = [1, 2].map(|k| controller.B.column(k).into_owned().select_rows(&reached));
        let applied = Mat::from_columns(&[applied]);
        let A = &saturated + &applied * &C;
        let B = Mat::from_columns(&[y]) + applied * through;
        let K = StateSpace::new(A, B, -C, Mat::from_element(1, 1, -through), time)?;
        let poles_of = |A: Mat| {
            let n = A.nrows();
            Ok::<_, Error>(StateSpace::new(A, Mat::zeros(n, 0), Mat::zeros(0, n), Mat::zeros(0, 0), time)?.poles())
        };
        let [T, M] = from_reference(controller)?;
        Ok(Feedback {
            poles: K.poles(),
            K: Response::new(&K)?,
            T,
            M,
            prefilter_poles: poles_of(controller.A.select_rows(&beyond).select_columns(&beyond))?,
            saturated_poles: poles_of(saturated)?,
            first_step: first_step(&K, period_s)?,
            period_s,
        })
    }

    /// K(z) and K'(z).
    pub fn at(&self, z: C64) -> (C64, C64) {
        self.K.at(z)
    }

    /// u/v for y = 0 and y_model/v.
    pub fn from_reference(&self, z: C64) -> (C64, C64) {
        (self.T.at(z).0, self.M.at(z).0)
    }

    /// Poles of K in the z-plane.
    pub fn poles(&self) -> &[C64] {
        &self.poles
    }

    /// Sample period [s].
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// 1/K(0) [rad/V]: how far a constant volt at the plant's input moves the tip; 0 with integral action, infinite for a
    /// controller that gives way.
    ///
    /// Numerics: the limit at z = 1 of 1/K by extrapolation; unlike C (I - A)^-1 B + D it does not ask for a regular I - A.
    pub fn compliance_rad_per_v(&self) -> f64 {
        limit_at_one(self.first_step, |z| self.at(z).0.inv().re)
    }

    /// y_model/v at rest.
    pub fn model_gain(&self) -> f64 {
        limit_at_one(FIRST_STEP_PER_S * self.period_s, |z| self.from_reference(z).1.re)
    }
}

/// First step of the extrapolation [1/s]: below the slowest dynamics of a controller for a beam, above what rounding swallows
/// (poles of a controller at 1 kHz are known to some 1e-12/s).
const FIRST_STEP_PER_S: f64 = 0.05;
/// 1/K is smooth up to the nearest zero of K: the step stays well inside.
fn first_step(K: &StateSpace, period_s: f64) -> Result<f64, Error> {
    let distances = transmission_zeros(K)?.into_iter().map(|z| (z - 1.0).norm());
    Ok(distances.fold(FIRST_STEP_PER_S * period_s, |step, distance| step.min(INSIDE * distance)))
}

/// Part of the distance to the nearest zero.
const INSIDE: f64 = 0.2;
/// Halvings of the step: six reach 1e-3/s and an error of order h^12.
const LEVELS: i32 = 6;

/// v -> u and v -> y_model, closed over u_applied = u.
fn from_reference(controller: &StateSpace) -> Result<[Response; 2], Error> {
    let column = |k: usize| controller.B.columns(k, 1).into_owned();
    let through = controller.D[(0, 0)];
    let A = &controller.A + column(2) * controller.C.rows(0, 1);
    let B = column(0) + column(2) * through;
    let to = |row: usize| {
        let C = controller.C.rows(row, 1).into_owned();
        let D = Mat::from_element(1, 1, controller.D[(row, 0)]);
        Response::new(&StateSpace::new(A.clone(), B.clone(), C, D, controller.time)?)
    };
    Ok([to(0)?, to(1)?])
}

/// lim f(z), z -> 1, for an f that is smooth there but cannot be evaluated at 1.
///
/// Numerics: Richardson extrapolation of (f(1 + h) + f(1 - h))/2, even in h; the entry that changes least is taken.
fn limit_at_one(first_step: f64, f: impl Fn(C64) -> f64) -> f64 {
    let mean = |h: f64| 0.5 * (f(C64::from(1.0 + h)) + f(C64::from(1.0 - h)));
    let mut table: Vec<f64> = (0..LEVELS).map(|k| mean(first_step * 0.5_f64.powi(k))).collect();
    let (mut best, mut change) = (table[table.len() - 1], f64::INFINITY);
    for order in 1..table.len() {
        let gain = 4.0_f64.powi(order as i32) - 1.0;
        for k in 0..table.len() - order {
            table[k] = table[k + 1] + (table[k + 1] - table[k]) / gain;
        }
        let last = table[table.len() - 1 - order];
        if (last - best).abs() < change {
            change = (last - best).abs();
            best = last;
        }
    }
    best
}

/// States that y or u_applied reach, and the others.
fn by_reach(controller: &StateSpace) -> (Vec<usize>, Vec<usize>) {
    let n = controller.order();
    let mut reached: Vec<bool> = (0..n).map(|i| controller.B[(i, 1)] != 0.0 || controller.B[(i, 2)] != 0.0).collect();
    let mut frontier: Vec<usize> = (0..n).filter(|&i| reached[i]).collect();
    while let Some(j) = frontier.pop() {
        for (i, is_reached) in reached.iter_mut().enumerate() {
            if !*is_reached && controller.A[(i, j)] != 0.0 {
                *is_reached = true;
                frontier.push(i);
            }
        }
    }
    (0..n).partition(|&i| reached[i])
}

/// Newton's iteration settles in a handful of steps from a start as near as the next angle.
const NEWTON_STEPS: usize = 8;
/// Two zeros nearer than this part of a step are one.
const SAME_POLE: f64 = 1e-3;

/// The loop gain L = G K around a sampled plant.
pub struct Loop<'a> {
    /// The plant.
    pub plant: &'a dyn Sampled,
    /// The controller.
    pub feedback: &'a Feedback,
}

impl<'a> Loop<'a> {
    /// Errors: [`Error::Setting`] when the two have different periods.
    pub fn new(plant: &'a dyn Sampled, feedback: &'a Feedback) -> Result<Loop<'a>, Error> {
        let (plant_s, value) = (plant.timing().period_s, feedback.period_s());
        if (plant_s - value).abs() > 1e-12 * value {
            return Err(Error::Setting {
                name: "the controller's period [s]",
                value,
                needed: "that of the certificate",
            });
        }
        Ok(Loop { plant, feedback })
    }

    /// L(z), and L'(z) where the plant gives its slope.
    pub fn gain(&self, z: C64) -> (C64, Option<C64>) {
        let ((G, G_slope), (K, K_slope)) = (self.plant.at(z), self.feedback.at(z));
        (G * K, G_slope.map(|slope| slope * K + G * K_slope))
    }

    /// Poles of plant and controller.
    pub fn open_poles(&self) -> Vec<C64> {
        let mut poles = self.plant.poles();
        poles.extend_from_slice(self.feedback.poles());
        poles
    }

    /// Closed-loop poles near the circle, by Newton's iteration on 1 + L from each of the angles; none where L has no slope.
    ///
    /// 1 + L is smooth from one angle to the next, its inverse is not: a sweep of the inverse must know where to look.
    pub(crate) fn resonances(&self, angles: &[f64], radius: f64) -> Vec<C64> {
        let mut found: Vec<C64> = Vec::new();
        for w in angles.windows(2) {
            let start = C64::from_polar(radius, 0.5 * (w[0] + w[1]));
            let Some(z) = self.newton(start, w[1] - w[0]) else { continue };
            if found.iter().all(|known| (known - z).norm() > SAME_POLE * (w[1] - w[0])) {
                found.push(z);
            }
        }
        found
    }

    /// A zero of 1 + L within `reach` of the start.
    fn newton(&self, start: C64, reach: f64) -> Option<C64> {
        let mut z = start;
        for _ in 0..NEWTON_STEPS {
            let (gain, slope) = self.gain(z);
            let step = (gain + 1.0) / slope?;
            z -= step;
            if !((z - start).norm() <= reach) {
                return None;
            }
            if step.norm() <= f64::EPSILON {
                break;
            }
        }
        Some(C64::new(z.re, z.im.abs()))
    }

    /// The loop's timing.
    pub fn timing(&self) -> Timing {
        self.plant.timing()
    }
}
