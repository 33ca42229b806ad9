//! Quanser's HIL library as C knows it, and one open card.
//!
//! Enters: channels and volts. Leaves: readings, or the library's own negative codes. Signatures as in the vendor's hil.h
//! and quanser_messages.h.

use crate::back_end::OpenError;
use crate::board::{Library, Missing, c_text};
use std::ffi::{CStr, c_char, c_double, c_int, c_uint, c_void};
use std::ptr::{null, null_mut};

/// Names under which Linux packages install the library, newest first.
const NAMES: [&str; 2] = ["libhil.so.1", "libhil.so"];

/// What libhil needs, and what holds the error texts.
const COMPANIONS: [[&str; 2]; 2] =
    [["libquanser_common.so.1", "libquanser_common.so"], ["libquanser_runtime.so.1", "libquanser_runtime.so"]];

const MISSING: Missing = Missing {
    library: "Quanser's HIL library",
    hint: "install Quanser's SDK (its package is quanser-sdk), or name the file in the port: library=/path/libhil.so",
};

const OTHER_LIBRARY: &str =
    "flexbeam needs Quanser's HIL library with its watchdog functions, as the Quanser SDK has it";

/// `DIGITAL_STATE_TRISTATE` of `t_digital_state`.
const TRISTATE: c_int = 2;

/// A negative number with which the library refuses a call.
pub(super) type Code = i32;

type RawCard = *mut c_void;
type Channels = *const c_uint;
type Open = unsafe extern "C" fn(*const c_char, *const c_char, *mut RawCard) -> c_int;
type OfCard = unsafe extern "C" fn(RawCard) -> c_int;
type SetVolts = unsafe extern "C" fn(RawCard, Channels, c_uint, *const c_double) -> c_int;
type SetInts = unsafe extern "C" fn(RawCard, Channels, c_uint, *const c_int) -> c_int;
type Start = unsafe extern "C" fn(RawCard, c_double) -> c_int;
type Message = unsafe extern "C" fn(*const c_char, c_int, *mut c_char, usize) -> c_int;
/// Inputs: analogue, encoder, digital, other. Outputs: analogue, PWM, digital, other. Then the buffers in the same order.
type ReadWrite = unsafe extern "C" fn(
    RawCard,
    Channels,
    c_uint,
    Channels,
    c_uint,
    Channels,
    c_uint,
    Channels,
    c_uint,
    Channels,
    c_uint,
    Channels,
    c_uint,
    Channels,
    c_uint,
    Channels,
    c_uint,
    *mut c_double,
    *mut c_int,
    *mut c_char,
    *mut c_double,
    *const c_double,
    *const c_double,
    *const c_char,
    *const c_double,
) -> c_int;

/// The functions in use.
struct Functions {
    open: Open,
    close: OfCard,
    read_write: ReadWrite,
    write_analog: SetVolts,
    set_encoder_counts: SetInts,
    set_analog_expiration: SetVolts,
    set_digital_expiration: SetInts,
    watchdog_start: Start,
    watchdog_reload: OfCard,
    watchdog_is_expired: OfCard,
    watchdog_stop: OfCard,
    watchdog_clear: OfCard,
    /// Absent where neither the library nor its companions have it; codes are then told without their text.
    message: Option<Message>,
}

