//! Matrices from a fixed seed, for tests.

use crate::Mat;

/// SplitMix64 (Steele, Lea and Flood 2014).
pub(crate) struct Draw(pub u64);

impl Draw {
    /// Uniform on [-1, 1).
    pub(crate) fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 * 2f64.powi(-52) - 1.0
    }

    pub(crate) fn matrix(&mut self, rows: usize, columns: usize) -> Mat {
        Mat::from_fn(rows, columns, |_, _| self.number())
    }

    /// Poles of modulus about one, all with real part below -margin.
    pub(crate) fn stable(&mut self, n: usize, margin: f64) -> Mat {
        let A = self.matrix(n, n) / (n as f64).sqrt();
        let rightmost = crate::schur::spectrum(&A).unwrap().iter().map(|p| p.re).fold(f64::NEG_INFINITY, f64::max);
        A - Mat::identity(n, n) * if n == 0 { 0.0 } else { rightmost + margin }
    }
}
