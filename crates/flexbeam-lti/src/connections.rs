//! Systems made of systems: series, parallel, feedback, inverse, side by side, and a choice of channels.
//!
//! Enters: systems on one time axis. Leaves: a system. Absent: cancellation of states (see `minimal`).

use crate::blocks::{beside, blocks, diagonal, stack};
use crate::state_space::expect_shape;
use crate::{Error, Mat, StateSpace};

/// Least singular value, relative to the size of the terms, with which I + D_K D_G or D counts as regular: below it the
/// answer has no digit.
const REGULAR: f64 = 16.0 * f64::EPSILON;

/// second(s) first(s): `first`'s outputs drive `second`'s inputs.
///
/// Shapes: `second` has as many inputs as `first` has outputs. States: [first; second].
/// Errors: [`Error::Shape`], [`Error::TimeMismatch`].
pub fn series(first: &StateSpace, second: &StateSpace) -> Result<StateSpace, Error> {
    let time = first.time.common(second.time)?;
    expect_shape("series: D of the second", &second.D, second.outputs(), first.outputs())?;
    let A = blocks(&first.A, &Mat::zeros(first.order(), second.order()), &(&second.B * &first.C), &second.A);
    let B = stack(&first.B, &(&second.B * &first.D));
    let C = beside(&(&second.D * &first.C), &second.C);
    StateSpace::new(A, B, C, &second.D * &first.D, time)
}

/// left(s) + right(s): common inputs, outputs added.
///
/// Shapes: equal inputs and outputs. States: [left; right].
/// Errors: [`Error::Shape`], [`Error::TimeMismatch`].
pub fn parallel(left: &StateSpace, right: &StateSpace) -> Result<StateSpace, Error> {
    let time = left.time.common(right.time)?;
    expect_shape("parallel: D of the second", &right.D, left.outputs(), left.inputs())?;
    let A = diagonal(&left.A, &right.A);
    StateSpace::new(A, stack(&left.B, &right.B), beside(&left.C, &right.C), &left.D + &right.D, time)
}

/// (I + G K)^-1 G: from u to y with y = G (u - K y). Negative feedback.
///
/// Shapes: G l x m, K m x l; result l x m. States: [G; K].
/// Errors: [`Error::Shape`], [`Error::TimeMismatch`]; [`Error::AlgebraicLoop`] when I + D_K D_G is singular.
/// Numerics: one LU of I + D_K D_G; exact copies when D_K D_G = 0.
pub fn feedback(G: &StateSpace, K: &StateSpace) -> Result<StateSpace, Error> {
    let time = G.time.common(K.time)?;
    expect_shape("feedback: D of K", &K.D, G.inputs(), G.outputs())?;
    let loop_gain = Mat::identity(G.inputs(), G.inputs()) + &K.D * &G.D;
    let singular = |reciprocal_condition| Error::AlgebraicLoop { reciprocal_condition };
    // e = u - K y at the input of G: (I + D_K D_G) e = u - D_K C_G x_G - C_K x_K.
    let drive = beside(&beside(&(-&K.D * &G.C), &-&K.C), &Mat::identity(G.inputs(), G.inputs()));
    let e = regular_solve(&loop_gain, 1.0 + (&K.D * &G.D).norm(), &drive).map_err(singular)?;
    let (states, m) = (G.order() + K.order(), G.inputs());
    let (e_x, e_u) = (e.columns(0, states).into_owned(), e.columns(states, m).into_owned());
    let open = diagonal(&G.A, &K.A);
    let mut A = open + stack(&G.B, &(&K.B * &G.D)) * &e_x;
    let mut below = A.view_mut((G.order(), 0), (K.order(), G.order()));
    below += &K.B * &G.C;
    let B = stack(&G.B, &(&K.B * &G.D)) * &e_u;
    let C = beside(&G.C, &Mat::zeros(G.outputs(), K.order())) + &G.D * &e_x;
    StateSpace::new(A, B, C, &G.D * &e_u, time)
}

/// G(s)^-1.
///
/// Shapes: G square, D regular.
/// Errors: [`Error::Shape`] when G is not square, [`Error::SingularFeedthrough`] when D is singular: G^-1 is then not proper.
/// Numerics: two LU solves with D.
pub fn inverse(G: &StateSpace) -> Result<StateSpace, Error> {
    expect_shape("inverse: D", &G.D, G.inputs(), G.inputs())?;
    let m = G.inputs();
    let singular = |reciprocal_condition| Error::SingularFeedthrough { reciprocal_condition };
    // u = D^-1 (y - C x)
    let u = regular_solve(&G.D, G.D.norm(), &beside(&G.C, &Mat::identity(m, m))).map_err(singular)?;
    let (DC, D) = (u.columns(0, G.order()).into_owned(), u.columns(G.order(), m).into_owned());
    StateSpace::new(&G.A - &G.B * &DC, &G.B * &D, -DC, D, G.time)
}

/// diag(upper, lower): both systems side by side, nothing connected.
///
/// Errors: [`Error::TimeMismatch`].
pub fn append(upper: &StateSpace, lower: &StateSpace) -> Result<StateSpace, Error> {
    let time = upper.time.common(lower.time)?;
    StateSpace::new(
        diagonal(&upper.A, &lower.A),
        diagonal(&upper.B, &lower.B),
        diagonal(&upper.C, &lower.C),
        diagonal(&upper.D, &lower.D),
        time,
    )
}

/// The given outputs and inputs, counted from 0, in the given order; repetition is allowed. All states stay.
///
/// Errors: [`Error::NoSuchChannel`].
pub fn select(G: &StateSpace, outputs: &[usize], inputs: &[usize]) -> Result<StateSpace, Error> {
    expect_channels("output", outputs, G.outputs())?;
    expect_channels("input", inputs, G.inputs())?;
    let D = G.D.select_rows(outputs).select_columns(inputs);
    StateSpace::new(G.A.clone(), G.B.select_columns(inputs), G.C.select_rows(outputs), D, G.time)
}

/// X of M X = R, or the least singular value of an M that is singular beside the `size` of its terms.
fn regular_solve(M: &Mat, size: f64, R: &Mat) -> Result<Mat, f64> {
    if M.is_empty() {
        return Ok(R.clone());
    }
    let reciprocal_condition = if size > 0.0 { M.singular_values().min() / size } else { 0.0 };
    if !(reciprocal_condition > REGULAR) {
        return Err(reciprocal_condition);
    }
    M.clone().lu().solve(R).ok_or(reciprocal_condition)
}

fn expect_channels(what: &'static str, channels: &[usize], count: usize) -> Result<(), Error> {
    match channels.iter().find(|&&index| index >= count) {
        None => Ok(()),
        Some(&index) => Err(Error::NoSuchChannel { what, index, count }),
    }
}
