//! What an excitation is to be: shape, band, size, periods.

use flexbeam_lti::C64;

use super::{chirp, multisine, prbs, white_gaussian};
use crate::Error;
use crate::fourier::{lines_of, record_of};

/// Kind of voltage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// White Gaussian noise; band-limited where a band is given.
    White,
    /// Maximal-length binary sequence: two voltages, +rms and -rms.
    Prbs,
    /// All harmonics of the band at one amplitude, phases chosen for a low crest factor.
    Multisine,
    /// Odd harmonics of the band at one amplitude and random phases; one of each group of four odd ones is left out at
    /// random, and shows with the even ones what is not linear.
    OddMultisine,
    /// A sine whose frequency rises with time.
    Chirp,
    /// A sine whose frequency rises exponentially: as long in each octave.
    LogChirp,
}

/// The experiment's voltage, before it is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Kind of voltage.
    pub shape: Shape,
    /// Lowest and highest frequency [Hz]; nothing: from one period's first harmonic to half the sampling frequency. A signal
    /// that leaves a part of that out does not excite as many block rows of a subspace identification.
    pub band_hz: Option<[f64; 2]>,
    /// Root mean square [V].
    pub rms_v: f64,
    /// Largest voltage [V], infinite for none: white noise is clipped there, every other shape is made smaller as a whole.
    pub peak_v: f64,
    /// The record is this many times the same; 1 for one that does not repeat.
    pub periods: usize,
    /// Samples of the whole record; it ends with the last whole period.
    pub samples: usize,
    /// Sample period [s].
    pub period_s: f64,
    /// Of all that is random.
    pub seed: u64,
}

/// A voltage, and how it repeats.
#[derive(Clone, Debug, PartialEq)]
pub struct Excitation {
    /// One voltage a sample [V].
    pub voltage_v: Vec<f64>,
    /// Samples of a period; nothing for noise that does not repeat.
    pub period_samples: Option<usize>,
    /// Lowest and highest frequency that is excited [Hz]; nothing where all are.
    pub band_hz: Option<[f64; 2]>,
    /// Samples for which a binary sequence holds a voltage at least.
    pub clock_samples: Option<usize>,
}

impl Excitation {
    /// Root mean square [V].
    pub fn rms_v(&self) -> f64 {
        rms(&self.voltage_v)
    }

    /// Largest magnitude [V].
    pub fn peak_v(&self) -> f64 {
        peak(&self.voltage_v)
    }

    /// Peak over rms: 1 for a binary sequence, 1.41 for a sine.
    pub fn crest_factor(&self) -> f64 {
        self.peak_v() / self.rms_v()
    }
}

impl Plan {
    /// Makes the voltage.
    ///
    /// Returns: `periods` whole periods, as many samples as were asked for or fewer; a binary sequence, whose length is
    /// a power of two less one clock, comes as near as it can from either side.
    /// Errors: [`Error::Setting`] for numbers of which no such signal can be made.
    pub fn excitation(&self) -> Result<Excitation, Error> {
        self.check()?;
        let samples = self.samples / self.periods;
        match self.shape {
            Shape::White => self.white(samples),
            Shape::Prbs => prbs::excitation(self),
            Shape::Multisine | Shape::OddMultisine => self.of_lines(samples),
            Shape::Chirp | Shape::LogChirp => self.chirp(samples),
        }
    }

    fn check(&self) -> Result<(), Error> {
        let nyquist_hz = 0.5 / self.period_s;
        let of_period = self.samples.checked_div(self.periods).unwrap_or(0);
        if of_period < FEWEST {
            let needed = "at least 8, in at least one period";
            return setting("the samples of a period of the excitation", of_period as f64, needed);
        }
        let finite = [("rms_v", self.rms_v, true), ("period_s", self.period_s, true), ("peak_v", self.peak_v, false)];
        for (name, found, finite) in finite {
            if !(found > 0.0 && (found.is_finite() || !finite)) {
                return setting(name, found, "a positive number");
            }
        }
        match self.band_hz {
            Some([low, _]) if !(low >= 0.0) => setting("the lower end of the band [Hz]", low, "0 or more"),
            Some([_, high]) if !(high <= nyquist_hz) => {
                setting("the upper end of the band [Hz]", high, "at most half the sampling frequency")
            }
            Some([low, high]) if !(high > low) => {
                setting("the upper end of the band [Hz]", high, "above the lower one")
            }
            _ => Ok(()),
        }
    }

