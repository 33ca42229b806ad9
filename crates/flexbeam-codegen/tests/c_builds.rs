//! Generated C as people build it: no warnings, clean under the sanitizers, its own test, make and CMake; a build that contracts is
//! found by the self-check.

mod support;

use flexbeam_codegen::Precision;
use support::{Language, WARNINGS, compile, random, reproduced, run, sources, succeeds, written};

const COMPILERS: [&str; 2] = ["gcc", "clang"];
const TEST: [&str; 3] = ["beam.c", "test_beam.c", "test_vectors.c"];

#[test]
fn its_own_test_passes_in_both_precisions_under_the_sanitizers() {
    for precision in [Precision::F64, Precision::F32] {
        for (controller, name) in [(random(0), "builds_0"), (reproduced(), "builds_reproduced")] {
            let folder = written(&format!("{name}_{precision:?}"), &sources(&controller, precision, &Language::C));
            for compiler in COMPILERS {
                let sanitize = ["-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
                let program = compile(compiler, &sanitize, &TEST, "test_beam", &folder);
                assert!(succeeds(&program, &[], &folder).contains("every bit"));
                compile(compiler, &["-O2"], &["main_udp.c", "flexbeam_frame.c", "beam.c"], "main_udp", &folder);
            }
        }
    }
}

/// What makes a compiler fuse products and sums on this machine; nothing, and loudly so, where it cannot.
fn fused() -> Option<&'static [&'static str]> {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("fma") {
        return Some(&["-ffp-contract=fast", "-mfma"]);
    }
    #[cfg(target_arch = "aarch64")]
    return Some(&["-ffp-contract=fast"]);
    #[allow(unreachable_code)]
    {
        eprintln!("\n!!! LEFT OUT: this processor cannot contract products and sums !!!\n");
        None
    }
}

#[test]
fn a_build_that_contracts_is_found() {
    let Some(fused) = fused() else { return };
    for order in [0, 1, 12, 24] {
        for precision in [Precision::F64, Precision::F32] {
            let folder =
                written(&format!("fused_{order}_{precision:?}"), &sources(&random(order), precision, &Language::C));
            for compiler in COMPILERS {
                let mut arguments: Vec<&str> = WARNINGS.to_vec();
                arguments.extend(["-O2", "-o", "fused"]);
                arguments.extend(fused);
                arguments.extend(TEST);
                succeeds(compiler, &arguments, &folder);
                let output = run(folder.join("fused"), &[], &folder);
                let said = String::from_utf8_lossy(&output.stdout);
                assert_eq!(output.status.code(), Some(1), "{compiler}, order {order}");
                assert!(said.contains("beam_selfcheck: tick") && said.contains("hint: "), "{said}");
            }
        }
    }
}

#[test]
fn a_processor_that_flushes_subnormal_numbers_is_found() {
    if !cfg!(target_arch = "x86_64") {
        return;
    }
    for precision in [Precision::F64, Precision::F32] {
        let folder = written(&format!("flushed_{precision:?}"), &sources(&reproduced(), precision, &Language::C));
        std::fs::write(
            folder.join("flushed.c"),
            "#include <xmmintrin.h>\n#include \"beam.h\"\n\
             int main(void) { _mm_setcsr(_mm_getcsr() | 0x8040u); return beam_selfcheck(); }\n",
        )
        .unwrap();
        let program = compile("gcc", &["-O2"], &["flushed.c", "beam.c"], "flushed", &folder);
        assert_eq!(run(program, &[], &folder).status.code(), Some(1), "the first tick is wrong");
    }
}

#[test]
fn fast_arithmetic_does_not_compile() {
    let folder = written("fast_math", &sources(&random(1), Precision::F64, &Language::C));
    let x87: &[(&str, &str)] = if cfg!(target_arch = "x86_64") { &[("gcc", "-mfpmath=387")] } else { &[] };
    for (compiler, flag) in [("gcc", "-ffast-math"), ("clang", "-ffast-math")].iter().chain(x87) {
        let output = run(compiler, &["-std=c99", "-c", flag, "beam.c", "-o", "beam.o"], &folder);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && said.contains("#error"), "{compiler} {flag}: {said}");
    }
}

