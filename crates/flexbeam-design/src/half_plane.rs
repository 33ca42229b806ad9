//! The nominal plant as (22) sees it: in a half-plane whose axis is the line Re s = -beta.
//!
//! Continuous: Gbar0(s) = G0(s - beta). Sampled: Gbar0(z) = G0(e^(-beta Ts) z), then z = (1 + w Ts/2)/(1 - w Ts/2).

use flexbeam_lti::equilibration::equilibrated;
use flexbeam_lti::{C64, CMat, Mat, StateSpace, Time, Zpk, sampling};

use crate::Error;

/// The shifted plant in the half-plane, as state space and as zeros, poles and gain.
#[derive(Clone, Debug)]
pub struct HalfPlane {
    /// The shifted plant in its own time axis.
    pub shifted: StateSpace,
    /// The same in the half-plane (the w-plane for a sampled plant).
    pub system: StateSpace,
    /// The same as zeros, poles and gain.
    pub zpk: Zpk,
    /// beta [1/s].
    pub beta: f64,
}

/// A pole this close to the axis, relative to the largest pole, cannot be told from one on it: eigenvalues of a balanced
/// matrix carry errors of some 1e-15 of its norm, and poles of lightly damped modes lose two or three digits more.
const ON_AXIS: f64 = 1e-11;

/// beta that is suggested, as a part of the damping of the plant's slowest pole.
const SUGGESTED: f64 = 0.1;

/// A coupling below this, relative to the norms of A and B (or C), is rounding: the singular values of the pencil carry
/// errors of some 1e-16 of its norm. Badly scaled but reachable modes stay well above.
const NO_COUPLING: f64 = 1e-14;

impl HalfPlane {
    /// Shifts the plant by beta and looks for what (22) excludes.
    ///
    /// Errors: [`Error::NotScalar`], [`Error::PoleOnLine`], [`Error::HiddenMode`].
    pub fn new(plant: &StateSpace, beta: f64) -> Result<HalfPlane, Error> {
        let (inputs, outputs) = (plant.inputs(), plant.outputs());
        if (inputs, outputs) != (1, 1) {
            return Err(Error::NotScalar { inputs, outputs });
        }
        let shifted = plant.shifted(beta);
        let system = match plant.time {
            Time::Continuous => shifted.clone(),
            Time::Sampled { .. } => sampling::to_w(&shifted)?,
        };
        let zpk = gauged(Zpk::from_state_space(&system)?, &system);
        let half_plane = HalfPlane { shifted, system, zpk, beta };
        half_plane.expect_axis_free()?;
        half_plane.expect_no_hidden_mode()?;
        Ok(half_plane)
    }

    /// Poles in Re s > 0, the interpolation points of (22).
    pub fn unstable_poles(&self) -> Vec<C64> {
        self.zpk.poles.iter().copied().filter(|p| p.re > 0.0).collect()
    }

    /// The interpolation point that belongs to an integrator, s = 0 before the shift.
    pub fn integrator_point(&self) -> f64 {
        match self.shifted.time {
            Time::Continuous => self.beta,
            Time::Sampled { period_s } => (self.beta * period_s / 2.0).tanh() * 2.0 / period_s,
        }
    }

    fn expect_axis_free(&self) -> Result<(), Error> {
        let scale = self.zpk.poles.iter().map(|p| p.norm()).fold(0.0, f64::max);
        match self.zpk.poles.iter().find(|p| p.re.abs() <= ON_AXIS * scale) {
            None => Ok(()),
            Some(p) => {
                let integrator = self.beta == 0.0 && p.norm() <= ON_AXIS * scale;
                let (limit, suggestion) = if integrator { self.integrator_at_zero(scale) } else { Default::default() };
                Err(Error::PoleOnLine { re: p.re - self.beta, im: p.im, beta: self.beta, limit, suggestion })
            }
        }
    }

    /// beta = 0 with an integrator: what the radius does, and a beta that the slowest of the other poles permits.
    fn integrator_at_zero(&self, scale: f64) -> (String, String) {
        let damping = self.zpk.poles.iter().map(|q| -q.re).filter(|damping| *damping > ON_AXIS * scale);
        let beta = SUGGESTED * damping.fold(f64::INFINITY, f64::min);
        let limit = "; with an integrator the radius grows without bound, as k/(2 beta), when beta goes to 0";
        (limit.into(), format!(": {beta:.3} 1/s suits this plant"))
    }

    /// A pole in Re s > 0 must be reached by the input and seen by the output (Popov-Belevitch-Hautus test).
    fn expect_no_hidden_mode(&self) -> Result<(), Error> {
        // Scaled first: the coupling of a mode must not be told from the units of its states.
        let system = &equilibrated(&self.system);
        for p in system.poles().into_iter().filter(|p| p.re > 0.0) {
            let pencil = CMat::from_diagonal_element(system.order(), system.order(), p) - system.A.map(C64::from);
            let coupling = [
                ("not controllable", smallest_relative(&pencil, &system.B)),
                ("not observable", smallest_relative(&pencil.transpose(), &system.C.transpose())),
            ];
            if let Some((kind, relative_gain)) = coupling.into_iter().find(|(_, gain)| !(*gain > NO_COUPLING)) {
                return Err(Error::HiddenMode {
                    re: p.re - self.beta,
                    im: p.im,
                    line: -self.beta,
                    kind,
                    relative_gain,
                });
            }
        }
        Ok(())
    }
}

/// The gain set where it is used, near the unstable poles: that of the highest frequencies is far below them, and has fewer
/// digits.
fn gauged(mut zpk: Zpk, system: &StateSpace) -> Zpk {
    let farthest = zpk.poles.iter().filter(|p| p.re > 0.0).map(|p| p.norm()).fold(0.0, f64::max);
    if farthest > 0.0 {
        let s = C64::from_polar(GAUGE * farthest, GAUGE_ANGLE);
        zpk.gain *= (system.at(s)[(0, 0)] / zpk.at(s)).re;
    }
    zpk
}

/// Near the poles, and off them.
const GAUGE: f64 = 2.7;

/// Off the real axis, where zeros like to be [rad].
const GAUGE_ANGLE: f64 = 0.7;

/// Smallest singular value of [pencil, B], both brought to norm one.
fn smallest_relative(pencil: &CMat, B: &Mat) -> f64 {
    let n = pencil.ncols();
    let unit = |norm: f64| C64::from(1.0 / norm.max(f64::MIN_POSITIVE));
    let mut joined = (pencil * unit(pencil.norm())).insert_columns(n, B.ncols(), C64::new(0.0, 0.0));
    joined.columns_mut(n, B.ncols()).copy_from(&(B.map(C64::from) * unit(B.norm())));
    joined.svd(false, false).singular_values.min()
}
