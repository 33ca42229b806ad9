//! The sampled beam against assumed modes behind an exact hold, and the loop made by hand on it.

use crate::by_hand::{TIMING, controller, nominal};
use flexbeam_lti::{C64, StateSpace, Zpk};
use flexbeam_rig::{Beam, Damping, Motion, Output, Physical};
use flexbeam_verify::{BeamPlant, Feedback, Loop, Plant, Sampled, Timing, on_beam, worst_neglected_mode};

fn assumed(modes: usize) -> StateSpace {
    Motion::assumed_modes(&Beam::paper(), modes, 0.0).unwrap().state_space(&[Output::Psi]).unwrap()
}

fn points(radius: f64) -> Vec<C64> {
    [1e-4, 0.003, 0.02, 0.13, 0.354, 0.7, 1.5, 3.0].map(|angle| C64::from_polar(radius, angle)).to_vec()
}

#[test]
fn alias_sum_is_the_exact_hold_of_many_assumed_modes() {
    for (delay_s, low_pass) in [(1e-3, 0.6), (0.0, 1.0), (1.7e-3, 1.0)] {
        let timing = Timing { delay_s, low_pass, ..TIMING };
        let beam = BeamPlant::with_tail(&Beam::paper(), timing, 1e-8).unwrap();
        let exact: Vec<(C64, C64)> = points(0.9985).into_iter().map(|z| (z, beam.at(z).0)).collect();
        let error = |modes: usize| {
            let modal = Plant::new(&assumed(modes), timing).unwrap();
            exact.iter().map(|(z, G)| (modal.at(*z).0 - G).norm()).fold(0.0, f64::max)
        };
        // Frequencies of assumed modes converge as N^-3.
        let (few, many) = (error(8), error(24));
        assert!(many < few / 15.0 && many < 2e-5, "{few} {many}");
    }
}

#[test]
fn the_tail_bound_holds_and_is_reached_within_its_reserve() {
    let beam = |relative: f64| BeamPlant::with_tail(&Beam::paper(), TIMING, relative).unwrap();
    let fine = beam(1e-9);
    for relative in [1e-5, 1e-7] {
        let coarse = beam(relative);
        let worst = points(0.9985).into_iter().map(|z| (coarse.at(z).0 - fine.at(z).0).norm()).fold(0.0, f64::max);
        let bound = coarse.tail_rad_per_v() + fine.tail_rad_per_v();
        assert!(worst <= bound, "{relative}: {worst} above {bound}");
        assert!(worst > 1e-4 * bound, "{relative}: {worst} far below {bound}");
        assert!(coarse.aliases() < fine.aliases());
    }
}

#[test]
fn on_the_shifted_line_the_beam_differs_as_the_design_page_says() {
    let timing = Timing { period_s: 1e-3, delay_s: 0.0, low_pass: 1.0 };
    let beam = BeamPlant::new(&Beam::paper(), timing).unwrap();
    let feedback = Feedback::new(&controller(TIMING, 1.5)).unwrap();
    let one = Zpk { zeros: vec![], poles: vec![], gain: 1.0 };
    for (beta, printed) in [(1.5, 0.087), (1.9, 0.174)] {
        let found = on_beam(&beam, &nominal(), &feedback, &one, beta).unwrap();
        assert!((found.largest_difference.value - printed).abs() < 1e-3, "{beta}: {:?}", found.largest_difference);
        assert_eq!(found.poles_beyond_beta, (1, 1));
        assert_eq!(found.difference, found.largest_difference);
    }
    let mode = worst_neglected_mode(&beam, &nominal()).unwrap();
    assert_eq!(mode.number, 3);
    assert!((mode.damping_per_s - 2.018).abs() < 2e-3 && (mode.omega_rad_s - 354.3).abs() < 0.6, "{mode:?}");
}

#[test]
fn counts_on_the_beam_are_those_of_many_assumed_modes() {
    let feedback = Feedback::new(&controller(TIMING, 1.5)).unwrap();
    let beam = BeamPlant::new(&Beam::paper(), TIMING).unwrap();
    let modal = Plant::new(&assumed(12), TIMING).unwrap();
    let (exact, truncated) = (Loop::new(&beam, &feedback).unwrap(), Loop::new(&modal, &feedback).unwrap());
    for degree in [0.0, 1.0, 1.5, 4.0] {
        let [a, b] = [&exact, &truncated].map(|L| flexbeam_verify::count(L, degree).unwrap());
        assert_eq!((a.beyond, a.open_loop), (b.beyond, b.open_loop), "{degree}");
    }
    assert_eq!(flexbeam_verify::count(&exact, 0.0).unwrap().beyond, 0, "the loop made by hand is stable on the beam");
}

#[test]
fn beyond_the_third_modes_damping_the_poles_no_longer_match() {
    let beam = BeamPlant::new(&Beam::paper(), TIMING).unwrap();
    let feedback = Feedback::new(&controller(TIMING, 1.5)).unwrap();
    let one = Zpk { zeros: vec![], poles: vec![], gain: 1.0 };
    let found = on_beam(&beam, &nominal(), &feedback, &one, 2.1).unwrap();
    assert_eq!(found.poles_beyond_beta, (3, 1));
    let broken: Vec<&str> = found.figures().iter().filter(|f| !f.agrees).map(|f| f.figure).collect();
    assert!(broken.contains(&"beam.open_loop_poles_beyond_beta"), "{broken:?}");
}

#[test]
fn a_beam_without_damping_of_its_own_is_counted_with_the_integrator_on_the_contour() {
    let undamped = Beam::new(Physical::paper(), Damping::KelvinVoigt { eta_s: 0.0 }).unwrap();
    let beam = BeamPlant::new(&undamped, TIMING).unwrap();
    // The hub's motor damps each mode a little: nothing stands on the circle but the integrator.
    assert!(beam.modes().iter().all(|p| p.re < 0.0));
    let feedback = Feedback::new(&controller(TIMING, 1.5)).unwrap();
    let L = Loop::new(&beam, &feedback).unwrap();
    let found = flexbeam_verify::count(&L, 0.0).unwrap();
    assert_eq!(found.open_loop, 0);
}
