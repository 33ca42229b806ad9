//! Integrators apart from the rest: A = diag(A1, A2), A1 upper triangular with ones on its diagonal.
//!
//! Enters: a model whose poles nearest 1 are meant to be 1. Leaves: coordinates in which they are, to the last bit.

use flexbeam_lti::schur::ordered_schur;
use flexbeam_lti::sylvester::sylvester;
use flexbeam_lti::{C64, Mat, StateSpace, Vector};

use crate::Error;

/// A pole nearer to 1 than this is an integrator already, as far as rounding can tell.
const AT_ONE: f64 = 1e-9;

/// A model in block form.
pub(crate) struct BlockForm {
    pub model: StateSpace,
    pub initial_state: Vector,
    /// Farthest that an eigenvalue was moved: above 1e-9, B and D no longer fit.
    pub moved: f64,
}

impl BlockForm {
    pub fn was_moved(&self) -> bool {
        self.moved > AT_ONE
    }
}

/// The `integrators` poles nearest 1, real ones first, become 1 and are split off.
///
/// Errors: [`Error::Order`] for more integrators than states; [`Error::Linear`] when another eigenvalue cannot be told apart.
pub(crate) fn block_form(model: &StateSpace, initial_state: &Vector, integrators: usize) -> Result<BlockForm, Error> {
    let (n, q) = (model.order(), integrators);
    if q > n {
        return Err(Error::Order { order: q, largest: n, reason: "the model has only so many states to integrate" });
    }
    if q == 0 {
        return Ok(BlockForm { model: model.clone(), initial_state: initial_state.clone(), moved: 0.0 });
    }
    let reach = reach(&model.poles(), q);
    let form = ordered_schur(&model.A, |z| farness(z) <= reach)?;
    let mut T = form.T;
    let leading = form.leading.max(q);
    let moved = (0..q).map(|k| (T[(k, k)] - 1.0).abs().max(subdiagonal(&T, k))).fold(0.0, f64::max);
    for c in 0..leading {
        (c + 1..leading).for_each(|r| T[(r, c)] = 0.0);
    }
    (0..q).for_each(|k| T[(k, k)] = 1.0);
    let (top, rest) = (T.view((0, 0), (q, q)).into_owned(), T.view((q, q), (n - q, n - q)).into_owned());
    let coupling = T.view((0, q), (q, n - q)).into_owned();
    let X = sylvester(&top, &-&rest, &-coupling)?;
    let mut A = Mat::zeros(n, n);
    A.view_mut((0, 0), (q, q)).copy_from(&top);
    A.view_mut((q, q), (n - q, n - q)).copy_from(&rest);
    let into = |M: Mat| {
        let mut M = form.Q.transpose() * M;
        let shared = &X * M.rows(q, n - q);
        let mut head = M.rows_mut(0, q);
        head -= shared;
        M
    };
    let mut C = &model.C * &form.Q;
    let shared = C.columns(0, q) * &X;
    let mut tail = C.columns_mut(q, n - q);
    tail += shared;
    let x0 = into(Mat::from_columns(std::slice::from_ref(initial_state)));
    let model = StateSpace::new(A, into(model.B.clone()), C, model.D.clone(), model.time)?;
    Ok(BlockForm { model, initial_state: x0.column(0).into_owned(), moved })
}

/// Distance from 1, all complex poles behind all real ones.
fn farness(z: C64) -> f64 {
    let distance = (z - 1.0).norm();
    if z.im == 0.0 { distance / (1.0 + distance) } else { 1.0 + distance }
}

/// Farness of the q-th pole, and a little more.
fn reach(poles: &[C64], q: usize) -> f64 {
    let mut all: Vec<f64> = poles.iter().map(|z| farness(*z)).collect();
    all.sort_by(f64::total_cmp);
    let next = all.get(q).map_or(f64::INFINITY, |next| *next);
    (0.5 * (all[q - 1] + next)).min(all[q - 1] * (1.0 + 1e-9) + 1e-9)
}

fn subdiagonal(T: &Mat, k: usize) -> f64 {
    if k + 1 < T.nrows() { T[(k + 1, k)].abs() } else { 0.0 }
}
