//! A rig's part of a unit: its variables, in the order of `templates/fmu/rig/memory.c`.

use super::Part;
use super::variables::{Enumeration, Role, Unnumbered, Value, Variable, numbered};
use crate::rig::{Kind, Parameter, banner, parameters, rig_sources, title};
use crate::template::filled;
use crate::{Error, Name, RigSubject, Source};

/// Of the noise, until the host sets another: that of `flexbeam simulate`.
const SEED: u64 = 1;

/// Most further periods that a host may ask for, unless the rig has more.
const LONGEST_DELAY: usize = 16;

/// Errors: [`Error::Rig`], [`Error::Delay`], [`Error::Counts`].
pub(super) fn part(subject: &RigSubject<'_>, name: &Name) -> Result<Part, Error> {
    let Some(delay) = subject.parameters.computing_delay_periods.checked_sub(1) else { return Err(Error::Delay) };
    let longest = delay.max(LONGEST_DELAY);
    let mut sources = Vec::from(rig_sources(subject, name)?);
    let (seed, delayed, most) = (SEED.to_string(), delay.to_string(), longest.to_string());
    let header = name.inserted(include_str!("../../templates/fmu/rig/memory.h"));
    let source = name.inserted(include_str!("../../templates/fmu/rig/memory.c"));
    sources.push(Source { path: "memory.h".into(), text: filled(&header, &[("LONGEST_DELAY", &most)]) });
    sources.push(Source { path: "memory.c".into(), text: filled(&source, &[("SEED", &seed), ("DELAY", &delayed)]) });
    let title = title(subject);
    let origin = subject.sha256.map(|sha256| format!(" SHA-256 of the rig file: {sha256}"));
    Ok(Part {
        sources,
        description: format!("{title}{}", origin.unwrap_or_default()),
        title,
        banner: banner(subject, ""),
        about: include_str!("../../templates/fmu/rig/about.html"),
        bits_of: "flexbeam's simulated rig",
        period_s: subject.parameters.period_s,
        variables: all(&parameters(subject.parameters)?, delay as u64, longest as u64),
        made_of: &MADE_OF,
        enumerations: &ENUMERATIONS,
    })
}

/// At rest at 0 rad: whatever the encoder is, it shows 0.
const MADE_OF: [(&str, &[&str]); 2] = [
    ("alpha_rad", &["seed", "gauge.noise_rad", "gauge.bias_rad", "gauge.converter_step_rad"]),
    ("contact", &["friction.coulomb_nm", "friction.stribeck_extra_nm"]),
];

const ENUMERATIONS: [Enumeration; 1] = [(
    "Contact",
    "Which set of linear equations the hub obeys",
    &[
        ("Free", "There is no dry friction"),
        ("Stuck", "Dry friction holds the hub: its speed is 0 to the last bit"),
        ("Sliding", "Dry friction opposes the hub's speed"),
    ],
)];

const OUTPUTS: [(&str, &str, &str); 7] = [
    ("theta_rad", "rad", "Hub angle as the encoder counts it, counter-clockwise"),
    ("alpha_rad", "rad", "Deflection angle of the tip relative to the hub, as the gauge reads it"),
    ("true_theta_rad", "rad", "Hub angle"),
    ("true_alpha_rad", "rad", "Deflection angle of the tip"),
    ("true_psi_rad", "rad", "Tip angle psi = theta + alpha"),
    ("true_theta_rad_s", "rad/s", "Hub speed"),
    ("true_alpha_rad_s", "rad/s", "Speed of the deflection angle"),
];

fn all(parameters: &[Parameter], delay: u64, longest: u64) -> Vec<Variable> {
    let voltage = Value::Number("V", Some(0.0));
    let mut found: Vec<Unnumbered> =
        vec![("voltage_v".into(), Role::Input, voltage, "Commanded voltage, held for the step")];
    found.extend(OUTPUTS.map(|(name, unit, text)| (name.into(), Role::Output, Value::Number(unit, None), text)));
    let (contact, text, _) = ENUMERATIONS[0];
    found.push(("contact".into(), Role::Output, Value::Enumeration(contact, None), text));
    let seed = Value::Whole(SEED, i64::MAX as u64);
    found.push(("seed".into(), Role::Fixed, seed, "Decides the gauge's noise"));
    let delay = Value::Whole(delay, longest);
    found.push((
        "delay_periods".into(),
        Role::Fixed,
        delay,
        "Whole periods by which the voltage is later than the input",
    ));
    found.extend(parameters.iter().map(of_parameter));
    numbered(found)
}

fn of_parameter(parameter: &Parameter) -> Unnumbered {
    // Friction that comes or goes under a moving hub is nothing that the simulated rig knows.
    let role = if parameter.name.starts_with("friction.") { Role::Fixed } else { Role::Setting };
    let value = match parameter.kind {
        Kind::Number(unit, start, least) if least.is_finite() => Value::NotBelow(unit, start, least),
        Kind::Number(unit, start, _) => Value::Number(unit, Some(start)),
        Kind::Whole(start) => Value::Whole(u64::from(start), i32::MAX as u64),
    };
    (parameter.name.to_owned(), role, value, parameter.description)
}

#[cfg(test)]
mod tests {
    use super::*;
    use flexbeam_rig::RigParameters;

    #[test]
    fn variables_stand_where_the_c_text_looks_for_them() {
        let all = all(&parameters(&RigParameters::default()).unwrap(), 0, 16);
        let at = |name: &str| all.iter().find(|v| v.name == name).map(|v| v.reference);
        for (name, reference) in [
            ("voltage_v", 1),
            ("true_alpha_rad_s", 8),
            ("contact", 9),
            ("seed", 10),
            ("delay_periods", 11),
            ("actuator.limit_v", 13),
            ("friction.coulomb_nm", 16),
            ("encoder.counts_per_turn", 19),
            ("gauge.converter_step_rad", 22),
        ] {
            assert_eq!(at(name), Some(reference), "{name}");
        }
        assert_eq!(all.len(), 22);
    }
}
