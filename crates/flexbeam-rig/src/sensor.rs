use crate::Error;
use crate::error::{not_negative, positive};
use crate::noise::Noise;
use std::f64::consts::TAU;

/// The encoder on the load shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoder {
    /// Counts a turn; none: exact. Default 4096.
    pub counts_per_turn: Option<u32>,
}

impl Default for Encoder {
    /// Source: DESIGN section 4.
    fn default() -> Encoder {
        Encoder { counts_per_turn: Some(4096) }
    }
}

impl Encoder {
    /// Hub angle as counted: the nearest count [rad].
    pub fn reading_rad(&self, theta_rad: f64) -> f64 {
        self.counts_per_turn.map_or(theta_rad, |counts| {
            let per_rad = f64::from(counts) / TAU;
            (theta_rad * per_rad).round() / per_rad
        })
    }
}

/// What the strain gauge is taken to see.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum GaugeSees {
    /// The deflection angle of the tip itself.
    #[default]
    TipAngle,
    /// The curvature at the root, calibrated on the first mode: higher modes come out larger than they are at the tip.
    RootStrain,
}

/// Strain gauge, its amplifier and the analogue-to-digital converter, referred to the deflection angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gauge {
    /// What the gauge sees. Default the tip angle.
    pub sees: GaugeSees,
    /// Standard deviation of white Gaussian noise [rad]. Default 2e-4, 3 mV at one volt an inch and L = 0.419 m.
    pub noise_rad: f64,
    /// What the gauge reads at alpha = 0 [rad]. Default 0.
    pub bias_rad: f64,
    /// Resolution of the converter [rad]; none: exact. Default 1.48e-4, twelve bits over +-5 V at one volt an inch.
    pub converter_step_rad: Option<f64>,
}

impl Default for Gauge {
    fn default() -> Gauge {
        let rad_per_v = 0.0254 / 0.419;
        Gauge {
            sees: GaugeSees::TipAngle,
            noise_rad: 2e-4,
            bias_rad: 0.0,
            converter_step_rad: Some(10.0 / 4096.0 * rad_per_v),
        }
    }
}

impl Gauge {
    /// The deflection angle, unchanged.
    pub const IDEAL: Gauge =
        Gauge { sees: GaugeSees::TipAngle, noise_rad: 0.0, bias_rad: 0.0, converter_step_rad: None };

    /// Deflection angle as read [rad]: bias, noise, conversion. Draws one number when there is noise, else none.
    pub fn reading_rad(&self, alpha_rad: f64, noise: &mut Noise) -> f64 {
        let mut reading = alpha_rad + self.bias_rad;
        if self.noise_rad > 0.0 {
            reading += self.noise_rad * noise.draw();
        }
        self.converter_step_rad.map_or(reading, |step| (reading / step).round() * step)
    }
}

/// What the control computer reads.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensors {
    /// Hub angle.
    pub encoder: Encoder,
    /// Deflection angle.
    pub gauge: Gauge,
}

impl Sensors {
    /// theta and alpha, unchanged.
    pub const IDEAL: Sensors = Sensors { encoder: Encoder { counts_per_turn: None }, gauge: Gauge::IDEAL };

    /// Standard deviations of what the sensors add to theta and alpha [rad]: noise, and rounding to steps as if it were
    /// uniform and white, which it is while the signal crosses several steps a sample.
    pub fn noise_rad(&self) -> [f64; 2] {
        let rounding = |step_rad: f64| step_rad / 12f64.sqrt();
        let count = self.encoder.counts_per_turn.map_or(0.0, |counts| rounding(TAU / f64::from(counts)));
        [count, self.gauge.noise_rad.hypot(self.gauge.converter_step_rad.map_or(0.0, rounding))]
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        self.encoder.counts_per_turn.map_or(Ok(0.0), |n| positive("encoder counts", "a turn", f64::from(n)))?;
        self.gauge.converter_step_rad.map_or(Ok(0.0), |step| positive("gauge converter step", "rad", step))?;
        not_negative("gauge noise", "rad", self.gauge.noise_rad)?;
        if self.gauge.bias_rad.is_finite() {
            return Ok(());
        }
        let found = self.gauge.bias_rad;
        Err(Error::Parameter { quantity: "gauge bias", found, unit: "rad", needed: "finite" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_encoder_counts() {
        let encoder = Encoder::default();
        let count = TAU / 4096.0;
        for (theta, counts) in
            [(0.0, 0.0), (0.49 * count, 0.0), (0.51 * count, 1.0), (-0.51 * count, -1.0), (TAU, 4096.0)]
        {
            assert!((encoder.reading_rad(theta) - counts * count).abs() < 1e-14);
        }
    }

    #[test]
    fn the_gauge_has_the_bias_and_the_noise_that_it_says() {
        let gauge = Gauge { bias_rad: 0.01, converter_step_rad: None, noise_rad: 3e-4, sees: GaugeSees::TipAngle };
        let mut noise = Noise::new(7);
        let n = 20_000;
        let readings: Vec<f64> = (0..n).map(|_| gauge.reading_rad(0.1, &mut noise)).collect();
        let mean = readings.iter().sum::<f64>() / f64::from(n);
        let deviation = (readings.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / f64::from(n)).sqrt();
        // Five standard errors of each estimate.
        assert!((mean - 0.11).abs() < 5.0 * 3e-4 / f64::from(n).sqrt(), "{mean}");
        assert!((deviation / 3e-4 - 1.0).abs() < 5.0 / (2.0 * f64::from(n)).sqrt(), "{deviation}");
    }

    #[test]
    fn the_converter_rounds_to_its_steps() {
        let gauge = Gauge { converter_step_rad: Some(0.25), ..Gauge::IDEAL };
        let mut unused = Noise::new(0);
        assert_eq!(gauge.reading_rad(0.3, &mut unused), 0.25);
        assert_eq!(gauge.reading_rad(-0.4, &mut unused), -0.5);
    }
}
