//! The lumped model (18) as a state space.

use crate::Lumped;
use flexbeam_lti::{Error, Mat, StateSpace, Time};

/// An output of the rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Output {
    /// Hub angle theta [rad].
    Theta,
    /// Deflection angle of the tip alpha [rad].
    Alpha,
    /// Tip angle psi = theta + alpha [rad].
    Psi,
    /// What a strain gauge at the root reports for alpha, calibrated on the first mode [rad]; alpha itself when the
    /// link is lumped.
    Gauge,
    /// Tip deflection d = L alpha [m].
    Deflection {
        /// L [m].
        length_m: f64,
    },
}

/// How an output is made of hub angle, deflection angle and gauge reading.
pub(crate) struct Weights {
    pub theta: f64,
    pub alpha: f64,
    pub gauge: f64,
}

impl Output {
    pub(crate) fn weights(self) -> Weights {
        let (theta, alpha, gauge) = match self {
            Output::Theta => (1.0, 0.0, 0.0),
            Output::Alpha => (0.0, 1.0, 0.0),
            Output::Psi => (1.0, 1.0, 0.0),
            Output::Gauge => (0.0, 0.0, 1.0),
            Output::Deflection { length_m } => (0.0, length_m, 0.0),
        };
        Weights { theta, alpha, gauge }
    }
}

impl Lumped {
    /// (18) with our signs: x = [theta alpha theta' alpha'], input the motor voltage.
    ///
    /// Returns one row of C for each output, D = 0.
    /// Errors: [`Error::NotFinite`] when a parameter is not a finite number.
    /// Source: paper (18), DESIGN section 2 (the printed (3)-(6) count alpha the other way).
    ///
    /// ```
    /// use flexbeam_rig::{Lumped, Output};
    /// let G0 = Lumped::PAPER.state_space(&[Output::Psi]).unwrap();
    /// let s = nalgebra::Complex::new(-1.5, 7.0);
    /// let printed = 43428.5 / (s * (s + 34.872) * (s * s + s * 22.828 + 669.14));
    /// assert!((G0.at(s)[(0, 0)] - printed).norm() < 2e-5 * printed.norm());
    /// ```
    pub fn state_space(&self, outputs: &[Output]) -> Result<StateSpace, Error> {
        let (A, B) = self.matrices();
        StateSpace::new(A, B, output_rows(outputs), Mat::zeros(outputs.len(), 1), Time::Continuous)
    }

    /// A and B of (18), whatever the numbers are.
    pub fn matrices(&self) -> (Mat, Mat) {
        let Lumped { k1, k2, c, b } = *self;
        #[rustfmt::skip]
        let A = Mat::from_row_slice(4, 4, &[
            0.0, 0.0, 1.0, 0.0,
            0.0, 0.0, 0.0, 1.0,
            0.0,  k1,  -c, 0.0,
            0.0, -k2,   c, 0.0,
        ]);
        (A, Mat::from_column_slice(4, 1, &[0.0, 0.0, b, -b]))
    }

    /// k1, k2, c, b.
    pub fn to_array(self) -> [f64; 4] {
        [self.k1, self.k2, self.c, self.b]
    }

    /// From k1, k2, c, b.
    pub fn from_array([k1, k2, c, b]: [f64; 4]) -> Lumped {
        Lumped { k1, k2, c, b }
    }
}

