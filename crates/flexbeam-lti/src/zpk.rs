//! Rational functions by zeros, poles and gain.
//!
//! Enters: roots and a gain, or a system. Leaves: values, a state space. Absent: coefficients (see `rational`).

use crate::connections::series;
use crate::equilibration::equilibrated;
use crate::state_space::expect_shape;
use crate::zeros::{invariant_zeros, normal_rank};
use crate::{C64, CMat, Error, Mat, Rational, StateSpace, Time};

/// Two roots within this relative distance of conjugates are a pair, and one within it of the real axis is real: what a
/// text file or an eigenvalue routine leaves of exact conjugates.
const CONJUGATE: f64 = 1e-10;

/// Points tried for the gain: circles, relative to the root of largest modulus, ..
const RADII: [f64; 7] = [0.01, 0.05, 0.2, 0.5, 0.9, 1.4, 3.0];
/// .. and directions on them.
const ANGLES_RAD: [f64; 4] = [0.0, 0.7, 1.3, 2.2];

/// gain (s - z1)(s - z2).. / ((s - p1)(s - p2)..)
#[derive(Clone, Debug, PartialEq)]
pub struct Zpk {
    /// Zeros.
    pub zeros: Vec<C64>,
    /// Poles.
    pub poles: Vec<C64>,
    /// Quotient of the leading coefficients.
    pub gain: f64,
}

impl Zpk {
    /// Zeros, poles and gain of a system with one input and one output; hidden modes appear in zeros and poles alike.
    ///
    /// Errors: [`Error::Shape`] for other sizes, [`Error::NotConverged`].
    /// Numerics: zeros by [`invariant_zeros`]; the gain from G(s) at the point where it is least sensitive to rounding.
    pub fn from_state_space(system: &StateSpace) -> Result<Zpk, Error> {
        expect_shape("zeros, poles and gain: D", &system.D, 1, 1)?;
        let poles = system.poles();
        if normal_rank(system) == 0 {
            return Ok(Zpk { zeros: Vec::new(), poles, gain: 0.0 });
        }
        let unit = Zpk { zeros: invariant_zeros(system)?, poles, gain: 1.0 };
        let gain = unit.gain_of(&equilibrated(system));
        Ok(Zpk { gain, ..unit })
    }

    /// Re G(s) / self(s) at the best of some points between the roots.
    fn gain_of(&self, system: &StateSpace) -> f64 {
        let roots = || self.zeros.iter().chain(&self.poles);
        let largest = Some(roots().map(|r| r.norm()).fold(0.0, f64::max)).filter(|r| *r > 0.0).unwrap_or(1.0);
        let points = RADII.iter().flat_map(|radius| ANGLES_RAD.map(|angle| C64::from_polar(radius * largest, angle)));
        // The roots themselves are known to rounding of the largest.
        let nearness = |s: C64| -> f64 { roots().map(|r| largest / (s - r).norm()).sum() };
        let tries =
            points.filter_map(|s| value_and_cancellation(system, s).map(|(G, lost)| (s, G, lost + nearness(s))));
        let best = tries.min_by(|a, b| a.2.total_cmp(&b.2));
        best.map_or(0.0, |(s, G, _)| (G / self.at(s)).re)
    }

    /// The function's value; infinite at a pole.
    pub fn at(&self, s: C64) -> C64 {
        if self.gain != 0.0 && self.poles.contains(&s) {
            return C64::new(f64::INFINITY, 0.0);
        }
        // One zero and one pole at a time: the product of all zeros alone may overflow.
        let factor = |roots: &[C64], k: usize| roots.get(k).map_or(C64::ONE, |r| s - r);
        let count = self.zeros.len().max(self.poles.len());
        (0..count).fold(C64::from(self.gain), |x, k| x * factor(&self.zeros, k) / factor(&self.poles, k))
    }

    /// G'(s)/G(s), the sum of 1/(s - z) over the zeros less that over the poles; infinite at either.
    pub fn logarithmic_derivative(&self, s: C64) -> C64 {
        let sum = |roots: &[C64]| roots.iter().map(|r| (s - r).inv()).sum::<C64>();
        sum(&self.zeros) - sum(&self.poles)
    }

