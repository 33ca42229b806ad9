//! Matrices made of blocks.

use crate::Mat;

/// [L R]
pub(crate) fn beside(L: &Mat, R: &Mat) -> Mat {
    let mut M = Mat::zeros(L.nrows(), L.ncols() + R.ncols());
    M.columns_mut(0, L.ncols()).copy_from(L);
    M.columns_mut(L.ncols(), R.ncols()).copy_from(R);
    M
}

/// [upper; lower]
pub(crate) fn stack(upper: &Mat, lower: &Mat) -> Mat {
    let mut M = Mat::zeros(upper.nrows() + lower.nrows(), upper.ncols());
    M.rows_mut(0, upper.nrows()).copy_from(upper);
    M.rows_mut(upper.nrows(), lower.nrows()).copy_from(lower);
    M
}

/// [M11 M12; M21 M22]
pub(crate) fn blocks(M11: &Mat, M12: &Mat, M21: &Mat, M22: &Mat) -> Mat {
    stack(&beside(M11, M12), &beside(M21, M22))
}

/// [M 0; 0 N]
pub(crate) fn diagonal(M: &Mat, N: &Mat) -> Mat {
    blocks(M, &Mat::zeros(M.nrows(), N.ncols()), &Mat::zeros(N.nrows(), M.ncols()), N)
}
