//! comedi's library as C knows it, and one open device.
//!
//! Enters: channels and samples. Leaves: samples, or the library's own error numbers. Signatures as in comedilib.h.

use super::scale::Scale;
use crate::back_end::OpenError;
use crate::board::{Library, Missing, c_text};
use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::ptr::NonNull;
use std::sync::Arc;

/// Names under which Linux packages install the library.
const NAMES: [&str; 2] = ["libcomedi.so.0", "libcomedi.so"];

const MISSING: Missing = Missing {
    library: "comedi's library",
    hint: "install it (Debian: libcomedi0), or name the file in the port: library=/path/libcomedi.so.0",
};

const OTHER_LIBRARY: &str = "flexbeam needs comedilib 0.7.18 or later";

/// `UNIT_volt` of comedi.h.
const VOLT: c_uint = 0;

/// An error number of the system, or one of comedi's own from 0x1000.
pub(super) type Errno = i32;

type RawDevice = *mut c_void;
type OfDevice = unsafe extern "C" fn(RawDevice) -> c_int;
type OfSubdevice = unsafe extern "C" fn(RawDevice, c_uint) -> c_int;

/// `comedi_range`.
#[repr(C)]
struct Range {
    min: f64,
    max: f64,
    unit: c_uint,
}

/// The functions in use.
struct Functions {
    open: unsafe extern "C" fn(*const c_char) -> RawDevice,
    close: OfDevice,
    subdevices: OfDevice,
    find_subdevice: unsafe extern "C" fn(RawDevice, c_int, c_uint) -> c_int,
    subdevice_type: OfSubdevice,
    channels: OfSubdevice,
    greatest: unsafe extern "C" fn(RawDevice, c_uint, c_uint) -> c_uint,
    ranges: unsafe extern "C" fn(RawDevice, c_uint, c_uint) -> c_int,
    range: unsafe extern "C" fn(RawDevice, c_uint, c_uint, c_uint) -> *const Range,
    read: unsafe extern "C" fn(RawDevice, c_uint, c_uint, c_uint, c_uint, *mut c_uint) -> c_int,
    write: unsafe extern "C" fn(RawDevice, c_uint, c_uint, c_uint, c_uint, c_uint) -> c_int,
    errno: unsafe extern "C" fn() -> c_int,
    text: unsafe extern "C" fn(c_int) -> *const c_char,
}

impl Functions {
    fn load(named: Option<&str>) -> Result<Functions, OpenError> {
        let library = match named {
            Some(name) => Library::open(&[name], &MISSING)?,
            None => Library::open(&NAMES, &MISSING)?,
        };
        // SAFETY: each type is that of the function in comedilib.h, with lsampl_t as unsigned int.
        unsafe {
            Ok(Functions {
                open: library.function("comedi_open", OTHER_LIBRARY)?,
                close: library.function("comedi_close", OTHER_LIBRARY)?,
                subdevices: library.function("comedi_get_n_subdevices", OTHER_LIBRARY)?,
                find_subdevice: library.function("comedi_find_subdevice_by_type", OTHER_LIBRARY)?,
                subdevice_type: library.function("comedi_get_subdevice_type", OTHER_LIBRARY)?,
                channels: library.function("comedi_get_n_channels", OTHER_LIBRARY)?,
                greatest: library.function("comedi_get_maxdata", OTHER_LIBRARY)?,
                ranges: library.function("comedi_get_n_ranges", OTHER_LIBRARY)?,
                range: library.function("comedi_get_range", OTHER_LIBRARY)?,
                read: library.function("comedi_data_read", OTHER_LIBRARY)?,
                write: library.function("comedi_data_write", OTHER_LIBRARY)?,
                errno: library.function("comedi_errno", OTHER_LIBRARY)?,
                text: library.function("comedi_strerror", OTHER_LIBRARY)?,
            })
        }
    }

    /// Real-time: yes. Of this thread's last call; comedilib 0.11 keeps one number a thread, older ones one for all.
    fn errno(&self) -> Errno {
        // SAFETY: takes nothing.
        unsafe { (self.errno)() }
    }
}

/// What a subdevice does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    AnalogInput = 1,
    AnalogOutput = 2,
    Counter = 6,
}

