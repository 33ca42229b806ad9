//! The feedback part of the controller, R u = T v - S y, from the interpolant.
//!
//! In the shifted plane S = F/(alpha D_p) with D = D_p B_p the plant's denominator, and from the Bezout identity R = 1/D - S G.
//! R is stable, so only the stable part of S G survives: 1 - R = [S G]_stable. The controller is therefore a copy of the
//! plant's well-damped modes, driven by the applied voltage, in front of S, and has no hidden modes:
//!
//! ```text
//! u = [S G]_stable u_applied - S y + T v.
//! ```
//!
//! Source: (20)-(22), DESIGN 6.5 (its observer form, with the modes that neither side sees taken out).

use flexbeam_lti::split::split;
use flexbeam_lti::sylvester::sylvester;
use flexbeam_lti::{C64, Mat, StateSpace, Time, sampling};

use crate::half_plane::HalfPlane;
use crate::interpolation::Interpolant;
use crate::radius::inverse;
use crate::{Error, Uncertainty};

/// The filters (y, u_applied) -> u without the reference, unshifted.
#[derive(Clone, Debug)]
pub struct Feedback {
    /// Inputs (y, u_applied), output u; the column of D that belongs to u_applied is zero.
    pub filters: StateSpace,
    /// D = prod (s - p)/(s - mirror of p): the plant's denominator over the well-damped one, unshifted poles p.
    pub unstable_poles: Vec<C64>,
    /// The mirrors, same order.
    pub mirrored_poles: Vec<C64>,
}

impl Feedback {
    /// Puts R and S together.
    ///
    /// Numerics: one ordered Schur form of the plant and one Sylvester equation between stable and antistable poles.
    pub fn new(plant: &HalfPlane, alpha: &Uncertainty, interpolant: &Interpolant) -> Result<Feedback, Error> {
        let S = numerator(plant, alpha, interpolant)?;
        let is_stable = |p: C64| match plant.shifted.time {
            Time::Continuous => p.re < 0.0,
            Time::Sampled { .. } => p.norm() < 1.0,
        };
        let (stable, antistable) = split(&plant.shifted, is_stable)?;
        let filters = join(&S, &stable, &antistable)?.shifted(-plant.beta);
        let unstable: Vec<C64> = antistable.poles();
        let unshift = |p: &C64| match plant.shifted.time {
            Time::Continuous => p - plant.beta,
            Time::Sampled { period_s } => p * (-plant.beta * period_s).exp(),
        };
        let unstable_poles = unstable.iter().map(unshift).collect();
        let mirrored_poles = unstable.iter().map(|p| unshift(&mirror(*p, plant.shifted.time))).collect();
        Ok(Feedback { filters, unstable_poles, mirrored_poles })
    }

    /// K of u = -K y, the loop closed over u_applied = u.
    pub fn controller(&self) -> StateSpace {
        let L = &self.filters;
        let measured = L.B.columns(0, 1).into_owned();
        let applied = L.B.columns(1, 1).into_owned();
        let through = L.D[(0, 0)];
        StateSpace {
            A: &L.A + &applied * &L.C,
            B: measured + applied * through,
            C: -&L.C,
            D: Mat::from_element(1, 1, -through),
            time: L.time,
        }
    }
}

/// S = F/(alpha D_p) in the plant's own shifted time axis.
fn numerator(plant: &HalfPlane, alpha: &Uncertainty, interpolant: &Interpolant) -> Result<StateSpace, Error> {
    let weight = inverse(alpha.zpk());
    let mut S = interpolant.function.clone();
    S.zeros.extend(weight.zeros);
    S.poles.extend(weight.poles);
    S.gain *= weight.gain;
    match plant.shifted.time {
        Time::Continuous => Ok(S.to_state_space(Time::Continuous)?),
        Time::Sampled { period_s } => {
            // D is monic in z; B_p is monic in w. Their ratio is the product of |p| over the unstable poles.
            let half = period_s / 2.0;
            let z_of_w = |w: C64| (w * half + 1.0) / (-(w * half) + 1.0);
            let ratio: f64 = plant.unstable_poles().into_iter().map(|w| z_of_w(w).norm()).product();
            S.gain /= ratio;
            Ok(sampling::from_w(&S.to_state_space(Time::Continuous)?, period_s)?)
        }
    }
}

/// Reflection at the boundary of stability.
fn mirror(p: C64, time: Time) -> C64 {
    match time {
        Time::Continuous => -p.conj(),
        Time::Sampled { .. } => p.conj().inv(),
    }
}

/// States (x_g, x_s): the plant's stable part driven by u_applied, then S.
fn join(S: &StateSpace, stable: &StateSpace, antistable: &StateSpace) -> Result<StateSpace, Error> {
    let (n_g, n_s) = (stable.order(), S.order());
    // As X - X A+ + Bs C+ = 0 cuts the antistable part off.
    let X = sylvester(&S.A, &-&antistable.A, &-(&S.B * &antistable.C))?;
    let mut A = Mat::zeros(n_g + n_s, n_g + n_s);
    A.view_mut((0, 0), (n_g, n_g)).copy_from(&stable.A);
    A.view_mut((n_g, 0), (n_s, n_g)).copy_from(&(&S.B * &stable.C));
    A.view_mut((n_g, n_g), (n_s, n_s)).copy_from(&S.A);
    let mut B = Mat::zeros(n_g + n_s, 2);
    B.view_mut((n_g, 0), (n_s, 1)).copy_from(&-&S.B);
    B.view_mut((0, 1), (n_g, 1)).copy_from(&stable.B);
    B.view_mut((n_g, 1), (n_s, 1)).copy_from(&-(X * &antistable.B));
    let mut C = Mat::zeros(1, n_g + n_s);
    C.view_mut((0, 0), (1, n_g)).copy_from(&(&S.D * &stable.C));
    C.view_mut((0, n_g), (1, n_s)).copy_from(&S.C);
    let mut D = Mat::zeros(1, 2);
    D[(0, 0)] = -S.D[(0, 0)];
    Ok(StateSpace::new(A, B, C, D, S.time)?)
}
