//! `identify --stability-degree`: the bound alpha(s) that the recording gives, into the table `uncertainty`.

use flexbeam_files::{BoundOrigin, Model, Uncertainty};
use flexbeam_ident::bound::{FromRecording, Settings, from_recording};
use flexbeam_ident::{Error, Options};
use flexbeam_report::significant;

use super::{Experiment, Hinted};
use crate::Failure;
use crate::nominal::{Nominal, nominal_name, nominal_plant, output_rows};
use crate::output::waiting;

/// What a bound from a recording is of: the output that a design controls unless it is told otherwise.
pub(super) const OUTPUT: &str = "psi";

/// alpha(s) between the plant that `design` takes from this model and the recorded beam.
///
/// Errors: a model without psi or a continuous plant; those of [`from_recording`].
pub(super) fn uncertainty(
    model: &Model,
    experiment: &Experiment,
    options: &Options,
    beta: f64,
) -> Result<Uncertainty, Failure> {
    let nominal = nominal_plant(model, OUTPUT, Nominal::Auto)?;
    let rows = output_rows(model, OUTPUT)?;
    let settings = Settings { estimation: options.clone(), ..Settings::new(beta) };
    let _sign = waiting("bounding what the model leaves out");
    let found =
        from_recording(&experiment.inputs, &experiment.outputs, &nominal, &rows, &settings).map_err(
            |why| match why {
                Error::PoleBeyond { .. } | Error::PoleUncertain { .. } => Failure::No(Box::new(Hinted(why))),
                why => Failure::while_trying("bound what the model leaves out")(Hinted(why)),
            },
        )?;
    say(&found, beta);
    let FromRecording { bound, band, full, .. } = found;
    let alpha = bound.alpha.rational().map_err(Failure::while_trying("write alpha(s) by its coefficients"))?;
    Ok(Uncertainty {
        num: alpha.num,
        den: alpha.den,
        beta,
        origin: Some(BoundOrigin {
            output: OUTPUT.into(),
            nominal: nominal_name(model, OUTPUT, Nominal::Auto).into(),
            level: band.level,
            full_order: full.identified.order,
            contradicted: full.contradicted,
            replicates: settings.replicates,
        }),
    })
}

fn say(found: &FromRecording, beta: f64) {
    let FromRecording { bound, band, full, .. } = found;
    eprintln!(
        "bound at beta = {beta}: a model of order {} differs from the nominal plant by up to {} rad/V on the shifted line, and the \
         recording leaves {} at {:.0} %",
        full.identified.order,
        significant(bound.difference, 3),
        significant(bound.radius, 3),
        100.0 * band.level,
    );
    if full.contradicted {
        eprintln!(
            "note: what that model leaves of the recording still answers to the voltage (friction, more modes): it was measured on \
             s = jw and added, which holds on the shifted line by assumption only"
        );
    }
}
