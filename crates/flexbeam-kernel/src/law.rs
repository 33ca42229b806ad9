//! The variable-structure law around the controller (paper, Figure 8; DESIGN section 7).
//!
//! Enters: the controller's u, the error e = y_model - y, the voltage after limits. Leaves: the compensated u_c, and
//! the u_applied that the controller's observer hears.
//!
//! What u_applied must be. The controller's observer models the plant without its dead zone, so it must hear a voltage
//! on that side of the dead zone.
//!
//! * `Inverse`: u_c = f(u) with f(u) = u + u_p sat(u/eps_u) strictly increasing, so u_applied = f^-1(voltage). Below
//!   the voltage limit it is u itself, to the last bit: the controller stays the linear one that was certified, with
//!   its K(0), and at rest |e| <= v_res/K(0). Hearing u_c instead, the observer believes in a push of u_p that never
//!   reaches the beam (3.2 degrees of stationary error against 0.3). Removing the dead zone literally (0 while stuck)
//!   would freeze integral action wherever the hub sticks.
//! * `Switched`: f jumps and has no inverse, and outside its dead region it compensates nothing. The observer hears
//!   what gets through the estimated dead zone: voltage minus breakaway, zero inside.
//! * `None`: the limited voltage.

use crate::settings::Settings;

/// Which variable-structure law stands between the controller and the amplifier.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Law {
    /// u_c = u.
    None,
    /// u_c = u outside the dead region; inside it u_p sign(e) while the error is large, else 0.
    Switched,
    /// u_c = u + u_p sat(u/eps_u).
    #[default]
    Inverse,
}

/// Real-time: no. Residual voltage of the inverse law: the largest |u| at which u + u_p u/eps_u stays within a breakaway voltage of
/// u_p.
///
/// v_res = eps_u u_p/(u_p + eps_u)  [V]
///
/// Returns: 0 when both are zero. At rest |e| <= v_res/K(0).
/// Source: DESIGN section 7.
pub fn v_res(eps_u_v: f64, u_p_v: f64) -> f64 {
    let sum = u_p_v + eps_u_v;
    if sum == 0.0 { 0.0 } else { eps_u_v * u_p_v / sum }
}

/// The two switches of Figure 8, with their memory.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Switches {
    /// Switch 1: the stationary error is large.
    error: bool,
    /// Switch 2: u lies in the dead region.
    dead: bool,
}

impl Switches {
    /// Real-time: yes. u_c of the law in force.
    pub(crate) fn compensated(&mut self, settings: &Settings, u: f64, e: f64) -> f64 {
        self.update(settings, u, e);
        match settings.law {
            Law::None => u,
            Law::Switched => self.switched(settings, u, e),
            Law::Inverse => inverse(settings, u),
        }
    }

    /// Switch 2 closes below eps_u and opens above eps_u (1 + hysteresis_u); switch 1 closes above eps_e and opens
    /// below eps_e (1 - hysteresis_e).
    fn update(&mut self, settings: &Settings, u: f64, e: f64) {
        let (u, e) = (magnitude(u), magnitude(e));
        let leave_u = settings.eps_u_v * (1.0 + settings.hysteresis_u);
        let leave_e = settings.eps_e_rad * (1.0 - settings.hysteresis_e);
        self.dead = u < settings.eps_u_v || (self.dead && u <= leave_u);
        self.error = e > settings.eps_e_rad || (self.error && e >= leave_e);
    }

    fn switched(&self, settings: &Settings, u: f64, e: f64) -> f64 {
        match (self.dead, self.error) {
            (false, _) => u,
            (true, false) => 0.0,
            (true, true) if e > 0.0 => settings.u_p_plus_v,
            (true, true) if e < 0.0 => -settings.u_p_minus_v,
            (true, true) => 0.0,
        }
    }
}

