//! Which variable is which: time, channels, the period.

use super::array::{Array, Content};
use super::fault::MatFault;
use crate::columns::ColumnName;
use crate::fault::Fault;
use crate::gathered::Gathered;
use crate::recording::{FEWEST_ROWS, Layout};
use crate::table::{LEFT_OUT, check_names};

/// Real numbers in rows and columns.
struct Matrix<'a> {
    /// As it stands in the file: `data.u`.
    path: String,
    /// Its last part: `u`.
    name: String,
    rows: usize,
    columns: usize,
    /// Column after column.
    numbers: &'a [f64],
}

/// Everything in a file, in its order.
#[derive(Default)]
struct Found<'a> {
    matrices: Vec<Matrix<'a>>,
    /// What is no matrix of numbers, in words.
    others: Vec<String>,
}

/// The channels in a file: by their names, and by the length that they share.
///
/// Errors: [`MatFault::NoSignals`], [`MatFault::Ambiguous`], [`Fault::NamesAndColumns`] and what else names can be.
pub(super) fn gather(variables: &[Array], layout: &Layout) -> Result<Gathered, Fault> {
    let mut found = Found::default();
    variables.iter().for_each(|variable| found.take(variable, ""));
    found.use_short_names();
    let samples = found.samples()?;
    let mut channels = Vec::new();
    let mut left_out = Vec::new();
    for matrix in &found.matrices {
        match matrix.channels(samples) {
            Some(of_matrix) => channels.extend(of_matrix),
            None if matrix.period_s().is_some() => {}
            None => left_out.push(matrix.words()),
        }
    }
    let made = found.matrices.iter().any(|matrix| matrix.is_channels(samples) && matrix.rows.min(matrix.columns) > 1);
    if let Some(names) = &layout.columns {
        check_names(names, channels.len())?;
        channels.iter_mut().zip(names).for_each(|(channel, name)| channel.0 = name.clone());
        channels.retain(|channel| channel.0 != LEFT_OUT);
    }
    let names: Vec<String> = channels.iter().map(|(name, _)| name.clone()).collect();
    check_names(&names, names.len())?;
    let understood = words(&found, &names, samples, &left_out);
    let time_s = names.iter().position(|name| is_time(name)).map(|t| in_seconds(channels.remove(t)));
    let (names, columns) = channels.into_iter().unzip();
    let period_s = found.matrices.iter().find_map(Matrix::period_s).filter(|_| time_s.is_none());
    let notice = (made || !left_out.is_empty() || period_s.is_some()).then_some(understood);
    Ok(Gathered { names, columns, time_s, period_s, notice })
}

/// Simulink calls it `tout`.
fn is_time(name: &str) -> bool {
    let name = name.rsplit('.').next().unwrap_or(name);
    ColumnName::of(name).is_time() || name == "tout"
}

fn in_seconds((name, mut times): (String, Vec<f64>)) -> Vec<f64> {
    let column = ColumnName::of(&name);
    if column.unit != column.si_unit {
        times.iter_mut().for_each(|time| *time *= column.si_factor);
    }
    times
}

fn words(found: &Found, names: &[String], samples: usize, left_out: &[String]) -> String {
    let across = found
        .matrices
        .iter()
        .find(|matrix| matrix.is_channels(samples) && matrix.rows < matrix.columns && matrix.rows > 1);
    let mut text = format!("{samples} samples of {}", names.join(", "));
    if let Some(matrix) = across {
        text += &format!("; the rows of {} are channels", matrix.path);
    }
    if let Some(matrix) = found.matrices.iter().find(|matrix| matrix.period_s().is_some()) {
        text += &format!("; {} = {} is the sampling", matrix.path, matrix.numbers[0]);
    }
    if !left_out.is_empty() {
        text += &format!("; left out: {}", left_out.join(", "));
    }
    text
}

impl<'a> Found<'a> {
    fn take(&mut self, variable: &'a Array, within: &str) {
        let path = format!("{within}{}", variable.name);
        match &variable.content {
            Content::Numbers(numbers) => match flat(&variable.shape) {
                Some((rows, columns)) if rows * columns > 0 => {
                    self.matrices.push(Matrix { name: path.clone(), path, rows, columns, numbers });
                }
                _ => self.others.push(format!("{path} ({})", shape(&variable.shape))),
            },
            Content::Text(_) => self.others.push(format!("{path} (text)")),
            Content::Other(what) => self.others.push(format!("{path} ({what})")),
            Content::Structs(structs) => match &structs[..] {
                [fields] => self.structure(fields, &path),
                _ => self.others.push(format!("{path} ({} structures)", structs.len())),
            },
        }
    }

