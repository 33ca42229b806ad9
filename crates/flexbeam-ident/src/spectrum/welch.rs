//! H1: averaged cross spectra of windowed pieces (Welch 1967), any number of inputs.
//!
//!   G = S_yu S_uu^-1,   coherence of output p = (G S_uu G^H)_pp / (S_yy)_pp,
//!   var G_pq = S_vv,p (S_uu^-1)_qq / K,   S_vv = S_yy (1 - coherence) K/(K - m)
//!
//! with S_uu the inputs' cross-spectral matrix and K independent pieces.

use flexbeam_lti::{C64, CMat, Mat, Signals};

use super::Measured;
use crate::Error;
use crate::fourier::Transform;

/// How a record is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segments {
    /// Samples of a piece; pieces overlap by half. Longer ones tell near frequencies apart and blur a resonance less, more
    /// of them say less wrongly what is noise.
    pub samples: usize,
}

/// Neighbours that overlap by half share this part of a Hann window's power spectrum: their correlation is 1/6.
const SHARED: f64 = 1.0 / 36.0;
/// A piece has at least this many samples.
const FEWEST: usize = 16;

impl Segments {
    /// Sixteen pieces, a compromise for a record of which nothing is known.
    pub fn of_record(samples: usize) -> Segments {
        Segments { samples: (2 * samples / 17).max(FEWEST) }
    }

    /// How many independent pieces a record of that many samples has.
    pub fn independent(&self, samples: usize) -> f64 {
        independent(self.starts(samples).len())
    }

    /// Starts of the pieces.
    fn starts(&self, samples: usize) -> Vec<usize> {
        let hop = (self.samples / 2).max(1);
        (0..).map(|k| k * hop).take_while(|start| start + self.samples <= samples).collect()
    }
}

/// How many independent pieces tell as much as `pieces` that overlap by half.
///
/// Source: Welch 1967, with the Hann window's correlation.
fn independent(pieces: usize) -> f64 {
    let count = pieces as f64;
    count / (1.0 + 2.0 * SHARED * (1.0 - 1.0 / count))
}

/// G by H1 at the frequencies of a piece.
///
/// Shapes: inputs m x s, outputs l x s.
/// Assumes: noise on the outputs alone, independent of the inputs: in a closed loop H1 is biased towards -1/K.
/// Returns: (samples of a piece)/2 - 1 frequencies, zero and half the sampling frequency left out.
/// Errors: [`Error::Length`]; [`Error::Setting`] for pieces that are too short or fewer than m + 2;
/// [`Error::NotFinite`]; [`Error::NotExciting`] where the inputs' spectral matrix is singular at every frequency. Single
/// frequencies at which it is singular are left out.
/// Numerics: Hann window, a straight line removed of each piece, so that an output that integrates does not leak.
/// Source: Bendat and Piersol 2010, chapters 6, 7 and 9; Pintelon and Schoukens 2012, section 2.6.
pub fn h1(inputs: &Signals, outputs: &Signals, segments: Segments) -> Result<Measured, Error> {
    crate::checks::expect_together(inputs, outputs)?;
    crate::checks::expect_finite(inputs, outputs)?;
    let starts = segments.starts(inputs.samples());
    let m = inputs.channels();
    if segments.samples < FEWEST {
        let (setting, needed) = ("the samples of a piece of the record", "at least 16");
        return Err(Error::Setting { setting, found: segments.samples as f64, needed });
    }
    if starts.len() < m + 2 {
        let setting = "the number of pieces of the record";
        return Err(Error::Setting { setting, found: starts.len() as f64, needed: "at least two more than inputs" });
    }
    let (U, Y) = (pieces(inputs, &starts, segments.samples), pieces(outputs, &starts, segments.samples));
    let (pieces, K) = (starts.len(), independent(starts.len()));
    let mut found = Measured { omega_rad_s: vec![], G: vec![], std: vec![], coherence: None };
    let mut coherence = Vec::new();
    for k in 1..segments.samples.div_ceil(2) {
        let Some(at) = Line::of(&U, &Y, k, pieces, K) else { continue };
        found.omega_rad_s.push(std::f64::consts::TAU * k as f64 / (segments.samples as f64 * inputs.period_s));
        found.G.push(at.G);
        found.std.push(at.std);
        coherence.push(at.coherence);
    }
    if found.G.is_empty() {
        return Err(Error::NotExciting { rank: m - 1, needed: m, block_rows: 1 });
    }
    found.coherence = Some(coherence);
    Ok(found)
}

