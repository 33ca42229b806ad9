//! A inside the unit circle, by constrained least squares.
//!
//! Enters: Gamma, the A of its shift structure. Leaves: an A all of whose eigenvalues are stable.
//! Deliberately absent: poles mirrored or cut off, which forget what the data say about the directions.

use flexbeam_lti::{C64, Mat, schur};

use crate::modes::eigenvector;

/// Steps of the constrained least squares; ten to a hundred settle it.
const MOST_STEPS: usize = 300;
/// A step shorter than this many halves is none.
const MOST_HALVES: i32 = 40;
/// A step below this part of A changes nothing.
const SETTLED: f64 = 1e-12;
/// Outside by no more than this is on the limit.
const ON_THE_LIMIT: f64 = 1e-6;
/// An eigenvalue nearer to the limit than this may cross it within the step: it is watched.
const NEAR_THE_LIMIT: f64 = 0.02;

/// min |Gamma_up A - Gamma_down|^2 over |eig A| <= 1 - 1/s.
///
/// Shapes: gamma il x n with blocks of l rows, A n x n, the minimum without the constraint.
/// Returns A itself when it is stable. A decay slower than the estimating part is long (s samples) is no different from
/// none, so that is where an unstable eigenvalue ends.
/// Numerics: the moduli are linearised at each step (d|z| = Re(conj z w* dA v / w* v)/|z|, v and w the eigenvectors) and the
/// equality-constrained least squares solved; it settles on a local minimum. Where it does not, at a Jordan block, or where it is
/// no better, A as a whole is scaled onto the limit: the answer is stable in any case.
/// Source: the problem of Lacy and Bernstein 2003, with the spectral radius itself in place of their Lyapunov inequality.
pub(crate) fn stable(gamma: &Mat, l: usize, A: Mat, s: usize) -> Mat {
    if radius(&A) < 1.0 {
        return A;
    }
    let limit = 1.0 - 1.0 / s as f64;
    let up = gamma.rows(0, gamma.nrows() - l);
    let misfit = |found: &Mat| (up * (found - &A)).norm();
    let scaled = &A * (limit / radius(&A));
    let constrained = Constrained { gram: up.transpose() * up, A: &A, limit }.solution();
    match constrained {
        Some(found) if misfit(&found) < misfit(&scaled) => found,
        _ => scaled,
    }
}

/// min tr (X - A)' S (X - A) over |eig X| <= limit, S = Gamma_up' Gamma_up.
struct Constrained<'a> {
    gram: Mat,
    A: &'a Mat,
    limit: f64,
}

impl Constrained<'_> {
    fn solution(&self) -> Option<Mat> {
        let root = self.gram.clone().cholesky()?;
        let mut X = self.A.clone();
        let mut price = 0.0;
        for _ in 0..MOST_STEPS {
            let (next, multiplier) = self.linearised(&X, &root)?;
            price = f64::max(price, 4.0 * multiplier);
            match self.shortened(&X, &(next - &X), price) {
                Some(step) if step.norm() > SETTLED * X.norm() => X += step,
                _ => break,
            }
        }
        // What rounding leaves outside goes inside; what never settled is not the answer.
        let excess = radius(&X) / self.limit;
        (excess < 1.0 + ON_THE_LIMIT).then(|| if excess > 1.0 { X / excess } else { X })
    }

    /// The step, or the longest of its halves that lowers the misfit plus `price` for what is outside.
    fn shortened(&self, X: &Mat, step: &Mat, price: f64) -> Option<Mat> {
        let cost = |X: &Mat| {
            let away = X - self.A;
            let outside = |z: &C64| (z.norm() - self.limit).max(0.0);
            (&self.gram * &away).dot(&away)
                + price * schur::spectrum(X).map_or(f64::INFINITY, |poles| poles.iter().map(outside).sum())
        };
        let now = cost(X);
        let shorter = |k: i32| step * 0.5_f64.powi(k);
        (0..MOST_HALVES).map(shorter).find(|step| cost(&(X + step)) < now)
    }

    /// The minimum with the moduli linearised at X, and the largest of its multipliers.
    fn linearised(&self, X: &Mat, root: &nalgebra::Cholesky<f64, nalgebra::Dyn>) -> Option<(Mat, f64)> {
        let out = |z: &&C64| z.norm() > self.limit * (1.0 - NEAR_THE_LIMIT) && z.im >= 0.0;
        let poles = schur::spectrum(X).ok()?;
        let mut active: Vec<(f64, Mat)> = poles.iter().filter(out).map(|z| modulus(X, *z)).collect();
        while !active.is_empty() {
            let moved: Vec<Mat> = active.iter().map(|(_, G)| root.solve(G)).collect();
            let right = active.iter().map(|(size, G)| self.limit - size - G.dot(&(self.A - X)));
            let right = Mat::from_iterator(active.len(), 1, right);
            let gram = Mat::from_fn(active.len(), active.len(), |r, c| active[r].1.dot(&moved[c]));
            let mu = gram.full_piv_lu().solve(&right)?;
            // A multiplier of the other sign pulls outwards: that constraint holds by itself.
            match (0..active.len()).filter(|&k| mu[k] > 0.0).max_by(|&a, &b| mu[a].total_cmp(&mu[b])) {
                Some(k) => drop(active.remove(k)),
                None => {
                    let sum = moved.iter().zip(mu.iter()).fold(self.A.clone(), |X, (M, mu)| X + M * *mu);
                    return Some((sum, mu.amax()));
                }
            }
        }
        Some((self.A.clone(), 0.0))
    }
}

