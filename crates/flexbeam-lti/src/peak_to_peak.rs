//! How much larger an output can become than the inputs: the sum of an impulse response's magnitudes.
//!
//! Enters: a stable sampled system. Leaves: one gain for each output and input. Deliberately absent: continuous time.

use crate::split::{balanced_states, expect_stable};
use crate::{Error, Mat, StateSpace, Time};

/// Ticks between two looks at what is left.
const LOOK: usize = 64;
/// The sum ends when the powers of A are this small; what is left is then bounded by about as much of the gain.
const LEFT: f64 = 1e-4;
/// Ticks after which the sum is given up: at some twenty states ten seconds.
const LONGEST: usize = 1_000_000;

/// l1 norms of the impulse responses: |D_ij| + sum over k of |(C A^k B)_ij|, the largest |y_i| for any inputs |u_j(k)| <= 1.
///
/// Shapes: l x m, as D.
/// Returns: upper bounds, too large by about 1e-4 at most: the sum over K ticks, and a bound of the rest. With g_ij that sum for
/// B = I, the rest of a column s = A^K B_j is at most max_j g_ij ||s||_1/(1 - ||A^K||_1).
/// Errors: [`Error::WrongTime`]; [`Error::WrongSide`], [`Error::BoundaryPole`] for a pole that is not stable;
/// [`Error::NotConverged`] after a million ticks.
/// Numerics: O(n^2 (n + m + l)) a tick, some ten times the slowest time constant; rounding of the sum itself is not in the bound.
/// Source: Dahleh and Diaz-Bobillo 1995, section 2.3; the rest is bounded as a geometric series of blocks of K ticks.
///
/// ```
/// use flexbeam_lti::{Mat, StateSpace, Time, peak_to_peak::l1_norms};
/// // b/(z - a): b/(1 - |a|).
/// let entry = |x| Mat::from_element(1, 1, x);
/// let G = StateSpace::new(entry(-0.9), entry(0.5), entry(1.0), entry(0.0), Time::Sampled { period_s: 1.0 })?;
/// assert!((l1_norms(&G)?[(0, 0)] - 5.0).abs() < 1e-3);
/// # Ok::<(), flexbeam_lti::Error>(())
/// ```
pub fn l1_norms(G: &StateSpace) -> Result<Mat, Error> {
    if G.time == Time::Continuous {
        return Err(Error::WrongTime { what: "an l1 norm", found: G.time, needed: "sampled time" });
    }
    expect_stable(G)?;
    let G = &balanced_states(G);
    let (mut power, mut states) = (Mat::identity(G.order(), G.order()), G.B.clone());
    let (mut of_states, mut norms) = (Mat::zeros(G.outputs(), G.order()), G.D.abs());
    let (mut row, mut next_power, mut next_states) = (G.D.clone(), power.clone(), states.clone());
    let mut state_row = of_states.clone();
    for k in 1..=LONGEST {
        add_magnitudes(&mut norms, &mut row, &G.C, &states);
        add_magnitudes(&mut of_states, &mut state_row, &G.C, &power);
        G.A.mul_to(&power, &mut next_power);
        G.A.mul_to(&states, &mut next_states);
        std::mem::swap(&mut power, &mut next_power);
        std::mem::swap(&mut states, &mut next_states);
        if k.is_multiple_of(LOOK) && norm_1(&power) <= LEFT {
            return Ok(norms + rest(&of_states, &states, norm_1(&power)));
        }
    }
    Err(Error::NotConverged { what: "the sum of an impulse response", iterations: LONGEST })
}

/// sums += |C X|
fn add_magnitudes(sums: &mut Mat, product: &mut Mat, C: &Mat, X: &Mat) {
    C.mul_to(X, product);
    sums.zip_apply(&*product, |sum, x| *sum += x.abs());
}

/// What the outputs still have to say of each column of `states`.
fn rest(of_states: &Mat, states: &Mat, contraction: f64) -> Mat {
    Mat::from_fn(of_states.nrows(), states.ncols(), |i, j| {
        of_states.row(i).amax() * states.column(j).lp_norm(1) / (1.0 - contraction)
    })
}

/// Largest sum of a column's magnitudes.
fn norm_1(M: &Mat) -> f64 {
    M.column_iter().map(|column| column.lp_norm(1)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Draw;
    use crate::simulation::simulate;
    use crate::{Vector, sampling};

    /// Sampled, three states, two inputs, two outputs, of which the second has states of another size.
    fn drawn(seed: u64) -> StateSpace {
        let mut draw = Draw(seed);
        let A = draw.stable(3, 0.3);
        let (B, C, D) = (draw.matrix(3, 2) * 1e6, draw.matrix(2, 3), draw.matrix(2, 2));
        sampling::zoh(&StateSpace::new(A, B, C, D, Time::Continuous).unwrap(), 0.05).unwrap()
    }

    #[test]
    fn the_worst_input_reaches_the_gain_and_none_exceeds_it() {
        const TICKS: usize = 1500;
        for seed in 0..6 {
            let G = drawn(seed);
            let gains = l1_norms(&G).unwrap();
            let output = |u: &Mat| simulate(&G, u, &Vector::zeros(3)).unwrap();
            for i in 0..2 {
                let responses = [0, 1].map(|j| {
                    let impulse = Mat::from_fn(2, TICKS, |row, k| f64::from(u8::from(row == j && k == 0)));
                    output(&impulse).row(i).into_owned()
                });
                let worst = Mat::from_fn(2, TICKS, |j, k| responses[j][TICKS - 1 - k].signum());
                let (reached, gain) = (output(&worst)[(i, TICKS - 1)], gains.row(i).sum());
                assert!(reached <= gain * (1.0 + 1e-12) && reached >= gain * (1.0 - 1e-3), "{reached} of {gain}");
            }
        }
    }

    #[test]
    fn where_nothing_changes_sign_it_is_the_gain_at_rest() {
        let A = Mat::from_row_slice(2, 2, &[0.999, 0.1, 0.0, 0.9]);
        let B = Mat::from_column_slice(2, 1, &[0.0, 1.0]);
        let C = Mat::from_row_slice(1, 2, &[2.0, 0.0]);
        let D = Mat::from_element(1, 1, 3.0);
        let G = StateSpace::new(A, B, C, D, Time::Sampled { period_s: 0.01 }).unwrap();
        let at_rest = 3.0 + 2.0 * 0.1 / (0.001 * 0.1);
        let gain = l1_norms(&G).unwrap()[(0, 0)];
        assert!(gain >= at_rest * (1.0 - 1e-12) && gain <= at_rest * (1.0 + 1e-3), "{gain} of {at_rest}");
    }

    #[test]
    fn what_has_no_gain_is_refused() {
        let one = |a: f64, time| {
            let entry = |x| Mat::from_element(1, 1, x);
            l1_norms(&StateSpace::new(entry(a), entry(1.0), entry(1.0), entry(0.0), time).unwrap())
        };
        let sampled = Time::Sampled { period_s: 1.0 };
        assert!(matches!(one(1.5, sampled), Err(Error::WrongSide { .. })));
        assert!(matches!(one(-0.5, Time::Continuous), Err(Error::WrongTime { .. })));
        assert!(matches!(one(1.0 - 1e-7, sampled), Err(Error::NotConverged { .. })));
        let gain = StateSpace::static_gain(Mat::from_element(1, 2, -2.0), sampled).unwrap();
        assert_eq!(l1_norms(&gain).unwrap(), Mat::from_element(1, 2, 2.0));
    }
}
