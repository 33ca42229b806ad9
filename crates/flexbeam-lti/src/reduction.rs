//! Balanced truncation.
//!
//! Enters: a stable system and an order. Leaves: a system of that order, and how far it may be off.
//! Deliberately absent: frequency weights, unstable systems (take the stable part first).

use crate::gramian::{controllability_factor, observability_factor};
use crate::{Error, Mat, StateSpace};

/// Hankel singular values below this part of the largest are rounding: their states cannot be kept.
const MINIMAL: f64 = f64::EPSILON;

/// A system of lower order.
#[derive(Clone, Debug, PartialEq)]
pub struct Reduced {
    /// Stable, balanced: both Gramians are the diagonal of the values kept.
    pub system: StateSpace,
    /// Hankel singular values of the full system, descending.
    pub singular_values: Vec<f64>,
    /// No gain of the difference exceeds this: twice the sum of the values left out.
    pub bound: f64,
}

/// The `order` states that carry most from input to output.
///
/// Errors: [`Error::WrongSide`], [`Error::BoundaryPole`] for a pole that is not stable; [`Error::Order`] when the system has fewer
/// states, or fewer that differ from rounding; those of [`controllability_factor`].
/// Numerics: square-root method, no balancing of the whole; O(n^3).
/// Source: Tombs and Postlethwaite 1987; Enns 1984 and Glover 1984 for the bound; Al-Saggaf and Franklin 1987 in sampled time.
pub fn balanced_truncation(G: &StateSpace, order: usize) -> Result<Reduced, Error> {
    let (L_P, L_Q) = (controllability_factor(G)?, observability_factor(G)?);
    if order > G.order() {
        return Err(Error::Order { asked: order, available: G.order() });
    }
    if G.order() == 0 {
        return Ok(Reduced { system: G.clone(), singular_values: Vec::new(), bound: 0.0 });
    }
    let svd = L_Q.tr_mul(&L_P).svd(true, true);
    let singular_values: Vec<f64> = svd.singular_values.iter().copied().collect();
    expect_kept(&singular_values, order)?;
    let (U, Vt) = (svd.u.expect("asked for"), svd.v_t.expect("asked for"));
    let left = halved(&(&L_Q * U.columns(0, order)), &singular_values);
    let right = halved(&(&L_P * Vt.rows(0, order).transpose()), &singular_values);
    let (A, B, C) = (left.tr_mul(&(&G.A * &right)), left.tr_mul(&G.B), &G.C * &right);
    let system = StateSpace::new(A, B, C, G.D.clone(), G.time)?;
    let bound = 2.0 * singular_values[order..].iter().sum::<f64>();
    Ok(Reduced { system, singular_values, bound })
}

fn expect_kept(singular_values: &[f64], order: usize) -> Result<(), Error> {
    let available = singular_values.iter().filter(|sigma| **sigma > MINIMAL * singular_values[0]).count();
    if order > available { Err(Error::Order { asked: order, available }) } else { Ok(()) }
}

