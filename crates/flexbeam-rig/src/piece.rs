//! One linear piece of a period: constant torque, one kind of contact.

use crate::stick_slip::HALVINGS;
use flexbeam_lti::Mat;

/// x(t + piece) = Phi x(t) + Gamma torque.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// n x n, column-major.
    pub Phi: Vec<f64>,
    /// n entries.
    pub Gamma: Vec<f64>,
}

impl Piece {
    /// next = Gamma torque, then next += Phi[:,j] x[j], j ascending.
    pub(crate) fn propagate(&self, x: &[f64], torque_nm: f64, next: &mut [f64]) {
        for (next, gamma) in next.iter_mut().zip(&self.Gamma) {
            *next = gamma * torque_nm;
        }
        for (column, x) in self.Phi.chunks_exact(self.Gamma.len()).zip(x) {
            for (next, phi) in next.iter_mut().zip(column) {
                *next += phi * x;
            }
        }
    }

    /// One entry of what [`Piece::propagate`] gives.
    pub(crate) fn row(&self, row: usize, x: &[f64], torque_nm: f64) -> f64 {
        let columns = self.Phi.chunks_exact(self.Gamma.len());
        self.Gamma[row] * torque_nm + columns.zip(x).map(|(column, x)| column[row] * x).sum::<f64>()
    }
}

/// exp([A B; 0 0] t) for t = substep, substep/2, .. substep/2^HALVINGS.
pub(crate) fn pieces(A: &Mat, B: &Mat, substep_s: f64) -> Vec<Piece> {
    let n = A.nrows();
    let mut augmented = Mat::zeros(n + 1, n + 1);
    augmented.view_mut((0, 0), (n, n)).copy_from(A);
    augmented.view_mut((0, n), (n, 1)).copy_from(B);
    let piece = |halvings: u32| {
        let exponential = (&augmented * (substep_s * 0.5_f64.powi(halvings as i32))).exp();
        let Phi = exponential.view((0, 0), (n, n)).iter().copied().collect();
        Piece { Phi, Gamma: exponential.view((0, n), (n, 1)).iter().copied().collect() }
    };
    (0..=HALVINGS).map(piece).collect()
}
