//! A true certificate is verified; each kind of sabotage breaks it and is named.

use crate::by_hand::{TIMING, closed_loop_poles, controller, degree, feedback_part, nominal, sampled_plant};
use flexbeam_lti::{C64, StateSpace, Zpk, connections, hankel, norm, sampling, split};
use flexbeam_verify::{Claim, Feedback, Loop, Plant, Subject, Timing, Verdict, Verified, margins, verify};

const BETA: f64 = 1.5;
const V_RES: f64 = 0.08;

struct Certificate {
    nominal: StateSpace,
    controller: StateSpace,
    timing: Timing,
    alpha: Zpk,
    claim: Claim,
}

impl Certificate {
    fn verdict(&self) -> Verdict {
        let Certificate { nominal, controller, timing, alpha, claim } = self;
        let subject =
            Subject { nominal, timing: *timing, controller, beta: BETA, alpha, alpha_w: alpha, v_res_v: V_RES };
        verify(&subject, claim).unwrap()
    }

    fn broken(&self) -> Vec<&'static str> {
        self.verdict().broken().map(|f| f.figure).collect()
    }
}

/// The figures by state space: eigenvalues, Hamiltonians, Hankel singular values. The margins are the loop's own: their test
/// perturbs the loop.
fn honest() -> Certificate {
    let controller = controller(TIMING, 3.0);
    let (plant, K) = (sampled_plant(TIMING), feedback_part(&controller));
    let W = connections::feedback(&K, &plant).unwrap();
    let gain = 0.9 / norm::hinf_norm(&sampling::to_w(&W.shifted(BETA)).unwrap()).unwrap().norm;
    let stiffness = K.at(C64::from(1.0))[(0, 0)].re;
    let (loop_plant, feedback) = (Plant::new(&nominal(), TIMING).unwrap(), Feedback::new(&controller).unwrap());
    let margins = margins(&Loop::new(&loop_plant, &feedback).unwrap());
    let poles = closed_loop_poles(TIMING, &controller);
    let claim = Claim {
        continuous_radius: Some(smallest_hankel(&nominal().shifted(BETA)) / gain),
        robust_radius: Some(smallest_hankel(&sampling::to_w(&plant.shifted(BETA)).unwrap()) / gain),
        bound_norm: 0.9,
        stability_degree: degree(&poles, TIMING.period_s),
        stiffness_v_per_rad: stiffness,
        gain_margin: margins.gain,
        phase_margin_rad: margins.phase_rad,
        delay_margin_s: margins.delay_s,
        disk_margin: margins.disk,
        closed_loop_poles: poles,
        stationary_error_rad: V_RES / stiffness,
    };
    let alpha = Zpk { zeros: vec![], poles: vec![], gain };
    Certificate { nominal: nominal(), controller, timing: TIMING, alpha, claim }
}

fn smallest_hankel(G: &StateSpace) -> f64 {
    let (antistable, _) = split::split(G, |p| p.re > 0.0).unwrap();
    let values = hankel::antistable_hankel_singular_values(&antistable).unwrap();
    values.into_iter().fold(f64::INFINITY, f64::min)
}

#[test]
fn an_honest_certificate_is_verified_and_agreement_is_far_below_the_tolerances() {
    let verdict = honest().verdict();
    assert!(verdict.verified(), "{:#?}", verdict.broken().collect::<Vec<_>>());
    for Verified { figure, claimed, recomputed, tolerance, .. } in &verdict.figures {
        println!("{figure:32} {claimed:<22} {recomputed:<22} {tolerance:.0e} {:.1e}", (claimed - recomputed).abs());
    }
    assert_eq!(verdict.figures.len(), 18);
}

