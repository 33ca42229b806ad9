//! Instructions of one tick, counted by callgrind: the kernel, the generated C, the generated Rust, the functional mock-up unit; and of one
//! period of the rig: flexbeam-rig, the generated C. Counts do not depend on how busy the machine is.
//!
//! Prints two tables. Needs valgrind, gcc, clang and rustc.

#[path = "../tests/support/mod.rs"]
mod support;

use flexbeam_codegen::fmu::{SOURCES, Version, unit};
use flexbeam_codegen::{Name, Precision, RigSubject, Sources, Subject, rig_sources};
use flexbeam_files::Controller;
use flexbeam_kernel::{Commanded, Controller as Kernel, Fault, Measured, Settings, State, tick};
use flexbeam_rig::{Link, RigParameters, SimulatedRig};
use std::path::Path;
use std::process::Command;
use support::{Language, SHA256, compile, named, random, settings_of, sources, succeeds, written};

const ORDERS: [usize; 3] = [8, 16, 32];
const TICKS: u64 = 2000;

/// Of the rig's link; 0: lumped.
const MODES: [usize; 3] = [0, 3, 8];

/// Likewise, for the rig.
const COUNTED_MODES: &str = "FLEXBEAM_COUNTED_MODES";

/// Names the order when this program runs under callgrind, as the one that is counted.
const COUNTED: &str = "FLEXBEAM_COUNTED_ORDER";

fn main() {
    if let Ok(order) = std::env::var(COUNTED) {
        return run_kernel(&controller(order.parse().expect("an order")));
    }
    if let Ok(modes) = std::env::var(COUNTED_MODES) {
        return run_rig(&rig(modes.parse().expect("a number of modes")));
    }
    if Command::new("valgrind").arg("--version").output().is_err() {
        eprintln!(
            "tried to count instructions, found no valgrind, needed it\nhint: apt-get install valgrind, or cargo xtask bench, which installs what is missing"
        );
        std::process::exit(2);
    }
    println!("\n| instructions a tick (and for each multiply-add) | n = 8 | n = 16 | n = 32 |\n|---|---|---|---|");
    row("kernel, rustc opt-level 3", |order| {
        let itself = std::env::current_exe().expect("the program that runs");
        let program = [itself.to_string_lossy()];
        counted(
            Command::new("valgrind").env(COUNTED, order.to_string()),
            COUNTED_TICK,
            &program.each_ref().map(|p| &**p),
        )
    });
    for (compiler, flag) in [("gcc", "-O2"), ("gcc", "-O3"), ("clang", "-O2")] {
        row(&format!("C, {compiler} {flag}"), |order| {
            let folder = generated(order, &Language::C);
            std::fs::write(folder.join("count.c"), named(C)).expect("written");
            let program = compile(compiler, &[flag], &["beam.c", "count.c"], "count", &folder);
            counted(&mut Command::new("valgrind"), COUNTED_TICK, &[&program.to_string_lossy()])
        });
    }
    row("Rust, rustc opt-level 3", |order| {
        let folder = generated(order, &Language::Rust);
        std::fs::write(folder.join("count.rs"), named(RUST)).expect("written");
        let flags = ["--edition", "2021", "-C", "opt-level=3"];
        let library = ["--crate-type", "rlib", "--crate-name", "beam", "src/lib.rs"];
        succeeds("rustc", &[&flags[..], &library].concat(), &folder);
        let program = ["--extern", "beam=libbeam.rlib", "count.rs", "-o", "count"];
        succeeds("rustc", &[&flags[..], &program].concat(), &folder);
        counted(&mut Command::new("valgrind"), COUNTED_TICK, &[&folder.join("count").to_string_lossy()])
    });
    for version in [Version::Two, Version::Three] {
        for (what, function) in [("set, step, get", COUNTED_TICK), ("the tick in it", "beam_step")] {
            row(&format!("FMU {}, gcc -O2: {what}", number(version)), |order| {
                let (program, guid) = unit_in_host(order, version);
                counted(&mut Command::new("valgrind"), function, &[&program.to_string_lossy(), &guid])
            });
        }
    }
    rigs();
}

/// What is counted: in each program the function that ticks once.
const COUNTED_TICK: &str = "*counted_tick*";

fn number(version: Version) -> &'static str {
    if version == Version::Two { "2.0" } else { "3.0" }
}

