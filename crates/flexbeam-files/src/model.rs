//! Models: a state space with named inputs and outputs, and how it was found.

use crate::document::Document;
use crate::fault::Fault;
use crate::matrices::{Matrices, Rows};
use crate::misfit::Misfit;
use crate::provenance::Provenance;
use flexbeam_lti::{StateSpace, Time};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// `flexbeam.model/1`: x' = A x + B u or x(k+1) = A x(k) + B u(k); y = C x + D u.
///
/// Shapes: A n*n, B n*m, C l*n, D l*m with m `inputs` and l `outputs`; n may be 0. Exactly one of `time` and `period_s`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// `continuous`, or nothing.
    pub time: Option<Axis>,
    /// Sample period [s] of a sampled model.
    pub period_s: Option<f64>,
    /// Names with their units: `voltage_v`.
    pub inputs: Vec<String>,
    /// Names with their units: `theta_rad`, `alpha_rad`.
    pub outputs: Vec<String>,
    /// State matrix.
    pub A: Rows,
    /// Input matrix.
    pub B: Rows,
    /// Output matrix.
    pub C: Rows,
    /// Feedthrough.
    pub D: Rows,
    /// The continuous model with the same inputs and outputs, beside a sampled one.
    pub continuous: Option<Matrices>,
    /// The four numbers of the flexible beam's lumped model.
    pub physical: Option<Physical>,
    /// Bound of what the model leaves out.
    pub uncertainty: Option<Uncertainty>,
    /// How well it predicts data that it has not seen.
    pub validation: Option<Validation>,
    /// What it leaves unexplained.
    pub innovations: Option<Innovations>,
    /// How it was found.
    pub identification: Option<Identification>,
    /// Where it came from.
    pub provenance: Option<Provenance>,
}

/// The time axis of a model without a sample period.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// Continuous time.
    Continuous,
}

/// The lumped model's numbers, each with its standard error where it is known.
///
/// theta'' = k1 alpha - c theta' + b V, alpha'' = -k2 alpha + c theta' - b V.
/// Source: DESIGN section 2.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Physical {
    /// K_stiff/J_base [1/s^2].
    pub k1: f64,
    /// Standard error of `k1`.
    pub k1_std: Option<f64>,
    /// K_stiff (1/J_link + 1/J_base) [1/s^2].
    pub k2: f64,
    /// Standard error of `k2`.
    pub k2_std: Option<f64>,
    /// Damping of the hub [1/s].
    pub c: f64,
    /// Standard error of `c`.
    pub c_std: Option<f64>,
    /// Angular acceleration of the hub per volt [rad/s^2/V].
    pub b: f64,
    /// Standard error of `b`.
    pub b_std: Option<f64>,
}

/// |dG(jw - beta)| < |alpha(jw)|, alpha = num/den in the shifted plane, stable and minimum phase.
///
/// Source: DESIGN section 6, (19).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Uncertainty {
    /// Numerator [rad/V], highest power first.
    pub num: Vec<f64>,
    /// Denominator, highest power first.
    pub den: Vec<f64>,
    /// Stability degree beta [1/s] at which the bound holds.
    pub beta: f64,
    /// How it came from a recording, where it did.
    pub origin: Option<BoundOrigin>,
}

/// What a bound from a recording is a bound of, and what it rests on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoundOrigin {
    /// The output that it is for: `psi`.
    pub output: String,
    /// The plant that it lies around: `physical` or `continuous`, the model's tables.
    pub nominal: String,
    /// Probability with which the full model's band holds, if the beam is linear and of its order.
    pub level: f64,
    /// States of the full model.
    pub full_order: usize,
    /// Whether the recording contradicts the full model, so that what it leaves on s = jw was added.
    pub contradicted: bool,
    /// Re-estimates behind the band.
    pub replicates: usize,
}

/// Fit on the part of the recording that was not used for estimation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Validation {
    /// 100 (1 - |y - yhat|/|y - mean y|) [percent], for each output.
    pub fit_percent: BTreeMap<String, f64>,
    /// Samples that were predicted.
    pub samples: Option<usize>,
}

/// x(k+1) = A x + B u + K e, y = C x + D u + e, A - K C stable; of the sampled model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Innovations {
    /// Gain, n x l.
    pub K: Rows,
    /// Covariance of e, l x l, in the outputs' units.
    pub covariance: Rows,
}

/// How the model was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Identification {
    /// Method: `moesp`, `paper`, ..
    pub method: String,
    /// Block rows i of the Hankel matrices.
    pub block_rows: usize,
    /// Order n that was chosen.
    pub order: usize,
    /// Singular values from which it was chosen, in descending order.
    pub singular_values: Vec<f64>,
    /// State at the recording's first sample.
    pub initial_state: Option<Vec<f64>>,
    /// Part of the recording used for estimation, from its start.
    pub estimate: Option<f64>,
    /// Samples used for estimation.
    pub samples: Option<usize>,
    /// Whether means were removed.
    pub remove_mean: Option<bool>,
    /// Poles that were known to be 1.
    pub integrators: Option<usize>,
    /// Delay of each input, which the model carries as states [samples].
    pub input_delay: Option<Vec<usize>>,
    /// What was taken from the outputs: means, and the offsets that were estimated with it.
    pub output_means: Option<Vec<f64>>,
    /// What `--refine` did afterwards.
    pub refinement: Option<Refinement>,
}

