//! A controller made by hand on (18): a sampled observer with state feedback, in the kernel's form.

use flexbeam_lti::{C64, Mat, StateSpace, Time, connections, sampling};
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

/// Inputs (v, y, u_applied), outputs (u, y_model). After the observer come the states that only v reaches: two of a prefilter w,
/// and the plant under state feedback driven by w, whose output is y_model: the tip follows it exactly.
pub fn controller(timing: Timing, degree: f64) -> StateSpace {
    let plant = sampled_plant(timing);
    let n = plant.order();
    let F = state_feedback(&plant, degree, &(plant.C.tr_mul(&plant.C) * 30.0), 1.0);
    let dual = StateSpace { A: plant.A.transpose(), B: plant.C.transpose(), C: plant.B.transpose(), ..plant.clone() };
    let H = state_feedback(&dual, degree, &(&plant.B * plant.B.transpose()), 1e-6).transpose();
    let followed = &plant.A - &plant.B * &F;
    let at_rest = (Mat::identity(n, n) - &followed).lu().solve(&plant.B).unwrap();
    let gain = 1.0 / (&plant.C * at_rest)[(0, 0)];
    let mut A = Mat::zeros(2 * n + 2, 2 * n + 2);
    A.view_mut((0, 0), (n, n)).copy_from(&(&plant.A - &H * &plant.C));
    A[(n, n)] = 0.97;
    A[(n + 1, n + 1)] = 0.97;
    A[(n + 1, n)] = 0.03;
    A.view_mut((n + 2, n + 2), (n, n)).copy_from(&followed);
    A.view_mut((n + 2, n + 1), (n, 1)).copy_from(&(&plant.B * gain));
    let mut B = Mat::zeros(2 * n + 2, 3);
    B.view_mut((0, 1), (n, 1)).copy_from(&H);
    B.view_mut((0, 2), (n, 1)).copy_from(&plant.B);
    B[(n, 0)] = 0.03;
    let mut C = Mat::zeros(2, 2 * n + 2);
    C.view_mut((0, 0), (1, n)).copy_from(&-&F);
    C[(0, n + 1)] = gain;
    C.view_mut((1, n + 2), (1, n)).copy_from(&plant.C);
    StateSpace::new(A, B, C, Mat::zeros(2, 3), plant.time).unwrap()
}

/// K of u = -K y, without the states that only v reaches.
pub fn feedback_part(controller: &StateSpace) -> StateSpace {
    let n = (controller.order() - 2) / 2;
    let part = |M: &Mat, rows: usize, columns: usize| M.view((0, 0), (rows, columns)).into_owned();
    let C = part(&controller.C, 1, n);
    let [y, applied] = [1, 2].map(|k| controller.B.view((0, k), (n, 1)).into_owned());
    StateSpace::new(part(&controller.A, n, n) + applied * &C, y, -C, Mat::zeros(1, 1), controller.time).unwrap()
}

/// Eigenvalues of the loop as one matrix: what the counts must find.
pub fn closed_loop_poles(timing: Timing, controller: &StateSpace) -> Vec<C64> {
    connections::feedback(&feedback_part(controller), &sampled_plant(timing)).unwrap().poles()
}

/// -max ln|z|/Ts.
pub fn degree(poles: &[C64], period_s: f64) -> f64 {
    -poles.iter().map(|z| z.norm()).fold(0.0, f64::max).ln() / period_s
}