impl Kind {
    fn words(self) -> &'static str {
        match self {
            Kind::AnalogInput => "analogue input",
            Kind::AnalogOutput => "analogue output",
            Kind::Counter => "counter",
        }
    }
}

/// What an analogue input is measured against.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reference {
    /// The board's ground. `ground` in a port's text.
    #[default]
    Ground = 0,
    /// The inputs' common line. `common` in a port's text.
    Common = 1,
    /// The neighbouring input, as a difference. `diff` in a port's text.
    Difference = 2,
    /// What the board's driver takes it for. `other` in a port's text.
    Other = 3,
}

/// One channel with its range.
#[derive(Clone, Copy, Debug)]
pub(super) struct Channel {
    pub subdevice: c_uint,
    pub channel: c_uint,
    pub range: c_uint,
    pub reference: Reference,
}

/// An open device; closed when dropped.
pub(super) struct Device {
    functions: Arc<Functions>,
    raw: NonNull<c_void>,
    path: String,
}

// SAFETY: the handle is the library's, not a thread's; each is owned by one thread at a time and not shared (no Sync).
unsafe impl Send for Device {}

impl Device {
    /// Real-time: no. The library, and the device behind it.
    ///
    /// Errors: no library, not this library, no such device.
    pub(super) fn open(named: Option<&str>, path: &str) -> Result<Device, OpenError> {
        Device::with(Arc::new(Functions::load(named)?), path)
    }

    /// Real-time: no. The same device once more, with a handle of its own.
    ///
    /// Errors: it does not open twice.
    pub(super) fn again(&self) -> Result<Device, OpenError> {
        Device::with(self.functions.clone(), &self.path)
    }

    fn with(functions: Arc<Functions>, path: &str) -> Result<Device, OpenError> {
        let c_path = c_text(path)?;
        // SAFETY: the text ends in NUL and outlives the call.
        match NonNull::new(unsafe { (functions.open)(c_path.as_ptr()) }) {
            Some(raw) => Ok(Device { functions, raw, path: path.into() }),
            None => Err(OpenError {
                found: format!("{path}: {}", text(&functions, functions.errno())),
                needed: "a comedi device that opens".into(),
                hint:
                    "comedi_board_info lists devices; your account needs to read and write them (Debian: group iocard)"
                        .into(),
            }),
        }
    }

    /// Real-time: yes, as far as the driver is.
    pub(super) fn read(&self, from: &Channel) -> Result<u32, Errno> {
        let mut sample = 0;
        // SAFETY: the handle is open; one sample goes to one number on this frame.
        let done = unsafe {
            (self.functions.read)(
                self.raw.as_ptr(),
                from.subdevice,
                from.channel,
                from.range,
                from.reference as c_uint,
                &mut sample,
            )
        };
        if done < 0 { Err(self.functions.errno()) } else { Ok(sample) }
    }

    /// Real-time: yes, as far as the driver is.
    pub(super) fn write(&self, to: &Channel, sample: u32) -> Result<(), Errno> {
        // SAFETY: the handle is open; the rest are numbers.
        let done = unsafe {
            (self.functions.write)(
                self.raw.as_ptr(),
                to.subdevice,
                to.channel,
                to.range,
                to.reference as c_uint,
                sample,
            )
        };
        if done < 0 { Err(self.functions.errno()) } else { Ok(()) }
    }

    /// Real-time: no. The subdevice that was named, or the first of this kind.
    ///
    /// Errors: there is none, or the named one is of another kind.
    pub(super) fn subdevice(&self, kind: Kind, named: Option<u32>, key: &str) -> Result<u32, OpenError> {
        let found = match named {
            Some(subdevice) => named.filter(|_| self.is(kind, subdevice)),
            None => self.first(kind),
        };
        found.ok_or_else(|| OpenError {
            found: match named {
                Some(subdevice) => format!("{}: {key}={subdevice}, which is no {}", self.path, kind.words()),
                None => format!("{}: {} subdevices, none of them {}", self.path, self.subdevices(), kind.words()),
            },
            needed: format!("a subdevice that is {}", kind.words()),
            hint: "comedi_board_info lists subdevices with their kinds".into(),
        })
    }

