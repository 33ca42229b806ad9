//! Poles known to be 1: the tip angle of a motor that turns.
//!
//! Enters: samples, the poles beside the known ones. Leaves: A with eigenvalues exactly 1, C.
//! Deliberately absent: chains of integrators, and B, which the simulated output gives.
//!
//! With v(k) = u(0) + .. + u(k-1), G u = (z - 1) G v, and (z - 1) G has lost the pole at 1. White noise on y stays white,
//! where differencing y would colour it and bury the slow part of the answer: at 1 ms the tip moves by a tenth of the noise
//! a sample.

use flexbeam_lti::Mat;

use crate::estimation::Estimation;
use crate::identify::Feedthrough;
use crate::output_map::{Unknowns, input_matrices};
use crate::singular::left_singular;

/// v(k) = u(0) + .. + u(k-1), each channel over its rms.
pub(crate) fn running_sum(U: &Mat) -> Mat {
    let mut V = Mat::zeros(U.nrows(), U.ncols());
    for (u, mut v) in U.column_iter().zip(V.column_iter_mut()) {
        let mut sum = 0.0;
        for (u, v) in u.iter().zip(v.iter_mut()) {
            *v = sum;
            sum += u;
        }
        let rms = v.norm() / (v.len() as f64).sqrt();
        if rms > 0.0 {
            v.unscale_mut(rms);
        }
    }
    V
}

/// A = diag(1, A_s), C = [C_1 C_s], where C_1 spans the q strongest directions of the residue H(1), H = (z - 1) G.
///
/// H comes from A_s, C_s and the running sum as input, by least squares on its output.
pub(crate) fn prepended(samples: &Estimation, A_s: &Mat, C_s: &Mat) -> (Mat, Mat) {
    let (q, n, l) = (samples.integrators, A_s.nrows(), C_s.nrows());
    let mut A = Mat::identity(q + n, q + n);
    A.view_mut((q, q), (n, n)).copy_from(A_s);
    let mut C = Mat::zeros(l, q + n);
    C.columns_mut(0, q).copy_from(&directions(samples, A_s, C_s));
    C.columns_mut(q, n).copy_from(C_s);
    (A, C)
}

fn directions(samples: &Estimation, A_s: &Mat, C_s: &Mat) -> Mat {
    let (q, n, l) = (samples.integrators, A_s.nrows(), C_s.nrows());
    if l == q {
        return Mat::identity(l, q);
    }
    let unknowns = Unknowns { feedthrough: Feedthrough::Free, offset: true };
    let (U, Y) = samples.samples.matrices();
    let H = input_matrices(A_s, C_s, &running_sum(&U), &Y, unknowns);
    let steady = (Mat::identity(n, n) - A_s).full_piv_lu().solve(&H.B);
    let residue = steady.map_or(H.D.clone(), |x| C_s * x + &H.D);
    left_singular(&residue).1.columns(0, q).into_owned()
}