/// Columns divided by the square roots of the singular values.
fn halved(M: &Mat, singular_values: &[f64]) -> Mat {
    Mat::from_fn(M.nrows(), M.ncols(), |i, j| M[(i, j)] / singular_values[j].sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::{beside, diagonal, stack};
    use crate::draw::Draw;
    use crate::hankel::hankel_singular_values;
    use crate::norm::hinf_norm;
    use crate::{C64, Time};

    fn difference(G: &StateSpace, H: &StateSpace) -> StateSpace {
        let (A, B, C) = (diagonal(&G.A, &H.A), stack(&G.B, &H.B), beside(&G.C, &-&H.C));
        StateSpace::new(A, B, C, &G.D - &H.D, G.time).unwrap()
    }

    fn random(draw: &mut Draw, n: usize, time: Time) -> StateSpace {
        let A = match time {
            Time::Continuous => draw.stable(n, 0.05),
            Time::Sampled { .. } => draw.matrix(n, n) * (0.9 / (n as f64).sqrt()),
        };
        StateSpace::new(A, draw.matrix(n, 2), draw.matrix(2, n), draw.matrix(2, 2), time).unwrap()
    }

    #[test]
    fn the_bound_holds_and_the_kept_values_stay() {
        let mut draw = Draw(71);
        for time in [Time::Continuous, Time::Sampled { period_s: 0.5 }] {
            for n in [1, 2, 6, 12] {
                let G = random(&mut draw, n, time);
                for order in 0..n {
                    let reduced = balanced_truncation(&G, order).unwrap();
                    assert_eq!(reduced.system.order(), order);
                    let error = hinf_norm(&difference(&G, &reduced.system)).unwrap().norm;
                    assert!(error <= reduced.bound * (1.0 + 1e-9), "{n} -> {order}: {error} {}", reduced.bound);
                    // Never below the first value left out: no system of that order is nearer (Glover 1984).
                    assert!(error >= reduced.singular_values[order] * (1.0 - 1e-6), "{n} -> {order}: {error}");
                }
            }
        }
    }

    #[test]
    fn one_state_left_out_of_a_scalar_system_meets_the_bound() {
        // All-pole lag in two well separated states, same sign: the bound is attained at w = 0.
        let A = Mat::from_row_slice(2, 2, &[-1.0, 0.0, 0.0, -30.0]);
        let one = Mat::from_element(2, 1, 1.0);
        let G = StateSpace::new(A, one.clone(), one.transpose(), Mat::zeros(1, 1), Time::Continuous).unwrap();
        let reduced = balanced_truncation(&G, 1).unwrap();
        let error = hinf_norm(&difference(&G, &reduced.system)).unwrap();
        assert!((error.norm / reduced.bound - 1.0).abs() < 1e-9, "{error:?} {}", reduced.bound);
    }

    #[test]
    fn nothing_left_out_is_the_same_system_balanced() {
        let mut draw = Draw(72);
        let G = random(&mut draw, 7, Time::Continuous);
        let reduced = balanced_truncation(&G, 7).unwrap();
        assert_eq!(reduced.bound, 0.0);
        for omega in [0.0, 0.3, 2.0] {
            let s = C64::new(0.0, omega);
            assert!((G.at(s) - reduced.system.at(s)).norm() < 1e-10 * G.at(s).norm());
        }
        let P =
            crate::sylvester::lyapunov(&reduced.system.A, &(&reduced.system.B * reduced.system.B.transpose())).unwrap();
        let sigma = Mat::from_diagonal(&crate::Vector::from_vec(reduced.singular_values.clone()));
        assert!((P - &sigma).norm() < 1e-8 * sigma.norm());
    }

    #[test]
    fn fifty_states_to_ten_lightly_damped() {
        let mut draw = Draw(73);
        let mut A = Mat::zeros(50, 50);
        for k in 0..25 {
            let omega = 1.3f64.powi(k as i32);
            A[(2 * k, 2 * k + 1)] = omega;
            A[(2 * k + 1, 2 * k)] = -omega;
            (A[(2 * k, 2 * k)], A[(2 * k + 1, 2 * k + 1)]) = (-1e-4 * omega, -1e-4 * omega);
        }
        let G = StateSpace::new(A, draw.matrix(50, 1), draw.matrix(1, 50), Mat::zeros(1, 1), Time::Continuous).unwrap();
        let reduced = balanced_truncation(&G, 10).unwrap();
        let error = hinf_norm(&difference(&G, &reduced.system)).unwrap().norm;
        assert!(error <= reduced.bound && error >= reduced.singular_values[10]);
        assert!(hankel_singular_values(&reduced.system).unwrap()[0] > 0.99 * reduced.singular_values[0]);
    }

    #[test]
    fn a_state_that_no_input_reaches_cannot_be_kept() {
        let A = Mat::from_row_slice(2, 2, &[-1.0, 0.0, 0.0, -2.0]);
        let (B, C) = (Mat::from_column_slice(2, 1, &[1.0, 0.0]), Mat::from_row_slice(1, 2, &[1.0, 1.0]));
        let G = StateSpace::new(A, B, C, Mat::zeros(1, 1), Time::Continuous).unwrap();
        assert_eq!(balanced_truncation(&G, 2).unwrap_err(), Error::Order { asked: 2, available: 1 });
        assert_eq!(balanced_truncation(&G, 3).unwrap_err(), Error::Order { asked: 3, available: 2 });
        let reduced = balanced_truncation(&G, 1).unwrap();
        assert!(hinf_norm(&difference(&G, &reduced.system)).unwrap().norm < 1e-15);
    }
}