    /// Harmonics of a period of this many samples inside the band; never the mean.
    pub(super) fn harmonics(&self, samples: usize) -> std::ops::RangeInclusive<usize> {
        let spacing_hz = 1.0 / (samples as f64 * self.period_s);
        let [low, high] = self.band_hz.unwrap_or([0.0, 0.5 / self.period_s]);
        // A harmonic at the edge belongs to the band whatever its last bit says.
        let first = (low / spacing_hz * (1.0 - EDGE)).ceil().max(1.0) as usize;
        let last = (high / spacing_hz * (1.0 + EDGE)).floor() as usize;
        first..=last.min((samples - 1) / 2)
    }

    fn white(&self, samples: usize) -> Result<Excitation, Error> {
        let mut one = white_gaussian(samples, self.rms_v, f64::INFINITY, self.seed);
        if self.band_hz.is_some() {
            let harmonics = self.harmonics(samples);
            expect_lines(harmonics.clone().count(), 1)?;
            let mut lines = lines_of(&one);
            let outside = |k: &usize| !harmonics.contains(k);
            (0..lines.len()).filter(outside).for_each(|k| lines[k] = C64::ZERO);
            one = record_of(&lines, samples);
            let scale = self.rms_v / rms(&one);
            one.iter_mut().for_each(|v| *v *= scale);
        }
        one.iter_mut().for_each(|v| *v = v.clamp(-self.peak_v, self.peak_v));
        let period_samples = (self.periods > 1).then_some(samples);
        Ok(Excitation { voltage_v: self.repeated(one), period_samples, band_hz: self.band_hz, clock_samples: None })
    }

    fn of_lines(&self, samples: usize) -> Result<Excitation, Error> {
        let harmonics: Vec<usize> = self.harmonics(samples).collect();
        let one = match self.shape {
            Shape::OddMultisine => {
                let excited = multisine::odd_grid(&harmonics, self.seed);
                expect_lines(excited.len(), 3)?;
                multisine::of_random_phase(&excited, samples, self.seed)
            }
            _ => {
                expect_lines(harmonics.len(), 2)?;
                multisine::of_low_crest(&harmonics, samples)
            }
        };
        Ok(self.periodic(one, [harmonics[0], harmonics[harmonics.len() - 1]], samples))
    }

    fn chirp(&self, samples: usize) -> Result<Excitation, Error> {
        let harmonics = self.harmonics(samples);
        expect_lines(harmonics.clone().count(), 2)?;
        let ends = [*harmonics.start(), *harmonics.end()];
        let one = match self.shape {
            Shape::LogChirp => chirp::logarithmic(ends, samples),
            _ => chirp::linear(ends, samples),
        };
        Ok(self.periodic(one, ends, samples))
    }

    fn periodic(&self, one: Vec<f64>, ends: [usize; 2], samples: usize) -> Excitation {
        let hz = |k: usize| k as f64 / (samples as f64 * self.period_s);
        let voltage_v = self.repeated(self.sized(one));
        Excitation { voltage_v, period_samples: Some(samples), band_hz: Some(ends.map(hz)), clock_samples: None }
    }

    /// At the rms that was asked for, or less where the peak would be too high.
    pub(super) fn sized(&self, mut one: Vec<f64>) -> Vec<f64> {
        let scale = (self.rms_v / rms(&one)).min(self.peak_v / peak(&one));
        // The peak itself must not stand a rounding above its limit.
        one.iter_mut().for_each(|v| *v = (*v * scale).clamp(-self.peak_v, self.peak_v));
        one
    }

    pub(super) fn repeated(&self, one: Vec<f64>) -> Vec<f64> {
        if self.periods == 1 { one } else { one.repeat(self.periods) }
    }
}

/// A period of fewer samples has no band.
const FEWEST: usize = 8;

/// A harmonic within this of the band's edge, relative, is in the band.
const EDGE: f64 = 1e-9;

pub(super) fn setting<T>(setting: &'static str, found: f64, needed: &'static str) -> Result<T, Error> {
    Err(Error::Setting { setting, found, needed })
}

fn expect_lines(found: usize, needed: usize) -> Result<(), Error> {
    match found >= needed {
        true => Ok(()),
        false if needed == 1 => setting("the number of excited harmonics in the band", found as f64, "at least 1"),
        false => setting(
            "the number of excited harmonics in the band",
            found as f64,
            "at least 2, or 3 of an odd multisine: a wider band or a longer period",
        ),
    }
}

fn rms(x: &[f64]) -> f64 {
    (x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64).sqrt()
}

pub(super) fn peak(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most, v| most.max(v.abs()))
}
