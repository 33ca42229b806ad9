//! The variable-structure law and the voltage limit.

use super::Real;
use super::settings::{Law, Settings};

/// The two switches, with their memory.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Switches {
    /// Switch 1: the stationary error is large.
    error: bool,
    /// Switch 2: u lies in the dead region.
    dead: bool,
}

impl Switches {
    /// u_c of the law in force.
    pub(super) fn compensated(&mut self, settings: &Settings, u: Real, e: Real) -> Real {
        self.update(settings, magnitude(u), magnitude(e));
        match settings.law {
            Law::None => u,
            Law::Switched => self.switched(settings, u, e),
            Law::Inverse => inverse(settings, u),
        }
    }

    fn update(&mut self, settings: &Settings, u: Real, e: Real) {
        let leave_u = settings.eps_u_v * (1.0 + settings.hysteresis_u);
        let leave_e = settings.eps_e_rad * (1.0 - settings.hysteresis_e);
        self.dead = u < settings.eps_u_v || (self.dead && u <= leave_u);
        self.error = e > settings.eps_e_rad || (self.error && e >= leave_e);
    }

    fn switched(&self, settings: &Settings, u: Real, e: Real) -> Real {
        if !self.dead {
            u
        } else if !self.error {
            0.0
        } else if e > 0.0 {
            settings.u_p_plus_v
        } else if e < 0.0 {
            -settings.u_p_minus_v
        } else {
            0.0
        }
    }
}

/// f(u) = u + u_p sat(u/eps_u), u_p of u's direction.
fn inverse(settings: &Settings, u: Real) -> Real {
    let eps = settings.eps_u_v;
    if u > 0.0 {
        if u < eps { u + settings.u_p_plus_v * (u / eps) } else { u + settings.u_p_plus_v }
    } else if u < 0.0 {
        if u > -eps { u + settings.u_p_minus_v * (u / eps) } else { u - settings.u_p_minus_v }
    } else {
        u
    }
}

/// A voltage within [-limit, limit]; 0 V for a limit that is negative or not a number.
pub(super) fn limited(voltage: Real, limit: Real) -> Real {
    if limit >= 0.0 {
        if voltage > limit {
            limit
        } else if voltage < -limit {
            -limit
        } else {
            voltage
        }
    } else {
        0.0
    }
}

/// What the controller's observer hears of the limited voltage, on its own side of the dead zone.
pub(super) fn applied(settings: &Settings, u: Real, u_c: Real, voltage: Real) -> Real {
    match settings.law {
        Law::None => voltage,
        Law::Switched => through_dead_zone(settings, voltage),
        Law::Inverse if voltage == u_c => u,
        Law::Inverse if voltage > 0.0 => undone(voltage, settings.eps_u_v, settings.u_p_plus_v),
        Law::Inverse if voltage < 0.0 => -undone(-voltage, settings.eps_u_v, settings.u_p_minus_v),
        Law::Inverse => voltage,
    }
}

/// One direction of f^-1, voltage > 0. Without a positive threshold f jumps by u_p at zero; what falls into the jump comes from 0.
fn undone(voltage: Real, eps: Real, u_p: Real) -> Real {
    if eps > 0.0 && voltage < eps + u_p {
        voltage * (eps / (eps + u_p))
    } else if voltage > u_p {
        voltage - u_p
    } else {
        0.0
    }
}

fn through_dead_zone(settings: &Settings, voltage: Real) -> Real {
    if voltage > settings.breakaway_plus_v {
        voltage - settings.breakaway_plus_v
    } else if voltage < -settings.breakaway_minus_v {
        voltage + settings.breakaway_minus_v
    } else {
        0.0
    }
}

/// |x|.
pub(super) fn magnitude(x: Real) -> Real {
    if x < 0.0 { -x } else { x }
}
