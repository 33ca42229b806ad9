//! A functional mock-up unit (FMI 2.0 or 3.0, co-simulation): all that goes into its archive but the binary.
//!
//! One step of the unit is one tick: it takes the inputs as they stand at the step's beginning, and its answers are the outputs at
//! its end. So the voltage is one period late, as in the real-time loop.

mod description;
mod variables;

use crate::numbers::Numbers;
use crate::template::filled;
use crate::{Error, Name, Precision, Source, Subject, c, heading};
use flexbeam_files::sha256_hex;

/// Version of the functional mock-up interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// 2.0
    Two,
    /// 3.0
    Three,
}

/// The unit without its binary.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// The files, by their paths in the archive; what is compiled lies under [`SOURCES`].
    pub files: Vec<Source>,
    /// What the compiler is given, below [`SOURCES`].
    pub compiled: Vec<String>,
}

/// The folder of the C text, with its slash.
pub const SOURCES: &str = "sources/";

impl Version {
    /// The file of the interface, and its text.
    fn interface(self) -> (&'static str, &'static str) {
        match self {
            Version::Two => ("fmi2.c", include_str!("../templates/fmu/fmi2.c")),
            Version::Three => ("fmi3.c", include_str!("../templates/fmu/fmi3.c")),
        }
    }
}

/// The unit of a controller in f64.
///
/// Errors: [`Error::Kernel`] for a controller that was not read from a file.
pub fn unit(subject: &Subject<'_>, name: &Name, version: Version) -> Result<Unit, Error> {
    let numbers = Numbers::new(subject, Precision::F64)?;
    let (interface, interface_text) = version.interface();
    let named = |text: &str| text.replace("NAME", name.as_str()).replace("UPPER", &name.upper());
    let mut sources = Vec::from(c::controller(subject, name, &numbers)?);
    sources.push(Source { path: "fmu.h".into(), text: named(include_str!("../templates/fmu/fmu.h")) });
    sources.push(Source { path: "fmu.c".into(), text: named(include_str!("../templates/fmu/fmu.c")) });
    let guid = guid(&sources, version);
    let interface_text = filled(&named(interface_text), &[("GUID", &guid)]);
    sources.push(Source { path: interface.into(), text: interface_text });
    let compiled: Vec<String> = sources.iter().map(|s| s.path.clone()).filter(|path| path.ends_with(".c")).collect();
    let model = description::Model { subject, name, guid: &guid, compiled: &compiled };
    let mut files = vec![Source { path: "modelDescription.xml".into(), text: model.description(version) }];
    files.push(Source { path: "documentation/index.html".into(), text: documentation(subject, version) });
    files.extend(sources.into_iter().map(|Source { path, text }| Source { path: format!("{SOURCES}{path}"), text }));
    if version == Version::Three {
        files.push(Source { path: format!("{SOURCES}buildDescription.xml"), text: model.build_description() });
    }
    Ok(Unit { files, compiled })
}

/// Another controller, another name, another version: another identity.
fn guid(sources: &[Source], version: Version) -> String {
    let texts: String = sources.iter().map(|source| source.text.as_str()).collect();
    let hex = sha256_hex(format!("{version:?}{texts}").as_bytes());
    let part = |from: usize, to: usize| &hex[from..to];
    format!("{{{}-{}-{}-{}-{}}}", part(0, 8), part(8, 12), part(12, 16), part(16, 20), part(20, 32))
}

fn documentation(subject: &Subject<'_>, version: Version) -> String {
    let marks = [
        ("TITLE", &*heading::title(subject, Precision::F64)),
        ("VERSION", version.number()),
        ("BANNER", &escaped(&heading::banner(subject, None, ""))),
        ("PERIOD", &format!("{:?}", subject.controller.period_s)),
        ("ROWS", &variables::rows(subject.settings)),
    ];
    filled(include_str!("../templates/fmu/index.html"), &marks)
}

/// For XML and HTML, between tags and in attributes.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_cannot_become_tags() {
        assert_eq!(escaped("a < b & \"c\" > d"), "a &lt; b &amp; &quot;c&quot; &gt; d");
    }

    #[test]
    fn an_identity_depends_on_every_byte() {
        let source = |text: &str| [Source { path: "a.c".into(), text: text.into() }];
        let found = guid(&source("a"), Version::Two);
        assert_eq!(found.len(), 38);
        assert_ne!(found, guid(&source("b"), Version::Two));
        assert_ne!(found, guid(&source("a"), Version::Three));
    }
}
