//! The flexible link's own coordinates and numbers, where a model has its pattern.

use flexbeam_files as files;
use flexbeam_files::ColumnName;
use flexbeam_ident::physical::physical_form;
use flexbeam_ident::structured::{LinkFit, structured_fit};
use flexbeam_ident::{Error, Identified, Options, Order, identify};
use flexbeam_lti::{Mat, StateSpace};

use super::Experiment;

/// States of the lumped link.
const ORDER: usize = 4;

/// What was found of a flexible link with theta and alpha measured.
pub(crate) struct Link {
    /// The continuous model in the coordinates [theta alpha theta' alpha'], with nothing else among its outputs; nothing
    /// where the model is of another order.
    pub model: Option<StateSpace>,
    /// k1, k2, c and b by structured least squares on the estimating samples.
    pub fit: Result<LinkFit, Error>,
}

impl Link {
    /// Nothing where the recording is no flexible link's: one input, theta and alpha in rad.
    ///
    /// The structured fit starts from a model of order 4, which is identified besides when the model has another order.
    pub fn of(experiment: &Experiment, identified: &Identified, options: &Options) -> Option<Link> {
        let theta = position(experiment, "theta")?;
        let alpha = position(experiment, "alpha")?;
        if experiment.inputs.channels() != 1 {
            return None;
        }
        let of_order_4 = |model: &Identified| {
            let continuous = model.continuous.as_ref().map_err(|why| Error::Linear(why.clone()))?;
            physical_form(continuous, theta, alpha)
        };
        if identified.order != ORDER {
            let options = Options { order: Order::Fixed(ORDER), ..options.clone() };
            let besides = identify(&experiment.inputs, &experiment.outputs, &options);
            let start = besides.and_then(|model| of_order_4(&model));
            let fit = start.and_then(|start| fit(experiment, identified, theta, alpha, start.parameters));
            return Some(Link { model: None, fit });
        }
        let form = match of_order_4(identified) {
            Ok(form) => form,
            Err(why) => return Some(Link { model: None, fit: Err(why) }),
        };
        let fit = fit(experiment, identified, theta, alpha, form.parameters);
        let only = experiment.outputs.channels() == 2;
        Some(Link { model: only.then(|| in_order(form.model, theta, alpha)), fit })
    }
}

/// The structured least squares on the samples that estimated the model, without the means where they were removed.
fn fit(
    experiment: &Experiment,
    identified: &Identified,
    theta: usize,
    alpha: usize,
    start: flexbeam_rig::Lumped,
) -> Result<LinkFit, Error> {
    let estimating = |data: &Mat, row: usize, mean: f64| -> Vec<f64> {
        data.row(row).iter().take(identified.estimation_samples).map(|x| x - mean).collect()
    };
    structured_fit(
        &estimating(&experiment.inputs.data, 0, identified.input_means[0]),
        &estimating(&experiment.outputs.data, theta, identified.output_means[theta]),
        &estimating(&experiment.outputs.data, alpha, identified.output_means[alpha]),
        experiment.inputs.period_s,
        start,
    )
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
