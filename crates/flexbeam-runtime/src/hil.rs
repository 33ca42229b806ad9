//! A rig behind a board of Quanser's, through the vendor's HIL library, which is opened at run time.
//!
//! Enters: a motor voltage a period. Leaves: hub angle and deflection of the same instant. Deliberately absent: anything
//! linked from Quanser; buffered and timed input and output, because the loop has its own clock.

mod card;

use crate::back_end::{Answer, BackEnd, Counters, Cutoff, LinkFault, OpenError, Timing};
use crate::board::{BoardMap, Counter, MAP_KEYS, PortText};
use card::{Card, Code, Reading, Wiring};
use flexbeam_rig::Measurement;

/// What the board's own watchdog is asked to do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BoardWatchdog {
    /// To take the output to 0 V when it expires. `set` in a port's text.
    #[default]
    Set,
    /// To run; what it does on expiry is fixed in the board, and its manual says 0 V. `fixed` in a port's text.
    Fixed,
    /// Nothing: the board has none. A killed process then leaves its last voltage standing. `none` in a port's text.
    Absent,
}

/// Which board, and how the rig is wired to it.
#[derive(Clone, Debug, PartialEq)]
pub struct HilPort {
    /// Board type as Quanser's manual names it: `q2_usb`.
    pub board_type: String,
    /// Which board of this type: `0` is the first.
    pub identifier: String,
    /// Channels and calibration.
    pub map: BoardMap,
    /// What the board's watchdog does. Default [`BoardWatchdog::Set`].
    pub watchdog: BoardWatchdog,
    /// Bits of the encoder's counter that are looked at, 8 to 32. Default 24, which suits wider counters too.
    pub counter_bits: u32,
    /// Digital lines from 0 that the watchdog makes high-impedance. The Q8 needs all of its 32, else its watchdog leaves the
    /// analogue outputs alone. Default 0.
    pub tristate_lines: u32,
    /// File of the library. Default none: the names under which Quanser installs it.
    pub library: Option<String>,
}

/// Keys beside those of the map.
const KEYS: [&str; 4] = ["watchdog", "counter_bits", "tristate", "library"];

/// No board has as many digital lines.
const MOST_LINES: u32 = 1024;

impl HilPort {
    /// Real-time: no. A board with everything else at its default.
    pub fn new(board_type: &str, identifier: &str) -> HilPort {
        HilPort {
            board_type: board_type.into(),
            identifier: identifier.into(),
            map: BoardMap::default(),
            watchdog: BoardWatchdog::default(),
            counter_bits: 24,
            tristate_lines: 0,
            library: None,
        }
    }

    /// Real-time: no. From the text after `hil:`, as in `q2_usb:0?encoder=0,output=0,gauge=0,rad_per_v=0.0606,theta=-1`.
    ///
    /// Errors: a key that is unknown or stands twice, a value that is none, a device without type or identifier.
    pub fn parse(text: &str) -> Result<HilPort, OpenError> {
        const WATCHDOGS: [(&str, BoardWatchdog); 3] =
            [("set", BoardWatchdog::Set), ("fixed", BoardWatchdog::Fixed), ("none", BoardWatchdog::Absent)];
        let known: Vec<&str> = MAP_KEYS.into_iter().chain(KEYS).collect();
        let port = PortText::read(text, &known)?;
        let (board_type, identifier) = device(port.device)?;
        let default = HilPort::new(board_type, identifier);
        Ok(HilPort {
            map: port.map()?,
            watchdog: port.choice("watchdog", &WATCHDOGS, default.watchdog)?,
            counter_bits: within("counter_bits", 8..=32, port.value("counter_bits", 24, "a number of bits")?)?,
            tristate_lines: within("tristate", 0..=MOST_LINES, port.value("tristate", 0, "a number of lines")?)?,
            library: port.word("library").map(String::from),
            ..default
        })
    }
}

fn device(text: &str) -> Result<(&str, &str), OpenError> {
    let parts =
        text.split_once(':').filter(|(board_type, identifier)| !board_type.is_empty() && !identifier.is_empty());
    parts.ok_or_else(|| OpenError {
        found: format!("\"{text}\" in the port's text"),
        needed: "board type and identifier, with a colon between them".into(),
        hint: "hil:q2_usb:0 is the first Q2-USB".into(),
    })
}

