use super::Schur;
use super::rotation::{Rotation, standardise};
use crate::{C64, Error, Mat};

/// Largest part below the diagonal, relative to the two blocks, that a swap may leave and drop.
/// Bai and Demmel accept 10 eps; ours also counts the rounding of the 4 x 4 products.
const DROPPED: f64 = 50.0 * f64::EPSILON;

/// Exchanges the neighbouring diagonal blocks of p and q rows that start at row k.
///
/// Errors: [`Error::NotSeparable`] when the two share an eigenvalue to working precision.
/// Source: Bai and Demmel 1993, direct swap by a small Sylvester equation.
pub(super) fn swap(form: &mut Schur, k: usize, p: usize, q: usize) -> Result<(), Error> {
    if p == 1 && q == 1 {
        swap_scalars(form, k);
        return Ok(());
    }
    let block = form.T.view((k, k), (p + q, p + q)).into_owned();
    let V = basis_of_second(&block, p, q).ok_or(not_separable(form, k, p))?;
    let turned = V.tr_mul(&block) * &V;
    if turned.view((q, 0), (p, q)).norm() > DROPPED * block.norm() {
        return Err(not_separable(form, k, p));
    }
    turn(form, k, &V);
    form.T.view_mut((k + q, k), (p, q)).fill(0.0);
    for (start, size) in [(k, q), (k + q, p)] {
        if size == 2 {
            standardise(form, start);
        }
    }
    Ok(())
}

fn swap_scalars(form: &mut Schur, k: usize) {
    let (a, b, _, d) = form.block(k);
    Rotation::onto_first_axis(b, d - a).turn(form, k);
    (form.T[(k, k)], form.T[(k + 1, k)], form.T[(k + 1, k + 1)]) = (d, 0.0, a);
}

/// Orthogonal, its first q columns an invariant subspace for the second block: [-X; I] with T11 X - X T22 = T12.
fn basis_of_second(block: &Mat, p: usize, q: usize) -> Option<Mat> {
    let T11 = block.view((0, 0), (p, p));
    let T22 = block.view((p, p), (q, q));
    let T12 = block.view((0, p), (p, q)).into_owned();
    let kronecker = Mat::identity(q, q).kronecker(&T11) - T22.transpose().kronecker(&Mat::identity(p, p));
    let X = kronecker.full_piv_lu().solve(&Mat::from_column_slice(p * q, 1, T12.as_slice()))?;
    let mut span = Mat::zeros(p + q, p + q);
    span.view_mut((0, 0), (p, q)).copy_from(&-X.reshape_generic(nalgebra::Dyn(p), nalgebra::Dyn(q)));
    span.view_mut((p, 0), (q, q)).fill_with_identity();
    span.view_mut((0, q), (p, p)).fill_with_identity();
    let V = span.qr().q();
    V.iter().all(|v| v.is_finite()).then_some(V)
}

fn turn(form: &mut Schur, k: usize, V: &Mat) {
    let (n, size) = (form.T.nrows(), V.nrows());
    let rows = V.tr_mul(&form.T.view((k, k), (size, n - k)));
    form.T.view_mut((k, k), (size, n - k)).copy_from(&rows);
    let columns = form.T.view((0, k), (k + size, size)) * V;
    form.T.view_mut((0, k), (k + size, size)).copy_from(&columns);
    let columns = form.Q.columns(k, size) * V;
    form.Q.columns_mut(k, size).copy_from(&columns);
}

fn not_separable(form: &Schur, k: usize, p: usize) -> Error {
    let at = if p == 2 { form.block_eigenvalue(k) } else { C64::new(form.T[(k, k)], 0.0) };
    Error::NotSeparable { re: at.re, im: at.im }
}