/// A host linked with the unit's library, which is built as `flexbeam export` builds it, but with its symbols; and its token.
fn unit_in_host(order: usize, version: Version) -> (std::path::PathBuf, String) {
    let (file, name) = (controller(order), Name::new("beam").expect("a name"));
    let (settings, figures) = (settings_of(&file), &file.certificate.sampled);
    let subject = Subject { controller: &file, settings: &settings, sha256: SHA256, figures, unverified: None };
    let unit = unit(&subject, &name, version).expect("a unit");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("unit_{}_{order}", number(version)));
    std::fs::create_dir_all(&folder).expect("a folder");
    for (path, text) in unit.files.iter().filter_map(|f| Some((f.path.strip_prefix(SOURCES)?, &f.text))) {
        std::fs::write(folder.join(path), text).expect("written");
    }
    let interface = if version == Version::Two { include_str!("fmu/host_2.c") } else { include_str!("fmu/host_3.c") };
    let host =
        [("host.h", include_str!("fmu/host.h")), ("host.c", include_str!("fmu/host.c")), ("interface.c", interface)];
    for (path, text) in host {
        std::fs::write(folder.join(path), text).expect("written");
    }
    let compiled: Vec<&str> = unit.compiled.iter().map(String::as_str).collect();
    compile("gcc", &["-O2", "-fPIC", "-shared", "-fvisibility=hidden"], &compiled, "libbeam.so", &folder);
    let program =
        compile("gcc", &["-O2", "-Wl,-rpath,$ORIGIN"], &["host.c", "interface.c", "-L.", "-lbeam"], "host", &folder);
    let description = unit.files.iter().find(|file| file.path == "modelDescription.xml").expect("a description");
    let guid = description.text.split('"').find(|text| text.starts_with('{')).expect("a token");
    (program, guid.to_owned())
}

fn rigs() {
    println!("\n| instructions a period (and for each multiply-add) | lumped | 3 modes | 8 modes |\n|---|---|---|---|");
    rig_row("flexbeam-rig, rustc opt-level 3", |modes| {
        let itself = std::env::current_exe().expect("the program that runs");
        counted(
            Command::new("valgrind").env(COUNTED_MODES, modes.to_string()),
            COUNTED_TICK,
            &[&itself.to_string_lossy()],
        )
    });
    for (compiler, flag) in [("gcc", "-O2"), ("gcc", "-O3"), ("clang", "-O2")] {
        rig_row(&format!("C, {compiler} {flag}"), |modes| {
            let subject = RigSubject { parameters: &rig(modes), sha256: None };
            let files = rig_sources(&subject, &Name::new("beam").expect("a name")).expect("a rig");
            let folder = written(&format!("instructions_rig_{modes}"), &Sources { files: files.into(), single: None });
            std::fs::write(folder.join("count.c"), named(RIG_C)).expect("written");
            let program = compile(compiler, &[flag], &["beam.c", "count.c"], "count", &folder);
            counted(&mut Command::new("valgrind"), COUNTED_TICK, &[&program.to_string_lossy()])
        });
    }
}

/// Of a period in which nothing changes: substeps of the whole state.
fn rig_row(name: &str, count: impl Fn(usize) -> u64) {
    let cells = MODES.map(|modes| {
        let n = 2 + 2 * modes.max(1);
        let (instructions, multiply_adds) = (count(modes), 4 * n * (n + 1));
        format!("{instructions} ({:.2})", instructions as f64 / multiply_adds as f64)
    });
    println!("| {name} | {} |", cells.join(" | "));
}

fn rig(modes: usize) -> RigParameters {
    let default = RigParameters::default();
    let Link::Modes { damping, tip_mass_kg, .. } = default.link else { unreachable!("the default link has modes") };
    let link = if modes == 0 { Link::Lumped } else { Link::Modes { count: modes, damping, tip_mass_kg } };
    RigParameters { link, ..default }
}

/// There and back, as the program in C does.
fn run_rig(parameters: &RigParameters) {
    let mut rig = SimulatedRig::new(parameters, 1).expect("a rig");
    for k in 0..TICKS {
        let voltage_v = if (k / 250).is_multiple_of(2) { 3.0 } else { -3.0 };
        assert!(counted_tick_of_rig(&mut rig, voltage_v).is_finite());
    }
}

#[inline(never)]
fn counted_tick_of_rig(rig: &mut SimulatedRig, voltage_v: f64) -> f64 {
    let read = rig.measure();
    rig.apply(std::hint::black_box(voltage_v));
    read.alpha_rad
}

fn row(name: &str, count: impl Fn(usize) -> u64) {
    let cells = ORDERS.map(|order| {
        let (instructions, multiply_adds) = (count(order), order * (order + 3) + 2 * (order + 2));
        format!("{instructions} ({:.2})", instructions as f64 / multiply_adds as f64)
    });
    println!("| {name} | {} |", cells.join(" | "));
}

