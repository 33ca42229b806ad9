//! C99: a header, a source, vectors, a test, a program for the UDP frame, and what builds them.

use crate::number::hexadecimal;
use crate::numbers::Numbers;
use crate::settings::in_c;
use crate::template::{ARITHMETIC, filled};
use crate::vectors::{Check, SingleFigures, Vectors};
use crate::{Error, Name, Options, Precision, Source, Sources, Subject, heading};
use flexbeam_kernel::{Commanded, Measured};

/// The files, by the name of the options.
///
/// Errors: [`Error::Overflow`], [`Error::Subnormal`] in f32; [`Error::Kernel`] for a controller that was not read from a file.
pub fn sources(subject: &Subject<'_>, options: &Options) -> Result<Sources, Error> {
    let Options { name, precision } = options;
    let numbers = Numbers::new(subject, *precision)?;
    let vectors = Vectors::new(subject, &numbers, *precision)?;
    let single = vectors.single(subject, &numbers, *precision)?;
    let text = Text { precision: *precision, upper: name.upper() };
    let title = heading::title(subject, *precision);
    let no_marks: &[(&str, &str)] = &[];
    let files = [
        ("Makefile", include_str!("../templates/c/Makefile"), no_marks),
        ("CMakeLists.txt", include_str!("../templates/c/CMakeLists.txt"), &[]),
        ("README.md", include_str!("../templates/c/README.md"), &[("TITLE", title.as_str())]),
        ("main_udp.c", include_str!("../templates/c/main_udp.c"), &[]),
        ("test_NAME.c", include_str!("../templates/c/test_NAME.c"), &[]),
    ];
    let mut files: Vec<(String, String)> = files
        .into_iter()
        .map(|(path, template, marks)| (path.to_owned(), text.named(options, template, marks)))
        .collect();
    files.extend(text.controller(subject, options, &numbers, single.as_ref())?);
    files.extend(text.vectors(options, &vectors));
    files.extend(FRAME.map(|(path, text)| (path.to_owned(), text.to_owned())));
    let files = files.into_iter().map(|(path, text)| Source { path: path.replace("NAME", name.as_str()), text });
    Ok(Sources { files: files.collect(), single })
}

/// Header and source of the controller alone, in f64.
///
/// Errors: those of the kernel.
pub(crate) fn controller(subject: &Subject<'_>, name: &Name, numbers: &Numbers) -> Result<[Source; 2], Error> {
    let text = Text { precision: Precision::F64, upper: name.upper() };
    let options = Options { name: name.clone(), precision: Precision::F64 };
    let files = text.controller(subject, &options, numbers, None)?;
    Ok(files.map(|(path, text)| Source { path: path.replace("NAME", name.as_str()), text }))
}

/// The frame between host and rig: the text that flexbeam-runtime tests, not a copy of it.
const FRAME: [(&str, &str); 2] = [
    ("flexbeam_frame.h", include_str!("../../flexbeam-runtime/firmware/flexbeam_frame.h")),
    ("flexbeam_frame.c", include_str!("../../flexbeam-runtime/firmware/flexbeam_frame.c")),
];

/// How numbers look.
struct Text {
    precision: Precision,
    upper: String,
}

