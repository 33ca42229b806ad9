//! Swings of a sampled model: frequency, damping, shape.
//!
//! Enters: a sampled model. Leaves: its oscillating modes. Deliberately absent: real poles, which do not swing.

use flexbeam_lti::{C64, CMat, Mat, StateSpace};

/// Steps of inverse iteration: each gains ten digits.
const INVERSE_STEPS: usize = 3;

/// One swing.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    /// Natural frequency |s|, s = ln z / T [rad/s].
    pub frequency_rad_s: f64,
    /// Damping ratio -Re s/|s|.
    pub damping: f64,
    /// C v of the eigenvector v, outputs scaled to unit rms.
    pub shape: Vec<C64>,
}

impl Mode {
    /// Modal assurance criterion of two shapes, |a* b|^2/(|a|^2 |b|^2): 1 where they are alike, always with one output.
    pub fn assurance(&self, other: &Mode) -> f64 {
        let dot = |a: &[C64], b: &[C64]| a.iter().zip(b).map(|(a, b)| a.conj() * b).sum::<C64>();
        let size = dot(&self.shape, &self.shape).re * dot(&other.shape, &other.shape).re;
        if size > 0.0 { dot(&self.shape, &other.shape).norm_sqr() / size } else { 0.0 }
    }
}

/// Modes with Im z > 0, by frequency.
pub(crate) fn modes(model: &StateSpace, period_s: f64) -> Vec<Mode> {
    let swings = |z: &C64| {
        let s = z.ln() / period_s;
        let v = model.C.map(C64::from) * eigenvector(&model.A, *z);
        Mode { frequency_rad_s: s.norm(), damping: -s.re / s.norm(), shape: v.iter().copied().collect() }
    };
    let poles = model.poles();
    let mut found: Vec<Mode> = poles.iter().filter(|z| z.im > 0.0).map(swings).collect();
    found.sort_by(|a, b| a.frequency_rad_s.total_cmp(&b.frequency_rad_s));
    found
}

/// v with A v = z v, of unit length, by inverse iteration.
pub(crate) fn eigenvector(A: &Mat, z: C64) -> CMat {
    let n = A.nrows();
    // Beside the eigenvalue, so that the matrix has an inverse.
    let beside = z * (1.0 + f64::EPSILON.powf(0.75));
    let pencil = (A.map(C64::from) - CMat::from_diagonal_element(n, n, beside)).full_piv_lu();
    let mut v = CMat::from_fn(n, 1, |r, _| C64::new(1.0, 0.3 * r as f64));
    for _ in 0..INVERSE_STEPS {
        v = pencil.solve(&v).unwrap_or(v);
        v.unscale_mut(v.norm());
    }
    v
}
