use super::*;
use crate::draw::Draw;

fn check(A: &Mat, first: impl Fn(C64) -> bool, factor: f64) -> OrderedSchur {
    let n = A.nrows();
    let S = ordered_schur(A, &first).unwrap();
    let size = A.norm().max(f64::MIN_POSITIVE);
    assert!((&S.Q * &S.T * S.Q.transpose() - A).norm() <= factor * f64::EPSILON * size, "residual");
    assert!((S.Q.tr_mul(&S.Q) - Mat::identity(n, n)).norm() <= factor * f64::EPSILON, "orthogonality");
    for j in 0..n {
        assert!((j + 2..n).all(|i| S.T[(i, j)] == 0.0), "quasi-triangular");
    }
    for (k, width) in diagonal_blocks(&S.T) {
        if width == 2 {
            assert_eq!(S.T[(k, k)], S.T[(k + 1, k + 1)]);
            assert!(S.T[(k, k + 1)] * S.T[(k + 1, k)] < 0.0);
        }
    }
    S
}

#[test]
fn chosen_eigenvalues_lead() {
    let mut draw = Draw(1);
    for n in [0, 1, 2, 3, 4, 5, 8, 20, 50] {
        for _ in 0..if n < 10 { 40 } else { 3 } {
            let A = draw.matrix(n, n);
            let S = check(&A, |p| p.re < 0.0, 40.0 * (n as f64 + 1.0));
            let found = eigenvalues(&S.T);
            assert!(found.iter().enumerate().all(|(k, p)| (p.re < 0.0) == (k < S.leading)), "{n}: {found:?}");
        }
    }
}

#[test]
fn order_by_modulus_moves_pairs_past_pairs() {
    // Lightly damped pairs, 1e-4, frequencies over 12 decades, hidden by an orthogonal transformation.
    let n = 12;
    let mut modes = Mat::zeros(n, n);
    for k in 0..n / 2 {
        let omega = 10f64.powf(-6.0 + 12.0 * k as f64 / 5.0);
        modes[(2 * k, 2 * k)] = -1e-4 * omega;
        modes[(2 * k + 1, 2 * k + 1)] = -1e-4 * omega;
        modes[(2 * k, 2 * k + 1)] = omega;
        modes[(2 * k + 1, 2 * k)] = -omega;
    }
    let S = check(&modes, |p| p.norm() > 10.0, 100.0);
    assert_eq!(S.leading, 6);
    let Q = Draw(2).matrix(n, n).qr().q();
    let S = check(&(&Q * modes * Q.transpose()), |p| p.norm() > 10.0, 500.0);
    assert_eq!(S.leading, 6);
}

#[test]
fn cyclic_and_nilpotent_matrices_converge() {
    for n in 2..12 {
        let cyclic = Mat::from_fn(n, n, |i, j| f64::from(u8::from(i == (j + 1) % n)));
        let S = check(&cyclic, |p| p.re > 0.5, 100.0 * n as f64);
        assert!(eigenvalues(&S.T).iter().all(|p| (p.norm() - 1.0).abs() < 1e-13));
        let nilpotent = Mat::from_fn(n, n, |i, j| f64::from(u8::from(i == j + 1)));
        let S = check(&nilpotent, |_| false, 100.0 * n as f64);
        assert!(eigenvalues(&S.T).iter().all(|p| p.norm() == 0.0));
        check(&Mat::zeros(n, n), |_| true, 1.0);
    }
}

#[test]
fn known_spectrum_survives() {
    let mut draw = Draw(3);
    let poles = [-1.0, -1.0, -1.0, 2.0, 5.0, -40.0];
    let mut T = draw.matrix(6, 6).upper_triangle();
    T.set_diagonal(&crate::Vector::from_row_slice(&poles));
    let Q = draw.matrix(6, 6).qr().q();
    let S = check(&(&Q * T * Q.transpose()), |p| p.re > 0.0, 200.0);
    let mut found: Vec<f64> = eigenvalues(&S.T)[..2].iter().map(|p| p.re).collect();
    found.sort_by(f64::total_cmp);
    assert!((found[0] - 2.0).abs() < 1e-12 && (found[1] - 5.0).abs() < 1e-12);
    assert!(eigenvalues(&S.T)[2..].iter().all(|p| p.re < -0.99));
}

#[test]
fn balancing_recovers_small_eigenvalues_of_a_badly_scaled_matrix() {
    let S = Mat::from_diagonal(&crate::Vector::from_row_slice(&[1.0, 1e4, 1e-5, 1e6]));
    let A = Mat::from_row_slice(4, 4, &[1., 2., 0., 1., 2., 3., 1., 0., 0., 1., 5., 2., 1., 0., 2., -4.]);
    let mut known: Vec<f64> = A.clone().symmetric_eigenvalues().iter().copied().collect();
    known.sort_by(f64::total_cmp);
    let skewed = &S * A * S.map(|x| if x == 0.0 { 0.0 } else { 1.0 / x });
    let mut found: Vec<f64> = spectrum(&skewed).unwrap().iter().map(|p| p.re).collect();
    found.sort_by(f64::total_cmp);
    for (found, known) in found.iter().zip(&known) {
        assert!((found - known).abs() < 1e-13 * 7.0, "{found} {known}");
    }
}

#[test]
fn equal_eigenvalues_cannot_be_parted() {
    let A = Mat::from_row_slice(4, 4, &[1., 2., 1., 1., -2., 1., 1., 1., 0., 0., 1., 2., 0., 0., -2., 1.]);
    // A predicate that separates what rounding has made of one double pair.
    let asked = std::cell::Cell::new(0);
    let second = |_| asked.replace(asked.get() + 1) == 1;
    assert!(matches!(ordered_schur(&A, second), Err(Error::NotSeparable { .. })));
}

#[test]
fn bad_input_is_named() {
    assert!(matches!(ordered_schur(&Mat::zeros(2, 3), |_| true), Err(Error::Shape { .. })));
    let A = Mat::from_element(3, 3, f64::NAN);
    assert!(matches!(spectrum(&A), Err(Error::NotFinite { row: 1, column: 1, .. })));
}
