//! Where a rig is, as people write it: `simulated`, `udp:HOST:PORT`, `serial:DEVICE[:BAUD]`, `hil:..`, `comedi:..`.
//!
//! Enters: text. Leaves: a port, or what is wrong with the text. Deliberately absent: opening it.

use crate::back_end::OpenError;
use crate::serial::{DEFAULT_BAUD, SPEEDS};
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// Where a rig is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Port {
    /// In this process.
    Simulated,
    /// Behind UDP.
    Udp {
        /// Name or number; an IPv6 number in brackets.
        host: String,
        /// Port, not 0.
        port: u16,
    },
    /// Behind a serial line.
    Serial {
        /// The device's path.
        device: PathBuf,
        /// One of [`SPEEDS`].
        baud: u32,
    },
    /// A board that Quanser's library drives: what stands behind the colon, `BOARD[:ID][?key=value,..]`.
    Hil(String),
    /// A board that comedi drives: what stands behind the colon, `DEVICE[?key=value,..]`.
    Comedi(String),
}

impl FromStr for Port {
    type Err = OpenError;

    /// Real-time: no.
    ///
    /// Errors: no such kind of port, or its parts are not what they should be.
    fn from_str(text: &str) -> Result<Port, OpenError> {
        match text.split_once(':') {
            None if text == "simulated" => Ok(Port::Simulated),
            Some(("udp", rest)) => udp(rest),
            Some(("serial", rest)) => serial(rest),
            Some(("hil", board)) if !board.is_empty() => Ok(Port::Hil(board.into())),
            Some(("comedi", board)) if !board.is_empty() => Ok(Port::Comedi(board.into())),
            _ => Err(unknown(text)),
        }
    }
}

impl fmt::Display for Port {
    /// Real-time: no. What [`Port::from_str`] reads back.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Port::Simulated => write!(f, "simulated"),
            Port::Udp { host, port } => write!(f, "udp:{host}:{port}"),
            Port::Serial { device, baud } => write!(f, "serial:{}:{baud}", device.display()),
            Port::Hil(board) => write!(f, "hil:{board}"),
            Port::Comedi(board) => write!(f, "comedi:{board}"),
        }
    }
}

/// Real-time: no.
fn unknown(text: &str) -> OpenError {
    OpenError {
        found: format!("\"{text}\" for a rig"),
        needed: "simulated, udp:HOST:PORT, serial:DEVICE[:BAUD], hil:BOARD or comedi:DEVICE".into(),
        hint: "udp:192.168.1.7:4810 and serial:/dev/ttyUSB0:921600 are two that could be".into(),
    }
}

/// Real-time: no. The last colon parts host and port, since an IPv6 number has colons of its own.
fn udp(rest: &str) -> Result<Port, OpenError> {
    let parts = rest.rsplit_once(':').filter(|(host, _)| is_host(host));
    let numbered = parts.and_then(|(host, port)| Some((host, port.parse().ok().filter(|port| *port != 0)?)));
    let Some((host, port)) = numbered else {
        return Err(OpenError {
            found: format!("\"udp:{rest}\""),
            needed: "udp:HOST:PORT with a port from 1 to 65535".into(),
            hint: "udp:192.168.1.7:4810, udp:[fe80::1]:4810, udp:localhost:4810".into(),
        });
    };
    Ok(Port::Udp { host: host.into(), port })
}

/// Real-time: no. A name without colons, or anything in brackets.
fn is_host(host: &str) -> bool {
    let bracketed = host.starts_with('[') && host.ends_with(']') && host.len() > 2;
    bracketed || (!host.is_empty() && !host.contains(':'))
}

/// Real-time: no. What follows the last colon is a speed if it is a number: paths such as those of /dev/serial/by-path have
/// colons of their own.
fn serial(rest: &str) -> Result<Port, OpenError> {
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let (device, speed) = match rest.rsplit_once(':') {
        Some((device, speed)) if is_number(speed) => (device, speed.parse().ok()),
        _ => (rest, Some(DEFAULT_BAUD)),
    };
    let baud = speed.filter(|baud| SPEEDS.contains(baud));
    match baud {
        Some(baud) if !device.is_empty() => Ok(Port::Serial { device: device.into(), baud }),
        _ => Err(OpenError {
            found: format!("\"serial:{rest}\""),
            needed: format!("serial:DEVICE:BAUD with one of {}", SPEEDS.map(|speed| speed.to_string()).join(", ")),
            hint: "serial:/dev/ttyUSB0:921600; a device whose name ends in a colon and digits needs its speed named"
                .into(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_back() {
        let texts = [
            "simulated",
            "udp:192.168.1.7:4810",
            "udp:[::1]:4810",
            "udp:rig.example:1",
            "serial:/dev/ttyUSB0:115200",
            "serial:/dev/serial/by-path/pci-0000:00:14.0-usb-0:2:1.0-port0:2000000",
            "hil:q2_usb:0?encoder=1",
            "comedi:/dev/comedi0?range=2,theta=1",
        ];
        for text in texts {
            assert_eq!(text.parse::<Port>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn a_serial_line_has_a_usual_speed() {
        let port = |device: &str| Port::Serial { device: device.into(), baud: DEFAULT_BAUD };
        assert_eq!("serial:/dev/pts/3".parse(), Ok(port("/dev/pts/3")));
        assert_eq!("serial:/dev/by-path/x:1.0-port0".parse(), Ok(port("/dev/by-path/x:1.0-port0")));
    }

    #[test]
    fn what_is_no_port_is_refused_with_its_text() {
        let texts = [
            "",
            "simulator",
            "tcp:1.2.3.4:5",
            "udp:",
            "udp:1.2.3.4",
            "udp::4810",
            "udp:host:0",
            "udp:host:65536",
            "udp:::1:4810",
            "serial:",
            "serial::921600",
            "serial:/dev/ttyUSB0:1234",
            "serial:/dev/ttyUSB0:99999999999",
            "hil:",
            "comedi:",
        ];
        for text in texts {
            let error = text.parse::<Port>().unwrap_err();
            assert!(error.found.contains(text), "{text}: {error}");
        }
    }
}
