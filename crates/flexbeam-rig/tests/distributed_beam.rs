//! The distributed beam: three descriptions against each other, and the figures of DESIGN sections 3 and 6.

use flexbeam_lti::{C64, Mat};
use flexbeam_rig::{Beam, Damping, Lumped, Motion, Output, Physical};

const POINTS: [C64; 7] = [
    C64::new(-1.5, 0.3),
    C64::new(-1.5, 26.0),
    C64::new(0.0, 129.0),
    C64::new(3.0, 400.0),
    C64::new(-40.0, 3.0),
    C64::new(65.0, 0.0),
    C64::new(0.0, 3000.0),
];

fn beam(damping: Damping) -> Beam {
    Beam::new(Physical { B_eq: 0.002, ..Physical::paper() }, damping).unwrap()
}

fn relative(found: C64, wanted: C64) -> f64 {
    (found - wanted).norm() / wanted.norm()
}

#[test]
fn series_and_closed_form_agree_without_damping() {
    let series = beam(Damping::Modal { zeta: 0.0 });
    let closed = beam(Damping::KelvinVoigt { eta_s: 0.0 });
    for s in POINTS {
        let (a, b) = (series.at(s), closed.at(s));
        let error =
            relative(a.theta, b.theta).max(relative(a.alpha, b.alpha)).max(relative(series.gauge(s), closed.gauge(s)));
        assert!(error < 1e-11, "{s}: {error:e}");
    }
}

/// Assumed modes against the exact response: the error falls with N as the theory says, for either damping.
#[test]
fn assumed_modes_converge_to_the_exact_response() {
    let outputs = [Output::Theta, Output::Alpha, Output::Gauge];
    for damping in [Damping::Modal { zeta: 0.005 }, Damping::KelvinVoigt { eta_s: 1e-4 }] {
        let beam = beam(damping);
        for s in [POINTS[0], POINTS[1], POINTS[2], POINTS[4]] {
            let exact = beam.at(s);
            let error = |N: usize| {
                let G = Motion::assumed_modes(&beam, N, 0.0).unwrap().state_space(&outputs).unwrap().at(s);
                [relative(G[0], exact.theta), relative(G[1], exact.alpha), relative(G[2], beam.gauge(s))]
            };
            let (coarse, fine) = (error(10), error(20));
            assert!(fine[0] < 1e-7 && fine[1] < 1e-6 && fine[2] < 1e-3, "{s}: {fine:?}");
            assert!(fine[2] < coarse[2] / 6.0, "{s}: {coarse:?} {fine:?}");
        }
    }
}

/// Root strain by the moment balance at the hub: EI (1 + eta s) w''(0) = J_base s^2 theta + c0 s theta - g V.
#[test]
fn the_gauge_closes_the_moment_balance_of_the_hub() {
    for damping in [Damping::Modal { zeta: 0.0 }, Damping::KelvinVoigt { eta_s: 2e-4 }] {
        let beam = beam(damping);
        let p = beam.physical;
        let eta_s = if let Damping::KelvinVoigt { eta_s } = damping { eta_s } else { 0.0 };
        for s in POINTS {
            let response = beam.at(s);
            let thickness_m = 0.002;
            let curvature = beam.root_strain(s, thickness_m) * (2.0 / thickness_m);
            let moment = curvature * (s * eta_s + 1.0) * beam.bending_stiffness();
            let drive = response.theta * (s * s * p.J_base + s * p.hub_damping()) - p.torque_per_volt();
            let scale = drive.norm().max(p.torque_per_volt());
            assert!((moment - drive).norm() < 1e-9 * scale, "{s} {damping:?}: {moment} {drive}");
        }
    }
}

#[test]
fn far_from_the_axis_the_closed_form_does_not_overflow() {
    let response = beam(Damping::KelvinVoigt { eta_s: 0.0 }).at(C64::new(1e9, 1e9));
    assert!(response.theta.is_finite() && response.alpha.is_finite());
    assert!(response.psi().norm() < 1e-15);
}