/// Real-time: yes. What the observer hears of `voltage`, the limited u_c: see the head of this file.
pub(crate) fn applied(settings: &Settings, u: f64, u_c: f64, voltage: f64) -> f64 {
    match settings.law {
        Law::None => voltage,
        Law::Switched => through_dead_zone(settings, voltage),
        Law::Inverse if voltage == u_c => u,
        Law::Inverse => inverse_of_inverse(settings, voltage),
    }
}

/// f(u) = u + u_p sat(u/eps_u), u_p of u's direction. A threshold that is not positive makes the sign of it.
fn inverse(settings: &Settings, u: f64) -> f64 {
    let eps = settings.eps_u_v;
    if u > 0.0 {
        if u < eps { u + settings.u_p_plus_v * (u / eps) } else { u + settings.u_p_plus_v }
    } else if u < 0.0 {
        if u > -eps { u + settings.u_p_minus_v * (u / eps) } else { u - settings.u_p_minus_v }
    } else {
        u
    }
}

/// f^-1: slope eps/(eps + u_p) up to eps + u_p, then shifted by u_p.
fn inverse_of_inverse(settings: &Settings, voltage: f64) -> f64 {
    let eps = settings.eps_u_v;
    if voltage > 0.0 {
        undone(voltage, eps, settings.u_p_plus_v)
    } else if voltage < 0.0 {
        -undone(-voltage, eps, settings.u_p_minus_v)
    } else {
        voltage
    }
}

/// One direction of f^-1, voltage > 0. Without a positive threshold f jumps by u_p at zero; what falls into the jump
/// comes from 0.
fn undone(voltage: f64, eps: f64, u_p: f64) -> f64 {
    if eps > 0.0 && voltage < eps + u_p {
        voltage * (eps / (eps + u_p))
    } else if voltage > u_p {
        voltage - u_p
    } else {
        0.0
    }
}

fn through_dead_zone(settings: &Settings, voltage: f64) -> f64 {
    if voltage > settings.breakaway_plus_v {
        voltage - settings.breakaway_plus_v
    } else if voltage < -settings.breakaway_minus_v {
        voltage + settings.breakaway_minus_v
    } else {
        0.0
    }
}

