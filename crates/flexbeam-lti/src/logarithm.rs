//! Real matrix logarithm.
//!
//! Enters: a real square matrix. Leaves: the real logarithm with eigenvalues in |Im| < pi.
//! Deliberately absent: other branches, functions of matrices in general.

use crate::schur::{balanced, diagonal_blocks, eigenvalues, ordered_schur};
use crate::state_space::{expect_finite, expect_shape};
use crate::sylvester::triangular_sylvester;
use crate::{C64, Error, Mat};

/// Below this 1-norm of E eight Gauss points give log(I + E) to 1e-17: their error factor at -E is
/// ((1 - sqrt(3/4))/(1 + sqrt(3/4)))^16.
const NEAR_IDENTITY: f64 = 0.25;
/// Square roots after which a norm must have come below [`NEAR_IDENTITY`]: each halves the logarithm, and f64 ends at 2^1024.
const ROOTS: usize = 80;
/// Eigenvalues of M smaller than this lose digits in M - I: roots are taken of M itself until none is left.
const SMALL: f64 = 0.25;
/// Distance from the negative real axis, relative to the modulus, that rounding cannot tell from zero.
const ON_AXIS: f64 = 4.0 * f64::EPSILON;
/// Gauss-Legendre nodes (the positive half) and weights of eight points on [-1, 1].
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_47),
    (0.960_289_856_497_536_2, 0.101_228_536_290_376_26),
];

/// Principal logarithm X, e^X = M.
///
/// Shapes: M n x n; returns n x n.
/// Errors: [`Error::Shape`], [`Error::NotFinite`], [`Error::NotConverged`]; [`Error::NegativeEigenvalue`] for an eigenvalue of M
/// on the closed negative real axis.
/// Numerics: works on E = M - I, balanced, so a matrix near I loses nothing: entries of X are right to
/// a few eps times the balanced norm of E; on M while it has small eigenvalues. Defective eigenvalues do not matter. O(n^3).
/// Source: Kenney and Laub 1989 (inverse scaling and squaring), Higham 2001 (partial fractions of the Pade
/// approximant at Gauss points). Differs: the square roots are carried as roots minus I.
pub fn logarithm(M: &Mat) -> Result<Mat, Error> {
    expect_shape("M", M, M.nrows(), M.nrows())?;
    expect_finite("M", M)?;
    let n = M.nrows();
    let (E, scale) = balanced(&(M - Mat::identity(n, n)));
    let X = if one_norm(&E) <= NEAR_IDENTITY {
        logarithm_near_identity(&E)?
    } else {
        let M = Mat::from_fn(n, n, |i, j| M[(i, j)] * (scale[j] / scale[i]));
        by_square_roots(&M, &E)?
    };
    Ok(Mat::from_fn(n, n, |i, j| X[(i, j)] * (scale[i] / scale[j])))
}

/// log M = 2^k log(M^(1/2^k)) on the Schur form of E = M - I, or of M as long as it has small eigenvalues.
fn by_square_roots(M: &Mat, E: &Mat) -> Result<Mat, Error> {
    let of_M = ordered_schur(M, |_| false)?;
    expect_off_negative_axis(&of_M.T)?;
    let n = M.nrows();
    let (Q, mut T, mut roots) = (of_M.Q, of_M.T, 0);
    while has_small_eigenvalue(&T) && roots < ROOTS {
        (T, roots) = (square_root(&T, Carried::Whole)?, roots + 1);
    }
    let (Q, mut T) = if roots > 0 {
        (Q, T - Mat::identity(n, n))
    } else {
        let of_E = ordered_schur(E, |_| false)?;
        (of_E.Q, of_E.T)
    };
    while one_norm(&T) > NEAR_IDENTITY {
        if roots == ROOTS {
            return Err(Error::NotConverged { what: "square roots for the logarithm", iterations: ROOTS });
        }
        (T, roots) = (square_root(&T, Carried::LessIdentity)?, roots + 1);
    }
    let X = logarithm_near_identity(&T)? * 2f64.powi(roots as i32);
    Ok(&Q * X * Q.transpose())
}

