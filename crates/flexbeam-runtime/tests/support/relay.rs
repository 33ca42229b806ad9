//! A road between host and rig that loses, doubles, swaps and damages what it carries, and notes what reached the rig.

use flexbeam_files::frame::Command;
use flexbeam_rig::Measurement;
use flexbeam_runtime::line::LineReader;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::HashMap;
use std::fs::File;
use std::io::{Read, Write};
use std::net::{SocketAddr, UdpSocket};
use std::os::fd::AsFd;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// What a road does to a frame (UDP) or a byte (serial), each with this probability.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mischief {
    pub loses: f64,
    pub doubles: f64,
    pub swaps: f64,
    pub damages: f64,
    /// After so many frames it carries nothing for 50 ms.
    pub silent_after: Option<u64>,
    /// Frames of the greeting that pass unharmed.
    pub spares: u64,
}

pub struct Relay {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<Vec<Command>>,
}

impl Relay {
    /// A road to the rig at `address`; the host talks to the address that comes back.
    pub fn udp(address: &str, mischief: Mischief) -> (Relay, String) {
        let host_side = UdpSocket::bind("127.0.0.1:0").unwrap();
        let rig_side = UdpSocket::bind("127.0.0.1:0").unwrap();
        rig_side.connect(address).unwrap();
        for socket in [&host_side, &rig_side] {
            socket.set_nonblocking(true).unwrap();
        }
        let name = host_side.local_addr().unwrap().to_string();
        let road = Datagrams {
            host_side,
            rig_side,
            host: None,
            up: Lane::default(),
            down: Lane::default(),
            delivered: vec![],
        };
        (Relay::start(road, mischief), name)
    }

    /// A road to the rig at `device`; the host opens the device that comes back.
    pub fn serial(device: &Path, mischief: Mischief) -> (Relay, PathBuf) {
        let pair = nix::pty::openpty(None, None).unwrap();
        let name = nix::unistd::ttyname(&pair.slave).unwrap();
        let flags = nix::fcntl::OFlag::O_RDWR | nix::fcntl::OFlag::O_NONBLOCK;
        nix::fcntl::fcntl(&pair.master, nix::fcntl::FcntlArg::F_SETFL(flags)).unwrap();
        let rig_side = File::options().read(true).write(true).custom_flags(flags.bits()).open(device).unwrap();
        let host_side = File::from(pair.master);
        let road = Bytes { host_side, rig_side, _slave: pair.slave, reader: LineReader::default(), delivered: vec![] };
        (Relay::start(road, mischief), name)
    }

    fn start(mut road: impl Road + 'static, mischief: Mischief) -> Relay {
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            let mut crook = Crook { mischief, dice: ChaCha8Rng::seed_from_u64(3), carried: 0, silent: None };
            while !flag.load(Ordering::Acquire) {
                road.carry(&mut crook);
            }
            road.delivered()
        });
        Relay { stop, thread }
    }

    /// Ends the road; what commands came out at its far end, in their order.
    pub fn end(self) -> Vec<Command> {
        self.stop.store(true, Ordering::Release);
        self.thread.join().unwrap()
    }
}

/// Decides what happens to each item.
struct Crook {
    mischief: Mischief,
    dice: ChaCha8Rng,
    carried: u64,
    silent: Option<Instant>,
}

enum Fate {
    Passes,
    Lost,
    Doubled,
    Swapped,
    Damaged,
}

impl Crook {
    fn fate(&mut self) -> Fate {
        self.carried += 1;
        if Some(self.carried) == self.mischief.silent_after {
            self.silent = Some(Instant::now());
        }
        if self.silent.is_some_and(|since| since.elapsed() < Duration::from_millis(50)) {
            return Fate::Lost;
        }
        let Mischief { loses, doubles, swaps, damages, spares, .. } = self.mischief;
        let mut dice = if self.carried <= spares { 1.0 } else { self.dice.random::<f64>() };
        for (share, fate) in
            [(loses, Fate::Lost), (doubles, Fate::Doubled), (swaps, Fate::Swapped), (damages, Fate::Damaged)]
        {
            if dice < share {
                return fate;
            }
            dice -= share;
        }
        Fate::Passes
    }
}

trait Road: Send {
    fn carry(&mut self, crook: &mut Crook);
    fn delivered(self) -> Vec<Command>;
}

struct Datagrams {
    host_side: UdpSocket,
    rig_side: UdpSocket,
    host: Option<SocketAddr>,
    up: Lane,
    down: Lane,
    delivered: Vec<Command>,
}