/// A refinement by simulated or predicted errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Refinement {
    /// `simulated` or `predicted`.
    pub errors: String,
    /// Linearisations used.
    pub iterations: usize,
    /// Parameters that were free, the initial state among them.
    pub parameters: usize,
    /// Part of the outputs missed before, 0 to 1; nothing where the start overflowed.
    pub missed_before: Option<f64>,
    /// Part of the outputs missed afterwards.
    pub missed_after: f64,
    /// Why it ended: `settled`, `rounding`, `no_descent`, `slow`, `iterations`, `asked`.
    pub reason: String,
    /// Innovations gain, n x l, where predicted errors were made small.
    pub K: Option<Rows>,
}

impl Model {
    /// A model with nothing but its matrices and names.
    pub fn new(G: &StateSpace, inputs: Vec<String>, outputs: Vec<String>) -> Model {
        let Matrices { A, B, C, D } = G.into();
        let (time, period_s) = match G.time {
            Time::Continuous => (Some(Axis::Continuous), None),
            Time::Sampled { period_s } => (None, Some(period_s)),
        };
        Model {
            time,
            period_s,
            inputs,
            outputs,
            A,
            B,
            C,
            D,
            continuous: None,
            physical: None,
            uncertainty: None,
            validation: None,
            innovations: None,
            identification: None,
            provenance: None,
        }
    }

    /// The time axis.
    pub fn time_axis(&self) -> Time {
        self.period_s.map_or(Time::Continuous, |period_s| Time::Sampled { period_s })
    }

    /// The model's system.
    ///
    /// Errors: those of [`StateSpace::new`]; none for a model that was read.
    pub fn state_space(&self) -> Result<StateSpace, flexbeam_lti::Error> {
        self.matrices().state_space(self.time_axis())
    }

    /// The continuous system: the table `continuous`, or the model's own matrices when it is continuous.
    ///
    /// Returns nothing when the file holds a sampled model only.
    /// Errors: as [`Model::state_space`].
    pub fn continuous_state_space(&self) -> Option<Result<StateSpace, flexbeam_lti::Error>> {
        match (&self.continuous, self.time_axis()) {
            (Some(continuous), _) => Some(continuous.state_space(Time::Continuous)),
            (None, Time::Continuous) => Some(self.state_space()),
            (None, Time::Sampled { .. }) => None,
        }
    }

    fn matrices(&self) -> Matrices {
        Matrices { A: self.A.clone(), B: self.B.clone(), C: self.C.clone(), D: self.D.clone() }
    }
}

impl Document for Model {
    const SCHEMA: &'static str = "flexbeam.model/1";
    const HEAD: &'static str =
        "flexbeam model: x' or x(k+1) = A x + B u, y = C x + D u. SI units; a row of a matrix a line.";

    fn provenance(&self) -> Option<&Provenance> {
        self.provenance.as_ref()
    }

    fn check(&self) -> Result<(), Misfit> {
        match (self.time, self.period_s) {
            (None, Some(period_s)) => positive("period_s", period_s)?,
            (Some(Axis::Continuous), None) => {}
            (time, _) => {
                let found = if time.is_some() { 2 } else { 0 };
                return Err(Misfit::new(Fault::OneOf { found, one: "time", other: "period_s" }));
            }
        }
        check_names("inputs", &self.inputs)?;
        check_names("outputs", &self.outputs)?;
        let (m, l) = (self.inputs.len(), self.outputs.len());
        self.matrices().check(m, l)?;
        if let Some(continuous) = &self.continuous {
            continuous.check(m, l).map_err(|misfit| misfit.under("continuous"))?;
        }
        if let Some(uncertainty) = &self.uncertainty {
            uncertainty.check().map_err(|misfit| misfit.under("uncertainty"))?;
        }
        if let Some(innovations) = &self.innovations {
            let n = self.A.0.len();
            innovations.K.check(n, l).map_err(|misfit| misfit.under("K").under("innovations"))?;
            innovations.covariance.check(l, l).map_err(|misfit| misfit.under("covariance").under("innovations"))?;
        }
        match &self.validation {
            Some(validation) => check_outputs(validation, &self.outputs),
            None => Ok(()),
        }
    }
}

impl Uncertainty {
    pub(crate) fn check(&self) -> Result<(), Misfit> {
        match (self.num.is_empty(), self.den.is_empty()) {
            (true, _) => Err(Misfit::empty("num")),
            (_, true) => Err(Misfit::empty("den")),
            _ if self.beta >= 0.0 => Ok(()),
            _ => Err(out_of_range("beta", self.beta, "zero or a positive number of 1/s")),
        }
    }
}

pub(crate) fn out_of_range(key: &str, found: f64, needed: &'static str) -> Misfit {
    Misfit::new(Fault::Range { key: String::new(), found, needed }).under(key)
}

pub(crate) fn positive(key: &str, found: f64) -> Result<(), Misfit> {
    if found > 0.0 { Ok(()) } else { Err(out_of_range(key, found, "a positive number")) }
}

/// Errors: [`Fault::EmptyList`], [`Fault::DuplicateName`].
pub(crate) fn check_names(key: &str, names: &[String]) -> Result<(), Misfit> {
    if names.is_empty() {
        return Err(Misfit::empty(key));
    }
    match (0..names.len()).find(|&k| names[..k].contains(&names[k])) {
        Some(k) => Err(Misfit::new(Fault::DuplicateName { name: names[k].clone() }).in_entry(k).under(key)),
        None => Ok(()),
    }
}

fn check_outputs(validation: &Validation, outputs: &[String]) -> Result<(), Misfit> {
    match validation.fit_percent.keys().find(|name| !outputs.contains(name)) {
        Some(name) => {
            let nearest = crate::columns::nearest(name, outputs);
            let fault = Fault::UnknownKey { key: name.clone(), known: outputs.to_vec(), nearest };
            Err(Misfit::new(fault).under("fit_percent").under("validation"))
        }
        None => Ok(()),
    }
}