fn expect_off_negative_axis(T: &Mat) -> Result<(), Error> {
    let on_axis = |p: &C64| p.re <= 0.0 && p.im.abs() <= ON_AXIS * p.re.abs();
    match eigenvalues(T).iter().find(|p| on_axis(p)) {
        Some(p) => Err(Error::NegativeEigenvalue { eigenvalue: p.re }),
        None => Ok(()),
    }
}

fn has_small_eigenvalue(T: &Mat) -> bool {
    eigenvalues(T).iter().any(|p| p.norm() < SMALL)
}

/// What a square root is taken of and given as: M itself, or M - I, which keeps what is near I accurate.
#[derive(Clone, Copy)]
enum Carried {
    Whole,
    LessIdentity,
}

/// R R = T, or (I + R)^2 = I + T, quasi-triangular like T, by block columns.
///
/// Source: Bjorck and Hammarling 1983, Higham 1987.
fn square_root(T: &Mat, carried: Carried) -> Result<Mat, Error> {
    let one = match carried {
        Carried::Whole => 0.0,
        Carried::LessIdentity => 1.0,
    };
    let identity = |size| Mat::from_diagonal_element(size, size, one);
    let mut R = Mat::zeros(T.nrows(), T.nrows());
    for (j, q) in diagonal_blocks(T) {
        R.view_mut((j, j), (q, q)).copy_from(&block_root(&T.view((j, j), (q, q)).into_owned(), carried));
        // The column above the block solves a Sylvester equation between the roots on its left and below.
        let left = identity(j) + R.view((0, 0), (j, j));
        let below = identity(q) + R.view((j, j), (q, q));
        let X = triangular_sylvester(&left, &below, T.view((0, j), (j, q)).into_owned())?;
        R.view_mut((0, j), (j, q)).copy_from(&X);
    }
    Ok(R)
}

fn block_root(T: &Mat, carried: Carried) -> Mat {
    let t = eigenvalues(T)[0];
    let f = match carried {
        Carried::Whole => t.sqrt(),
        // sqrt(1 + t) - 1 without cancellation.
        Carried::LessIdentity => t / (1.0 + (1.0 + t).sqrt()),
    };
    if T.nrows() == 1 {
        return Mat::from_element(1, 1, f.re);
    }
    // Standard block a I + N with N N = -mu^2 I: any function is Re f I + Im f/mu N.
    let slope = f.im / t.im;
    Mat::from_row_slice(2, 2, &[f.re, slope * T[(0, 1)], slope * T[(1, 0)], f.re])
}

/// log(I + E) = integral of E (I + x E)^-1 over x in [0, 1], at eight Gauss points.
fn logarithm_near_identity(E: &Mat) -> Result<Mat, Error> {
    let n = E.nrows();
    let mut X = Mat::zeros(n, n);
    for (node, weight) in GAUSS {
        for x in [0.5 * (1.0 - node), 0.5 * (1.0 + node)] {
            let term = (Mat::identity(n, n) + E * x).lu().solve(E);
            X += term.expect("I + x E is invertible: the norm of x E is below one") * (0.5 * weight);
        }
    }
    Ok(X)
}

