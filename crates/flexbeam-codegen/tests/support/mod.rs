//! Controllers to write, ticks to run them through, compilers. Each test file uses a part of it.
#![allow(dead_code)]

use flexbeam_codegen::{Name, Options, Precision, Sources, Subject, c, rounded, rust};
use flexbeam_files::{Controller, Document};
use flexbeam_kernel::{self as kernel, Channel, Commanded, Fault, Law, Measured, Settings, State, tick};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

pub const WARNINGS: [&str; 6] = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"];
pub const SHA256: &str = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

/// The controller of `flexbeam reproduce --seed 1`.
pub fn reproduced() -> Controller {
    Controller::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/reproduce.toml")).unwrap()
}

/// Random numbers with a stable A: rows of absolute sum 0.97, B, C and D full.
pub fn random(order: usize) -> Controller {
    let mut random = ChaCha8Rng::seed_from_u64(order as u64);
    let mut rows = |rows: usize, columns: usize, size: f64| -> Vec<Vec<f64>> {
        let mut row = || (0..columns).map(|_| random.random_range(-size..size)).collect();
        (0..rows).map(|_| row()).collect()
    };
    let mut controller = reproduced();
    controller.order = order;
    controller.certificate.controller_order = order;
    controller.A.0 = rows(order, order, 1.0);
    for row in &mut controller.A.0 {
        let sum: f64 = row.iter().map(|x| x.abs()).sum();
        row.iter_mut().for_each(|x| *x *= 0.97 / sum);
    }
    controller.B.0 = rows(order, 3, 0.2);
    controller.C.0 = rows(2, order, 3.0);
    controller.D.0 = rows(2, 2, 4.0);
    controller.settings = flexbeam_files::Settings::default();
    controller
}

/// The settings that these controllers start with: a key that is left out has the kernel's default.
pub fn settings_of(controller: &Controller) -> Settings {
    let (table, own) = (&controller.settings, Settings::default());
    let channel = |c: &Option<flexbeam_files::Channel>| {
        let c = c.clone().unwrap_or_default();
        Channel {
            scale: c.scale.unwrap_or(1.0),
            offset_rad: c.offset_rad.unwrap_or(0.0),
            low_pass: c.low_pass.unwrap_or(1.0),
        }
    };
    Settings {
        theta: channel(&table.theta),
        alpha: channel(&table.alpha),
        smooth_ticks: table.smooth_ticks.unwrap_or(own.smooth_ticks),
        smooth_step_rad: table.smooth_step_rad.unwrap_or(own.smooth_step_rad),
        u_p_plus_v: table.u_p_plus_v.unwrap_or(own.u_p_plus_v),
        u_p_minus_v: table.u_p_minus_v.unwrap_or(own.u_p_minus_v),
        eps_u_v: table.eps_u_v.unwrap_or(own.eps_u_v),
        voltage_limit_v: table.voltage_limit_v.unwrap_or(own.voltage_limit_v),
        ..own
    }
}

pub enum Language {
    C,
    Rust,
}

pub fn sources(controller: &Controller, precision: Precision, language: &Language) -> Sources {
    let settings = settings_of(controller);
    let figures = &controller.certificate.sampled;
    let subject = Subject { controller, settings: &settings, sha256: SHA256, figures, unverified: None };
    let options = Options { name: Name::new("beam").unwrap(), precision };
    match language {
        Language::C => c::sources(&subject, &options).unwrap(),
        Language::Rust => rust::sources(&subject, &options).unwrap(),
    }
}

/// A folder of the test's own, with the files in it.
pub fn written(name: &str, sources: &Sources) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    for file in &sources.files {
        let path = folder.join(&file.path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, &file.text).unwrap();
    }
    folder
}

/// A text of this folder with the controller's name in it.
pub fn named(text: &str) -> String {
    text.replace("NAME", "beam").replace("UPPER", "BEAM")
}

pub fn run(program: impl AsRef<std::ffi::OsStr>, arguments: &[&str], folder: &Path) -> Output {
    let mut command = Command::new(&program);
    command.args(arguments).current_dir(folder);
    command.output().unwrap_or_else(|error| panic!("{:?}: {error}", program.as_ref()))
}

