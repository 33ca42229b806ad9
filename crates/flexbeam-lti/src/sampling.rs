//! From continuous to sampled time and back: zero-order hold, with delay; the bilinear w-plane.
//!
//! Enters: systems. Leaves: systems on another time axis. Absent: anti-aliasing filters, which belong to the rig.

use crate::blocks::blocks;
use crate::equilibration::equilibrated;
use crate::exponential::exponential_minus_identity;
use crate::logarithm::logarithm;
use crate::{Error, Mat, StateSpace, Time};

/// A delay within this fraction of a whole number of periods is that number: the rounding of `0.003 / 0.001`, or of a
/// delay that went through a text file, must not cost an extra state.
const WHOLE_PERIODS: f64 = 1e-9;

/// Exact sampled equivalent behind a zero-order hold: x(k+1) = e^(A Ts) x(k) + (integral of e^(A t), 0 to Ts) B u(k).
///
/// Shapes: as the given system.
/// Errors: [`Error::WrongTime`] for a sampled system, [`Error::Period`], [`Error::NotFinite`] when e^(A Ts) overflows.
/// Numerics: one exponential of [A B; 0 0] Ts; entries are accurate relative to themselves.
/// Source: Van Loan 1978, eq. 1.2.
pub fn zoh(system: &StateSpace, period_s: f64) -> Result<StateSpace, Error> {
    zoh_with_delay(system, period_s, 0.0)
}

/// Exact sampled equivalent of the system behind a zero-order hold and a delay of its inputs.
///
/// With delay = q Ts + e, 0 <= e < Ts: x(k+1) = Phi x(k) + Gamma_late u(k-q) + Gamma_early u(k-q-1), and the past inputs
/// become states: [x(k); u(k-1); u(k-2); ..].
///
/// Shapes: n + m ceil(delay/Ts) states. A delay of one period adds m states and m poles at z = 0.
/// Errors: as [`zoh`]; [`Error::Delay`] for a negative or infinite delay.
/// Numerics: as [`zoh`], one exponential for each part of the period.
/// Source: Astrom & Wittenmark 1997, section 2.3.
pub fn zoh_with_delay(system: &StateSpace, period_s: f64, delay_s: f64) -> Result<StateSpace, Error> {
    expect_continuous("zero-order hold", system)?;
    expect_period(period_s)?;
    let (periods, rest_s) = whole_periods(delay_s, period_s)?;
    let late = Hold::new(system, period_s - rest_s);
    if rest_s == 0.0 {
        return behind_past_inputs(late.Phi, &[(periods, late.Gamma)], (periods, &system.D), &system.C, period_s);
    }
    let early = Hold::new(system, rest_s);
    let Gamma_early = &late.Phi * early.Gamma;
    let terms = [(periods, late.Gamma), (periods + 1, Gamma_early)];
    behind_past_inputs(Hold::new(system, period_s).Phi, &terms, (periods + 1, &system.D), &system.C, period_s)
}

/// The continuous system whose zero-order hold equivalent is the given one, with poles in |Im s| < pi/Ts.
///
/// Shapes: as the given system.
/// Errors: [`Error::WrongTime`] for a continuous system; [`Error::NoContinuousEquivalent`] names all poles on the closed
/// negative real axis: such a pole is no e^(p Ts) with real p, and one at 0 is a delay (remove it first);
/// [`Error::NotConverged`].
/// Numerics: logarithm of [Phi Gamma; 0 I]. What sampling has lost, the logarithm cannot bring back: the error is that of
/// the entries over Ts.
/// Source: DESIGN section 5; Higham 2008, section 2.3, for the logarithm.
pub fn inverse_zoh(system: &StateSpace) -> Result<StateSpace, Error> {
    let period_s = expect_sampled("the inverse of the zero-order hold", system)?;
    expect_continuous_equivalent(system)?;
    let (n, m) = (system.order(), system.inputs());
    let change = &system.A - Mat::identity(n, n);
    let scale = power_of_two(system.B.norm() / change.norm());
    let step = blocks(&system.A, &(&system.B / scale), &Mat::zeros(m, n), &Mat::identity(m, m));
    let L = logarithm(&step)? / period_s;
    let (A, B) = (L.view((0, 0), (n, n)).into_owned(), L.view((0, n), (n, m)) * scale);
    StateSpace::new(A, B, system.C.clone(), system.D.clone(), Time::Continuous)
}

