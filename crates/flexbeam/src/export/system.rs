//! A model or a controller as data: for MATLAB, with a script that rebuilds the loop, or as JSON.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use flexbeam_files::{
    Controller, Document, Error, Fault, MatVariable, Model, Overwrite, SystemResult, Tried, check_free_for_json,
    check_free_for_mat, check_free_for_script, is_mat_name, json_document, json_text, mat_bytes, mat_of_controller,
    mat_of_model, read_bytes, sha256_hex, write_bytes,
};
use flexbeam_lti::{StateSpace, Time};

use crate::controller_file::controller_system;
use crate::output::{provenance, say};
use crate::verify::broken_figures;
use crate::{Failure, cli};

const HEAD: &str = include_str!("matlab/head.m");
const CONTROLLER: &str = include_str!("matlab/controller.m");
const MODEL: &str = include_str!("matlab/model.m");
const COMPARE: &str = include_str!("matlab/compare.m");

/// A name by which MATLAB could not run the script, or by which the script would run itself in place of a function.
#[derive(Debug, thiserror::Error)]
enum NoScript {
    #[error(
        "found the name {found:?}, needed one that ends in .mat\nhint: the script beside it has the same name and .m"
    )]
    Ending { found: String },
    #[error(
        "found the name {found:?}, needed a name of MATLAB's: letters, digits and underscores, a letter first, 63 at most, no word of the language\nhint: --out {suggestion}.mat; the script beside it is run by that name"
    )]
    Name { found: String, suggestion: String },
    #[error("found the name {found:?}, which the script beside the file calls itself\nhint: --out {found}_1.mat")]
    Called { found: String },
}

/// A model or a controller.
enum System {
    Model(Box<Model>),
    Controller(Box<Controller>),
}

pub(super) fn export(arguments: &cli::Export, schema: &str) -> Result<(), Failure> {
    let tried = || format!("export {}", arguments.file.display());
    let overwrite = if arguments.force { Overwrite::Allow } else { Overwrite::SameKind };
    let script = match arguments.form {
        cli::Form::Json => None,
        _ => Some(script_path(&arguments.out).map_err(Failure::while_trying(tried()))?),
    };
    match &script {
        None => check_free_for_json(&arguments.out, overwrite)?,
        Some(script) => {
            check_free_for_mat(&arguments.out, overwrite)?;
            check_free_for_script(script, overwrite)?;
        }
    }
    let system = System::read(&arguments.file, schema)?;
    let source_sha256 = sha256_hex(&read_bytes(&arguments.file)?);
    let notice = system.notice()?;
    if let Some(notice) = &notice {
        say(format_args!("warning: {notice}"));
    }
    let bytes = match &script {
        None => system.json(&arguments.out)?.into_bytes(),
        Some(_) => system.mat(arguments, &source_sha256, notice.as_deref())?,
    };
    write_bytes(&arguments.out, &bytes, overwrite)?;
    if let Some(script) = &script {
        write_bytes(script, system.script().as_bytes(), overwrite)?;
    }
    let G = system.state_space()?;
    answer(
        arguments,
        SystemResult {
            file: arguments.out.display().to_string(),
            sha256: sha256_hex(&bytes),
            format: if script.is_some() { "mat" } else { "json" }.into(),
            script: script.map(|script| script.display().to_string()),
            source: arguments.file.display().to_string(),
            source_sha256,
            schema: schema.into(),
            order: G.order(),
            period_s: match G.time {
                Time::Continuous => None,
                Time::Sampled { period_s } => Some(period_s),
            },
            notice,
        },
    );
    Ok(())
}

/// The script's path, of the same name as the file.
fn script_path(out: &Path) -> Result<PathBuf, NoScript> {
    let name = out.file_name().unwrap_or_default().to_string_lossy();
    let Some(stem) = name.strip_suffix(".mat") else { return Err(NoScript::Ending { found: name.into() }) };
    if !is_mat_name(stem) {
        return Err(NoScript::Name { found: stem.into(), suggestion: flexbeam_files::mat_name(stem) });
    }
    if called().contains(stem) {
        return Err(NoScript::Called { found: stem.into() });
    }
    Ok(out.with_extension("m"))
}

