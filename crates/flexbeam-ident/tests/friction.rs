//! The friction test on the simulated rig: what the simulator was given comes back, from voltages and readings alone.

use flexbeam_ident::Error;
use flexbeam_ident::breakaway::{Breakaway, Detection, repeated};
use flexbeam_ident::friction::plan::{Pilot, Plan, pilot, pilot_runs};
use flexbeam_ident::friction::{Estimate, FrictionTest, Motor, Options, Recorded, friction};
use flexbeam_rig::{Actuator, Friction, RigParameters, SimulatedRig, Stribeck, open_loop};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A recording of these voltages.
struct Bench {
    voltage_v: Vec<f64>,
    theta_rad: Vec<f64>,
    alpha_rad: Vec<f64>,
    period_s: f64,
}

impl Bench {
    fn of(rig: &mut SimulatedRig, voltage_v: Vec<f64>) -> Bench {
        let signals = open_loop(rig, &voltage_v).unwrap();
        let row = |k: usize| signals.data.row(k).iter().copied().collect();
        Bench { theta_rad: row(1), alpha_rad: row(2), voltage_v, period_s: signals.period_s }
    }

    fn recorded(&self) -> Recorded<'_> {
        let Bench { voltage_v, theta_rad, alpha_rad, period_s } = self;
        Recorded { voltage_v, theta_rad, alpha_rad, period_s: *period_s }
    }
}

/// Runs of a rig whose pilot was 3 % and 4 mV off.
fn runs_of(parameters: &RigParameters, seed: u64) -> Bench {
    let truth = Truth::of(parameters);
    let rough = Pilot {
        plus_v: truth.breakaway_v[0] + 0.004,
        minus_v: -truth.breakaway_v[1] + 0.004,
        slope_v_s: 1.03 * truth.slope_v_s,
    };
    let voltages = Plan::default().runs(&rough, parameters.period_s, &Options::default()).unwrap();
    Bench::of(&mut SimulatedRig::new(parameters, seed).unwrap(), voltages)
}

/// What the simulator was given, in the units of the test.
struct Truth {
    breakaway_v: [f64; 2],
    dead_zone_v: [f64; 2],
    slope_v_s: f64,
    motor: Motor,
}

impl Truth {
    fn of(parameters: &RigParameters) -> Truth {
        let (physical, actuator, g) = (parameters.physical, parameters.actuator, parameters.physical.torque_per_volt());
        let breakaway_v = parameters.friction.breakaway_nm() / g;
        Truth {
            breakaway_v: [actuator.dead_zone_plus_v + breakaway_v, -actuator.dead_zone_minus_v - breakaway_v],
            dead_zone_v: [actuator.dead_zone_plus_v, actuator.dead_zone_minus_v],
            slope_v_s: physical.hub_damping() / g,
            motor: Motor::Known { K_g: physical.K_g, K_b: physical.K_b, R_ohm: physical.R_ohm },
        }
    }
}

fn rig(coulomb: f64, dead_zone: f64) -> RigParameters {
    let usual = Actuator::default();
    RigParameters {
        friction: Friction { coulomb_nm: coulomb * Friction::default().coulomb_nm, stribeck: None },
        actuator: Actuator {
            dead_zone_plus_v: dead_zone * usual.dead_zone_plus_v,
            dead_zone_minus_v: dead_zone * usual.dead_zone_minus_v,
            ..usual
        },
        ..RigParameters::default()
    }
}

/// The paper's rig and others: half and twice the Coulomb torque, no and twice the dead zone, Stribeck, viscous.
fn rigs() -> Vec<(&'static str, RigParameters)> {
    let stribeck = Stribeck { extra_nm: 0.006, speed_rad_s: 0.15 };
    let rises =
        RigParameters { friction: Friction { stribeck: Some(stribeck), ..Friction::default() }, ..rig(1.0, 1.0) };
    let mut viscous = rig(1.0, 1.0);
    viscous.physical.B_eq = 0.02;
    vec![
        ("the paper's", rig(1.0, 1.0)),
        ("half the Coulomb torque", rig(0.5, 1.0)),
        ("twice the Coulomb torque", rig(2.0, 1.0)),
        ("no dead zone", rig(1.0, 0.0)),
        ("twice the dead zone", rig(1.0, 2.0)),
        ("Stribeck", rises),
        ("viscous", viscous),
    ]
}

fn coulomb(test: &FrictionTest, truth: &Truth) -> Estimate {
    test.coulomb_nm(&truth.motor).expect("parted")
}