/// Standard output of a program that must succeed.
pub fn succeeds(program: impl AsRef<std::ffi::OsStr>, arguments: &[&str], folder: &Path) -> String {
    let output = run(&program, arguments, folder);
    let said = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{:?} {arguments:?} in {}: {said}", program.as_ref(), folder.display());
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Compiles files of the folder, all warnings being errors.
pub fn compile(compiler: &str, flags: &[&str], files: &[&str], output: &str, folder: &Path) -> PathBuf {
    let arguments: Vec<&str> = WARNINGS
        .iter()
        .chain(&["-ffp-contract=off"])
        .chain(flags)
        .chain(files)
        .chain(&["-o", output])
        .copied()
        .collect();
    succeeds(compiler, &arguments, folder);
    folder.join(output)
}

/// Numbers of a controller as the kernel takes them, in a precision.
pub struct Kernel {
    pub order: usize,
    pub coefficients: Vec<f64>,
}

impl Kernel {
    pub fn of(controller: &Controller, precision: Precision) -> Kernel {
        let settings = settings_of(controller);
        let used = match precision {
            Precision::F64 => controller.clone(),
            Precision::F32 => rounded(controller, &settings).unwrap().0,
        };
        Kernel { order: used.order, coefficients: used.coefficients() }
    }
}

/// What a file of ticks visits, by name.
pub type Visits = BTreeMap<&'static str, usize>;

/// Ticks to run through: numbers of every size, and loops that look like a beam's.
pub fn write_ticks(path: &Path, kernel: &Kernel, precision: Precision, ticks: usize) -> Visits {
    let mut random = ChaCha8Rng::seed_from_u64(64);
    let nearest = |x: f64| if precision == Precision::F32 { f64::from(x as f32) } else { x };
    let choices: Vec<Settings> = (0..64).map(|k| random_settings(&mut random, k, &nearest)).collect();
    let mut out = BufWriter::with_capacity(1 << 20, std::fs::File::create(path).unwrap());
    let mut put = |numbers: &[f64]| numbers.iter().for_each(|x| out.write_all(&x.to_le_bytes()).unwrap());
    put(&[choices.len() as f64]);
    choices.iter().for_each(|s| put(&row_of(s)));
    let controller = kernel::Controller::new(kernel.order, &kernel.coefficients).unwrap();
    let mut memory = vec![0.0; controller.state_len()];
    let mut state = State::new(&controller, &mut memory).unwrap();
    let mut walk = Walk { theta: 0.0, alpha: 0.0, reference: 0.0, choice: 0 };
    let mut visits = Visits::new();
    for k in 0..ticks {
        let changed = walk.step(&mut random);
        let reset = k == 0 || (state.fault() != Fault::None && random.random_bool(0.1)) || random.random_bool(1e-4);
        if reset {
            state.reset();
        }
        let measured = walk.measured(&mut random, &nearest);
        let settings = &choices[walk.choice];
        let c = tick(settings, &controller, &mut state, measured);
        note(&mut visits, settings, &c, reset, changed);
        let answers =
            [c.voltage_v, c.u_v, c.reference_rad, c.y_rad, c.y_model_rad, c.error_rad, f64::from(c.fault as u8)];
        put(&[
            walk.choice as f64,
            f64::from(u8::from(reset)),
            measured.reference_rad,
            measured.theta_rad,
            measured.alpha_rad,
        ]);
        put(&answers);
    }
    visits
}

/// Asserts that nothing was left out.
pub fn assert_visited(visits: &Visits, ticks: usize) {
    let names = ["saturated", "dead", "compensated", "smooth", "changed", "reset"];
    for name in names.into_iter().chain(["Deflection", "Angle", "Speed", "NonFinite"]) {
        let count = visits.get(name).copied().unwrap_or(0);
        assert!(count >= ticks / 5000, "{name}: {count} of {ticks} ticks; {visits:?}");
    }
}

fn note(visits: &mut Visits, settings: &Settings, c: &Commanded, reset: bool, changed: bool) {
    let mut add = |name, when: bool| *visits.entry(name).or_default() += usize::from(when);
    let runs = c.fault == Fault::None;
    add("saturated", runs && c.voltage_v.abs() == settings.voltage_limit_v);
    add("dead", runs && settings.law == Law::Switched && c.voltage_v != c.u_v);
    add("compensated", runs && settings.law == Law::Inverse && c.voltage_v != c.u_v);
    add("smooth", runs && settings.smooth_ticks > 1.0);
    add("changed", changed);
    add("reset", reset);
    add("Deflection", c.fault == Fault::Deflection);
    add("Angle", c.fault == Fault::Angle);
    add("Speed", c.fault == Fault::Speed);
    add("NonFinite", c.fault == Fault::NonFinite);
}

/// Angles and a reference on their way.
struct Walk {
    theta: f64,
    alpha: f64,
    reference: f64,
    choice: usize,
}

impl Walk {
    /// Returns whether the settings changed.
    fn step(&mut self, random: &mut ChaCha8Rng) -> bool {
        self.theta = 0.999 * self.theta + random.random_range(-0.01..0.01);
        self.alpha = 0.99 * self.alpha + random.random_range(-0.005..0.005);
        if random.random_bool(0.005) {
            self.reference = random.random_range(-1.0..1.0) * [1.0, 0.01][usize::from(random.random_bool(0.5))];
        }
        let changes = random.random_bool(0.01);
        if changes {
            self.choice = random.random_range(0..64);
        }
        changes
    }

    fn measured(&self, random: &mut ChaCha8Rng, nearest: &impl Fn(f64) -> f64) -> Measured {
        let mut odd = |x: f64| match random.random_range(0..20_000) {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => f64::NEG_INFINITY,
            3 => -0.0,
            4 => 1e-310,
            5 => -1e-41,
            6 => 3e37,
            7 => -1e38,
            8 => 1e300,
            9..20 => x + 0.7,
            _ => x,
        };
        let [reference_rad, theta_rad, alpha_rad] =
            [odd(self.reference), odd(self.theta), odd(self.alpha)].map(nearest);
        Measured { reference_rad, theta_rad, alpha_rad }
    }
}

/// Sensible in most fields, senseless in some.
fn random_settings(random: &mut ChaCha8Rng, k: usize, nearest: &impl Fn(f64) -> f64) -> Settings {
    let mut within = |low: f64, high: f64| nearest(random.random_range(low..high));
    let mut channel = || Channel {
        scale: within(0.9, 1.1),
        offset_rad: within(-0.01, 0.01),
        low_pass: if k.is_multiple_of(4) { 1.0 } else { within(0.1, 1.0) },
    };
    let (theta, alpha) = (channel(), channel());
    let strange = [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-38];
    let odd = |each: usize, at: usize, x: f64| if k % each == at { strange[(k / each) % strange.len()] } else { x };
    Settings {
        theta,
        alpha,
        smooth_ticks: if k.is_multiple_of(3) { 0.0 } else { odd(31, 1, within(2.0, 300.0)) },
        smooth_step_rad: odd(17, 3, within(0.1, 1.0)),
        law: [Law::None, Law::Switched, Law::Inverse][k % 3],
        u_p_plus_v: within(0.0, 0.4),
        u_p_minus_v: within(0.0, 0.4),
        eps_u_v: odd(13, 5, within(0.01, 0.5)),
        eps_e_rad: odd(19, 7, within(0.001, 0.02)),
        hysteresis_u: within(0.0, 0.5),
        hysteresis_e: within(0.0, 1.0),
        breakaway_plus_v: within(0.0, 0.4),
        breakaway_minus_v: within(0.0, 0.4),
        voltage_limit_v: odd(23, 9, if k.is_multiple_of(2) { within(0.2, 2.0) } else { 10.0 }),
        deflection_limit_rad: odd(29, 11, within(0.3, 0.6)),
        theta_limit_rad: odd(37, 13, within(0.8, 2.0)),
        theta_step_limit_rad: odd(41, 15, within(0.1, 0.6)),
    }
}

fn row_of(s: &Settings) -> [f64; 21] {
    [
        s.theta.scale,
        s.theta.offset_rad,
        s.theta.low_pass,
        s.alpha.scale,
        s.alpha.offset_rad,
        s.alpha.low_pass,
        s.smooth_ticks,
        s.smooth_step_rad,
        f64::from(s.law as u8),
        s.u_p_plus_v,
        s.u_p_minus_v,
        s.eps_u_v,
        s.eps_e_rad,
        s.hysteresis_u,
        s.hysteresis_e,
        s.breakaway_plus_v,
        s.breakaway_minus_v,
        s.voltage_limit_v,
        s.deflection_limit_rad,
        s.theta_limit_rad,
        s.theta_step_limit_rad,
    ]
}
