//! The flexible link's own coordinates and numbers, where a model has its pattern.

use flexbeam_files as files;
use flexbeam_files::ColumnName;
use flexbeam_ident::Identified;
use flexbeam_ident::physical::physical_form;
use flexbeam_ident::structured::{LinkFit, structured_fit};
use flexbeam_lti::StateSpace;

use super::Experiment;

/// States of the lumped link.
const ORDER: usize = 4;

/// What was found of a flexible link with theta and alpha measured.
pub(crate) struct Link {
    /// The continuous model in the coordinates [theta alpha theta' alpha'], with nothing else among its outputs.
    pub model: Option<StateSpace>,
    /// k1, k2, c and b by structured least squares on the estimating samples.
    pub fit: Result<LinkFit, flexbeam_ident::Error>,
}

impl Link {
    /// Nothing where the recording is no flexible link's: one input, theta and alpha in rad, order 4, a continuous form.
    pub fn of(experiment: &Experiment, identified: &Identified) -> Option<Link> {
        let theta = position(experiment, "theta")?;
        let alpha = position(experiment, "alpha")?;
        let continuous = identified.continuous.as_ref().ok()?;
        if identified.order != ORDER || experiment.inputs.channels() != 1 {
            return None;
        }
        let form = match physical_form(continuous, theta, alpha) {
            Ok(form) => form,
            Err(why) => return Some(Link { model: None, fit: Err(why) }),
        };
        let estimating = |data: &flexbeam_lti::Mat, row: usize, mean: f64| -> Vec<f64> {
            data.row(row).iter().take(identified.estimation_samples).map(|x| x - mean).collect()
        };
        let fit = structured_fit(
            &estimating(&experiment.inputs.data, 0, identified.input_means[0]),
            &estimating(&experiment.outputs.data, theta, identified.output_means[theta]),
            &estimating(&experiment.outputs.data, alpha, identified.output_means[alpha]),
            experiment.inputs.period_s,
            form.parameters,
        );
        let only = experiment.outputs.channels() == 2;
        Some(Link { model: only.then(|| in_order(form.model, theta, alpha)), fit })
    }
}

/// Output of that quantity in rad.
fn position(experiment: &Experiment, quantity: &str) -> Option<usize> {
    experiment.outputs.names.iter().position(|name| {
        let column = ColumnName::of(name);
        column.quantity == quantity && column.unit == "rad"
    })
}

/// The form's outputs, theta before alpha, in the recording's order.
fn in_order(form: StateSpace, theta: usize, alpha: usize) -> StateSpace {
    let rows = if theta < alpha { [0, 1] } else { [1, 0] };
    StateSpace { C: form.C.select_rows(&rows), D: form.D.select_rows(&rows), ..form }
}

/// The table `physical` of a model.
pub(super) fn physical_table(fit: &LinkFit) -> files::Physical {
    let (found, std) = (fit.parameters, fit.standard_errors);
    let known = |std: f64| Some(std).filter(|std| std.is_finite());
    files::Physical {
        k1: found.k1,
        k1_std: known(std.k1),
        k2: found.k2,
        k2_std: known(std.k2),
        c: found.c,
        c_std: known(std.c),
        b: found.b,
        b_std: known(std.b),
    }
}
