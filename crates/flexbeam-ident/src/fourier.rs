//! Discrete Fourier transforms of real records, of any length.
//!
//! X(k) = sum over t of x(t) e^(-2 pi j k t / N), k = 0 .. N/2; the inverse divides by N.
//! Enters: samples or lines. Leaves: lines or samples. Absent: windows and scales, which belong to who asks.

use flexbeam_lti::C64;
use realfft::RealFftPlanner;

/// X(0) .. X(N/2) of a real record of N samples.
pub(crate) fn lines_of(x: &[f64]) -> Vec<C64> {
    let mut transform = Transform::new(x.len());
    let mut lines = Vec::new();
    transform.lines(x, &mut lines);
    lines
}

/// A real record of `samples` samples from X(0) .. X(N/2).
///
/// The imaginary parts of X(0) and, for even N, X(N/2) are no part of a real record and are left out.
pub(crate) fn record_of(lines: &[C64], samples: usize) -> Vec<f64> {
    let inverse = RealFftPlanner::<f64>::new().plan_fft_inverse(samples);
    let mut lines = lines.to_vec();
    lines[0].im = 0.0;
    if samples.is_multiple_of(2) {
        lines[samples / 2].im = 0.0;
    }
    let mut record = inverse.make_output_vec();
    inverse.process(&mut lines, &mut record).expect("N/2 + 1 lines make N samples");
    record.iter_mut().for_each(|x| *x /= samples as f64);
    record
}

/// A transform of one length, used again and again.
pub(crate) struct Transform {
    forward: std::sync::Arc<dyn realfft::RealToComplex<f64>>,
    record: Vec<f64>,
}

impl Transform {
    pub fn new(samples: usize) -> Transform {
        let forward = RealFftPlanner::<f64>::new().plan_fft_forward(samples);
        Transform { record: forward.make_input_vec(), forward }
    }

    /// X(0) .. X(N/2) of `x`, in place of what `lines` held.
    pub fn lines(&mut self, x: &[f64], lines: &mut Vec<C64>) {
        self.record.copy_from_slice(x);
        lines.resize(x.len() / 2 + 1, C64::ZERO);
        self.forward.process(&mut self.record, lines).expect("N samples make N/2 + 1 lines");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the defining sum, for an even, an odd and a prime length.
    #[test]
    fn lines_are_the_defining_sum_and_come_back() {
        for n in [16usize, 15, 37] {
            let x: Vec<f64> = (0..n).map(|t| ((t * t + 3) % 11) as f64 - 4.0).collect();
            let lines = lines_of(&x);
            assert_eq!(lines.len(), n / 2 + 1);
            for (k, line) in lines.iter().enumerate() {
                let turn = |t: usize| C64::cis(-std::f64::consts::TAU * (k * t % n) as f64 / n as f64);
                let sum: C64 = x.iter().enumerate().map(|(t, x)| turn(t) * *x).sum();
                assert!((line - sum).norm() < 1e-12 * n as f64, "N = {n}, line {k}: {line} {sum}");
            }
            let back = record_of(&lines, n);
            assert!(back.iter().zip(&x).all(|(a, b)| (a - b).abs() < 1e-13), "N = {n}");
        }
    }
}
