//! Eigenvalues of the clamped-free beam, 1 + cos mu cosh mu = 0.

use std::f64::consts::PI;

use std::sync::LazyLock;

/// sech mu is below half a unit in the last place of mu = (k - 1/2) pi from here on: mu_k is that number.
const ASYMPTOTIC: usize = 13;

static FIRST: LazyLock<[f64; ASYMPTOTIC]> = LazyLock::new(|| std::array::from_fn(newton));

/// The root mu_k, k = 1, 2, ..
///
/// Source: DESIGN section 3 (a).
pub fn clamped_free_root(k: usize) -> f64 {
    assert!(k >= 1, "the roots are counted from 1");
    if k <= ASYMPTOTIC { FIRST[k - 1] } else { (k as f64 - 0.5) * PI }
}

/// Newton doubles the digits from a start that is off by 0.3 at worst (k = 1).
const NEWTON_STEPS: usize = 7;

/// Numerics: the scaled form cos mu + sech mu = 0 cannot overflow, and its slope is near 1 at every root.
fn newton(index: usize) -> f64 {
    let mut mu = (index as f64 + 0.5) * PI;
    for _ in 0..NEWTON_STEPS {
        let sech = 1.0 / mu.cosh();
        mu += (mu.cos() + sech) / (mu.sin() + sech * mu.tanh());
    }
    mu
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_roots_as_tabulated() {
        // Blevins 1979, table 8-1, clamped-free.
        for (k, tabulated) in [1.87510407, 4.69409113, 7.85475744, 10.99554073, 14.13716839].iter().enumerate() {
            assert!((clamped_free_root(k + 1) - tabulated).abs() < 5e-9);
        }
    }

    #[test]
    fn power_sums_are_the_taylor_coefficients_of_the_characteristic_function() {
        // (1 + cos x cosh x)/2 = prod(1 - x^4/mu^4) = 1 - x^4/12 + x^8/5040 - ..
        let sum = |power: i32| (1..20_000).rev().map(|k| clamped_free_root(k).powi(-power)).sum::<f64>();
        assert!((sum(4) * 12.0 - 1.0).abs() < 1e-13);
        assert!((sum(8) / (1.0 / 144.0 - 2.0 / 5040.0) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn newton_gives_the_asymptotic_root_where_the_table_ends() {
        for index in [ASYMPTOTIC, 40, 1000] {
            assert!((newton(index) / clamped_free_root(index + 1) - 1.0).abs() < 2.0 * f64::EPSILON);
        }
        assert!(newton(ASYMPTOTIC - 3) != (ASYMPTOTIC as f64 - 2.5) * PI);
    }
}