/// Random, with every part of the tick at work.
fn controller(order: usize) -> Controller {
    let mut controller = random(order);
    controller.settings.u_p_plus_v = Some(0.28);
    controller.settings.u_p_minus_v = Some(0.1);
    controller.settings.smooth_ticks = Some(300.0);
    controller
}

fn generated(order: usize, language: &Language) -> std::path::PathBuf {
    written(&format!("instructions_{order}"), &sources(&controller(order), Precision::F64, language))
}

/// Instructions of one tick of a program that runs `function` 2000 times.
fn counted(valgrind: &mut Command, function: &str, program: &[&str]) -> u64 {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let tool = ["--tool=callgrind", "--callgrind-out-file=/dev/null", &format!("--toggle-collect={function}")];
    let output = valgrind.args(tool).args(program).current_dir(folder).output().expect("valgrind starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let line = said.lines().find_map(|line| line.split_once("Collected :"));
    let all: u64 =
        line.and_then(|(_, number)| number.trim().parse().ok()).unwrap_or_else(|| panic!("no count in {said}"));
    assert!(all > 100 * TICKS, "the tick was found: {said}");
    all / TICKS
}

/// As the two programs below.
fn run_kernel(file: &Controller) {
    let (coefficients, settings) = (file.coefficients(), settings_of(file));
    let controller = Kernel::new(file.order, &coefficients).expect("a controller");
    let mut memory = vec![0.0; controller.state_len()];
    let mut state = State::new(&controller, &mut memory).expect("its memory");
    for k in 0..TICKS {
        let reference_rad = if (k / 500).is_multiple_of(2) { 0.5 } else { -0.5 };
        let measured = Measured { reference_rad, theta_rad: 0.3 * reference_rad, alpha_rad: 0.01 };
        let commanded = counted_tick(&settings, &controller, &mut state, measured);
        assert_eq!(commanded.fault, Fault::None, "the loop that is counted runs");
    }
}

#[inline(never)]
fn counted_tick(settings: &Settings, controller: &Kernel<'_>, state: &mut State<'_>, measured: Measured) -> Commanded {
    tick(settings, controller, state, std::hint::black_box(measured))
}

const C: &str = r#"
#include "NAME.h"

__attribute__((noinline)) struct NAME_commanded counted_tick(struct NAME_state *state, struct NAME_measured measured);

struct NAME_commanded counted_tick(struct NAME_state *state, struct NAME_measured measured)
{
    return NAME_tick(&NAME_default_settings, state, measured);
}

int main(void)
{
    static struct NAME_state state;
    NAME_reset(&state);
    for (int k = 0; k < 2000; ++k) {
        const double reference = k / 500 % 2 == 0 ? 0.5 : -0.5;
        const struct NAME_measured measured = {reference, 0.3 * reference, 0.01};
        if (counted_tick(&state, measured).fault != UPPER_FAULT_NONE) {
            return 1;
        }
    }
    return 0;
}
"#;

const RUST: &str = r#"
use NAME::{Commanded, DEFAULT_SETTINGS, Fault, Measured, State, tick};

#[inline(never)]
fn counted_tick(state: &mut State, measured: Measured) -> Commanded {
    tick(&DEFAULT_SETTINGS, state, std::hint::black_box(measured))
}

fn main() {
    let mut state = State::new();
    for k in 0..2000 {
        let reference_rad = if k / 500 % 2 == 0 { 0.5 } else { -0.5 };
        let measured = Measured { reference_rad, theta_rad: 0.3 * reference_rad, alpha_rad: 0.01 };
        assert_eq!(counted_tick(&mut state, measured).fault, Fault::None);
    }
}
"#;

const RIG_C: &str = r#"
#include "NAME.h"

__attribute__((noinline)) double counted_tick(struct NAME_state *state, double voltage);

double counted_tick(struct NAME_state *state, double voltage)
{
    const struct NAME_measurement read = NAME_measure(&NAME_default_parameters, state);
    NAME_apply(&NAME_default_parameters, state, voltage);
    return read.alpha_rad;
}

int main(void)
{
    static struct NAME_state state;
    NAME_reset(&NAME_default_parameters, &state, 1);
    for (int k = 0; k < 2000; ++k) {
        const double read = counted_tick(&state, k / 250 % 2 == 0 ? 3.0 : -3.0);
        if (read != read) {
            return 1;
        }
    }
    return 0;
}
"#;