fn output_rows(outputs: &[Output]) -> Mat {
    Mat::from_fn(outputs.len(), 4, |row, column| {
        let weight = outputs[row].weights();
        [weight.theta, weight.alpha + weight.gauge, 0.0, 0.0][column]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Drive, Physical};
    use flexbeam_lti::C64;

    /// The paper's (3) with the motor, in the paper's own sign of alpha, as it should read (DESIGN, misprints of (5)).
    fn paper_5(p: &Physical, length_m: f64) -> (Mat, Mat) {
        let (k1, k2) = (p.K_stiff / p.J_base, p.K_stiff * (1.0 / p.J_link + 1.0 / p.J_base));
        let c = p.K_b * p.K_b * p.K_g * p.K_g / (p.J_base * p.R_ohm);
        let b = p.K_b * p.K_g / (p.J_base * p.R_ohm);
        let L = length_m;
        #[rustfmt::skip]
        let A = Mat::from_row_slice(4, 4, &[
            0.0,     0.0,    1.0, 0.0,
            0.0,     0.0,    0.0, 1.0,
            0.0, -k1 / L,     -c, 0.0,
            0.0,     -k2, -c * L, 0.0,
        ]);
        (A, Mat::from_column_slice(4, 1, &[0.0, 0.0, b, b * L]))
    }

    #[test]
    fn the_papers_equation_3_is_our_image_under_minus_alpha() {
        let ours = Lumped::PAPER.state_space(&[Output::Theta]).unwrap();
        let T = Mat::from_diagonal(&nalgebra::dvector![1.0, -1.0, 1.0, -1.0]);
        let (A, B) = paper_5(&Physical::paper(), 1.0);
        assert!((&T * &ours.A * &T - &A).norm() < 1e-12 * A.norm());
        assert!((&T * &ours.B - &B).norm() < 1e-12 * B.norm());
    }

    #[test]
    fn the_papers_equation_6_is_our_image_in_theta_and_deflection() {
        let L = Physical::paper().length_m;
        let ours = Lumped::PAPER.state_space(&[Output::Theta]).unwrap();
        let T = Mat::from_diagonal(&nalgebra::dvector![1.0, -L, 1.0, -L]);
        let (A, B) = paper_5(&Physical::paper(), L);
        assert!((&T * &ours.A - &A * &T).norm() < 1e-12 * A.norm());
        assert!((&T * &ours.B - &B).norm() < 1e-12 * B.norm());
    }

    /// Lagrange's equations themselves, M(q) q'' from the energies T and P of DESIGN section 2, at one frequency.
    #[test]
    fn the_state_space_solves_lagranges_equations() {
        let p = Physical { B_eq: 0.004, ..Physical::paper() };
        let s = C64::new(-0.7, 21.0);
        let g = p.K_g * p.K_b / p.R_ohm;
        let dissipation = s * (g * p.K_g * p.K_b + p.B_eq);
        let inertia = nalgebra::matrix![p.J_base + p.J_link, p.J_link; p.J_link, p.J_link].map(C64::from);
        let stiffness = nalgebra::matrix![dissipation, C64::from(0.0); C64::from(0.0), C64::from(p.K_stiff)];
        let q = (inertia * (s * s) + stiffness).lu().solve(&nalgebra::vector![C64::from(g), C64::from(0.0)]).unwrap();
        let outputs = [Output::Theta, Output::Alpha, Output::Psi, Output::Deflection { length_m: 0.419 }];
        let G = p.lumped().state_space(&outputs).unwrap().at(s);
        for (found, wanted) in G.iter().zip([q[0], q[1], q[0] + q[1], q[1] * 0.419]) {
            assert!((found - wanted).norm() < 1e-13 * q.norm());
        }
    }

    #[test]
    fn printed_figures_of_the_plant() {
        let p = Physical::paper();
        let close =
            |found: f64, printed: f64, digits: f64| assert!((found - printed).abs() < digits, "{found} {printed}");
        close(p.K_b, 0.00767563, 5e-9);
        close(p.J_base, 1.924309e-3, 5e-10);
        close(p.K_stiff, 2.041307, 5e-7);
        close(p.J_link, 5.047742e-3, 5e-10);
        close(p.clamped_frequency_rad_s() / (2.0 * std::f64::consts::PI), 3.20, 5e-3);
        let psi = Lumped::PAPER.state_space(&[Output::Psi]).unwrap();
        let s = C64::from(1e-7);
        close((psi.at(s)[(0, 0)] * s).re, 1.8612, 5e-5);
    }

    #[test]
    fn lumped_and_physical_are_each_others_inverse() {
        let drives = [
            Drive::SRV02,
            Drive { B_eq: 0.004, ..Drive::SRV02 },
            Drive { K_g: 14.0, R_ohm: 5.1, B_eq: 1e-3, length_m: 0.3 },
        ];
        for drive in drives {
            let there = Physical::from_lumped(&Lumped::PAPER, &drive).unwrap();
            let back = there.lumped();
            for (found, wanted) in [back.k1, back.k2, back.c, back.b].iter().zip([1060.8, 1465.2, 57.7, 107.39]) {
                assert!((found / wanted - 1.0).abs() < 1e-14, "{found} {wanted}");
            }
            let again = Physical::from_lumped(&back, &there.drive()).unwrap();
            assert!((again.J_link / there.J_link - 1.0).abs() < 1e-13);
            assert!((again.K_b / there.K_b - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn what_no_rig_can_be_is_refused_with_numbers() {
        let soft = Lumped { k2: 1000.0, ..Lumped::PAPER };
        let refused = Physical::from_lumped(&soft, &Drive::SRV02);
        assert_eq!(refused, Err(crate::Error::NoLinkInertia { k1: 1060.8, k2: 1000.0 }));
        let rough = Drive { B_eq: 1.0, ..Drive::SRV02 };
        match Physical::from_lumped(&Lumped::PAPER, &rough) {
            Err(crate::Error::TooMuchFriction { largest, .. }) => {
                let barely = Drive { B_eq: largest * (1.0 - 1e-12), ..Drive::SRV02 };
                assert!(Physical::from_lumped(&Lumped::PAPER, &barely).is_ok());
            }
            other => panic!("{other:?}"),
        }
        let nan = Lumped { c: f64::NAN, ..Lumped::PAPER };
        assert!(matches!(Physical::from_lumped(&nan, &Drive::SRV02), Err(crate::Error::Parameter { .. })));
    }
}