fn paper_poles(N: usize) -> Vec<C64> {
    let motion = Motion::assumed_modes(&Beam::paper(), N, 0.0).unwrap();
    motion.state_space(&[Output::Psi]).unwrap().poles()
}

fn nearest(poles: &[C64], wanted: C64) -> f64 {
    poles.iter().map(|p| (p - wanted).norm()).fold(f64::INFINITY, f64::min)
}

#[test]
fn poles_of_three_modes_as_in_design_section_3() {
    let poles = paper_poles(3);
    for (printed, half_digit) in [
        (C64::new(-10.85, 23.42), 0.0071),
        (C64::from(-32.76), 0.0051),
        (C64::new(-2.30, 129.5), 0.051),
        (C64::new(-2.018, 354.3), 0.051),
        (C64::from(0.0), 1e-9),
    ] {
        assert!(nearest(&poles, printed) < half_digit, "{printed}: {poles:?}");
    }
    let lumped = Lumped::PAPER.state_space(&[Output::Psi]).unwrap().poles();
    let worst = lumped.iter().filter(|p| p.norm() > 1.0).map(|p| nearest(&poles, *p) / p.norm()).fold(0.0, f64::max);
    assert!((worst - 0.061).abs() < 5e-4, "{worst}");
}

/// The zeros of psi are those of 1 + alpha/theta, on the real axis; a sign change brackets each.
#[test]
fn right_half_plane_zeros_of_the_tip_angle_as_in_design_section_3() {
    let sigma = |beam: &Beam, s: f64| (beam.at(C64::from(s)).psi() / beam.at(C64::from(s)).theta).re;
    let beam = Beam::paper();
    for (printed, half_digit) in [(65.4, 0.05), (330.8, 0.05)] {
        let (low, high) = (sigma(&beam, printed - half_digit), sigma(&beam, printed + half_digit));
        assert!(low * high < 0.0, "{printed}: {low} {high}");
    }
}

/// max over w of |psi/V of a beam - (18)| on s = jw - beta: a grid with each mode's frequency in it, and from
/// its largest value a search that halves its step.
fn largest_difference(beta: f64, psi: impl Fn(C64) -> C64) -> f64 {
    let G0 = Lumped::PAPER.state_space(&[Output::Psi]).unwrap();
    let dG = |omega: f64| {
        let s = C64::new(-beta, omega);
        (psi(s) - G0.at(s)[(0, 0)]).norm()
    };
    let grid = (0..500).map(f64::from).chain(paper_poles(8).into_iter().map(|p| p.im));
    let mut peak = grid.map(|omega| (dG(omega), omega)).fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
    let mut step = 1.0;
    while step > 1e-7 {
        let uphill = [peak.1 - step, peak.1 + step].map(|omega| (dG(omega), omega)).into_iter().find(|p| p.0 > peak.0);
        match uphill {
            Some(higher) => peak = higher,
            None => step /= 2.0,
        }
    }
    peak.0
}

/// DESIGN's figures are those of three assumed modes. Close to the third mode's damping the exact beam, whose mode
/// stands at -2.01776 and not at -2.01819, differs more: the last two figures become 0.549 and 3.53.
#[test]
fn distance_from_18_as_in_design_section_6() {
    let three = Motion::assumed_modes(&Beam::paper(), 3, 0.0).unwrap().state_space(&[Output::Psi]).unwrap();
    for (beta, printed, half_digit) in [(1.5, 0.087, 5e-4), (1.9, 0.174, 5e-4), (2.0, 0.54, 5e-3), (2.015, 3.1, 0.05)] {
        let found = largest_difference(beta, |s| three.at(s)[(0, 0)]);
        assert!((found - printed).abs() <= half_digit, "beta {beta}: {found}, printed {printed}");
    }
    for (beta, exact, half_digit) in
        [(1.5, 0.0866, 5e-5), (1.9, 0.1736, 5e-5), (2.0, 0.5495, 5e-5), (2.015, 3.533, 5e-4)]
    {
        let found = largest_difference(beta, |s| Beam::paper().at(s).psi());
        assert!((found - exact).abs() <= half_digit, "beta {beta}: {found}, exact {exact}");
    }
}

