//! `flexbeam identify`: a recording becomes a model.
//!
//! Enters: a recording and settings. Leaves: a model file, figures, one answer. Deliberately absent: the identification
//! itself, which `flexbeam-ident` owns.

mod bode;
mod bound;
mod hinted;
mod link;
mod orders;
pub(crate) mod pictures;
mod refinement;
mod table;

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use flexbeam_files as files;
use flexbeam_files::{
    ColumnName, Document, Excitation, Identification, IdentifyResult, Layout, Matrices, Model, Recording, Rows,
    json_text, pairs,
};
use flexbeam_ident::{Feedthrough, Identified, Options, Order, Poles, identify};
use flexbeam_lti::Signals;
use indicatif::ProgressBar;

use crate::output::{overwrite, provenance, waiting};
use crate::{Failure, cli};
pub(crate) use hinted::Hinted;
pub(crate) use link::Link;
pub(crate) use refinement::Refinement;
pub(crate) use table::physical_table;

/// A recording, parted into what goes in and what comes out.
pub(crate) struct Experiment {
    /// Inputs, SI units.
    pub inputs: Signals,
    /// Outputs, SI units.
    pub outputs: Signals,
    /// Samples of the excitation's period, where the recording says it.
    pub period_samples: Option<usize>,
}

/// What was found, and how long it took.
pub(crate) struct Found {
    /// The model and what it was judged by.
    pub identified: Identified,
    /// What `--refine` did.
    pub refinement: Option<Refinement>,
    /// The flexible link's own coordinates and numbers, where the model has its pattern.
    pub link: Option<Link>,
    /// Time of the identification itself [s].
    pub identify_s: f64,
    /// Bound on what the model leaves out, where it was asked for.
    pub uncertainty: Option<files::Uncertainty>,
}

/// `flexbeam identify`.
pub fn run(arguments: &cli::Identify) -> Result<(), Failure> {
    let (experiment, found) = identified(arguments)?;
    found.notes(arguments, &experiment);
    let options = options(arguments);
    let rows = orders::rows(arguments, &experiment, &options)?;
    if let Some(folder) = &arguments.plots {
        pictures::draw(folder, &experiment, &found, &options)?;
        orders::draw(folder, &rows, experiment.outputs.channels())?;
    }
    let mut result = found.result(&experiment, &options);
    result.orders = arguments.orders.map(|_| orders::results(&experiment, &rows));
    match arguments.json {
        true => println!("{}", json_text(&result)),
        false => print!("{}{}", table::text(arguments, &experiment, &found), orders::text(&experiment, &rows)),
    }
    Ok(())
}

/// Identifies, and writes the model.
///
/// Errors: a recording or options of which no model can be made; those of writing.
pub(crate) fn identified(arguments: &cli::Identify) -> Result<(Experiment, Found), Failure> {
    let replace = overwrite::<Model>(&arguments.out, arguments.force)?;
    let sign = waiting("reading the recording");
    let recording = recording(arguments)?;
    if let Some(notice) = &recording.notice {
        sign.suspend(|| eprintln!("{notice}"));
    }
    let experiment = Experiment::of(&recording, &arguments.inputs, &arguments.outputs)?;
    let options = options(arguments);
    sign.set_message("identifying");
    let mut found = Found::of(&experiment, &options, arguments.refine, &sign)
        .map_err(Hinted)
        .map_err(Failure::while_trying(format!("identify {}", arguments.recording.display())))?;
    sign.finish_and_clear();
    let mut model = found.model_file(&experiment, &options, &arguments.recording, &arguments.out)?;
    if let Some(beta) = arguments.stability_degree {
        found.uncertainty = Some(bound::uncertainty(&model, &experiment, &options, beta)?);
        model.uncertainty = found.uncertainty.clone();
    }
    model.write(&arguments.out, replace)?;
    Ok((experiment, found))
}

fn options(arguments: &cli::Identify) -> Options {
    let block_rows = match (&arguments.block_rows[..], arguments.integrators) {
        ([], 0) => &[20][..],
        // What an integrator leaves is slow: more rows see it better, and cost.
        ([], _) => &[20, 40, 60],
        (given, _) => given,
    };
    Options {
        block_rows: block_rows[0],
        more_block_rows: block_rows[1..].to_vec(),
        integrators: arguments.integrators,
        feedthrough: if arguments.no_feedthrough { Feedthrough::Zero } else { Feedthrough::Free },
        poles: if arguments.stable { Poles::Stable } else { Poles::Free },
        delay: arguments.delay,
        order: arguments.order,
        method: match arguments.method {
            cli::Method::Auto => flexbeam_ident::Method::Auto,
            cli::Method::Paper => flexbeam_ident::Method::Paper,
            cli::Method::N4sid => flexbeam_ident::Method::N4sid,
            cli::Method::Moesp => flexbeam_ident::Method::Moesp,
            cli::Method::Cva => flexbeam_ident::Method::Cva,
        },
        estimate: arguments.estimate,
        remove_mean: arguments.remove_mean,
        ..Options::default()
    }
}

