//! The microcontroller's side in C against ours: the same bytes both ways, the same frames out of a damaged line, the same rig.

use flexbeam_files::frame::{Command, FrameError, Measurement};
use flexbeam_runtime::line::{LineReader, Stuffed};
use flexbeam_runtime::rig_side::{Decision, Phase, RigSide};
use libloading::Library;
use proptest::prelude::*;
use std::ffi::c_int;
use std::path::{Path, PathBuf};
use std::process::Command as Process;
use std::sync::OnceLock;

const WARNINGS: [&str; 6] = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"];

fn firmware(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("firmware").join(file)
}

/// Compiles a file of the firmware into the test's own folder.
fn compiled(file: &str, arguments: &[&str], output: &str) -> PathBuf {
    let output = Path::new(env!("CARGO_TARGET_TMPDIR")).join(output);
    let mut compiler = Process::new("cc");
    compiler.args(WARNINGS).args(arguments).arg(firmware(file)).arg("-o").arg(&output);
    let said = compiler.output().expect("cc starts: the tests need a C compiler");
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    output
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
struct CCommand {
    session: u32,
    sequence: u32,
    hold_ms: u16,
    flags: u16,
    voltage_v: f64,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
struct CMeasurement {
    session: u32,
    sequence: u32,
    status: u32,
    theta_rad: f64,
    alpha_rad: f64,
    boots: u32,
}

#[repr(C)]
struct CLine {
    frame: [u8; 64],
    length: u16,
    left: u8,
    inside: u8,
}

#[repr(C)]
struct CRig {
    voltage_v: f64,
    phase: c_int,
    rest: [u32; 5],
    reply: [u8; 64],
}

/// The functions of `flexbeam_frame.h`.
struct Firmware {
    encode_command: unsafe extern "C" fn(*const CCommand, *mut u8),
    encode_measurement: unsafe extern "C" fn(*const CMeasurement, *mut u8),
    decode_command: unsafe extern "C" fn(*const u8, usize, *mut CCommand) -> c_int,
    decode_measurement: unsafe extern "C" fn(*const u8, usize, *mut CMeasurement) -> c_int,
    line_encode: unsafe extern "C" fn(*const u8, usize, *mut u8) -> usize,
    line_push: unsafe extern "C" fn(*mut CLine, u8) -> c_int,
    rig_init: unsafe extern "C" fn(*mut CRig, u32),
    rig_on_tick_ms: unsafe extern "C" fn(*mut CRig, u32),
    rig_on_frame: unsafe extern "C" fn(*mut CRig, *const u8, usize, u32, f64, f64, u32, *mut u8) -> usize,
}

static FIRMWARE: OnceLock<Firmware> = OnceLock::new();

fn c() -> &'static Firmware {
    FIRMWARE.get_or_init(|| {
        let path = compiled("flexbeam_frame.c", &["-O2", "-shared", "-fPIC"], "libflexbeam_frame.so");
        // SAFETY: a library of ours that runs nothing when it is loaded; leaked, so its functions stay.
        let library: &'static Library = Box::leak(Box::new(unsafe { Library::new(path) }.expect("loads")));
        // SAFETY: the types are those of flexbeam_frame.h.
        unsafe {
            Firmware {
                encode_command: *library.get(b"flexbeam_encode_command").unwrap(),
                encode_measurement: *library.get(b"flexbeam_encode_measurement").unwrap(),
                decode_command: *library.get(b"flexbeam_decode_command").unwrap(),
                decode_measurement: *library.get(b"flexbeam_decode_measurement").unwrap(),
                line_encode: *library.get(b"flexbeam_line_encode").unwrap(),
                line_push: *library.get(b"flexbeam_line_push").unwrap(),
                rig_init: *library.get(b"flexbeam_rig_init").unwrap(),
                rig_on_tick_ms: *library.get(b"flexbeam_rig_on_tick_ms").unwrap(),
                rig_on_frame: *library.get(b"flexbeam_rig_on_frame").unwrap(),
            }
        }
    })
}

/// The code of `enum flexbeam_fault`.
fn code<T>(decoded: &Result<T, FrameError>) -> c_int {
    match decoded {
        Ok(_) => 0,
        Err(FrameError::Magic) => 1,
        Err(FrameError::Version { .. }) => 2,
        Err(FrameError::Length { .. }) => 3,
        Err(FrameError::Checksum) => 4,
        Err(FrameError::Kind { .. }) => 5,
    }
}

/// Both decoders on the same bytes, and both encoders on what came out.
fn decode_alike(bytes: &[u8]) {
    let (mut command, mut measurement) = (CCommand::default(), CMeasurement::default());
    // SAFETY: pointer and length are those of one slice, and the results lie on this stack.
    let codes = unsafe {
        [
            (c().decode_command)(bytes.as_ptr(), bytes.len(), &mut command),
            (c().decode_measurement)(bytes.as_ptr(), bytes.len(), &mut measurement),
        ]
    };
    let (ours_command, ours_measurement) = (Command::decode(bytes), Measurement::decode(bytes));
    assert_eq!(codes, [code(&ours_command), code(&ours_measurement)], "{bytes:?}");
    if let Ok(ours) = ours_command {
        let CCommand { session, sequence, hold_ms, flags, voltage_v } = command;
        assert_eq!(Command { session, sequence, hold_ms, flags, voltage_v }.encode(), ours.encode());
        let mut encoded = [0xEE; 32];
        // SAFETY: the frame has the length that the header asks for.
        unsafe { (c().encode_command)(&command, encoded.as_mut_ptr()) };
        assert_eq!(encoded, ours.encode());
    }
    if let Ok(ours) = ours_measurement {
        let CMeasurement { session, sequence, status, theta_rad, alpha_rad, boots } = measurement;
        assert_eq!(Measurement { session, sequence, status, theta_rad, alpha_rad, boots }.encode(), ours.encode());
        let mut encoded = [0xEE; 40];
        // SAFETY: the frame has the length that the header asks for.
        unsafe { (c().encode_measurement)(&measurement, encoded.as_mut_ptr()) };
        assert_eq!(encoded, ours.encode());
    }
}

/// A frame of either kind with any numbers in it.
fn frame() -> impl Strategy<Value = Vec<u8>> {
    (any::<bool>(), any::<[u32; 4]>(), any::<[u64; 2]>()).prop_map(|(command, [session, sequence, x, boots], bits)| {
        let [theta_rad, alpha_rad] = bits.map(f64::from_bits);
        if command {
            let (hold_ms, flags) = (x as u16, (x >> 16) as u16);
            Command { session, sequence, hold_ms, flags, voltage_v: theta_rad }.encode().to_vec()
        } else {
            Measurement { session, sequence, status: x, theta_rad, alpha_rad, boots }.encode().to_vec()
        }
    })
}

/// What both readers find in the same bytes.
fn read_alike(bytes: &[u8]) -> usize {
    let mut ours = LineReader::default();
    let mut theirs = CLine { frame: [0; 64], length: 0, left: 0, inside: 0 };
    let mut whole = 0;
    for &byte in bytes {
        // SAFETY: a line of the header's layout.
        let length = unsafe { (c().line_push)(&mut theirs, byte) };
        // Frames too long for the smaller buffer are none there.
        let found = ours.push(byte).map(|frame| if frame.len() > 64 { &[] } else { frame });
        let theirs = usize::try_from(length).ok().map(|length| &theirs.frame[..length]);
        assert_eq!(found, theirs);
        whole += usize::from(found.is_some_and(|frame| !frame.is_empty()));
    }
    whole
}

#[test]
fn the_example_compiles_without_a_warning() {
    compiled("example.c", &["-O2", "-c"], "example.o");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn frames_have_the_same_bytes_on_both_sides(frame in frame()) {
        decode_alike(&frame);
    }

    #[test]
    fn damaged_frames_are_judged_alike(mut frame in frame(), at in 0..40_usize, wrong in 1..=u8::MAX, cut in 0..40_usize) {
        let length = frame.len();
        frame[at % length] ^= wrong;
        decode_alike(&frame);
        frame.truncate(cut);
        decode_alike(&frame);
    }

    #[test]
    fn any_bytes_are_judged_alike(bytes in proptest::collection::vec(any::<u8>(), 0..60)) {
        decode_alike(&bytes);
        read_alike(&bytes);
    }

    #[test]
    fn frames_look_alike_on_a_line(frame in frame()) {
        let mut line = [0xEE; 42];
        // SAFETY: the line has the length that the header asks for.
        let length = unsafe { (c().line_encode)(frame.as_ptr(), frame.len(), line.as_mut_ptr()) };
        let stuffed = Stuffed::new(&frame).unwrap();
        prop_assert_eq!(&line[..length], stuffed.plain());
        prop_assert_eq!(read_alike(stuffed.plain()), 1);
        prop_assert_eq!(read_alike(stuffed.closing()), 1);
    }

    /// Bytes lost, changed and put in: both find the same frames, and the ones behind the damage.
    #[test]
    fn a_damaged_line_is_read_alike(
        frames in proptest::collection::vec(frame(), 1..6),
        damage in proptest::collection::vec((any::<proptest::sample::Index>(), 0..3_u8, any::<u8>()), 0..6),
        last in frame(),
    ) {
        let mut bytes: Vec<u8> = frames.iter().flat_map(|f| Stuffed::new(f).unwrap().plain().to_vec()).collect();
        for (at, kind, byte) in damage {
            let at = at.index(bytes.len());
            match kind {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                _ if bytes.len() > 1 => { bytes.remove(at); }
                _ => {}
            }
        }
        bytes.extend(Stuffed::new(&last).unwrap().closing());
        prop_assert!(read_alike(&bytes) >= 1);
    }
}

/// One thing that happens to a rig.
#[derive(Clone, Debug)]
enum Event {
    Command { session: u32, ahead: i32, flags: u16, hold_ms: u16, voltage_bits: u64 },
    Greeting { session: u32, left: u32 },
    Damaged { at: usize },
    OtherVersion,
    Ticks { ms: u32 },
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        8 => (0..3_u32, -3..4_i32, 0..30_u16, 5..60_u16, any::<u64>()).prop_map(
            |(session, ahead, flags, hold_ms, voltage_bits)| {
                let flags = if flags == 0 { 1 } else { flags & !1 };
                Event::Command { session, ahead, flags, hold_ms, voltage_bits }
            }
        ),
        3 => (0..3_u32, 1..50_u32).prop_map(|(session, left)| Event::Greeting { session, left }),
        1 => (0..32_usize).prop_map(|at| Event::Damaged { at }),
        1 => Just(Event::OtherVersion),
        3 => (0..40_u32).prop_map(|ms| Event::Ticks { ms }),
    ]
}