fn within(key: &str, range: std::ops::RangeInclusive<u32>, found: u32) -> Result<u32, OpenError> {
    range.contains(&found).then_some(found).ok_or_else(|| OpenError {
        found: format!("{key}={found} in the port's text"),
        needed: format!("{} to {}", range.start(), range.end()),
        hint: "the board's manual has the number".into(),
    })
}

/// Whether the board's watchdog runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Watch {
    Idle,
    Running,
}

/// A rig behind a board of Quanser's. theta is zero where the hub stood when the board was opened.
///
/// An exchange takes as long as the board takes to answer: the library has no time-out, so that [`Answer::Lost`] never comes
/// and a hanging call is ended by the board's watchdog, which needs no thread of ours. Dropped, also by a panic, it writes
/// 0 V, stops the watchdog and closes the board.
pub struct HilRig {
    card: Card,
    port: HilPort,
    wiring: Wiring,
    counter: Counter,
    watch: Watch,
    hold_s: f64,
}

impl HilRig {
    /// Real-time: no. Opens library and board, writes 0 V and takes the hub's angle as zero.
    ///
    /// Errors: no library, a library without a function that is needed, a board that does not open, a channel that it does not
    /// have; each with the library's own words.
    pub fn open(port: &HilPort) -> Result<HilRig, OpenError> {
        port.map.check()?;
        let card = Card::open(port.library.as_deref(), &port.board_type, &port.identifier)?;
        let wiring = Wiring {
            analog_input: port.map.gauge_input,
            encoder: port.map.encoder,
            analog_output: port.map.analog_output,
        };
        let greatest = u32::MAX >> (32 - port.counter_bits.clamp(8, 32));
        let counter = Counter::new(greatest, 0);
        let mut rig = HilRig { card, port: port.clone(), wiring, counter, watch: Watch::Idle, hold_s: 0.0 };
        rig.calmed()?;
        rig.take_zero()?;
        rig.rest()?;
        Ok(rig)
    }

    fn take_zero(&mut self) -> Result<(), OpenError> {
        let hint = "encoder=N in the port's text is an encoder input of the board";
        let taken = self.card.set_encoder_counts(self.wiring.encoder, 0);
        taken.map_err(|code| self.card.refused("hil_set_encoder_counts", code, hint))
    }

    /// Sends 0 V and reads what an exchange reads.
    fn rest(&mut self) -> Result<(), OpenError> {
        let reading = self.card.read_write(&self.wiring, 0.0).map_err(|code| {
            let hint = "output, encoder and gauge in the port's text are channels that the board has, counted from 0";
            self.card.refused("hil_read_write", code, hint)
        })?;
        self.measured(reading);
        Ok(())
    }

    fn measured(&mut self, reading: Reading) -> Measurement {
        // The library's counts are signed; the counter takes the same bits.
        let counts = self.counter.counts(reading.counts as u32);
        self.port.map.measurement(counts, reading.gauge_v)
    }

    /// Ends the watch of an earlier run, of this process or of one that was killed, and takes the output to 0 V.
    fn calm(&mut self) -> Result<(), Code> {
        if self.watches() {
            let expired = self.card.watchdog_is_expired()?;
            let stopped = self.card.watchdog_stop();
            if expired || self.watch == Watch::Running {
                stopped?;
            }
            if expired {
                self.card.watchdog_clear()?;
            }
            self.watch = Watch::Idle;
        }
        // At once: clearing may bring back the voltage that stood when the watchdog expired.
        self.card.write_analog(self.wiring.analog_output, 0.0)
    }

    /// Errors: a board that stays closed, or has no such output.
    fn calmed(&mut self) -> Result<(), OpenError> {
        self.calm().map_err(|code| {
            let hint =
                "output=N in the port's text is a channel of the board; for a board without watchdog: watchdog=none";
            self.card.refused("the calls that take the board to 0 V", code, hint)
        })
    }

    /// Tells the board what to do on expiry.
    fn arm(&mut self) -> Result<(), OpenError> {
        let hint = "watchdog=fixed for a board that goes to 0 V by itself, watchdog=none for one without watchdog";
        if self.port.watchdog == BoardWatchdog::Set {
            let set = self.card.set_analog_expiration(self.wiring.analog_output, 0.0);
            set.map_err(|code| self.card.refused("hil_watchdog_set_analog_expiration_state", code, hint))?;
        }
        if self.port.tristate_lines > 0 {
            let set = self.card.set_digital_expiration(self.port.tristate_lines);
            set.map_err(|code| {
                self.card.refused("hil_watchdog_set_digital_expiration_state", code, "tristate=N in the port's text")
            })?;
        }
        // Tried here, where nothing moves, and started for good by the first exchange: the time until then is unknown.
        let tried = self.card.watchdog_start(self.hold_s);
        tried.map_err(|code| self.card.refused(&format!("hil_watchdog_start({} s)", self.hold_s), code, hint))?;
        self.watch = Watch::Running;
        // Not stopped by hand: this process may have been asleep for longer than the watchdog waits.
        self.calmed()
    }

