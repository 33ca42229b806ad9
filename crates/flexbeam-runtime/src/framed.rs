//! A rig behind frames: the back end that UDP and the serial line share.
//!
//! Enters: instants and voltages from the loop. Leaves: readings, or what became of them. One command goes out per exchange,
//! and whatever lies in the wire is judged until the command's own answer is found or the time is over: three system calls in
//! the usual case (send, sleep, receive), no allocation, no lock.
//! Deliberately absent: what the frames mean (`exchange.rs`), how they travel ([`crate::wire`]).

use crate::back_end::{Answer, BackEnd, Counters, Cutoff, LinkFault, OpenError, Timing};
use crate::exchange::{Exchange, GREETINGS, Greeted, stop};
use crate::wire::{Broken, FrameBuffer, HostWire, LONGEST_FRAME, Received, wait};
use flexbeam_files::frame::VERSION;
use flexbeam_rig::Measurement;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// How long one greeting waits for its answer; 50 of them make a second.
const GREETING_WAIT: Duration = Duration::from_millis(20);

/// Stop commands in a row, since each may be lost.
const STOPS: u32 = 3;

/// Frames that are thrown away before a run, at most: a wire that never falls silent is met by the greetings.
const MOST_LEFT_BEHIND: usize = 10_000;

/// The longest hold that a frame can state [s].
const LONGEST_HOLD_S: f64 = u16::MAX as f64 / 1000.0;

/// A rig that answers frames. See [`crate::udp::UdpRig`] and [`crate::serial::SerialRig`].
///
/// The seed that it is opened with decides the numbers of its sessions. It has to differ from run to run: a rig takes a session
/// that it has just had for the old one, and stays silent or at 0 V.
pub struct FramedRig<W> {
    wire: W,
    name: String,
    /// What to look at when nothing can be read.
    hint: &'static str,
    seed: u64,
    runs: u64,
    wait: Duration,
    exchange: Exchange,
    gate: Arc<Gate>,
    buffer: FrameBuffer,
}

/// What the loop's thread and the watchdog's share.
#[derive(Debug, Default)]
struct Gate {
    shut: AtomicBool,
    session: AtomicU32,
}

impl From<Broken> for LinkFault {
    /// Real-time: yes.
    fn from(broken: Broken) -> LinkFault {
        LinkFault::Gone { errno: broken.errno }
    }
}

impl<W: HostWire> FramedRig<W> {
    /// Real-time: no.
    pub(crate) fn new(wire: W, name: String, hint: &'static str, seed: u64) -> FramedRig<W> {
        FramedRig {
            wire,
            name,
            hint,
            seed,
            runs: 0,
            wait: Duration::ZERO,
            exchange: Exchange::default(),
            gate: Arc::default(),
            buffer: [0; LONGEST_FRAME],
        }
    }

    /// Real-time: no. Greets until the rig answers.
    fn greet(&mut self) -> Result<(), OpenError> {
        let mut met = Met::Nothing;
        for left in (1..=GREETINGS).rev() {
            let sent = Instant::now();
            if let Err(Broken { errno }) = self.wire.send(&self.exchange.greeting(left).encode()) {
                met = met.or(Met::Broken(errno));
            }
            match self.listen(sent) {
                Ok(Some(Greeted::Answered)) => return Ok(()),
                Ok(Some(Greeted::Version(found))) => return Err(self.other_version(found)),
                Ok(Some(Greeted::Unreadable)) => met = Met::Unreadable,
                Ok(Some(Greeted::Foreign) | None) => {}
                Err(Broken { errno }) => met = met.or(Met::Broken(errno)),
            }
            // A refused greeting comes back at once, and the rig may be about to start.
            std::thread::sleep(GREETING_WAIT.saturating_sub(sent.elapsed()));
        }
        Err(self.no_answer(met))
    }

    /// Real-time: no. What came within [`GREETING_WAIT`] of `sent`: the answer, or else the last other thing.
    fn listen(&mut self, sent: Instant) -> Result<Option<Greeted>, Broken> {
        let mut other = None;
        loop {
            let left = GREETING_WAIT.saturating_sub(sent.elapsed());
            let woken = wait(self.wire.descriptor(), left);
            while let Received::Frame(length) = self.wire.receive(&mut self.buffer)? {
                match self.exchange.greeted(self.buffer.get(..length).unwrap_or_default()) {
                    decided @ (Greeted::Answered | Greeted::Version(_)) => return Ok(Some(decided)),
                    kept => other = Some(kept),
                }
                if sent.elapsed() > GREETING_WAIT {
                    return Ok(other);
                }
            }
            if !woken || left.is_zero() {
                return Ok(other);
            }
        }
    }

    /// Real-time: no. What an earlier run has left in the wire is thrown away.
    fn drain(&mut self) {
        for _ in 0..MOST_LEFT_BEHIND {
            // An error of an earlier run is reported by the next send, should it still hold.
            if matches!(self.wire.receive(&mut self.buffer), Ok(Received::Nothing) | Err(_)) {
                return;
            }
        }
    }

    /// Real-time: no.
    fn other_version(&self, found: u8) -> OpenError {
        OpenError {
            found: format!("a rig at {} that speaks frame version {found}", self.name),
            needed: format!("frame version {VERSION}"),
            hint: "bring the rig's firmware and this program to the same version".into(),
        }
    }

    /// Real-time: no.
    fn no_answer(&self, met: Met) -> OpenError {
        let found = match met {
            Met::Nothing => format!("no answer from {} within a second", self.name),
            Met::Broken(errno) => {
                let words = std::io::Error::from_raw_os_error(errno);
                format!("no answer from {} within a second ({words})", self.name)
            }
            Met::Unreadable => format!("bytes from {} that are no frames", self.name),
        };
        OpenError { found, needed: "a rig that answers a greeting".into(), hint: self.hint.into() }
    }