/// Either end has something, or 5 ms are over.
fn wait(a: &impl AsFd, b: &impl AsFd) {
    let mut watched = [PollFd::new(a.as_fd(), PollFlags::POLLIN), PollFd::new(b.as_fd(), PollFlags::POLLIN)];
    let _ = poll(&mut watched, PollTimeout::from(5_u8));
}

impl Road for Datagrams {
    fn carry(&mut self, crook: &mut Crook) {
        wait(&self.host_side, &self.rig_side);
        let mut buffer = [0; 256];
        while let Ok((length, host)) = self.host_side.recv_from(&mut buffer) {
            self.host = Some(host);
            for frame in self.up.carried(&buffer[..length], crook) {
                self.delivered.extend(Command::decode(&frame));
                let _ = self.rig_side.send(&frame);
            }
        }
        while let Ok(length) = self.rig_side.recv(&mut buffer) {
            for frame in self.down.carried(&buffer[..length], crook) {
                let _ = self.host.map(|host| self.host_side.send_to(&frame, host));
            }
        }
    }

    fn delivered(self) -> Vec<Command> {
        self.delivered
    }
}

/// One direction of a road.
#[derive(Default)]
struct Lane {
    /// Waits until the next frame has overtaken it.
    overtaken: Option<Vec<u8>>,
}

impl Lane {
    /// What comes out when this frame goes in.
    fn carried(&mut self, frame: &[u8], crook: &mut Crook) -> Vec<Vec<u8>> {
        let mut frame = frame.to_vec();
        let earlier = self.overtaken.take();
        let mut out = match crook.fate() {
            Fate::Lost => vec![],
            Fate::Passes => vec![frame],
            Fate::Doubled => vec![frame.clone(), frame],
            Fate::Swapped => {
                self.overtaken = Some(frame);
                vec![]
            }
            Fate::Damaged => {
                let at = crook.dice.random_range(0..frame.len());
                frame[at] ^= crook.dice.random_range(1..=255_u8);
                vec![frame]
            }
        };
        out.extend(earlier);
        out
    }
}

struct Bytes {
    host_side: File,
    rig_side: File,
    /// Keeps the pseudo-terminal alive before the host has opened it.
    _slave: std::os::fd::OwnedFd,
    reader: LineReader,
    delivered: Vec<Command>,
}

impl Road for Bytes {
    fn carry(&mut self, crook: &mut Crook) {
        wait(&self.host_side, &self.rig_side);
        let up = damaged(&mut self.host_side, crook);
        for &byte in &up {
            self.delivered.extend(self.reader.push(byte).and_then(|frame| Command::decode(frame).ok()));
        }
        self.rig_side.write_all(&up).unwrap();
        let down = damaged(&mut self.rig_side, crook);
        let _ = self.host_side.write_all(&down);
    }

    fn delivered(self) -> Vec<Command> {
        self.delivered
    }
}

/// What came in at one end, less what is lost and with what is damaged.
fn damaged(from: &mut File, crook: &mut Crook) -> Vec<u8> {
    let mut chunk = [0; 512];
    let length = from.read(&mut chunk).unwrap_or(0);
    let mut out = Vec::new();
    for &byte in &chunk[..length] {
        match crook.fate() {
            Fate::Lost => {}
            Fate::Passes | Fate::Swapped => out.push(byte),
            Fate::Doubled => out.extend([byte, byte]),
            Fate::Damaged => out.push(byte ^ crook.dice.random_range(1..=255_u8)),
        }
    }
    out
}

/// What a rig must have answered to each sequence, had it obeyed these commands in this order: the newest voltage alone, for as
/// many periods as there are to the next. Written without the program's own rig side.
pub fn replayed(commands: &[Command]) -> HashMap<u32, Measurement> {
    let mut rig = super::rig();
    let mut newest: Option<Command> = None;
    let mut answers = HashMap::new();
    for command in commands.iter().filter(|command| command.sequence < 1 << 31 && command.flags == 0) {
        if newest.is_some_and(|newest| command.sequence <= newest.sequence) {
            continue;
        }
        for _ in newest.map_or(0..0, |newest| newest.sequence..command.sequence) {
            rig.apply(newest.map_or(0.0, |newest| newest.voltage_v));
        }
        answers.insert(command.sequence, rig.measure());
        newest = Some(*command);
    }
    answers
}