fn magnitude(x: f64) -> f64 {
    if x < 0.0 { -x } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(law: Law) -> Settings {
        Settings { law, u_p_plus_v: 0.28, u_p_minus_v: 0.1, eps_u_v: 0.2, eps_e_rad: 0.01, ..Settings::default() }
    }

    /// u_c of fresh switches.
    fn once(settings: &Settings, u: f64, e: f64) -> f64 {
        Switches::default().compensated(settings, u, e)
    }

    #[test]
    fn no_law_passes_u() {
        let s = settings(Law::None);
        assert_eq!(once(&s, 0.05, 1.0), 0.05);
        assert_eq!(applied(&s, 12.0, 12.0, 10.0), 10.0);
    }

    #[test]
    fn the_switched_law_is_figure_8() {
        let s = settings(Law::Switched);
        for (u, e, u_c) in [
            (0.3, 0.0, 0.3),    // outside the dead region: u
            (-0.3, 1.0, -0.3),  // whatever the error
            (0.1, 0.02, 0.28),  // inside, error large: u_p sign(e)
            (0.1, -0.02, -0.1), // the error's sign, not u's; each direction has its own u_p
            (0.1, 0.005, 0.0),  // inside, error small: nothing
            (-0.1, -0.005, 0.0),
        ] {
            assert_eq!(once(&s, u, e), u_c, "u = {u}, e = {e}");
        }
    }

    #[test]
    fn both_switches_remember() {
        let s = Settings { hysteresis_u: 0.5, hysteresis_e: 0.5, ..settings(Law::Switched) };
        let mut switches = Switches::default();
        let mut u_c = |u, e| switches.compensated(&s, u, e);
        assert_eq!(u_c(0.25, 0.02), 0.25, "between the thresholds, from outside: still outside");
        assert_eq!(u_c(0.19, 0.02), 0.28, "below eps_u: dead");
        assert_eq!(u_c(0.29, 0.02), 0.28, "until eps_u (1 + h)");
        assert_eq!(u_c(0.31, 0.02), 0.31);
        assert_eq!(u_c(0.1, 0.008), 0.28, "the error was large and is above eps_e (1 - h)");
        assert_eq!(u_c(0.1, 0.004), 0.0);
        assert_eq!(u_c(0.1, 0.008), 0.0, "and stays small until eps_e");
        assert_eq!(u_c(0.1, 0.011), 0.28);
    }

    #[test]
    fn without_hysteresis_the_thresholds_are_the_papers() {
        let s = Settings { hysteresis_u: 0.0, hysteresis_e: 0.0, ..settings(Law::Switched) };
        let mut switches = Switches::default();
        assert_eq!(switches.compensated(&s, 0.1999, 0.02), 0.28);
        assert_eq!(switches.compensated(&s, 0.2001, 0.02), 0.2001);
        assert_eq!(switches.compensated(&s, 0.1, 0.0101), 0.28);
        assert_eq!(switches.compensated(&s, 0.1, 0.0099), 0.0);
    }

    #[test]
    fn the_inverse_law_is_a_ramp_and_a_shift_in_each_direction() {
        let s = settings(Law::Inverse);
        assert_eq!(once(&s, 0.0, 1.0), 0.0);
        assert_eq!(once(&s, 0.2, 0.0), 0.2 + 0.28);
        assert_eq!(once(&s, 3.0, 0.0), 3.0 + 0.28);
        assert_eq!(once(&s, -3.0, 0.0), -3.0 - 0.1);
        assert_eq!(once(&s, 0.05, 0.0), 0.05 + 0.28 * 0.25);
        assert_eq!(once(&s, -0.05, 0.0), -0.05 - 0.1 * 0.25);
    }

    #[test]
    fn the_observer_hears_its_own_u_below_the_limit_and_the_inverse_beyond_it() {
        let s = settings(Law::Inverse);
        for k in -400..=400 {
            let u = 0.005 * f64::from(k);
            let u_c = once(&s, u, 0.0);
            assert_eq!(applied(&s, u, u_c, u_c).to_bits(), u.to_bits());
            // Limited to the voltage that another u gives, the observer hears that u.
            let heard = applied(&s, 7.0 * u + 1.0, 7.0 * u_c + 1.0, u_c);
            assert!((heard - u).abs() <= 1e-15, "{heard} against {u}");
        }
    }

    #[test]
    fn under_the_switched_law_the_observer_hears_what_passes_the_dead_zone() {
        let s = Settings { breakaway_plus_v: 0.25, breakaway_minus_v: 0.08, ..settings(Law::Switched) };
        for (voltage, heard) in [(0.2, 0.0), (-0.05, 0.0), (1.25, 1.0), (-1.08, -1.0), (0.0, 0.0)] {
            assert!((applied(&s, 9.0, 9.0, voltage) - heard).abs() < 1e-15);
        }
    }

    #[test]
    fn v_res_is_where_the_inverse_law_reaches_the_breakaway_voltage() {
        for (eps_u_v, u_p) in [(0.1, 0.28), (0.3, 0.1), (0.05, 0.05)] {
            let s = Settings { eps_u_v, u_p_plus_v: u_p, ..settings(Law::Inverse) };
            assert!((once(&s, v_res(eps_u_v, u_p), 0.0) - u_p).abs() < 1e-15);
        }
        assert_eq!(v_res(0.0, 0.0), 0.0);
    }

    #[test]
    fn a_threshold_of_zero_makes_a_jump_and_not_a_division() {
        let s = Settings { eps_u_v: 0.0, ..settings(Law::Inverse) };
        assert_eq!(once(&s, 0.0, 0.0), 0.0);
        assert_eq!(once(&s, 1e-300, 0.0), 0.28);
        assert_eq!(applied(&s, 5.0, 5.0, 0.1), 0.0);
        assert_eq!(applied(&s, 5.0, 5.0, 1.28), 1.0);
    }
}
