//! The live settings as a list, in the order of the structure that is written.

use crate::Precision;
use crate::number::{decimal, hexadecimal};
use flexbeam_kernel::{Channel, Law, Settings};

/// One setting; the law stands between its neighbours as a number.
pub(crate) enum Field {
    /// A channel's three numbers.
    Channel(&'static str, Channel),
    /// A number with its unit.
    Number(&'static str, &'static str, f64),
    /// The law.
    Law(Law),
}

/// All of them, in order.
pub(crate) fn fields(s: &Settings) -> Vec<Field> {
    vec![
        Field::Channel("theta", s.theta),
        Field::Channel("alpha", s.alpha),
        Field::Number("smooth_ticks", "ticks", s.smooth_ticks),
        Field::Number("smooth_step_rad", "rad", s.smooth_step_rad),
        Field::Law(s.law),
        Field::Number("u_p_plus_v", "V", s.u_p_plus_v),
        Field::Number("u_p_minus_v", "V", s.u_p_minus_v),
        Field::Number("eps_u_v", "V", s.eps_u_v),
        Field::Number("eps_e_rad", "rad", s.eps_e_rad),
        Field::Number("hysteresis_u", "-", s.hysteresis_u),
        Field::Number("hysteresis_e", "-", s.hysteresis_e),
        Field::Number("breakaway_plus_v", "V", s.breakaway_plus_v),
        Field::Number("breakaway_minus_v", "V", s.breakaway_minus_v),
        Field::Number("voltage_limit_v", "V", s.voltage_limit_v),
        Field::Number("deflection_limit_rad", "rad", s.deflection_limit_rad),
        Field::Number("theta_limit_rad", "rad", s.theta_limit_rad),
        Field::Number("theta_step_limit_rad", "rad", s.theta_step_limit_rad),
    ]
}

/// The settings with each number put through `f`, which gets its name in the controller file.
pub(crate) fn mapped<E>(s: &Settings, mut f: impl FnMut(&str, f64) -> Result<f64, E>) -> Result<Settings, E> {
    let mut channel = |name: &str, c: Channel| {
        Ok(Channel {
            scale: f(&format!("settings.{name}.scale"), c.scale)?,
            offset_rad: f(&format!("settings.{name}.offset_rad"), c.offset_rad)?,
            low_pass: f(&format!("settings.{name}.low_pass"), c.low_pass)?,
        })
    };
    Ok(Settings {
        theta: channel("theta", s.theta)?,
        alpha: channel("alpha", s.alpha)?,
        smooth_ticks: f("settings.smooth_ticks", s.smooth_ticks)?,
        smooth_step_rad: f("settings.smooth_step_rad", s.smooth_step_rad)?,
        law: s.law,
        u_p_plus_v: f("settings.u_p_plus_v", s.u_p_plus_v)?,
        u_p_minus_v: f("settings.u_p_minus_v", s.u_p_minus_v)?,
        eps_u_v: f("settings.eps_u_v", s.eps_u_v)?,
        eps_e_rad: f("settings.eps_e_rad", s.eps_e_rad)?,
        hysteresis_u: f("settings.hysteresis_u", s.hysteresis_u)?,
        hysteresis_e: f("settings.hysteresis_e", s.hysteresis_e)?,
        breakaway_plus_v: f("settings.breakaway_plus_v", s.breakaway_plus_v)?,
        breakaway_minus_v: f("settings.breakaway_minus_v", s.breakaway_minus_v)?,
        voltage_limit_v: f("settings.voltage_limit_v", s.voltage_limit_v)?,
        deflection_limit_rad: f("settings.deflection_limit_rad", s.deflection_limit_rad)?,
        theta_limit_rad: f("settings.theta_limit_rad", s.theta_limit_rad)?,
        theta_step_limit_rad: f("settings.theta_step_limit_rad", s.theta_step_limit_rad)?,
    })
}

/// The inside of an initialiser in C: one line a setting, with a decimal comment.
pub(crate) fn in_c(s: &Settings, upper: &str, precision: Precision, indent: &str) -> String {
    let line = |field: &Field| {
        let number = |x: f64| hexadecimal(x, precision);
        match field {
            Field::Channel(name, c) => format!(
                "{indent}{{{}, {}, {}}}, /* {name}: scale {}, offset {} rad, low_pass {} */",
                number(c.scale),
                number(c.offset_rad),
                number(c.low_pass),
                shown(c.scale),
                shown(c.offset_rad),
                shown(c.low_pass)
            ),
            Field::Number(name, unit, x) if *unit == "-" || x.is_infinite() => {
                format!("{indent}{}, /* {name}: {} */", number(*x), shown(*x))
            }
            Field::Number(name, unit, x) => format!("{indent}{}, /* {name}: {} {unit} */", number(*x), shown(*x)),
            Field::Law(law) => format!("{indent}{upper}_LAW_{},", format!("{law:?}").to_uppercase()),
        }
    };
    fields(s).iter().map(line).collect::<Vec<_>>().join("\n")
}

/// A number for a comment.
fn shown(x: f64) -> String {
    if x.is_infinite() { "no limit".to_owned() } else { format!("{x}") }
}

/// An expression in Rust.
pub(crate) fn in_rust(s: &Settings, precision: Precision, indent: &str) -> String {
    let number = |x: f64| decimal(x, precision);
    let line = |field: &Field| match field {
        Field::Channel(name, c) => format!(
            "{indent}    {name}: Channel {{ scale: {}, offset_rad: {}, low_pass: {} }},",
            number(c.scale),
            number(c.offset_rad),
            number(c.low_pass)
        ),
        Field::Number(name, _, x) => format!("{indent}    {name}: {},", number(*x)),
        Field::Law(law) => format!("{indent}    law: Law::{law:?},"),
    };
    let lines: Vec<String> = fields(s).iter().map(line).collect();
    format!("Settings {{\n{}\n{indent}}}", lines.join("\n"))
}