impl Text {
    fn real(&self) -> &'static str {
        match self.precision {
            Precision::F64 => "double",
            Precision::F32 => "float",
        }
    }

    fn named(&self, options: &Options, template: &str, marks: &[(&str, &str)]) -> String {
        filled(&options.name.inserted(template), marks)
    }

    /// NAME.h, NAME.c.
    fn controller(
        &self,
        subject: &Subject<'_>,
        options: &Options,
        numbers: &Numbers,
        single: Option<&SingleFigures>,
    ) -> Result<[(String, String); 2], Error> {
        let header = [
            ("TITLE", &*heading::title(subject, self.precision)),
            ("BANNER", &heading::banner(subject, single, " *")),
            ("ORDER", &numbers.order.to_string()),
            ("PERIOD", &format!("{:?}", subject.controller.period_s)),
            ("SHA256", subject.sha256),
            ("REAL", self.real()),
        ];
        let header = self.named(options, include_str!("../templates/c/NAME.h"), &header);
        Ok([("NAME.h".into(), header), ("NAME.c".into(), self.source(options, numbers)?)])
    }

    fn source(&self, options: &Options, numbers: &Numbers) -> Result<String, Error> {
        let (mantissa, digits) = match self.precision {
            Precision::F64 => ("DBL_MANT_DIG", f64::MANTISSA_DIGITS),
            Precision::F32 => ("FLT_MANT_DIG", f32::MANTISSA_DIGITS),
        };
        let check = Check::new(numbers, self.precision)?;
        let row = |numbers: &[f64]| format!("    {{{}}},", self.list(numbers));
        let inputs: Vec<String> = check.ticks.iter().map(|(measured, _)| row(&inputs(measured))).collect();
        let answers: Vec<String> = check.ticks.iter().map(|(_, commanded)| row(&answers(commanded))).collect();
        let marks = [
            ("ARITHMETIC", ARITHMETIC.trim_end()),
            ("MANTISSA_DIGITS", mantissa),
            ("DIGITS", &digits.to_string()),
            ("GAINS", &self.gains(numbers)),
            ("SETTINGS", &in_c(&numbers.settings, &self.upper, self.precision, "    ")),
            ("CHECKED_TICKS", &check.ticks.len().to_string()),
            ("CHECKED_SETTINGS", &in_c(&check.settings, &self.upper, self.precision, "    ")),
            ("CHECKED_INPUTS", &inputs.join("\n")),
            ("CHECKED_ANSWERS", &answers.join("\n")),
        ];
        Ok(self.named(options, include_str!("../templates/c/NAME.c"), &marks))
    }

    /// [A B] for a controller that has states, [C D].
    fn gains(&self, numbers: &Numbers) -> String {
        let n = numbers.order;
        let of_input =
            |j: usize| ["v", "y", "u_applied"].get(j.wrapping_sub(n)).map_or(format!("x[{j}]"), |s| (*s).into());
        let column = |(j, column): (usize, &[f64])| {
            let lines: Vec<String> = column.chunks(6).map(|part| format!("     {}", self.list(part))).collect();
            format!("    {{ /* {} */\n{}}},", of_input(j), lines.join(",\n"))
        };
        let pair = |(j, pair): (usize, &[f64])| format!("    {}, /* {} */", self.list(pair), of_input(j));
        let cd: Vec<String> = numbers.cd().chunks(2).enumerate().map(pair).collect();
        let cd = format!(
            "/* (u, y_model) = [C D] (x, v, y): a column a line. */\nstatic const real CD[2 * ({upper}_ORDER + 2)] = {{\n{}\n}};\n",
            cd.join("\n"),
            upper = self.upper
        );
        if n == 0 {
            return cd;
        }
        let ab: Vec<String> = numbers.ab().chunks(n).enumerate().map(column).collect();
        format!(
            "/* x+ = [A B] (x, v, y, u_applied): column by column. */\nstatic const real AB[{upper}_ORDER + 3][{upper}_ORDER] = \
             {{\n{}\n}};\n\n{cd}",
            ab.join("\n"),
            upper = self.upper
        )
    }

    fn list(&self, numbers: &[f64]) -> String {
        numbers.iter().map(|&x| hexadecimal(x, self.precision)).collect::<Vec<_>>().join(", ")
    }

    fn vectors(&self, options: &Options, vectors: &Vectors) -> [(String, String); 2] {
        let made_by = match self.precision {
            Precision::F64 => "kernel",
            Precision::F32 => "own f32 form of the kernel",
        };
        let header = [
            ("MADE_BY", made_by),
            ("VECTORS", &vectors.steps.len().to_string()),
            ("VECTOR_SETTINGS", &vectors.settings.len().to_string()),
        ];
        let settings = vectors
            .settings
            .iter()
            .map(|s| format!("    {{\n{}\n    }},", in_c(s, &self.upper, self.precision, "        ")));
        let row = |(step, commanded): (&crate::stimulus::Step, &Commanded)| {
            let (inputs, answers) = (self.list(&inputs(&step.measured)), self.list(&answers(commanded)));
            let (settings, reset, fault) = (step.settings, u8::from(step.reset), commanded.fault as u8);
            format!("    {{{settings}, {reset}, {fault}, {{{inputs}}},\n     {{{answers}}}}},")
        };
        let rows: Vec<String> = vectors.steps.iter().zip(&vectors.answers).map(row).collect();
        let source = [("SETTINGS", &*settings.collect::<Vec<_>>().join("\n")), ("ROWS", &rows.join("\n"))];
        [
            ("test_vectors.h".into(), self.named(options, include_str!("../templates/c/test_vectors.h"), &header)),
            ("test_vectors.c".into(), self.named(options, include_str!("../templates/c/test_vectors.c"), &source)),
        ]
    }
}

/// In the order of the vectors.
pub(crate) fn inputs(measured: &Measured) -> [f64; 3] {
    [measured.reference_rad, measured.theta_rad, measured.alpha_rad]
}

/// In the order of the vectors.
pub(crate) fn answers(c: &Commanded) -> [f64; 6] {
    [c.voltage_v, c.u_v, c.reference_rad, c.y_rad, c.y_model_rad, c.error_rad]
}
