//! The text form of a port behind a board: `DEVICE?key=value,key=value`.

use super::{BoardMap, Sign};
use crate::back_end::OpenError;
use flexbeam_files::nearest;
use std::str::FromStr;

/// Keys of [`BoardMap`], in every board's port.
pub(crate) const MAP_KEYS: [&str; 10] =
    ["output", "encoder", "gauge", "counts_per_turn", "rad_per_v", "zero_v", "gain", "theta", "alpha", "voltage"];

/// A port's text, taken apart; its keys are known ones, each stands once.
#[derive(Debug)]
pub(crate) struct PortText<'a> {
    /// What stands before the question mark.
    pub device: &'a str,
    options: Vec<(&'a str, &'a str)>,
}

impl<'a> PortText<'a> {
    /// Errors: a part without `=`, a key that is not `known` (with the nearest that is), a key that stands twice.
    pub(crate) fn read(text: &'a str, known: &[&str]) -> Result<PortText<'a>, OpenError> {
        let (device, rest) = text.split_once('?').unwrap_or((text, ""));
        let mut options: Vec<(&str, &str)> = Vec::new();
        for part in rest.split(',').filter(|part| !part.is_empty()) {
            let (key, value) = part.split_once('=').ok_or_else(|| refused(part, "key=value", hint(part, known)))?;
            if !known.contains(&key) {
                return Err(refused(key, &format!("one of {}", known.join(", ")), hint(key, known)));
            }
            if options.iter().any(|(other, _)| *other == key) {
                return Err(refused(&format!("{key} twice"), "each key once", "leave one of the two out".into()));
            }
            options.push((key, value));
        }
        Ok(PortText { device, options })
    }

    /// The value of a key as it stands.
    pub(crate) fn word(&self, key: &str) -> Option<&'a str> {
        self.options.iter().find(|(known, _)| *known == key).map(|(_, value)| *value)
    }

    /// The value of a key, or `default` where it does not stand.
    ///
    /// Errors: a value that is not a `needed`.
    pub(crate) fn value<T: FromStr>(&self, key: &str, default: T, needed: &str) -> Result<T, OpenError> {
        let Some(word) = self.word(key) else { return Ok(default) };
        word.parse().map_err(|_| refused(&format!("{key}={word}"), needed, format!("for instance {key}=1")))
    }

    /// The value of a key among named choices; the first is the default.
    ///
    /// Errors: another word.
    pub(crate) fn choice<T: Copy>(&self, key: &str, choices: &[(&str, T)], default: T) -> Result<T, OpenError> {
        let Some(word) = self.word(key) else { return Ok(default) };
        let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
        let found = choices.iter().find(|(name, _)| *name == word).map(|(_, choice)| *choice);
        found.ok_or_else(|| {
            refused(&format!("{key}={word}"), &format!("one of {}", names.join(", ")), hint(word, &names))
        })
    }

    /// Channels and calibration.
    ///
    /// Errors: a value that is none, or that no rig can have.
    pub(crate) fn map(&self) -> Result<BoardMap, OpenError> {
        const CHANNEL: &str = "a channel number from 0";
        const NUMBER: &str = "a number";
        const SIGNS: [(&str, Sign); 2] = [("1", Sign::Same), ("-1", Sign::Reversed)];
        let default = BoardMap::default();
        let map = BoardMap {
            analog_output: self.value("output", default.analog_output, CHANNEL)?,
            encoder: self.value("encoder", default.encoder, CHANNEL)?,
            gauge_input: self.value("gauge", default.gauge_input, CHANNEL)?,
            counts_per_turn: self.value("counts_per_turn", default.counts_per_turn, NUMBER)?,
            gauge_rad_per_v: self.value("rad_per_v", default.gauge_rad_per_v, NUMBER)?,
            gauge_zero_v: self.value("zero_v", default.gauge_zero_v, NUMBER)?,
            amplifier_gain: self.value("gain", default.amplifier_gain, NUMBER)?,
            theta_sign: self.choice("theta", &SIGNS, default.theta_sign)?,
            alpha_sign: self.choice("alpha", &SIGNS, default.alpha_sign)?,
            voltage_sign: self.choice("voltage", &SIGNS, default.voltage_sign)?,
        };
        map.check()?;
        Ok(map)
    }
}

fn refused(found: &str, needed: &str, hint: String) -> OpenError {
    OpenError { found: format!("{found} in the port's text"), needed: needed.into(), hint }
}

fn hint(word: &str, known: &[&str]) -> String {
    match nearest(word, known) {
        Some(meant) => format!("did you mean {meant}?"),
        None => "the book's pages on boards list what a port may say".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_reaches_its_field() {
        let text = "q8:1?output=1,encoder=2,gauge=3,counts_per_turn=8192,rad_per_v=0.5,zero_v=0.25,gain=5,theta=-1,alpha=1,voltage=-1";
        let port = PortText::read(text, &MAP_KEYS).unwrap();
        assert_eq!(port.device, "q8:1");
        let expected = BoardMap {
            analog_output: 1,
            encoder: 2,
            gauge_input: 3,
            counts_per_turn: 8192.0,
            gauge_rad_per_v: 0.5,
            gauge_zero_v: 0.25,
            amplifier_gain: 5.0,
            theta_sign: Sign::Reversed,
            alpha_sign: Sign::Same,
            voltage_sign: Sign::Reversed,
        };
        assert_eq!(port.map().unwrap(), expected);
        assert_eq!(PortText::read("q8:1", &MAP_KEYS).unwrap().map().unwrap(), BoardMap::default());
    }

    #[test]
    fn a_bad_text_names_what_is_bad_what_is_known_and_what_was_meant() {
        for (text, found, needed, hint) in [
            ("q?encodr=0", "encodr in", "encoder, gauge", "did you mean encoder?"),
            ("q?encoder", "encoder in", "key=value", "did you mean encoder?"),
            ("q?gain=1,gain=2", "gain twice", "each key once", "leave one"),
        ] {
            let error = PortText::read(text, &MAP_KEYS).unwrap_err();
            assert!(error.found.contains(found), "{error}");
            assert!(error.needed.contains(needed), "{error}");
            assert!(error.hint.contains(hint), "{error}");
        }
        for (text, found, needed) in [
            ("q?encoder=-1", "encoder=-1", "channel number"),
            ("q?rad_per_v=deg", "rad_per_v=deg", "a number"),
            ("q?theta=0", "theta=0", "one of 1, -1"),
            ("q?gain=0", "gain=0", "positive"),
            ("q?counts_per_turn=-4096", "counts_per_turn=-4096", "positive"),
            ("q?rad_per_v=nan", "rad_per_v=NaN", "positive"),
            ("q?zero_v=inf", "zero_v=inf", "finite"),
        ] {
            let error = PortText::read(text, &MAP_KEYS).unwrap().map().unwrap_err();
            assert!(error.found.contains(found), "{text}: {error}");
            assert!(error.needed.contains(needed), "{text}: {error}");
        }
    }
}
