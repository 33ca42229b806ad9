//! A controller made by hand on (18): a sampled observer with state feedback, in the kernel's form.

use flexbeam_lti::{Mat, StateSpace, Time, connections, sampling};
use flexbeam_rig::{Lumped, Output};
use flexbeam_verify::Timing;

pub const TIMING: Timing = Timing { period_s: 1e-3, delay_s: 1e-3, low_pass: 0.6 };

pub fn nominal() -> StateSpace {
    Lumped::PAPER.state_space(&[Output::Psi]).unwrap()
}

/// Zero-order hold, delay and filter as one state space.
pub fn sampled_plant(timing: Timing) -> StateSpace {
    let held = sampling::zoh_with_delay(&nominal(), timing.period_s, timing.delay_s).unwrap();
    let one = |x: f64| Mat::from_element(1, 1, x);
    let (a, time) = (timing.low_pass, Time::Sampled { period_s: timing.period_s });
    let filter = StateSpace::new(one(1.0 - a), one(a), one(1.0 - a), one(a), time).unwrap();
    connections::series(&held, &filter).unwrap()
}

/// Fixed point of the Riccati difference equation: F of u = -F x for A, B with every pole inside e^(-degree Ts).
fn state_feedback(plant: &StateSpace, degree: f64, Q: &Mat, r: f64) -> Mat {
    let shifted = plant.shifted(degree);
    let (A, B) = (&shifted.A, &shifted.B);
    let mut X = Q.clone();
    let mut F = Mat::zeros(1, A.nrows());
    for _ in 0..20_000 {
        F = B.tr_mul(&X) * A / (r + (B.tr_mul(&X) * B)[(0, 0)]);
        let next = A.tr_mul(&X) * (A - B * &F) + Q;
        let settled = (&next - &X).norm() < 1e-13 * X.norm();
        X = (&next + next.transpose()) * 0.5;
        if settled {
            break;
        }
    }
    F
}

/// Inputs (v, y, u_applied), outputs (u, y_model); two more states as a prefilter.
pub fn controller(timing: Timing, degree: f64) -> StateSpace {
    let plant = sampled_plant(timing);
    let n = plant.order();
    let F = state_feedback(&plant, degree, &(plant.C.tr_mul(&plant.C) * 30.0), 1.0);
    let dual = StateSpace { A: plant.A.transpose(), B: plant.C.transpose(), C: plant.B.transpose(), ..plant.clone() };
    let H = state_feedback(&dual, degree, &(&plant.B * plant.B.transpose() * 1.0), 1e-6).transpose();
    let mut A = Mat::zeros(n + 2, n + 2);
    A.view_mut((0, 0), (n, n)).copy_from(&(&plant.A - &H * &plant.C));
    A[(n, n)] = 0.97;
    A[(n + 1, n + 1)] = 0.97;
    A[(n + 1, n)] = 0.03;
    let mut B = Mat::zeros(n + 2, 3);
    B.view_mut((0, 1), (n, 1)).copy_from(&H);
    B.view_mut((0, 2), (n, 1)).copy_from(&plant.B);
    B[(n, 0)] = 0.03;
    let mut C = Mat::zeros(2, n + 2);
    C.view_mut((0, 0), (1, n)).copy_from(&-&F);
    C[(0, n + 1)] = stiffness(&plant, &F, &H);
    C[(1, n + 1)] = 1.0;
    StateSpace::new(A, B, C, Mat::zeros(2, 3), plant.time).unwrap()
}

/// K(1) = F (I - A + H C + B F)^-1 H.
fn stiffness(plant: &StateSpace, F: &Mat, H: &Mat) -> f64 {
    let n = plant.order();
    let M = Mat::identity(n, n) - &plant.A + H * &plant.C + &plant.B * F;
    (F * M.lu().solve(H).unwrap())[(0, 0)]
}