fn one_norm(M: &Mat) -> f64 {
    M.column_iter().map(|column| column.lp_norm(1)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Draw;
    use crate::exponential::exponential;

    fn round_trip_error(M: &Mat) -> f64 {
        (exponential(&logarithm(M).unwrap()) - M).norm() / M.norm().max(f64::MIN_POSITIVE)
    }

    #[test]
    fn exponential_undoes_it() {
        let mut draw = Draw(41);
        for n in [0, 1, 2, 3, 5, 12, 50] {
            for size in [1e-6, 0.1, 1.0, 2.0] {
                // |Im lambda| below pi: X is the principal logarithm of its exponential.
                let X = draw.matrix(n, n) * (size / (n as f64 + 1.0).sqrt());
                let found = logarithm(&exponential(&X)).unwrap();
                // The exponential's own rounding is relative to one, not to X.
                let allowed = 1e-13 * X.norm() + 4.0 * f64::EPSILON * n as f64;
                assert!((found - &X).norm() <= allowed, "{n} {size}");
            }
        }
    }

    #[test]
    fn the_plant_18_comes_back_from_one_millisecond() {
        let period_s = 0.001;
        let mut X = Mat::zeros(5, 5);
        let nonzero = [
            (0, 2, 1.0),
            (1, 3, 1.0),
            (2, 1, 1060.8),
            (2, 2, -57.7),
            (3, 1, -1465.2),
            (3, 2, 57.7),
            (2, 4, 107.39),
            (3, 4, -107.39),
        ];
        for (i, j, x) in nonzero {
            X[(i, j)] = x;
        }
        let found = logarithm(&exponential(&(&X * period_s))).unwrap() / period_s;
        let worst = nonzero.iter().map(|&(i, j, x)| (found[(i, j)] / x - 1.0).abs()).fold(0.0, f64::max);
        println!("worst relative entry: {worst:e}, worst entry: {:e}", (&found - &X).amax());
        assert!(worst < 1e-12, "{worst}");
        assert!((found - X).amax() < 1e-10);
    }

    #[test]
    fn near_the_identity_small_entries_keep_their_digits() {
        // Nilpotent X: e^X = I + X + X^2/2 exactly; entries 12 decades apart.
        let mut X = Mat::zeros(3, 3);
        (X[(0, 1)], X[(1, 2)], X[(0, 2)]) = (1e-9, 1e3, 1e-3);
        let M = Mat::identity(3, 3) + &X + &X * &X * 0.5;
        let found = logarithm(&M).unwrap();
        for (i, j) in [(0, 1), (1, 2), (0, 2)] {
            assert!((found[(i, j)] / X[(i, j)] - 1.0).abs() < 1e-14, "{i} {j}");
        }
    }

    #[test]
    fn rotations_and_jordan_blocks() {
        for angle in [1e-8, 1.0, 3.0, std::f64::consts::PI - 1e-5] {
            let (s, c) = f64::sin_cos(angle);
            let X = logarithm(&Mat::from_row_slice(2, 2, &[c, s, -s, c])).unwrap();
            assert!((X[(0, 1)] / angle - 1.0).abs() < 1e-14 && X[(0, 0)].abs() < 1e-15, "{angle}: {X}");
        }
        for lambda in [1e-6, 0.3, 1.0, 50.0] {
            let J = Mat::from_fn(4, 4, |i, j| if i == j { lambda } else { f64::from(u8::from(j == i + 1)) * lambda });
            let X = logarithm(&J).unwrap();
            let ln = lambda.ln();
            let known = [ln, 1.0, -0.5, 1.0 / 3.0];
            for (j, known) in known.iter().enumerate() {
                assert!((X[(0, j)] - known).abs() < 1e-13 * (1.0 + ln.abs()), "{lambda} {j}: {}", X[(0, j)]);
            }
        }
    }

    #[test]
    fn eigenvalues_over_many_decades() {
        let mut draw = Draw(42);
        let Q = draw.matrix(6, 6).qr().q();
        let lambda = crate::Vector::from_row_slice(&[1e-6, 1e-3, 1.0, 7.0, 1e3, 1e6]);
        let M = &Q * Mat::from_diagonal(&lambda) * Q.transpose();
        assert!(round_trip_error(&M) < 1e-13, "{}", round_trip_error(&M));
    }

    #[test]
    fn negative_and_zero_eigenvalues_are_named() {
        for lambda in [-0.25, 0.0, -30.0] {
            let M = Mat::from_row_slice(2, 2, &[lambda, 5.0, 0.0, 2.0]);
            assert_eq!(logarithm(&M), Err(Error::NegativeEigenvalue { eigenvalue: lambda }));
        }
    }
}
