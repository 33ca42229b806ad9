//! A rig behind a board that Linux's comedi drives, through comedi's library, which is opened at run time.
//!
//! Enters: a motor voltage a period. Leaves: hub angle and deflection of the same instant. Deliberately absent: comedi's
//! streaming commands, because the loop has its own clock; calibration files of boards that are calibrated in software.

mod device;
mod scale;

pub use device::Reference;

use crate::back_end::{Answer, BackEnd, Counters, Cutoff, LinkFault, OpenError, Timing};
use crate::board::{BoardMap, Counter, MAP_KEYS, PortText};
use device::{Channel, Device, Errno, Kind};
use scale::Scale;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Which device, and how the rig is wired to it.
#[derive(Clone, Debug, PartialEq)]
pub struct ComediPort {
    /// The device's file: `/dev/comedi0`.
    pub path: String,
    /// Channels and calibration.
    pub map: BoardMap,
    /// Subdevice of the analogue output. Default none: the first of that kind.
    pub output_subdevice: Option<u32>,
    /// Subdevice of the encoder, a counter. Default none: the first of that kind.
    pub encoder_subdevice: Option<u32>,
    /// Subdevice of the analogue input. Default none: the first of that kind.
    pub gauge_subdevice: Option<u32>,
    /// Number of the output's range. Default none: the one in volts that reaches farthest in both directions.
    pub output_range: Option<u32>,
    /// Number of the input's range. Default none: as for the output.
    pub gauge_range: Option<u32>,
    /// What the gauge is measured against. Default [`Reference::Ground`].
    pub reference: Reference,
    /// File of the library. Default none: the names under which Linux installs it.
    pub library: Option<String>,
}

/// Keys beside those of the map.
const KEYS: [&str; 7] =
    ["output_subdevice", "encoder_subdevice", "gauge_subdevice", "output_range", "gauge_range", "reference", "library"];

impl ComediPort {
    /// Real-time: no. A device with everything else at its default.
    pub fn new(path: &str) -> ComediPort {
        ComediPort {
            path: path.into(),
            map: BoardMap::default(),
            output_subdevice: None,
            encoder_subdevice: None,
            gauge_subdevice: None,
            output_range: None,
            gauge_range: None,
            reference: Reference::default(),
            library: None,
        }
    }

    /// Real-time: no. From the text after `comedi:`, as in `/dev/comedi0?encoder=0,output=0,gauge=0,reference=diff`.
    ///
    /// Errors: a key that is unknown or stands twice, a value that is none, no device.
    pub fn parse(text: &str) -> Result<ComediPort, OpenError> {
        const REFERENCES: [(&str, Reference); 4] = [
            ("ground", Reference::Ground),
            ("common", Reference::Common),
            ("diff", Reference::Difference),
            ("other", Reference::Other),
        ];
        let known: Vec<&str> = MAP_KEYS.into_iter().chain(KEYS).collect();
        let port = PortText::read(text, &known)?;
        let default = ComediPort::new(device_file(port.device)?);
        let number = |key: &str| match port.word(key) {
            None => Ok(None),
            Some(_) => port.value(key, 0, "a number from 0").map(Some),
        };
        Ok(ComediPort {
            map: port.map()?,
            output_subdevice: number("output_subdevice")?,
            encoder_subdevice: number("encoder_subdevice")?,
            gauge_subdevice: number("gauge_subdevice")?,
            output_range: number("output_range")?,
            gauge_range: number("gauge_range")?,
            reference: port.choice("reference", &REFERENCES, default.reference)?,
            library: port.word("library").map(String::from),
            ..default
        })
    }
}

fn device_file(text: &str) -> Result<&str, OpenError> {
    (!text.is_empty()).then_some(text).ok_or_else(|| OpenError {
        found: "no device in the port's text".into(),
        needed: "a device file".into(),
        hint: "comedi:/dev/comedi0 is the first board".into(),
    })
}

/// The analogue output with its converter.
#[derive(Clone, Copy)]
struct Output {
    channel: Channel,
    scale: Scale,
}

