//! Answers: of the kernel in f64, of the written text itself in f32.

use crate::bound::{self, NoBound, SingleBound};
use crate::numbers::Numbers;
use crate::single::Single;
use crate::stimulus::{self, Step};
use crate::{Error, Precision, Subject, settings};
use flexbeam_kernel::{Commanded, Measured, Settings, State, tick};

/// Ticks with their answers.
#[derive(Clone, Debug)]
pub(crate) struct Vectors {
    pub(crate) settings: Vec<Settings>,
    pub(crate) steps: Vec<Step>,
    pub(crate) answers: Vec<Commanded>,
}

/// How far the f32 text is from the kernel in f64.
#[derive(Clone, Debug, PartialEq)]
pub struct SingleFigures {
    /// Measured over the vectors.
    pub error: SingleError,
    /// For all references and all times, round the nominal loop.
    pub bound: Result<SingleBound, NoBound>,
}

/// Largest differences of the f32 text from the kernel in f64, over the ticks of the vectors that are a loop as it should run.
///
/// Both see the same inputs. Every build that reproduces the vectors has these differences, so over them they are exact; over other
/// inputs they are a measurement, no bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingleError {
    /// Ticks that were compared.
    pub ticks: usize,
    /// Of the voltage sent, while the law has no jumps [V].
    pub voltage_v: f64,
    /// Of the voltage sent under the switched law, whose switches may close a tick earlier or later [V].
    pub switched_voltage_v: f64,
    /// Of the controller's u [V].
    pub u_v: f64,
    /// Of the smoothed reference, of the filtered tip angle and of the reference model's answer [rad].
    pub angle_rad: f64,
}

/// Settings and ticks of the self-check, with their answers.
#[derive(Clone, Debug)]
pub(crate) struct Check {
    pub(crate) settings: Settings,
    pub(crate) ticks: Vec<(Measured, Commanded)>,
}

impl Vectors {
    /// Errors: those of the kernel.
    pub(crate) fn new(subject: &Subject<'_>, numbers: &Numbers, precision: Precision) -> Result<Vectors, Error> {
        let file = subject.controller;
        let settings: Vec<Settings> =
            stimulus::settings(&numbers.settings).iter().map(|s| in_precision(s, precision)).collect();
        let steps = stimulus::script(numbers, &file.plant, file.period_s, precision)?;
        let answers = answers(numbers, &settings, &steps, precision)?;
        Ok(Vectors { settings, steps, answers })
    }

    /// How far f32 is off; nothing in f64.
    ///
    /// Errors: those of the kernel.
    pub(crate) fn single(
        &self,
        subject: &Subject<'_>,
        numbers: &Numbers,
        precision: Precision,
    ) -> Result<Option<SingleFigures>, Error> {
        match precision {
            Precision::F64 => Ok(None),
            Precision::F32 => {
                let (error, bound) = (self.single_error(subject)?, bound::single_bound(subject, numbers)?);
                Ok(Some(SingleFigures { error, bound }))
            }
        }
    }

    fn single_error(&self, subject: &Subject<'_>) -> Result<SingleError, Error> {
        let exact = Numbers::new(subject, Precision::F64)?;
        let exact = answers(&exact, &stimulus::settings(subject.settings), &self.steps, Precision::F64)?;
        let nothing = SingleError { ticks: 0, voltage_v: 0.0, switched_voltage_v: 0.0, u_v: 0.0, angle_rad: 0.0 };
        let compared = self.steps.iter().zip(self.answers.iter().zip(&exact)).filter(|(step, _)| step.fair);
        Ok(compared.fold(nothing, |error, (step, (single, exact))| {
            error.with(single, exact, self.settings[step.settings].law == flexbeam_kernel::Law::Switched)
        }))
    }
}

impl SingleError {
    fn with(self, single: &Commanded, exact: &Commanded, switched: bool) -> SingleError {
        let off = |of: fn(&Commanded) -> f64| (of(single) - of(exact)).abs();
        let voltage_v = off(|c| c.voltage_v);
        let angles = [off(|c| c.reference_rad), off(|c| c.y_rad), off(|c| c.y_model_rad)];
        SingleError {
            ticks: self.ticks + 1,
            voltage_v: if switched { self.voltage_v } else { self.voltage_v.max(voltage_v) },
            switched_voltage_v: if switched { self.switched_voltage_v.max(voltage_v) } else { self.switched_voltage_v },
            u_v: self.u_v.max(off(|c| c.u_v)),
            angle_rad: angles.into_iter().fold(self.angle_rad, f64::max),
        }
    }
}

impl Check {
    /// Errors: those of the kernel.
    pub(crate) fn new(numbers: &Numbers, precision: Precision) -> Result<Check, Error> {
        let (settings, inputs) = stimulus::check(precision);
        let settings = in_precision(&settings, precision);
        let step = |measured| Step { settings: 0, reset: false, measured, fair: true };
        let steps: Vec<Step> = inputs.iter().map(|&measured| step(measured)).collect();
        let answers = answers(numbers, &[settings], &steps, precision)?;
        Ok(Check { settings, ticks: inputs.into_iter().zip(answers).collect() })
    }
}

fn in_precision(settings: &Settings, precision: Precision) -> Settings {
    let Ok(nearest) = settings::mapped(settings, |_, x| Ok::<f64, std::convert::Infallible>(precision.nearest(x)));
    nearest
}

fn answers(
    numbers: &Numbers,
    settings: &[Settings],
    steps: &[Step],
    precision: Precision,
) -> Result<Vec<Commanded>, Error> {
    let controller = numbers.controller()?;
    let mut memory = vec![0.0; controller.state_len()];
    let mut double = State::new(&controller, &mut memory)?;
    let mut single = Single::new(&controller);
    let mut answer = |step: &Step| {
        if step.reset {
            double.reset();
            single.reset();
        }
        match precision {
            Precision::F64 => tick(&settings[step.settings], &controller, &mut double, step.measured),
            Precision::F32 => single.tick(&settings[step.settings], step.measured),
        }
    };
    Ok(steps.iter().map(&mut answer).collect())
}
