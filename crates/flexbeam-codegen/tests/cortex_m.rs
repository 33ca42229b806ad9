//! Generated C on a Cortex-M that qemu simulates, in closed loop with the nominal beam: the bits of the host and of the kernel, and
//! a table of instructions a tick, stack and code. The stack is painted, and counted from what compiler and disassembler say.

#[path = "support/frames.rs"]
mod frames;
mod support;

use flexbeam_codegen::Precision;
use flexbeam_kernel::{self as kernel, Fault, Law, Measured, Settings, State, tick};
use frames::Frames;
use std::path::Path;
use support::{Kernel, Language, WARNINGS, compile, named, reproduced, run, settings_of, sources, succeeds, written};

/// A board of qemu's, and how to compile for it.
struct Board {
    name: &'static str,
    machine: &'static str,
    flags: &'static [&'static str],
}

const BOARDS: [Board; 3] = [
    Board { name: "Cortex-M3, no FPU", machine: "mps2-an385", flags: &["-mcpu=cortex-m3", "-mfloat-abi=soft"] },
    Board {
        name: "Cortex-M4F, FPU for f32",
        machine: "mps2-an386",
        flags: &["-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"],
    },
    Board {
        name: "Cortex-M7, FPU for f64",
        machine: "mps2-an500",
        flags: &["-mcpu=cortex-m7", "-mfloat-abi=hard", "-mfpu=fpv5-d16"],
    },
];

/// -fstack-usage does not count the part of a structure that came in registers and is put back on the stack.
const PUT_BACK: u64 = 8;

/// Bytes of the frames that these ticks wrote nothing to, at most: those of a fault, and what is called for one.
const UNWRITTEN: u64 = 64;

/// What a board says.
struct Ran {
    sum: String,
    instructions: u64,
    stack: u64,
    /// What the compiler says of the tick's own frame.
    usage: u64,
    /// The same by the disassembly.
    own: u64,
    /// Of the deepest routine that it calls, by the disassembly.
    below: u64,
    code: u64,
}

fn on_board(board: &Board, folder: &Path) -> Ran {
    let mut arguments: Vec<&str> = WARNINGS.to_vec();
    arguments.extend(["-O2", "-ffp-contract=off", "-mthumb", "-ffunction-sections", "-fdata-sections"]);
    arguments.extend(board.flags);
    let mut object = arguments.clone();
    object.extend(["-fstack-usage", "-c", "beam.c", "-o", "beam_arm.o"]);
    succeeds("arm-none-eabi-gcc", &object, folder);
    let usage = stack_usage(folder, "beam_arm.su", "beam_tick");
    let size = succeeds("arm-none-eabi-size", &["beam_arm.o"], folder);
    let code = size.lines().nth(1).and_then(|line| line.split_whitespace().next()?.parse().ok()).expect("a size");
    // The start of a board reads and writes what the linker names, and writes by register: no -Wpedantic there.
    arguments.retain(|flag| !["-std=c99", "-Wpedantic"].contains(flag));
    arguments.extend([
        "-DON_BOARD",
        "-fstack-usage",
        "beam_arm.o",
        "main.c",
        "board.c",
        "-T",
        "board.ld",
        "-nostartfiles",
    ]);
    arguments.extend(["--specs=nosys.specs", "-Wl,--gc-sections", "-o", "beam.elf"]);
    succeeds("arm-none-eabi-gcc", &arguments, folder);
    for painter in ["board_paint", "board_count", "board_stack_used"] {
        assert_eq!(stack_usage(folder, "beam.elf-board.su", painter), 0, "{painter} paints over itself");
    }
    let frames = Frames::of_arm(&succeeds("arm-none-eabi-objdump", &["-d", "beam.elf"], folder));
    let own = frames.own("beam_tick");
    assert!([own, own - PUT_BACK].contains(&usage), "{}: {own} bytes, -fstack-usage says {usage}", board.name);
    let machine =
        ["-M", board.machine, "-display", "none", "-monitor", "none", "-serial", "none", "-icount", "shift=0"];
    let semihosting = ["-semihosting-config", "enable=on,target=native", "-kernel", "beam.elf"];
    let output = run("timeout", &[&["60", "qemu-system-arm"], &machine[..], &semihosting].concat(), folder);
    let said = String::from_utf8_lossy(&output.stderr); // where qemu puts a board's words
    assert!(output.status.success(), "{}: {said}", board.name);
    let value = |name: &str| -> String {
        let line = said.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '));
        line.unwrap_or_else(|| panic!("{name} in {said}")).to_owned()
    };
    let number = |name: &str| value(name).parse().expect("a number");
    Ran {
        sum: value("sum"),
        instructions: number("instructions"),
        stack: number("stack"),
        usage,
        own,
        below: frames.below("beam_tick"),
        code,
    }
}

