//! The simulated rig as C99: a header and a source that compute its bits.
//!
//! Enters: parameters of a rig. Leaves: text, in which all matrices stand as numbers; nothing is left to a library's exp.

mod check;
mod parameters;

pub(crate) use parameters::{Kind, Parameter, parameters};

use crate::heading::wrapped;
use crate::number::hexadecimal;
use crate::template::{ARITHMETIC, filled};
use crate::{Error, Name, Precision, Source};
use check::Check;
use flexbeam_files::sha256_hex;
use flexbeam_rig::{Damping, GaugeSees, Link, Piece, RigNumbers, RigParameters, SimulatedRig, elementary, ziggurat};

/// A rig that is written as text.
#[derive(Clone, Copy, Debug)]
pub struct RigSubject<'a> {
    /// What it is.
    pub parameters: &'a RigParameters,
    /// SHA-256 of its rig file; none: the paper's rig.
    pub sha256: Option<&'a str>,
}

/// Header and source of the rig.
///
/// Errors: [`Error::Rig`], [`Error::Counts`].
pub fn rig_sources(subject: &RigSubject<'_>, name: &Name) -> Result<[Source; 2], Error> {
    let parameters = subject.parameters;
    let rig = SimulatedRig::new(parameters, 0)?;
    let list = parameters::parameters(parameters)?;
    let check = Check::new(parameters)?;
    let numbers = matrices(&rig.numbers());
    let period = format!("{:?}", parameters.period_s);
    let substeps = parameters.substeps.to_string();
    let own = parameters::in_c(&list);
    let sha256 = identity(&numbers, &[&period, &substeps, &own]);
    let order = 2 + 2 * rig.numbers().tip.len();
    let header = filled(
        &name.inserted(include_str!("../templates/rig/NAME.h")),
        &[
            ("TITLE", &title(subject)),
            ("BANNER", &banner(subject, " *")),
            ("ORDER", &order.to_string()),
            ("PERIOD", &period),
            ("SHA256", &sha256),
        ],
    );
    let fixed = fixed_numbers();
    let text = [("SUBSTEPS", substeps), ("PARAMETERS", own)];
    let marks = numbers.iter().chain(&fixed).chain(&text).map(|(mark, text)| (*mark, text.clone()));
    let marks: Vec<(&str, String)> = marks.chain(check.marks()?).collect();
    let marks: Vec<(&str, &str)> = marks.iter().map(|(mark, text)| (*mark, text.as_str())).collect();
    let source = filled(&name.inserted(include_str!("../templates/rig/NAME.c")), &marks);
    let file = |ending: &str, text| Source { path: format!("{}.{ending}", name.as_str()), text };
    Ok([file("h", header), file("c", source)])
}

/// One sentence.
pub(crate) fn title(subject: &RigSubject<'_>) -> String {
    let link = match subject.parameters.link {
        Link::Lumped => "a lumped link".to_owned(),
        Link::Modes { count: 1, .. } => "one mode of the link".to_owned(),
        Link::Modes { count, .. } => format!("{count} modes of the link"),
    };
    format!("Simulated rotary flexible beam: {link}, sample period {} s.", subject.parameters.period_s)
}

/// Origin and the numbers that stand in the matrices, each line behind `prefix`.
pub(crate) fn banner(subject: &RigSubject<'_>, prefix: &str) -> String {
    let written = format!("Written by flexbeam {} from", env!("CARGO_PKG_VERSION"));
    let mut lines = match subject.sha256 {
        Some(sha256) => vec![format!("{written} the rig file with SHA-256"), sha256.to_owned()],
        None => vec![format!("{written} the paper's rig, without a rig file.")],
    };
    lines.push(String::new());
    lines.extend(wrapped("What stands in the matrices; another value of it is another export:"));
    lines.extend(in_matrices(subject.parameters));
    let line = |line: &String| format!("{prefix}{}{line}", if line.is_empty() { "" } else { " " });
    lines.iter().map(line).collect::<Vec<_>>().join("\n")
}

