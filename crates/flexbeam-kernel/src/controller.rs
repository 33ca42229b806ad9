//! The linear controller. Enters: its coefficients, the state, the inputs (v, y, u_applied). Leaves: u, y_model and the
//! next state. Deliberately absent: where the coefficients come from, and the memory: the caller lends it.

use core::fmt;

/// Why a controller or its state cannot be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Error {
    /// The slice of coefficients does not have the length that the order asks for.
    Coefficients {
        /// Order of the controller.
        order: usize,
        /// Length that this order needs.
        needed: usize,
        /// Length that was given.
        found: usize,
    },
    /// A coefficient is infinite or not a number.
    NotFinite {
        /// Where it stands in the slice.
        index: usize,
    },
    /// The memory lent to a state does not have the length that [`Controller::state_len`] asks for.
    Memory {
        /// Length that the controller needs.
        needed: usize,
        /// Length that was given.
        found: usize,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Coefficients { order, needed, found } => {
                write!(f, "a controller of order {order} needs {needed} coefficients (A, B, C, D), found {found}")
            }
            Self::NotFinite { index } => write!(f, "controller coefficient {index} is not a finite number"),
            Self::Memory { needed, found } => write!(f, "the controller's state needs {needed} numbers, found {found}"),
        }
    }
}

impl core::error::Error for Error {}

/// x+ = A x + B (v, y, u_applied),  (u, y_model) = C x + D (v, y).
///
/// v is the smoothed reference, y = psi the filtered tip angle, u_applied the voltage that the plant effectively got
/// (anti-windup comes with it), u the voltage asked for and y_model = M r what the reference model does. Order is a
/// run-time number and may be zero.
///
/// Shapes: A n*n, B n*3, C 2*n, D 2*2, each column-major, one after the other in one slice.
/// Numerics: one accumulation per row over the columns of [A B] or [C D] in ascending order, beginning with the first
/// product (not with zero).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Controller<'a> {
    order: usize,
    coefficients: &'a [f64],
    /// [A B], n rows.
    AB: &'a [f64],
    /// [C D], two rows.
    CD: &'a [f64],
}

impl<'a> Controller<'a> {
    /// Number of inputs of the state equation: v, y, u_applied.
    pub const INPUTS: usize = 3;

    /// Number of coefficients of a controller of this order: n n + 3 n + 2 n + 4.
    ///
    /// Returns: `None` when it does not fit a `usize`.
    pub fn coefficients_len(order: usize) -> Option<usize> {
        order.checked_mul(order)?.checked_add(order.checked_mul(5)?)?.checked_add(4)
    }

    /// Real-time: no. A controller over coefficients that the caller keeps.
    ///
    /// Errors: [`Error::Coefficients`] when the length is not that of the order, [`Error::NotFinite`] at the first
    /// coefficient that is no number.
    pub fn new(order: usize, coefficients: &'a [f64]) -> Result<Self, Error> {
        let found = coefficients.len();
        let needed = Self::coefficients_len(order).unwrap_or(usize::MAX);
        if found != needed {
            return Err(Error::Coefficients { order, needed, found });
        }
        if let Some(index) = coefficients.iter().position(|c| !c.is_finite()) {
            return Err(Error::NotFinite { index });
        }
        let (AB, CD) = coefficients.split_at_checked(order * (order + Self::INPUTS)).unwrap_or_default();
        Ok(Self { order, coefficients, AB, CD })
    }

    /// Number of states n.
    pub fn order(&self) -> usize {
        self.order
    }

    /// A, B, C, D as they were given.
    pub fn coefficients(&self) -> &'a [f64] {
        self.coefficients
    }

    /// Length of the memory that [`crate::State::new`] borrows: x, the three inputs, and the next x.
    pub fn state_len(&self) -> usize {
        2 * self.order + Self::INPUTS
    }

    /// Real-time: yes. (u, y_model) = [C D] z, with z = (x, v, y, ..).
    pub(crate) fn outputs(&self, z: &[f64]) -> (f64, f64) {
        let mut products = self.CD.as_chunks::<2>().0.iter().zip(z).map(|(&[c_u, c_y], &z)| (c_u * z, c_y * z));
        let first = products.next().unwrap_or((0.0, 0.0));
        products.fold(first, |(u, y_model), (p_u, p_y)| (u + p_u, y_model + p_y))
    }

    /// Real-time: yes. next = [A B] z, with z = (x, v, y, u_applied).
    pub(crate) fn advance(&self, z: &[f64], next: &mut [f64]) {
        // chunks_exact refuses a length of zero; with order 0 there is nothing to chunk.
        let mut columns = self.AB.chunks_exact(self.order.max(1)).zip(z);
        if let Some((column, &z)) = columns.next() {
            next.iter_mut().zip(column).for_each(|(next, a)| *next = a * z);
        }
        for (column, &z) in columns {
            next.iter_mut().zip(column).for_each(|(next, a)| *next += a * z);
        }
    }
}