#[test]
fn each_figure_that_is_claimed_wrongly_is_named_and_no_other() {
    type Lie = (&'static str, fn(&mut Claim));
    let lies: [Lie; 11] = [
        ("robust_radius", |c| c.continuous_radius = c.continuous_radius.map(|r| r * 1.001)),
        ("sampled.robust_radius", |c| c.robust_radius = None),
        ("sampled.bound_norm", |c| c.bound_norm *= 0.999),
        ("sampled.stability_degree", |c| c.stability_degree *= 1.001),
        ("closed_loop_poles", |c| c.closed_loop_poles[3] = (c.closed_loop_poles[3] - 1.0) * 1.01 + 1.0),
        ("stiffness", |c| c.stiffness_v_per_rad = f64::INFINITY),
        ("gain_margin", |c| c.gain_margin *= 1.001),
        ("phase_margin_rad", |c| c.phase_margin_rad *= 0.999),
        ("delay_margin_s", |c| c.delay_margin_s = f64::INFINITY),
        ("disk_margin", |c| c.disk_margin *= 1.001),
        ("stationary_error_rad", |c| c.stationary_error_rad *= 0.999),
    ];
    for (figure, lie) in lies {
        let mut certificate = honest();
        lie(&mut certificate.claim);
        assert_eq!(certificate.broken(), [figure]);
    }
    let mut certificate = honest();
    certificate.claim.closed_loop_poles.remove(3);
    assert_eq!(certificate.broken(), ["closed_loop_poles"]);
}

#[test]
fn one_coefficient_off_by_a_percent_is_found_wherever_it_stands() {
    let mut certificate = honest();
    let whole = certificate.controller.clone();
    let order = whole.order();
    let places = (0..order * (order + 5)).filter(|&place| *entry(&mut certificate.controller, place) != 0.0);
    let places: Vec<usize> = places.collect();
    assert!(places.len() > 60, "{}", places.len());
    let mut found = 0;
    for place in places.into_iter().step_by(3) {
        certificate.controller = whole.clone();
        *entry(&mut certificate.controller, place) *= 1.01;
        let weight = effect(&whole, &certificate.controller);
        assert!(!certificate.broken().is_empty() || weight < 1e-6, "coefficient {place} of {order} weighs {weight}");
        found += usize::from(weight >= 1e-6);
    }
    assert!(found > 20, "{found} coefficients that matter");
}

/// Largest relative change of K, T and M over frequency.
fn effect(before: &StateSpace, after: &StateSpace) -> f64 {
    let [before, after] = [before, after].map(|controller| Feedback::new(controller).unwrap());
    let responses = |f: &Feedback, z: C64| {
        let (T, M) = f.from_reference(z);
        [f.at(z).0, T, M]
    };
    let angles = (0..200).map(|k| 1e-5 * 10f64.powf(f64::from(k) * 0.02749));
    let points = angles.map(|angle| C64::from_polar(1.0, angle));
    let change = points.flat_map(|z| {
        let (a, b) = (responses(&before, z), responses(&after, z));
        (0..3).map(move |k| (a[k] - b[k]).norm() / a[k].norm())
    });
    change.fold(0.0, f64::max)
}

/// Entries of A, B, C in the kernel's order.
fn entry(controller: &mut StateSpace, place: usize) -> &mut f64 {
    let n = controller.order();
    match place {
        p if p < n * n => &mut controller.A.as_mut_slice()[p],
        p if p < n * (n + 3) => &mut controller.B.as_mut_slice()[p - n * n],
        p => &mut controller.C.as_mut_slice()[p - n * (n + 3)],
    }
}

#[test]
fn a_sign_turned_over_makes_the_loop_unstable_and_is_named() {
    let mut certificate = honest();
    certificate.controller.B.column_mut(1).neg_mut();
    let broken = certificate.broken();
    for figure in ["poles_beyond_beta", "sampled.stability_degree", "closed_loop_poles", "stiffness"] {
        assert!(broken.contains(&figure), "{figure} not in {broken:?}");
    }
    // The prefilter alone: the loop is as before, the tip goes the other way.
    let mut certificate = honest();
    certificate.controller.B.column_mut(0).neg_mut();
    certificate.controller.C.row_mut(1).neg_mut();
    assert_eq!(certificate.broken(), ["matching_error"]);
}

#[test]
fn another_period_or_delay_or_filter_is_found() {
    let mut certificate = honest();
    certificate.timing.period_s *= 1.01;
    certificate.controller.time = flexbeam_lti::Time::Sampled { period_s: certificate.timing.period_s };
    let broken = certificate.broken();
    assert!(broken.contains(&"sampled.stability_degree") && broken.contains(&"closed_loop_poles"), "{broken:?}");
    for timing in [Timing { delay_s: 1.02e-3, ..TIMING }, Timing { low_pass: 0.606, ..TIMING }] {
        let certificate = Certificate { timing, ..honest() };
        let broken = certificate.broken();
        // The radius stays: the only pole right of the line is the integrator's, which neither delay nor filter moves.
        assert!(broken.contains(&"closed_loop_poles") && broken.contains(&"delay_margin_s"), "{broken:?}");
    }
    let mut certificate = honest();
    certificate.controller.time = flexbeam_lti::Time::Sampled { period_s: 2e-3 };
    let Certificate { nominal, controller, timing, alpha, claim } = &certificate;
    let subject = Subject { nominal, timing: *timing, controller, beta: BETA, alpha, alpha_w: alpha, v_res_v: V_RES };
    assert!(verify(&subject, claim).is_err());
}

#[test]
fn a_bound_that_is_broken_or_not_covered_by_its_image_is_named() {
    let mut certificate = honest();
    certificate.alpha.gain *= 1.2;
    let broken = certificate.broken();
    assert!(broken.contains(&"bound_norm_limit") && broken.contains(&"robust_radius"), "{broken:?}");
    let certificate = honest();
    let Certificate { nominal, controller, timing, alpha, claim } = &certificate;
    let above = Zpk { gain: alpha.gain * 1.001, ..alpha.clone() };
    let subject =
        Subject { nominal, timing: *timing, controller, beta: BETA, alpha: &above, alpha_w: alpha, v_res_v: V_RES };
    let broken: Vec<&str> = verify(&subject, claim).unwrap().broken().map(|f| f.figure).collect();
    assert_eq!(broken, ["robust_radius", "alpha_over_its_image"]);
}