    /// Real-time: yes. The answer to the last command, or nothing when `self.wait` since `sent` is over.
    fn answer(&mut self, sent: Instant) -> Result<Answer, LinkFault> {
        loop {
            let left = self.wait.saturating_sub(sent.elapsed());
            let woken = wait(self.wire.descriptor(), left);
            if let Some(measurement) = self.take_in(sent)? {
                return Ok(Answer::Fresh(measurement));
            }
            if !woken || left.is_zero() {
                self.exchange.lost();
                return Ok(Answer::Lost);
            }
        }
    }

    /// Real-time: yes. Judges what lies in the wire, as far as the time reaches; at least one frame, however late it is.
    fn take_in(&mut self, sent: Instant) -> Result<Option<Measurement>, LinkFault> {
        while let Received::Frame(length) = self.wire.receive(&mut self.buffer)? {
            let heard = self.exchange.hear(self.buffer.get(..length).unwrap_or_default())?;
            if heard.is_some() || sent.elapsed() > self.wait {
                return Ok(heard);
            }
        }
        Ok(None)
    }
}

/// What greetings met instead of an answer.
#[derive(Clone, Copy)]
enum Met {
    Nothing,
    Broken(i32),
    Unreadable,
}

impl Met {
    /// Real-time: no. Bytes that cannot be read say more than a refusal.
    fn or(self, other: Met) -> Met {
        if matches!(self, Met::Unreadable) { self } else { other }
    }
}

impl<W: HostWire> BackEnd for FramedRig<W> {
    /// Real-time: yes. As the trait says; three system calls.
    fn exchange(&mut self, instant: u64, voltage_v: f64) -> Result<Answer, LinkFault> {
        if self.gate.shut.load(Ordering::Acquire) {
            return Err(LinkFault::CutOff);
        }
        let sent = Instant::now();
        self.wire.send(&self.exchange.command(instant, voltage_v).encode())?;
        self.answer(sent)
    }

    /// Real-time: yes. Three stop commands, without waiting for an answer: the rig obeys no voltage until it is prepared again.
    fn zero(&mut self) -> Result<(), LinkFault> {
        Ok(stop_several(&self.wire, &self.exchange.stop().encode())?)
    }

    /// Real-time: no. A new session: greets the rig with 0 V for up to a second. The rig's time-out counts from the first
    /// exchange on.
    fn prepare(&mut self, timing: Timing) -> Result<(), OpenError> {
        let hold_ms = hold_ms(timing)?;
        self.wait = wait_of(timing)?;
        self.exchange = Exchange::new(session(self.seed, self.runs), hold_ms);
        self.runs = self.runs.wrapping_add(1);
        self.gate.session.store(self.exchange.session(), Ordering::Release);
        self.gate.shut.store(false, Ordering::Release);
        self.drain();
        self.greet()
    }

    /// Real-time: no. Sends stop commands by itself.
    fn cutoff(&self) -> Option<Box<dyn Cutoff>> {
        Some(Box::new(FrameCutoff { wire: self.wire.second(), gate: Arc::clone(&self.gate) }))
    }

    /// Real-time: yes.
    fn counters(&self) -> Counters {
        self.exchange.counters()
    }

    /// Real-time: no.
    fn name(&self) -> String {
        self.name.clone()
    }
}

/// The watchdog's road to a rig.
struct FrameCutoff<W> {
    wire: W,
    gate: Arc<Gate>,
}

impl<W: HostWire> Cutoff for FrameCutoff<W> {
    /// Real-time: yes. A voltage that the loop's thread was about to send finds the rig stopped.
    fn cut(&self) {
        self.gate.shut.store(true, Ordering::Release);
        let stop = stop(self.gate.session.load(Ordering::Acquire), 0);
        // A rig that cannot be reached any more goes to 0 V by its own time-out.
        let _ = stop_several(&self.wire, &stop.encode());
    }
}

/// Real-time: yes. Sends it [`STOPS`] times.
///
/// Errors: none of them went out.
fn stop_several(wire: &impl HostWire, frame: &[u8]) -> Result<(), Broken> {
    let mut result = wire.send(frame);
    for _ in 1..STOPS {
        result = wire.send(frame).or(result);
    }
    result
}

/// Real-time: no. The number of a run's session: the finaliser of SplitMix64, whose 32 upper bits are well mixed. Never 0, which
/// a rig puts into answers to hosts of another version.
fn session(seed: u64, run: u64) -> u32 {
    let mut x = seed.wrapping_add(run.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (((x ^ (x >> 31)) >> 32) as u32).max(1)
}

/// Real-time: no. Rounded up to whole milliseconds.
fn hold_ms(timing: Timing) -> Result<u16, OpenError> {
    let Timing { period_s, hold_s, .. } = timing;
    if !(hold_s > period_s && hold_s <= LONGEST_HOLD_S) {
        return Err(OpenError {
            found: format!("a hold of {hold_s} s"),
            needed: format!("more than the period of {period_s} s and at most {LONGEST_HOLD_S} s"),
            hint: "a few tens of periods let the link lose some frames and still stop the rig in time".into(),
        });
    }
    Ok((hold_s * 1000.0).ceil() as u16)
}

/// Real-time: no.
fn wait_of(timing: Timing) -> Result<Duration, OpenError> {
    let Timing { wait_s, hold_s, .. } = timing;
    if !(0.0..=hold_s).contains(&wait_s) {
        return Err(OpenError {
            found: format!("a wait of {wait_s} s for an answer"),
            needed: format!("0 to the hold of {hold_s} s"),
            hint: "wait for less than a period: the loop has to compute, too".into(),
        });
    }
    Ok(Duration::from_secs_f64(wait_s))
}