/// No pole at 0 or on the negative real axis.
fn expect_continuous_equivalent(system: &StateSpace) -> Result<(), Error> {
    let rounding = f64::EPSILON * system.order() as f64 * equilibrated(system).A.norm();
    let on_axis = |p: &crate::C64| p.norm() <= rounding || (p.im == 0.0 && p.re < 0.0);
    let poles: Vec<f64> = system.poles().iter().filter(|p| on_axis(p)).map(|p| p.re).collect();
    if poles.is_empty() { Ok(()) } else { Err(Error::NoContinuousEquivalent { poles }) }
}

/// The system in the w-plane: z = (1 + w Ts/2)/(1 - w Ts/2), w = (2/Ts)(z - 1)/(z + 1).
///
/// Returns: a system with [`Time::Continuous`] whose value at w is the given one's at z. The unit disk becomes the left half-plane, so
/// norms and Hankel singular values carry over.
/// Errors: [`Error::WrongTime`] for a continuous system, [`Error::MappedPole`] for a pole at z = -1.
/// Numerics: one LU of A + I; B and C share the factor 2/sqrt(Ts).
/// Source: Glover 1984, section 2 (with w Ts/2 in place of s).
pub fn to_w(system: &StateSpace) -> Result<StateSpace, Error> {
    let period_s = expect_sampled("the w-plane", system)?;
    let n = system.order();
    let I = Mat::identity(n, n);
    let pole = || Error::MappedPole { at: -1.0, found: nearest_pole(system, -1.0) };
    let plus = invertible(&system.A + &I).ok_or_else(pole)?;
    let A = solve(&plus, &(&system.A - &I)).ok_or_else(pole)? * (2.0 / period_s);
    let XB = solve(&plus, &system.B).ok_or_else(pole)?;
    let CX = solve(&plus.transpose(), &system.C.transpose()).ok_or_else(pole)?.transpose();
    let root = 2.0 / period_s.sqrt();
    let D = &system.D - &system.C * &XB;
    StateSpace::new(A, XB * root, CX * root, D, Time::Continuous)
}

/// The system whose image in the w-plane is the given one: inverse of [`to_w`].
///
/// Errors: [`Error::WrongTime`] for a sampled system, [`Error::Period`], [`Error::MappedPole`] for a pole at w = 2/Ts.
/// Numerics: one LU of I - A Ts/2.
pub fn from_w(system: &StateSpace, period_s: f64) -> Result<StateSpace, Error> {
    expect_continuous("the way back from the w-plane", system)?;
    expect_period(period_s)?;
    let n = system.order();
    let I = Mat::identity(n, n);
    let half = &system.A * (period_s / 2.0);
    let at = 2.0 / period_s;
    let pole = || Error::MappedPole { at, found: nearest_pole(system, at) };
    let minus = invertible(&I - &half).ok_or_else(pole)?;
    let A = solve(&minus, &(&I + &half)).ok_or_else(pole)?;
    let XB = solve(&minus, &system.B).ok_or_else(pole)?;
    let CX = solve(&minus.transpose(), &system.C.transpose()).ok_or_else(pole)?.transpose();
    let D = &system.D + &system.C * &XB * (period_s / 2.0);
    let root = period_s.sqrt();
    StateSpace::new(A, XB * root, CX * root, D, Time::Sampled { period_s })
}

/// Phi = e^(A t) and Gamma = (integral of e^(A s), 0 to t) B.
struct Hold {
    Phi: Mat,
    Gamma: Mat,
}

impl Hold {
    fn new(system: &StateSpace, t_s: f64) -> Hold {
        let (n, m) = (system.order(), system.inputs());
        // Gamma is linear in B: a large B alone would ask for more halvings.
        let scale = power_of_two(system.B.norm() / system.A.norm());
        let mut M = Mat::zeros(n + m, n + m);
        M.view_mut((0, 0), (n, n)).copy_from(&(&system.A * t_s));
        M.view_mut((0, n), (n, m)).copy_from(&(&system.B * (t_s / scale)));
        let E = exponential_minus_identity(&M);
        Hold { Phi: E.view((0, 0), (n, n)) + Mat::identity(n, n), Gamma: E.view((0, n), (n, m)) * scale }
    }
}

