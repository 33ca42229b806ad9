//! A controller or a rig as a functional mock-up unit.

use std::path::Path;

use flexbeam_codegen::fmu::{self, SOURCES, Unit, Version};
use flexbeam_codegen::{Name, Precision, RigSubject, Subject};
use flexbeam_files::{
    Controller, Document, Error, Fault, Overwrite, Rig, Tried, UnitResult, json_text, read_bytes, schema_of,
    sha256_hex, write_bytes, zip_bytes,
};

use super::Idle;
use super::compiler::{self, Platform};
use super::source::checked;
use crate::controller_file::kernel_settings;
use crate::output::waiting;
use crate::rig_file::rig_parameters;
use crate::{Failure, cli};

/// Stands for the rig that no file describes.
const PAPER: &str = "paper";

/// The unit without its binary, and what is said of it.
struct Written {
    unit: Unit,
    schema: &'static str,
    sha256: Option<String>,
    order: usize,
    period_s: f64,
    unverified: Option<String>,
}

pub(super) fn export(arguments: &cli::Export) -> Result<(), Failure> {
    let tried = || format!("export {}", arguments.file.display());
    let of_rig = is_rig(&arguments.file)?;
    let name = Name::new(arguments.name_or(if of_rig { "rig" } else { cli::DEFAULT_NAME }))
        .map_err(Failure::while_trying(tried()))?;
    let version = Version::from(arguments.fmi.unwrap_or_default());
    let platform = match arguments.sources_only {
        true => None,
        false => Some(Platform::of_this_machine(version).map_err(Failure::while_trying(tried()))?),
    };
    let overwrite = if arguments.force { Overwrite::Allow } else { Overwrite::Refuse };
    let written = match of_rig {
        true => rig(arguments, &name, version)?,
        false => controller(arguments, &name, version)?,
    };
    let binary = match platform {
        None => None,
        Some(platform) => Some(compiled(&written.unit, &name, &platform).map_err(Failure::while_trying(tried()))?),
    };
    let mut entries: Vec<(&str, &[u8])> =
        written.unit.files.iter().map(|file| (file.path.as_str(), file.text.as_bytes())).collect();
    entries.extend(binary.iter().map(|(path, bytes)| (path.as_str(), bytes.as_slice())));
    let bytes = zip_bytes(&entries);
    write_bytes(&arguments.out, &bytes, overwrite)?;
    answer(
        arguments,
        UnitResult {
            file: arguments.out.display().to_string(),
            sha256: sha256_hex(&bytes),
            files: entries.iter().map(|(path, _)| (*path).to_owned()).collect(),
            format: "fmu".into(),
            fmi: version.number().into(),
            name: name.as_str().into(),
            source: arguments.file.display().to_string(),
            source_sha256: written.sha256,
            schema: written.schema.into(),
            order: written.order,
            period_s: written.period_s,
            unverified: written.unverified,
        },
    );
    Ok(())
}

/// By the word or by the schema.
///
/// Errors: neither a controller nor a rig.
fn is_rig(file: &Path) -> Result<bool, Error> {
    if file == Path::new(PAPER) {
        return Ok(true);
    }
    let needed = "flexbeam.controller/1 or flexbeam.rig/1";
    let refused = |fault| Err(Error::new(Tried::Read, file, fault));
    match schema_of(file)?.as_deref() {
        Some(Rig::SCHEMA) => Ok(true),
        Some(Controller::SCHEMA) => Ok(false),
        Some(found) => refused(Fault::Schema { found: found.into(), needed }),
        None => refused(Fault::NoSchema { needed }),
    }
}

fn controller(arguments: &cli::Export, name: &Name, version: Version) -> Result<Written, Failure> {
    let file = Controller::read(&arguments.file)?;
    let sha256 = sha256_hex(&read_bytes(&arguments.file)?);
    let settings = kernel_settings(&file.settings, None);
    let (figures, unverified) = checked(arguments, &file, &settings, Precision::F64)?;
    let subject = Subject {
        controller: &file,
        settings: &settings,
        sha256: &sha256,
        figures: &figures,
        unverified: unverified.as_deref(),
    };
    let tried = format!("export {}", arguments.file.display());
    let unit = fmu::unit(&subject, name, version).map_err(Failure::while_trying(tried))?;
    let (order, period_s) = (file.order, file.period_s);
    Ok(Written { unit, schema: Controller::SCHEMA, sha256: Some(sha256), order, period_s, unverified })
}

fn rig(arguments: &cli::Export, name: &Name, version: Version) -> Result<Written, Failure> {
    let tried = || format!("export {}", arguments.file.display());
    if arguments.unverified.is_some() {
        let idle = Idle { option: "--unverified", form: "fmu of a rig", needed: "a controller" };
        return Err(Failure::while_trying(tried())(idle));
    }
    let file = Some(arguments.file.as_path()).filter(|file| *file != Path::new(PAPER));
    let parameters = rig_parameters(file)?;
    let sha256 = file.map(read_bytes).transpose()?.map(|bytes| sha256_hex(&bytes));
    let subject = RigSubject { parameters: &parameters, sha256: sha256.as_deref() };
    let unit = fmu::rig_unit(&subject, name, version).map_err(Failure::while_trying(tried()))?;
    let motion = parameters.motion().map_err(Failure::while_trying(tried()))?;
    let (order, period_s) = (2 + 2 * motion.link_coordinates(), parameters.period_s);
    Ok(Written { unit, schema: Rig::SCHEMA, sha256, order, period_s, unverified: None })
}

/// The binary with its path in the archive.
fn compiled(unit: &Unit, name: &Name, platform: &Platform) -> Result<(String, Vec<u8>), compiler::Error> {
    let sign = waiting("compiling");
    let texts = unit.files.iter().filter_map(|file| Some((file.path.strip_prefix(SOURCES)?, file.text.as_str())));
    let bytes = compiler::library(&texts.collect::<Vec<_>>(), &unit.compiled)?;
    sign.finish_and_clear();
    Ok((format!("binaries/{}/{}.so", platform.folder, name.as_str()), bytes))
}

fn answer(arguments: &cli::Export, result: UnitResult) {
    if arguments.json {
        println!("{}", json_text(&result));
    } else {
        println!("{}: FMI {}: {}", result.file, result.fmi, result.files.join(", "));
    }
}