    fn is(&self, kind: Kind, subdevice: u32) -> bool {
        // SAFETY: the handle is open, and a subdevice that is not there is answered by -1.
        unsafe { (self.functions.subdevice_type)(self.raw.as_ptr(), subdevice) == kind as c_int }
    }

    fn first(&self, kind: Kind) -> Option<u32> {
        // SAFETY: the handle is open; the rest are numbers.
        u32::try_from(unsafe { (self.functions.find_subdevice)(self.raw.as_ptr(), kind as c_int, 0) }).ok()
    }

    fn subdevices(&self) -> c_int {
        // SAFETY: the handle is open.
        unsafe { (self.functions.subdevices)(self.raw.as_ptr()) }
    }

    /// Real-time: no. The greatest sample of a channel.
    ///
    /// Errors: the subdevice has no such channel.
    pub(super) fn greatest(&self, subdevice: u32, channel: u32, key: &str) -> Result<u32, OpenError> {
        // SAFETY: the handle is open; the rest are numbers.
        let channels = unsafe { (self.functions.channels)(self.raw.as_ptr(), subdevice) };
        let exists = u32::try_from(channels).is_ok_and(|channels| channel < channels);
        // SAFETY: as above, and the channel exists.
        let greatest =
            if exists { unsafe { (self.functions.greatest)(self.raw.as_ptr(), subdevice, channel) } } else { 0 };
        (greatest > 0).then_some(greatest).ok_or_else(|| OpenError {
            found: format!("{}: {key}={channel} on subdevice {subdevice} with {channels} channels", self.path),
            needed: "a channel that it has, counted from 0".into(),
            hint: "comedi_board_info lists channels; another subdevice is named by its key in the port".into(),
        })
    }

    /// Real-time: no. The named range of a channel, or the one in volts that reaches farthest in both directions.
    ///
    /// Errors: no such range, or none in volts.
    pub(super) fn range(
        &self,
        subdevice: u32,
        channel: u32,
        named: Option<u32>,
        key: &str,
    ) -> Result<(u32, Scale), OpenError> {
        let greatest = self.greatest(subdevice, channel, key)?;
        // SAFETY: the handle is open and the channel exists.
        let count = unsafe { (self.functions.ranges)(self.raw.as_ptr(), subdevice, channel) };
        let in_volts = (0..u32::try_from(count).unwrap_or(0)).filter_map(|range| {
            let (min_v, max_v) = self.volts(subdevice, channel, range)?;
            Some((range, Scale { min_v, max_v, greatest }))
        });
        let fitting = in_volts.filter(|(range, _)| named.is_none_or(|named| named == *range));
        fitting.max_by(|(_, a), (_, b)| a.reach_v().total_cmp(&b.reach_v())).ok_or_else(|| OpenError {
            found: format!("{}: {count} ranges of {key}={channel}, and not the one asked for in volts", self.path),
            needed: match named {
                Some(range) => format!("range {range} in volts"),
                None => "one in volts".into(),
            },
            hint: "comedi_board_info -v lists ranges".into(),
        })
    }

    /// Ends of a range, where it is one in volts.
    fn volts(&self, subdevice: u32, channel: u32, range: u32) -> Option<(f64, f64)> {
        // SAFETY: the handle is open; what comes back is null or belongs to the device, which outlives this call.
        let range = unsafe { (self.functions.range)(self.raw.as_ptr(), subdevice, channel, range).as_ref() }?;
        (range.unit == VOLT && range.min < range.max).then_some((range.min, range.max))
    }

    /// Real-time: no. The library's own words for an error number.
    pub(super) fn text(&self, errno: Errno) -> String {
        text(&self.functions, errno)
    }

    /// Where the device stands.
    pub(super) fn path(&self) -> &str {
        &self.path
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: the handle is open and not used again. A device that does not close is beyond help here.
        unsafe { (self.functions.close)(self.raw.as_ptr()) };
    }
}

fn text(functions: &Functions, errno: Errno) -> String {
    // SAFETY: what comes back is null or a text that ends in NUL and stands until the next call of this thread.
    let text = unsafe {
        let text = (functions.text)(errno);
        (!text.is_null()).then(|| CStr::from_ptr(text).to_string_lossy().into_owned())
    };
    text.unwrap_or_else(|| format!("error {errno}"))
}
