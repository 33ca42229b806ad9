//! Rust: a `no_std` crate without dependencies, and a test with vectors.

use crate::c::{answers, inputs};
use crate::number::{bits, decimal};
use crate::numbers::Numbers;
use crate::settings::in_rust;
use crate::stimulus::Step;
use crate::template::filled;
use crate::vectors::{Check, Vectors};
use crate::{Error, Options, Precision, Source, Sources, Subject, heading};
use flexbeam_kernel::Commanded;

/// The files of the crate.
///
/// Errors: as [`crate::c::sources`], and [`Error::Name`] for capital letters.
pub fn sources(subject: &Subject<'_>, options: &Options) -> Result<Sources, Error> {
    let Options { name, precision } = options;
    let name = name.of_crate()?;
    let numbers = Numbers::new(subject, *precision)?;
    let vectors = Vectors::new(subject, &numbers, *precision)?;
    let single = vectors.single(subject, &numbers, *precision)?;
    let text = Text(*precision);
    let title = heading::title(subject, *precision);
    let named = |template: &str| template.replace("NAME", name);
    let banner = heading::banner(subject, single.as_ref(), "//!");
    let files = [
        ("Cargo.toml", filled(&named(include_str!("../templates/rust/Cargo.toml")), &[("TITLE", &title)])),
        ("README.md", filled(&named(include_str!("../templates/rust/README.md")), &[("TITLE", &title)])),
        ("src/lib.rs", text.library(subject, &numbers, &title, &banner)?),
        ("src/law.rs", include_str!("../templates/rust/src/law.rs").to_owned()),
        ("src/settings.rs", include_str!("../templates/rust/src/settings.rs").to_owned()),
        ("src/tick.rs", include_str!("../templates/rust/src/tick.rs").to_owned()),
        ("tests/vectors.rs", text.vectors(&named(include_str!("../templates/rust/tests/vectors.rs")), &vectors)),
    ];
    let files = files.into_iter().map(|(path, text)| Source { path: path.to_owned(), text });
    Ok(Sources { files: files.collect(), single })
}

/// How numbers look.
struct Text(Precision);

impl Text {
    fn library(&self, subject: &Subject<'_>, numbers: &Numbers, title: &str, banner: &str) -> Result<String, Error> {
        let check = Check::new(numbers, self.0)?;
        let row = |numbers: &[f64]| format!("    [{}],", self.list(numbers));
        let checked_inputs: Vec<String> = check.ticks.iter().map(|(measured, _)| row(&inputs(measured))).collect();
        let checked_answers: Vec<String> = check.ticks.iter().map(|(_, answer)| row(&answers(answer))).collect();
        let real = match self.0 {
            Precision::F64 => "f64",
            Precision::F32 => "f32",
        };
        let marks = [
            ("TITLE", title),
            ("BANNER", banner),
            ("REAL", real),
            ("ORDER", &numbers.order.to_string()),
            ("PERIOD", &format!("{:?}", subject.controller.period_s)),
            ("SHA256", subject.sha256),
            ("SETTINGS", &in_rust(&numbers.settings, self.0, "")),
            ("AB", &self.lines(numbers.ab())),
            ("CD", &self.lines(numbers.cd())),
            ("CHECKED_SETTINGS", &in_rust(&check.settings, self.0, "")),
            ("CHECKED_TICKS", &check.ticks.len().to_string()),
            ("CHECKED_INPUTS", &checked_inputs.join("\n")),
            ("CHECKED_ANSWERS", &checked_answers.join("\n")),
        ];
        Ok(filled(include_str!("../templates/rust/src/lib.rs"), &marks))
    }

    fn vectors(&self, template: &str, vectors: &Vectors) -> String {
        let (made_by, unsigned) = match self.0 {
            Precision::F64 => ("kernel", "u64"),
            Precision::F32 => ("own f32 form of the kernel", "u32"),
        };
        let settings: Vec<String> =
            vectors.settings.iter().map(|s| format!("    {},", in_rust(s, self.0, "    "))).collect();
        let list = |numbers: &[f64]| numbers.iter().map(|&x| bits(x, self.0)).collect::<Vec<_>>().join(", ");
        let row = |(step, answer): (&Step, &Commanded)| {
            let (asked, answered) = (list(&inputs(&step.measured)), list(&answers(answer)));
            let (settings, reset, fault) = (step.settings, step.reset, answer.fault);
            format!("    Vector({settings}, {reset}, Fault::{fault:?}, [{asked}], [{answered}]),")
        };
        let rows: Vec<String> = vectors.steps.iter().zip(&vectors.answers).map(row).collect();
        let marks = [
            ("MADE_BY", made_by),
            ("BITS", unsigned),
            ("VECTOR_SETTINGS", &*vectors.settings.len().to_string()),
            ("SETTINGS", &settings.join("\n")),
            ("VECTORS", &vectors.steps.len().to_string()),
            ("ROWS", &rows.join("\n")),
        ];
        filled(template, &marks)
    }

    fn lines(&self, numbers: &[f64]) -> String {
        numbers.chunks(6).map(|part| format!("    {},", self.list(part))).collect::<Vec<_>>().join("\n")
    }

    fn list(&self, numbers: &[f64]) -> String {
        numbers.iter().map(|&x| decimal(x, self.0)).collect::<Vec<_>>().join(", ")
    }
}
