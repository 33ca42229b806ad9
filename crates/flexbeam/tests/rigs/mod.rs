//! Rigs for the program's tests: the simulated one as a process, and ones that answer what they should not.

#[path = "../../../flexbeam-runtime/tests/support/relay.rs"]
#[allow(dead_code, reason = "each test uses a part")]
pub mod relay;

use crate::support::Bench;
use flexbeam_files::frame::{Command as Commanded, Measurement as Measured};
use serde_json::Value;
use std::io::{BufRead, BufReader, Read};
use std::net::UdpSocket;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// What the relay's replays start from.
fn rig() -> flexbeam_rig::SimulatedRig {
    flexbeam_rig::SimulatedRig::new(&flexbeam_rig::RigParameters::default(), 1).unwrap()
}

/// `flexbeam rig` as a process; it goes with the value.
pub struct RigProcess {
    child: Child,
    pub port: String,
}

impl RigProcess {
    pub fn udp(bench: &Bench, options: &str) -> RigProcess {
        // A port that is free now; two tests that ask at once get two.
        let free = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        RigProcess::start(bench, &format!("--listen udp:{free} {options}"))
    }

    pub fn pty(bench: &Bench, options: &str) -> RigProcess {
        RigProcess::start(bench, &format!("--listen pty {options}"))
    }

    fn start(bench: &Bench, options: &str) -> RigProcess {
        let mut program = Command::new(env!("CARGO_BIN_EXE_flexbeam"));
        program.args(["rig", "--json"]).args(options.split_whitespace()).current_dir(bench.path(""));
        let mut child = program.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut said = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        said.read_line(&mut line).unwrap();
        let port = line.split(" listens at ").nth(1).and_then(|rest| rest.split(';').next());
        let port = port.unwrap_or_else(|| panic!("{line}")).to_string();
        RigProcess { child, port }
    }

    pub fn address(&self) -> &str {
        self.port.strip_prefix("udp:").unwrap()
    }

    pub fn device(&self) -> PathBuf {
        self.port.strip_prefix("serial:").unwrap().into()
    }

    /// Without a word.
    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// As by Ctrl-C; its report.
    pub fn end(mut self) -> Value {
        let pid = nix::unistd::Pid::from_raw(self.child.id() as i32);
        nix::sys::signal::kill(pid, nix::sys::signal::Signal::SIGINT).unwrap();
        let mut out = String::new();
        self.child.stdout.take().unwrap().read_to_string(&mut out).unwrap();
        assert!(self.child.wait().unwrap().success());
        serde_json::from_str(&out).unwrap()
    }
}

impl Drop for RigProcess {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A rig that answers every command with what a function of the count of answers says: theta, alpha, frame version.
pub struct Answering {
    stop: Arc<AtomicBool>,
    pub port: String,
}

impl Answering {
    pub fn start(answer: impl Fn(u32) -> (f64, f64, u8) + Send + 'static) -> Answering {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.set_read_timeout(Some(Duration::from_millis(20))).unwrap();
        let port = format!("udp:{}", socket.local_addr().unwrap());
        let stop = Arc::new(AtomicBool::new(false));
        let flag = stop.clone();
        std::thread::spawn(move || {
            let (mut count, mut buffer) = (0, [0; 256]);
            while !flag.load(Ordering::Acquire) {
                let Ok((length, host)) = socket.recv_from(&mut buffer) else { continue };
                let Ok(command) = Commanded::decode(&buffer[..length]) else { continue };
                let (theta_rad, alpha_rad, version) = answer(count);
                count += 1;
                let (session, sequence) = (command.session, command.sequence);
                let mut frame = Measured { session, sequence, status: 0, theta_rad, alpha_rad, boots: 1 }.encode();
                frame[2] = version;
                let body = frame.len() - 4;
                let sealed = crc32fast::hash(&frame[..body]).to_le_bytes();
                frame[body..].copy_from_slice(&sealed);
                let _ = socket.send_to(&frame, host);
            }
        });
        Answering { stop, port }
    }
}

impl Drop for Answering {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
    }
}