#[test]
fn nothing_of_libm_and_nothing_of_the_heap_is_called() {
    let folder = written("symbols", &sources(&reproduced(), Precision::F64, &Language::C));
    for compiler in COMPILERS {
        let object = compile(compiler, &["-O2", "-c"], &["beam.c"], "beam.o", &folder);
        let undefined = succeeds("nm", &["-u", &object.to_string_lossy()], &folder);
        let foreign = undefined.split_whitespace().find(|word| !["U", "memset", "memcpy"].contains(word));
        assert_eq!(foreign, None, "{undefined}");
        let writable = succeeds("nm", &[&object.to_string_lossy()], &folder);
        let global_state = writable.lines().find(|line| [" b ", " B ", " d ", " D "].iter().any(|s| line.contains(s)));
        assert_eq!(global_state, None, "{writable}");
    }
}

/// Gains that overflow at once make faults, in the vectors and in the self-check, and no panic here.
#[test]
fn a_senseless_controller_is_written_and_computed_alike() {
    let mut controller = random(3);
    controller.D.0[0] = vec![1e308, -1e308];
    let folder = written("senseless", &sources(&controller, Precision::F64, &Language::C));
    let program = compile("gcc", &["-O2"], &TEST, "test_beam", &folder);
    assert!(succeeds(&program, &[], &folder).contains("every bit"));
}

/// An enumeration of C holds any number.
#[test]
fn a_law_that_is_none_gives_no_voltage() {
    let folder = written("no_law", &sources(&reproduced(), Precision::F64, &Language::C));
    let text = "#include \"beam.h\"\n\
        int main(void)\n{\n    static struct beam_state state;\n    struct beam_settings settings = beam_default_settings;\n\
        \x20   const struct beam_measured measured = {0.0, -0.3, 0.0};\n    beam_reset(&state);\n\
        \x20   if (beam_tick(&settings, &state, measured).voltage_v == 0) {\n        return 1;\n    }\n\
        \x20   settings.law = (enum beam_law)7;\n\
        \x20   return beam_tick(&settings, &state, measured).voltage_v == 0 ? 0 : 2;\n}\n";
    std::fs::write(folder.join("main.c"), text).unwrap();
    for compiler in COMPILERS {
        let program = compile(compiler, &["-O2", "-fsanitize=undefined"], &["beam.c", "main.c"], "main", &folder);
        assert_eq!(run(program, &[], &folder).status.code(), Some(0), "{compiler}");
    }
}

#[test]
fn cpp_may_include_the_header() {
    let folder = written("cpp", &sources(&random(1), Precision::F64, &Language::C));
    std::fs::write(folder.join("main.cpp"), "#include \"beam.h\"\nint main() { return beam_selfcheck(); }\n").unwrap();
    let flags = ["-x", "c++", "-std=c++11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only", "main.cpp"];
    // gcc's own needs a package more.
    succeeds("clang", &flags, &folder);
}

#[test]
fn make_and_cmake_build_and_test() {
    let folder = written("make", &sources(&reproduced(), Precision::F64, &Language::C));
    // Flags of a person's own that ask for contraction do not get it.
    let flags = format!("CFLAGS=-O2 -Werror {}", fused().unwrap_or_default().join(" "));
    assert!(succeeds("make", &[&flags, "all", "test"], &folder).contains("every bit"));
    succeeds("cmake", &["-S", ".", "-B", "build", "-DCMAKE_C_FLAGS=-Werror"], &folder);
    succeeds("cmake", &["--build", "build"], &folder);
    let said = succeeds("ctest", &["--test-dir", "build", "--output-on-failure"], &folder);
    assert!(said.contains("100% tests passed"), "{said}");
}

#[test]
fn the_same_input_gives_the_same_bytes_and_no_clock() {
    for language in [Language::C, Language::Rust] {
        let (one, two) =
            (sources(&reproduced(), Precision::F64, &language), sources(&reproduced(), Precision::F64, &language));
        assert_eq!(one, two);
        for file in &one.files {
            let text = &file.text;
            assert!(!text.contains("__DATE__") && !text.contains("__TIME__") && text.ends_with('\n'), "{}", file.path);
            assert!(text.lines().all(|line| line.trim_end() == line), "{}: spaces at a line's end", file.path);
        }
    }
}

#[test]
fn the_header_says_where_it_came_from_and_what_was_proven() {
    let controller = reproduced();
    let of = |precision| {
        let files = sources(&controller, precision, &Language::C).files;
        files.into_iter().find(|file| file.path == "beam.h").unwrap().text
    };
    let figure = format!("stability_degree  {:.6} 1/s", controller.certificate.sampled.stability_degree);
    for text in [of(Precision::F64), of(Precision::F32)] {
        assert!(text.contains(support::SHA256) && text.contains(&figure), "{text}");
    }
    assert!(of(Precision::F32).contains("no bound for others") && !of(Precision::F64).contains("f32"));
}
