//! Connections: so many, and none that dawdles.

use std::collections::HashMap;
use std::net::{IpAddr, SocketAddr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::Router;
use axum::extract::ConnectInfo;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::{TcpListener, TcpStream};
use tower::Service;

/// How long a client may take to say what it wants, and how long a connection may be kept without wanting anything.
const HEAD_WITHIN: Duration = Duration::from_secs(5);
/// Connections at a time, and those of one address; a viewer of the live stream has a seat instead.
const MOST: usize = 512;
const MOST_OF_ONE: usize = 128;
/// Pause after a connection that could not be accepted, as where there are no file descriptors left.
const PAUSE: Duration = Duration::from_millis(50);

/// Serves connections for ever.
pub async fn serve(listener: TcpListener, router: Router) {
    let door = Arc::new(Door::default());
    loop {
        let Ok((stream, peer)) = listener.accept().await else {
            tokio::time::sleep(PAUSE).await;
            continue;
        };
        // Who comes too many is not even answered: that would cost more than coming.
        if let Some(guest) = door.admit(peer.ip().to_canonical()) {
            tokio::spawn(converse(stream, peer, router.clone(), guest));
        }
    }
}

async fn converse(stream: TcpStream, peer: SocketAddr, router: Router, _guest: Guest) {
    // Samples are not to wait until there are enough of them for a packet.
    let _ = stream.set_nodelay(true);
    let service = service_fn(move |mut request: hyper::Request<Incoming>| {
        request.extensions_mut().insert(ConnectInfo(peer));
        router.clone().call(request)
    });
    // A client that broke off is none of ours.
    let _ = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_WITHIN)
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades()
        .await;
}

/// Counts who is inside.
#[derive(Debug, Default)]
struct Door {
    inside: Mutex<HashMap<IpAddr, usize>>,
}

impl Door {
    fn admit(self: &Arc<Self>, address: IpAddr) -> Option<Guest> {
        let mut inside = self.inside();
        let all: usize = inside.values().sum();
        let own = inside.get(&address).copied().unwrap_or(0);
        if all >= MOST || own >= MOST_OF_ONE {
            return None;
        }
        inside.insert(address, own + 1);
        Some(Guest {
            door: Arc::clone(self),
            address,
        })
    }

    fn inside(&self) -> MutexGuard<'_, HashMap<IpAddr, usize>> {
        self.inside.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A place among the connections, free again when dropped.
struct Guest {
    door: Arc<Door>,
    address: IpAddr,
}

impl Drop for Guest {
    fn drop(&mut self) {
        let mut inside = self.door.inside();
        let left = inside.get(&self.address).map_or(0, |own| own - 1);
        if left == 0 {
            inside.remove(&self.address);
        } else {
            inside.insert(self.address, left);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn io_one_address_does_not_keep_others_out() {
        let door = Arc::new(Door::default());
        let of = |last: u8| IpAddr::from([192, 0, 2, last]);
        let crowd: Vec<Guest> = (0..MOST_OF_ONE)
            .map(|_| door.admit(of(1)).unwrap())
            .collect();
        assert!(door.admit(of(1)).is_none());
        let other = door.admit(of(2)).unwrap();
        drop(crowd);
        assert!(door.admit(of(1)).is_some());
        drop(other);
        assert!(door.inside().is_empty());
        let all: Vec<Guest> = (0..)
            .map_while(|k| door.admit(of((k % 250) as u8)))
            .collect();
        assert_eq!(all.len(), MOST);
    }
}