/// What the scripts call: every word before a parenthesis.
fn called() -> BTreeSet<&'static str> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let before = [HEAD, CONTROLLER, MODEL, COMPARE].into_iter().flat_map(|text| text.split('('));
    before.filter_map(|text| text.rsplit(|c| !is_word(c)).next()).filter(|word| !word.is_empty()).collect()
}

impl System {
    fn read(file: &Path, schema: &str) -> Result<System, Error> {
        if schema == Model::SCHEMA {
            Ok(System::Model(Box::new(Model::read(file)?)))
        } else {
            Ok(System::Controller(Box::new(Controller::read(file)?)))
        }
    }

    fn state_space(&self) -> Result<StateSpace, Failure> {
        match self {
            System::Model(model) => model.state_space().map_err(Failure::while_trying("use the model")),
            System::Controller(controller) => controller_system(controller),
        }
    }

    /// A certificate that does not match is data like any other, but not in silence.
    fn notice(&self) -> Result<Option<String>, Failure> {
        let System::Controller(controller) = self else { return Ok(None) };
        let broken = broken_figures(controller)?;
        let text = || format!("the certificate does not match the controller's numbers: {}", broken.join("; "));
        Ok((!broken.is_empty()).then(text))
    }

    fn json(&self, out: &Path) -> Result<String, Error> {
        match self {
            System::Model(model) => json_document(&**model, out),
            System::Controller(controller) => json_document(&**controller, out),
        }
    }

    /// The document's variables, and where they came from.
    fn mat(&self, arguments: &cli::Export, sha256: &str, notice: Option<&str>) -> Result<Vec<u8>, Failure> {
        let out = &arguments.out;
        let poles = self.state_space()?.poles();
        let mut variables = match self {
            System::Model(model) => mat_of_model(model, &poles, out)?,
            System::Controller(controller) => mat_of_controller(controller, &poles, out)?,
        };
        let origin = provenance(&[&arguments.file], out)?;
        let source = origin.parents.first().map(|parent| parent.path.clone()).unwrap_or_default();
        let texts = [
            ("source", source),
            ("source_sha256", sha256.into()),
            ("tool", origin.tool),
            ("command", origin.command.unwrap_or_default()),
        ];
        let notice = notice.map(|notice| ("notice", notice.to_string()));
        let texts = texts.into_iter().chain(notice);
        variables.extend(texts.map(|(name, text)| (name.to_string(), MatVariable::Text(text))));
        let written = mat_bytes(&variables).map_err(|fault: Fault| Error::new(Tried::Write, out, fault))?;
        Ok(written)
    }

    fn script(&self) -> String {
        let own = match self {
            System::Model(_) => MODEL,
            System::Controller(_) => CONTROLLER,
        };
        [HEAD, own, COMPARE].concat()
    }
}

fn answer(arguments: &cli::Export, result: SystemResult) {
    if arguments.json {
        println!("{}", json_text(&result));
        return;
    }
    let script = result.script.map(|script| format!(", {script}")).unwrap_or_default();
    println!("{}{script}: {} of order {} from {}", result.file, result.schema, result.order, result.source);
}

#[cfg(test)]
mod tests {
    use flexbeam_files::SCRIPT_HEAD;

    use super::*;

    #[test]
    fn scripts_are_known_again_and_do_not_call_themselves() {
        assert!(HEAD.starts_with(SCRIPT_HEAD));
        assert!(["ss", "c2d", "load", "mean", "warning", "pkg"].iter().all(|name| called().contains(name)));
        for name in ["controller.mat", "model.mat", "beam_1.mat", "plant.mat"] {
            assert!(script_path(Path::new(name)).is_ok(), "{name}");
        }
    }
}
