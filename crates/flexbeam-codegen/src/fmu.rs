//! A functional mock-up unit (FMI 2.0 or 3.0, co-simulation): all that goes into its archive but the binary.
//!
//! One step of the unit is one sample period: it takes the inputs as they stand at the step's beginning, and its answers are the
//! outputs at its end. So a controller's voltage is one period late, as in the real-time loop, and a rig's sensors are read behind the
//! period through which the voltage was held.

mod controller;
mod description;
mod rig;
mod variables;

use crate::template::filled;
use crate::{Error, Name, RigSubject, Source, Subject};
use flexbeam_files::sha256_hex;
use variables::{Enumeration, Variable};

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

/// What a unit is of: text, words and variables.
struct Part {
    /// `NAME.h`, `NAME.c`, `memory.h`, `memory.c`.
    sources: Vec<Source>,
    title: String,
    description: String,
    banner: String,
    /// Paragraphs of the documentation, with its own marks in them.
    about: &'static str,
    bits_of: &'static str,
    period_s: f64,
    variables: Vec<Variable>,
    /// Of which parameters an output is made before the first step; of those that are left out, none.
    made_of: &'static [(&'static str, &'static [&'static str])],
    enumerations: &'static [Enumeration],
}

/// The unit of a controller in f64.
///
/// Errors: [`Error::Kernel`] for a controller that was not read from a file.
pub fn unit(subject: &Subject<'_>, name: &Name, version: Version) -> Result<Unit, Error> {
    Ok(assembled(controller::part(subject, name)?, name, version))
}

/// The unit of a simulated rig.
///
/// Errors: [`Error::Rig`] for a quantity that no rig can have; [`Error::Delay`], [`Error::Counts`].
pub fn rig_unit(subject: &RigSubject<'_>, name: &Name, version: Version) -> Result<Unit, Error> {
    Ok(assembled(rig::part(subject, name)?, name, version))
}

fn assembled(mut part: Part, name: &Name, version: Version) -> Unit {
    let (interface, interface_text) = version.interface();
    let mut sources = std::mem::take(&mut part.sources);
    sources.push(Source { path: "fmu.h".into(), text: name.inserted(include_str!("../templates/fmu/fmu.h")) });
    sources.push(Source { path: "fmu.c".into(), text: name.inserted(include_str!("../templates/fmu/fmu.c")) });
    let guid = guid(&sources, version);
    let interface_text = filled(&name.inserted(interface_text), &[("GUID", &guid)]);
    sources.push(Source { path: interface.into(), text: interface_text });
    let compiled: Vec<String> = sources.iter().map(|s| s.path.clone()).filter(|path| path.ends_with(".c")).collect();
    let model = description::Model { part: &part, name, guid: &guid, compiled: &compiled };
    let mut files = vec![Source { path: "modelDescription.xml".into(), text: model.description(version) }];
    files.push(Source { path: "documentation/index.html".into(), text: documentation(&part, version) });
    files.extend(sources.into_iter().map(|Source { path, text }| Source { path: format!("{SOURCES}{path}"), text }));
    if version == Version::Three {
        files.push(Source { path: format!("{SOURCES}buildDescription.xml"), text: model.build_description() });
    }
    Unit { files, compiled }
}

/// Another controller or rig, another name, another version: another identity.
fn guid(sources: &[Source], version: Version) -> String {
    let texts: String = sources.iter().map(|source| source.text.as_str()).collect();
    let hex = sha256_hex(format!("{version:?}{texts}").as_bytes());
    let part = |from: usize, to: usize| &hex[from..to];
    format!("{{{}-{}-{}-{}-{}}}", part(0, 8), part(8, 12), part(12, 16), part(16, 20), part(20, 32))
}

fn documentation(part: &Part, version: Version) -> String {
    let about = filled(part.about, &[("PERIOD", &format!("{:?}", part.period_s)), ("VERSION", version.number())]);
    let marks = [
        ("TITLE", escaped(&part.title)),
        ("ABOUT", about),
        ("BANNER", escaped(&part.banner)),
        ("ROWS", variables::rows(&part.variables)),
        ("BITS_OF", part.bits_of.to_owned()),
    ];
    let marks: Vec<(&str, &str)> = marks.iter().map(|(mark, text)| (*mark, text.as_str())).collect();
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
