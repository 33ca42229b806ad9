//! One period of the loop, from measurement to voltage. The order of every sum and product here is that of flexbeam's kernel: do not
//! rearrange.

use super::law::{Switches, applied, limited, magnitude};
use super::settings::Settings;
use super::{Memory, Real};

/// Why the rig is held at 0 V. A fault latches until [`State::reset`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Fault {
    /// No fault.
    #[default]
    None,
    /// |alpha| went beyond `deflection_limit_rad`.
    Deflection,
    /// |theta| went beyond `theta_limit_rad`.
    Angle,
    /// theta moved more than `theta_step_limit_rad` in one tick.
    Speed,
    /// An input or a result was infinite or not a number.
    NonFinite,
}

/// What one tick is given.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Measured {
    /// Reference of the tip angle psi = theta + alpha [rad]; may step.
    pub reference_rad: Real,
    /// Hub angle, counter-clockwise [rad].
    pub theta_rad: Real,
    /// Deflection angle of the tip relative to the hub [rad].
    pub alpha_rad: Real,
}

/// What one tick answers. All numbers are finite, always.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Commanded {
    /// Voltage to send [V].
    pub voltage_v: Real,
    /// The controller's u, before the law [V].
    pub u_v: Real,
    /// v, the reference after smoothing [rad].
    pub reference_rad: Real,
    /// y = psi, filtered tip angle [rad].
    pub y_rad: Real,
    /// Output of the reference model [rad].
    pub y_model_rad: Real,
    /// e = y_model - y [rad].
    pub error_rad: Real,
    /// Why the voltage is zero, if it must be.
    pub fault: Fault,
}

/// The controller's matrices, column by column: [A B] with n rows, [C D] with two.
#[derive(Clone, Copy)]
pub(super) struct Gains<'a> {
    pub(super) order: usize,
    pub(super) ab: &'a [Real],
    pub(super) cd: &'a [Real],
}

/// All that one tick hands to the next.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// x, v, y, u_applied.
    pub(super) z: Memory,
    /// Where the next x is put together: as long as z, of which it uses the first n.
    pub(super) next: Memory,
    theta: LowPass,
    alpha: LowPass,
    reference: Path,
    switches: Switches,
    fault: Fault,
}

impl State {
    /// At rest at 0 rad, x = 0, no fault, in memory that is zero.
    pub(super) fn at_rest(z: Memory, next: Memory) -> Self {
        Self {
            z,
            next,
            theta: LowPass::default(),
            alpha: LowPass::default(),
            reference: Path::default(),
            switches: Switches::default(),
            fault: Fault::None,
        }
    }

    /// Back to rest: the only way out of a fault. Where the beam rests elsewhere, the channels' offsets take it to 0 rad.
    pub fn reset(&mut self) {
        self.z.fill(0.0);
        self.next.fill(0.0);
        self.theta = LowPass::default();
        self.alpha = LowPass::default();
        self.reference = Path::default();
        self.switches = Switches::default();
        self.fault = Fault::None;
    }

    /// The fault that holds the rig at 0 V.
    pub fn fault(&self) -> Fault {
        self.fault
    }
}

/// One period. A missed tick is not made up for: the next one runs with the state as it stands.
#[inline]
pub(super) fn tick(gains: Gains<'_>, settings: &Settings, state: &mut State, measured: Measured) -> Commanded {
    let sensed = state.sense(settings, measured);
    let y = sensed.theta + sensed.alpha;
    if state.fault == Fault::None {
        state.fault = sensed.broken(settings);
    }
    if state.fault != Fault::None {
        return Commanded::stopped(y, state.fault);
    }
    let v = state.reference.follow(settings.smooth_ticks, settings.smooth_step_rad, measured.reference_rad);
    if let [.., z_v, z_y, _] = &mut state.z[..] {
        (*z_v, *z_y) = (v, y);
    }
    let (u, y_model) = gains.outputs(&state.z);
    let e = y_model - y;
    let u_c = state.switches.compensated(settings, u, e);
    let voltage_v = limited(u_c, settings.voltage_limit_v);
    if let [.., u_applied] = &mut state.z[..] {
        *u_applied = applied(settings, u, u_c, voltage_v);
    }
    gains.advance(&state.z, &mut state.next);
    state.z.iter_mut().zip(&state.next).take(gains.order).for_each(|(x, next)| *x = *next);
    let commanded = Commanded {
        voltage_v,
        u_v: u,
        reference_rad: v,
        y_rad: y,
        y_model_rad: y_model,
        error_rad: e,
        fault: Fault::None,
    };
    if commanded.is_finite() {
        return commanded;
    }
    state.fault = Fault::NonFinite;
    Commanded::stopped(y, state.fault)
}

