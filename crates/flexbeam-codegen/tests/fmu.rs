//! The text of a functional mock-up unit as others build it: no warnings, into a program of their own, under the sanitizers; a build
//! that contracts refuses to be instantiated. What an importer makes of it is tested at the roof.

mod support;

use flexbeam_codegen::fmu::{SOURCES, Unit, Version, rig_unit, unit};
use flexbeam_codegen::{Error, Name, RigSubject, Subject};
use flexbeam_rig::{Encoder, RigParameters, Sensors};
use std::path::PathBuf;
use support::{SHA256, WARNINGS, random, reproduced, run, settings_of, succeeds};

const COMPILERS: [&str; 2] = ["gcc", "clang"];

/// A host of one call, linked with the unit: 0 when it gets an instance, 1 when it is told why not.
const HOST_2: &str = r#"#include <stdarg.h>
#include <stdio.h>
void *beam_fmi2Instantiate(const char *, int, const char *, const char *, const void *, int, int);
void beam_fmi2FreeInstance(void *);
static void log_it(void *host, const char *instance, int status, const char *category, const char *message, ...)
{
    (void)host, (void)instance, (void)status, (void)category;
    puts(message);
}
int main(int count, char **words)
{
    const struct { void (*log)(void *, const char *, int, const char *, const char *, ...); void *other[4]; } host = {log_it, {0}};
    void *instance = beam_fmi2Instantiate("one", 1, count > 1 ? words[1] : "", "", &host, 0, 0);
    const int without = instance == NULL;
    beam_fmi2FreeInstance(instance);
    return without;
}
"#;

/// The same.
const HOST_3: &str = r#"#include <stdbool.h>
#include <stdio.h>
void *beam_fmi3InstantiateCoSimulation(const char *, const char *, const char *, bool, bool, bool, bool, const unsigned *,
                                       size_t, void *, void (*)(void *, int, const char *, const char *), void (*)(void));
void beam_fmi3FreeInstance(void *);
static void log_it(void *host, int status, const char *category, const char *message)
{
    (void)host, (void)status, (void)category;
    puts(message);
}
int main(int count, char **words)
{
    void *instance = beam_fmi3InstantiateCoSimulation("one", count > 1 ? words[1] : "", "", false, false, false, false, NULL, 0,
                                                      NULL, log_it, NULL);
    const int without = instance == NULL;
    beam_fmi3FreeInstance(instance);
    return without;
}
"#;

struct Written {
    folder: PathBuf,
    compiled: Vec<String>,
    guid: String,
}

/// What the unit is of.
#[derive(Clone, Copy, Debug)]
enum Of {
    Random(usize),
    Reproduced,
    Rig,
}

fn unit_of(of: Of, version: Version) -> Unit {
    let name = Name::new("beam").unwrap();
    let controller = match of {
        Of::Random(order) => random(order),
        Of::Reproduced => reproduced(),
        Of::Rig => {
            let subject = RigSubject { parameters: &RigParameters::default(), sha256: Some(SHA256) };
            return rig_unit(&subject, &name, version).unwrap();
        }
    };
    let settings = settings_of(&controller);
    let figures = &controller.certificate.sampled;
    let subject = Subject { controller: &controller, settings: &settings, sha256: SHA256, figures, unverified: None };
    unit(&subject, &name, version).unwrap()
}

fn written(of: Of, version: Version) -> Written {
    let Unit { files, mut compiled, .. } = unit_of(of, version);
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("fmu_{version:?}_{of:?}"));
    std::fs::create_dir_all(&folder).unwrap();
    for file in files.iter().filter_map(|file| Some((file.path.strip_prefix(SOURCES)?, &file.text))) {
        std::fs::write(folder.join(file.0), file.1).unwrap();
    }
    std::fs::write(folder.join("host.c"), if version == Version::Two { HOST_2 } else { HOST_3 }).unwrap();
    compiled.push("host.c".into());
    let description = &files.iter().find(|file| file.path == "modelDescription.xml").unwrap().text;
    let guid = description.split('"').find(|text| text.starts_with('{')).unwrap().to_owned();
    Written { folder, compiled, guid }
}

