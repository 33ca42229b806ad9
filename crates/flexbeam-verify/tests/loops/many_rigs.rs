//! Campaigns on the simulated rig.

use crate::by_hand::{TIMING, controller};
use flexbeam_kernel::{Channel, Settings};
use flexbeam_lti::StateSpace;
use flexbeam_rig::{Beam, Damping, Link, RigParameters};
use flexbeam_verify::{Campaign, Error, Quantiles, Scenario, Spread, monte_carlo};

fn scenario(controller: &StateSpace, rig: RigParameters) -> Scenario<'_> {
    let channel = Channel { low_pass: TIMING.low_pass, ..Channel::default() };
    let settings = Settings { theta: channel, alpha: channel, smooth_ticks: 300.0, ..Settings::default() };
    Scenario { rig, settings, controller, step_rad: 0.5, duration_s: 3.0 }
}

#[test]
fn threads_do_not_change_the_result_and_every_run_is_counted() {
    let controller = controller(TIMING, 1.5);
    let scenario = scenario(&controller, RigParameters::default());
    let mut heard = Vec::new();
    let campaign = Campaign { runs: 12, seed: 7, threads: 1, ..Campaign::default() };
    let one = monte_carlo(&scenario, &campaign, |done| heard.push(done)).unwrap();
    let three = monte_carlo(&scenario, &Campaign { threads: 3, ..campaign }, |_| ()).unwrap();
    assert_eq!(one, three);
    assert_eq!(heard, (1..=12).collect::<Vec<_>>());
    let other = monte_carlo(&scenario, &Campaign { seed: 8, ..campaign }, |_| ()).unwrap();
    assert!(one.runs.iter().zip(&other.runs).all(|(a, b)| a.rig != b.rig && a.metrics != b.metrics));
    // A longer campaign begins with the shorter one.
    let longer = monte_carlo(&scenario, &Campaign { runs: 14, ..campaign }, |_| ()).unwrap();
    assert_eq!(longer.runs[..12], one.runs[..]);
}

#[test]
fn a_linear_rig_without_spread_repeats_itself_in_both_directions() {
    let controller = controller(TIMING, 1.5);
    let scenario = scenario(&controller, RigParameters::default().linear());
    let campaign = Campaign { runs: 4, spread: Spread::NONE, ..Campaign::default() };
    let summary = monte_carlo(&scenario, &campaign, |_| ()).unwrap();
    assert_eq!((summary.share_stable, summary.share_limit_cycle), (1.0, 0.0));
    let [up, down] = [0, 1].map(|k| summary.runs[k].metrics);
    assert!((up.step_rad + down.step_rad).abs() < 1e-12);
    assert!((up.peak_voltage_v - down.peak_voltage_v).abs() < 1e-9 * up.peak_voltage_v);
    assert!(up.stationary_error_rad < 1e-3 && up.residual_vibration_rad < 1e-3, "{up:?}");
    assert!(summary.settling_time_s.worst < 3.0);
}

#[test]
fn friction_is_seen_and_an_unstable_loop_is_counted() {
    let mut controller = controller(TIMING, 1.5);
    let campaign = Campaign { runs: 6, ..Campaign::default() };
    let with = monte_carlo(&scenario(&controller, RigParameters::default()), &campaign, |_| ()).unwrap();
    let without = monte_carlo(&scenario(&controller, RigParameters::default().linear()), &campaign, |_| ()).unwrap();
    assert!(with.stationary_error_rad.median > 5.0 * without.stationary_error_rad.median);
    controller.B.column_mut(1).neg_mut();
    let unstable = monte_carlo(&scenario(&controller, RigParameters::default()), &campaign, |_| ()).unwrap();
    assert_eq!(unstable.share_stable, 0.0);
}

#[test]
fn the_spread_is_drawn_as_stated() {
    let controller = controller(TIMING, 1.5);
    let scenario = Scenario { duration_s: 0.02, ..scenario(&controller, RigParameters::default()) };
    let summary = monte_carlo(&scenario, &Campaign { runs: 400, ..Campaign::default() }, |_| ()).unwrap();
    let nominal = scenario.rig;
    let damping = |link: Link| match link {
        Link::Modes { damping: Damping::Modal { zeta }, .. } => zeta,
        other => panic!("{other:?}"),
    };
    type Measure = fn(&RigParameters) -> f64;
    let measures: [(f64, Measure); 4] = [
        (0.03, |r| r.physical.J_base),
        (0.05, |r| r.physical.K_stiff),
        (0.2, |r| r.friction.coulomb_nm),
        (0.2, |r| r.actuator.dead_zone_plus_v),
    ];
    for (sigma, measure) in measures {
        let logarithms: Vec<f64> =
            summary.runs.iter().map(|run| (measure(&run.rig) / measure(&nominal)).ln()).collect();
        expect_spread(sigma, &logarithms);
    }
    let logarithms: Vec<f64> = summary.runs.iter().map(|run| (damping(run.rig.link) / Beam::ZETA).ln()).collect();
    expect_spread(0.3, &logarithms);
}

/// 400 samples: the standard deviation is known to 3.5 %, the mean to 5 % of sigma; four of these.
fn expect_spread(sigma: f64, samples: &[f64]) {
    let mean = samples.iter().sum::<f64>() / samples.len() as f64;
    let deviation = (samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / samples.len() as f64).sqrt();
    assert!((deviation / sigma - 1.0).abs() < 0.15 && mean.abs() < 0.2 * sigma, "{sigma}: {mean} {deviation}");
}

#[test]
fn quantiles_are_order_statistics() {
    let found = Quantiles::of((1..=20).rev().map(f64::from));
    assert_eq!((found.median, found.p95, found.worst), (10.0, 19.0, 20.0));
    let one = Quantiles::of([3.0].into_iter());
    assert_eq!((one.median, one.p95, one.worst), (3.0, 3.0, 3.0));
    let unsettled = Quantiles::of([1.0, f64::INFINITY, 2.0].into_iter());
    assert_eq!((unsettled.median, unsettled.worst), (2.0, f64::INFINITY));
}

#[test]
fn nothing_to_run_is_an_error() {
    let controller = controller(TIMING, 1.5);
    let scenario = scenario(&controller, RigParameters::default());
    for campaign in [Campaign { runs: 0, ..Campaign::default() }, Campaign { threads: 0, ..Campaign::default() }] {
        assert!(matches!(monte_carlo(&scenario, &campaign, |_| ()), Err(Error::Setting { .. })));
    }
}
