//! What host and rig say to one another once a period, over UDP or a serial line: the frame, version 1.
//!
//! Enters: a voltage with its instant, or readings with the instant that they answer. Leaves: 32 or 40 bytes, little-endian,
//! each number aligned to its size; and back. Every function is total and allocates nothing.
//! Deliberately absent: sockets and lines; who obeys which frame (flexbeam-runtime).
//!
//! What every version keeps: magic, version and kind in front; at the end the check sum of all before it. So a frame of another
//! version is told from noise whatever its size ([`is_sealed`]), and a host's from a rig's ([`is_command`]).

use std::fmt;

/// The first two bytes of every frame.
pub const MAGIC: [u8; 2] = *b"FB";

/// The version that this program speaks.
pub const VERSION: u8 = 1;

/// Length of a command [bytes].
pub const COMMAND_BYTES: usize = 32;

/// Length of a measurement [bytes].
pub const MEASUREMENT_BYTES: usize = 40;

const COMMAND: u8 = 1;
const MEASUREMENT: u8 = 2;
const CHECKSUM_BYTES: usize = 4;

/// Host to rig: hold this voltage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// Number of the run, chosen by the host.
    pub session: u32,
    /// Instant of the run at which it was sent, modulo 2^32.
    pub sequence: u32,
    /// How long the voltage may stand without a newer command before the rig goes to 0 V by itself [ms].
    pub hold_ms: u16,
    /// [`Command::STOP`] or 0; a reader passes over the other bits.
    pub flags: u16,
    /// Voltage to hold from now on [V].
    pub voltage_v: f64,
}

impl Command {
    /// In `flags`: 0 V now, and until a new session.
    pub const STOP: u16 = 1;

    /// Whether it stops the rig.
    pub fn stops(&self) -> bool {
        self.flags & Command::STOP != 0
    }

    /// The bytes that go out.
    pub fn encode(&self) -> [u8; COMMAND_BYTES] {
        let mut bytes = [0; COMMAND_BYTES];
        bytes[..4].copy_from_slice(&head(COMMAND));
        bytes[4..8].copy_from_slice(&self.session.to_le_bytes());
        bytes[8..12].copy_from_slice(&self.sequence.to_le_bytes());
        bytes[12..14].copy_from_slice(&self.hold_ms.to_le_bytes());
        bytes[14..16].copy_from_slice(&self.flags.to_le_bytes());
        bytes[16..24].copy_from_slice(&self.voltage_v.to_le_bytes());
        sealed(bytes)
    }

    /// Errors: [`FrameError`], the first that applies in the order of its variants; fewer than four bytes are of a wrong length.
    pub fn decode(bytes: &[u8]) -> Result<Command, FrameError> {
        let mut fields = Fields::opened(bytes, COMMAND, COMMAND_BYTES)?;
        Ok(Command {
            session: u32::from_le_bytes(fields.take()?),
            sequence: u32::from_le_bytes(fields.take()?),
            hold_ms: u16::from_le_bytes(fields.take()?),
            flags: u16::from_le_bytes(fields.take()?),
            voltage_v: f64::from_le_bytes(fields.take()?),
        })
    }
}

/// Rig to host: the sensors, at the instant of the command that it answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Session of the command.
    pub session: u32,
    /// Sequence of the command.
    pub sequence: u32,
    /// [`Measurement::TIMED_OUT`] and the like, or 0; a reader passes over the other bits.
    pub status: u32,
    /// Hub angle [rad].
    pub theta_rad: f64,
    /// Deflection angle of the tip [rad].
    pub alpha_rad: f64,
    /// A number that changes when the rig restarts.
    pub boots: u32,
}

impl Measurement {
    /// In `status`: no command came in time, so the rig is at 0 V, and stays there until a new session.
    pub const TIMED_OUT: u32 = 1;
    /// In `status`: a stop command came, so the rig is at 0 V, and stays there until a new session.
    pub const STOPPED: u32 = 2;
    /// In `status`: a sensor is broken; the angles mean nothing.
    pub const SENSOR_FAULT: u32 = 4;

    /// The bytes that go out.
    pub fn encode(&self) -> [u8; MEASUREMENT_BYTES] {
        let mut bytes = [0; MEASUREMENT_BYTES];
        bytes[..4].copy_from_slice(&head(MEASUREMENT));
        bytes[4..8].copy_from_slice(&self.session.to_le_bytes());
        bytes[8..12].copy_from_slice(&self.sequence.to_le_bytes());
        bytes[12..16].copy_from_slice(&self.status.to_le_bytes());
        bytes[16..24].copy_from_slice(&self.theta_rad.to_le_bytes());
        bytes[24..32].copy_from_slice(&self.alpha_rad.to_le_bytes());
        bytes[32..36].copy_from_slice(&self.boots.to_le_bytes());
        sealed(bytes)
    }