fn built(written: &Written, compiler: &str, flags: &[&str]) -> PathBuf {
    let mut arguments: Vec<&str> = WARNINGS.to_vec();
    arguments.extend(flags);
    arguments.extend(["-DFMI2_FUNCTION_PREFIX=beam_", "-DFMI3_FUNCTION_PREFIX=beam_", "-o", "host"]);
    arguments.extend(written.compiled.iter().map(String::as_str));
    succeeds(compiler, &arguments, &written.folder);
    written.folder.join("host")
}

#[test]
fn it_builds_without_warnings_and_knows_its_own_description() {
    for version in [Version::Two, Version::Three] {
        for of in [Of::Random(0), Of::Reproduced, Of::Rig] {
            let written = written(of, version);
            for compiler in COMPILERS {
                let sanitized =
                    ["-O1", "-ffp-contract=off", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
                let host = built(&written, compiler, &sanitized);
                assert_eq!(run(&host, &[&written.guid], &written.folder).status.code(), Some(0));
                let other = run(&host, &["{another}"], &written.folder);
                assert_eq!(other.status.code(), Some(1));
                assert!(String::from_utf8_lossy(&other.stdout).contains("needed that of modelDescription.xml"));
            }
        }
    }
}

#[test]
fn a_reason_stands_in_the_documentation_and_is_no_tag() {
    let controller = reproduced();
    let (settings, figures) = (settings_of(&controller), &controller.certificate.sampled);
    for (reason, words) in
        [(None, None), (Some("<b> & a \"trial\""), Some("NOT VERIFIED: &lt;b&gt; &amp; a &quot;trial&quot;"))]
    {
        let subject =
            Subject { controller: &controller, settings: &settings, sha256: SHA256, figures, unverified: reason };
        let files = unit(&subject, &Name::new("beam").unwrap(), Version::Three).unwrap().files;
        let text = |path: &str| &files.iter().find(|file| file.path == path).unwrap().text;
        assert!(words.is_none_or(|words| text("documentation/index.html").contains(words)));
        for path in ["documentation/index.html", "modelDescription.xml", "sources/beam.h"] {
            assert_eq!(text(path).contains("NOT VERIFIED"), reason.is_some(), "{path}");
        }
    }
}

/// On other processors there may be nothing to contract; the self-check's own test says so loudly.
#[cfg(target_arch = "x86_64")]
#[test]
fn a_build_that_contracts_refuses_to_be_instantiated() {
    if !std::arch::is_x86_feature_detected!("fma") {
        eprintln!("\n!!! LEFT OUT: this processor cannot contract products and sums !!!\n");
        return;
    }
    for version in [Version::Two, Version::Three] {
        for of in [Of::Reproduced, Of::Rig] {
            let written = written(of, version);
            let host = built(&written, "gcc", &["-O2", "-ffp-contract=fast", "-mfma"]);
            let output = run(&host, &[&written.guid], &written.folder);
            assert_eq!(output.status.code(), Some(1));
            assert!(String::from_utf8_lossy(&output.stdout).contains("found arithmetic that is not flexbeam's"));
        }
    }
}

#[test]
fn a_rig_that_no_unit_can_be_is_refused() {
    let default = RigParameters::default();
    let unit = |parameters: RigParameters| {
        let subject = RigSubject { parameters: &parameters, sha256: None };
        rig_unit(&subject, &Name::new("rig").unwrap(), Version::Two).map(|unit| unit.files)
    };
    let counts = Encoder { counts_per_turn: Some(1 << 31) };
    let many = RigParameters { sensors: Sensors { encoder: counts, ..default.sensors }, ..default };
    assert_eq!(unit(many), Err(Error::Counts { found: 1 << 31 }));
    assert_eq!(unit(RigParameters { computing_delay_periods: 0, ..default }), Err(Error::Delay));
    assert!(matches!(unit(RigParameters { period_s: -1.0, ..default }), Err(Error::Rig(_))));
    // More delay than a host may ask for otherwise.
    let files = unit(RigParameters { computing_delay_periods: 40, ..default }).unwrap();
    assert!(files.iter().any(|file| file.text.contains("_LONGEST_DELAY 39\n")));
}
