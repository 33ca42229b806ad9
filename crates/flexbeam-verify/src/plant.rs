//! The plant as a sampled controller meets it: zero-order hold, delay, measurement filter.
//!
//! Enters: a continuous plant V -> psi, the loop's timing. Leaves: its response in the z-plane and its poles.

use crate::{Error, response::Response};
use flexbeam_lti::{C64, StateSpace, Time, sampling};

/// When the loop measures and writes, and how it filters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Sample period Ts [s].
    pub period_s: f64,
    /// Time from a measurement to the voltage that answers it [s].
    pub delay_s: f64,
    /// Share a of the new measurement in y_f += a (y - y_f); 1 passes everything.
    pub low_pass: f64,
}

impl Timing {
    /// Errors: [`Error::Setting`].
    pub fn check(&self) -> Result<(), Error> {
        let Timing { period_s, delay_s, low_pass } = *self;
        let expect =
            |fits: bool, name, value, needed| if fits { Ok(()) } else { Err(Error::Setting { name, value, needed }) };
        expect(period_s > 0.0 && period_s.is_finite(), "period [s]", period_s, "positive and finite")?;
        expect(delay_s >= 0.0 && delay_s.is_finite(), "delay [s]", delay_s, "not negative, and finite")?;
        expect(low_pass > 0.0 && low_pass <= 1.0, "low-pass coefficient", low_pass, "above 0, at most 1")
    }

    /// z = e^(s Ts).
    pub fn z(&self, s: C64) -> C64 {
        (s * self.period_s).exp()
    }

    /// s = ln(z)/Ts with |Im s| <= pi/Ts.
    pub fn s(&self, z: C64) -> C64 {
        z.ln() / self.period_s
    }

    /// e^(-degree Ts), the radius of the circle that is the image of Re s = -degree.
    pub fn radius(&self, degree: f64) -> f64 {
        (-degree * self.period_s).exp()
    }

    /// Highest frequency of the base band, pi/Ts [rad/s].
    pub fn nyquist_rad_s(&self) -> f64 {
        std::f64::consts::PI / self.period_s
    }

    /// H(z) = a z/(z - (1 - a)) and H'(z).
    pub(crate) fn filter(&self, z: C64) -> (C64, C64) {
        let rest = 1.0 - self.low_pass;
        let denominator = z - rest;
        (z * self.low_pass / denominator, -(denominator * denominator).inv() * (self.low_pass * rest))
    }

    /// Pole of the filter; none when it passes everything.
    pub(crate) fn filter_pole(&self) -> Option<C64> {
        (self.low_pass < 1.0).then(|| C64::from(1.0 - self.low_pass))
    }
}

/// A response in the z-plane whose poles are known.
pub trait Sampled: Sync {
    /// G(z), and G'(z) where it is to be had.
    fn at(&self, z: C64) -> (C64, Option<C64>);
    /// Poles in the z-plane: all of them outside any circle that is asked about, and those inside that lie near one.
    fn poles(&self) -> Vec<C64>;
    /// Timing of the loop.
    fn timing(&self) -> Timing;
}

/// The nominal plant, sampled exactly.
#[derive(Clone, Debug)]
pub struct Plant {
    timing: Timing,
    held: Response,
    poles: Vec<C64>,
}

impl Plant {
    /// Zero-order hold, delay and filter around a continuous V -> psi.
    ///
    /// Errors: [`Error::Shape`] unless `nominal` is scalar, continuous and strictly proper; [`Error::Setting`].
    pub fn new(nominal: &StateSpace, timing: Timing) -> Result<Plant, Error> {
        timing.check()?;
        let (inputs, outputs, time) = (nominal.inputs(), nominal.outputs(), nominal.time);
        if (inputs, outputs, time) != (1, 1, Time::Continuous) || nominal.D[(0, 0)] != 0.0 {
            let needed = "one of each, continuous time, D = 0";
            return Err(Error::Shape { what: "nominal plant", inputs, outputs, time, needed });
        }
        let held = sampling::zoh_with_delay(nominal, timing.period_s, timing.delay_s)?;
        // The exponential of a continuous pole has more digits than an eigenvalue near 1 of the sampled matrix.
        let delays = held.order() - nominal.order();
        let mut poles: Vec<C64> = nominal.poles().into_iter().map(|p| timing.z(p)).collect();
        poles.extend(std::iter::repeat_n(C64::ZERO, delays));
        poles.extend(timing.filter_pole());
        Ok(Plant { timing, held: Response::new(&held)?, poles })
    }
}

impl Sampled for Plant {
    fn at(&self, z: C64) -> (C64, Option<C64>) {
        let ((G, slope), (H, H_slope)) = (self.held.at(z), self.timing.filter(z));
        (H * G, Some(H * slope + H_slope * G))
    }

    fn poles(&self) -> Vec<C64> {
        self.poles.clone()
    }

    fn timing(&self) -> Timing {
        self.timing
    }
}