/// The method by the name that files carry.
fn method_name(method: flexbeam_ident::Method) -> &'static str {
    match method {
        flexbeam_ident::Method::Auto => "auto",
        flexbeam_ident::Method::Moesp => "moesp",
        flexbeam_ident::Method::Paper => "paper",
        flexbeam_ident::Method::N4sid => "n4sid",
        flexbeam_ident::Method::Cva => "cva",
    }
}

fn recording(arguments: &cli::Identify) -> Result<Recording, Failure> {
    let columns = Some(arguments.columns.clone()).filter(|columns| !columns.is_empty());
    let layout = Layout { columns, period_s: arguments.period, resample_s: arguments.resample };
    Ok(Recording::read(&arguments.recording, &layout)?.into_si())
}

impl Experiment {
    /// The columns of these names; `theta_deg` is found as `theta_rad`, in SI units as the recording is.
    ///
    /// Errors: a column that is not there, or is named twice.
    pub fn of(recording: &Recording, inputs: &[String], outputs: &[String]) -> Result<Experiment, Failure> {
        let names: Vec<String> = inputs.iter().chain(outputs).map(|name| si_name(name)).collect();
        let all = recording.select(&names)?;
        let rows = |first: usize, count: usize| Signals {
            names: all.names[first..first + count].to_vec(),
            units: all.units[first..first + count].to_vec(),
            period_s: all.period_s,
            data: all.data.rows(first, count).into_owned(),
        };
        let excitation = Excitation::of_recording(&recording.source, &recording.sha256);
        Ok(Experiment {
            inputs: rows(0, inputs.len()),
            outputs: rows(inputs.len(), outputs.len()),
            period_samples: excitation.and_then(|excitation| excitation.period_samples),
        })
    }
}

fn si_name(name: &str) -> String {
    let column = ColumnName::of(name);
    if column.unit == column.si_unit { name.into() } else { format!("{}_{}", column.quantity, column.si_unit) }
}

impl Found {
    /// Identification, refinement where it is asked for, and where the model has its pattern the flexible link's numbers.
    ///
    /// Errors: those of [`identify`] and of the refinement.
    pub fn of(
        experiment: &Experiment,
        options: &Options,
        refine: Option<cli::Refinement>,
        sign: &ProgressBar,
    ) -> Result<Found, flexbeam_ident::Error> {
        let start = Instant::now();
        let identified = identify(&experiment.inputs, &experiment.outputs, options)?;
        let identify_s = start.elapsed().as_secs_f64();
        let (identified, refinement) = match refine {
            None => (identified, None),
            Some(errors) => {
                let (better, refinement) = refinement::refined(errors, experiment, &identified, options, sign)?;
                (better, Some(refinement))
            }
        };
        let link = Link::of(experiment, &identified, options);
        Ok(Found { identified, refinement, link, identify_s, uncertainty: None })
    }

    /// What a person should know besides the figures: on standard error.
    fn notes(&self, arguments: &cli::Identify, experiment: &Experiment) {
        self.identified.doubts.iter().for_each(|doubt| eprintln!("{doubt}"));
        let Identified { singular_values, order, .. } = &self.identified;
        if arguments.order == Order::Auto {
            let shown = self.identified.singular_order;
            let next = singular_values.get(shown).copied().unwrap_or(0.0);
            eprintln!(
                "order {order} by the rule: singular value {shown} is {:.3e}, the next one {next:.3e}; \
                 --plots DIR draws them, --order N decides otherwise",
                singular_values[shown - 1],
            );
        }
        if let Some(note) = self.refinement.as_ref().and_then(Refinement::note) {
            eprintln!("{note}");
        }
        if let Err(why) = &self.identified.continuous {
            eprintln!("no continuous model: {why}\nhint: another --order, or a shorter sample period");
        }
        let fits = self.identified.fit_percent.iter().flatten();
        let missed = experiment.outputs.names.iter().zip(fits).filter(|(_, fit)| **fit < 0.0);
        let missed: Vec<&str> = missed.map(|(name, _)| name.as_str()).collect();
        if !missed.is_empty() {
            eprintln!(
                "on unseen samples the mean says more about {} than the model does\n\
                 hint: more --block-rows see slower swings, --order N decides otherwise, --plots DIR shows what is missed",
                missed.join(", ")
            );
        }
        if let Some(why) = self.link.as_ref().and_then(|link| link.fit.as_ref().err()) {
            eprintln!("no physical parameters: {}", Hinted(why.clone()));
        }
    }