fn in_matrices(parameters: &RigParameters) -> Vec<String> {
    let p = &parameters.physical;
    let line = |name: &str, x: f64, unit: &str| format!("  {name:<18}{x} {unit}").trim_end().to_owned();
    let mut lines = vec![
        line("J_base", p.J_base, "kg m^2"),
        line("J_link", p.J_link, "kg m^2"),
        line("K_stiff", p.K_stiff, "N m/rad"),
        line("K_b", p.K_b, "V s/rad"),
        line("K_g", p.K_g, ""),
        line("R", p.R_ohm, "ohm"),
        line("B_eq", p.B_eq, "N m s/rad"),
        line("length", p.length_m, "m"),
    ];
    if let Link::Modes { damping, tip_mass_kg, .. } = parameters.link {
        lines.push(match damping {
            Damping::Modal { zeta } => line("zeta", zeta, "(damping ratio of every mode)"),
            Damping::KelvinVoigt { eta_s } => line("eta", eta_s, "s"),
        });
        lines.push(line("tip mass", tip_mass_kg, "kg"));
    }
    let sees = match parameters.sensors.gauge.sees {
        GaugeSees::TipAngle => "the tip angle",
        GaugeSees::RootStrain => "the strain at the root",
    };
    lines.push(format!("  {:<18}{sees}", "the gauge sees"));
    lines.push(line("substeps", f64::from(parameters.substeps), "a period"));
    lines
}

type Marks = Vec<(&'static str, String)>;

fn matrices(numbers: &RigNumbers<'_>) -> Marks {
    vec![
        ("HALVINGS", (numbers.sliding.len() - 1).to_string()),
        ("SLIDING", pieces(numbers.sliding)),
        ("HELD", pieces(numbers.held)),
        ("REACTION", list(numbers.reaction)),
        ("TIP", list(numbers.tip)),
        ("GAUGE", list(numbers.gauge)),
        ("TORQUE_PER_VOLT", number(numbers.torque_per_volt)),
    ]
}

/// The same for every rig.
fn fixed_numbers() -> Marks {
    vec![
        ("ARITHMETIC", ARITHMETIC.trim_end().to_owned()),
        ("EXP_COUNT", elementary::EXP_TERMS.len().to_string()),
        ("EXP_TERMS", lines(&elementary::EXP_TERMS)),
        ("EXP_IS_ZERO", number(elementary::EXP_IS_ZERO)),
        ("LOG2_E", number(std::f64::consts::LOG2_E)),
        ("LN_COUNT", elementary::LN_TERMS.len().to_string()),
        ("LN_TERMS", lines(&elementary::LN_TERMS)),
        ("LN_2_HIGH", number(elementary::LN_2_HIGH)),
        ("LN_2_LOW", number(elementary::LN_2_LOW)),
        ("ABOVE_ROOT_2", format!("UINT64_C({:#x})", elementary::ABOVE_ROOT_2)),
        ("ZIGGURAT_X", lines(&ziggurat::X)),
        ("ZIGGURAT_F", lines(&ziggurat::F)),
        ("TAU", number(std::f64::consts::TAU)),
    ]
}

fn identity(matrices: &Marks, others: &[&str]) -> String {
    let texts: String = matrices.iter().map(|(_, text)| text.as_str()).chain(others.iter().copied()).collect();
    sha256_hex(texts.as_bytes())
}

pub(crate) fn number(x: f64) -> String {
    hexadecimal(x, Precision::F64)
}

fn list(numbers: &[f64]) -> String {
    numbers.iter().map(|&x| number(x)).collect::<Vec<_>>().join(", ")
}

/// Six to a line.
fn lines(numbers: &[f64]) -> String {
    numbers.chunks(6).map(|part| format!("    {},", list(part))).collect::<Vec<_>>().join("\n")
}

/// Columns of Phi, then Gamma.
fn pieces(pieces: &[Piece]) -> String {
    let column = |column: &[f64]| format!("     {{{}}}", list(column));
    let piece = |piece: &Piece| {
        let columns = piece.Phi.chunks(piece.Gamma.len()).chain([piece.Gamma.as_slice()]);
        format!("    {{\n{}}},", columns.map(column).collect::<Vec<_>>().join(",\n"))
    };
    pieces.iter().map(piece).collect::<Vec<_>>().join("\n")
}
