use crate::Mat;

/// Rows and columns closer than this in norm are balanced enough.
const WORTHWHILE: f64 = 0.95;
/// Rounds after which balancing stops; three are typical.
const ROUNDS: usize = 100;

/// (S^-1 A S, diagonal of S) with rows and columns of like 1-norm; S holds powers of two, so nothing is rounded.
///
/// Source: Osborne 1960, Parlett and Reinsch 1969. Differs: no permutation.
pub fn balanced(A: &Mat) -> (Mat, Vec<f64>) {
    let mut A = A.clone();
    let mut scale = vec![1.0; A.nrows()];
    for _ in 0..ROUNDS {
        let mut settled = true;
        for (k, scale) in scale.iter_mut().enumerate() {
            let factor = balancing_factor(&A, k);
            if factor != 1.0 {
                A.column_mut(k).scale_mut(factor);
                A.row_mut(k).unscale_mut(factor);
                *scale *= factor;
                settled = false;
            }
        }
        if settled {
            break;
        }
    }
    (A, scale)
}

/// The power of two that brings column k and row k together, 1 when that gains too little.
fn balancing_factor(A: &Mat, k: usize) -> f64 {
    let column = A.column(k).lp_norm(1) - A[(k, k)].abs();
    let row = A.row(k).lp_norm(1) - A[(k, k)].abs();
    if !(column > 0.0 && row > 0.0) {
        return 1.0;
    }
    let factor = (0.5 * (row / column).log2()).round().exp2();
    let gains = column * factor + row / factor < WORTHWHILE * (column + row);
    if gains && factor.is_normal() { factor } else { 1.0 }
}
