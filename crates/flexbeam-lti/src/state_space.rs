use crate::schur::spectrum;
use crate::{C64, CMat, Error, Mat, Time};

/// x' = A x + B u, y = C x + D u; or x(k+1) = A x(k) + B u(k).
///
/// Shapes: A n x n, B n x m, C l x n, D l x m, checked by [`StateSpace::new`]; n may be 0.
#[derive(Clone, Debug, PartialEq)]
pub struct StateSpace {
    /// State matrix, n x n.
    pub A: Mat,
    /// Input matrix, n x m.
    pub B: Mat,
    /// Output matrix, l x n.
    pub C: Mat,
    /// Feedthrough, l x m.
    pub D: Mat,
    /// Time axis.
    pub time: Time,
}

impl StateSpace {
    /// Checks shapes and entries.
    ///
    /// Errors: [`Error::Shape`], [`Error::NotFinite`], [`Error::Period`].
    pub fn new(A: Mat, B: Mat, C: Mat, D: Mat, time: Time) -> Result<StateSpace, Error> {
        let n = A.nrows();
        expect_shape("A", &A, n, n)?;
        expect_shape("B", &B, n, D.ncols())?;
        expect_shape("C", &C, D.nrows(), n)?;
        for (what, M) in [("A", &A), ("B", &B), ("C", &C), ("D", &D)] {
            expect_finite(what, M)?;
        }
        match time {
            Time::Sampled { period_s } if !(period_s > 0.0 && period_s.is_finite()) => Err(Error::Period { period_s }),
            _ => Ok(StateSpace { A, B, C, D, time }),
        }
    }

    /// y = D u, no state.
    pub fn static_gain(D: Mat, time: Time) -> Result<StateSpace, Error> {
        StateSpace::new(Mat::zeros(0, 0), Mat::zeros(0, D.ncols()), Mat::zeros(D.nrows(), 0), D, time)
    }

    /// Number of states n.
    pub fn order(&self) -> usize {
        self.A.nrows()
    }

    /// Number of inputs m.
    pub fn inputs(&self) -> usize {
        self.D.ncols()
    }

    /// Number of outputs l.
    pub fn outputs(&self) -> usize {
        self.D.nrows()
    }

    /// Eigenvalues of A.
    pub fn poles(&self) -> Vec<C64> {
        spectrum(&self.A).expect("QR iteration converges on the finite square matrix that `new` has checked")
    }

    /// G(s) = C (s I - A)^-1 B + D at one point of the s- or z-plane.
    ///
    /// Returns infinite entries when `s` is a pole to working precision. O(n^3); for many points use
    /// `frequency_response`.
    pub fn at(&self, s: C64) -> CMat {
        if self.order() == 0 {
            return self.D.map(C64::from);
        }
        let pencil = CMat::from_diagonal_element(self.order(), self.order(), s) - self.A.map(C64::from);
        let D = self.D.map(C64::from);
        match pencil.lu().solve(&self.B.map(C64::from)) {
            Some(X) => self.C.map(C64::from) * X + D,
            None => CMat::from_element(self.outputs(), self.inputs(), C64::new(f64::INFINITY, 0.0)),
        }
    }

    /// G(s - beta), or G(e^(-beta Ts) z): the poles move by +beta.
    ///
    /// Source: DESIGN section 6 (the bar).
    pub fn shifted(&self, beta: f64) -> StateSpace {
        let mut shifted = self.clone();
        match self.time {
            Time::Continuous => {
                for k in 0..self.order() {
                    shifted.A[(k, k)] += beta;
                }
            }
            Time::Sampled { period_s } => {
                let growth = (beta * period_s).exp();
                shifted.A *= growth;
                shifted.B *= growth;
            }
        }
        shifted
    }
}

pub(crate) fn expect_shape(what: &'static str, M: &Mat, rows: usize, columns: usize) -> Result<(), Error> {
    if M.shape() == (rows, columns) {
        return Ok(());
    }
    Err(Error::Shape {
        what,
        found_rows: M.nrows(),
        found_columns: M.ncols(),
        needed_rows: rows,
        needed_columns: columns,
    })
}

pub(crate) fn expect_finite(what: &'static str, M: &Mat) -> Result<(), Error> {
    match M.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(k) => Err(Error::NotFinite { what, row: k % M.nrows() + 1, column: k / M.nrows() + 1, value: M[k] }),
    }
}
