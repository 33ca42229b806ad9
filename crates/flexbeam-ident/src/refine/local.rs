//! Local coordinates of all models of one order and structure: the directions in which the input-output behaviour changes.
//!
//! Enters: a model in block form. Leaves: an orthonormal basis of directions, and what they do to the predictor.
//! Deliberately absent: any canonical form, which would be ill-conditioned somewhere.

use flexbeam_lti::{Mat, Vector};

use super::sensitivity::Predictor;

/// A direction of the orbit below this part of the longest is none.
const ORBIT_RANK: f64 = 1e-12;

/// x(k+1) = A x + B u + K e, y = C x + D u + e, from x(0).
#[derive(Clone)]
pub(crate) struct Point {
    pub A: Mat,
    pub B: Mat,
    pub C: Mat,
    pub D: Mat,
    /// n x l; None where only the simulated output counts.
    pub K: Option<Mat>,
    pub initial_state: Vector,
}

/// What is known of the model and stays as it is.
#[derive(Clone, Copy)]
pub(crate) struct Structure {
    /// A = diag(A1, A2), A1 of so many rows, upper triangular with a diagonal of ones.
    pub integrators: usize,
    /// D = 0.
    pub no_feedthrough: bool,
    /// The last input is one at every sample and reaches the outputs alone: its column of D is an offset of each.
    pub offset: bool,
}

/// Directions of [A B K; C D 0], a column each, row-major entries; and the initial state's beside them.
pub(crate) struct Basis {
    directions: Mat,
}

impl Point {
    fn sizes(&self) -> (usize, usize, usize) {
        (self.A.nrows(), self.B.ncols(), self.C.nrows())
    }

    /// Rows and columns of [A B K; C D 0].
    fn shape(&self) -> (usize, usize) {
        let (n, m, l) = self.sizes();
        (n + l, n + m + self.K.as_ref().map_or(0, |_| l))
    }

    /// The model as a filter of u, or of [u; y] where it has a gain.
    pub fn predictor(&self) -> Predictor {
        let Point { A, B, C, D, K, initial_state } = self.clone();
        let (n, m, l) = self.sizes();
        match K {
            None => Predictor { A, B, C, D, initial_state },
            Some(K) => {
                let mut inputs = Mat::zeros(n, m + l);
                inputs.columns_mut(0, m).copy_from(&(B - &K * &D));
                inputs.columns_mut(m, l).copy_from(&K);
                let D = D.resize_horizontally(m + l, 0.0);
                Predictor { A: A - K * &C, B: inputs, C, D, initial_state }
            }
        }
    }

    /// Orthonormal directions that leave the structure alone and stand at right angles to all changes of basis.
    ///
    /// Source: McKelvey, Helmersson and Ribarits 2004 (data-driven local coordinates). Differs: the changes of basis are those
    /// that keep A block diagonal.
    pub fn basis(&self, structure: Structure) -> Basis {
        let free = self.free_entries(structure);
        let orbit = self.orbit(structure, &free);
        let changes = orbit.ncols();
        let whole = orbit.resize_horizontally(free.len().max(changes), 0.0);
        let qr = whole.col_piv_qr();
        let R = qr.r();
        let floor = ORBIT_RANK * R.get((0, 0)).map_or(0.0, |r| r.abs());
        let rank = (0..changes.min(R.nrows())).take_while(|&k| R[(k, k)].abs() > floor).count();
        let Q = qr.q();
        let (rows, columns) = self.shape();
        let mut directions = Mat::zeros(rows * columns, free.len() - rank);
        for (k, &entry) in free.iter().enumerate() {
            directions.row_mut(entry).copy_from(&Q.row(k).columns(rank, free.len() - rank));
        }
        Basis { directions }
    }

    /// Row-major places of the entries that may change.
    fn free_entries(&self, structure: Structure) -> Vec<usize> {
        let (n, m, _) = self.sizes();
        let (rows, columns) = self.shape();
        let q = structure.integrators;
        let constant = |c: usize| structure.offset && c == n + m - 1;
        let free = |r: usize, c: usize| match (r < n, c < n) {
            (true, true) => (r < q && c < q && r < c) || (r >= q && c >= q),
            (true, false) => !constant(c),
            (false, true) => true,
            (false, false) => c < n + m && (constant(c) || !structure.no_feedthrough),
        };
        (0..rows * columns).filter(|entry| free(entry / columns, entry % columns)).collect()
    }

