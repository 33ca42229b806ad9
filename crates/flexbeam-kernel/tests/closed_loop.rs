//! The loop closed around a rigid servo with a dead zone: what the laws and u_applied are for.

use flexbeam_kernel::{Commanded, Controller, Fault, Law, Measured, Settings, State, tick, v_res};

/// p+ = p + w, w+ = A w + B V per tick: 1.86 rad/s/V with 30 ms, 1 kHz.
const A: f64 = 0.967;
const B: f64 = 1.86e-3 * (1.0 - A);
/// State feedback with both poles at R, observer with both at Q.
const R: f64 = 0.98;
const Q: f64 = 0.95;
const F: [f64; 2] = [(1.0 - R) * (1.0 - R) / B, (1.0 + A - 2.0 * R) / B];
const L: [f64; 2] = [1.0 + A - 2.0 * Q, Q * Q - (2.0 * Q - A) * A];

const BREAKAWAY_V: f64 = 0.28;

/// Observer (x1, x2), u = F1 (v - x1) - F2 x2, and the closed loop's own model (x3, x4), column-major.
fn observer_controller() -> [f64; 40] {
    #[rustfmt::skip]
    let coefficients = [
        1.0 - L[0], -L[1], 0.0, 0.0,               // x1
        1.0, A, 0.0, 0.0,                          // x2
        0.0, 0.0, 1.0, -B * F[0],                  // x3
        0.0, 0.0, 1.0, A - B * F[1],               // x4
        0.0, 0.0, 0.0, B * F[0],                   // v
        L[0], L[1], 0.0, 0.0,                      // y
        0.0, B, 0.0, 0.0,                          // u_applied
        -F[0], 0.0, -F[1], 0.0, 0.0, 1.0, 0.0, 0.0, // C
        F[0], 0.0, 0.0, 0.0,                       // D
    ];
    coefficients
}

/// Volts per radian at rest, from the controller's equations with y standing still.
fn stiffness() -> f64 {
    F[0] / (1.0 + (F[0] + F[1] * L[0]) * B / ((1.0 - A) * L[0] + L[1]))
}

struct Servo {
    p: f64,
    w: f64,
    breakaway_v: f64,
}

impl Servo {
    fn advance(&mut self, voltage: f64) {
        let beyond = (voltage.abs() - self.breakaway_v).max(0.0).copysign(voltage);
        self.p += self.w;
        self.w = A * self.w + B * beyond;
    }
}

/// Every tick's answer, with the largest distance between the observer's state and the servo's.
fn run(settings: &Settings, breakaway_v: f64, reference_rad: f64, ticks: usize) -> (Vec<Commanded>, f64) {
    let coefficients = observer_controller();
    let controller = Controller::new(4, &coefficients).unwrap();
    let mut memory = [0.0; 11];
    let mut state = State::new(&controller, &mut memory).unwrap();
    let mut servo = Servo { p: 0.0, w: 0.0, breakaway_v };
    let mut observer_error: f64 = 0.0;
    let answers = (0..ticks).map(|_| {
        observer_error = observer_error.max((state.x()[0] - servo.p).abs()).max((state.x()[1] - servo.w).abs());
        let measured = Measured { reference_rad, theta_rad: servo.p, alpha_rad: 0.0 };
        let commanded = tick(settings, &controller, &mut state, measured);
        assert_eq!(commanded.fault, Fault::None);
        servo.advance(commanded.voltage_v);
        commanded
    });
    (answers.collect(), observer_error)
}

fn at_rest(settings: &Settings, reference_rad: f64) -> f64 {
    let (answers, _) = run(settings, BREAKAWAY_V, reference_rad, 8000);
    let rest = answers[7999].y_rad;
    assert!((rest - answers[7000].y_rad).abs() < 1e-9, "at rest");
    (reference_rad - rest).abs()
}

fn compensating(law: Law) -> Settings {
    let (u_p, eps_u_v) = (BREAKAWAY_V, 0.1);
    Settings {
        law,
        u_p_plus_v: u_p,
        u_p_minus_v: u_p,
        breakaway_plus_v: BREAKAWAY_V,
        breakaway_minus_v: BREAKAWAY_V,
        eps_u_v,
        smooth_ticks: 200.0,
        ..Settings::default()
    }
}

#[test]
fn the_linear_loop_is_its_own_reference_model() {
    let settings = Settings { smooth_ticks: 150.0, ..Settings::default() };
    let (answers, observer_error) = run(&settings, 0.0, 0.5, 3000);
    let largest = answers.iter().fold(0.0, |m: f64, c| m.max(c.error_rad.abs()));
    assert!(largest < 1e-13 && observer_error < 1e-13, "{largest} {observer_error}");
    assert!((answers[2999].y_rad - 0.5).abs() < 1e-9);
}

#[test]
fn the_observer_follows_the_servo_through_saturation_and_dead_zone() {
    for (law, breakaway_v) in [(Law::None, 0.0), (Law::Switched, BREAKAWAY_V)] {
        let settings = Settings { voltage_limit_v: 2.0, smooth_ticks: 0.0, ..compensating(law) };
        let (answers, observer_error) = run(&settings, breakaway_v, 4.0, 4000);
        let saturated = answers.iter().filter(|c| c.voltage_v == 2.0).count();
        assert!(saturated > 300, "{law:?}: {saturated} ticks at the limit");
        assert!(observer_error < 1e-12, "{law:?}: {observer_error}");
        let overshoot = answers.iter().fold(0.0, |m: f64, c| m.max(c.y_rad)) - 4.0;
        assert!(overshoot < 0.02, "{law:?}: wound up, {overshoot} rad");
    }
}

#[test]
fn at_rest_the_inverse_law_leaves_v_res_over_the_stiffness_and_no_law_leaves_more() {
    let promised = v_res(0.1, BREAKAWAY_V) / stiffness();
    let (mut with, mut without): (f64, f64) = (0.0, 0.0);
    for k in -12..=12 {
        let reference_rad = 0.1 * f64::from(k);
        with = with.max(at_rest(&compensating(Law::Inverse), reference_rad));
        without = without.max(at_rest(&compensating(Law::None), reference_rad));
    }
    assert!(with <= promised * (1.0 + 1e-9), "{with} against {promised}");
    assert!(
        without > 1.5 * promised && without <= BREAKAWAY_V / stiffness() * (1.0 + 1e-9),
        "{without} against {promised}"
    );
}
