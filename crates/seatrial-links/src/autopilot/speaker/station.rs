//! The ground station of a vehicle that is played.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream, UdpSocket};
use std::time::Duration;

/// Where a played vehicle's messages go, and where its commands come from.
#[derive(Debug)]
pub enum Station {
    /// A ground station that listens for datagrams.
    Udp(UdpSocket),
    /// The station that connects.
    Tcp(TcpListener, Option<TcpStream>),
}

impl Station {
    /// Sends datagrams to a place, HOST:PORT.
    pub fn udp(place: &str) -> io::Result<Self> {
        let is_loopback = ["127.", "localhost:", "[::1]"].iter().any(|p| place.starts_with(p));
        let any = if is_loopback { "127.0.0.1:0" } else { "0.0.0.0:0" };
        let socket = UdpSocket::bind(any)?;
        socket.connect(place)?;
        Ok(Self::Udp(socket))
    }

    /// Waits for a connection at a place, HOST:PORT.
    pub fn tcp(place: &str) -> io::Result<Self> {
        let listener = TcpListener::bind(place)?;
        listener.set_nonblocking(true)?;
        Ok(Self::Tcp(listener, None))
    }

    /// Sends what the vehicle says.
    pub fn send(&mut self, bytes: &[u8]) {
        match self {
            // A station that is not there yet, or gone, does not stop the vehicle.
            Self::Udp(socket) => drop(socket.send(bytes)),
            Self::Tcp(_, stream) => {
                if stream.as_mut().is_some_and(|s| s.write_all(bytes).is_err()) {
                    *stream = None;
                }
            }
        }
    }

    /// What has come, after waiting this long at most.
    pub fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> usize {
        let waits = !timeout.is_zero();
        let timeout = timeout.max(Duration::from_micros(100));
        let received = match self {
            Self::Udp(socket) => socket
                .set_nonblocking(!waits)
                .and_then(|()| socket.set_read_timeout(Some(timeout)))
                .and_then(|()| socket.recv(buffer)),
            Self::Tcp(_, Some(stream)) => stream
                .set_nonblocking(!waits)
                .and_then(|()| stream.set_read_timeout(Some(timeout)))
                .and_then(|()| stream.read(buffer))
                .and_then(|length| match length {
                    0 => Err(ErrorKind::ConnectionReset.into()),
                    length => Ok(length),
                }),
            Self::Tcp(listener, stream) => {
                if waits {
                    std::thread::sleep(timeout.min(Duration::from_millis(5)));
                }
                if let Ok((accepted, _)) = listener.accept()
                    && accepted.set_nonblocking(false).is_ok()
                    && accepted.set_nodelay(true).is_ok()
                {
                    *stream = Some(accepted);
                }
                return 0;
            }
        };
        // What is sent waits for a station that reads late.
        if let Self::Tcp(_, Some(stream)) = self {
            let _ = stream.set_nonblocking(false);
        }
        match received {
            Ok(length) => length,
            Err(error) => {
                let is_passing =
                    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut);
                match self {
                    Self::Tcp(_, stream) if !is_passing => *stream = None,
                    _ if !is_passing && waits => std::thread::sleep(timeout),
                    _ => {}
                }
                0
            }
        }
    }
}
