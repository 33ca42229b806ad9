//! The value and the slope of a scalar system at a point of its plane.
//!
//! Enters: a system with one input and one output. Leaves: G(z), G'(z). Absent: grids.

use crate::Error;
use flexbeam_lti::{C64, CMat, StateSpace};

/// A scalar system prepared for many evaluations.
#[derive(Clone, Debug)]
pub struct Response {
    A: CMat,
    B: CMat,
    C: CMat,
    D: C64,
}

impl Response {
    /// Errors: [`Error::Shape`] unless the system has one input and one output.
    pub fn new(system: &StateSpace) -> Result<Response, Error> {
        let (inputs, outputs, time) = (system.inputs(), system.outputs(), system.time);
        if (inputs, outputs) != (1, 1) {
            return Err(Error::Shape { what: "response", inputs, outputs, time, needed: "one of each" });
        }
        let complex = |M: &flexbeam_lti::Mat| M.map(C64::from);
        Ok(Response { A: complex(&system.A), B: complex(&system.B), C: complex(&system.C), D: system.D[(0, 0)].into() })
    }

    /// G(z) = C (z I - A)^-1 B + D and G'(z) = -C (z I - A)^-2 B; infinite at a pole.
    ///
    /// Numerics: one LU, two solves.
    pub fn at(&self, z: C64) -> (C64, C64) {
        if self.A.is_empty() {
            return (self.D, C64::ZERO);
        }
        let infinite = C64::new(f64::INFINITY, 0.0);
        let n = self.A.nrows();
        let pencil = (CMat::from_diagonal_element(n, n, z) - &self.A).lu();
        let Some(X) = pencil.solve(&self.B) else { return (infinite, infinite) };
        let Some(XX) = pencil.solve(&X) else { return (infinite, infinite) };
        ((&self.C * X)[(0, 0)] + self.D, -(&self.C * XX)[(0, 0)])
    }
}