    /// Real-time: yes. Why a call was refused: an expired watchdog closes the board, and that is the reason to tell.
    fn fault(&mut self, code: Code) -> LinkFault {
        let expired = self.watch == Watch::Running && self.card.watchdog_is_expired() == Ok(true);
        if expired { LinkFault::RigTimedOut } else { LinkFault::Board { code } }
    }

    fn watches(&self) -> bool {
        self.port.watchdog != BoardWatchdog::Absent
    }

    /// Real-time: yes. Starts the watchdog before the first voltage of a run.
    fn watch(&mut self) -> Result<(), LinkFault> {
        if self.watches() && self.watch == Watch::Idle {
            self.card.watchdog_start(self.hold_s).map_err(|code| LinkFault::Board { code })?;
            self.watch = Watch::Running;
        }
        Ok(())
    }

    /// Real-time: yes. Tells the watchdog that the voltage just sent is alive.
    fn reload(&mut self) -> Result<(), LinkFault> {
        if !self.watches() {
            return Ok(());
        }
        match self.card.watchdog_reload() {
            Ok(true) => Ok(()),
            Ok(false) => Err(LinkFault::RigTimedOut),
            Err(code) => Err(self.fault(code)),
        }
    }
}

impl BackEnd for HilRig {
    /// Real-time: yes, as far as the library is. One `hil_read_write` that writes the output and reads encoder and gauge, one
    /// `hil_watchdog_reload`.
    fn exchange(&mut self, _instant: u64, voltage_v: f64) -> Result<Answer, LinkFault> {
        self.watch()?;
        let board_v = self.port.map.board_v(voltage_v);
        let reading = self.card.read_write(&self.wiring, board_v).map_err(|code| self.fault(code))?;
        self.reload()?;
        Ok(Answer::Fresh(self.measured(reading)))
    }

    /// Real-time: yes, as far as the library is. 0 V, then the watchdog may rest; where 0 V does not go out it keeps running
    /// and expires.
    fn zero(&mut self) -> Result<(), LinkFault> {
        match self.card.write_analog(self.wiring.analog_output, 0.0).map_err(|code| self.fault(code)) {
            // The board is at 0 V by itself and takes no other voltage.
            Err(LinkFault::RigTimedOut) => Ok(()),
            Err(fault) => Err(fault),
            Ok(()) => {
                if self.watch == Watch::Running && self.card.watchdog_stop().is_ok() {
                    self.watch = Watch::Idle;
                }
                Ok(())
            }
        }
    }

    /// Real-time: no. 0 V, the state of the board on expiry of its watchdog, one trial of the watchdog, one reading.
    fn prepare(&mut self, timing: Timing) -> Result<(), OpenError> {
        self.hold_s = timing.hold_s;
        self.calmed()?;
        if self.watches() {
            self.arm()?;
        }
        self.rest()
    }

    /// Real-time: no. None: Quanser does not document whether two threads may use one board. Its watchdog is the second road.
    fn cutoff(&self) -> Option<Box<dyn Cutoff>> {
        None
    }

    /// Real-time: yes. All zero: a board loses nothing.
    fn counters(&self) -> Counters {
        Counters::default()
    }

    /// Real-time: no.
    fn name(&self) -> String {
        format!("hil:{}:{}", self.port.board_type, self.port.identifier)
    }

    /// Real-time: no. With the library's own text for a code.
    fn explain(&self, fault: LinkFault) -> String {
        match fault {
            LinkFault::Board { code } => match self.card.text(code) {
                Some(text) => format!("{fault}: {text}"),
                None => format!("{fault}, for which it has no text"),
            },
            LinkFault::RigTimedOut => format!("{fault} (the board's watchdog expired after {} s)", self.hold_s),
            other => other.to_string(),
        }
    }
}

impl Drop for HilRig {
    fn drop(&mut self) {
        // What fails here cannot be told any more; the watchdog, which then runs on, is what is left.
        let _ = self.zero();
    }
}
