//! One period of the loop, from measurement to voltage. This file owns the order; everything else is a part of it.

use crate::controller::Controller;
use crate::law;
use crate::limits::{self, Fault};
use crate::settings::Settings;
use crate::state::State;

/// What one tick is given.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Measured {
    /// Reference of the tip angle psi [rad]; may step.
    pub reference_rad: f64,
    /// Hub angle [rad].
    pub theta_rad: f64,
    /// Deflection angle of the tip relative to the hub [rad].
    pub alpha_rad: f64,
}

/// What one tick answers. All numbers are finite, always.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Commanded {
    /// Voltage to send [V].
    pub voltage_v: f64,
    /// The controller's u, before the law [V] (Figure 10 of the paper).
    pub u_v: f64,
    /// Reference after smoothing, v [rad].
    pub reference_rad: f64,
    /// Filtered tip angle y = psi [rad].
    pub y_rad: f64,
    /// Output of the reference model M r [rad].
    pub y_model_rad: f64,
    /// e = y_model - y [rad].
    pub error_rad: f64,
    /// Why the voltage is zero, if it must be.
    pub fault: Fault,
}

impl Commanded {
    /// A stopped loop asks for nothing: its reference and its model stand where the tip is.
    fn stopped(y: f64, fault: Fault) -> Self {
        let y = if y.is_finite() { y } else { 0.0 };
        Self { reference_rad: y, y_rad: y, y_model_rad: y, fault, ..Self::default() }
    }

    fn is_finite(&self) -> bool {
        let Self { voltage_v, u_v, reference_rad, y_rad, y_model_rad, error_rad, fault: _ } = *self;
        [voltage_v, u_v, reference_rad, y_rad, y_model_rad, error_rad].iter().all(|x| x.is_finite())
    }
}

/// Real-time: yes. One period of the loop.
///
/// Order: scale, filter, limits on the measurements, smooth reference, controller outputs, variable-structure law,
/// voltage limit, u_applied, state update, non-finite check.
///
/// Total for any settings, any controller, any numbers: no panic, no allocation, no lock, no clock. A fault gives 0 V
/// from this tick on, until [`State::reset`]; the measurements are still filtered and answered. A missed tick is not
/// made up for: the next one runs with the state as it stands, so the caller counts it and decides.
/// Numerics: the same f64 bits on every IEEE platform without contraction. About 2 n (n + 5) flops.
/// Source: paper, Figure 8, for what stands between controller and amplifier; DESIGN sections 1 and 7 for the order.
pub fn tick(settings: &Settings, controller: &Controller<'_>, state: &mut State<'_>, measured: Measured) -> Commanded {
    let sensed = state.sense(settings, measured); // scale, filter
    let y = sensed.theta_rad + sensed.alpha_rad;
    state.latch(sensed.fault(settings, controller, state));
    if state.fault != Fault::None {
        return Commanded::stopped(y, state.fault);
    }
    let v = state.reference.follow(settings.smooth_ticks, settings.smooth_step_rad, measured.reference_rad);
    state.set_inputs(v, y);
    let (u, y_model) = controller.outputs(state.z);
    let e = y_model - y;
    let u_c = state.switches.compensated(settings, u, e);
    let voltage_v = limits::limited(u_c, settings.voltage_limit_v);
    state.advance(controller, law::applied(settings, u, u_c, voltage_v));
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
    state.latch(Fault::NonFinite);
    Commanded::stopped(y, state.fault)
}

/// Scaled and filtered measurements.
struct Sensed {
    theta_rad: f64,
    alpha_rad: f64,
    theta_change_rad: f64,
    /// All that came in was a number.
    finite: bool,
}

impl Sensed {
    fn fault(&self, settings: &Settings, controller: &Controller<'_>, state: &State<'_>) -> Fault {
        if state.next.len() != controller.order() {
            Fault::Order
        } else if !self.finite {
            Fault::NonFinite
        } else {
            limits::broken(settings, self.theta_rad, self.alpha_rad, self.theta_change_rad)
        }
    }
}

impl State<'_> {
    /// Scales and filters; what is not a number leaves the filters as they were.
    fn sense(&mut self, settings: &Settings, measured: Measured) -> Sensed {
        let theta = settings.theta.scaled(measured.theta_rad);
        let alpha = settings.alpha.scaled(measured.alpha_rad);
        let before = self.theta.last();
        let finite = theta.is_finite() && alpha.is_finite() && measured.reference_rad.is_finite();
        if !finite {
            let (theta_rad, alpha_rad) = (before.unwrap_or(0.0), self.alpha.last().unwrap_or(0.0));
            return Sensed { theta_rad, alpha_rad, theta_change_rad: 0.0, finite };
        }
        let theta_rad = self.theta.pass(settings.theta.low_pass, theta);
        let alpha_rad = self.alpha.pass(settings.alpha.low_pass, alpha);
        Sensed { theta_rad, alpha_rad, theta_change_rad: theta_rad - before.unwrap_or(theta_rad), finite }
    }

    /// The first fault stays.
    fn latch(&mut self, fault: Fault) {
        if self.fault == Fault::None {
            self.fault = fault;
        }
    }
}