/// The two machines, side by side.
struct Twins {
    ours: RigSide,
    theirs: CRig,
    now_ms: u32,
    sequence: u32,
    readings: f64,
}

impl Twins {
    fn new(now_ms: u32, sequence: u32) -> Twins {
        let mut theirs = CRig { voltage_v: 9.0, phase: 9, rest: [9; 5], reply: [9; 64] };
        // SAFETY: a rig of the header's layout, with room to spare behind it.
        unsafe { (c().rig_init)(&mut theirs, 77) };
        Twins { ours: RigSide::new(77), theirs, now_ms, sequence, readings: 0.0 }
    }

    fn happens(&mut self, event: &Event) {
        match *event {
            Event::Command { session, ahead, flags, hold_ms, voltage_bits } => {
                let sequence = self.sequence.wrapping_add_signed(ahead);
                self.sequence = if ahead > 0 { sequence } else { self.sequence };
                let voltage_v = f64::from_bits(voltage_bits);
                self.frame(&Command { session, sequence, hold_ms, flags, voltage_v }.encode());
            }
            Event::Greeting { session, left } => {
                let sequence = 0_u32.wrapping_sub(left);
                self.frame(&Command { session, sequence, hold_ms: 20, flags: 0, voltage_v: 0.0 }.encode());
            }
            Event::Damaged { at } => {
                let good = Command { session: 1, sequence: self.sequence, hold_ms: 20, flags: 0, voltage_v: 5.0 };
                let mut bytes = good.encode();
                bytes[at] ^= 0x10;
                self.frame(&bytes);
            }
            Event::OtherVersion => {
                let mut bytes = vec![b'F', b'B', 2, 1, 0, 0, 0, 0, 0];
                bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
                self.frame(&bytes);
            }
            Event::Ticks { ms } => self.ticks(ms),
        }
        self.agree();
    }