impl Output {
    /// Errors: no such output, or one that cannot turn the motor both ways.
    fn find(device: &Device, port: &ComediPort) -> Result<Output, OpenError> {
        let subdevice = device.subdevice(Kind::AnalogOutput, port.output_subdevice, "output_subdevice")?;
        let channel = port.map.analog_output;
        let (range, scale) = device.range(subdevice, channel, port.output_range, "output")?;
        if !(scale.reach_v() > 0.0) {
            return Err(OpenError {
                found: format!("{}: an output from {} V to {} V", port.path, scale.min_v, scale.max_v),
                needed: "a range with 0 V inside, since the motor turns both ways".into(),
                hint: "set the board's output to bipolar, or name another range: output_range=N".into(),
            });
        }
        Ok(Output { channel: Channel { subdevice, channel, range, reference: Reference::Ground }, scale })
    }

    /// Real-time: yes, as far as the driver is.
    fn write(&self, device: &Device, board_v: f64) -> Result<(), Errno> {
        device.write(&self.channel, self.scale.sample(board_v))
    }
}

/// A rig behind a comedi board. theta is zero where the hub stood when the board was opened.
///
/// comedi knows no watchdog: a process that is killed leaves its last voltage standing. What is here is [`BackEnd::cutoff`],
/// with a handle of its own on the device, and 0 V when the rig is dropped, also by a panic. An exchange takes as long as the
/// driver takes to answer, and [`Answer::Lost`] never comes.
pub struct ComediRig {
    device: Device,
    spare: Arc<Mutex<Device>>,
    gate: Arc<AtomicBool>,
    output: Output,
    encoder: Channel,
    counter: Counter,
    gauge: Channel,
    gauge_scale: Scale,
    map: BoardMap,
}

impl ComediRig {
    /// Real-time: no. Opens library and device, writes 0 V and takes the hub's angle as zero.
    ///
    /// Errors: no library, a library without a function that is needed, a device that does not open twice, a channel or range
    /// that it does not have; each with the library's own words.
    pub fn open(port: &ComediPort) -> Result<ComediRig, OpenError> {
        port.map.check()?;
        let device = Device::open(port.library.as_deref(), &port.path)?;
        let output = Output::find(&device, port)?;
        let asked = "the board's first 0 V";
        output.write(&device, 0.0).map_err(|errno| refused(&device, asked, errno))?;
        let (encoder, greatest) = encoder(&device, port)?;
        let (gauge, gauge_scale) = gauge(&device, port)?;
        let counts = device.read(&encoder).map_err(|errno| refused(&device, "the encoder's counter", errno))?;
        Ok(ComediRig {
            spare: Arc::new(Mutex::new(device.again()?)),
            gate: Arc::new(AtomicBool::new(false)),
            counter: Counter::new(greatest, counts),
            map: port.map,
            device,
            output,
            encoder,
            gauge,
            gauge_scale,
        })
    }

    /// Real-time: yes, as far as the driver is.
    fn sensors(&mut self) -> Result<flexbeam_rig::Measurement, Errno> {
        let reading = self.device.read(&self.encoder)?;
        let sample = self.device.read(&self.gauge)?;
        Ok(self.map.measurement(self.counter.counts(reading), self.gauge_scale.volts(sample)))
    }

    /// Real-time: yes, as far as the driver is. Nothing but 0 V goes out once the gate is shut.
    ///
    /// RT: the gate is looked at again after the write, for a cut may have come, and written its 0 V, while ours was under way.
    fn send(&mut self, board_v: f64) -> Result<(), LinkFault> {
        if self.gate.load(Ordering::SeqCst) {
            return Err(LinkFault::CutOff);
        }
        self.output.write(&self.device, board_v).map_err(fault)?;
        if self.gate.load(Ordering::SeqCst) {
            self.zero()?;
            return Err(LinkFault::CutOff);
        }
        Ok(())
    }
}

fn encoder(device: &Device, port: &ComediPort) -> Result<(Channel, u32), OpenError> {
    let subdevice = device.subdevice(Kind::Counter, port.encoder_subdevice, "encoder_subdevice")?;
    let channel = port.map.encoder;
    let greatest = device.greatest(subdevice, channel, "encoder")?;
    Ok((Channel { subdevice, channel, range: 0, reference: Reference::Ground }, greatest))
}

