//! The simulated rig: commanded voltage in, sensor readings out, one sample period at a time.

use crate::error::positive;
use crate::noise::Noise;
use crate::piece::Piece;
use crate::stick_slip::StickSlip;
use crate::{Actuator, Beam, Damping, Error, Friction, GaugeSees, Motion, Output, Physical, Sensors};
use flexbeam_lti::{Mat, Signals, StateSpace};

/// How the link is modelled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Link {
    /// A torsion spring and a rigid link: (18).
    Lumped,
    /// Assumed modes of the distributed beam, with a point mass at its tip.
    Modes {
        /// Number of modes, 1 to 16.
        count: usize,
        /// Damping of the beam.
        damping: Damping,
        /// Mass at the tip [kg].
        tip_mass_kg: f64,
    },
}

impl Default for Link {
    /// Three modes, damping ratio 0.005, nothing at the tip.
    fn default() -> Link {
        Link::Modes { count: 3, damping: Damping::Modal { zeta: Beam::ZETA }, tip_mass_kg: 0.0 }
    }
}

/// More modes than this are faster than any sampled loop sees, and slow the simulation down.
const MOST_MODES: usize = 16;

/// All that makes a rig. The default is the paper's rig with everything that DESIGN section 4 gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigParameters {
    /// Motor, hub and link. Default [`Physical::paper`].
    pub physical: Physical,
    /// Model of the link. Default three modes.
    pub link: Link,
    /// Converter, amplifier, dead zone. Default [`Actuator::default`].
    pub actuator: Actuator,
    /// Dry friction at the hub. Default [`Friction::default`].
    pub friction: Friction,
    /// Encoder and strain gauge. Default [`Sensors::default`].
    pub sensors: Sensors,
    /// Sample period [s]. Default 0.001.
    pub period_s: f64,
    /// Whole periods between a measurement and the voltage computed from it, in a closed loop. Default 1.
    pub computing_delay_periods: usize,
    /// Pieces into which a period is cut to look for changes between sticking and sliding. Default 4.
    pub substeps: u32,
}

impl Default for RigParameters {
    fn default() -> RigParameters {
        RigParameters {
            physical: Physical::paper(),
            link: Link::default(),
            actuator: Actuator::default(),
            friction: Friction::default(),
            sensors: Sensors::default(),
            period_s: 0.001,
            computing_delay_periods: 1,
            substeps: 4,
        }
    }
}

impl RigParameters {
    /// The same rig with nothing in it that is not linear: no saturation, dead zone, dry friction, resolution or noise.
    /// The computing delay stays.
    pub fn linear(self) -> RigParameters {
        RigParameters { actuator: Actuator::IDEAL, friction: Friction::NONE, sensors: Sensors::IDEAL, ..self }
    }

    /// Equations of motion of hub and link.
    ///
    /// Errors: [`Error::Parameter`].
    pub fn motion(&self) -> Result<Motion, Error> {
        self.physical.check()?;
        match self.link {
            Link::Lumped => Ok(Motion::lumped(&self.physical)),
            Link::Modes { count, damping, tip_mass_kg } if (1..=MOST_MODES).contains(&count) => {
                Motion::assumed_modes(&Beam::new(self.physical, damping)?, count, tip_mass_kg)
            }
            Link::Modes { count, .. } => Err(Error::Parameter {
                quantity: "number of modes",
                found: count as f64,
                unit: "modes",
                needed: "1 to 16",
            }),
        }
    }

    /// The linear model that the rig is when everything else is switched off; input the motor voltage.
    ///
    /// Errors: [`Error::Parameter`], [`Error::Lti`].
    pub fn linear_model(&self, outputs: &[Output]) -> Result<StateSpace, Error> {
        self.motion()?.state_space(outputs)
    }

    /// Errors: [`Error::Parameter`] for the first quantity that no rig can have.
    pub fn check(&self) -> Result<(), Error> {
        self.motion()?;
        self.actuator.check()?;
        self.friction.check()?;
        self.sensors.check()?;
        positive("sample period", "s", self.period_s)?;
        positive("substeps", "a period", f64::from(self.substeps))?;
        Ok(())
    }
}

/// The numbers by which a period is computed, for who computes it elsewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigNumbers<'a> {
    /// Of [theta theta' eta eta'] under hub torque, for a substep, half of it, a quarter, ..
    pub sliding: &'a [Piece],
    /// Of [eta eta'] with the hub held, likewise; the torque has no part in them.
    pub held: &'a [Piece],
    /// Torque of the link on the held hub: its product with [eta eta'].
    pub reaction: &'a [f64],
    /// alpha = tip . eta.
    pub tip: &'a [f64],
    /// Gauge signal = gauge . eta.
    pub gauge: &'a [f64],
    /// g [N m/V].
    pub torque_per_volt: f64,
}

/// What the control computer reads at a sample instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Hub angle as counted [rad].
    pub theta_rad: f64,
    /// Deflection angle as the gauge reads it [rad].
    pub alpha_rad: f64,
}

/// What nobody can read on a real rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Hub angle [rad].
    pub theta_rad: f64,
    /// Deflection angle of the tip [rad].
    pub alpha_rad: f64,
    /// Hub speed [rad/s].
    pub theta_rad_s: f64,
    /// Speed of the deflection angle [rad/s].
    pub alpha_rad_s: f64,
    /// Whether dry friction holds the hub.
    pub stuck: bool,
}

