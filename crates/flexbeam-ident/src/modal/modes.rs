//! Modes of a real matrix.

use flexbeam_lti::{C64, CMat, Mat, schur};

/// A basis of modes worse than this is left alone: the iteration that refines the solution could not make up for it.
const LARGEST_CONDITION: f64 = 1e7;

/// A V = V Lambda with Lambda of blocks \[s\] and \[s w; -w s\], columns of V of unit length pair by pair.
pub(crate) struct Modes {
    /// One pole for each real mode, that with positive imaginary part for each pair.
    pub poles: Vec<C64>,
    pub V: Mat,
}

impl Modes {
    /// None when the modes are no basis to speak of: a pole that is repeated, or nearly.
    pub fn of(A: &Mat) -> Option<Modes> {
        let n = A.nrows();
        let poles: Vec<C64> = schur::spectrum(A).ok()?.into_iter().filter(|z| z.im >= 0.0).collect();
        if poles.iter().map(|z| if z.im > 0.0 { 2 } else { 1 }).sum::<usize>() != n {
            return None;
        }
        let mut V = Mat::zeros(n, n);
        let mut column = 0;
        for pole in &poles {
            let v = eigenvector(A, *pole)?;
            V.set_column(column, &v.map(|x| x.re).column(0));
            column += 1;
            if pole.im > 0.0 {
                V.set_column(column, &v.map(|x| x.im).column(0));
                column += 1;
            }
        }
        let inverse = V.clone().try_inverse()?;
        let modes = Modes { poles, V };
        let missed = (A * &modes.V - &modes.V * modes.Lambda()).norm();
        let sound = inverse.norm() * modes.V.norm() < LARGEST_CONDITION && missed <= 1e-12 * A.norm();
        sound.then_some(modes)
    }

    pub fn Lambda(&self) -> Mat {
        let n = self.V.ncols();
        let mut Lambda = Mat::zeros(n, n);
        let mut k = 0;
        for z in &self.poles {
            Lambda[(k, k)] = z.re;
            if z.im > 0.0 {
                Lambda[(k + 1, k + 1)] = z.re;
                (Lambda[(k, k + 1)], Lambda[(k + 1, k)]) = (z.im, -z.im);
                k += 1;
            }
            k += 1;
        }
        Lambda
    }
}

/// A vector of unit length in the null space of A - z I, by two steps of inverse iteration.
fn eigenvector(A: &Mat, z: C64) -> Option<CMat> {
    let n = A.nrows();
    let size = A.norm().max(f64::MIN_POSITIVE);
    // Off the eigenvalue by a rounding error or two, so that the factors exist.
    let shift = z + C64::new(size * 4.0 * f64::EPSILON, 0.0);
    let lu = (A.map(C64::from) - CMat::identity(n, n) * shift).lu();
    // Anything that is not orthogonal to the vector by accident.
    let mut v = CMat::from_fn(n, 1, |r, _| {
        C64::new(1.0 + (r as f64).sin(), (r as f64 * 1.7).cos() * f64::from(u8::from(z.im > 0.0)))
    });
    for _ in 0..3 {
        v = lu.solve(&v)?;
        let norm = v.norm();
        if !(norm > 0.0 && norm.is_finite()) {
            return None;
        }
        v /= C64::from(norm);
    }
    Some(v)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_of_a_mixed_matrix() {
        #[rustfmt::skip]
        let A = Mat::from_row_slice(4, 4, &[
            0.9, 0.2, 0.1, 0.0,
            0.0, 0.7, 0.5, 0.3,
            0.0, -0.5, 0.7, 0.0,
            0.0, 0.0, 0.0, 1.0,
        ]);
        let modes = Modes::of(&A).unwrap();
        assert_eq!(modes.poles.len(), 3);
        assert!((&A * &modes.V - &modes.V * modes.Lambda()).norm() < 1e-14);
    }

    #[test]
    fn a_repeated_pole_has_no_basis() {
        assert!(Modes::of(&Mat::from_row_slice(2, 2, &[0.5, 1.0, 0.0, 0.5])).is_none());
    }
}
