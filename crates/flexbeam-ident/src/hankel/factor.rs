//! Triangular factor of the block Hankel matrices.
//!
//! Enters: inputs and outputs, samples x channels. Leaves: L of H = L Q for all 2i block rows of (8), from which every
//! projection of (13) follows. Deliberately absent: Q and anything else of width j.

use flexbeam_lti::Mat;

use super::cholesky::cholesky;
use crate::Error;
use crate::correlation::Gram;
use crate::double::Double;
use crate::singular::rank;

/// H = L Q with H = [1; U_f; U_p; Y_p; Y_f] of 2i block rows; the row of ones only on request, and left out of L again.
///
/// Leaving out the row of ones projects on its orthogonal complement: each Hankel row loses its own mean.
pub(crate) struct Factor {
    /// Lower triangular, 2i(m + l) square, rows in the order of H.
    pub L: Mat,
    /// Block rows i.
    pub i: usize,
    /// Inputs m.
    pub m: usize,
    /// Outputs l.
    pub l: usize,
}

/// Samples that i block rows of m inputs and l outputs need: as many columns as rows, j >= 2i(m + l).
pub(crate) fn samples_needed(i: usize, m: usize, l: usize) -> usize {
    2 * i * (m + l + 1) - 1
}

impl Factor {
    /// From H H' of [u; y], channels divided by `scale`; `constant` leaves out each Hankel row's own mean.
    ///
    /// Assumes: at least as many columns as rows, [`samples_needed`].
    /// Numerics: see [`Gram`] and [`cholesky`]: in double-double, so that nothing is lost by squaring.
    pub fn of_gram(gram: &Gram, m: usize, scale: &[f64], constant: bool) -> Factor {
        let (i, c) = (gram.i, gram.channels());
        let l = c - m;
        let lags = |channels: std::ops::Range<usize>, lags: std::ops::Range<usize>| {
            lags.flat_map(move |p| channels.clone().map(move |a| p * c + a))
        };
        let rows: Vec<usize> =
            lags(0..m, i..2 * i).chain(lags(0..m, 0..i)).chain(lags(m..c, 0..i)).chain(lags(m..c, i..2 * i)).collect();
        let ones = usize::from(constant);
        let columns = Double::new(gram.columns as f64);
        let entry = |r: usize, q: usize| match (r < ones, q < ones) {
            (true, true) => columns,
            (true, false) => gram.sum(rows[q - ones]),
            (false, true) => gram.sum(rows[r - ones]),
            (false, false) => gram.product(rows[r - ones], rows[q - ones]),
        };
        let full = cholesky(ones + rows.len(), entry);
        let mut L = full.view((ones, ones), (rows.len(), rows.len())).into_owned();
        for (mut row, place) in L.row_iter_mut().zip(&rows) {
            let unit = Double::new(1.0 / scale[place % c]).shifted(gram.exponents()[place % c]).hi;
            row *= unit;
        }
        Factor { L, i, m, l }
    }

    /// Rows of L that hold the inputs of these lags.
    pub fn inputs(&self, lags: std::ops::Range<usize>) -> Vec<usize> {
        let place = |lag: usize| if lag >= self.i { lag - self.i } else { lag + self.i };
        lags.flat_map(|lag| (0..self.m).map(move |c| place(lag) * self.m + c)).collect()
    }

    /// Rows of L that hold the outputs of these lags.
    pub fn outputs(&self, lags: std::ops::Range<usize>) -> Vec<usize> {
        lags.flat_map(|lag| (0..self.l).map(move |c| 2 * self.i * self.m + lag * self.l + c)).collect()
    }

    /// Rank of the 2im input rows.
    ///
    /// Errors: [`Error::NotExciting`] when they are not independent.
    pub fn expect_exciting(&self) -> Result<(), Error> {
        let needed = 2 * self.i * self.m;
        let inputs = self.L.view((0, 0), (needed, needed)).into_owned();
        // A well-conditioned triangle has full rank; only others are worth a pivoted QR.
        let inverse = inputs.solve_lower_triangular(&Mat::identity(needed, needed));
        if inverse.is_some_and(|inverse| inverse.norm() * inputs.norm() < 1e-2 / INPUT_RANK) {
            return Ok(());
        }
        let rank = rank(&inputs, INPUT_RANK);
        if rank < needed { Err(Error::NotExciting { rank, needed, block_rows: self.i }) } else { Ok(()) }
    }
}

