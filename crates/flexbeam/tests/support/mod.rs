//! The real program, run in an empty folder of its own.

// Each test file takes what it needs from here.
#![allow(dead_code)]

pub mod recorded_run;

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// A folder in which the program runs.
pub struct Bench {
    folder: tempfile::TempDir,
}

/// What the program said, and how it ended.
#[derive(Debug)]
pub struct Answer {
    pub status: i32,
    pub out: String,
    pub err: String,
}

impl Bench {
    pub fn new() -> Bench {
        Bench { folder: tempfile::tempdir().expect("a folder for the test") }
    }

    /// Runs `flexbeam` with these words; no word contains a blank.
    pub fn run(&self, line: &str) -> Answer {
        self.run_words(&line.split_whitespace().collect::<Vec<_>>())
    }

    pub fn run_words(&self, words: &[&str]) -> Answer {
        let mut program = Command::new(env!("CARGO_BIN_EXE_flexbeam"));
        let output = program.args(words).current_dir(self.folder.path()).output().expect("the program starts");
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("the program speaks UTF-8");
        Answer {
            status: output.status.code().expect("the program ends by itself"),
            out: text(output.stdout),
            err: text(output.stderr),
        }
    }

    /// Runs, expects success, and returns standard output.
    pub fn done(&self, line: &str) -> String {
        let answer = self.run(line);
        assert_eq!(answer.status, 0, "flexbeam {line}: {}", answer.err);
        answer.out
    }

    /// Runs with `--json`, expects success, and returns the one object.
    pub fn json(&self, line: &str) -> Value {
        let text = self.done(&format!("{line} --json"));
        let value: Value = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{line}: {error}: {text}"));
        assert!(value.is_object(), "{line}: {text}");
        value
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).expect("the test's own file is written");
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Names of all files, sorted.
    pub fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).expect("the folder is there");
        let mut names: Vec<String> =
            entries.map(|entry| entry.expect("an entry").file_name().into_string().expect("UTF-8")).collect();
        names.sort();
        names
    }
}

/// Number under a key of an object.
pub fn number(object: &Value, key: &str) -> f64 {
    object[key].as_f64().unwrap_or_else(|| panic!("{key} is no number in {object}"))
}

/// Pairs [re, im] under a key.
pub fn pairs(object: &Value, key: &str) -> Vec<[f64; 2]> {
    let list = object[key].as_array().unwrap_or_else(|| panic!("{key} is no list in {object}"));
    list.iter().map(|pair| [pair[0].as_f64().expect("re"), pair[1].as_f64().expect("im")]).collect()
}

/// Columns of a CSV text, by their names.
pub fn column(csv: &str, name: &str) -> Vec<f64> {
    let mut lines = csv.lines();
    let header = lines.next().expect("a header");
    let k = header.split(',').position(|column| column == name).unwrap_or_else(|| panic!("{name} in {header}"));
    lines.map(|line| line.split(',').nth(k).expect("a cell").parse().expect("a number")).collect()
}

/// The recordings of `shared/data`; nothing, and loudly so, where they are missing.
pub fn data() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("FLEXBEAM_DATA").map(PathBuf::from).unwrap_or(beside);
    if folder.join("robot_arm.dat").is_file() {
        return Some(folder);
    }
    eprintln!("\n!!! LEFT OUT: no recordings in {}; set FLEXBEAM_DATA to their folder !!!\n", folder.display());
    None
}

/// A Python with the packages of `xtask/src/python.rs`; nothing, and loudly so, where there is none.
pub fn python() -> Option<PathBuf> {
    let named = std::env::var_os("FLEXBEAM_PYTHON").filter(|path| !path.is_empty()).map(PathBuf::from);
    if named.is_none() {
        eprintln!("\n!!! LEFT OUT: no other reader; FLEXBEAM_PYTHON names none, cargo xtask test makes one !!!\n");
    }
    named
}

/// A sequence without pattern, between -1 and 1: the top bits of a congruential generator.
pub fn pseudorandom(count: usize) -> Vec<f64> {
    let mut state = 12345u64;
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    (0..count).map(|_| next()).collect()
}

/// A model file with the lumped plant's matrices, written by hand as a user would.
pub fn model(plant: &flexbeam_rig::Lumped) -> String {
    let flexbeam_rig::Lumped { k1, k2, c, b } = *plant;
    format!(
        "schema = \"flexbeam.model/1\"\ntime = \"continuous\"\n\
         inputs = [\"voltage_v\"]\noutputs = [\"theta_rad\", \"alpha_rad\"]\n\
         A = [[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0], [0.0, {k1:?}, -{c:?}, 0.0], [0.0, -{k2:?}, {c:?}, 0.0]]\n\
         B = [[0.0], [0.0], [{b:?}], [-{b:?}]]\n\
         C = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]]\nD = [[0.0], [0.0]]\n"
    )
}
