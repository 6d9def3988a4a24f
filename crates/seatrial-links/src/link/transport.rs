//! Where the bytes of a link go: UDP, TCP, a serial line.

use std::fmt;
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs, UdpSocket};
use std::str::FromStr;
use std::time::{Duration, Instant};

use thiserror::Error;

/// Bytes to and from a vehicle, and the time. A wire that breaks mends itself as soon as it can; until then nothing comes
/// and what is sent is lost.
pub trait Wire {
    /// The time on this side, s.
    fn now_s(&self) -> f64;
    /// Waits for bytes until `until_s` at most and puts them at the end of `bytes`.
    fn receive(&mut self, bytes: &mut Vec<u8>, until_s: f64);
    /// Sends bytes.
    fn send(&mut self, bytes: &[u8]);
    /// What was received last is the vehicle's: answers go there.
    fn is_vehicle(&mut self) {}
}

/// Where a vehicle is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// The vehicle sends to this address of ours.
    UdpIn(String),
    /// The vehicle listens at this address.
    UdpOut(String),
    /// The vehicle listens at this address for a connection.
    Tcp(String),
    /// A device and its baud rate.
    Serial(String, u32),
}

/// A text that is no address.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error(
    "{0}: expected udp:HOST:PORT (listens there), udpout:HOST:PORT, tcp:HOST:PORT or serial:DEVICE:BAUD"
)]
pub struct InvalidAddress(String);

impl FromStr for Address {
    type Err = InvalidAddress;

    fn from_str(text: &str) -> Result<Self, InvalidAddress> {
        let wrong = || InvalidAddress(text.into());
        let (kind, rest) = text.split_once(':').ok_or_else(wrong)?;
        let (place, number) = rest.rsplit_once(':').ok_or_else(wrong)?;
        if place.is_empty() {
            return Err(wrong());
        }
        if kind == "serial" {
            let baud = number.parse().map_err(|_| wrong())?;
            return Ok(Self::Serial(place.into(), baud));
        }
        number.parse::<u16>().map_err(|_| wrong())?;
        match kind {
            "udp" | "udpin" => Ok(Self::UdpIn(rest.into())),
            "udpout" => Ok(Self::UdpOut(rest.into())),
            "tcp" => Ok(Self::Tcp(rest.into())),
            _ => Err(wrong()),
        }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::UdpIn(place) => write!(f, "udp:{place}"),
            Self::UdpOut(place) => write!(f, "udpout:{place}"),
            Self::Tcp(place) => write!(f, "tcp:{place}"),
            Self::Serial(device, baud) => write!(f, "serial:{device}:{baud}"),
        }
    }
}

/// Between two attempts to connect.
const RETRY: Duration = Duration::from_millis(300);
/// A write that takes longer is given up.
const WRITE: Duration = Duration::from_millis(100);
/// A peer that is silent for so long may be replaced by another.
const PEER_SILENCE: Duration = Duration::from_secs(2);
/// The longest datagram.
const DATAGRAM: usize = 1 << 16;
/// The shortest wait that can be asked for.
const SHORTEST: Duration = Duration::from_micros(100);

/// A link to the world.
pub struct Transport {
    start: Instant,
    address: Address,
    channel: Option<Channel>,
    next_attempt: Instant,
    buffer: Vec<u8>,
}

enum Channel {
    Udp {
        socket: UdpSocket,
        /// May another take the place of the peer?
        is_open: bool,
        peer: Option<(SocketAddr, Instant)>,
        last: Option<SocketAddr>,
    },
    Tcp(TcpStream),
    Serial(Box<dyn serialport::SerialPort>),
}

impl Transport {
    /// Opens the link. A vehicle that does not answer yet is no error; an address that cannot be had is.
    pub fn open(address: &Address) -> std::io::Result<Self> {
        let now = Instant::now();
        Ok(Self {
            start: now,
            channel: Some(Channel::open(address)?),
            address: address.clone(),
            next_attempt: now,
            buffer: vec![0; DATAGRAM],
        })
    }

    /// The address on this side, where it has one.
    pub fn local_address(&self) -> Option<SocketAddr> {
        match &self.channel {
            Some(Channel::Udp { socket, .. }) => socket.local_addr().ok(),
            Some(Channel::Tcp(stream)) => stream.local_addr().ok(),
            _ => None,
        }
    }
}

impl Channel {
    fn open(address: &Address) -> std::io::Result<Self> {
        let resolve = |place: &str| {
            let addresses = place.to_socket_addrs()?;
            addresses.into_iter().next().ok_or_else(|| {
                std::io::Error::new(ErrorKind::NotFound, format!("{place}: no such host"))
            })
        };
        Ok(match address {
            Address::UdpIn(place) => Self::Udp {
                socket: UdpSocket::bind(resolve(place)?)?,
                is_open: true,
                peer: None,
                last: None,
            },
            Address::UdpOut(place) => {
                let peer = resolve(place)?;
                let any: SocketAddr = match (peer.ip().is_loopback(), peer.is_ipv4()) {
                    (true, true) => ([127, 0, 0, 1], 0).into(),
                    (false, true) => ([0; 4], 0).into(),
                    (true, false) => (std::net::Ipv6Addr::LOCALHOST, 0).into(),
                    (false, false) => (std::net::Ipv6Addr::UNSPECIFIED, 0).into(),
                };
                let socket = UdpSocket::bind(any)?;
                // Only the peer is heard.
                socket.connect(peer)?;
                Self::Udp { socket, is_open: false, peer: Some((peer, Instant::now())), last: None }
            }
            Address::Tcp(place) => {
                let stream = TcpStream::connect_timeout(&resolve(place)?, Duration::from_secs(2))?;
                stream.set_nodelay(true)?;
                stream.set_write_timeout(Some(WRITE))?;
                Self::Tcp(stream)
            }
            Address::Serial(device, baud) => {
                Self::Serial(serialport::new(device, *baud).timeout(WRITE).open()?)
            }
        })
    }