    /// The same function by its coefficients.
    ///
    /// Assumes: roots closed under conjugation.
    /// Errors: those of [`Rational::new`].
    /// Numerics: products of (s - root), one at a time; coefficients of high degree carry less than the roots did.
    ///
    /// ```
    /// use flexbeam_lti::{C64, Zpk};
    /// let pair = vec![C64::new(-1.0, 2.0), C64::new(-1.0, -2.0)];
    /// let G = Zpk { zeros: vec![C64::new(-20.0, 0.0)], poles: pair, gain: 0.5 };
    /// assert_eq!(G.rational().unwrap().num, [0.5, 10.0]);
    /// assert_eq!(G.rational().unwrap().den, [1.0, 2.0, 5.0]);
    /// ```
    pub fn rational(&self) -> Result<Rational, Error> {
        let num = polynomial(&self.zeros).into_iter().map(|c| c * self.gain).collect();
        Rational::new(num, polynomial(&self.poles))
    }

    /// A real state space with this function: sections of first and second order in a row.
    ///
    /// Errors: [`Error::Improper`], [`Error::NotConjugate`], [`Error::Period`].
    /// Numerics: each pole stands in a block of its own, so all poles keep their digits whatever their number; zeros go to
    /// the nearest poles.
    pub fn to_state_space(&self, time: Time) -> Result<StateSpace, Error> {
        if self.zeros.len() > self.poles.len() {
            return Err(Error::Improper { zeros: self.zeros.len(), poles: self.poles.len() });
        }
        let (zeros, poles) = (Roots::new("zero", &self.zeros)?, Roots::new("pole", &self.poles)?);
        let mut system = StateSpace::static_gain(Mat::from_element(1, 1, self.gain), time)?;
        for section in sections(zeros, poles) {
            system = series(&system, &section.to_state_space(time)?)?;
        }
        Ok(equilibrated(&system))
    }
}

/// G(s), and how much larger its terms are than itself.
fn value_and_cancellation(system: &StateSpace, s: C64) -> Option<(C64, f64)> {
    let (n, D) = (system.order(), system.D[0]);
    let (mut G, mut terms) = (C64::from(D), D.abs());
    if n > 0 {
        let pencil = CMat::from_diagonal_element(n, n, s) - system.A.map(C64::from);
        let X = pencil.lu().solve(&system.B.map(C64::from))?;
        for (c, x) in system.C.iter().zip(X.iter()) {
            G += x * *c;
            terms += x.norm() * c.abs();
        }
    }
    Some((G, terms / G.norm())).filter(|(_, lost)| lost.is_finite())
}

/// prod (s - root), highest power first.
fn polynomial(roots: &[C64]) -> Vec<f64> {
    let mut coefficients = vec![C64::ONE];
    for root in roots {
        coefficients.push(C64::ZERO);
        for k in (1..coefficients.len()).rev() {
            let above = coefficients[k - 1];
            coefficients[k] -= above * root;
        }
    }
    coefficients.into_iter().map(|c| c.re).collect()
}

/// Real roots, and one of each conjugate pair: the one above the axis.
struct Roots {
    real: Vec<f64>,
    pairs: Vec<C64>,
}

impl Roots {
    fn new(what: &'static str, roots: &[C64]) -> Result<Roots, Error> {
        let is_real = |r: &C64| r.im.abs() <= CONJUGATE * r.norm();
        let real = roots.iter().filter(|r| is_real(r)).map(|r| r.re).collect();
        let mut below: Vec<C64> = roots.iter().copied().filter(|r| !is_real(r) && r.im < 0.0).collect();
        let mut pairs = Vec::new();
        for &value in roots.iter().filter(|r| !is_real(r) && r.im > 0.0) {
            let partner =
                nearest(&below, value.conj()).filter(|&k| (below[k].conj() - value).norm() <= CONJUGATE * value.norm());
            below.swap_remove(partner.ok_or(Error::NotConjugate { what, value })?);
            pairs.push(value);
        }
        match below.first() {
            Some(&value) => Err(Error::NotConjugate { what, value }),
            None => Ok(Roots { real, pairs }),
        }
    }