/// An input direction that is weaker than this, relative to the strongest, is rounding: 600 rows times the unit roundoff, with
/// a margin of ten.
const INPUT_RANK: f64 = 1e-12;

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::correlation::{Channels, Record};
    use crate::excitation::white_gaussian;
    use crate::triangle::{CHUNK_ROWS, Triangle};

    impl Factor {
        /// Shapes: U s x m, Y s x l.
        pub(crate) fn new(U: &Mat, Y: &Mat, i: usize, constant: bool) -> Factor {
            let mut record = Record::new(U.ncols() + Y.ncols(), i);
            record.absorb(&Channels::of_columns(U).beside(Channels::of_columns(Y)), 1).expect("finite samples");
            let gram = record.finish();
            let gram = if constant { gram } else { gram.about(&vec![0.0; gram.channels()]) };
            Factor::of_gram(&gram, U.ncols(), &vec![1.0; gram.channels()], constant)
        }

        /// The same by Householder's reflections on H itself, which squares nothing: the independent check.
        pub(crate) fn dense(U: &Mat, Y: &Mat, i: usize, constant: bool) -> Factor {
            let (s, m, l) = (U.nrows(), U.ncols(), Y.ncols());
            let j = s - 2 * i + 1;
            let rows: Vec<(&[f64], usize)> = hankel_rows(U, i..2 * i)
                .chain(hankel_rows(U, 0..i))
                .chain(hankel_rows(Y, 0..i))
                .chain(hankel_rows(Y, i..2 * i))
                .collect();
            let ones = usize::from(constant);
            let mut triangle = Triangle::new(ones + rows.len());
            for first in (0..j).step_by(CHUNK_ROWS) {
                let width = CHUNK_ROWS.min(j - first);
                let mut chunk = Mat::from_element(width, ones + rows.len(), 1.0);
                for (column, (channel, lag)) in rows.iter().enumerate() {
                    let stretch = &channel[first + lag..first + lag + width];
                    chunk.column_mut(ones + column).copy_from_slice(stretch);
                }
                triangle.absorb(&mut chunk);
            }
            let L = triangle.R.view((ones, ones), (rows.len(), rows.len())).transpose();
            Factor { L, i, m, l }
        }
    }

    fn hankel_rows(data: &Mat, lags: std::ops::Range<usize>) -> impl Iterator<Item = (&[f64], usize)> {
        let s = data.nrows();
        let channels = data.as_slice();
        lags.flat_map(move |lag| (0..data.ncols()).map(move |c| (&channels[c * s..(c + 1) * s], lag)))
    }

    /// Two inputs, three outputs, without any law between them: what is checked here needs none.
    pub(crate) fn noise(s: usize) -> (Mat, Mat) {
        let of = |channels: usize, seed: u64| {
            Mat::from_column_slice(s, channels, &white_gaussian(s * channels, 1.0, 9.0, seed))
        };
        (of(2, 1), of(3, 2))
    }

    /// Block rows `lags` of (8), formed as the paper prints them.
    pub(crate) fn hankel(data: &Mat, lags: std::ops::Range<usize>, j: usize) -> Mat {
        let channels = data.ncols();
        let first = lags.start;
        Mat::from_fn(lags.len() * channels, j, |r, k| data[(first + r / channels + k, r % channels)])
    }

    pub(crate) fn stacked(parts: &[Mat]) -> Mat {
        let rows: Vec<_> = parts.iter().flat_map(|p| p.row_iter().map(|r| r.into_owned())).collect();
        Mat::from_rows(&rows)
    }

    /// L L' = H H' with H formed in full, and the rows are where `inputs` and `outputs` say.
    #[test]
    fn gram_matrix_is_that_of_the_printed_hankel_matrices() {
        let (s, i) = (700, 4);
        let (U, Y) = noise(s);
        let j = s - 2 * i + 1;
        let factor = Factor::new(&U, &Y, i, false);
        let rows = [factor.inputs(0..2 * i), factor.outputs(0..2 * i)].concat();
        let L = factor.L.select_rows(&rows);
        let H = stacked(&[hankel(&U, 0..2 * i, j), hankel(&Y, 0..2 * i, j)]);
        let gram = &H * H.transpose();
        assert!((&L * L.transpose() - &gram).norm() < 1e-13 * gram.norm());
    }

    /// With the row of ones, every Hankel row is as good as without its mean.
    #[test]
    fn a_row_of_ones_removes_the_mean_of_every_hankel_row() {
        let (s, i) = (500, 3);
        let (U, Y) = noise(s);
        let (U, Y) = (U.add_scalar(5.0), Y.add_scalar(-700.0));
        let j = s - 2 * i + 1;
        let factor = Factor::new(&U, &Y, i, true);
        let rows = [factor.inputs(0..2 * i), factor.outputs(0..2 * i)].concat();
        let L = factor.L.select_rows(&rows);
        let mut H = stacked(&[hankel(&U, 0..2 * i, j), hankel(&Y, 0..2 * i, j)]);
        H.row_iter_mut().for_each(|mut row| row.add_scalar_mut(-row.mean()));
        let gram = &H * H.transpose();
        assert!((&L * L.transpose() - &gram).norm() < 1e-11 * gram.norm());
    }

    #[test]
    fn inputs_that_repeat_each_other_are_not_exciting() {
        let (mut U, Y) = noise(400);
        let twin = U.column(0).into_owned();
        U.set_column(1, &twin);
        let refused = Factor::new(&U, &Y, 4, false).expect_exciting();
        assert_eq!(refused, Err(Error::NotExciting { rank: 8, needed: 16, block_rows: 4 }));
    }

    /// Rows of L of the two ways agree to the rounding of a QR, a row of ones or not.
    #[test]
    fn factor_is_that_of_a_dense_qr() {
        let (U, Y) = noise(3000);
        let Y = Mat::from_fn(3000, 3, |k, c| Y[(k, c)] * 1e3f64.powi(c as i32) + 40.0 * c as f64);
        for constant in [false, true] {
            let (found, wanted) = (Factor::new(&U, &Y, 5, constant), Factor::dense(&U, &Y, 5, constant));
            for k in 0..found.L.ncols() {
                let sign = wanted.L[(k, k)].signum();
                for r in k..found.L.nrows() {
                    let error = (found.L[(r, k)] - sign * wanted.L[(r, k)]).abs() / wanted.L.row(r).norm();
                    assert!(error < 1e-13, "({r},{k}), row of ones {constant}: {error:e}");
                }
            }
        }
    }
}
