//! `needed`, `optimal`, `integral` or a number.

use serde::de::{self, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// What was asked of the feedback against constant disturbances.
///
/// Source: DESIGN 6.2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stiffness {
    /// As much as the residual voltage needs.
    Needed,
    /// None: the smallest norm.
    Optimal,
    /// Integral action.
    Integral,
    /// K(0) [V/rad].
    Value(f64),
}

/// The words of the command line.
const WORDS: [(&str, Stiffness); 3] =
    [("needed", Stiffness::Needed), ("optimal", Stiffness::Optimal), ("integral", Stiffness::Integral)];

/// Neither one of the words nor a positive number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoStiffness;

impl fmt::Display for NoStiffness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("needed, optimal, integral or a positive number of V/rad")
    }
}

impl std::error::Error for NoStiffness {}

impl std::str::FromStr for Stiffness {
    type Err = NoStiffness;

    fn from_str(text: &str) -> Result<Stiffness, NoStiffness> {
        match WORDS.iter().find(|(word, _)| *word == text) {
            Some((_, stiffness)) => Ok(*stiffness),
            None => text.parse().map_err(|_| NoStiffness).and_then(Stiffness::value),
        }
    }
}

impl Stiffness {
    /// Errors: [`NoStiffness`] unless `k` is positive and finite.
    pub fn value(k: f64) -> Result<Stiffness, NoStiffness> {
        if k > 0.0 && k.is_finite() { Ok(Stiffness::Value(k)) } else { Err(NoStiffness) }
    }
}

impl fmt::Display for Stiffness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self, WORDS.iter().find(|(_, stiffness)| stiffness == self)) {
            (Stiffness::Value(k), _) => write!(f, "{k}"),
            (_, Some((word, _))) => f.write_str(word),
            (_, None) => unreachable!("every stiffness that is no number has its word"),
        }
    }
}

impl Serialize for Stiffness {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Stiffness::Value(k) => serializer.serialize_f64(*k),
            _ => serializer.collect_str(self),
        }
    }
}

impl<'de> Deserialize<'de> for Stiffness {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Stiffness, D::Error> {
        deserializer.deserialize_any(WordOrNumber)
    }
}

struct WordOrNumber;

impl Visitor<'_> for WordOrNumber {
    type Value = Stiffness;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&NoStiffness, f)
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Stiffness, E> {
        text.parse().map_err(|_| E::invalid_value(de::Unexpected::Str(text), &self))
    }

    fn visit_f64<E: de::Error>(self, k: f64) -> Result<Stiffness, E> {
        Stiffness::value(k).map_err(|_| E::invalid_value(de::Unexpected::Float(k), &self))
    }

    fn visit_i64<E: de::Error>(self, k: i64) -> Result<Stiffness, E> {
        self.visit_f64(k as f64)
    }
}
