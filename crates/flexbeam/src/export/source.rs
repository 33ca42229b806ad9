//! A controller as C or Rust.

use flexbeam_codegen::{
    Name, Options, Precision, SingleBound, SingleError, SingleFigures, Source, Sources, Subject, c, rust,
};
use flexbeam_files::{
    Controller, Document, LoopFigures, Overwrite, SingleBoundResult, SingleErrorResult, SourceResult,
    check_free_folder, json_text, read_bytes, sha256_hex, write_folder,
};
use flexbeam_kernel::Settings;

use super::single;
use crate::controller_file::kernel_settings;
use crate::output::{say, waiting};
use crate::verify::broken_figures;
use crate::{Failure, cli};

/// A controller whose certificate does not match its numbers is not written, unless somebody says why it may be.
#[derive(Debug, thiserror::Error)]
#[error(
    "found a certificate that does not match the controller's numbers:\n  {}\nneeded every figure as it is claimed\nhint: design it again, or see `flexbeam verify`; --unverified REASON writes it all the same, with the reason in its head",
    .0.join("\n  ")
)]
struct NotCertified(Vec<String>);

/// Rounded to f32, it is another controller.
#[derive(Debug, thiserror::Error)]
#[error(
    "found a certificate that does not survive rounding to f32:\n  {}\nneeded every limit kept, and every figure within {percent} % of what is claimed\nhint: --precision f64, or a longer sample period; --unverified REASON writes it all the same, with the reason in its head",
    .0.join("\n  "),
    percent = 100.0 * single::WITHIN
)]
struct LostInRounding(Vec<String>);

pub(super) fn export(arguments: &cli::Export) -> Result<(), Failure> {
    let tried = || format!("export {}", arguments.file.display());
    let name = Name::new(arguments.name_or(cli::DEFAULT_NAME)).map_err(Failure::while_trying(tried()))?;
    let overwrite = if arguments.force { Overwrite::Allow } else { Overwrite::Refuse };
    check_free_folder(&arguments.out, overwrite)?;
    let file = Controller::read(&arguments.file)?;
    let sha256 = sha256_hex(&read_bytes(&arguments.file)?);
    let options = Options { name, precision: arguments.precision.unwrap_or_default().into() };
    let (sources, unverified) = sources(arguments, &file, &sha256, &options)?;
    let texts: Vec<(&str, &str)> = sources.files.iter().map(|file| (file.path.as_str(), file.text.as_str())).collect();
    write_folder(&arguments.out, &texts, overwrite)?;
    answer(arguments, &file, sha256, &sources, unverified);
    Ok(())
}

/// The files, and why they were made all the same.
fn sources(
    arguments: &cli::Export,
    file: &Controller,
    sha256: &str,
    options: &Options,
) -> Result<(Sources, Option<String>), Failure> {
    let settings = kernel_settings(&file.settings, None);
    let (figures, unverified) = checked(arguments, file, &settings, options.precision)?;
    let subject =
        Subject { controller: file, settings: &settings, sha256, figures: &figures, unverified: unverified.as_deref() };
    let sign = (options.precision == Precision::F32).then(|| waiting("bounding what f32 rounds away"));
    let sources = match arguments.form {
        cli::Form::Rust => rust::sources(&subject, options),
        _ => c::sources(&subject, options),
    };
    sign.inspect(|sign| sign.finish_and_clear());
    let tried = format!("export {}", arguments.file.display());
    Ok((sources.map_err(Failure::while_trying(tried))?, unverified))
}

/// The figures of what is written, and why it may be written although they do not match the certificate.
pub(super) fn checked(
    arguments: &cli::Export,
    file: &Controller,
    settings: &Settings,
    precision: Precision,
) -> Result<(LoopFigures, Option<String>), Failure> {
    let tried = || format!("export {}", arguments.file.display());
    let broken = broken_figures(file)?;
    if !broken.is_empty() && arguments.unverified.is_none() {
        return Err(Failure::while_trying(tried())(NotCertified(broken)));
    }
    let (figures, lost) = match precision {
        Precision::F64 => (file.certificate.sampled.clone(), Vec::new()),
        Precision::F32 => single::figures(file, settings, &tried())?,
    };
    if broken.is_empty() && !lost.is_empty() && arguments.unverified.is_none() {
        return Err(Failure::while_trying(tried())(LostInRounding(lost)));
    }
    let reasons: Vec<String> = broken.into_iter().chain(lost).collect();
    let unverified = arguments.unverified.as_ref().filter(|_| !reasons.is_empty()).map(|reason| {
        let text = format!("the certificate does not match ({}); written all the same: {reason}", reasons.join("; "));
        say(format_args!("warning: {text}"));
        text
    });
    Ok((figures, unverified))
}

fn answer(
    arguments: &cli::Export,
    file: &Controller,
    source_sha256: String,
    sources: &Sources,
    unverified: Option<String>,
) {
    let precision = arguments.precision.unwrap_or_default();
    let files: Vec<String> = sources.files.iter().map(|Source { path, .. }| path.clone()).collect();
    let folder = arguments.out.display().to_string();
    if !arguments.json {
        println!("{folder}: {}", files.join(", "));
        if let Some(single) = &sources.single {
            tell_single(single);
        }
        return;
    }
    let bound = sources.single.as_ref().map(|single| &single.bound);
    println!(
        "{}",
        json_text(&SourceResult {
            folder,
            files,
            format: if arguments.form == cli::Form::Rust { "rust" } else { "c" }.into(),
            precision: match precision {
                cli::Precision::F64 => "f64",
                cli::Precision::F32 => "f32",
            }
            .into(),
            name: arguments.name_or(cli::DEFAULT_NAME).into(),
            source: arguments.file.display().to_string(),
            source_sha256,
            order: file.order,
            period_s: file.period_s,
            single_error: sources.single.as_ref().map(|single| error_result(&single.error)),
            single_bound: bound.and_then(|bound| bound.as_ref().ok()).map(bound_result),
            no_bound: bound.and_then(|bound| bound.as_ref().err()).map(ToString::to_string),
            unverified,
        })
    );
}

fn tell_single(single: &SingleFigures) {
    let error = &single.error;
    println!(
        "f32 against f64 over {} ticks: voltage {:.2e} V, {:.2e} V under the switched law, angles {:.2e} rad at most",
        error.ticks, error.voltage_v, error.switched_voltage_v, error.angle_rad
    );
    match &single.bound {
        Ok(bound) => println!(
            "round the nominal loop, for references within {:.4} rad: never more than voltage {:.2e} V, u {:.2e} V, tip {:.2e} rad",
            bound.reference_rad, bound.voltage_v, bound.u_v, bound.tip_rad
        ),
        Err(why) => println!("round the nominal loop: no bound, for {why}"),
    }
}

fn error_result(error: &SingleError) -> SingleErrorResult {
    SingleErrorResult {
        ticks: error.ticks,
        voltage_v: error.voltage_v,
        switched_voltage_v: error.switched_voltage_v,
        u_v: error.u_v,
        angle_rad: error.angle_rad,
    }
}

fn bound_result(bound: &SingleBound) -> SingleBoundResult {
    SingleBoundResult {
        reference_rad: bound.reference_rad,
        deflection_rad: bound.deflection_rad,
        voltage_v: bound.voltage_v,
        u_v: bound.u_v,
        tip_rad: bound.tip_rad,
    }
}
