//! Where a descent begins: the model as given, put right where it lacks what is known.
//!
//! Enters: the model and what is known. Leaves: the cheapest of a few points. Deliberately absent: chance.

use std::ops::ControlFlow;

use flexbeam_lti::schur::ordered_schur;
use flexbeam_lti::{Mat, StateSpace, Time, Vector};

use super::block_form::block_form;
use super::descent::{Descent, Standing, Watch};
use super::local::Point;
use super::sensitivity::Record;
use super::{Errors, Progress, Settings};
use crate::correlation::{Channels, NotFinite};
use crate::output_map::{Unknowns, input_matrices};
use crate::validate::validate;
use crate::{Error, Feedthrough};

/// A mirrored pole comes no nearer to the circle than this.
const MIRRORED_MODULUS: f64 = 0.999;

/// Shapes, time and settings.
pub(super) fn check(start: &StateSpace, U: &Mat, Y: &Mat, settings: &Settings) -> Result<(), Error> {
    let (n, m, l) = (start.order(), start.inputs(), start.outputs());
    if start.time == Time::Continuous {
        let (what, needed) = ("refinement", "sampled time");
        return Err(flexbeam_lti::Error::WrongTime { what, found: start.time, needed }.into());
    }
    expect_shape("U (rows are inputs)", U, m, U.ncols())?;
    expect_shape("Y (rows are outputs)", Y, l, Y.ncols())?;
    if U.ncols() != Y.ncols() {
        return Err(Error::Length { inputs: U.ncols(), outputs: Y.ncols() });
    }
    let gain = match &settings.errors {
        Errors::Simulated => 0,
        Errors::Predicted(K) => {
            K.iter().try_for_each(|K| expect_shape("K", K, n, l))?;
            n * l
        }
    };
    let parameters = n * (m + l) + m * l + n + gain + if settings.offset { l } else { 0 };
    let needed = parameters.div_ceil(l.max(1)) + 1;
    if U.ncols() < needed {
        return Err(Error::TooFewSamples { what: "refinement", found: U.ncols(), needed, block_rows: 1 });
    }
    if let Some(NotFinite { channel, sample }) = Channels::of_rows(U).beside(Channels::of_rows(Y)).not_finite() {
        let (of, row, data) = if channel < m { ("input", channel, U) } else { ("output", channel - m, Y) };
        let channel = format!("{of} {row} (from 0)");
        return Err(Error::NotFinite { channel, sample, value: data[(row, sample)] });
    }
    if !(settings.tolerance > 0.0) {
        return Err(Error::Setting { setting: "tolerance", found: settings.tolerance, needed: "a positive number" });
    }
    Ok(())
}

fn expect_shape(what: &'static str, M: &Mat, rows: usize, columns: usize) -> Result<(), Error> {
    if M.shape() == (rows, columns) {
        return Ok(());
    }
    Err(flexbeam_lti::Error::Shape {
        what,
        found_rows: M.nrows(),
        found_columns: M.ncols(),
        needed_rows: rows,
        needed_columns: columns,
    }
    .into())
}

/// The start in block form; besides, with unstable poles mirrored, where that may help.
pub(super) fn candidates(start: &StateSpace, U: &Mat, Y: &Mat, settings: &Settings) -> Result<Vec<Start>, Error> {
    let initial_state = validate(start, U, Y)?.initial_state;
    let form = block_form(start, &initial_state, settings.integrators)?;
    let no_feedthrough = settings.feedthrough == Feedthrough::Zero && start.D.iter().any(|d| *d != 0.0);
    let given = if form.was_moved() || no_feedthrough {
        refitted(&form.model, U, Y, settings)?
    } else {
        let offset = Vector::zeros(form.model.outputs());
        Start { model: form.model.clone(), initial_state: form.initial_state, offset }
    };
    let mirrored = match mirrored(&form.model, settings.integrators)? {
        Some(model) => Some(refitted(&model, U, Y, settings)?),
        None => None,
    };
    Ok([Some(given), mirrored].into_iter().flatten().collect())
}

