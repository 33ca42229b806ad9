//! Rational functions by coefficients, highest power first.
//!
//! Enters: numerator and denominator. Leaves: values, roots, a state space. Absent: arithmetic of rational functions
//! (connect state spaces instead: sums of polynomials lose digits that nothing brings back).

use crate::equilibration::equilibrated;
use crate::generalised::generalised_eigenvalues;
use crate::{C64, Error, Mat, StateSpace, Time};

/// num(s) / den(s), coefficients highest power first, no leading zeros.
#[derive(Clone, Debug, PartialEq)]
pub struct Rational {
    /// Numerator; `[0.0]` for the zero function.
    pub num: Vec<f64>,
    /// Denominator; its first coefficient is not zero.
    pub den: Vec<f64>,
}

impl Rational {
    /// Leading zeros are dropped.
    ///
    /// Errors: [`Error::NotFinite`], [`Error::ZeroDenominator`]. An empty numerator is the zero function.
    pub fn new(num: Vec<f64>, den: Vec<f64>) -> Result<Rational, Error> {
        expect_finite("numerator", &num)?;
        expect_finite("denominator", &den)?;
        let (num, den) = (without_leading_zeros(num), without_leading_zeros(den));
        if den == [0.0] {
            return Err(Error::ZeroDenominator);
        }
        Ok(Rational { num, den })
    }

    /// num(s) / den(s); infinite where den(s) is zero.
    ///
    /// Numerics: Horner; for |s| > 1 in powers of 1/s, so that no power overflows.
    pub fn at(&self, s: C64) -> C64 {
        let den = scaled_horner(&self.den, s);
        if den == C64::ZERO {
            return C64::new(f64::INFINITY, 0.0);
        }
        let excess = self.num.len() as i32 - self.den.len() as i32;
        let power = if s.norm() > 1.0 { s.powi(excess) } else { C64::ONE };
        scaled_horner(&self.num, s) / den * power
    }

    /// Roots of the numerator.
    ///
    /// Errors, numerics: as [`Rational::poles`].
    pub fn zeros(&self) -> Result<Vec<C64>, Error> {
        roots(&self.num)
    }

    /// Roots of the denominator, real or in exact conjugate pairs.
    ///
    /// Errors: [`Error::NotConverged`].
    /// Numerics: QZ of the balanced companion pencil, which needs no division by the first coefficient; roots at 0 are exact.
    pub fn poles(&self) -> Result<Vec<C64>, Error> {
        roots(&self.den)
    }

    /// A state space with this function: controller form, states rescaled by powers of two.
    ///
    /// Errors: [`Error::Improper`], [`Error::Period`].
    /// Numerics: only the division by the first coefficient and, with as many zeros as poles, one subtraction round.
    pub fn to_state_space(&self, time: Time) -> Result<StateSpace, Error> {
        let (zeros, n) = (self.num.len() - 1, self.den.len() - 1);
        if zeros > n {
            return Err(Error::Improper { zeros, poles: n });
        }
        let monic = |a: f64| a / self.den[0];
        let mut b = vec![0.0; n - zeros];
        b.extend(self.num.iter().copied().map(monic));
        let a: Vec<f64> = self.den.iter().copied().map(monic).collect();
        let A = Mat::from_fn(n, n, |i, j| if i == 0 { -a[j + 1] } else { f64::from(i == j + 1) });
        let B = Mat::from_fn(n, 1, |i, _| f64::from(i == 0));
        let C = Mat::from_fn(1, n, |_, j| b[j + 1] - b[0] * a[j + 1]);
        Ok(equilibrated(&StateSpace::new(A, B, C, Mat::from_element(1, 1, b[0]), time)?))
    }
}

/// Roots of p(s), highest power first.
fn roots(p: &[f64]) -> Result<Vec<C64>, Error> {
    let at_origin = p.iter().rev().take_while(|a| **a == 0.0).count().min(p.len() - 1);
    let p = &p[..p.len() - at_origin];
    let n = p.len() - 1;
    let A = Mat::from_fn(n, n, |i, j| if i == 0 { -p[j + 1] } else { f64::from(i == j + 1) });
    let B = Mat::from_fn(n, n, |i, j| f64::from(i == j) * if i == 0 { p[0] } else { 1.0 });
    let mut roots = vec![C64::ZERO; at_origin];
    roots.extend(generalised_eigenvalues(&A, &B)?.iter().filter_map(|e| e.finite()));
    Ok(roots)
}

/// p(s), or p(s) / s^degree for |s| > 1.
fn scaled_horner(p: &[f64], s: C64) -> C64 {
    let step = |x: C64, t: C64, a: &f64| x * t + a;
    if s.norm() > 1.0 {
        p.iter().rev().fold(C64::ZERO, |x, a| step(x, s.inv(), a))
    } else {
        p.iter().fold(C64::ZERO, |x, a| step(x, s, a))
    }
}

fn without_leading_zeros(p: Vec<f64>) -> Vec<f64> {
    match p.iter().position(|a| *a != 0.0) {
        Some(first) => p[first..].to_vec(),
        None => vec![0.0],
    }
}

fn expect_finite(what: &'static str, p: &[f64]) -> Result<(), Error> {
    match p.iter().position(|a| !a.is_finite()) {
        None => Ok(()),
        Some(k) => Err(Error::NotFinite { what, row: 1, column: k + 1, value: p[k] }),
    }
}
