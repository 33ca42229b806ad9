//! Equations of motion of the hub and a finite number of link coordinates, and their state space.

use crate::error::not_negative;
use crate::roots::clamped_free_root;
use crate::{Beam, Error, Output, Physical};
use flexbeam_lti::{Mat, StateSpace, Time, Vector};

/// J theta'' + h'eta'' + c0 theta' = g V - friction,   h theta'' + M eta'' + D eta' + K eta = 0.
///
/// Shapes: N link coordinates eta; h, tip, gauge have N entries, M, D, K are N x N. The lumped link is N = 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Torque per volt g [N m/V].
    pub g: f64,
    /// Hub damping c0 [N m s/rad].
    pub c0: f64,
    /// Inertia J of hub and rigid link [kg m^2].
    pub J: f64,
    /// Coupling h [kg m^2].
    pub h: Vector,
    /// Mass matrix M of the link [kg m^2].
    pub M: Mat,
    /// Damping matrix D of the link [N m s/rad].
    pub D: Mat,
    /// Stiffness matrix K of the link [N m/rad].
    pub K: Mat,
    /// alpha = tip' eta.
    pub tip: Vector,
    /// What a strain gauge at the root reports for alpha: gauge' eta.
    pub gauge: Vector,
}

impl Motion {
    /// The lumped link: eta = alpha, no damping.
    ///
    /// Source: DESIGN section 2.
    pub fn lumped(physical: &Physical) -> Motion {
        Motion {
            g: physical.torque_per_volt(),
            c0: physical.hub_damping(),
            J: physical.J_base + physical.J_link,
            h: Vector::from_element(1, physical.J_link),
            M: Mat::from_element(1, 1, physical.J_link),
            D: Mat::zeros(1, 1),
            K: Mat::from_element(1, 1, physical.K_stiff),
            tip: Vector::from_element(1, 1.0),
            gauge: Vector::from_element(1, 1.0),
        }
    }

    /// Assumed modes: w = L sum phi_k(x) eta_k with the first `modes` clamped-free shapes, a point mass at the tip.
    ///
    /// With integral(phi_k^2) = L: h_k = 2 m L^2/mu_k^2, phi_k(L) = 2 (-1)^(k-1), L phi_k''(0) = 2 mu_k^2/L.
    /// The tip mass adds (mass) L^2 (theta' + sum phi_k(L) eta_k')^2/2 to the kinetic energy.
    ///
    /// Errors: [`Error::Parameter`] for a tip mass that is negative or not finite.
    /// Numerics: frequencies converge as N^-3 without a tip mass.
    /// Source: DESIGN section 3 (c).
    pub fn assumed_modes(beam: &Beam, modes: usize, tip_mass_kg: f64) -> Result<Motion, Error> {
        not_negative("tip mass", "kg", tip_mass_kg)?;
        let p = &beam.physical;
        let mL2 = 3.0 * p.J_link;
        let tip_J = tip_mass_kg * p.length_m * p.length_m;
        let mu = Vector::from_fn(modes, |k, _| clamped_free_root(k + 1));
        let omega = Vector::from_fn(modes, |k, _| beam.clamped_frequency_rad_s(k + 1));
        let tip = Vector::from_fn(modes, |k, _| if k % 2 == 0 { 2.0 } else { -2.0 });
        Ok(Motion {
            g: p.torque_per_volt(),
            c0: p.hub_damping(),
            J: p.J_base + p.J_link + tip_J,
            h: mu.map(|mu| 2.0 * mL2 / (mu * mu)) + &tip * tip_J,
            M: Mat::from_diagonal_element(modes, modes, mL2) + &tip * tip.transpose() * tip_J,
            D: Mat::from_diagonal(&omega.map(|omega| mL2 * beam.damping.rate(omega))),
            K: Mat::from_diagonal(&omega.map(|omega| mL2 * omega * omega)),
            gauge: mu.map(|mu_k| 2.0 * (mu_k / mu[0]).powi(2)),
            tip,
        })
    }

    /// Number of link coordinates N.
    pub fn link_coordinates(&self) -> usize {
        self.h.len()
    }

