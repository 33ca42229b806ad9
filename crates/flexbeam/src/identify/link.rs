//! The flexible link's own coordinates and numbers, where a model has its pattern.

use flexbeam_files as files;
use flexbeam_files::ColumnName;
use flexbeam_ident::physical::{lumped_from_poles, physical_form};
use flexbeam_ident::structured::{BeamDamping, LinkFit, Measured, structured_fit};
use flexbeam_ident::{Error, Identified, Options, Order, identify};
use flexbeam_lti::{Mat, Signals, StateSpace};
use flexbeam_rig::{Lumped, Output};

use super::Experiment;

/// What was found of a flexible link.
pub(crate) struct Link {
    /// The continuous model in the coordinates [theta alpha theta' alpha'], with nothing else among its outputs; nothing where theta
    /// or alpha was not measured, or the model is of another order.
    pub model: Option<StateSpace>,
    /// k1, k2, c and b by structured least squares on the estimating samples.
    pub fit: Result<LinkFit, Error>,
}

/// Outputs that are made of theta and alpha, by their places.
struct Shown(Vec<(usize, Output)>);

impl Link {
    /// Nothing where the recording is no flexible link's: one input, and theta, alpha or psi in rad.
    ///
    /// The structured fit starts from a model of the link's order, which is identified besides when the model has another one.
    pub fn of(experiment: &Experiment, identified: &Identified, options: &Options) -> Option<Link> {
        let shown = Shown::of(experiment);
        if experiment.inputs.channels() != 1 || shown.0.is_empty() {
            return None;
        }
        let alone = shown.0.len() == experiment.outputs.channels();
        let besides = if alone && identified.order == shown.order() {
            Ok(identified.clone())
        } else {
            let order = Order::Fixed(shown.order());
            identify(&experiment.inputs, &shown.outputs(experiment), &Options { order, ..options.clone() })
        };
        let start = besides.and_then(|besides| shown.start(&besides));
        let model = match (&start, shown.both()) {
            (Ok((_, Some(form))), Some((theta, alpha))) if alone && identified.order == shown.order() => {
                Some(in_order(form.clone(), theta, alpha))
            }
            _ => None,
        };
        let fit = start.and_then(|(start, _)| shown.fit(experiment, identified, start));
        Some(Link { model, fit })
    }
}

impl Shown {
    fn of(experiment: &Experiment) -> Shown {
        let known = [("theta", Output::Theta), ("alpha", Output::Alpha), ("psi", Output::Psi)];
        let output = |name: &String| {
            let column = ColumnName::of(name);
            known
                .iter()
                .find(|(quantity, _)| column.quantity == *quantity && column.unit == "rad")
                .map(|(_, shown)| *shown)
        };
        let names = experiment.outputs.names.iter().enumerate();
        Shown(names.filter_map(|(k, name)| Some((k, output(name)?))).collect())
    }

    /// The deflection does not see the integrator.
    fn order(&self) -> usize {
        if self.0.iter().all(|(_, output)| *output == Output::Alpha) { 3 } else { 4 }
    }

    /// Places of theta and alpha among what is shown.
    fn both(&self) -> Option<(usize, usize)> {
        let place = |wanted: Output| self.0.iter().position(|(_, output)| *output == wanted);
        Some((place(Output::Theta)?, place(Output::Alpha)?))
    }

    fn outputs(&self, experiment: &Experiment) -> Signals {
        let Signals { names, units, period_s, data } = &experiment.outputs;
        let places: Vec<usize> = self.0.iter().map(|(k, _)| *k).collect();
        let of = |texts: &[String]| places.iter().map(|&k| texts[k].clone()).collect();
        Signals { names: of(names), units: of(units), period_s: *period_s, data: data.select_rows(&places) }
    }

    /// First values of the parameters, and the physical form where theta and alpha are both there.
    fn start(&self, identified: &Identified) -> Result<(Lumped, Option<StateSpace>), Error> {
        let continuous = identified.continuous.as_ref().map_err(|why| Error::Linear(why.clone()))?;
        match self.both() {
            Some((theta, alpha)) => {
                let form = physical_form(continuous, theta, alpha)?;
                Ok((form.parameters, (self.0.len() == 2).then_some(form.model)))
            }
            None => {
                let outputs: Vec<Output> = self.0.iter().map(|(_, output)| *output).collect();
                Ok((lumped_from_poles(continuous, &outputs)?, None))
            }
        }
    }

    /// The structured least squares on the samples that estimated the model, without the means where they were removed.
    fn fit(&self, experiment: &Experiment, identified: &Identified, start: Lumped) -> Result<LinkFit, Error> {
        let estimating = |data: &Mat, row: usize, mean: f64| -> Vec<f64> {
            data.row(row).iter().take(identified.estimation_samples).map(|x| x - mean).collect()
        };
        let voltage_v = estimating(&experiment.inputs.data, 0, identified.input_means[0]);
        let rows = self
            .0
            .iter()
            .map(|&(k, output)| (output, estimating(&experiment.outputs.data, k, identified.output_means[k])));
        let rows: Vec<(Output, Vec<f64>)> = rows.collect();
        let measured: Vec<Measured> =
            rows.iter().map(|(output, samples)| Measured { output: *output, samples }).collect();
        structured_fit(&voltage_v, &measured, experiment.inputs.period_s, start, BeamDamping::None)
    }
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
