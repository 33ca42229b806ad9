//! Real Schur form, its order, and eigenvalues.
//!
//! Enters: a square matrix. Leaves: orthogonal Q and quasi-triangular T, eigenvalues.
//! Deliberately absent: eigenvectors, the generalised problem.

mod balance;
mod complex;
mod condition;
mod francis;
mod rotation;
mod swap;

use crate::state_space::{expect_finite, expect_shape};
use crate::{C64, Error, Mat};

pub use balance::balanced;
pub(crate) use complex::complex_schur;
pub(crate) use condition::spectrum_off_line;

/// A = Q T Q' with chosen eigenvalues first.
#[derive(Clone, Debug, PartialEq)]
pub struct OrderedSchur {
    /// Quasi-triangular; 2 x 2 blocks are [a b; c a] with b c < 0.
    pub T: Mat,
    /// Orthogonal.
    pub Q: Mat,
    /// How many eigenvalues were chosen: the first so many columns of Q span their invariant subspace.
    pub leading: usize,
}

/// A = Q T Q', no order.
#[derive(Clone, Debug)]
struct Schur {
    T: Mat,
    Q: Mat,
}

impl Schur {
    /// (a, b, c, d) of the block [a b; c d] in rows k, k+1.
    fn block(&self, k: usize) -> (f64, f64, f64, f64) {
        (self.T[(k, k)], self.T[(k, k + 1)], self.T[(k + 1, k)], self.T[(k + 1, k + 1)])
    }

    /// The eigenvalue with positive imaginary part of the 2 x 2 block at row k.
    fn block_eigenvalue(&self, k: usize) -> C64 {
        block_eigenvalues(&self.T, k)[0]
    }
}

/// A = Q T Q', the eigenvalues with `first` leading.
///
/// Shapes: A n x n, n may be 0.
/// Assumes: `first` says the same of both members of a conjugate pair; it is asked about the upper one.
/// Errors: [`Error::Shape`], [`Error::NotFinite`], [`Error::NotConverged`], [`Error::NotSeparable`] when a chosen and another
/// eigenvalue agree to working precision.
/// Numerics: O(n^3), backward stable: the residual is a small multiple of eps times the norm of A.
/// Source: Francis 1961; Bai and Demmel 1993 for the order.
pub fn ordered_schur(A: &Mat, first: impl Fn(C64) -> bool) -> Result<OrderedSchur, Error> {
    let mut form = real_schur(A)?;
    let blocks: Vec<_> =
        diagonal_blocks(&form.T).map(|(k, size)| (size, first(upper_eigenvalue(&form.T, k, size)))).collect();
    let leading = gather(&mut form, blocks)?;
    Ok(OrderedSchur { T: form.T, Q: form.Q, leading })
}

/// Moves the chosen blocks to the front, keeping their order, and counts their rows.
fn gather(form: &mut Schur, mut blocks: Vec<(usize, bool)>) -> Result<usize, Error> {
    let (mut chosen, mut leading) = (0, 0);
    for from in 0..blocks.len() {
        if !blocks[from].1 {
            continue;
        }
        for at in (chosen..from).rev() {
            let row = blocks[..at].iter().map(|(size, _)| size).sum();
            swap::swap(form, row, blocks[at].0, blocks[at + 1].0)?;
            blocks.swap(at, at + 1);
        }
        leading += blocks[chosen].0;
        chosen += 1;
    }
    Ok(leading)
}

fn real_schur(A: &Mat) -> Result<Schur, Error> {
    expect_square(A)?;
    francis::real_schur(A)
}

fn expect_square(A: &Mat) -> Result<(), Error> {
    expect_shape("A", A, A.nrows(), A.nrows())?;
    expect_finite("A", A)
}

/// Diagonal blocks of a quasi-triangular matrix: (first row, 1 or 2).
pub(crate) fn diagonal_blocks(T: &Mat) -> impl DoubleEndedIterator<Item = (usize, usize)> + use<> {
    let mut found = Vec::new();
    let mut k = 0;
    while k < T.nrows() {
        let size = if k + 1 < T.nrows() && T[(k + 1, k)] != 0.0 { 2 } else { 1 };
        found.push((k, size));
        k += size;
    }
    found.into_iter()
}

/// Eigenvalues of a quasi-triangular matrix in the order of its diagonal; of a pair the upper one first.
pub fn eigenvalues(T: &Mat) -> Vec<C64> {
    let of_block = |(k, size)| if size == 1 { vec![C64::new(T[(k, k)], 0.0)] } else { block_eigenvalues(T, k).into() };
    diagonal_blocks(T).flat_map(of_block).collect()
}

/// Eigenvalues of any square matrix, balanced first.
///
/// Errors: those of [`ordered_schur`] without order.
/// Numerics: the error of each is eps times its condition times the norm of the balanced matrix.
pub fn spectrum(A: &Mat) -> Result<Vec<C64>, Error> {
    expect_square(A)?;
    Ok(eigenvalues(&francis::eigenvalue_blocks(&balanced(A).0)?))
}

fn upper_eigenvalue(T: &Mat, k: usize, size: usize) -> C64 {
    if size == 1 { C64::new(T[(k, k)], 0.0) } else { block_eigenvalues(T, k)[0] }
}

/// Both eigenvalues of a block [a b; c d], in standard form or not.
fn block_eigenvalues(T: &Mat, k: usize) -> [C64; 2] {
    let (a, b, c, d) = (T[(k, k)], T[(k, k + 1)], T[(k + 1, k)], T[(k + 1, k + 1)]);
    let (mean, p) = (0.5 * (a + d), 0.5 * (a - d));
    if p == 0.0 && b * c < 0.0 {
        let im = b.abs().sqrt() * c.abs().sqrt();
        return [C64::new(mean, im), C64::new(mean, -im)];
    }
    let root = C64::new(p * p + b * c, 0.0).sqrt();
    [mean + root, mean - root]
}

#[cfg(test)]
mod tests;