    /// The sampled model with its tables `continuous`, `physical`, `validation` and `identification`.
    ///
    /// Errors: a recording that vanished meanwhile.
    pub fn model_file(
        &self,
        experiment: &Experiment,
        options: &Options,
        recording: &Path,
        out: &Path,
    ) -> Result<Model, Failure> {
        let identified = &self.identified;
        let (inputs, outputs) = (&experiment.inputs, &experiment.outputs);
        let fits = by_name(experiment, identified.fit_percent.as_ref());
        let fits = fits.into_iter().filter_map(|(name, fit)| Some((name, fit?)));
        let validation = identified.fit_percent.as_ref().map(|_| files::Validation {
            fit_percent: fits.collect(),
            samples: Some(inputs.samples() - identified.estimation_samples),
        });
        Ok(Model {
            continuous: self.continuous().map(Matrices::from),
            physical: self.physical(),
            validation,
            identification: Some(Identification {
                method: method_name(self.identified.method).into(),
                block_rows: identified.block_rows,
                order: identified.order,
                singular_values: identified.singular_values.clone(),
                initial_state: Some(identified.initial_state.as_slice().to_vec()),
                estimate: Some(options.estimate),
                samples: Some(identified.estimation_samples),
                remove_mean: Some(options.remove_mean),
                refinement: self.refinement.as_ref().map(Refinement::file),
                integrators: Some(options.integrators).filter(|integrators| *integrators > 0),
                input_delay: Some(identified.input_delay.clone()).filter(|delays| delays.iter().any(|d| *d > 0)),
                output_means: Some(identified.output_means.clone()).filter(|_| options.remove_mean),
            }),
            innovations: self.innovations(),
            provenance: Some(provenance(&[recording], out)?),
            ..Model::new(&identified.model, inputs.names.clone(), outputs.names.clone())
        })
    }

    /// The continuous model, in (18)'s coordinates where it has them.
    fn continuous(&self) -> Option<&flexbeam_lti::StateSpace> {
        let physical = self.link.as_ref().and_then(|link| link.model.as_ref());
        physical.or(self.identified.continuous.as_ref().ok())
    }

    fn physical(&self) -> Option<files::Physical> {
        self.link.as_ref().and_then(|link| link.fit.as_ref().ok()).map(link::physical_table)
    }

    fn innovations(&self) -> Option<files::Innovations> {
        let found = self.identified.innovations.as_ref()?;
        Some(files::Innovations { K: Rows::from(&found.K), covariance: Rows::from(&found.covariance) })
    }

    fn result(&self, experiment: &Experiment, options: &Options) -> IdentifyResult {
        let Identified { model, initial_state, singular_values, order, block_rows, continuous, .. } = &self.identified;
        IdentifyResult {
            order: *order,
            period_s: experiment.inputs.period_s,
            block_rows: *block_rows,
            method: method_name(self.identified.method).into(),
            singular_values: singular_values.clone(),
            poles: pairs(&model.poles()),
            continuous_poles: continuous.as_ref().ok().map(|model| pairs(&model.poles())),
            fit_percent: by_name(experiment, self.identified.fit_percent.as_ref()),
            physical: self.physical(),
            inputs: experiment.inputs.names.clone(),
            outputs: experiment.outputs.names.clone(),
            A: Rows::from(&model.A),
            B: Rows::from(&model.B),
            C: Rows::from(&model.C),
            D: Rows::from(&model.D),
            initial_state: initial_state.as_slice().to_vec(),
            uncertainty: self.uncertainty.clone(),
            integrators: options.integrators,
            input_delay: self.identified.input_delay.clone(),
            input_means: self.identified.input_means.clone(),
            output_means: self.identified.output_means.clone(),
            estimation_fit_percent: by_name(experiment, Some(&self.identified.estimation_fit_percent)),
            innovations: self.innovations(),
            doubts: self.identified.doubts.iter().map(ToString::to_string).collect(),
            orders: None,
            identify_s: self.identify_s,
            refined: self.refinement.as_ref().map(|refinement| files::RefinedResult {
                refinement: refinement.file(),
                refine_s: refinement.refine_s,
            }),
        }
    }
}

/// Fit by output's name; nothing where the simulation overflowed or there were no samples.
fn by_name(experiment: &Experiment, fits: Option<&Vec<f64>>) -> BTreeMap<String, Option<f64>> {
    let fit = |k: usize| fits.map(|fits| fits[k]).filter(|fit| fit.is_finite());
    experiment.outputs.names.iter().enumerate().map(|(k, name)| (name.clone(), fit(k))).collect()
}
