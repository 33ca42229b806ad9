//! A controller's part of a unit: its variables, in the order of `templates/fmu/controller/memory.c`.

use super::Part;
use super::variables::{Enumeration, NONE, Role, Unnumbered, Value, Variable, numbered};
use crate::numbers::Numbers;
use crate::settings::{Field, fields};
use crate::{Error, Name, Precision, Source, Subject, c, heading};
use flexbeam_kernel::Settings;

/// Errors: [`Error::Kernel`] for a controller that was not read from a file.
pub(super) fn part(subject: &Subject<'_>, name: &Name) -> Result<Part, Error> {
    let numbers = Numbers::new(subject, Precision::F64)?;
    let mut sources = Vec::from(c::controller(subject, name, &numbers)?);
    let memory = [
        ("memory.h", include_str!("../../templates/fmu/controller/memory.h")),
        ("memory.c", include_str!("../../templates/fmu/controller/memory.c")),
    ];
    sources.extend(memory.map(|(path, text)| Source { path: path.into(), text: name.inserted(text) }));
    let title = heading::title(subject, Precision::F64);
    let mut description = format!("{title} SHA-256 of the controller file: {}", subject.sha256);
    if subject.unverified.is_some() {
        description.push_str(". NOT VERIFIED: see documentation/index.html");
    }
    Ok(Part {
        sources,
        title,
        description,
        banner: heading::banner(subject, None, ""),
        about: include_str!("../../templates/fmu/controller/about.html"),
        bits_of: "flexbeam's kernel",
        period_s: subject.controller.period_s,
        variables: all(subject.settings),
        made_of: &[],
        enumerations: &ENUMERATIONS,
    })
}

/// The two enumerations.
const ENUMERATIONS: [Enumeration; 2] = [
    (
        "Fault",
        "Why the voltage is held at 0 V; latches until the unit is reset",
        &[
            ("None", "No fault"),
            ("Deflection", "|alpha| beyond settings.deflection_limit_rad"),
            ("Angle", "|theta| beyond settings.theta_limit_rad"),
            ("Speed", "theta moved more than settings.theta_step_limit_rad in one step"),
            ("NonFinite", "An input or a result was infinite or not a number"),
        ],
    ),
    (
        "Law",
        "Variable-structure law",
        &[
            ("None", "u_c = u"),
            ("Switched", "u_c = u outside the dead region; inside it u_p sign(e) while the error is large, else 0"),
            ("Inverse", "u_c = u + u_p sat(u/eps_u)"),
        ],
    ),
];

const INPUTS: [(&str, &str); 3] = [
    ("reference_rad", "Reference of the tip angle psi = theta + alpha; may step"),
    ("theta_rad", "Hub angle, counter-clockwise"),
    ("alpha_rad", "Deflection angle of the tip relative to the hub"),
];

const OUTPUTS: [(&str, &str, &str); 6] = [
    ("voltage_v", "V", "Voltage to send, of the step that ends here"),
    ("u_v", "V", "The controller's u, before the law"),
    ("smoothed_rad", "rad", "v, the reference after smoothing"),
    ("y_rad", "rad", "y = psi, filtered tip angle"),
    ("y_model_rad", "rad", "Output of the reference model"),
    ("error_rad", "rad", "e = y_model - y"),
];

/// All of them.
fn all(settings: &Settings) -> Vec<Variable> {
    let mut found: Vec<Unnumbered> = Vec::new();
    let input = |(name, text): (&str, _)| (name.to_owned(), Role::Input, Value::Number("rad", Some(0.0)), text);
    found.extend(INPUTS.map(input));
    let output = |(name, unit, text): (&str, _, _)| (name.to_owned(), Role::Output, Value::Number(unit, None), text);
    found.extend(OUTPUTS.map(output));
    let (fault, text, _) = ENUMERATIONS[0];
    found.push(("fault".to_owned(), Role::Output, Value::Enumeration(fault, None), text));
    for field in fields(settings) {
        found.extend(
            of_field(&field)
                .into_iter()
                .map(|(name, value)| (format!("settings.{name}"), Role::Setting, value, described(&name))),
        );
    }
    numbered(found)
}

fn of_field(field: &Field) -> Vec<(String, Value)> {
    let number = |name: String, unit, x| (name, Value::Number(unit, Some(x)));
    match field {
        Field::Channel(name, c) => vec![
            number(format!("{name}.scale"), NONE, c.scale),
            number(format!("{name}.offset_rad"), "rad", c.offset_rad),
            number(format!("{name}.low_pass"), NONE, c.low_pass),
        ],
        Field::Number(name, "-" | "ticks", x) => vec![number((*name).to_owned(), NONE, *x)],
        Field::Number(name, unit, x) => vec![number((*name).to_owned(), unit, *x)],
        Field::Law(law) => vec![("law".to_owned(), Value::Enumeration(ENUMERATIONS[1].0, Some(*law as u8)))],
    }
}

/// Panics: a setting without a description is our own bug.
fn described(name: &str) -> &'static str {
    let found = DESCRIPTIONS.iter().find(|(setting, _)| *setting == name);
    found.unwrap_or_else(|| panic!("the setting {name} has no description")).1
}

const DESCRIPTIONS: [(&str, &str); 21] = [
    ("theta.scale", "Correction of the hub sensor's gain"),
    ("theta.offset_rad", "What the hub sensor shows at zero"),
    ("theta.low_pass", "Share of the new measurement, above 0 and at most 1; 1 passes every bit"),
    ("alpha.scale", "Correction of the deflection sensor's gain"),
    ("alpha.offset_rad", "What the deflection sensor shows at zero"),
    ("alpha.low_pass", "Share of the new measurement, above 0 and at most 1; 1 passes every bit"),
    ("smooth_ticks", "Duration of the smooth step in sample periods; 0 passes the reference"),
    ("smooth_step_rad", "Steps above this size take proportionally longer"),
    ("law", "Variable-structure law"),
    ("u_p_plus_v", "Compensation voltage, positive direction"),
    ("u_p_minus_v", "The same in the negative direction, as a magnitude"),
    ("eps_u_v", "Threshold of switch 2, width of the inverse law's ramp"),
    ("eps_e_rad", "Threshold of switch 1"),
    ("hysteresis_u", "Switch 2 opens above eps_u (1 + hysteresis_u)"),
    ("hysteresis_e", "Switch 1 opens below eps_e (1 - hysteresis_e)"),
    ("breakaway_plus_v", "Estimated breakaway voltage, positive direction"),
    ("breakaway_minus_v", "The same in the negative direction, as a magnitude"),
    ("voltage_limit_v", "Largest magnitude of the voltage"),
    ("deflection_limit_rad", "Largest |alpha|; beyond it: fault"),
    ("theta_limit_rad", "Largest |theta|; beyond it: fault"),
    ("theta_step_limit_rad", "Largest change of theta in one sample period; beyond it: fault"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variables_stand_where_the_c_text_looks_for_them() {
        let all = all(&Settings::default());
        let at = |name: &str| all.iter().find(|v| v.name == name).map(|v| v.reference);
        assert_eq!(all.len(), 31);
        for (name, reference) in
            [("reference_rad", 1), ("voltage_v", 4), ("fault", 10), ("settings.theta.scale", 11), ("settings.law", 19)]
        {
            assert_eq!(at(name), Some(reference), "{name}");
        }
        assert_eq!(all.last().map(|v| v.reference), Some(31));
    }
}