impl Gains<'_> {
    /// (u, y_model) = [C D] z.
    #[inline]
    fn outputs(&self, z: &[Real]) -> (Real, Real) {
        let mut products = self.cd.chunks_exact(2).zip(z).map(|(c, &z)| (c[0] * z, c[1] * z));
        let first = products.next().unwrap_or((0.0, 0.0));
        products.fold(first, |(u, y_model), (p_u, p_y)| (u + p_u, y_model + p_y))
    }

    /// next = [A B] z. With order 0 there is nothing to chunk.
    #[inline]
    fn advance(&self, z: &[Real], next: &mut [Real]) {
        let mut columns = self.ab.chunks_exact(self.order.max(1)).zip(z);
        if let Some((column, &z)) = columns.next() {
            next.iter_mut().zip(column).for_each(|(next, a)| *next = a * z);
        }
        for (column, &z) in columns {
            next.iter_mut().zip(column).for_each(|(next, a)| *next += a * z);
        }
    }
}

impl Commanded {
    /// A stopped loop asks for nothing: its reference and its model stand where the tip is.
    fn stopped(y: Real, fault: Fault) -> Self {
        let y = if y.is_finite() { y } else { 0.0 };
        Self { reference_rad: y, y_rad: y, y_model_rad: y, fault, ..Self::default() }
    }

    fn is_finite(&self) -> bool {
        let all = [self.voltage_v, self.u_v, self.reference_rad, self.y_rad, self.y_model_rad, self.error_rad];
        all.iter().all(|x| x.is_finite())
    }
}

/// Scaled and filtered measurements.
struct Sensed {
    theta: Real,
    alpha: Real,
    /// Since the tick before.
    theta_change: Real,
    /// All that came in was a number.
    finite: bool,
}

impl Sensed {
    fn broken(&self, settings: &Settings) -> Fault {
        if !self.finite {
            Fault::NonFinite
        } else if !within(self.alpha, settings.deflection_limit_rad) {
            Fault::Deflection
        } else if !within(self.theta, settings.theta_limit_rad) {
            Fault::Angle
        } else if !within(self.theta_change, settings.theta_step_limit_rad) {
            Fault::Speed
        } else {
            Fault::None
        }
    }
}

fn within(x: Real, limit: Real) -> bool {
    -limit <= x && x <= limit
}

impl State {
    /// Scales and filters; what is not a number leaves the filters as they were.
    fn sense(&mut self, settings: &Settings, measured: Measured) -> Sensed {
        let theta = settings.theta.scaled(measured.theta_rad);
        let alpha = settings.alpha.scaled(measured.alpha_rad);
        let before = self.theta.y_f;
        let finite = theta.is_finite() && alpha.is_finite() && measured.reference_rad.is_finite();
        if !finite {
            let (theta, alpha) = (before.unwrap_or(0.0), self.alpha.y_f.unwrap_or(0.0));
            return Sensed { theta, alpha, theta_change: 0.0, finite };
        }
        let theta = self.theta.pass(settings.theta.low_pass, theta);
        let alpha = self.alpha.pass(settings.alpha.low_pass, alpha);
        Sensed { theta, alpha, theta_change: theta - before.unwrap_or(theta), finite }
    }
}

/// First-order low-pass: its last output, or nothing before the first measurement.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct LowPass {
    y_f: Option<Real>,
}

impl LowPass {
    /// y_f += a (y - y_f), written so that a = 1 passes y to the last bit; the first measurement passes.
    fn pass(&mut self, a: Real, y: Real) -> Real {
        let y_f = match self.y_f {
            Some(y_f) => y - (1.0 - a) * (y - y_f),
            None => y,
        };
        self.y_f = Some(y_f);
        y_f
    }
}

/// The smooth step: p(t) = target + (1 - t)^3 (c0 + c1 t + c2 t^2), minimum jerk, exact at its end.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Path {
    target: Real,
    position: Real,
    /// Per tick.
    velocity: Real,
    /// Per tick^2.
    acceleration: Real,
    c: [Real; 3],
    gone: Real,
    ticks: Real,
}

impl Path {
    fn follow(&mut self, ticks: Real, largest_step: Real, reference: Real) -> Real {
        if reference != self.target {
            self.restart(ticks, largest_step, reference);
        }
        self.gone += 1.0;
        if self.gone < self.ticks {
            self.evaluate();
        } else {
            *self = Self { target: self.target, position: self.target, ..Self::default() };
        }
        self.position
    }

    fn restart(&mut self, ticks: Real, largest_step: Real, target: Real) {
        let d = self.position - target;
        let step = magnitude(d);
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
}