#[test]
fn coulomb_torque_dead_zone_and_viscous_friction_come_back_on_every_rig() {
    for (name, parameters) in rigs() {
        let truth = Truth::of(&parameters);
        let bench = runs_of(&parameters, 1);
        let test = friction(&bench.recorded(), &Options::default()).unwrap();
        let found = coulomb(&test, &truth);
        let off = found.value / parameters.friction.coulomb_nm - 1.0;
        let dead = [test.dead_zone_plus_v().unwrap(), test.dead_zone_minus_v().unwrap()];
        let dead_off: Vec<f64> = dead.iter().zip(truth.dead_zone_v).map(|(d, t)| d.value - t).collect();
        let viscous = test.viscous(&truth.motor);
        println!(
            "{name}: coulomb off {:.2} % +- {:.2} %, dead zone off {:.2?} mV +- {:.2}, B_eq {:.5} +- {:.5}, stribeck {:?}",
            100.0 * off,
            100.0 * found.standard_error / found.value,
            dead_off.iter().map(|d| 1e3 * d).collect::<Vec<_>>(),
            1e3 * dead[0].standard_error,
            viscous.value,
            viscous.standard_error,
            test.stribeck_extra_nm(&truth.motor).map(|e| e.value)
        );
        assert!(off.abs() < 0.10, "{name}: {off}");
        assert!(dead_off.iter().all(|d| d.abs() < 0.008), "{name}: {dead_off:?}");
        assert!((viscous.value - parameters.physical.B_eq).abs() < 0.002, "{name}: {viscous:?}");
        assert_eq!(test.stribeck().is_some(), parameters.friction.stribeck.is_some(), "{name}");
    }
}

/// Breakaway by three ramps each way, as the test plans them.
fn ramps_of(parameters: &RigParameters, seed: u64) -> [Estimate; 2] {
    let truth = Truth::of(parameters);
    let rough = Pilot { plus_v: truth.breakaway_v[0] + 0.004, minus_v: 0.004 - truth.breakaway_v[1], slope_v_s: 0.5 };
    let voltages = Plan::default().ramps(&rough, 3, 0.02, 10.0, parameters.period_s);
    let bench = Bench::of(&mut SimulatedRig::new(parameters, seed).unwrap(), voltages);
    let step_v = parameters.actuator.converter_step_v.unwrap_or(0.0);
    repeated(&bench.voltage_v, &bench.theta_rad, bench.period_s, &Detection::default(), step_v).unwrap()
}

#[test]
fn breakaway_voltages_come_back_on_every_rig() {
    for (name, parameters) in rigs() {
        let truth = Truth::of(&parameters);
        for (found, truth) in ramps_of(&parameters, 1).iter().zip(truth.breakaway_v) {
            println!(
                "{name}: {:.5} for {truth:.5}, {:.2} %, +- {:.5} ({})",
                found.value,
                100.0 * (found.value / truth - 1.0),
                found.standard_error,
                found.freedom
            );
            assert!((found.value / truth - 1.0).abs() < 0.05, "{name}: {found:?} for {truth}");
        }
    }
}

/// A rig with another friction and another seed in every draw: the interval that the test states must hold the truth in most.
#[test]
fn ninety_five_percent_intervals_hold_the_truth_in_most_draws() {
    const DRAWS: u64 = 40;
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut held = [0u32; 5];
    let mut worst = [0.0_f64; 2];
    for seed in 0..DRAWS {
        let mut parameters = rig(random.random_range(0.5..2.0), random.random_range(0.0..2.0));
        parameters.physical.B_eq = random.random_range(0.0..0.02);
        let truth = Truth::of(&parameters);
        let bench = runs_of(&parameters, 100 + seed);
        let test = friction(&bench.recorded(), &Options::default()).unwrap();
        let breakaway = ramps_of(&parameters, 200 + seed);
        let tau = coulomb(&test, &truth);
        let holds = |e: Estimate, truth: f64| u32::from((e.value - truth).abs() <= e.half_width_95());
        let of = [
            holds(tau, parameters.friction.coulomb_nm),
            holds(test.dead_zone_plus_v().unwrap(), truth.dead_zone_v[0]),
            holds(test.viscous(&truth.motor), parameters.physical.B_eq),
            holds(breakaway[0], truth.breakaway_v[0]),
            holds(breakaway[1], truth.breakaway_v[1]),
        ];
        held.iter_mut().zip(of).for_each(|(sum, one)| *sum += one);
        worst[0] = worst[0].max((tau.value / parameters.friction.coulomb_nm - 1.0).abs());
        for (e, truth) in breakaway.iter().zip(truth.breakaway_v) {
            worst[1] = worst[1].max((e.value / truth - 1.0).abs());
        }
    }
    println!("held in {DRAWS}: coulomb, dead zone, B_eq, breakaway +-: {held:?}; worst {worst:?}");
    assert!(worst[0] < 0.10 && worst[1] < 0.05, "{worst:?}");
    // 40 draws of 95 %: 34 or fewer come once in seventy times; a bias of two standard errors would hold 20.
    assert!(held.iter().all(|&h| h >= 35), "{held:?}");
}

