//! A stand-in's library, compiled once and loaded anew for each test.

use libloading::os::unix::Library;
use std::ffi::CString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// One loaded stand-in with its log.
pub struct StandIn {
    library: Library,
    path: PathBuf,
    log: PathBuf,
    _folder: TempDir,
}

impl StandIn {
    /// The stand-in of this name: `hil`, `comedi`.
    pub fn new(name: &str) -> StandIn {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(format!("lib{name}.so"));
        // A copy has state of its own.
        std::fs::copy(compiled(name), &path).expect("copied");
        // SAFETY: the stand-in has no start-up code.
        let library = unsafe { Library::new(&path) }.expect("loaded");
        let log = folder.path().join("calls.txt");
        let stand_in = StandIn { library, path, log, _folder: folder };
        let log = CString::new(stand_in.log.to_str().expect("text")).expect("no NUL");
        // SAFETY: the type is that of the function in the stand-in.
        unsafe {
            stand_in.library.get::<unsafe extern "C" fn(*const i8)>("stand_in_log_path").expect("there")(log.as_ptr())
        };
        stand_in
    }

    /// For `library=`.
    pub fn path(&self) -> String {
        self.path.to_str().expect("text").to_owned()
    }

    /// Every call so far, in order, with its arguments.
    pub fn log(&self) -> Vec<String> {
        std::fs::read_to_string(&self.log).unwrap_or_default().lines().map(String::from).collect()
    }

    /// Calls whose line begins so.
    pub fn logged(&self, start: &str) -> Vec<String> {
        self.log().into_iter().filter(|line| line.starts_with(start)).collect()
    }

    /// Waits until a call with this line has begun.
    pub fn wait_for(&self, line: &str) {
        let start = Instant::now();
        while !self.log().iter().any(|logged| logged == line) {
            assert!(start.elapsed() < Duration::from_secs(120), "{line} was never called");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// The nth call of this name from now on fails.
    pub fn fail(&self, call: &str, nth: i32, code: i32) {
        let call = CString::new(call).expect("no NUL");
        // SAFETY: the type is that of the function in the stand-in.
        unsafe {
            self.library.get::<unsafe extern "C" fn(*const i8, i32, i32)>("stand_in_fail").expect("there")(
                call.as_ptr(),
                nth,
                code,
            )
        };
    }

    /// The nth call of this name from now on hangs.
    pub fn stall(&self, call: &str, nth: i32) {
        let call = CString::new(call).expect("no NUL");
        // SAFETY: the type is that of the function in the stand-in.
        unsafe {
            self.library.get::<unsafe extern "C" fn(*const i8, i32)>("stand_in_stall").expect("there")(
                call.as_ptr(),
                nth,
            )
        };
    }

    /// What hangs goes on.
    pub fn release(&self) {
        // SAFETY: the type is that of the function in the stand-in.
        unsafe { self.library.get::<unsafe extern "C" fn()>("stand_in_release").expect("there")() };
    }

    /// Sets the counter and the gauge's volts.
    pub fn sensors(&self, count: i32, gauge_v: f64) {
        // SAFETY: the type is that of the function in the stand-in.
        unsafe {
            self.library.get::<unsafe extern "C" fn(i32, f64)>("stand_in_sensors").expect("there")(count, gauge_v)
        };
    }

    /// What stands at the board's terminals.
    pub fn output_v(&self) -> f64 {
        // SAFETY: the type is that of the function in the stand-in.
        unsafe { self.library.get::<unsafe extern "C" fn() -> f64>("stand_in_output_v").expect("there")() }
    }

    /// Handles that are open now.
    pub fn open_handles(&self) -> i32 {
        // SAFETY: the type is that of the function in the stand-in.
        unsafe { self.library.get::<unsafe extern "C" fn() -> i32>("stand_in_open_handles").expect("there")() }
    }

    /// HIL: the board has no watchdog.
    pub fn without_watchdog(&self) {
        // SAFETY: the type is that of the function in the stand-in.
        unsafe { self.library.get::<unsafe extern "C" fn()>("stand_in_without_watchdog").expect("there")() };
    }

    /// HIL: the watchdog expires now, with this voltage as the last one written.
    pub fn expired_at(&self, voltage_v: f64) {
        // SAFETY: the type is that of the function in the stand-in.
        unsafe { self.library.get::<unsafe extern "C" fn(f64)>("stand_in_expired_at").expect("there")(voltage_v) };
    }
}

/// Compiles C of this folder, with words in front of the file's name.
///
/// Errors: what the compiler said.
pub fn compile(source: &str, words: &[&str], into: &Path) -> Result<(), String> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/boards").join(source);
    let output = Command::new("cc")
        .args(["-std=gnu11", "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror", "-o"])
        .arg(into)
        .args(words)
        .arg(source)
        .arg("-lm")
        .output()
        .expect("cc starts: the tests need a C compiler");
    output.status.success().then_some(()).ok_or_else(|| String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Where the compiled stand-in lies; compiled at its first use in a process.
fn compiled(name: &str) -> PathBuf {
    static DONE: Mutex<Vec<String>> = Mutex::new(Vec::new());
    let mut done = DONE.lock().expect("the stand-ins compile");
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}_stand_in.so"));
    if !done.iter().any(|other| other == name) {
        // Renamed into place: another process may be reading the file that is there.
        let beside = path.with_extension(std::process::id().to_string());
        compile(&format!("{name}_stand_in.c"), &[], &beside).expect("the stand-in compiles");
        std::fs::rename(&beside, &path).expect("renamed");
        done.push(name.into());
    }
    path
}
