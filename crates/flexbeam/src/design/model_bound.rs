//! `design --uncertainty model`: the bound that the model file carries, if it is a bound for this design.

use flexbeam_design::Uncertainty;
use flexbeam_files::Model;

use crate::controller_file::uncertainty;
use crate::nominal::nominal_name;
use crate::{Failure, cli};

/// Two stability degrees within this of each other, relative, are one that went through a text file.
const SAME: f64 = 1e-9;

/// A bound that is not there, or is one of something else.
#[derive(Debug, thiserror::Error)]
enum NotThisBound {
    #[error(
        "the model has no table [uncertainty], which --uncertainty model asks for\nhint: flexbeam identify RECORDING --stability-degree {0} makes it"
    )]
    Missing(f64),
    #[error(
        "the model's bound was made for beta = {found}, needed {needed}: on another line it says nothing\nhint: design with --stability-degree {found}, or identify again with {needed}"
    )]
    Beta { found: f64, needed: f64 },
    #[error(
        "the model's bound is for {found}, needed one for {needed}\nhint: a bound from a recording is for psi and the plant of --nominal auto; --uncertainty takes coefficients, too"
    )]
    Plant { found: String, needed: String },
}

/// alpha(s) of the table `uncertainty`.
///
/// Errors: none there, another stability degree, another output or nominal plant.
pub(super) fn of_model(arguments: &cli::Design, model: &Model) -> Result<Uncertainty, Failure> {
    let refused = |error| Err(Failure::while_trying("take the model's uncertainty")(error));
    let needed = arguments.stability_degree;
    let Some(bound) = &model.uncertainty else { return refused(NotThisBound::Missing(needed)) };
    if (bound.beta - needed).abs() > SAME * needed.abs() {
        return refused(NotThisBound::Beta { found: bound.beta, needed });
    }
    if let Some(origin) = &bound.origin {
        let plant = nominal_name(model, &arguments.output_name, arguments.nominal);
        if (origin.output.as_str(), origin.nominal.as_str()) != (arguments.output_name.as_str(), plant) {
            let of = |output: &str, nominal: &str| format!("{output} of [{nominal}]");
            let found = of(&origin.output, &origin.nominal);
            return refused(NotThisBound::Plant { found, needed: of(&arguments.output_name, plant) });
        }
    }
    uncertainty(&bound.num, &bound.den)
}