impl Functions {
    fn load(named: Option<&str>) -> Result<Functions, OpenError> {
        let companions: Vec<Library> = COMPANIONS.iter().filter_map(|names| Library::companion(names)).collect();
        let library = match named {
            Some(name) => Library::open(&[name], &MISSING)?,
            None => Library::open(&NAMES, &MISSING)?,
        };
        let texts = [&library].into_iter().chain(&companions);
        // SAFETY: each type is that of the function in hil.h and quanser_messages.h, with t_error, t_int32 and enums as
        // int, t_uint32 and t_uint as unsigned int, t_double as double, t_boolean as char.
        unsafe {
            Ok(Functions {
                open: library.function("hil_open", OTHER_LIBRARY)?,
                close: library.function("hil_close", OTHER_LIBRARY)?,
                read_write: library.function("hil_read_write", OTHER_LIBRARY)?,
                write_analog: library.function("hil_write_analog", OTHER_LIBRARY)?,
                set_encoder_counts: library.function("hil_set_encoder_counts", OTHER_LIBRARY)?,
                set_analog_expiration: library.function("hil_watchdog_set_analog_expiration_state", OTHER_LIBRARY)?,
                set_digital_expiration: library.function("hil_watchdog_set_digital_expiration_state", OTHER_LIBRARY)?,
                watchdog_start: library.function("hil_watchdog_start", OTHER_LIBRARY)?,
                watchdog_reload: library.function("hil_watchdog_reload", OTHER_LIBRARY)?,
                watchdog_is_expired: library.function("hil_watchdog_is_expired", OTHER_LIBRARY)?,
                watchdog_stop: library.function("hil_watchdog_stop", OTHER_LIBRARY)?,
                watchdog_clear: library.function("hil_watchdog_clear", OTHER_LIBRARY)?,
                message: texts.filter_map(|l| l.function("msg_get_error_messageA", OTHER_LIBRARY).ok()).next(),
            })
        }
    }
}

/// Channels that an exchange uses.
#[derive(Clone, Copy)]
pub(super) struct Wiring {
    pub analog_input: u32,
    pub encoder: u32,
    pub analog_output: u32,
}

/// What one exchange read.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reading {
    pub counts: i32,
    pub gauge_v: f64,
}

/// An open card; closed when dropped.
pub(super) struct Card {
    functions: Functions,
    raw: RawCard,
}

// SAFETY: the handle is the library's, not a thread's; `&mut self` on every call that uses it keeps it to one thread at a time.
unsafe impl Send for Card {}

impl Card {
    /// Real-time: no. The library, and the card behind it.
    ///
    /// Errors: no library, not this library, no such card.
    pub(super) fn open(named: Option<&str>, board_type: &str, identifier: &str) -> Result<Card, OpenError> {
        let functions = Functions::load(named)?;
        let mut card = Card { functions, raw: null_mut() };
        let (c_type, c_identifier) = (c_text(board_type)?, c_text(identifier)?);
        // SAFETY: both texts end in NUL and outlive the call, which writes one handle to `raw`.
        let code = unsafe { (card.functions.open)(c_type.as_ptr(), c_identifier.as_ptr(), &mut card.raw) };
        checked(code).map_err(|code| {
            card.raw = null_mut();
            let hint = "board type and identifier are those of Quanser's manual: hil:q2_usb:0, hil:q8_usb:0";
            card.refused(&format!("hil_open(\"{board_type}\", \"{identifier}\")"), code, hint)
        })?;
        Ok(card)
    }

    /// Real-time: yes, as far as the library is: it does not return before the board answered. Sends a voltage, reads encoder
    /// and gauge.
    pub(super) fn read_write(&mut self, wiring: &Wiring, board_v: f64) -> Result<Reading, Code> {
        let mut reading = Reading::default();
        let none: Channels = null();
        // SAFETY: each count of 1 goes with one channel and a buffer of one element of the documented type, all on this frame;
        // the kinds that are not used have count 0, with which the library reads no pointer (QUARC's own code passes null).
        let code = unsafe {
            (self.functions.read_write)(
                self.raw,
                &wiring.analog_input,
                1,
                &wiring.encoder,
                1,
                none,
                0,
                none,
                0,
                &wiring.analog_output,
                1,
                none,
                0,
                none,
                0,
                none,
                0,
                &mut reading.gauge_v,
                &mut reading.counts,
                null_mut(),
                null_mut(),
                &board_v,
                null(),
                null(),
                null(),
            )
        };
        checked(code).map(|_| reading)
    }

    /// Real-time: yes, as [`Card::read_write`].
    pub(super) fn write_analog(&mut self, channel: u32, board_v: f64) -> Result<(), Code> {
        // SAFETY: one channel, one voltage, both on this frame.
        checked(unsafe { (self.functions.write_analog)(self.raw, &channel, 1, &board_v) }).map(|_| ())
    }