    /// A structure's fields; of Simulink's "structure with time", the signals by their labels.
    fn structure(&mut self, fields: &'a [Array], path: &str) {
        let signals = fields.iter().find(|field| field.name == "signals").map(|field| &field.content);
        let Some(Content::Structs(signals)) = signals else {
            return fields.iter().for_each(|field| self.take(field, &format!("{path}.")));
        };
        fields.iter().filter(|field| field.name == "time").for_each(|field| self.take(field, &format!("{path}.")));
        for (k, signal) in signals.iter().enumerate() {
            let values = signal.iter().find(|field| field.name == "values");
            let label = signal.iter().find_map(|field| match &field.content {
                Content::Text(text) if field.name == "label" && !text.trim().is_empty() => {
                    Some(text.trim().to_string())
                }
                _ => None,
            });
            let number = if signals.len() > 1 { (k + 1).to_string() } else { String::new() };
            let name = label.unwrap_or_else(|| format!("signal{number}"));
            let Some(values) = values else { continue };
            let before = self.matrices.len();
            self.take(values, &format!("{path}.signals{number}."));
            self.matrices[before..].iter_mut().for_each(|matrix| matrix.name = format!("{path}.{name}"));
        }
    }

    /// `u` for `data.u`, where no other would have that name.
    fn use_short_names(&mut self) {
        let short = |matrix: &Matrix| matrix.name.rsplit('.').next().unwrap_or_default().to_string();
        let names: Vec<String> = self.matrices.iter().map(short).collect();
        for (matrix, name) in self.matrices.iter_mut().zip(&names) {
            if names.iter().filter(|other| *other == name).count() == 1 {
                matrix.name.clone_from(name);
            }
        }
    }

    /// How many samples the recording has: as many as its time axis; without one, the one length that all arrays have.
    fn samples(&self) -> Result<usize, MatFault> {
        let long = || self.matrices.iter().filter(|matrix| matrix.rows.max(matrix.columns) >= FEWEST_ROWS);
        let mut times = long().filter(|matrix| is_time(&matrix.name) && matrix.rows.min(matrix.columns) == 1);
        let samples = match (times.next(), times.next()) {
            (Some(time), None) => time.numbers.len(),
            (Some(_), Some(_)) => return Err(self.ambiguous()),
            (None, _) => self.shared_length()?,
        };
        let square = long().any(|matrix| (matrix.rows, matrix.columns) == (samples, samples));
        if square { Err(self.ambiguous()) } else { Ok(samples) }
    }

    fn shared_length(&self) -> Result<usize, MatFault> {
        let mut long = self.matrices.iter().filter(|matrix| matrix.rows.max(matrix.columns) >= FEWEST_ROWS);
        let first = long.next().ok_or_else(|| MatFault::NoSignals { there: self.words() })?;
        let sides = [first.rows.max(first.columns), first.rows.min(first.columns)];
        let fits = |samples: usize| samples >= FEWEST_ROWS && long.clone().all(|matrix| matrix.is_channels(samples));
        sides.into_iter().find(|&samples| fits(samples)).ok_or_else(|| self.ambiguous())
    }

    fn ambiguous(&self) -> MatFault {
        MatFault::Ambiguous { there: self.words() }
    }

    /// What is there, for a person.
    fn words(&self) -> String {
        let all: Vec<String> = self.matrices.iter().map(Matrix::words).chain(self.others.iter().cloned()).collect();
        if all.is_empty() { "it is empty".into() } else { all.join(", ") }
    }
}

impl Matrix<'_> {
    fn words(&self) -> String {
        format!("{} ({} x {})", self.path, self.rows, self.columns)
    }

    fn is_channels(&self, samples: usize) -> bool {
        self.rows == samples || self.columns == samples
    }

    /// The channels, by name: rows or columns, whichever are so many samples long.
    fn channels(&self, samples: usize) -> Option<Vec<(String, Vec<f64>)>> {
        let Matrix { rows, columns, .. } = *self;
        let (count, step, stride) = match () {
            () if rows == samples => (columns, 1, rows),
            () if columns == samples => (rows, rows, 1),
            () => return None,
        };
        let name = |k: usize| if count == 1 { self.name.clone() } else { format!("{}{}", self.name, k + 1) };
        let channel = |k: usize| (0..samples).map(|s| self.numbers[k * stride + s * step]).collect();
        Some((0..count).map(|k| (name(k), channel(k))).collect())
    }

    /// The sample period, where this is a number that is called so [s]; of `fs`, a rate in Hz, the inverse.
    fn period_s(&self) -> Option<f64> {
        let [number] = self.numbers else { return None };
        match self.name.to_lowercase().as_str() {
            "period_s" | "period" | "ts" | "dt" | "t_s" => Some(*number),
            "fs" => Some(number.recip()),
            _ => None,
        }
    }
}

/// Rows and columns; more dimensions only where all but one are 1, which Simulink writes for a scalar signal.
fn flat(shape: &[usize]) -> Option<(usize, usize)> {
    match shape {
        [rows, columns] => Some((*rows, *columns)),
        _ => {
            let mut long = shape.iter().filter(|length| **length != 1);
            let length = long.next().copied().unwrap_or(1);
            long.next().is_none().then_some((length, 1))
        }
    }
}

fn shape(shape: &[usize]) -> String {
    shape.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ")
}
