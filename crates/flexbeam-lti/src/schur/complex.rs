use super::{block_eigenvalues, diagonal_blocks, ordered_schur};
use crate::{C64, CMat, Error, Mat};

/// A = Q T Q* with T triangular and Q unitary: the real form with its 2 x 2 blocks turned.
///
/// Errors: those of [`ordered_schur`] without order.
pub(crate) fn complex_schur(A: &Mat) -> Result<(CMat, CMat), Error> {
    let form = ordered_schur(A, |_| false)?;
    let (mut T, mut Q) = (form.T.map(C64::from), form.Q.map(C64::from));
    for (k, size) in diagonal_blocks(&form.T) {
        if size == 2 {
            // Eigenvector of the standard block [a b; c a] for a + j w: (b, j w).
            let upper = block_eigenvalues(&form.T, k)[0];
            let (x, y) = (form.T[(k, k + 1)], upper.im);
            let r = x.hypot(y);
            let (x, y) = (C64::new(x / r, 0.0), C64::new(0.0, y / r));
            let V = CMat::from_row_slice(2, 2, &[x, -y.conj(), y, x]);
            let rows = V.adjoint() * T.rows(k, 2);
            T.rows_mut(k, 2).copy_from(&rows);
            for M in [&mut T, &mut Q] {
                let columns = M.columns(k, 2) * &V;
                M.columns_mut(k, 2).copy_from(&columns);
            }
            T[(k + 1, k)] = C64::default();
        }
    }
    Ok((T, Q))
}
