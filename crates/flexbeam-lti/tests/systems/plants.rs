//! Plants for the tests, and comparisons that coordinates cannot change.

use flexbeam_lti::{C64, CMat, Mat, StateSpace, Time};

/// Equation (18) with a row of C over [theta alpha theta' alpha'].
pub fn flexible_link(C: [f64; 4]) -> StateSpace {
    let (k1, k2, c, b) = (1060.8, 1465.2, 57.7, 107.39);
    let A = Mat::from_row_slice(4, 4, &[0., 0., 1., 0., 0., 0., 0., 1., 0., k1, -c, 0., 0., -k2, c, 0.]);
    let B = Mat::from_column_slice(4, 1, &[0., 0., b, -b]);
    StateSpace::new(A, B, Mat::from_row_slice(1, 4, &C), Mat::zeros(1, 1), Time::Continuous).unwrap()
}

/// V -> psi of (18).
pub fn tip_angle() -> StateSpace {
    flexible_link([1., 1., 0., 0.])
}

/// Numbers between -1 and 1, the same ones for the same seed (splitmix64).
pub struct Noise(pub u64);

impl Noise {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub fn matrix(&mut self, rows: usize, columns: usize) -> Mat {
        Mat::from_fn(rows, columns, |_, _| self.next())
    }

    /// n states, l outputs, m inputs, full D.
    pub fn system(&mut self, n: usize, l: usize, m: usize, time: Time) -> StateSpace {
        let (A, B) = (self.matrix(n, n), self.matrix(n, m));
        let (C, D) = (self.matrix(l, n), self.matrix(l, m));
        StateSpace::new(A, B, C, D, time).unwrap()
    }

    /// A point with |s| between 2 and 4: away from the poles of [`Noise::system`] of small order.
    pub fn point(&mut self) -> C64 {
        C64::from_polar(3.0 + self.next(), 3.1 * self.next())
    }
}

/// Modes at the given frequencies [rad/s] with equal damping, output at the actuator or elsewhere.
pub fn modes(omega: &[f64], zeta: f64, residues: &[f64]) -> StateSpace {
    let n = 2 * omega.len();
    let mut A = Mat::zeros(n, n);
    let mut C = Mat::zeros(1, n);
    for (k, w) in omega.iter().enumerate() {
        A[(2 * k, 2 * k + 1)] = 1.0;
        A[(2 * k + 1, 2 * k)] = -w * w;
        A[(2 * k + 1, 2 * k + 1)] = -2.0 * zeta * w;
        C[2 * k] = residues[k];
    }
    let B = Mat::from_fn(n, 1, |i, _| (i % 2) as f64);
    StateSpace::new(A, B, C, Mat::zeros(1, 1), Time::Continuous).unwrap()
}

/// |X - Y| / |Y|
pub fn relative(X: &CMat, Y: &CMat) -> f64 {
    (X - Y).norm() / Y.norm()
}

/// Largest distance, relative to the wanted roots' modulus (or `floor`), when each finds its nearest partner once.
pub fn distance(found: &[C64], wanted: &[C64], floor: f64) -> f64 {
    assert_eq!(found.len(), wanted.len(), "{found:?} instead of {wanted:?}");
    let mut left: Vec<C64> = found.to_vec();
    let mut worst = 0.0_f64;
    for w in wanted {
        let near = (0..left.len()).min_by(|&i, &j| (left[i] - w).norm().total_cmp(&(left[j] - w).norm())).unwrap();
        worst = worst.max((left.swap_remove(near) - w).norm() / w.norm().max(floor));
    }
    worst
}