/// Fourier lines of each piece of each channel: `[channel][piece][line]`.
fn pieces(signals: &Signals, starts: &[usize], samples: usize) -> Vec<Vec<Vec<C64>>> {
    let window: Vec<f64> =
        (0..samples).map(|t| 0.5 - 0.5 * (std::f64::consts::TAU * (t as f64 + 0.5) / samples as f64).cos()).collect();
    let mut transform = Transform::new(samples);
    let mut of_channel = |row: Vec<f64>| {
        let of_piece = |start: &usize| {
            let mut piece = row[*start..start + samples].to_vec();
            remove_line(&mut piece);
            piece.iter_mut().zip(&window).for_each(|(x, w)| *x *= w);
            let mut lines = Vec::new();
            transform.lines(&piece, &mut lines);
            lines
        };
        starts.iter().map(of_piece).collect()
    };
    (0..signals.channels()).map(|c| of_channel(signals.data.row(c).iter().copied().collect())).collect()
}

/// Less the straight line of least squares.
fn remove_line(x: &mut [f64]) {
    let n = x.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = x.iter().sum::<f64>() / n;
    let moment: f64 = x.iter().enumerate().map(|(t, v)| (t as f64 - middle) * v).sum();
    let slope = moment / (n * (n * n - 1.0) / 12.0);
    x.iter_mut().enumerate().for_each(|(t, v)| *v -= mean + slope * (t as f64 - middle));
}

/// Estimates at one frequency.
struct Line {
    G: CMat,
    std: Mat,
    coherence: Vec<f64>,
}

/// The inputs' spectral matrix, each input at unit power, carries no digits of a direction below this pivot.
const LEAST_PIVOT: f64 = 1e-10;

impl Line {
    /// Nothing where the inputs do not excite this frequency in all directions.
    fn of(U: &[Vec<Vec<C64>>], Y: &[Vec<Vec<C64>>], k: usize, pieces: usize, independent: f64) -> Option<Line> {
        let (m, l) = (U.len(), Y.len());
        let crossed = |a: &[Vec<C64>], b: &[Vec<C64>]| -> C64 {
            (0..pieces).map(|r| a[r][k] * b[r][k].conj()).sum::<C64>() / pieces as f64
        };
        let S_uu = CMat::from_fn(m, m, |p, q| crossed(&U[p], &U[q]));
        let S_yu = CMat::from_fn(l, m, |p, q| crossed(&Y[p], &U[q]));
        let power: Vec<f64> = (0..m).map(|q| S_uu[(q, q)].re.sqrt()).collect();
        let unit = CMat::from_fn(m, m, |p, q| S_uu[(p, q)] / (power[p] * power[q]));
        let factor = nalgebra::Cholesky::new(unit)?;
        if (0..m).any(|q| !(factor.l_dirty()[(q, q)].re.powi(2) > LEAST_PIVOT)) {
            return None;
        }
        let inverse = factor.inverse();
        let inverse = CMat::from_fn(m, m, |p, q| inverse[(p, q)] / (power[p] * power[q]));
        let G = &S_yu * &inverse;
        let explained = &G * S_yu.adjoint();
        let S_yy: Vec<f64> = (0..l).map(|p| crossed(&Y[p], &Y[p]).re).collect();
        let part = |p: usize| if S_yy[p] > 0.0 { (explained[(p, p)].re / S_yy[p]).clamp(0.0, 1.0) } else { 0.0 };
        let coherence: Vec<f64> = (0..l).map(part).collect();
        let free = independent / (independent - m as f64);
        let noise = |p: usize| S_yy[p] * (1.0 - coherence[p]) * free;
        let std = Mat::from_fn(l, m, |p, q| (noise(p) * inverse[(q, q)].re / independent).sqrt());
        Some(Line { G, std, coherence })
    }
}