    /// x = [theta eta theta' eta'], inputs motor voltage [V] and friction torque at the hub [N m].
    ///
    /// Returns one row of C for each output, D = 0.
    /// Errors: [`Error::Lti`] when an entry is not finite.
    pub fn state_space_with_friction(&self, outputs: &[Output]) -> Result<StateSpace, Error> {
        let n = 1 + self.link_coordinates();
        let mut A = Mat::zeros(2 * n, 2 * n);
        A.view_mut((0, n), (n, n)).fill_with_identity();
        A.view_mut((n, 0), (n, 2 * n)).copy_from(&self.accelerations(&self.restoring()));
        let mut B = Mat::zeros(2 * n, 2);
        let mut torques = Mat::zeros(n, 2);
        torques[(0, 0)] = self.g;
        torques[(0, 1)] = -1.0;
        B.view_mut((n, 0), (n, 2)).copy_from(&self.accelerations(&torques));
        let C = self.output_rows(outputs);
        Ok(StateSpace::new(A, B, C, Mat::zeros(outputs.len(), 2), Time::Continuous)?)
    }

    /// x = [theta eta theta' eta'], input the motor voltage, no friction but the viscous one.
    ///
    /// Errors: [`Error::Lti`] when an entry is not finite.
    pub fn state_space(&self, outputs: &[Output]) -> Result<StateSpace, Error> {
        let both = self.state_space_with_friction(outputs)?;
        let B = both.B.columns(0, 1).into_owned();
        Ok(StateSpace::new(both.A, B, both.C, Mat::zeros(outputs.len(), 1), Time::Continuous)?)
    }

    /// [eta eta'] with the hub held, and the weights that give the torque which the hub then feels, -h'eta''.
    ///
    /// Shapes: 2N x 2N and 2N.
    pub fn clamped(&self) -> (Mat, Vector) {
        let N = self.link_coordinates();
        let mut restoring = Mat::zeros(N, 2 * N);
        restoring.view_mut((0, 0), (N, N)).copy_from(&-&self.K);
        restoring.view_mut((0, N), (N, N)).copy_from(&-&self.D);
        let eta_acceleration = positive_definite(self.M.clone()).solve(&restoring);
        let mut A = Mat::zeros(2 * N, 2 * N);
        A.view_mut((0, N), (N, N)).fill_with_identity();
        A.view_mut((N, 0), (N, 2 * N)).copy_from(&eta_acceleration);
        (A, -eta_acceleration.tr_mul(&self.h))
    }

    /// [0 -K .. | -c0 -D] acting on [theta eta theta' eta'].
    fn restoring(&self) -> Mat {
        let (N, n) = (self.link_coordinates(), 1 + self.link_coordinates());
        let mut restoring = Mat::zeros(n, 2 * n);
        restoring.view_mut((1, 1), (N, N)).copy_from(&-&self.K);
        restoring[(0, n)] = -self.c0;
        restoring.view_mut((1, n + 1), (N, N)).copy_from(&-&self.D);
        restoring
    }

    /// [theta'' eta''] for the columns of generalised torques.
    fn accelerations(&self, torques: &Mat) -> Mat {
        let (N, n) = (self.link_coordinates(), 1 + self.link_coordinates());
        let mut inertia = Mat::zeros(n, n);
        inertia[(0, 0)] = self.J;
        inertia.view_mut((1, 0), (N, 1)).copy_from(&self.h);
        inertia.view_mut((0, 1), (1, N)).copy_from(&self.h.transpose());
        inertia.view_mut((1, 1), (N, N)).copy_from(&self.M);
        positive_definite(inertia).solve(torques)
    }

    fn output_rows(&self, outputs: &[Output]) -> Mat {
        let n = 1 + self.link_coordinates();
        let mut C = Mat::zeros(outputs.len(), 2 * n);
        for (row, output) in outputs.iter().enumerate() {
            let weight = output.weights();
            C[(row, 0)] = weight.theta;
            for k in 1..n {
                C[(row, k)] = weight.alpha * self.tip[k - 1] + weight.gauge * self.gauge[k - 1];
            }
        }
        C
    }
}

fn positive_definite(inertia: Mat) -> nalgebra::Cholesky<f64, nalgebra::Dyn> {
    inertia.cholesky().expect("kinetic energy of checked parameters is positive")
}