/// What -fstack-usage says of a function that takes the same bytes always.
fn stack_usage(folder: &Path, file: &str, function: &str) -> u64 {
    let text = std::fs::read_to_string(folder.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
    let line = text.lines().find(|line| line.contains(&format!(":{function}\t"))).expect("the function");
    let words: Vec<&str> = line.split('\t').collect();
    assert_eq!(words[2], "static", "{line}");
    words[1].parse().expect("bytes")
}

/// The same loop around the kernel; see main.c.
fn sum_of_kernel() -> String {
    let file = reproduced();
    let kernel = Kernel::of(&file, Precision::F64);
    let controller = kernel::Controller::new(kernel.order, &kernel.coefficients).unwrap();
    let mut memory = vec![0.0; controller.state_len()];
    let mut state = State::new(&controller, &mut memory).unwrap();
    let (mut theta, mut alpha, mut theta_rate, mut alpha_rate) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    let mut sum = 0xCBF2_9CE4_8422_2325_u64;
    let mut add = |x: f64| {
        for byte in x.to_bits().to_le_bytes() {
            sum = (sum ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3);
        }
    };
    for k in 0..1500 {
        let law = if k < 1000 { Law::Inverse } else { Law::Switched };
        let settings = Settings { voltage_limit_v: 5.0, law, ..settings_of(&file) };
        let reference_rad = if k < 500 { 0.5 } else { -0.25 };
        let c =
            tick(&settings, &controller, &mut state, Measured { reference_rad, theta_rad: theta, alpha_rad: alpha });
        assert_eq!(c.fault, Fault::None, "the loop that is compared runs");
        let numbers = [c.voltage_v, c.u_v, c.reference_rad, c.y_rad, c.y_model_rad, c.error_rad];
        numbers.into_iter().for_each(&mut add);
        add(0.0);
        for _ in 0..8 {
            let h = 0.001 / 8.0;
            let theta_acceleration = 1060.8 * alpha - 57.7 * theta_rate + 107.39 * c.voltage_v;
            let alpha_acceleration = -1465.2 * alpha + 57.7 * theta_rate - 107.39 * c.voltage_v;
            theta += h * theta_rate;
            alpha += h * alpha_rate;
            theta_rate += h * theta_acceleration;
            alpha_rate += h * alpha_acceleration;
        }
    }
    add(theta);
    add(alpha);
    format!("{sum:x}")
}

#[test]
fn a_cortex_m_computes_the_host_s_bits() {
    let texts = [
        ("main.c", include_str!("cortex_m/main.c")),
        ("board.c", include_str!("cortex_m/board.c")),
        ("board.h", include_str!("cortex_m/board.h")),
        ("board.ld", include_str!("cortex_m/board.ld")),
    ];
    println!(
        "| processor | precision | instructions a tick | stack, painted | -fstack-usage | disassembly | code and constants [bytes] |\n\
         |---|---|---|---|---|---|---|"
    );
    for precision in [Precision::F64, Precision::F32] {
        let folder = written(&format!("cortex_m_{precision:?}"), &sources(&reproduced(), precision, &Language::C));
        for (name, text) in texts {
            std::fs::write(folder.join(name), named(text)).unwrap();
        }
        let host = compile("gcc", &["-O2"], &["beam.c", "main.c"], "host", &folder);
        let needed = succeeds(host, &[], &folder).trim().replace("sum ", "");
        if precision == Precision::F64 {
            assert_eq!(needed, sum_of_kernel());
        }
        for board in &BOARDS {
            let ran = on_board(board, &folder);
            assert_eq!(ran.sum, needed, "{}, {precision:?}", board.name);
            assert!(
                ran.instructions > 300 && ran.stack < 2048,
                "{} instructions, {} bytes",
                ran.instructions,
                ran.stack
            );
            let Ran { instructions, stack, usage, own, below, code, .. } = ran;
            assert!(stack <= own + below && stack + UNWRITTEN >= own + below, "{stack} of {own} + {below} bytes");
            println!(
                "| {} | {precision:?} | {instructions} | {stack} | {usage} | {own} + {below} | {code} |",
                board.name
            );
        }
    }
}