/// |z| and its gradient over the entries of A, z a simple eigenvalue.
fn modulus(A: &Mat, z: C64) -> (f64, Mat) {
    let (v, w) = (eigenvector(A, z), eigenvector(&A.transpose(), z.conj()));
    let direction = z.conj() / (z.norm() * w.dotc(&v));
    let gradient = Mat::from_fn(A.nrows(), A.nrows(), |r, c| (direction * w[r].conj() * v[c]).re);
    (z.norm(), gradient)
}

fn radius(A: &Mat) -> f64 {
    schur::spectrum(A).map_or(f64::INFINITY, |poles| poles.iter().map(|z| z.norm()).fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A in coordinates that are far from diagonal, and its Gamma of ten block rows with some noise.
    fn gamma(diagonal: &Mat, l: usize) -> Mat {
        let n = diagonal.nrows();
        let T = Mat::from_fn(n, n, |r, c| ((r + 2 * c + 1) as f64).sin() + if r == c { 2.0 } else { 0.0 });
        let A = &T * diagonal * T.clone().try_inverse().unwrap();
        let mut block = Mat::from_fn(l, n, |r, c| 1.0 / (1.0 + (r + c) as f64));
        let mut gamma = Mat::zeros(10 * l, n);
        for k in 0..10 {
            gamma.rows_mut(k * l, l).copy_from(&block);
            block *= &A;
        }
        Mat::from_fn(10 * l, n, |r, c| gamma[(r, c)] + 1e-3 * (((r + 1) * (c + 3)) as f64 * 2.7).sin())
    }

    fn shifted(gamma: &Mat, l: usize) -> Mat {
        crate::subspace::shift(gamma, l).unwrap().0
    }

    fn misfit(gamma: &Mat, l: usize, A: &Mat) -> f64 {
        let tall = gamma.nrows() - l;
        (gamma.rows(0, tall) * A - gamma.rows(l, tall)).norm()
    }

    #[rustfmt::skip]
    fn swing_and_two(radius: f64, slow: f64) -> Mat {
        let (c, s) = (radius * 0.4_f64.cos(), radius * 0.4_f64.sin());
        Mat::from_row_slice(4, 4, &[
              c,   s, 0.0,  0.0,
             -s,   c, 0.0,  0.0,
            0.0, 0.0, slow, 0.0,
            0.0, 0.0, 0.0,  0.5,
        ])
    }

    #[test]
    fn a_stable_matrix_stays_bit_for_bit() {
        let gamma = gamma(&swing_and_two(0.9, 0.8), 2);
        let A = shifted(&gamma, 2);
        assert_eq!(stable(&gamma, 2, A.clone(), 500), A);
    }

    /// No neighbour that is as stable fits better.
    fn expect_minimum(gamma: &Mat, found: &Mat, limit: f64) {
        let least = misfit(gamma, 2, found);
        for k in 0..400 {
            let direction = Mat::from_fn(4, 4, |r, c| ((k * 16 + 4 * r + c) as f64 * 1.3).sin());
            let mut near = found + direction * 1e-3;
            near *= (limit / radius(&near)).min(1.0);
            assert!(misfit(gamma, 2, &near) > least * (1.0 - 1e-9), "neighbour {k}");
        }
    }

    /// Real, complex, and both outside: the eigenvalues end on the limit, the others hardly move.
    #[test]
    fn unstable_eigenvalues_end_on_the_limit_at_little_cost() {
        for (radius_of_swing, slow) in [(1.03, 0.8), (0.9, 1.02), (1.03, 1.02)] {
            let gamma = gamma(&swing_and_two(radius_of_swing, slow), 2);
            let A = shifted(&gamma, 2);
            assert!(radius(&A) > 1.0);
            let found = stable(&gamma, 2, A.clone(), 500);
            let limit = 1.0 - 1.0 / 500.0;
            assert!((radius(&found) - limit).abs() < 1e-9, "{}", radius(&found));
            let scaled = &A * (limit / radius(&A));
            let [ours, scaled] = [found.clone(), scaled].map(|A| misfit(&gamma, 2, &A));
            println!("misfit {ours:.2e}, scaled {scaled:.2e}");
            assert!(ours < 0.8 * scaled);
            expect_minimum(&gamma, &found, limit);
            let poles = schur::spectrum(&found).unwrap();
            let nearest = |z: C64| poles.iter().map(|w| (w - z).norm()).fold(f64::MAX, f64::min);
            assert!(nearest(C64::new(0.5, 0.0)) < 0.1, "{poles:?}");
        }
    }

    /// Twice the same unstable eigenvalue in one Jordan block.
    #[test]
    fn a_repeated_unstable_eigenvalue_is_stabilised() {
        let jordan = Mat::from_row_slice(3, 3, &[1.05, 1.0, 0.0, 0.0, 1.05, 0.0, 0.0, 0.0, 0.3]);
        let gamma = gamma(&jordan, 1);
        let found = stable(&gamma, 1, shifted(&gamma, 1), 100);
        assert!(radius(&found) <= 0.99 + 1e-9, "{}", radius(&found));
    }
}
