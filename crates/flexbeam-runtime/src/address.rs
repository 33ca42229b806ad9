//! Where viewers connect.

use std::fmt;
use std::net::IpAddr;
use std::str::FromStr;

/// Where nobody from outside can connect.
const LOOPBACK: &str = "127.0.0.1";

/// Where viewers connect: `PORT` on the loopback, or `HOST:PORT`. Port 0 is any that is free.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ViewerAddress {
    host: String,
    port: u16,
}

/// A text that is no address.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "found {0:?} as an address for viewers, needed PORT or HOST:PORT\nhint: 8765 and 127.0.0.1:8765 are the same; an IPv6 number stands in brackets"
)]
pub struct NoAddress(pub String);

impl ViewerAddress {
    /// Real-time: no. Name or number; an IPv6 number in brackets.
    pub fn host(&self) -> &str {
        &self.host
    }

    /// Real-time: no. The port.
    pub fn port(&self) -> u16 {
        self.port
    }

    /// Real-time: no. Whether only programs on this machine reach it.
    pub fn is_loopback(&self) -> bool {
        let number = self.host.trim_start_matches('[').trim_end_matches(']');
        self.host == "localhost" || number.parse().is_ok_and(|ip: IpAddr| ip.is_loopback())
    }

    pub(crate) fn with_port(&self, port: u16) -> ViewerAddress {
        ViewerAddress { host: self.host.clone(), port }
    }
}

impl FromStr for ViewerAddress {
    type Err = NoAddress;

    /// Real-time: no.
    ///
    /// Errors: [`NoAddress`].
    fn from_str(text: &str) -> Result<ViewerAddress, NoAddress> {
        let (host, port) = text.rsplit_once(':').unwrap_or((LOOPBACK, text));
        let bracketed = host.starts_with('[') && host.ends_with(']') && host.len() > 2;
        let is_host = bracketed || (!host.is_empty() && !host.contains([':', '[', ']']));
        match port.parse() {
            Ok(port) if is_host => Ok(ViewerAddress { host: host.into(), port }),
            _ => Err(NoAddress(text.into())),
        }
    }
}

impl fmt::Display for ViewerAddress {
    /// Real-time: no. What [`ViewerAddress::from_str`] reads back.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.host, self.port)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_alone_is_on_the_loopback() {
        for (text, shown, loopback) in [
            ("8765", "127.0.0.1:8765", true),
            ("127.0.0.1:0", "127.0.0.1:0", true),
            ("localhost:1", "localhost:1", true),
            ("[::1]:8765", "[::1]:8765", true),
            ("0.0.0.0:8765", "0.0.0.0:8765", false),
            ("[::]:8765", "[::]:8765", false),
            ("rig.example:8765", "rig.example:8765", false),
        ] {
            let address: ViewerAddress = text.parse().unwrap();
            assert_eq!((address.to_string().as_str(), address.is_loopback()), (shown, loopback));
        }
    }

    #[test]
    fn what_is_no_address_is_refused_with_its_text() {
        for text in ["", "port", "65536", "-1", ":8765", "::1:8765", "[]:8765", "localhost", "localhost:", "ws://a:1"] {
            assert_eq!(text.parse::<ViewerAddress>(), Err(NoAddress(text.into())));
        }
    }
}
