use crate::plants::{Noise, distance};
use flexbeam_lti::generalised::{GeneralisedEigenvalue, generalised_eigenvalues};
use flexbeam_lti::{C64, Error, Mat};

fn finite(found: &[GeneralisedEigenvalue]) -> Vec<C64> {
    found.iter().filter_map(|e| e.finite()).collect()
}

/// Smallest singular value of beta A - alpha B relative to its size.
fn residual(A: &Mat, B: &Mat, e: &GeneralisedEigenvalue) -> f64 {
    let M = A.map(|a| e.beta * a) - B.map(|b| e.alpha * b);
    M.singular_values().min() / (e.beta.norm() * A.norm() + e.alpha.norm() * B.norm()).max(f64::MIN_POSITIVE)
}

#[test]
fn every_eigenvalue_makes_the_pencil_singular() {
    let mut noise = Noise(1);
    for n in 1..30 {
        let (A, B) = (noise.matrix(n, n), noise.matrix(n, n));
        let found = generalised_eigenvalues(&A, &B).unwrap();
        assert_eq!(found.len(), n);
        assert!(found.iter().all(|e| residual(&A, &B, e) < 1e-14), "{n}");
        // Each counted once: their product is det A / det B, their sum the trace of B^-1 A.
        let product: C64 = finite(&found).iter().product();
        let ratio = A.determinant() / B.determinant();
        assert!((product - ratio).norm() < 1e-9 * ratio.abs(), "{n}: {product} {ratio}");
    }
}

#[test]
fn a_planted_spectrum_is_found_with_its_infinite_part() {
    let mut noise = Noise(2);
    let (P, Q) = (noise.matrix(7, 7), noise.matrix(7, 7));
    let mut S = Mat::from_diagonal(&nalgebra::DVector::from_vec(vec![1.0, -2.0, 0.0, 3.0, 3.0, 1.0, 1.0]));
    (S[(3, 4)], S[(4, 3)]) = (4.0, -4.0);
    for defective in [0.0, 1.0] {
        let mut T = Mat::identity(7, 7);
        (T[(5, 5)], T[(6, 6)], T[(5, 6)]) = (0.0, 0.0, defective);
        let found = generalised_eigenvalues(&(&P * &S * &Q), &(&P * &T * &Q)).unwrap();
        let wanted = [(1.0, 0.0), (-2.0, 0.0), (0.0, 0.0), (3.0, 4.0), (3.0, -4.0)].map(|(re, im)| C64::new(re, im));
        let (finite, infinite): (Vec<&GeneralisedEigenvalue>, Vec<_>) =
            found.iter().partition(|e| e.alpha.norm() < 1e5 * e.beta.norm());
        let finite: Vec<C64> = finite.iter().map(|e| e.alpha / e.beta).collect();
        assert!(distance(&finite, &wanted, 1.0) < 1e-11, "{finite:?}");
        assert_eq!(infinite.len(), 2);
    }
}

#[test]
fn exact_zeros_of_B_are_infinite_eigenvalues() {
    let mut noise = Noise(3);
    for n in [2, 3, 6] {
        for zeros in 1..=n {
            let A = noise.matrix(n, n);
            let mut B = noise.matrix(n, n).upper_triangle();
            for k in 0..zeros {
                let i = (k * 2 + 1) % n;
                let i = if B[(i, i)] == 0.0 { (i + 1) % n } else { i };
                B.fill_row(i, 0.0);
            }
            let rank = (0..n).filter(|&i| B.row(i).norm() > 0.0).count();
            let found = generalised_eigenvalues(&A, &B).unwrap();
            assert_eq!(finite(&found).len(), rank, "{n} {zeros}");
            assert!(found.iter().all(|e| residual(&A, &B, e) < 1e-14));
        }
    }
}

#[test]
fn cycles_are_broken() {
    // Orthogonal and Hessenberg: a shift of 0 leaves it as it is. Eigenvalues: the roots of unity.
    for n in 2..12 {
        let A = Mat::from_fn(n, n, |i, j| f64::from((j + 1) % n == i));
        let found = finite(&generalised_eigenvalues(&A, &Mat::identity(n, n)).unwrap());
        let wanted: Vec<C64> = (0..n).map(|k| C64::cis(std::f64::consts::TAU * k as f64 / n as f64)).collect();
        assert!(distance(&found, &wanted, 1.0) < 1e-13, "{n}: {found:?}");
    }
}

#[test]
fn conjugates_are_exact() {
    let mut noise = Noise(5);
    let (A, B) = (noise.matrix(9, 9), noise.matrix(9, 9));
    let found = finite(&generalised_eigenvalues(&A, &B).unwrap());
    assert!(found.iter().all(|e| found.contains(&e.conj())));
}

#[test]
fn zero_matrices_and_wrong_shapes() {
    let zero = Mat::zeros(3, 3);
    let both = generalised_eigenvalues(&zero, &zero).unwrap();
    assert!(both.iter().all(|e| e.alpha == C64::ZERO && e.beta == C64::ZERO && e.finite().is_none()));
    assert_eq!(finite(&generalised_eigenvalues(&zero, &Mat::identity(3, 3)).unwrap()), [C64::ZERO; 3]);
    assert!(generalised_eigenvalues(&Mat::zeros(0, 0), &Mat::zeros(0, 0)).unwrap().is_empty());
    assert!(matches!(generalised_eigenvalues(&zero, &Mat::zeros(2, 2)), Err(Error::Shape { .. })));
    assert!(matches!(generalised_eigenvalues(&zero.add_scalar(f64::NAN), &zero), Err(Error::NotFinite { .. })));
}