    /// Tangents of the changes of basis: T A - A T, T B, T K, -C T, a column for each entry of T.
    fn orbit(&self, structure: Structure, free: &[usize]) -> Mat {
        let (n, m, l) = self.sizes();
        let (rows, columns) = self.shape();
        let q = structure.integrators;
        let of_basis =
            (0..n * n).map(|k| (k / n, k % n)).filter(|&(r, c)| (r < q && c < q && r <= c) || (r >= q && c >= q));
        let tangents = of_basis.map(|(r, c)| {
            // T = e_r e_c'.
            let mut tangent = Mat::zeros(rows, columns);
            for k in 0..n {
                tangent[(r, k)] += self.A[(c, k)];
                tangent[(k, c)] -= self.A[(k, r)];
            }
            tangent.view_mut((r, n), (1, m)).copy_from(&self.B.row(c));
            if let Some(K) = &self.K {
                tangent.view_mut((r, n + m), (1, l)).copy_from(&K.row(c));
            }
            (0..l).for_each(|p| tangent[(n + p, c)] = -self.C[(p, r)]);
            Vector::from_iterator(free.len(), free.iter().map(|e| tangent[(e / columns, e % columns)]))
        });
        Mat::from_columns(&tangents.collect::<Vec<_>>())
    }

    /// The point after a step along the basis and in the initial state.
    pub fn moved(&self, basis: &Basis, step: &Vector) -> Point {
        let mut moved = self.clone();
        let change = &basis.directions * step.rows(0, basis.directions.ncols());
        let (n, m, l) = self.sizes();
        let (_, columns) = self.shape();
        let change = Mat::from_row_slice(n + l, columns, change.as_slice());
        moved.A += change.view((0, 0), (n, n));
        moved.B += change.view((0, n), (n, m));
        moved.C += change.view((n, 0), (l, n));
        moved.D += change.view((n, n), (l, m));
        if let Some(K) = &mut moved.K {
            *K += change.view((0, n + m), (n, l));
        }
        moved.initial_state += step.rows(basis.directions.ncols(), n);
        moved
    }

    /// The basis and the initial state as directions of the predictor's entries, a row each.
    pub fn predictor_directions(&self, basis: &Basis, predictor: &Predictor) -> Mat {
        let (n, m, l) = self.sizes();
        let (_, columns) = self.shape();
        let d = basis.directions.ncols();
        let mut rows = Mat::zeros(d + n, predictor.entries());
        for k in 0..d {
            let change = Mat::from_row_slice(n + l, columns, basis.directions.column(k).as_slice());
            let (mut state, output) = (change.rows(0, n).into_owned(), change.rows(n, l).into_owned());
            if let Some(K) = &self.K {
                // A - K C and B - K D.
                let dK = state.columns(n + m, l).into_owned();
                let through = &dK * stacked_beside(&self.C, &self.D) + K * output.columns(0, n + m);
                let mut left = state.columns_mut(0, n + m);
                left -= through;
            }
            for r in 0..n {
                (0..columns).for_each(|c| rows[(k, predictor.state_entry(r, c))] = state[(r, c)]);
            }
            for p in 0..l {
                (0..columns).for_each(|c| rows[(k, predictor.output_entry(p, c))] = output[(p, c)]);
            }
        }
        (0..n).for_each(|r| rows[(d + r, predictor.state_entry(r, columns))] = 1.0);
        rows
    }
}

#[cfg(test)]
impl Basis {
    pub fn is_orthonormal(&self, tolerance: f64) -> bool {
        let d = self.directions.ncols();
        (self.directions.transpose() * &self.directions - Mat::identity(d, d)).amax() < tolerance
    }
}

fn stacked_beside(left: &Mat, right: &Mat) -> Mat {
    let mut both = left.clone().resize_horizontally(left.ncols() + right.ncols(), 0.0);
    both.columns_mut(left.ncols(), right.ncols()).copy_from(right);
    both
}
