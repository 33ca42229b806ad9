//! A rig behind UDP, from both ends.
//!
//! Enters: addresses. Leaves: a back end for the host ([`UdpRig`]), a wire for the rig ([`UdpRigWire`]).
//! Deliberately absent: retransmission. A voltage that comes late is worth nothing.

use crate::back_end::OpenError;
use crate::framed::FramedRig;
use crate::wire::{Broken, FrameBuffer, HostWire, Received, Wire};
use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, ToSocketAddrs, UdpSocket};
use std::os::fd::{AsFd, BorrowedFd};
use std::sync::Arc;

const HINT: &str = "start the rig first, then check address, port, cable and firewall";

/// A rig at an address.
///
/// The socket is connected, so that the system drops what others send, and says when nothing listens at the port.
pub type UdpRig = FramedRig<UdpWire>;

impl UdpRig {
    /// Real-time: no. `address` is `HOST:PORT`, an IPv6 host in brackets; the seed has to differ from run to run, see
    /// [`FramedRig`]. Nothing is sent before [`prepare`](crate::back_end::BackEnd::prepare).
    ///
    /// Errors: no such host, or no socket to be had.
    pub fn open(address: &str, seed: u64) -> Result<UdpRig, OpenError> {
        let name = format!("udp:{address}");
        match UdpWire::connected(address) {
            Ok(wire) => Ok(FramedRig::new(wire, name, HINT, seed)),
            Err(error) => Err(OpenError {
                found: format!("no way to {name} ({error})"),
                needed: "the address of a rig, HOST:PORT".into(),
                hint: "numbers work where names do not: 192.168.1.7:4810".into(),
            }),
        }
    }
}

/// The host's end.
#[derive(Clone, Debug)]
pub struct UdpWire {
    socket: Arc<UdpSocket>,
}

impl UdpWire {
    /// Real-time: no.
    fn connected(address: &str) -> io::Result<UdpWire> {
        let mut last = io::Error::from(io::ErrorKind::NotFound);
        for address in address.to_socket_addrs()? {
            match connected(address) {
                Ok(socket) => return Ok(UdpWire { socket: Arc::new(socket) }),
                Err(error) => last = error,
            }
        }
        Err(last)
    }
}

/// Real-time: no.
fn connected(address: SocketAddr) -> io::Result<UdpSocket> {
    let socket = match address {
        SocketAddr::V4(_) => UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?,
        SocketAddr::V6(_) => UdpSocket::bind((Ipv6Addr::UNSPECIFIED, 0))?,
    };
    socket.connect(address)?;
    socket.set_nonblocking(true)?;
    Ok(socket)
}

impl Wire for UdpWire {
    /// Real-time: yes.
    fn send(&self, frame: &[u8]) -> Result<(), Broken> {
        self.socket.send(frame).map(drop).or_else(|error| Broken::unless_passing(&error, ()))
    }

    /// Real-time: yes.
    fn receive(&mut self, buffer: &mut FrameBuffer) -> Result<Received, Broken> {
        let received = self.socket.recv(buffer).map(Received::Frame);
        received.or_else(|error| Broken::unless_passing(&error, Received::Nothing))
    }

    /// Real-time: yes.
    fn descriptor(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }
}

impl HostWire for UdpWire {
    /// Real-time: no.
    fn second(&self) -> UdpWire {
        self.clone()
    }
}

/// The rig's end: answers whoever asked last.
#[derive(Debug)]
pub struct UdpRigWire {
    socket: UdpSocket,
    asker: Option<SocketAddr>,
}

impl UdpRigWire {
    /// Real-time: no. Listens at `address`, for example `0.0.0.0:4810`; port 0 takes a free one.
    ///
    /// Errors: the address is not this machine's, or its port is taken.
    pub fn bind(address: &str) -> Result<UdpRigWire, OpenError> {
        let bound = UdpSocket::bind(address).and_then(|socket| socket.set_nonblocking(true).map(|()| socket));
        match bound {
            Ok(socket) => Ok(UdpRigWire { socket, asker: None }),
            Err(error) => Err(OpenError {
                found: format!("no way to listen at udp:{address} ({error})"),
                needed: "an address of this machine with a free port".into(),
                hint: "127.0.0.1:4810 serves this machine alone, 0.0.0.0:4810 every one that reaches it".into(),
            }),
        }
    }

    /// Real-time: no. Where it listens, with the port that it took.
    ///
    /// Errors: the system's.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.socket.local_addr()
    }
}

impl Wire for UdpRigWire {
    /// Real-time: yes. To the sender of the last frame that came.
    fn send(&self, frame: &[u8]) -> Result<(), Broken> {
        let Some(asker) = self.asker else { return Ok(()) };
        // A host that is gone is no fault of the rig, which waits for the next one.
        let _ = self.socket.send_to(frame, asker);
        Ok(())
    }

    /// Real-time: yes.
    fn receive(&mut self, buffer: &mut FrameBuffer) -> Result<Received, Broken> {
        match self.socket.recv_from(buffer) {
            Ok((length, asker)) => {
                self.asker = Some(asker);
                Ok(Received::Frame(length))
            }
            Err(error) => Broken::unless_passing(&error, Received::Nothing),
        }
    }

    /// Real-time: yes.
    fn descriptor(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }
}