fn gauge(device: &Device, port: &ComediPort) -> Result<(Channel, Scale), OpenError> {
    let subdevice = device.subdevice(Kind::AnalogInput, port.gauge_subdevice, "gauge_subdevice")?;
    let channel = port.map.gauge_input;
    let (range, scale) = device.range(subdevice, channel, port.gauge_range, "gauge")?;
    Ok((Channel { subdevice, channel, range, reference: port.reference }, scale))
}

/// Real-time: yes. A device that is unplugged says that there is none.
fn fault(errno: Errno) -> LinkFault {
    match errno {
        libc::ENODEV | libc::ENXIO => LinkFault::Gone { errno },
        code => LinkFault::Board { code },
    }
}

fn refused(device: &Device, asked: &str, errno: Errno) -> OpenError {
    OpenError {
        found: format!("{}: {} from {asked}", device.path(), device.text(errno)),
        needed: "a device that answers".into(),
        hint: "another program may hold the board: close it".into(),
    }
}

impl BackEnd for ComediRig {
    /// Real-time: no. What the board's range gives at the motor's terminals in both directions.
    fn reach_v(&self) -> f64 {
        self.output.scale.reach_v() * self.map.amplifier_gain
    }

    /// Real-time: yes, as far as the driver is. Writes the output, then reads counter and gauge.
    fn exchange(&mut self, _instant: u64, voltage_v: f64) -> Result<Answer, LinkFault> {
        self.send(self.map.board_v(voltage_v))?;
        let measurement = self.sensors().map_err(fault)?;
        if self.gate.load(Ordering::SeqCst) { Err(LinkFault::CutOff) } else { Ok(Answer::Fresh(measurement)) }
    }

    /// Real-time: yes, as far as the driver is.
    fn zero(&mut self) -> Result<(), LinkFault> {
        self.output.write(&self.device, 0.0).map_err(fault)
    }

    /// Real-time: no. 0 V, one reading; opens what a cutoff closed. `hold_s` has no addressee here.
    fn prepare(&mut self, _timing: Timing) -> Result<(), OpenError> {
        self.output.write(&self.device, 0.0).map_err(|errno| refused(&self.device, "0 V", errno))?;
        self.sensors().map_err(|errno| refused(&self.device, "the sensors", errno))?;
        self.gate.store(false, Ordering::SeqCst);
        Ok(())
    }

    /// Real-time: no. Writes 0 V through a second handle. Linux takes one call at a time for a device: where the loop hangs
    /// inside the driver and not outside of it, the 0 V waits too.
    fn cutoff(&self) -> Option<Box<dyn Cutoff>> {
        Some(Box::new(ComediCutoff { device: self.spare.clone(), gate: self.gate.clone(), output: self.output }))
    }

    /// Real-time: yes. All zero: a board loses nothing.
    fn counters(&self) -> Counters {
        Counters::default()
    }

    /// Real-time: no.
    fn name(&self) -> String {
        format!("comedi:{}", self.device.path())
    }

    /// Real-time: no. With the library's own text for an error number.
    fn explain(&self, fault: LinkFault) -> String {
        match fault {
            LinkFault::Board { code } | LinkFault::Gone { errno: code } => {
                format!("{fault}: {}", self.device.text(code))
            }
            other => other.to_string(),
        }
    }
}

impl Drop for ComediRig {
    fn drop(&mut self) {
        // What fails here cannot be told any more.
        let _ = self.zero();
    }
}

/// The second road to 0 V.
struct ComediCutoff {
    device: Arc<Mutex<Device>>,
    gate: Arc<AtomicBool>,
    output: Output,
}

impl Cutoff for ComediCutoff {
    /// The gate first: a voltage that the loop sends after it is taken back by the loop itself.
    fn cut(&self) {
        self.gate.store(true, Ordering::SeqCst);
        let device = self.device.lock().unwrap_or_else(PoisonError::into_inner);
        // A board that refuses 0 V here cannot be told so; the loop's own zero comes next.
        let _ = self.output.write(&device, 0.0);
    }
}
