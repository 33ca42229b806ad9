//! Orthogonal row compression: the rank of a matrix, and rows that hold all of it.

use crate::Mat;

/// Blur beyond which no rank is believed to have been lost: half the digits.
const LARGEST_BLUR: f64 = 1.5e-8;

/// Relative uncertainty of the matrices in a chain of rank decisions.
///
/// Each compression turns the coordinates by an angle known only to blur / (smallest pivot kept), and the next matrix is seen
/// through that angle. A tolerance that stays at rounding then finds ranks that rounding has made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blur(f64);

impl Blur {
    /// Rounding in matrices of that many rows and columns together.
    pub(crate) fn of_rounding(dimension: usize) -> Blur {
        Blur(f64::EPSILON * dimension as f64)
    }

    pub(crate) fn times(self, size: f64) -> f64 {
        self.0 * size
    }

    /// The blur of what is next seen, after a compression of a matrix whose scale is `size`. Without a split there is no
    /// angle to be uncertain about.
    pub(crate) fn after(self, compression: &RowCompression, size: f64) -> Blur {
        if compression.rank == 0 || compression.rank == compression.Q.nrows() {
            return self;
        }
        Blur((self.0 * (1.0 + size / compression.least_pivot)).min(LARGEST_BLUR))
    }
}

/// Orthogonal Q with Q' M = [R; 0], R of `rank` independent rows.
pub(crate) struct RowCompression {
    pub(crate) Q: Mat,
    pub(crate) rank: usize,
    /// Length of the shortest column that counted; infinite when none did.
    pub(crate) least_pivot: f64,
}

impl RowCompression {
    /// Householder reflections with column pivoting, until no remaining column is longer than `tolerance`.
    pub(crate) fn new(M: &Mat, tolerance: f64) -> RowCompression {
        let mut R = M.clone();
        let mut Q = Mat::identity(M.nrows(), M.nrows());
        let mut least_pivot = f64::INFINITY;
        for k in 0..M.nrows().min(M.ncols()) {
            let length = |j: &usize| R.view((k, *j), (R.nrows() - k, 1)).norm();
            let pivot = (k..M.ncols()).max_by(|i, j| length(i).total_cmp(&length(j))).expect("a column is left");
            let longest = length(&pivot);
            if !(longest > tolerance) {
                return RowCompression { Q, rank: k, least_pivot };
            }
            least_pivot = longest;
            R.swap_columns(k, pivot);
            reflect(&mut R, &mut Q, k);
        }
        RowCompression { Q, rank: M.nrows().min(M.ncols()), least_pivot }
    }
}

/// Clears column k of R below its diagonal by a reflection, which Q collects.
fn reflect(R: &mut Mat, Q: &mut Mat, k: usize) {
    let mut v = R.view((k, k), (R.nrows() - k, 1)).into_owned();
    v[0] += v.norm().copysign(v[0]);
    v.unscale_mut(v.norm());
    let columns = R.ncols() - k;
    let mut lower = R.view_mut((k, k), (v.len(), columns));
    let along = v.tr_mul(&lower);
    lower.gemm(-2.0, &v, &along, 1.0);
    let mut right = Q.columns_mut(k, v.len());
    let along = &right * &v;
    right.gemm(-2.0, &along, &v.transpose(), 1.0);
}
