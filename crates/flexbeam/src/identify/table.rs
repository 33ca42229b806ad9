//! The answer for a person.

use flexbeam_files as files;
use flexbeam_report::{Cell, Table, engineering, significant};

use super::{Experiment, Found};
use crate::{cli, poles};

/// Head, poles, fits and physical parameters.
pub(super) fn text(arguments: &cli::Identify, experiment: &Experiment, found: &Found) -> String {
    let identified = &found.identified;
    let mut text = format!(
        "{}: order {} from {}\n{} samples of {}, the first {} estimate; {} block rows; identified in {}\n\n",
        arguments.out.display(),
        identified.order,
        arguments.recording.display(),
        experiment.inputs.samples(),
        engineering(experiment.inputs.period_s, 4, "s"),
        identified.estimation_samples,
        identified.block_rows,
        engineering(found.identify_s, 3, "s"),
    );
    if let Some(refinement) = &found.refinement {
        text.pop();
        text += &format!("{}\n\n", refinement.text());
    }
    let model = identified.continuous.as_ref().unwrap_or(&identified.model);
    text += &poles::table(model).text();
    text += "\n";
    text += &fits(experiment, found).text();
    if let Some(physical) = found.physical() {
        text += "\n";
        text += &physical_table(&physical).text();
    }
    text
}

fn fits(experiment: &Experiment, found: &Found) -> Table {
    let identified = &found.identified;
    let percent = |fit: f64| Cell::Number(if fit.is_finite() { format!("{fit:.2}") } else { "overflow".into() });
    let rows = experiment.outputs.names.iter().enumerate().map(|(k, name)| {
        let unseen = identified.fit_percent.as_ref().map_or("none left".into(), |fits| percent(fits[k]));
        [name.as_str().into(), unseen, percent(identified.estimation_fit_percent[k])]
    });
    let columns = [("output", ""), ("fit on unseen samples", "%"), ("on those that estimated", "%")];
    rows.fold(Table::new(&columns), Table::row)
}

/// k1, k2, c, b with their standard errors.
pub(crate) fn physical_table(physical: &files::Physical) -> Table {
    let rows = [
        ("k1 = K_stiff/J_base", physical.k1, physical.k1_std, "1/s²"),
        ("k2 = K_stiff (1/J_link + 1/J_base)", physical.k2, physical.k2_std, "1/s²"),
        ("c, damping of the hub", physical.c, physical.c_std, "1/s"),
        ("b, acceleration per volt", physical.b, physical.b_std, "rad/s²/V"),
    ];
    let columns = [("lumped link", ""), ("value", ""), ("standard error", ""), ("unit", "")];
    rows.into_iter().fold(Table::new(&columns), |table, (name, value, std, unit)| {
        let std = std.map_or("".to_string(), |std| significant(std, 2));
        table.row([name.into(), Cell::number(value, 7), Cell::Number(std), unit.into()])
    })
}
