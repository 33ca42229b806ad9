//! Products of columns that stand one after the other.
//!
//! Enters: columns of one length, a multiple of eight. Leaves: their products, or one of them less a combination of the others.

use crate::lanes::{Kernel, LANES, Lanes, on_widest};

/// Columns that one pass over another multiplies.
const TILE: usize = 4;

/// Columns of `rows` numbers each; those that are not `alive` are zero, and skipped.
#[derive(Clone, Copy)]
pub(crate) struct Columns<'a> {
    pub data: &'a [f64],
    pub rows: usize,
    pub alive: &'a [bool],
}

impl<'a> Columns<'a> {
    fn column(self, c: usize) -> &'a [f64] {
        &self.data[c * self.rows..(c + 1) * self.rows]
    }

    /// Products of all pairs: entry c n + r for c <= r; those of columns that are not alive are left as they are.
    pub fn gram(self, found: &mut [f64]) {
        let n = self.alive.len();
        for c in (0..n).filter(|c| self.alive[*c]) {
            let rest = Columns { data: &self.data[c * self.rows..], rows: self.rows, alive: &self.alive[c..] };
            rest.products(self.column(c), &mut found[c * n + c..(c + 1) * n]);
        }
    }

    /// Products with one more column.
    pub fn products(self, column: &[f64], found: &mut [f64]) {
        assert!(self.rows.is_multiple_of(LANES) && column.len() == self.rows, "{} rows", self.rows);
        on_widest(Products { columns: self, column, found });
    }

    /// `column` less the sum of weight times column.
    pub fn take_from(self, weights: &[f64], column: &mut [f64]) {
        assert!(self.rows.is_multiple_of(LANES) && column.len() == self.rows, "{} rows", self.rows);
        on_widest(TakeFrom { columns: self, weights, column });
    }
}

struct Products<'a, 'b> {
    columns: Columns<'a>,
    column: &'a [f64],
    found: &'b mut [f64],
}

impl Kernel for Products<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Columns { data, rows, alive } = self.columns;
        let mut c = 0;
        while c < alive.len() {
            let four = c + TILE <= alive.len() && alive[c] && alive[c + 1] && alive[c + 2] && alive[c + 3];
            if four {
                let sums = tile::<L, TILE>(&data[c * rows..(c + TILE) * rows], rows, self.column);
                self.found[c..c + TILE].copy_from_slice(&sums);
                c += TILE;
            } else {
                if alive[c] {
                    self.found[c] = tile::<L, 1>(&data[c * rows..(c + 1) * rows], rows, self.column)[0];
                }
                c += 1;
            }
        }
    }
}

/// Products of N columns with one.
#[inline(always)]
fn tile<L: Lanes, const N: usize>(columns: &[f64], rows: usize, column: &[f64]) -> [f64; N] {
    // Two sums a column: one alone would wait for itself.
    let mut sums = [[L::splat(0.0); 2]; N];
    let (columns, column) = (&columns[..N * rows], &column[..rows]);
    let mut k = 0;
    while k + 2 * LANES <= rows {
        let (x, y) = (L::load(&column[k..]), L::load(&column[k + LANES..]));
        for (n, sum) in sums.iter_mut().enumerate() {
            let at = n * rows + k;
            sum[0] = L::load(&columns[at..]).times_plus(x, sum[0]);
            sum[1] = L::load(&columns[at + LANES..]).times_plus(y, sum[1]);
        }
        k += 2 * LANES;
    }
    if k < rows {
        let x = L::load(&column[k..]);
        for (n, sum) in sums.iter_mut().enumerate() {
            sum[0] = L::load(&columns[n * rows + k..]).times_plus(x, sum[0]);
        }
    }
    let mut found = [0.0; N];
    for (found, sum) in found.iter_mut().zip(sums) {
        *found = sum[0].plus(sum[1]).total();
    }
    found
}

struct TakeFrom<'a, 'b> {
    columns: Columns<'a>,
    weights: &'a [f64],
    column: &'b mut [f64],
}

impl Kernel for TakeFrom<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Columns { data, rows, alive } = self.columns;
        for k in (0..rows).step_by(LANES) {
            let mut x = L::load(&self.column[k..]);
            for c in 0..alive.len() {
                if alive[c] {
                    x = L::load(&data[c * rows + k..]).times_plus(L::splat(-self.weights[c]), x);
                }
            }
            x.store(&mut self.column[k..]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::white_gaussian;

    #[test]
    fn products_and_combinations_are_those_of_plain_sums() {
        for (rows, n) in [(8, 1), (24, 6), (64, 9)] {
            let data = white_gaussian(rows * n, 1.0, 9.0, 3);
            let alive: Vec<bool> = (0..n).map(|c| c != 2).collect();
            let columns = Columns { data: &data, rows, alive: &alive };
            let mut found = vec![7.0; n * n];
            columns.gram(&mut found);
            let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
            let mut rest = columns.column(0).to_vec();
            let weights: Vec<f64> = (0..n).map(|c| c as f64 - 1.5).collect();
            columns.take_from(&weights, &mut rest);
            for c in 0..n {
                for r in 0..n {
                    let wanted = if r < c || !alive[c] || !alive[r] {
                        7.0
                    } else {
                        product(columns.column(c), columns.column(r))
                    };
                    assert!((found[c * n + r] - wanted).abs() < 1e-13 * rows as f64, "({r},{c})");
                }
            }
            for (k, rest) in rest.iter().enumerate() {
                let sum: f64 = (0..n).filter(|c| alive[*c]).map(|c| weights[c] * columns.column(c)[k]).sum();
                assert!((rest - (columns.column(0)[k] - sum)).abs() < 1e-13);
            }
        }
    }
}
