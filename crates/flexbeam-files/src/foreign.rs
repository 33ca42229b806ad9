//! MCAP files of other programs, as far as their numbers are in JSON.
//!
//! Enters: bytes. Leaves: the columns of the one topic whose messages hold numbers. Deliberately absent: ROS 2's CDR and Protocol
//! Buffers, of which only our own run files are read; topics that keep different time.

use crate::columns::ColumnName;
use crate::error::{Error, Tried};
use crate::fault::Fault;
use crate::gathered::Gathered;
use crate::run_file::{RunFault, each_record, reader_options};
use mcap::records::{Record, op};
use mcap::sans_io::LinearReader;
use mcap::{MAGIC, parse_record};
use serde_json::Value;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// The encoding that is read.
const JSON: &str = "json";

/// A topic so far.
struct Topic {
    encoding: String,
    messages: usize,
    /// Numbers of the first message, by their places in it.
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
    /// When each message was logged [ns].
    logged_ns: Vec<u64>,
}

/// The columns in a foreign file.
///
/// Errors: [`Fault::Run`] with [`RunFault::NoNumbers`], [`RunFault::Unreadable`] or [`RunFault::Topics`]; [`Fault::NotANumber`],
/// [`Fault::MissingValue`].
pub(crate) fn parse(bytes: &[u8], source: &Path) -> Result<Gathered, Error> {
    topics(bytes).and_then(gathered).map_err(|(fault, message)| {
        let error = Error::new(Tried::Read, source, fault);
        message.map_or(error.clone(), |message| error.at_line(message))
    })
}

/// A fault, and the message where it shows, from 1.
type Found = (Fault, Option<usize>);

/// NUMERICS: by the reader that bounds every length; the crate's own stream of messages believes them.
fn topics(bytes: &[u8]) -> Result<BTreeMap<String, Topic>, Found> {
    let unreadable = |what: String| (RunFault::Unreadable { what }.into(), None);
    let mut channels = HashMap::new();
    let mut topics: BTreeMap<String, Topic> = BTreeMap::new();
    let mut whole = false;
    let mut reader = LinearReader::new_with_options(reader_options());
    each_record(&bytes[MAGIC.len()..], &mut reader, unreadable, |opcode, data| {
        whole |= opcode == op::DATA_END;
        if whole || !matches!(opcode, op::CHANNEL | op::MESSAGE) {
            return Ok(());
        }
        match parse_record(opcode, data).map_err(|error| unreadable(error.to_string()))? {
            Record::Channel(channel) => {
                topics.entry(channel.topic.clone()).or_insert_with(|| Topic::new(channel.message_encoding));
                channels.insert(channel.id, channel.topic);
                Ok(())
            }
            Record::Message { header, data } => {
                let topic = channels.get(&header.channel_id).and_then(|topic| topics.get_mut(topic));
                let topic = topic.ok_or_else(|| unreadable("a message of an unknown channel".into()))?;
                topic.take(&data, header.log_time)
            }
            _ => Ok(()),
        }
    })?;
    if whole { Ok(topics) } else { Err(unreadable("it ends too early".into())) }
}

impl Topic {
    fn new(encoding: String) -> Topic {
        Topic { encoding, messages: 0, names: Vec::new(), columns: Vec::new(), logged_ns: Vec::new() }
    }

    fn take(&mut self, data: &[u8], log_time: u64) -> Result<(), Found> {
        self.messages += 1;
        if self.encoding != JSON {
            return Ok(());
        }
        let here = Some(self.messages);
        let value: Value = serde_json::from_slice(data).map_err(|_| {
            (
                Fault::NotANumber {
                    name: "message".into(),
                    text: String::from_utf8_lossy(data).chars().take(20).collect(),
                },
                here,
            )
        })?;
        if self.messages == 1 {
            numbers(&value, "", &mut self.names);
            self.columns = vec![Vec::new(); self.names.len()];
        }
        for (name, column) in self.names.iter().zip(&mut self.columns) {
            let number = name.split('.').try_fold(&value, |value, part| match value {
                Value::Array(entries) => entries.get(part.parse::<usize>().ok()?),
                value => value.get(part),
            });
            let number = number.and_then(Value::as_f64).ok_or((Fault::MissingValue { name: name.clone() }, here))?;
            column.push(number);
        }
        self.logged_ns.push(log_time);
        Ok(())
    }
}

/// The places of all numbers in a message: `pose.x`, `force.0`.
fn numbers(value: &Value, path: &str, found: &mut Vec<String>) {
    let deeper = |part: &str| if path.is_empty() { part.to_string() } else { format!("{path}.{part}") };
    match value {
        Value::Number(_) if !path.is_empty() => found.push(path.into()),
        // A key with a point in it would name another place.
        Value::Object(fields) => {
            fields
                .iter()
                .filter(|(key, _)| !key.contains('.'))
                .for_each(|(key, value)| numbers(value, &deeper(key), found));
        }
        Value::Array(entries) => {
            entries.iter().enumerate().for_each(|(k, value)| numbers(value, &deeper(&k.to_string()), found));
        }
        _ => {}
    }
}

fn gathered(topics: BTreeMap<String, Topic>) -> Result<Gathered, Found> {
    let there: Vec<String> = topics
        .iter()
        .map(|(name, topic)| format!("{name} ({}, {} messages)", topic.encoding, topic.messages))
        .collect();
    let there = if there.is_empty() { "no messages".into() } else { there.join(", ") };
    let mut numeric = topics.into_iter().filter(|(_, topic)| !topic.names.is_empty());
    let (name, topic) = match (numeric.next(), numeric.next()) {
        (Some(one), None) => one,
        (None, _) => return Err((RunFault::NoNumbers { there }.into(), None)),
        (Some(_), Some(_)) => return Err((RunFault::Topics { there }.into(), None)),
    };
    let Topic { mut names, mut columns, logged_ns, .. } = topic;
    let at = names.iter().position(|name| ColumnName::of(name).is_time());
    let axis = at.map_or("the time at which each was logged".to_string(), |t| names[t].clone());
    let time_s = match at {
        Some(t) => {
            let factor =
                Some(ColumnName::of(&names.remove(t))).filter(|c| c.unit != c.si_unit).map_or(1.0, |c| c.si_factor);
            columns.remove(t).into_iter().map(|time| time * factor).collect()
        }
        None => since_first(&logged_ns),
    };
    let notice = Some(format!("messages of {name}; time axis {axis}; columns {}", names.join(", ")));
    Ok(Gathered { names, columns, time_s: Some(time_s), period_s: None, notice })
}

/// Since the first message [s].
fn since_first(logged_ns: &[u64]) -> Vec<f64> {
    let first = logged_ns.first().copied().unwrap_or(0);
    logged_ns.iter().map(|ns| (i128::from(*ns) - i128::from(first)) as f64 / 1e9).collect()
}
