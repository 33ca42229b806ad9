//! Averages over the periods of a periodic excitation: what does not repeat is noise, what repeats where nothing was sent is
//! nonlinear.
//!
//! Over n periods, at each harmonic: mean Y, variance of the mean s^2/n with s^2 = sum |Y_r - mean|^2/(n - 1). At the
//! harmonics that the input has, G = Y/U. At the others a linear system answers nothing.

use std::f64::consts::TAU;

use flexbeam_lti::{C64, CMat, Mat, Signals};

use super::Measured;
use crate::Error;
use crate::fourier::Transform;

/// A harmonic is excited when the input has more than this part of its largest amplitude there.
const EXCITED: f64 = 1e-4;

/// What a periodic excitation shows.
#[derive(Clone, Debug)]
pub struct Averaged {
    /// G at the excited harmonics; its standard deviation is that of the noise alone.
    pub measured: Measured,
    /// Standard deviation of the mean output by noise at the excited harmonics: l at each frequency, in amplitudes.
    pub noise: Vec<Vec<f64>>,
    /// Amplitudes of the mean output at the excited harmonics: l at each frequency.
    pub answer: Vec<Vec<f64>>,
    /// Odd harmonics that were not sent: cubes and other odd functions answer there, and bend G as much.
    pub odd: Detection,
    /// Even harmonics that were not sent: squares answer there.
    pub even: Detection,
    /// Periods that were averaged.
    pub periods: usize,
}

/// The mean output where the input has nothing.
#[derive(Clone, Debug, Default)]
pub struct Detection {
    /// Frequencies [rad/s].
    pub omega_rad_s: Vec<f64>,
    /// Amplitude of the mean output: l at each frequency.
    pub amplitude: Vec<Vec<f64>>,
    /// Standard deviation of that mean by noise: l at each frequency.
    pub noise: Vec<Vec<f64>>,
}

impl Detection {
    /// Root mean square of an output's amplitudes over its noise's: 1 where all is noise.
    pub fn over_noise(&self, output: usize) -> f64 {
        let squares = |x: &[Vec<f64>]| x.iter().map(|at| at[output] * at[output]).sum::<f64>();
        (squares(&self.amplitude) / squares(&self.noise)).sqrt()
    }
}

/// Averages all whole periods after the first `run_in` of them.
///
/// Shapes: one input, l outputs.
/// Assumes: the transient has died away in the periods left out. What an output drifts evenly from period to period, as an
/// integrator does after a transient, is taken out as a straight line.
/// Errors: [`Error::Length`], [`Error::NotFinite`]; [`Error::Setting`] for several inputs, a period of fewer than 8 samples
/// or fewer than two periods left; [`Error::NotExciting`] for a constant input.
/// Source: Pintelon and Schoukens 2012, sections 2.5, 4.3.1 and 10.3 (sample means and variances; odd and even detection lines).
pub fn averaged(inputs: &Signals, outputs: &Signals, period: usize, run_in: usize) -> Result<Averaged, Error> {
    crate::checks::expect_together(inputs, outputs)?;
    crate::checks::expect_finite(inputs, outputs)?;
    let setting = |setting, found: usize, needed| Err(Error::Setting { setting, found: found as f64, needed });
    if inputs.channels() != 1 {
        return setting("the number of inputs of a periodic excitation", inputs.channels(), "1");
    }
    if period < 8 {
        return setting("the samples of a period of the excitation", period, "at least 8");
    }
    let periods = (inputs.samples() / period).saturating_sub(run_in);
    if periods < 2 {
        return setting("the number of periods after the first ones", periods, "at least 2");
    }
    let part = |signals: &Signals, c: usize| -> Vec<f64> {
        let row = signals.data.row(c);
        (run_in * period..(run_in + periods) * period).map(|t| row[t]).collect()
    };
    let u = Mean::of(&part(inputs, 0), period);
    let y: Vec<Mean> = (0..outputs.channels()).map(|p| Mean::of(&part(outputs, p), period)).collect();
    let excited = |k: usize| u.lines[k].norm() > EXCITED * u.highest();
    let omega = |k: usize| TAU * k as f64 / (period as f64 * inputs.period_s);
    let harmonics = 1..period.div_ceil(2);
    let lines: Vec<usize> = harmonics.clone().filter(|k| excited(*k)).collect();
    let Some(last) = lines.last().filter(|_| u.highest() > 0.0) else {
        return Err(Error::NotExciting { rank: 0, needed: 1, block_rows: 1 });
    };
    let silent = |odd: usize| {
        let of = |k: &usize| !excited(*k) && k % 2 == odd && k <= last;
        Detection::of(harmonics.clone().filter(of), &y, omega)
    };
    let amplitudes = |k: &usize| y.iter().map(|y| y.lines[*k].norm()).collect();
    Ok(Averaged {
        measured: Measured {
            omega_rad_s: lines.iter().map(|k| omega(*k)).collect(),
            G: lines.iter().map(|k| CMat::from_fn(y.len(), 1, |p, _| y[p].lines[*k] / u.lines[*k])).collect(),
            std: lines.iter().map(|k| Mat::from_fn(y.len(), 1, |p, _| y[p].std_over(&u, *k))).collect(),
            coherence: None,
        },
        noise: lines.iter().map(|k| y.iter().map(|y| y.std(*k)).collect()).collect(),
        answer: lines.iter().map(amplitudes).collect(),
        odd: silent(1),
        even: silent(0),
        periods,
    })
}

