//! Linear simulation of a sampled system, sample by sample.
//!
//! Enters: a sampled system, its input, its first state. Leaves: its output. Absent: the nonlinear rig, continuous
//! time (sample it first: `sampling::zoh` is exact for an input that is held).

use crate::state_space::expect_shape;
use crate::{Error, Mat, StateSpace, Time, Vector};

/// y(k) = C x(k) + D u(k), x(k+1) = A x(k) + B u(k), x(0) = x0.
///
/// Shapes: u m x samples, x0 n; returns l x samples.
/// Errors: [`Error::WrongTime`] for a continuous system, [`Error::Shape`].
/// Numerics: O((n + l)(n + m)) a sample, no allocation within the loop.
pub fn simulate(system: &StateSpace, u: &Mat, x0: &Vector) -> Result<Mat, Error> {
    if system.time == Time::Continuous {
        return Err(Error::WrongTime { what: "simulation", found: system.time, needed: "sampled time" });
    }
    expect_shape("u (rows are inputs)", u, system.inputs(), u.ncols())?;
    expect_shape("x0", &Mat::from_columns(std::slice::from_ref(x0)), system.order(), 1)?;
    let mut y = &system.D * u;
    let mut x = x0.clone();
    let mut next = x0.clone();
    for (u_k, mut y_k) in u.column_iter().zip(y.column_iter_mut()) {
        y_k.gemv(1.0, &system.C, &x, 1.0);
        next.gemv(1.0, &system.A, &x, 0.0);
        next.gemv(1.0, &system.B, &u_k, 1.0);
        std::mem::swap(&mut x, &mut next);
    }
    Ok(y)
}