    fn ticks(&mut self, ms: u32) {
        for _ in 0..ms {
            self.now_ms = self.now_ms.wrapping_add(1);
            self.ours.on_tick(self.now_ms);
            // SAFETY: a rig of the header's layout.
            unsafe { (c().rig_on_tick_ms)(&mut self.theirs, self.now_ms) };
        }
    }

    fn frame(&mut self, bytes: &[u8]) {
        self.readings += 0.125;
        let (theta_rad, alpha_rad) = (self.readings, -self.readings);
        let mut answer = [0; 40];
        // SAFETY: pointer and length are those of one slice; the answer has the length that the header asks for.
        let length = unsafe {
            let rig = &mut self.theirs;
            let answer = answer.as_mut_ptr();
            (c().rig_on_frame)(rig, bytes.as_ptr(), bytes.len(), self.now_ms, theta_rad, alpha_rad, 0, answer)
        };
        let ours = self.answered(bytes, theta_rad, alpha_rad).map(|answer| answer.encode());
        assert_eq!(ours, (length == 40).then_some(answer));
    }

    fn answered(&mut self, bytes: &[u8], theta_rad: f64, alpha_rad: f64) -> Option<Measurement> {
        self.ours.on_tick(self.now_ms);
        match Command::decode(bytes) {
            Ok(command) => match self.ours.on_command(&command, self.now_ms) {
                Decision::Older | Decision::Foreign => None,
                Decision::Repeat(reply) => Some(reply),
                Decision::Read(_) => Some(self.ours.answer(&command, theta_rad, alpha_rad, 0)),
            },
            Err(FrameError::Version { .. }) if flexbeam_files::frame::is_command(bytes) => self.ours.on_other_version(),
            Err(_) => None,
        }
    }

    fn agree(&self) {
        assert_eq!(self.ours.voltage_v().to_bits(), self.theirs.voltage_v.to_bits());
        let phases = [Phase::Idle, Phase::Greeted, Phase::Running, Phase::TimedOut, Phase::Stopped];
        assert_eq!(phases.get(self.theirs.phase as usize), Some(&self.ours.phase()));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    /// Across the overflow of the clock and of the sequence, too.
    #[test]
    fn the_two_rigs_obey_alike(
        events in proptest::collection::vec(event(), 1..120),
        now_ms in prop_oneof![Just(0), Just(u32::MAX - 30)],
        sequence in prop_oneof![Just(0), Just(i32::MAX as u32 - 20)],
    ) {
        let mut twins = Twins::new(now_ms, sequence);
        events.iter().for_each(|event| twins.happens(event));
    }
}