    /// Waits so long at most. `None`: not at all; the shortest wait is a tick of the system's clock, 4 ms and more.
    fn receive(&mut self, buffer: &mut [u8], wait: Option<Duration>) -> std::io::Result<usize> {
        match self {
            Self::Udp { socket, last, .. } => {
                socket.set_nonblocking(wait.is_none())?;
                socket.set_read_timeout(wait)?;
                let (length, sender) = socket.recv_from(buffer)?;
                *last = Some(sender);
                Ok(length)
            }
            Self::Tcp(stream) => {
                stream.set_nonblocking(wait.is_none())?;
                stream.set_read_timeout(wait)?;
                let read = stream.read(buffer);
                stream.set_nonblocking(false)?;
                match read? {
                    0 => Err(ErrorKind::ConnectionReset.into()),
                    length => Ok(length),
                }
            }
            Self::Serial(port) => {
                if wait.is_none() && port.bytes_to_read()? == 0 {
                    return Err(ErrorKind::WouldBlock.into());
                }
                port.set_timeout(wait.unwrap_or(SHORTEST))?;
                match port.read(buffer)? {
                    0 => Err(ErrorKind::ConnectionReset.into()),
                    length => Ok(length),
                }
            }
        }
    }

    fn send(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        match self {
            Self::Udp { socket, is_open: true, peer: Some((peer, _)), .. } => {
                socket.send_to(bytes, *peer).map(drop)
            }
            Self::Udp { is_open: true, .. } => Ok(()),
            Self::Udp { socket, .. } => socket.send(bytes).map(drop),
            Self::Tcp(stream) => stream.write_all(bytes),
            Self::Serial(port) => port.write_all(bytes),
        }
    }
}

/// No bytes for now, and nothing is broken. A datagram to a port where nobody listens yet is reported at the next read.
fn is_passing(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}

impl Wire for Transport {
    fn now_s(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    fn receive(&mut self, bytes: &mut Vec<u8>, until_s: f64) {
        let left = Duration::try_from_secs_f64(until_s - self.now_s()).unwrap_or_default();
        let wait = (!left.is_zero()).then(|| left.max(SHORTEST));
        let Some(channel) = &mut self.channel else {
            let now = Instant::now();
            if now >= self.next_attempt {
                self.next_attempt = now + RETRY;
                self.channel = Channel::open(&self.address).ok();
            } else {
                std::thread::sleep(left.min(self.next_attempt - now));
            }
            return;
        };
        match channel.receive(&mut self.buffer, wait) {
            Ok(length) => bytes.extend_from_slice(&self.buffer[..length]),
            Err(error) if is_passing(error.kind()) => {}
            Err(_) if matches!(channel, Channel::Udp { .. }) => {
                std::thread::sleep(left.min(Duration::from_millis(10)));
            }
            Err(_) => self.channel = None,
        }
    }

    fn send(&mut self, bytes: &[u8]) {
        let Some(channel) = &mut self.channel else {
            return;
        };
        match channel.send(bytes) {
            Err(error) if !is_passing(error.kind()) && !matches!(channel, Channel::Udp { .. }) => {
                self.channel = None;
            }
            _ => {}
        }
    }

    fn is_vehicle(&mut self) {
        let Some(Channel::Udp { is_open: true, peer, last: Some(last), .. }) = &mut self.channel
        else {
            return;
        };
        let now = Instant::now();
        match peer {
            Some((address, heard)) if address == last || now - *heard > PEER_SILENCE => {
                (*address, *heard) = (*last, now);
            }
            Some(_) => {}
            None => *peer = Some((*last, now)),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;

    use super::*;

    /// A look of the thread that tends a link keeps a sample waiting.
    #[test]
    fn io_a_look_at_a_silent_link_does_not_wait() {
        let silent = TcpListener::bind("127.0.0.1:0").unwrap();
        for address in [
            Address::UdpIn("127.0.0.1:0".into()),
            Address::Tcp(silent.local_addr().unwrap().to_string()),
        ] {
            let mut link = Transport::open(&address).unwrap();
            let mut bytes = Vec::new();
            let mut looks: Vec<Duration> = (0..21)
                .map(|_| {
                    let begun = Instant::now();
                    link.receive(&mut bytes, link.now_s());
                    begun.elapsed()
                })
                .collect();
            looks.sort();
            // A tick of the system's clock is 1 ms and more.
            assert!(looks[10] < Duration::from_micros(500), "{looks:?}");
            let begun = Instant::now();
            link.receive(&mut bytes, link.now_s() + 0.03);
            assert!(begun.elapsed() > Duration::from_millis(29));
        }
    }
}
