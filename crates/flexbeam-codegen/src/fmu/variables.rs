//! The unit's variables, in the order of their value references: that of `templates/fmu/fmu.c`.

use super::escaped;
use crate::settings::{Field, fields};
use flexbeam_kernel::Settings;

/// What a variable is to the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Set before a step.
    Input,
    /// Read behind it.
    Output,
    /// May be set between steps.
    Setting,
}

/// What its values are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value {
    /// A number with its unit; the start value, for an output none.
    Number(&'static str, Option<f64>),
    /// An enumeration by its type; the start value, for an output none.
    Enumeration(&'static str, Option<u8>),
}

/// One variable.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Variable {
    pub(super) reference: usize,
    pub(super) name: String,
    pub(super) role: Role,
    pub(super) value: Value,
    pub(super) description: &'static str,
}

/// A type with its values, from 0 on.
pub(super) type Enumeration = (&'static str, &'static str, &'static [(&'static str, &'static str)]);

/// The unit of what has none.
pub(super) const NONE: &str = "1";

/// The two enumerations.
pub(super) const ENUMERATIONS: [Enumeration; 2] = [
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

/// All of them; the first has value reference 1, 0 is time.
pub(super) fn all(settings: &Settings) -> Vec<Variable> {
    let mut found: Vec<(String, Role, Value, &'static str)> = Vec::new();
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
    let numbered = found.into_iter().zip(1..);
    numbered
        .map(|((name, role, value, description), reference)| Variable { reference, name, role, value, description })
        .collect()
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

/// Rows of a table in HTML.
pub(super) fn rows(settings: &Settings) -> String {
    let row = |variable: &Variable| {
        let (kind, start) = match variable.value {
            Value::Number(unit, start) => (unit, start.map(decimal)),
            Value::Enumeration(name, start) => (name, start.map(|x| x.to_string())),
        };
        let role = match variable.role {
            Role::Input => "input",
            Role::Output => "output",
            Role::Setting => "tunable parameter",
        };
        let (name, start, text) = (&variable.name, start.unwrap_or_default(), escaped(variable.description));
        format!("<tr><td><code>{name}</code></td><td>{role}</td><td>{kind}</td><td>{start}</td><td>{text}</td></tr>")
    };
    all(settings).iter().map(row).collect::<Vec<_>>().join("\n")
}

/// A number of XML Schema's type double that reads back to the last bit.
pub(super) fn decimal(x: f64) -> String {
    if x.is_nan() {
        "NaN".to_owned()
    } else if x.is_infinite() {
        if x > 0.0 { "INF" } else { "-INF" }.to_owned()
    } else {
        format!("{x:?}")
    }
}

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

    #[test]
    fn numbers_read_back() {
        for x in [0.1, -0.0, 1e-310, f64::MAX, 1e21] {
            assert_eq!(decimal(x).parse::<f64>().unwrap().to_bits(), x.to_bits());
        }
        assert_eq!([decimal(f64::INFINITY), decimal(-f64::INFINITY)], ["INF", "-INF"]);
    }
}
