//! The reference of a run: signal generators, computed once a tick from settings that may change on the way.

use std::f64::consts::TAU;
use std::sync::Arc;

/// Shape of the reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shape {
    /// Offset until `delay_s`, then offset + amplitude.
    #[default]
    Step,
    /// Offset + amplitude for half a period, offset - amplitude for the other half.
    Square,
    /// Offset + amplitude sin(2 pi t/period).
    Sine,
    /// From offset - amplitude up to offset + amplitude, and back at once.
    Sawtooth,
    /// The samples of a file, one a period of the loop; the last one stays.
    File,
}

/// What the tip is to do.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Shape. Default a step.
    pub shape: Shape,
    /// Amplitude [rad]; it also scales a file. Default 0.
    pub amplitude_rad: f64,
    /// Period of the square, sine and sawtooth [s]. Default 4.
    pub period_s: f64,
    /// What the amplitude is added to [rad]. Default 0.
    pub offset_rad: f64,
    /// Rest before a step [s]. Default 0.1, as in a simulation.
    pub delay_s: f64,
    /// Samples of a file, in units of the amplitude.
    pub samples: Arc<[f64]>,
}

impl Reference {
    /// Real-time: no. The largest sample of a file, either way, in units of the amplitude.
    pub fn peak(&self) -> f64 {
        self.samples.iter().fold(0.0, |peak, x| peak.max(x.abs()))
    }

    /// Real-time: no. The amplitude that keeps its meaning under another shape: of a file it is a factor, of all others an angle.
    pub fn amplitude_as(&self, shape: Shape) -> f64 {
        match (self.shape, shape) {
            (Shape::File, Shape::File) => self.amplitude_rad,
            (Shape::File, _) => self.peak() * self.amplitude_rad,
            (_, Shape::File) => 1.0,
            _ => self.amplitude_rad,
        }
    }
}

impl Default for Reference {
    fn default() -> Reference {
        Reference {
            shape: Shape::Step,
            amplitude_rad: 0.0,
            period_s: 4.0,
            offset_rad: 0.0,
            delay_s: 0.1,
            samples: Arc::new([]),
        }
    }
}

/// A period is a whole number of ticks within this, relative: 0.3 s at 0.001 s is 300 ticks, whatever the division says.
const WHOLE: f64 = 1e-9;

/// Where a periodic reference stands in its period.
///
/// The place is counted on, not computed from the time, so a new period or amplitude leaves it where it is.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Generator {
    /// Ticks of the period that are gone, and its length in ticks.
    gone: f64,
    length: f64,
}

impl Generator {
    /// Real-time: yes. The reference of the tick `tick` of a run [rad]; `ticks` periods after the last call.
    pub(crate) fn next(&mut self, reference: &Reference, tick: u64, ticks: u64, period_s: f64) -> f64 {
        let wave = match reference.shape {
            Shape::Step => step(tick as f64 * period_s, reference.delay_s),
            Shape::Square => self.advance(reference, ticks, period_s, |p| if p < 0.5 { 1.0 } else { -1.0 }),
            Shape::Sine => self.advance(reference, ticks, period_s, |p| (TAU * p).sin()),
            Shape::Sawtooth => self.advance(reference, ticks, period_s, |p| 2.0 * p - 1.0),
            Shape::File => reference.samples.get(tick as usize).or(reference.samples.last()).copied().unwrap_or(0.0),
        };
        reference.offset_rad + reference.amplitude_rad * wave
    }

    /// The wave after `ticks` more ticks.
    fn advance(&mut self, reference: &Reference, ticks: u64, period_s: f64, wave: impl Fn(f64) -> f64) -> f64 {
        let length = in_ticks(reference.period_s / period_s);
        if length != self.length {
            self.gone = if self.length > 0.0 { self.gone / self.length * length } else { 0.0 };
            self.length = length;
        }
        if !(length > 0.0 && length.is_finite()) {
            return wave(0.0);
        }
        // The remainder of two whole numbers is exact, so the edges of a whole number of ticks do not wander.
        self.gone = (self.gone + ticks as f64) % length;
        wave(self.gone / length)
    }
}

