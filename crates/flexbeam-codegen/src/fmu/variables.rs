//! A unit's variables, in the order of their value references.

use super::escaped;

/// What a variable is to the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Set before a step.
    Input,
    /// Read behind it.
    Output,
    /// May be set between steps.
    Setting,
    /// May be set before the first step.
    Fixed,
}

/// What its values are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value {
    /// A number with its unit; the start value, for an output none.
    Number(&'static str, Option<f64>),
    /// A number with its unit and its start value, not below a least one.
    NotBelow(&'static str, f64, f64),
    /// A whole number: its start value, and the largest one; the least is 0.
    Whole(u64, u64),
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

/// A variable before it has its value reference.
pub(super) type Unnumbered = (String, Role, Value, &'static str);

/// The first has value reference 1; 0 is time.
pub(super) fn numbered(found: Vec<Unnumbered>) -> Vec<Variable> {
    let numbered = found.into_iter().zip(1..);
    numbered
        .map(|((name, role, value, description), reference)| Variable { reference, name, role, value, description })
        .collect()
}

/// A type with its values, from 0 on.
pub(super) type Enumeration = (&'static str, &'static str, &'static [(&'static str, &'static str)]);

/// The unit of what has none.
pub(super) const NONE: &str = "1";

/// Rows of a table in HTML.
pub(super) fn rows(variables: &[Variable]) -> String {
    let row = |variable: &Variable| {
        let (kind, start) = match variable.value {
            Value::Number(unit, start) => (unit, start.map(decimal)),
            Value::NotBelow(unit, start, _) => (unit, Some(decimal(start))),
            Value::Whole(start, _) => ("whole number", Some(start.to_string())),
            Value::Enumeration(name, start) => (name, start.map(|x| x.to_string())),
        };
        let role = match variable.role {
            Role::Input => "input",
            Role::Output => "output",
            Role::Setting => "tunable parameter",
            Role::Fixed => "parameter, fixed from the first step on",
        };
        let (name, start, text) = (&variable.name, start.unwrap_or_default(), escaped(variable.description));
        format!("<tr><td><code>{name}</code></td><td>{role}</td><td>{kind}</td><td>{start}</td><td>{text}</td></tr>")
    };
    variables.iter().map(row).collect::<Vec<_>>().join("\n")
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
    fn numbers_read_back() {
        for x in [0.1, -0.0, 1e-310, f64::MAX, 1e21] {
            assert_eq!(decimal(x).parse::<f64>().unwrap().to_bits(), x.to_bits());
        }
        assert_eq!([decimal(f64::INFINITY), decimal(-f64::INFINITY)], ["INF", "-INF"]);
    }
}
