//! The robust radius: the largest additive perturbation, in units of alpha, that some controller survives.
//!
//! Two roads, always compared: the smallest Hankel singular value of the antistable part of Gbar0/alpha (Glover 1986), and the
//! norm of the Nevanlinna-Pick interpolant (Kimura 1984).

use flexbeam_lti::hankel::antistable_hankel_singular_values;
use flexbeam_lti::split::split;
use flexbeam_lti::sylvester::sylvester;
use flexbeam_lti::{C64, StateSpace, Time, Zpk};

use crate::half_plane::HalfPlane;
use crate::interpolation::Interpolation;
use crate::{Error, Uncertainty};

/// Largest relative disagreement of the two roads that is still rounding: some 1e-16 times the condition of the Cauchy
/// matrix of up to ten poles.
const AGREEMENT: f64 = 1e-8;

/// The radius by both roads.
///
/// Returns `None` when nothing is unstable after the shift: every bound is survived, by u = 0.
/// Errors: [`Error::RadiusDisagreement`] when the two roads part by more than `AGREEMENT`.
/// Source: DESIGN 6.1.
pub fn robust_radius(plant: &HalfPlane, alpha: &Uncertainty) -> Result<Option<f64>, Error> {
    if plant.unstable_poles().is_empty() {
        return Ok(None);
    }
    let hankel = radius_by_hankel(plant, alpha)?;
    let pick = 1.0 / conditions(plant, alpha)?.optimal()?.norm;
    if (hankel - pick).abs() > AGREEMENT * hankel {
        return Err(Error::RadiusDisagreement { hankel, pick, tolerance: AGREEMENT });
    }
    Ok(Some(pick))
}

/// Smallest Hankel singular value of the antistable part of Gbar0/alpha, by state space alone.
///
/// With Gbar0's antistable part (A, B, C) and 1/alpha = (Aa, Ba, Ca, Da), that part is (A, A-image of B under 1/alpha, C):
/// the product's antistable part, from one Sylvester equation.
pub fn radius_by_hankel(plant: &HalfPlane, alpha: &Uncertainty) -> Result<f64, Error> {
    let (antistable, _) = split(&plant.system, |p| p.re > 0.0)?;
    let weighted = weighted_antistable(&antistable, alpha)?;
    let values = antistable_hankel_singular_values(&weighted)?;
    Ok(values.into_iter().fold(f64::INFINITY, f64::min))
}

/// The antistable part of G/alpha for an antistable strictly proper G: the poles are G's, the input matrix (1/alpha)(A) B.
fn weighted_antistable(antistable: &StateSpace, alpha: &Uncertainty) -> Result<StateSpace, Error> {
    let weight = inverse(alpha.zpk()).to_state_space(Time::Continuous)?;
    // u -> weight -> G: the stable states x_a feed B Ca; the change of state x - Y x_a with A Y - Y Aa + B Ca = 0 cuts them off.
    let Y = sylvester(&antistable.A, &-&weight.A, &-(&antistable.B * &weight.C))?;
    let B = &antistable.B * &weight.D - Y * &weight.B;
    let D = flexbeam_lti::Mat::zeros(1, 1);
    Ok(StateSpace::new(antistable.A.clone(), B, antistable.C.clone(), D, Time::Continuous)?)
}

/// 1/alpha.
pub(crate) fn inverse(alpha: &Zpk) -> Zpk {
    Zpk { zeros: alpha.poles.clone(), poles: alpha.zeros.clone(), gain: 1.0 / alpha.gain }
}

/// F(p_i) = alpha(p_i) / (B_p Gbar0)(p_i) at the poles of Gbar0 in Re s > 0.
///
/// W = B_p F/alpha is then the control sensitivity K/(1 + G K) of an internally stable loop.
pub(crate) fn conditions(plant: &HalfPlane, alpha: &Uncertainty) -> Result<Interpolation, Error> {
    let points = plant.unstable_poles();
    let values = (0..points.len()).map(|i| alpha.zpk().at(points[i]) / blaschke_plant(plant, &points, i)).collect();
    Interpolation::new(points, values)
}

/// (B_p Gbar0)(p_i): the residue at p_i times B_p's slope there.
fn blaschke_plant(plant: &HalfPlane, points: &[C64], i: usize) -> C64 {
    let p = points[i];
    let slope = points.iter().enumerate().fold(C64::new(1.0, 0.0), |product, (j, q)| {
        let factor = if j == i { C64::new(1.0, 0.0) } else { p - q };
        product * factor / (p + q.conj())
    });
    residue(&plant.zpk, p) * slope
}

/// lim (s - p) G(s) at a simple pole p of G.
pub(crate) fn residue(G: &Zpk, p: C64) -> C64 {
    let numerator = G.zeros.iter().fold(C64::from(G.gain), |product, z| product * (p - z));
    others(&G.poles, p).fold(numerator, |product, q| product / (p - q))
}

/// d/ds of log((s - p) G(s)) at a simple pole p of G.
pub(crate) fn regular_slope(G: &Zpk, p: C64) -> C64 {
    let zeros: C64 = G.zeros.iter().map(|z| (p - z).inv()).sum();
    let poles: C64 = others(&G.poles, p).map(|q| (p - q).inv()).sum();
    zeros - poles
}

/// All poles but the one at p.
fn others(poles: &[C64], p: C64) -> impl Iterator<Item = &C64> {
    let nearest =
        (0..poles.len()).min_by(|a, b| (poles[*a] - p).norm().total_cmp(&(poles[*b] - p).norm())).unwrap_or(0);
    poles.iter().enumerate().filter(move |(k, _)| *k != nearest).map(|(_, q)| q)
}