/// The power of two next to x; 1 where there is none.
fn power_of_two(x: f64) -> f64 {
    if x.is_normal() { x.log2().round().exp2() } else { 1.0 }
}

/// delay = periods * Ts + rest, 0 <= rest < Ts.
fn whole_periods(delay_s: f64, period_s: f64) -> Result<(usize, f64), Error> {
    if !(delay_s >= 0.0 && delay_s.is_finite()) {
        return Err(Error::Delay { delay_s });
    }
    let ratio = delay_s / period_s;
    if (ratio - ratio.round()).abs() <= WHOLE_PERIODS * ratio.max(1.0) {
        return Ok((ratio.round() as usize, 0.0));
    }
    Ok((ratio.floor() as usize, delay_s - ratio.floor() * period_s))
}

/// x(k+1) = Phi x(k) + sum Gamma_i u(k - i), y(k) = C x(k) + D u(k - d), past inputs as states.
fn behind_past_inputs(
    Phi: Mat,
    Gamma: &[(usize, Mat)],
    (lag_D, D): (usize, &Mat),
    C: &Mat,
    period_s: f64,
) -> Result<StateSpace, Error> {
    let (n, m, l) = (Phi.nrows(), D.ncols(), D.nrows());
    let lags = Gamma.iter().map(|(lag, _)| *lag).fold(lag_D, usize::max);
    let order = n + m * lags;
    // One matrix over [x; u(k-1); ..; u(k-lags)] and, last, u(k).
    let column = |lag: usize| if lag == 0 { order } else { n + m * (lag - 1) };
    let mut step = Mat::zeros(order + l, order + m);
    step.view_mut((0, 0), (n, n)).copy_from(&Phi);
    for (lag, G) in Gamma {
        step.view_mut((0, column(*lag)), (n, m)).copy_from(G);
    }
    for lag in 1..=lags {
        step.view_mut((column(lag), column(lag - 1)), (m, m)).fill_with_identity();
    }
    step.view_mut((order, 0), (l, n)).copy_from(C);
    step.view_mut((order, column(lag_D)), (l, m)).copy_from(D);
    StateSpace::new(
        step.view((0, 0), (order, order)).into_owned(),
        step.view((0, order), (order, m)).into_owned(),
        step.view((order, 0), (l, order)).into_owned(),
        step.view((order, order), (l, m)).into_owned(),
        Time::Sampled { period_s },
    )
}

/// M, unless it is singular to working precision.
fn invertible(M: Mat) -> Option<Mat> {
    if M.is_empty() {
        return Some(M);
    }
    let sigma = M.singular_values();
    (sigma.min() > sigma.max() * f64::EPSILON).then_some(M)
}

fn solve(M: &Mat, X: &Mat) -> Option<Mat> {
    if M.is_empty() { Some(X.clone()) } else { M.clone().lu().solve(X) }
}

fn nearest_pole(system: &StateSpace, point: f64) -> crate::C64 {
    let poles = system.poles().into_iter();
    let distance = |p: &crate::C64| (p - point).norm();
    poles.min_by(|p, q| distance(p).total_cmp(&distance(q))).expect("a system without states has no pole to be near")
}

fn expect_continuous(what: &'static str, system: &StateSpace) -> Result<(), Error> {
    match system.time {
        Time::Continuous => Ok(()),
        found => Err(Error::WrongTime { what, found, needed: "continuous time" }),
    }
}

fn expect_sampled(what: &'static str, system: &StateSpace) -> Result<f64, Error> {
    match system.time {
        Time::Sampled { period_s } => Ok(period_s),
        found => Err(Error::WrongTime { what, found, needed: "sampled time" }),
    }
}

fn expect_period(period_s: f64) -> Result<(), Error> {
    if period_s > 0.0 && period_s.is_finite() { Ok(()) } else { Err(Error::Period { period_s }) }
}