fn in_ticks(ratio: f64) -> f64 {
    let whole = ratio.round();
    if (ratio - whole).abs() <= WHOLE * whole { whole } else { ratio }
}

fn step(time_s: f64, delay_s: f64) -> f64 {
    if time_s < delay_s { 0.0 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A factor of 1 taken for an angle would be a step of 57 degrees.
    #[test]
    fn the_amplitude_of_a_file_is_no_angle() {
        let file = Reference {
            shape: Shape::File,
            amplitude_rad: 0.5,
            samples: [0.0, 0.2, -0.3].into(),
            ..Reference::default()
        };
        assert_eq!([Shape::File, Shape::Square].map(|shape| file.amplitude_as(shape)), [0.5, 0.15]);
        let step = Reference { shape: Shape::Step, ..file };
        assert_eq!([Shape::File, Shape::Sine].map(|shape| step.amplitude_as(shape)), [1.0, 0.5]);
    }

    fn run(reference: &Reference, ticks: u64) -> Vec<f64> {
        let mut generator = Generator::default();
        (0..ticks).map(|k| generator.next(reference, k, u64::from(k > 0), 0.25)).collect()
    }

    fn of(shape: Shape) -> Reference {
        Reference { shape, amplitude_rad: 2.0, period_s: 1.0, offset_rad: 10.0, ..Reference::default() }
    }

    #[test]
    fn each_shape_over_a_period_of_four_ticks() {
        assert_eq!(run(&of(Shape::Step), 3), [10.0, 12.0, 12.0]);
        assert_eq!(run(&of(Shape::Square), 5), [12.0, 12.0, 8.0, 8.0, 12.0]);
        assert_eq!(run(&of(Shape::Sawtooth), 5), [8.0, 9.0, 10.0, 11.0, 8.0]);
        let sine = run(&of(Shape::Sine), 4);
        for (found, expected) in sine.iter().zip([10.0, 12.0, 10.0, 8.0]) {
            assert!((found - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn a_file_is_played_once_and_its_last_sample_stays() {
        let reference = Reference { samples: [0.5, -1.0].into(), ..of(Shape::File) };
        assert_eq!(run(&reference, 4), [11.0, 8.0, 8.0, 8.0]);
        assert_eq!(run(&of(Shape::File), 2), [10.0, 10.0], "no samples: the offset");
    }

    #[test]
    fn a_step_without_offset_is_the_amplitude_to_the_last_bit() {
        let step = Reference { amplitude_rad: 30f64.to_radians(), ..Reference::default() };
        let mut generator = Generator::default();
        let found: Vec<f64> = (0..102).map(|k| generator.next(&step, k, 1, 0.001)).collect();
        assert_eq!((found[99], found[100].to_bits()), (0.0, 30f64.to_radians().to_bits()));
    }

    #[test]
    fn a_new_period_leaves_the_phase_where_it_is_and_missed_ticks_count() {
        let (slow, fast) = (of(Shape::Sawtooth), Reference { period_s: 0.5, ..of(Shape::Sawtooth) });
        let mut generator = Generator::default();
        generator.next(&slow, 0, 0, 0.05);
        let before = generator.next(&slow, 5, 5, 0.05);
        let after = generator.next(&fast, 6, 1, 0.05);
        assert!((before - 9.0).abs() < 1e-12 && (after - 9.4).abs() < 1e-12, "{before} {after}");
    }

    #[test]
    fn edges_of_a_whole_number_of_ticks_do_not_wander() {
        let square = Reference { shape: Shape::Square, amplitude_rad: 1.0, period_s: 0.3, ..Reference::default() };
        let mut generator = Generator::default();
        let wave: Vec<f64> = (0..100_000).map(|k| generator.next(&square, k, u64::from(k > 0), 0.001)).collect();
        assert!(wave.iter().enumerate().all(|(k, r)| *r == if k % 300 < 150 { 1.0 } else { -1.0 }));
    }

    #[test]
    fn a_period_of_zero_stands_still() {
        let stopped = Reference { period_s: 0.0, ..of(Shape::Sine) };
        assert!(run(&stopped, 5).iter().all(|r| *r == 10.0));
    }
}