impl Truth {
    /// Tip angle psi = theta + alpha [rad].
    pub fn psi_rad(&self) -> f64 {
        self.theta_rad + self.alpha_rad
    }
}

/// A rig that exists in the computer.
///
/// Once a period: [`SimulatedRig::measure`] reads the sensors at the sample instant, [`SimulatedRig::apply`] holds a
/// voltage until the next one. The computing delay belongs to the loop, not to the rig: see [`crate::closed_loop`].
///
/// Numerics: the linear parts are exact (matrix exponentials); with everything switched off the rig equals the sampled
/// linear model to rounding. A stuck hub does not move by a bit. Neither call allocates.
///
/// ```
/// use flexbeam_rig::{RigParameters, SimulatedRig};
/// let mut rig = SimulatedRig::new(&RigParameters::default(), 1).unwrap();
/// for _ in 0..1000 {
///     rig.apply(0.27); // V: a hundredth below breakaway
/// }
/// assert_eq!(rig.truth().theta_rad, 0.0);
/// rig.apply(0.29);
/// assert!(rig.truth().theta_rad > 0.0);
/// ```
#[derive(Clone, Debug)]
pub struct SimulatedRig {
    parameters: RigParameters,
    dynamics: StickSlip,
    /// alpha = tip . eta.
    tip: Vec<f64>,
    /// Gauge signal = gauge . eta.
    gauge: Vec<f64>,
    torque_per_volt: f64,
    seed: u64,
    noise: Noise,
}

impl SimulatedRig {
    /// At rest at theta = alpha = 0; `seed` decides the sensor noise.
    ///
    /// Errors: [`Error::Parameter`] for a quantity that no rig can have.
    /// Numerics: a millisecond, most of it in 50 matrix exponentials.
    pub fn new(parameters: &RigParameters, seed: u64) -> Result<SimulatedRig, Error> {
        parameters.check()?;
        let motion = parameters.motion()?;
        let seen = match parameters.sensors.gauge.sees {
            GaugeSees::TipAngle => &motion.tip,
            GaugeSees::RootStrain => &motion.gauge,
        };
        Ok(SimulatedRig {
            dynamics: StickSlip::new(&motion, parameters.friction, parameters.period_s, parameters.substeps)?,
            tip: motion.tip.as_slice().to_vec(),
            gauge: seen.as_slice().to_vec(),
            torque_per_volt: motion.g,
            parameters: *parameters,
            seed,
            noise: Noise::new(seed),
        })
    }

    /// The parameters it was made from.
    pub fn parameters(&self) -> &RigParameters {
        &self.parameters
    }

    /// The numbers behind [`SimulatedRig::measure`] and [`SimulatedRig::apply`].
    pub fn numbers(&self) -> RigNumbers<'_> {
        RigNumbers {
            sliding: self.dynamics.sliding(),
            held: self.dynamics.held(),
            reaction: self.dynamics.reaction(),
            tip: &self.tip,
            gauge: &self.gauge,
            torque_per_volt: self.torque_per_volt,
        }
    }

    /// Back to rest at theta = alpha = 0, with the same noise as from the start.
    pub fn reset(&mut self) {
        self.dynamics.reset();
        self.noise = Noise::new(self.seed);
    }

    /// The sensors at this instant. Each call draws new noise.
    pub fn measure(&mut self) -> Measurement {
        let sensors = self.parameters.sensors;
        let alpha = dot(&self.gauge, self.dynamics.link());
        Measurement {
            theta_rad: sensors.encoder.reading_rad(self.dynamics.theta()),
            alpha_rad: sensors.gauge.reading_rad(alpha, &mut self.noise),
        }
    }

    /// Holds the commanded voltage for one period.
    pub fn apply(&mut self, commanded_v: f64) {
        let motor_v = self.parameters.actuator.motor_v(commanded_v);
        self.dynamics.advance(self.torque_per_volt * motor_v);
    }

    /// The state behind the sensors.
    pub fn truth(&self) -> Truth {
        let (eta, eta_rate) = self.dynamics.link().split_at(self.tip.len());
        Truth {
            theta_rad: self.dynamics.theta(),
            alpha_rad: dot(&self.tip, eta),
            theta_rad_s: self.dynamics.speed(),
            alpha_rad_s: dot(&self.tip, eta_rate),
            stuck: self.dynamics.is_stuck(),
        }
    }
}

/// Sum over the shorter of the two.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Drives the rig with these voltages, each held for one period without delay, and records what a computer would.
///
/// Returns channels `voltage_v`, `theta_rad`, `alpha_rad`; column k holds the readings at instant k and the voltage
/// commanded from then on.
/// Errors: [`Error::Lti`] never, for a rig that exists.
pub fn open_loop(rig: &mut SimulatedRig, voltages_v: &[f64]) -> Result<Signals, Error> {
    let mut data = Mat::zeros(3, voltages_v.len());
    for (k, &voltage_v) in voltages_v.iter().enumerate() {
        let Measurement { theta_rad, alpha_rad } = rig.measure();
        data.column_mut(k).copy_from_slice(&[voltage_v, theta_rad, alpha_rad]);
        rig.apply(voltage_v);
    }
    let names = ["voltage_v", "theta_rad", "alpha_rad"].map(String::from).to_vec();
    let units = ["v", "rad", "rad"].map(String::from).to_vec();
    Ok(Signals::new(names, units, rig.parameters().period_s, data)?)
}