    /// Real-time: no.
    pub(super) fn set_encoder_counts(&mut self, channel: u32, counts: i32) -> Result<(), Code> {
        // SAFETY: one channel, one number, both on this frame.
        checked(unsafe { (self.functions.set_encoder_counts)(self.raw, &channel, 1, &counts) }).map(|_| ())
    }

    /// Real-time: no. The voltage that the board takes when its watchdog expires.
    pub(super) fn set_analog_expiration(&mut self, channel: u32, board_v: f64) -> Result<(), Code> {
        // SAFETY: one channel, one voltage, both on this frame.
        checked(unsafe { (self.functions.set_analog_expiration)(self.raw, &channel, 1, &board_v) }).map(|_| ())
    }

    /// Real-time: no. Digital lines 0 to `lines` - 1 let go of their pins when the watchdog expires.
    pub(super) fn set_digital_expiration(&mut self, lines: u32) -> Result<(), Code> {
        let channels: Vec<c_uint> = (0..lines).collect();
        let states = vec![TRISTATE; channels.len()];
        // SAFETY: both vectors hold `lines` elements and outlive the call.
        let code =
            unsafe { (self.functions.set_digital_expiration)(self.raw, channels.as_ptr(), lines, states.as_ptr()) };
        checked(code).map(|_| ())
    }

    /// Real-time: yes, as [`Card::read_write`].
    pub(super) fn watchdog_start(&mut self, timeout_s: f64) -> Result<(), Code> {
        // SAFETY: the handle is open.
        checked(unsafe { (self.functions.watchdog_start)(self.raw, timeout_s) }).map(|_| ())
    }

    /// Real-time: yes, as [`Card::read_write`]. Whether the watchdog was still running.
    pub(super) fn watchdog_reload(&mut self) -> Result<bool, Code> {
        self.of_card(self.functions.watchdog_reload).map(|answer| answer != 0)
    }

    /// Real-time: yes, as [`Card::read_write`].
    pub(super) fn watchdog_is_expired(&mut self) -> Result<bool, Code> {
        self.of_card(self.functions.watchdog_is_expired).map(|answer| answer != 0)
    }

    /// Real-time: yes, as [`Card::read_write`].
    pub(super) fn watchdog_stop(&mut self) -> Result<(), Code> {
        self.of_card(self.functions.watchdog_stop).map(|_| ())
    }

    /// Real-time: no. Opens the outputs again that an expiry closed. What they then hold is the board's affair.
    pub(super) fn watchdog_clear(&mut self) -> Result<(), Code> {
        self.of_card(self.functions.watchdog_clear).map(|_| ())
    }

    fn of_card(&mut self, function: OfCard) -> Result<c_int, Code> {
        // SAFETY: the handle is open, and each function of this type takes nothing else.
        checked(unsafe { function(self.raw) })
    }

    /// Real-time: no. The library's own words for a code; nothing where it has none.
    pub(super) fn text(&self, code: Code) -> Option<String> {
        let mut buffer = [0 as c_char; 512];
        // SAFETY: the buffer is as long as the call is told; a null locale is documented as the default one.
        let found = unsafe { (self.functions.message?)(null(), code, buffer.as_mut_ptr(), buffer.len()) };
        buffer[buffer.len() - 1] = 0;
        // SAFETY: the last element is 0, so that the text ends within the buffer.
        let text = unsafe { CStr::from_ptr(buffer.as_ptr()) }.to_string_lossy().trim().to_owned();
        (found >= 0 && !text.is_empty()).then_some(text)
    }

    /// Real-time: no. A refused call as an error before the run.
    pub(super) fn refused(&self, call: &str, code: Code, hint: &str) -> OpenError {
        let text = self.text(code).unwrap_or_else(|| "the library has no text for it".into());
        OpenError {
            found: format!("{code} from {call}: {text}"),
            needed: "0 from Quanser's HIL library".into(),
            hint: hint.into(),
        }
    }
}

impl Drop for Card {
    fn drop(&mut self) {
        if !self.raw.is_null() {
            // SAFETY: the handle is open and not used again. A card that does not close is beyond help here.
            unsafe { (self.functions.close)(self.raw) };
        }
    }
}

fn checked(code: c_int) -> Result<c_int, Code> {
    if code < 0 { Err(code) } else { Ok(code) }
}
