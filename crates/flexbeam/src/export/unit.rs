//! A controller as a functional mock-up unit.

use flexbeam_codegen::fmu::{self, SOURCES, Unit, Version};
use flexbeam_codegen::{Name, Precision, Subject};
use flexbeam_files::{
    Controller, Document, Overwrite, UnitResult, json_text, read_bytes, sha256_hex, write_bytes, zip_bytes,
};

use super::compiler::{self, Platform};
use super::source::checked;
use crate::controller_file::kernel_settings;
use crate::output::waiting;
use crate::{Failure, cli};

pub(super) fn export(arguments: &cli::Export) -> Result<(), Failure> {
    let tried = || format!("export {}", arguments.file.display());
    let name = Name::new(&arguments.name).map_err(Failure::while_trying(tried()))?;
    let version = Version::from(arguments.fmi.unwrap_or_default());
    let platform = match arguments.sources_only {
        true => None,
        false => Some(Platform::of_this_machine(version).map_err(Failure::while_trying(tried()))?),
    };
    let overwrite = if arguments.force { Overwrite::Allow } else { Overwrite::Refuse };
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
    let unit = fmu::unit(&subject, &name, version).map_err(Failure::while_trying(tried()))?;
    let binary = match platform {
        None => None,
        Some(platform) => Some(compiled(&unit, &name, &platform).map_err(Failure::while_trying(tried()))?),
    };
    let mut entries: Vec<(&str, &[u8])> =
        unit.files.iter().map(|file| (file.path.as_str(), file.text.as_bytes())).collect();
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
            source_sha256: sha256.clone(),
            order: file.order,
            period_s: file.period_s,
            unverified: unverified.clone(),
        },
    );
    Ok(())
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
