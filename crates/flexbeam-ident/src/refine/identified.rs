//! Refinement of what the subspace method found, on the samples that estimated it.

use flexbeam_lti::{Mat, Signals, StateSpace, sampling};

use super::descent::Watch;
use super::{Refined, Scales, Settings, refine};
use crate::validate::validate;
use crate::{Error, Identified};

/// The identified model refined on its estimating samples, and judged anew on both parts.
///
/// Returns the gain of predicted errors beside the model ([`Refined::K`]); the innovations of the model that was are gone.
/// Assumes: the recording that was identified.
/// Errors: those of [`refine`]; [`Error::DelayRefined`].
pub fn refine_identified(
    identified: &Identified,
    inputs: &Signals,
    outputs: &Signals,
    settings: &Settings,
    watch: Watch,
) -> Result<(Identified, Refined), Error> {
    if let Some(delay) = identified.input_delay.iter().copied().max().filter(|delay| *delay > 0) {
        return Err(Error::DelayRefined { delay });
    }
    let U = without_means(&inputs.data, &identified.input_means);
    let Y = without_means(&outputs.data, &identified.output_means);
    let (s, all) = (identified.estimation_samples, U.ncols());
    let part = |M: &Mat, first: usize, count: usize| M.columns(first, count).into_owned();
    let (U_e, Y_e) = (part(&U, 0, s), part(&Y, 0, s));
    let refined = refine(&identified.model, &U_e, &Y_e, settings, watch)?;
    let Y = without_means(&Y, refined.offset.as_slice());
    let Y_e = part(&Y, 0, s);
    let scales = Scales::of(&U_e, &Y_e);
    let estimation_fit_percent = fits(&refined.model, &scales, &U_e, &Y_e)?;
    let fit_percent = match all - s {
        0 => None,
        rest => Some(fits(&refined.model, &scales, &part(&U, s, rest), &part(&Y, s, rest))?),
    };
    let identified = Identified {
        continuous: sampling::inverse_zoh(&refined.model),
        model: refined.model.clone(),
        initial_state: refined.initial_state.clone(),
        output_means: identified.output_means.iter().zip(&refined.offset).map(|(mean, d)| mean + d).collect(),
        fit_percent,
        estimation_fit_percent,
        innovations: None,
        ..identified.clone()
    };
    Ok((identified, refined))
}

/// Fit of each output, the initial state by least squares on outputs of the estimating part's rms.
fn fits(model: &StateSpace, scales: &Scales, U: &Mat, Y: &Mat) -> Result<Vec<f64>, Error> {
    let (U, Y) = (scales.inputs.apply_rows(U), scales.outputs.apply_rows(Y));
    Ok(validate(&scales.scaled(model)?, &U, &Y)?.fit_percent)
}

fn without_means(data: &Mat, means: &[f64]) -> Mat {
    Mat::from_fn(data.nrows(), data.ncols(), |c, k| data[(c, k)] - means[c])
}