/// A model with its initial state, and a constant on each output.
pub(super) struct Start {
    model: StateSpace,
    initial_state: Vector,
    offset: Vector,
}

/// B, D, x(0) and the offsets by linear least squares on the simulated output.
fn refitted(model: &StateSpace, U: &Mat, Y: &Mat, settings: &Settings) -> Result<Start, Error> {
    let unknowns = Unknowns { feedthrough: settings.feedthrough, offset: settings.offset };
    let found = input_matrices(&model.A, &model.C, &U.transpose(), &Y.transpose(), unknowns);
    let model = StateSpace::new(model.A.clone(), found.B, model.C.clone(), found.D, model.time)?;
    Ok(Start { model, initial_state: found.initial_state, offset: found.offset })
}

/// Poles outside the circle mirrored into it, known integrators apart; None when there are none.
fn mirrored(model: &StateSpace, integrators: usize) -> Result<Option<StateSpace>, Error> {
    let (n, q) = (model.order(), integrators);
    let rest = model.A.view((q, q), (n - q, n - q)).into_owned();
    let mut form = ordered_schur(&rest, |z| z.norm() >= 1.0)?;
    if form.leading == 0 {
        return Ok(None);
    }
    let unstable = form.T.view((0, 0), (form.leading, form.leading)).into_owned();
    let largest = modulus(&unstable);
    // Their block over the square of its largest modulus: the same angles, inside the circle.
    let factor = (1.0 / (largest * largest)).min(MIRRORED_MODULUS / largest);
    form.T.columns_mut(0, form.leading).scale_mut(factor);
    let mut A = model.A.clone();
    A.view_mut((q, q), (n - q, n - q)).copy_from(&(&form.Q * &form.T * form.Q.transpose()));
    Ok(Some(StateSpace::new(A, model.B.clone(), model.C.clone(), model.D.clone(), model.time)?))
}

fn modulus(A: &Mat) -> f64 {
    flexbeam_lti::schur::eigenvalues(A).iter().map(|z| z.norm()).fold(0.0, f64::max)
}

/// The cheapest point.
///
/// Errors: [`Error::Overflow`] when all of them overflow.
pub(super) fn best(
    descent: &Descent,
    candidates: Vec<Start>,
    gain: Option<Option<Mat>>,
    watch: Watch,
) -> Result<Standing, Error> {
    let mut best: Option<Standing> = None;
    for Start { model: StateSpace { A, mut B, C, mut D, .. }, initial_state, offset } in candidates {
        if descent.structure.offset {
            let m = D.ncols();
            (B, D) = (B.resize_horizontally(m + 1, 0.0), D.resize_horizontally(m + 1, 0.0));
            D.set_column(m, &offset);
        }
        let K = gain.clone().map(|K| K.unwrap_or_else(|| Mat::zeros(A.nrows(), C.nrows())));
        let point = Point { A, B, C, D, K, initial_state };
        let progress = Progress { iterations: 0, missed: f64::INFINITY };
        // Whoever has had enough already still gets the start, which costs one simulation.
        let mut patient = |progress: &Progress| {
            let _ = watch(progress);
            ControlFlow::Continue(())
        };
        let ControlFlow::Continue(Some(standing)) = descent.standing(point, &mut patient, progress) else { continue };
        if best.as_ref().is_none_or(|best| standing.judged.cost < best.judged.cost) {
            best = Some(standing);
        }
    }
    best.ok_or(Error::Overflow { samples: descent.record.Y.ncols() })
}

/// What the predictor is driven by, [U; 1; Y] as far as it is, and the output to be met.
pub(super) fn record(U: Mat, Y: Mat, settings: &Settings) -> Record {
    let mut W = U;
    if settings.offset {
        let m = W.nrows();
        W = W.resize_vertically(m + 1, 1.0);
    }
    if settings.errors != Errors::Simulated {
        let v = W.nrows();
        W = W.resize_vertically(v + Y.nrows(), 0.0);
        W.rows_mut(v, Y.nrows()).copy_from(&Y);
    }
    Record { W, Y }
}