/// Newton's refinement against forty assumed modes.
#[test]
fn modes_of_the_exact_beam() {
    for beam in [Beam::paper(), beam(Damping::KelvinVoigt { eta_s: 2e-5 })] {
        let modes = beam.modes(4);
        let many = Motion::assumed_modes(&beam, 40, 0.0).unwrap().state_space(&[Output::Psi]).unwrap().poles();
        for (k, mode) in modes.iter().enumerate() {
            assert!(nearest(&many, *mode) < 1e-6 * mode.norm(), "mode {}: {mode}", k + 1);
            assert!(beam.at(*mode).theta.norm() > 1e6, "mode {}: {mode} is no pole", k + 1);
        }
    }
    let third = Beam::paper().modes(3)[2];
    assert!((third - C64::new(-2.01776, 354.3045)).norm() < 1e-4, "{third}");
}

/// A tip mass against the exact boundary condition is checked by statics: a hub that turns with constant
/// acceleration bends the beam by (11/120) m L^3/EI + M_t L^3/(3EI) per unit of acceleration, over L.
#[test]
fn a_tip_mass_bends_the_accelerated_beam_as_statics_says() {
    let beam = Beam::paper();
    let (p, tip_mass_kg) = (beam.physical, 0.05);
    let L = p.length_m;
    let wanted = (11.0 / 120.0 * p.link_mass_kg() + tip_mass_kg / 3.0) * L.powi(3) / beam.bending_stiffness();
    let motion = Motion::assumed_modes(&beam, 60, tip_mass_kg).unwrap();
    let eta = motion.K.clone().lu().solve(&Mat::from_column_slice(60, 1, motion.h.as_slice())).unwrap();
    let found = (motion.tip.transpose() * eta)[0];
    assert!((found / wanted - 1.0).abs() < 1e-6, "{found} {wanted}");
}

/// The clamped beam with mass r m at its tip has frequencies omega_1 (lambda/mu_1)^2, where
/// 1 + cos cosh + r lambda (cos sinh - sin cosh) = 0 at lambda.
#[test]
fn a_tip_mass_lowers_the_clamped_frequencies_as_the_exact_equation_says() {
    let beam = Beam::paper();
    let r = 0.4;
    let characteristic = |x: f64| {
        let moment = x.cos() * x.sinh() - x.sin() * x.cosh();
        1.0 + x.cos() * x.cosh() + r * x * moment
    };
    let motion = Motion::assumed_modes(&beam, 80, r * beam.physical.link_mass_kg()).unwrap();
    let mut found: Vec<f64> = motion.clamped().0.complex_eigenvalues().iter().map(|p| p.norm()).collect();
    found.sort_by(f64::total_cmp);
    let mu_1 = flexbeam_rig::clamped_free_root(1);
    for (k, (mut low, mut high)) in [(1.0, 1.87), (3.2, 4.69), (6.5, 7.85)].into_iter().enumerate() {
        assert!(characteristic(low) * characteristic(high) < 0.0, "mode {}", k + 1);
        for _ in 0..60 {
            let middle: f64 = (low + high) / 2.0;
            if characteristic(low) * characteristic(middle) <= 0.0 { high = middle } else { low = middle }
        }
        let omega = beam.clamped_frequency_rad_s(1) * (low / mu_1).powi(2);
        // Clamped-free shapes have no shear force at the tip: N of them miss by a part of order k^2/N.
        let error = found[2 * k] / omega - 1.0;
        assert!((-1e-9..5e-3).contains(&error), "mode {}: {error:e}", k + 1);
    }
}
