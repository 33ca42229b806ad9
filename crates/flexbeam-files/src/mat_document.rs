//! Models and controllers as variables of MATLAB's: those of the TOML file, tables as structures.
//!
//! Enters: a document and its poles. Leaves: names and values. Deliberately absent: the script that rebuilds the loop, which the
//! command owns.

use crate::controller::Controller;
use crate::document::{Document, SCHEMA_KEY};
use crate::error::Error;
use crate::mat::{MatVariable, mat_name};
use crate::model::Model;
use flexbeam_lti::{C64, Mat};
use std::path::Path;
use toml::{Table, Value};

/// How every script of ours begins.
pub const SCRIPT_HEAD: &str = "% flexbeam script";

/// The variables of a model: its keys, and `poles` in its own time: [1/s], or in the z-plane.
///
/// Errors: as [`Document::to_toml`]; `path` is for messages.
pub fn mat_of_model(model: &Model, poles: &[C64], path: &Path) -> Result<Vec<(String, MatVariable)>, Error> {
    let mut variables = variables_of(model, path)?;
    set_columns(&mut variables, "B", model.inputs.len());
    if let Some((_, MatVariable::Struct(continuous))) = variables.iter_mut().find(|(name, _)| name == "continuous") {
        set_columns(continuous, "B", model.inputs.len());
    }
    variables.push(("poles".into(), MatVariable::Complex(poles.to_vec())));
    Ok(variables)
}

/// The variables of a controller: its keys; `inputs` and `outputs` of the state equation; its own `poles` in the z-plane.
///
/// D has a third column of zeros: `u_applied_v` reaches the states only.
/// Errors: as [`Document::to_toml`]; `path` is for messages.
pub fn mat_of_controller(
    controller: &Controller,
    poles: &[C64],
    path: &Path,
) -> Result<Vec<(String, MatVariable)>, Error> {
    let mut variables = variables_of(controller, path)?;
    set_columns(&mut variables, "B", Controller::INPUT_NAMES.len());
    if let Some((_, D)) = variables.iter_mut().find(|(name, _)| name == "D") {
        *D = MatVariable::Matrix(controller.D.to_mat(2).insert_column(2, 0.0));
    }
    if let Some((_, MatVariable::Struct(plant))) = variables.iter_mut().find(|(name, _)| name == "plant") {
        set_columns(plant, "B", 1);
    }
    let names =
        |names: &[&str]| MatVariable::Cells(names.iter().map(|name| MatVariable::Text((*name).into())).collect());
    variables.push(("inputs".into(), names(&Controller::INPUT_NAMES)));
    variables.push(("outputs".into(), names(&Controller::OUTPUT_NAMES)));
    variables.push(("poles".into(), MatVariable::Complex(poles.to_vec())));
    Ok(variables)
}

fn variables_of<D: Document>(document: &D, path: &Path) -> Result<Vec<(String, MatVariable)>, Error> {
    let schema = (SCHEMA_KEY.to_string(), MatVariable::Text(D::SCHEMA.into()));
    Ok(std::iter::once(schema).chain(fields(&document.table(path)?)).collect())
}

/// A matrix without rows does not say in the file how many columns it has.
fn set_columns(variables: &mut [(String, MatVariable)], name: &str, columns: usize) {
    if let Some((_, MatVariable::Matrix(M))) = variables.iter_mut().find(|(other, _)| other == name)
        && M.nrows() == 0
    {
        *M = Mat::zeros(0, columns);
    }
}

fn fields(table: &Table) -> Vec<(String, MatVariable)> {
    table.iter().map(|(key, value)| (mat_name(key), variable(key, value))).collect()
}

fn variable(key: &str, value: &Value) -> MatVariable {
    match value {
        Value::Table(table) => MatVariable::Struct(fields(table)),
        Value::Array(entries) => list(key, entries),
        Value::Float(x) => MatVariable::Column(vec![*x]),
        Value::Integer(k) => MatVariable::Column(vec![*k as f64]),
        Value::Boolean(b) => MatVariable::Column(vec![f64::from(u8::from(*b))]),
        Value::String(text) => MatVariable::Text(text.clone()),
        Value::Datetime(time) => MatVariable::Text(time.to_string()),
    }
}

/// Pairs that are poles are complex; coefficients of powers stand in a row, as MATLAB's `tf` wants them; other numbers in a column.
fn list(key: &str, entries: &[Value]) -> MatVariable {
    let numbers = |entries: &[Value]| entries.iter().map(number).collect::<Option<Vec<f64>>>();
    if let Some(values) = numbers(entries) {
        return match (values.len(), is_polynomial(key)) {
            (0, _) => MatVariable::Matrix(Mat::zeros(0, 0)),
            (n, true) => MatVariable::Matrix(Mat::from_row_slice(1, n, &values)),
            (_, false) => MatVariable::Column(values),
        };
    }
    let rows = entries.iter().map(|entry| numbers(entry.as_array()?)).collect::<Option<Vec<Vec<f64>>>>();
    match rows {
        Some(rows) if key == "closed_loop_poles" => {
            MatVariable::Complex(rows.iter().map(|pair| C64::new(pair[0], pair[1])).collect())
        }
        Some(rows) => MatVariable::Matrix(Mat::from_fn(rows.len(), rows[0].len(), |r, c| rows[r][c])),
        None => MatVariable::Cells(entries.iter().map(|entry| variable(key, entry)).collect()),
    }
}

fn is_polynomial(key: &str) -> bool {
    ["num", "den"].iter().any(|end| key == *end || key.ends_with(&format!("_{end}")))
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Float(x) => Some(*x),
        Value::Integer(k) => Some(*k as f64),
        _ => None,
    }
}
