//! Limits on concurrent and idle connections.

use std::collections::HashMap;
use std::convert::Infallible;
use std::net::{IpAddr, SocketAddr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::Router;
use axum::body::Body;
use axum::extract::{ConnectInfo, Request};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::{TcpListener, TcpStream};
use tower::Service;

use crate::guard::ABORT;
use crate::refusal::Refusal;

/// How long the head of a request may take, from the connection or from the answer before it.
const HEAD_WITHIN: Duration = Duration::from_secs(5);
/// Connections at a time, and those of one address. A live stream counts among the viewers instead.
const MOST: usize = 512;
const MOST_OF_ONE: usize = 128;
/// Connections beyond these, kept for aborts alone, and how long the head of an abort may take.
const MOST_ABORTS: usize = 64;
const ABORT_WITHIN: Duration = Duration::from_secs(1);
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
        // A connection too many is closed without an answer, which would cost more than the connection.
        if let Some(guest) = door.admit(peer.ip().to_canonical()) {
            tokio::spawn(converse(stream, peer, router.clone(), guest));
        }
    }
}

/// Answers the requests of a connection until its client closes it or breaks it off.
async fn converse(stream: TcpStream, peer: SocketAddr, router: Router, guest: Guest) {
    // Samples are not to wait until there are enough of them for a packet.
    let _ = stream.set_nodelay(true);
    let is_for_aborts = guest.address.is_none();
    let service = service_fn(move |request: hyper::Request<hyper::body::Incoming>| {
        let mut request = request.map(Body::new);
        request.extensions_mut().insert(ConnectInfo(peer));
        answer(router.clone(), request, is_for_aborts)
    });
    let within = if is_for_aborts { ABORT_WITHIN } else { HEAD_WITHIN };
    let _ = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(within)
        .keep_alive(!is_for_aborts)
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades()
        .await;
}

async fn answer(
    mut router: Router,
    request: Request,
    is_for_aborts: bool,
) -> Result<Response, Infallible> {
    if is_for_aborts && request.uri().path() != ABORT {
        let text = "too many connections; close some";
        let refusal = Refusal::new(StatusCode::SERVICE_UNAVAILABLE, "busy", text);
        return Ok(refusal.into_response());
    }
    router.call(request).await
}

/// Counts connections by address; those kept for aborts have none.
#[derive(Debug, Default)]
struct Door {
    open: Mutex<HashMap<Option<IpAddr>, usize>>,
}

impl Door {
    fn admit(self: &Arc<Self>, address: IpAddr) -> Option<Guest> {
        let mut open = self.open();
        let count = |key| open.get(&key).copied().unwrap_or(0);
        let aborts = count(None);
        let all = open.values().sum::<usize>() - aborts;
        let is_full = all >= MOST || count(Some(address)) >= MOST_OF_ONE;
        if is_full && aborts >= MOST_ABORTS {
            return None;
        }
        let address = (!is_full).then_some(address);
        *open.entry(address).or_default() += 1;
        Some(Guest { door: Arc::clone(self), address })
    }

    fn open(&self) -> MutexGuard<'_, HashMap<Option<IpAddr>, usize>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A connection that is counted until this is dropped.
struct Guest {
    door: Arc<Door>,
    /// `None`: beyond the limits, for aborts alone.
    address: Option<IpAddr>,
}

impl Drop for Guest {
    fn drop(&mut self) {
        let mut open = self.door.open();
        let left = open.get(&self.address).map_or(0, |own| own - 1);
        if left == 0 {
            open.remove(&self.address);
        } else {
            open.insert(self.address, left);
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
        let is_full = |guest: Option<Guest>| guest.is_none_or(|guest| guest.address.is_none());
        let crowd: Vec<Guest> = (0..MOST_OF_ONE).map(|_| door.admit(of(1)).unwrap()).collect();
        assert!(is_full(door.admit(of(1))));
        let other = door.admit(of(2)).unwrap();
        assert!(other.address.is_some());
        drop(crowd);
        assert!(!is_full(door.admit(of(1))));
        drop(other);
        assert!(door.open().is_empty());
        let all: Vec<Guest> = (0..).map_while(|k| door.admit(of((k % 250) as u8))).collect();
        assert_eq!(all.len(), MOST + MOST_ABORTS);
        let for_aborts = all.iter().filter(|guest| guest.address.is_none());
        assert_eq!(for_aborts.count(), MOST_ABORTS);
    }
}