#[test]
fn the_pilot_finds_the_slope() {
    let parameters = RigParameters::default();
    let truth = Truth::of(&parameters);
    let found = Breakaway { plus_v: 0.284, minus_v: -0.104, plus_sample: 0, minus_sample: 0 };
    let voltages = pilot_runs(&found, 2.0, parameters.period_s, &Options::default());
    let bench = Bench::of(&mut SimulatedRig::new(&parameters, 1).unwrap(), voltages);
    let pilot = pilot(&bench.recorded(), &found, &Options::default()).unwrap();
    assert!((pilot.slope_v_s / truth.slope_v_s - 1.0).abs() < 0.05, "{pilot:?} for {}", truth.slope_v_s);
}

/// A computer that writes down a voltage two periods before it acts: the test finds the delay and the same torque.
#[test]
fn a_recording_whose_voltage_acts_later_says_so() {
    let parameters = RigParameters::default();
    let truth = Truth::of(&parameters);
    let mut bench = runs_of(&parameters, 3);
    bench.voltage_v.rotate_left(2);
    let test = friction(&bench.recorded(), &Options::default()).unwrap();
    let delay = test.delay_s().unwrap();
    assert!((delay.value - 0.002).abs() < 0.0005, "{delay:?}");
    let off = coulomb(&test, &truth).value / parameters.friction.coulomb_nm - 1.0;
    assert!(off.abs() < 0.10, "{off}");
}

/// Without viscous friction the slope is the back-emf and the resistance alone makes newton metres; with it, it must not be used.
#[test]
fn the_resistance_alone_is_enough_where_nothing_is_viscous() {
    let parameters = RigParameters::default();
    let bench = runs_of(&parameters, 4);
    let test = friction(&bench.recorded(), &Options::default()).unwrap();
    let motor = Motor::NoViscous { R_ohm: parameters.physical.R_ohm };
    let g = test.torque_per_volt(&motor);
    assert!((g.value / parameters.physical.torque_per_volt() - 1.0).abs() < 0.01, "{g:?}");
    let off = test.coulomb_nm(&motor).unwrap().value / parameters.friction.coulomb_nm - 1.0;
    assert!(off.abs() < 0.10, "{off}");
    assert_eq!(test.viscous(&motor).value, 0.0);
}

/// What a recording lacks is said: no cut, no second speed, one direction, a hub that stands, a sample that is no number.
#[test]
fn what_a_recording_lacks_is_said() {
    let parameters = RigParameters::default();
    let of = |voltages: Vec<f64>| Bench::of(&mut SimulatedRig::new(&parameters, 1).unwrap(), voltages);
    let steps = |levels: &[f64]| levels.iter().flat_map(|&v| std::iter::repeat_n(v, 1200)).collect::<Vec<f64>>();
    let ask = |bench: &Bench| friction(&bench.recorded(), &Options::default());

    // From run to run without a rest: the sums are there, the parts are not.
    let uncut = ask(&of(steps(&[0.6, -0.4, 1.0, -0.8, 1.4, -1.2, 0.8, -0.6]))).unwrap();
    assert!(matches!(uncut.together, Some(Error::NoCoast { forward: 0, backward: 0, .. })), "{:?}", uncut.together);
    assert!(uncut.coulomb_plus_v().is_none());
    assert!((uncut.dry_plus_v().value - 0.28).abs() < 0.01, "{:?}", uncut.dry_plus_v());

    let forward = ask(&of(steps(&[0.6, 0.0, 1.0, 0.0, 1.4, 0.0])));
    assert_eq!(forward.unwrap_err(), Error::TooFewRuns { direction: "backward", found: 0, needed: 3 });
    let still = ask(&of(steps(&[0.1, 0.0, -0.05, 0.0])));
    assert_eq!(still.unwrap_err(), Error::TooFewRuns { direction: "forward", found: 0, needed: 3 });
    let alike = ask(&of(steps(&[0.60, -0.42, 0.61, -0.43, 0.62, -0.44])));
    assert!(matches!(alike.unwrap_err(), Error::OneSpeed { .. }));

    let mut broken = runs_of(&parameters, 1);
    broken.alpha_rad[77] = f64::NAN;
    assert!(matches!(ask(&broken).unwrap_err(), Error::NotFinite { sample: 77, .. }));
    broken.alpha_rad.pop();
    assert!(matches!(ask(&broken).unwrap_err(), Error::Length { .. }));
    let coarse = Bench { period_s: 0.02, ..runs_of(&parameters, 1) };
    assert!(matches!(ask(&coarse).unwrap_err(), Error::Setting { .. }));
    let refused = Plan { travel_rad: 0.1, ..Plan::default() }.runs(
        &Pilot { plus_v: 0.3, minus_v: 0.1, slope_v_s: 0.5 },
        0.001,
        &Options::default(),
    );
    assert!(matches!(refused.unwrap_err(), Error::Setting { found: 0.1, .. }));
}
