//! What a data-acquisition board knows nothing of: which channel carries what, and what a count or a volt is worth.
//!
//! Enters: counts and volts of the board. Leaves: angles, and the volts to ask the board for. For rigs behind a board,
//! counts become SI here and nowhere else. Deliberately absent: the boards' libraries ([`crate::hil`],
//! [`crate::comedi`]).

mod counter;
mod library;
mod port;

pub(crate) use counter::Counter;
pub(crate) use library::{Library, Missing, c_text};
pub(crate) use port::{MAP_KEYS, PortText};

use crate::back_end::OpenError;
use flexbeam_rig::Measurement;
use std::f64::consts::TAU;

/// Which way a channel counts, compared with the signs of the book's glossary.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sign {
    /// As flexbeam does. `1` in a port's text.
    #[default]
    Same,
    /// The other way. `-1` in a port's text.
    Reversed,
}

impl Sign {
    /// Real-time: yes. 1 or -1.
    pub fn factor(self) -> f64 {
        match self {
            Sign::Same => 1.0,
            Sign::Reversed => -1.0,
        }
    }
}

/// Channels of a board and what they are worth. The default is the SRV02 with its flexible link on channels 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoardMap {
    /// Analogue output that drives the amplifier. Default 0.
    pub analog_output: u32,
    /// Encoder input of the hub. Default 0.
    pub encoder: u32,
    /// Analogue input of the strain gauge. Default 0.
    pub gauge_input: u32,
    /// Counts for one turn of the hub, quadrature included. Default 4096: the encoder sits on the load shaft.
    pub counts_per_turn: f64,
    /// Deflection angle for one volt of the gauge [rad/V]. Default 0.0254/0.419: a volt an inch at the tip of a link of 0.419 m.
    pub gauge_rad_per_v: f64,
    /// What the gauge's input reads when the beam is straight [V]. Default 0.
    pub gauge_zero_v: f64,
    /// Volts at the motor's terminals for one volt of the board. Default 1.
    pub amplifier_gain: f64,
    /// Which way the encoder counts. Default [`Sign::Same`].
    pub theta_sign: Sign,
    /// Which way the gauge counts. Default [`Sign::Same`].
    pub alpha_sign: Sign,
    /// Which way a positive voltage turns the hub. Default [`Sign::Same`].
    pub voltage_sign: Sign,
}

impl Default for BoardMap {
    fn default() -> BoardMap {
        BoardMap {
            analog_output: 0,
            encoder: 0,
            gauge_input: 0,
            counts_per_turn: 4096.0,
            gauge_rad_per_v: 0.0254 / 0.419,
            gauge_zero_v: 0.0,
            amplifier_gain: 1.0,
            theta_sign: Sign::Same,
            alpha_sign: Sign::Same,
            voltage_sign: Sign::Same,
        }
    }
}

impl BoardMap {
    /// Real-time: yes. Volts to ask the board for, so that the motor's terminals get `voltage_v`.
    ///
    /// Returns 0 for what is not a finite number: a converter has no value for it, and 0 V is the one that is safe.
    pub fn board_v(&self, voltage_v: f64) -> f64 {
        let board_v = self.voltage_sign.factor() * voltage_v / self.amplifier_gain;
        if board_v.is_finite() { board_v } else { 0.0 }
    }

    /// Real-time: yes. Angles for counts since the zero was taken, and for the gauge's volts.
    pub fn measurement(&self, counts: i64, gauge_v: f64) -> Measurement {
        Measurement {
            theta_rad: self.theta_sign.factor() * counts as f64 * TAU / self.counts_per_turn,
            alpha_rad: self.alpha_sign.factor() * (gauge_v - self.gauge_zero_v) * self.gauge_rad_per_v,
        }
    }

    /// Errors: the first number that no rig can have.
    pub(crate) fn check(&self) -> Result<(), OpenError> {
        let fits = |key: &str, value: f64, fits: bool, needed: &str| {
            (fits && value.is_finite()).then_some(()).ok_or_else(|| OpenError {
                found: format!("{key}={value}"),
                needed: needed.into(),
                hint: "the direction of a channel is set by theta, alpha and voltage: 1 or -1".into(),
            })
        };
        let positive = |key: &str, value: f64| fits(key, value, value > 0.0, "a positive number");
        positive("counts_per_turn", self.counts_per_turn)?;
        positive("rad_per_v", self.gauge_rad_per_v)?;
        positive("gain", self.amplifier_gain)?;
        fits("zero_v", self.gauge_zero_v, true, "a finite number")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_is_1024_counts_and_an_inch_is_a_volt() {
        let measured = BoardMap::default().measurement(1024, 1.0);
        assert_eq!(measured.theta_rad, TAU / 4.0);
        assert!((measured.alpha_rad * 0.419 - 0.0254).abs() < 1e-15);
    }

    #[test]
    fn each_sign_turns_its_own_channel_only() {
        let map = BoardMap { gauge_zero_v: 0.5, ..BoardMap::default() };
        let plain = map.measurement(100, 1.5);
        let theta = BoardMap { theta_sign: Sign::Reversed, ..map }.measurement(100, 1.5);
        let alpha = BoardMap { alpha_sign: Sign::Reversed, ..map }.measurement(100, 1.5);
        assert_eq!((theta.theta_rad, theta.alpha_rad), (-plain.theta_rad, plain.alpha_rad));
        assert_eq!((alpha.theta_rad, alpha.alpha_rad), (plain.theta_rad, -plain.alpha_rad));
        assert_eq!(BoardMap { voltage_sign: Sign::Reversed, ..map }.board_v(2.0), -2.0);
    }

    #[test]
    fn a_cable_that_multiplies_is_divided_out_and_what_is_no_number_is_0_v() {
        let map = BoardMap { amplifier_gain: 5.0, ..BoardMap::default() };
        assert_eq!(map.board_v(10.0), 2.0);
        for voltage_v in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(map.board_v(voltage_v), 0.0);
        }
    }
}
