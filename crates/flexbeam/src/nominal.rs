//! The plant of a design, from a model file: voltage to the controlled output, continuous.

use flexbeam_files::Model;
use flexbeam_lti::{Mat, StateSpace, connections, sampling};
use flexbeam_rig::{Lumped, Output};

use crate::Failure;

/// A model without the output that is to be controlled.
#[derive(Debug, thiserror::Error)]
enum NoPlant {
    #[error(
        "no output is named {wanted}: the model has {}\nhint: name one with --output; psi is also formed from theta and alpha",
        .outputs.join(", ")
    )]
    Output { wanted: String, outputs: Vec<String> },
    #[error("found {} inputs, {}; needed one\nhint: identify with the motor voltage as the only input", .0.len(), .0.join(", "))]
    Inputs(Vec<String>),
    #[error(
        "the model has no table [physical], which --nominal physical asks for\nhint: identify with theta_rad and alpha_rad as outputs and --order 4"
    )]
    NoPhysical,
}

/// Which of a model's descriptions is the nominal plant.
#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
pub enum Nominal {
    /// [physical] where the model has it and psi is controlled, else [continuous]
    Auto,
    /// The lumped beam of [physical]
    Physical,
    /// The matrices of [continuous], or the exact inverse of the zero-order hold
    Continuous,
}

/// The nominal plant of `model`.
///
/// Errors: an output that is not there, several inputs, a sampled model without a continuous one.
pub fn nominal_plant(model: &Model, output: &str, nominal: Nominal) -> Result<StateSpace, Failure> {
    match (nominal, &model.physical) {
        (Nominal::Auto | Nominal::Physical, Some(physical)) if output == "psi" => lumped_psi(&lumped(physical)),
        (Nominal::Physical, _) => Err(bad(NoPlant::NoPhysical)),
        _ => from_matrices(model, output),
    }
}

/// Which description that is, by its name in the file.
pub fn nominal_name(model: &Model, output: &str, nominal: Nominal) -> &'static str {
    match (nominal, &model.physical) {
        (Nominal::Auto, Some(_)) if output == "psi" => "physical",
        (Nominal::Physical, _) => "physical",
        _ => "continuous",
    }
}

/// The four numbers as the rig's crate knows them.
pub fn lumped(physical: &flexbeam_files::Physical) -> Lumped {
    Lumped { k1: physical.k1, k2: physical.k2, c: physical.c, b: physical.b }
}

/// Voltage to tip angle of the lumped beam.
pub fn lumped_psi(lumped: &Lumped) -> Result<StateSpace, Failure> {
    lumped.state_space(&[Output::Psi]).map_err(Failure::while_trying("form the nominal plant"))
}

fn from_matrices(model: &Model, output: &str) -> Result<StateSpace, Failure> {
    if model.inputs.len() != 1 {
        return Err(bad(NoPlant::Inputs(model.inputs.clone())));
    }
    let rows = output_rows(model, output)?;
    let forming = "form the continuous nominal plant";
    let system = match model.continuous_state_space() {
        Some(continuous) => continuous.map_err(Failure::while_trying(forming))?,
        None => {
            let sampled = model.state_space().map_err(Failure::while_trying(forming))?;
            sampling::inverse_zoh(&sampled).map_err(Failure::while_trying(forming))?
        }
    };
    let all = connections::select(&system, &rows, &[0]).map_err(Failure::while_trying(forming))?;
    let sum = Mat::from_element(1, rows.len(), 1.0);
    StateSpace::new(all.A, all.B, &sum * all.C, &sum * all.D, all.time).map_err(Failure::while_trying(forming))
}

/// The row of that name, with or without its unit; psi is the sum of theta and alpha where no output has its name.
pub fn output_rows(model: &Model, output: &str) -> Result<Vec<usize>, Failure> {
    let row = |name: &str| {
        let with_unit = format!("{name}_rad");
        model.outputs.iter().position(|found| *found == name || *found == with_unit)
    };
    match (row(output), row("theta"), row("alpha")) {
        (Some(row), _, _) => Ok(vec![row]),
        (None, Some(theta), Some(alpha)) if output == "psi" => Ok(vec![theta, alpha]),
        _ => Err(bad(NoPlant::Output { wanted: output.into(), outputs: model.outputs.clone() })),
    }
}

fn bad(error: NoPlant) -> Failure {
    Failure::Input { tried: "form the nominal plant".into(), error: Box::new(error) }
}