impl Detection {
    fn of(lines: impl Iterator<Item = usize>, y: &[Mean], omega: impl Fn(usize) -> f64) -> Detection {
        let mut found = Detection::default();
        for k in lines {
            found.omega_rad_s.push(omega(k));
            found.amplitude.push(y.iter().map(|y| y.lines[k].norm()).collect());
            found.noise.push(y.iter().map(|y| y.std(k)).collect());
        }
        found
    }
}

/// Fourier lines of the periods of one channel, as amplitudes: a sine of amplitude 1 has a line of modulus 1.
struct Mean {
    /// Mean over the periods.
    lines: Vec<C64>,
    /// Each period's.
    of_period: Vec<Vec<C64>>,
}

impl Mean {
    fn of(x: &[f64], period: usize) -> Mean {
        let level = remove_drift(x, period);
        let mut transform = Transform::new(period);
        let of_period: Vec<Vec<C64>> = level
            .chunks(period)
            .map(|one| {
                let mut lines = Vec::new();
                transform.lines(one, &mut lines);
                lines.iter_mut().for_each(|line| *line *= 2.0 / period as f64);
                lines
            })
            .collect();
        let n = of_period.len() as f64;
        let lines = (0..of_period[0].len()).map(|k| of_period.iter().map(|one| one[k]).sum::<C64>() / n).collect();
        Mean { lines, of_period }
    }

    /// Largest amplitude, the mean left out.
    fn highest(&self) -> f64 {
        self.lines[1..].iter().fold(0.0, |most, line| most.max(line.norm()))
    }

    /// Standard deviation of the mean at a harmonic.
    fn std(&self, k: usize) -> f64 {
        self.spread(|one, _| one[k] - self.lines[k])
    }

    /// Standard deviation of (mean of this)/(mean of u) at a harmonic, both noisy.
    fn std_over(&self, u: &Mean, k: usize) -> f64 {
        let G = self.lines[k] / u.lines[k];
        self.spread(|one, r| (one[k] - self.lines[k] - G * (u.of_period[r][k] - u.lines[k])) / u.lines[k])
    }

    fn spread(&self, off: impl Fn(&[C64], usize) -> C64) -> f64 {
        let n = self.of_period.len() as f64;
        let squares: f64 = self.of_period.iter().enumerate().map(|(r, one)| off(one, r).norm_sqr()).sum();
        (squares / (n * (n - 1.0))).sqrt()
    }
}

/// Less a straight line whose slope is the mean change from one period to the next.
fn remove_drift(x: &[f64], period: usize) -> Vec<f64> {
    let mean = |one: &[f64]| one.iter().sum::<f64>() / period as f64;
    let (first, last) = (mean(&x[..period]), mean(&x[x.len() - period..]));
    let slope = (last - first) / (x.len() - period) as f64;
    x.iter().enumerate().map(|(t, v)| v - slope * t as f64).collect()
}
