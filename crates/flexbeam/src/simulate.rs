//! `flexbeam simulate`: a step of the tip angle on the nonlinear rig.

use flexbeam_files::{Controller, Law, Overwrite, SimulateResult, json_text, write_signals};
use flexbeam_kernel as kernel;
use flexbeam_report::{Cell, Table};

use crate::Failure;
use crate::cli;
use crate::controller_file::kernel_settings;
use crate::law::law_name;
use crate::output::{folder, write_figure};
use crate::project::controller_and_rig;
use crate::record::MOST_SAMPLES;
use crate::response::{linear_rig, rig_at, step_response};

/// A number on the command line that makes no sense.
#[derive(Debug, thiserror::Error)]
#[error("{name} is {found}, needed {needed}\nhint: `flexbeam simulate --help` lists units and defaults")]
struct Setting {
    name: &'static str,
    found: f64,
    needed: &'static str,
}

/// Runs the command.
pub fn run(arguments: &cli::Simulate) -> Result<(), Failure> {
    let (file, rig) = controller_and_rig(&arguments.controller, arguments.rig.as_deref())?;
    let tried = || format!("simulate {}", arguments.controller.display());
    let mut rig = rig_at(rig.as_deref(), file.period_s)?;
    let samples = arguments.duration / file.period_s;
    let fits = samples > 0.0 && samples <= MOST_SAMPLES;
    expect(tried, "--duration [s]", arguments.duration, fits, "a positive number, at most 10^8 periods")?;
    expect(tried, "--step-deg", arguments.step_deg, arguments.step_deg != 0.0, "a number that is not 0")?;
    if arguments.linear {
        rig = linear_rig(&rig);
    }
    let law = law_in_force(arguments, &file);
    let settings = kernel_settings(&file.settings, Some(law));
    let coefficients = file.coefficients();
    let controller = kernel::Controller::new(file.order, &coefficients).map_err(Failure::while_trying(tried()))?;
    let step_rad = arguments.step_deg.to_radians();
    let response = step_response(&rig, &settings, &controller, step_rad, arguments.duration, arguments.seed)?;

    folder(&arguments.out)?;
    let signals = response.record.signals();
    let time_s = &response.record.time_s;
    write_signals(&signals, Some(time_s), &arguments.out.join("response.csv"), Overwrite::SameKind)?;
    let title = format!("Step of {}°, {}", arguments.step_deg, law_name(law));
    let mut files = vec!["response.csv".to_string()];
    files.extend(write_figure(&arguments.out, "response", &response.figure(&title))?);
    let result = response.result(law, arguments.seed, files);
    if arguments.json {
        println!("{}", json_text(&result));
    } else {
        print!("{}", table(&result).text());
        eprintln!("wrote {} in {}", result.files.join(", "), arguments.out.display());
    }
    response.stopped().map_or(Ok(()), |stopped| Err(Failure::Fault(Box::new(stopped))))
}

fn expect(
    tried: impl Fn() -> String,
    name: &'static str,
    found: f64,
    holds: bool,
    needed: &'static str,
) -> Result<(), Failure> {
    if holds && found.is_finite() {
        Ok(())
    } else {
        Err(Failure::while_trying(tried())(Setting { name, found, needed }))
    }
}

/// The command line's law, or the file's; a linear run needs none.
fn law_in_force(arguments: &cli::Simulate, file: &Controller) -> Law {
    let of_file = if arguments.linear { Law::None } else { file.settings.law.unwrap_or(Law::Inverse) };
    arguments.law.map_or(of_file, Law::from)
}

fn table(result: &SimulateResult) -> Table {
    let number = |x: f64, digits| Cell::number(x, digits);
    let yes_no = |yes: bool| Cell::from(if yes { "yes" } else { "no" });
    let table = Table::new(&[("figure", ""), ("value", ""), ("unit", "")])
        .row([
            "settling time (2 %)".into(),
            result.settling_time_s.map_or("never".into(), |t| number(t, 4)),
            "s".into(),
        ])
        .row(["overshoot".into(), number(result.overshoot_percent, 3), "%".into()])
        .row(["stationary error".into(), number(result.stationary_error_rad.to_degrees(), 3), "deg".into()])
        .row(["residual vibration".into(), number(result.residual_vibration_rad.to_degrees(), 3), "deg".into()])
        .row(["peak voltage".into(), number(result.peak_voltage_v, 4), "V".into()])
        .row(["limit cycle".into(), yes_no(result.limit_cycle), "".into()]);
    match &result.fault {
        Some(_) => table.row(["stopped by a fault".into(), "yes".into(), "".into()]),
        None => table,
    }
}