    /// Two real roots, the one nearest to `point` first.
    fn take_two_real(&mut self, point: C64) -> Option<(f64, f64)> {
        if self.real.len() < 2 {
            return None;
        }
        Some((self.take_real(point)?, self.take_real(point)?))
    }

    fn take_real(&mut self, point: C64) -> Option<f64> {
        let k = nearest(&self.real.iter().map(|r| C64::from(*r)).collect::<Vec<_>>(), point)?;
        Some(self.real.swap_remove(k))
    }

    fn take_pair(&mut self, point: C64) -> Option<C64> {
        nearest(&self.pairs, point).map(|k| self.pairs.swap_remove(k))
    }
}

fn nearest(roots: &[C64], point: C64) -> Option<usize> {
    (0..roots.len()).min_by(|&i, &k| (roots[i] - point).norm().total_cmp(&(roots[k] - point).norm()))
}

/// Pairs of zeros first: they alone need a section of second order.
fn sections(mut zeros: Roots, mut poles: Roots) -> Vec<Section> {
    let mut sections = Vec::new();
    while let Some(z) = zeros.pairs.pop() {
        sections.push(match poles.take_pair(z) {
            Some(p) => Section::Pair(p, Numerator::Pair(z)),
            None => {
                let (p, q) = poles.take_two_real(z).expect("a proper function has two poles for each pair of zeros");
                Section::TwoReal(p, q, Numerator::Pair(z))
            }
        });
    }
    while let Some(p) = poles.pairs.pop() {
        let numerator = match zeros.take_two_real(p) {
            Some((z, w)) => Numerator::TwoReal(z, w),
            None => zeros.take_real(p).map_or(Numerator::One, Numerator::Real),
        };
        sections.push(Section::Pair(p, numerator));
    }
    while let Some(p) = poles.real.pop() {
        sections.push(Section::Real(p, zeros.take_real(C64::from(p)).map_or(Numerator::One, Numerator::Real)));
    }
    sections
}

enum Numerator {
    One,
    Real(f64),
    TwoReal(f64, f64),
    /// The zero above the axis and its conjugate.
    Pair(C64),
}

impl Numerator {
    /// Coefficients n of n0 + n1 (s - c) + n2 (s - c)^2, from the distances between c and the zeros.
    fn about(&self, c: f64) -> [f64; 3] {
        match self {
            Numerator::One => [1.0, 0.0, 0.0],
            Numerator::Real(z) => [c - z, 1.0, 0.0],
            Numerator::TwoReal(z, w) => [(c - z) * (c - w), (c - z) + (c - w), 1.0],
            Numerator::Pair(z) => [(c - z.re).powi(2) + z.im.powi(2), 2.0 * (c - z.re), 1.0],
        }
    }
}

/// Real poles p, or the pole p above the axis and its conjugate.
enum Section {
    Real(f64, Numerator),
    TwoReal(f64, f64, Numerator),
    Pair(C64, Numerator),
}

impl Section {
    fn to_state_space(&self, time: Time) -> Result<StateSpace, Error> {
        match self {
            Section::Real(p, numerator) => {
                let [n0, n1, _] = numerator.about(*p);
                section(&[*p], &[n0], n1, time)
            }
            // States 1/(s - p) and 1/((s - p)(s - q)).
            Section::TwoReal(p, q, numerator) => {
                let [n0, n1, n2] = numerator.about(*q);
                section(&[*p, 0.0, 1.0, *q], &[n1 + n2 * (p - q), n0], n2, time)
            }
            // States (s - re)/d and im/d with d = (s - re)^2 + im^2.
            Section::Pair(p, numerator) => {
                let [n0, n1, n2] = numerator.about(p.re);
                section(&[p.re, -p.im, p.im, p.re], &[n1, (n0 - n2 * p.im * p.im) / p.im], n2, time)
            }
        }
    }
}

/// The input drives the first state.
fn section(A: &[f64], C: &[f64], D: f64, time: Time) -> Result<StateSpace, Error> {
    let n = C.len();
    let B = Mat::from_fn(n, 1, |i, _| f64::from(i == 0));
    StateSpace::new(Mat::from_row_slice(n, n, A), B, Mat::from_row_slice(1, n, C), Mat::from_element(1, 1, D), time)
}