    /// Errors: [`FrameError`], the first that applies in the order of its variants; fewer than four bytes are of a wrong length.
    pub fn decode(bytes: &[u8]) -> Result<Measurement, FrameError> {
        let mut fields = Fields::opened(bytes, MEASUREMENT, MEASUREMENT_BYTES)?;
        Ok(Measurement {
            session: u32::from_le_bytes(fields.take()?),
            sequence: u32::from_le_bytes(fields.take()?),
            status: u32::from_le_bytes(fields.take()?),
            theta_rad: f64::from_le_bytes(fields.take()?),
            alpha_rad: f64::from_le_bytes(fields.take()?),
            boots: u32::from_le_bytes(fields.take()?),
        })
    }
}

/// Why bytes are no frame of the kind that was wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// Not "FB" in front: another program's.
    Magic,
    /// Another version, before the check sum is looked at: ask [`is_sealed`] whether to believe it.
    Version {
        /// Version found.
        found: u8,
    },
    /// No frame has this length; or not one of this kind.
    Length {
        /// Length found [bytes].
        found: usize,
    },
    /// The bytes were changed on their way.
    Checksum,
    /// The other direction's, or unknown: a line that echoes.
    Kind {
        /// Kind found.
        found: u8,
    },
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FrameError::Magic => write!(f, "bytes that begin otherwise than a frame does"),
            FrameError::Version { found } => write!(f, "a frame of version {found}; this program speaks {VERSION}"),
            FrameError::Length { found } => write!(f, "{found} bytes, which no frame of its kind has"),
            FrameError::Checksum => write!(f, "a frame whose check sum is wrong"),
            FrameError::Kind { found } => write!(f, "a frame of kind {found}"),
        }
    }
}

impl std::error::Error for FrameError {}

/// Whether the last four bytes are the check sum of all before them, as in every version.
pub fn is_sealed(bytes: &[u8]) -> bool {
    bytes.split_last_chunk().is_some_and(|(body, seal)| *seal == checksum(body))
}

/// Whether it is a command of any version, as far as its head and its seal tell.
pub fn is_command(bytes: &[u8]) -> bool {
    let [first, second] = MAGIC;
    matches!(*bytes, [a, b, _, COMMAND, _, _, _, _, ..] if a == first && b == second) && is_sealed(bytes)
}

/// CRC-32 of IEEE 802.3.
fn checksum(body: &[u8]) -> [u8; CHECKSUM_BYTES] {
    crc32fast::hash(body).to_le_bytes()
}

fn head(kind: u8) -> [u8; 4] {
    let [first, second] = MAGIC;
    [first, second, VERSION, kind]
}

fn sealed<const N: usize>(mut bytes: [u8; N]) -> [u8; N] {
    if let Some((body, seal)) = bytes.split_last_chunk_mut() {
        *seal = checksum(body);
    }
    bytes
}

/// What is left of a frame that is being read.
struct Fields<'a> {
    rest: &'a [u8],
    length: usize,
}

impl<'a> Fields<'a> {
    /// Behind the head of a frame that is whole, of our version and of this kind.
    fn opened(bytes: &'a [u8], kind: u8, length: usize) -> Result<Fields<'a>, FrameError> {
        let wrong_length = FrameError::Length { found: bytes.len() };
        let Some((&[first, second, version, found], rest)) = bytes.split_first_chunk() else {
            return Err(wrong_length);
        };
        if [first, second] != MAGIC {
            Err(FrameError::Magic)
        } else if version != VERSION {
            Err(FrameError::Version { found: version })
        } else if ![COMMAND_BYTES, MEASUREMENT_BYTES].contains(&bytes.len()) {
            Err(wrong_length)
        } else if !is_sealed(bytes) {
            Err(FrameError::Checksum)
        } else if found != kind {
            Err(FrameError::Kind { found })
        } else if bytes.len() != length {
            Err(wrong_length)
        } else {
            Ok(Fields { rest, length })
        }
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], FrameError> {
        let Some((field, rest)) = self.rest.split_first_chunk() else {
            return Err(FrameError::Length { found: self.length });
        };
        self.rest = rest;
        Ok(*field)
    }
}
