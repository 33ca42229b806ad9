//! Frequency responses: one reduction to Hessenberg form, then O(n^2) for each point.
//!
//! Enters: a system and frequencies. Leaves: values of G. Absent: plots, decibels, phase unwrapping.

use crate::equilibration::equilibrated;
use crate::{C64, CMat, Error, Mat, StateSpace, Time};

/// A system whose A is an upper Hessenberg matrix H: (H, Q'B, C Q, D).
#[derive(Clone, Debug)]
pub struct Hessenberg {
    system: StateSpace,
}

impl Hessenberg {
    /// Reduces once: states rescaled by powers of two, then Householder reflections; O(n^3).
    pub fn new(system: &StateSpace) -> Hessenberg {
        let mut system = equilibrated(system);
        if system.order() > 0 {
            let (Q, H) = nalgebra::linalg::Hessenberg::new(system.A).unpack();
            system.A = H;
            system.B = Q.tr_mul(&system.B);
            system.C *= Q;
        }
        Hessenberg { system }
    }

    /// G(s) at one point of the s- or z-plane; infinite entries at a pole.
    ///
    /// Numerics: Gaussian elimination of s I - H by columns with partial pivoting, O(n^2 + n l m); backward stable.
    pub fn at(&self, s: C64) -> CMat {
        let StateSpace { A: H, B, C, D, .. } = &self.system;
        let mut M = H.map(|h| C64::from(-h));
        for k in 0..M.nrows() {
            M[(k, k)] += s;
        }
        let mut Z = C.map(C64::from);
        to_triangle(&mut M, &mut Z);
        if !divide_by_triangle(&mut Z, &M) {
            return CMat::from_element(D.nrows(), D.ncols(), C64::new(f64::INFINITY, 0.0));
        }
        D.map(C64::from) + times_real(&Z, B)
    }

    /// G(j omega), or G(e^(j omega Ts)).
    pub fn at_frequency(&self, omega_rad_s: f64) -> CMat {
        self.at(match self.system.time {
            Time::Continuous => C64::new(0.0, omega_rad_s),
            Time::Sampled { period_s } => C64::cis(omega_rad_s * period_s),
        })
    }
}

/// G(j omega), or G(e^(j omega Ts)), at each omega [rad/s].
///
/// Returns: one l x m matrix a frequency, infinite where omega meets a pole.
/// Errors: [`Error::NotFinite`] for a frequency that is infinite or not a number.
/// Numerics: O(n^3) once and O(n^2) a point.
/// Source: Laub 1981.
pub fn frequency_response(system: &StateSpace, omega: &[f64]) -> Result<Vec<CMat>, Error> {
    if let Some(k) = omega.iter().position(|w| !w.is_finite()) {
        return Err(Error::NotFinite { what: "omega", row: 1, column: k + 1, value: omega[k] });
    }
    let reduced = Hessenberg::new(system);
    Ok(omega.iter().map(|w| reduced.at_frequency(*w)).collect())
}

/// Column operations that make the Hessenberg matrix M upper triangular, from its last row up; Z takes part.
fn to_triangle(M: &mut CMat, Z: &mut CMat) {
    for k in (1..M.nrows()).rev() {
        if M[(k, k - 1)].norm_sqr() > M[(k, k)].norm_sqr() {
            M.swap_columns(k - 1, k);
            Z.swap_columns(k - 1, k);
        }
        if M[(k, k - 1)] == C64::ZERO {
            continue;
        }
        let f = M[(k, k - 1)] / M[(k, k)];
        subtract_column(M, k, f, k);
        subtract_column(Z, k, f, Z.nrows());
    }
}

/// Column k-1 less f times column k, in the first `rows` rows.
fn subtract_column(M: &mut CMat, k: usize, f: C64, rows: usize) {
    for i in 0..rows {
        let x = M[(i, k)];
        M[(i, k - 1)] -= f * x;
    }
}

/// Z R^-1 for an upper triangular R; false when R is singular.
fn divide_by_triangle(Z: &mut CMat, R: &CMat) -> bool {
    for j in 0..R.nrows() {
        if R[(j, j)] == C64::ZERO {
            return false;
        }
        for row in 0..Z.nrows() {
            let known: C64 = (0..j).map(|i| Z[(row, i)] * R[(i, j)]).sum();
            Z[(row, j)] = (Z[(row, j)] - known) / R[(j, j)];
        }
    }
    true
}

fn times_real(Z: &CMat, B: &Mat) -> CMat {
    CMat::from_fn(Z.nrows(), B.ncols(), |i, j| (0..B.nrows()).map(|k| Z[(i, k)] * B[(k, j)]).sum())
}
