//! A router of MAVLink as BlueOS has one: a vehicle on one side, and a station that calls first on the other.

use std::net::{SocketAddr, UdpSocket};
use std::sync::{Arc, Mutex};

/// Larger than any frame.
const LARGEST: usize = 1 << 16;

/// Passes datagrams on until the program ends.
pub struct Router {
    vehicle_side: SocketAddr,
}

impl Router {
    /// A router whose stations call at the port of a vehicle `mavlink:udpout:HOST:PORT`.
    pub fn start(vehicle: &str) -> Result<Self, String> {
        let port = vehicle.rsplit(':').next().unwrap_or_default();
        let port: u16 = port
            .parse()
            .map_err(|error| format!("{vehicle}: {error}"))?;
        let open = |port| {
            let opened = UdpSocket::bind(("127.0.0.1", port));
            opened.map_err(|error| format!("UDP port {port}: {error}; what uses it must end"))
        };
        let (stations, vehicle) = (open(port)?, open(0)?);
        let vehicle_side = vehicle.local_addr().map_err(|error| error.to_string())?;
        let sides = [stations, vehicle].map(Arc::new);
        let callers = [(); 2].map(|()| Arc::new(Mutex::new(None)));
        for (here, there) in [(0, 1), (1, 0)] {
            let (from, to) = (Arc::clone(&sides[here]), Arc::clone(&sides[there]));
            let (caller, called) = (Arc::clone(&callers[here]), Arc::clone(&callers[there]));
            std::thread::spawn(move || pass_on(&from, &caller, &to, &called));
        }
        Ok(Self { vehicle_side })
    }

    /// Where the vehicle sends to, as ADDRESS:PORT.
    pub fn vehicle_side(&self) -> String {
        self.vehicle_side.to_string()
    }
}

/// Who called last at a side.
type Caller = Mutex<Option<SocketAddr>>;

fn pass_on(from: &UdpSocket, caller: &Caller, to: &UdpSocket, called: &Caller) {
    let mut datagram = vec![0; LARGEST];
    loop {
        // A refused datagram of a side that is not there yet is reported here; the next one may arrive.
        let Ok((length, address)) = from.recv_from(&mut datagram) else {
            continue;
        };
        if let Ok(mut caller) = caller.lock() {
            *caller = Some(address);
        }
        let receiver = called.lock().ok().and_then(|called| *called);
        if let Some(receiver) = receiver {
            // A receiver that has gone misses it, as over any network.
            let _ = to.send_to(&datagram[..length], receiver);
        }
    }
}
