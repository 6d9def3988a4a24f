//! One viewer of the live stream.

use std::future::pending;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::{Message as Frame, WebSocket};
use tokio::sync::broadcast::error::RecvError;
use tokio::time::{interval, timeout};

use crate::api::{Hello, LiveEvent};
use crate::convert::now;
use crate::guard::WRONG_TOKEN;
use crate::live::{HEARTBEAT_EVERY, Message};
use crate::server_state::{Caller, Seat, ServerState};

/// How long a viewer may take to say hello.
const HELLO_WITHIN: Duration = Duration::from_secs(10);
/// How long a viewer may take to let a message through.
const SENT_WITHIN: Duration = Duration::from_secs(20);

/// Shows the trial until the viewer or the server goes.
pub async fn show(mut socket: WebSocket, shared: Arc<ServerState>, caller: Caller, _seat: Seat) {
    let hello = match hello(&mut socket, &shared, &caller).await {
        Ok(hello) => hello,
        Err((code, message)) => return goodbye(&mut socket, &shared, code, message).await,
    };
    let (first, mut coming) = shared.live.join(hello.stream.as_deref(), hello.after);
    for message in first {
        if !send(&mut socket, message).await {
            return;
        }
    }
    let mut closing = shared.closing.subscribe();
    let mut heartbeat = interval(HEARTBEAT_EVERY);
    heartbeat.tick().await;
    loop {
        tokio::select! {
            message = coming.recv() => match message {
                Ok(message) => {
                    if !send(&mut socket, message).await {
                        return;
                    }
                }
                Err(RecvError::Lagged(missed)) => {
                    let lagged = shared.live.aside(LiveEvent::Lagged { missed });
                    let (snapshot, from_now) = shared.live.join(None, None);
                    coming = from_now;
                    for message in [lagged].into_iter().chain(snapshot) {
                        if !send(&mut socket, message).await {
                            return;
                        }
                    }
                }
                Err(RecvError::Closed) => return,
            },
            said = socket.recv() => match said {
                Some(Ok(Frame::Close(_)) | Err(_)) | None => return,
                Some(Ok(_)) => {}
            },
            _ = heartbeat.tick() => {
                shared.leases.claim(hello.lease.as_deref());
                let alive = shared.live.aside(LiveEvent::Heartbeat { now: now() });
                if !send(&mut socket, alive).await {
                    return;
                }
            }
            _ = closed(&mut closing) => {
                return goodbye(&mut socket, &shared, "shutting_down", "the server ends").await;
            }
        }
    }
}

async fn closed(closing: &mut tokio::sync::watch::Receiver<bool>) {
    if closing.wait_for(|closing| *closing).await.is_err() {
        pending::<()>().await;
    }
}

async fn hello(
    socket: &mut WebSocket,
    shared: &ServerState,
    caller: &Caller,
) -> Result<Hello, (&'static str, &'static str)> {
    let expected = (
        "hello_expected",
        "expected a first message within 10 s, such as {\"token\": null, \"stream\": null, \"after\": null}",
    );
    let said = timeout(HELLO_WITHIN, socket.recv()).await;
    let Ok(Some(Ok(Frame::Text(said)))) = said else {
        return Err(expected);
    };
    let hello: Hello = serde_json::from_str(&said).map_err(|_| expected)?;
    if caller.role.is_some() {
        return Ok(hello);
    }
    let tokens = shared.tokens.as_ref().zip(hello.token.as_deref());
    let is_known = tokens.is_some_and(|(tokens, token)| tokens.role(token).is_some());
    let cost = if is_known { 1.0 } else { WRONG_TOKEN };
    if !shared.rates.allows(caller.address, cost) {
        return Err((
            "too_many_requests",
            "too many requests from your address; wait some seconds",
        ));
    }
    if !is_known {
        return Err(("token_needed", "the first message has no token that is known"));
    }
    Ok(hello)
}

async fn send(socket: &mut WebSocket, (_, text): Message) -> bool {
    let sent = socket.send(Frame::Text(text));
    matches!(timeout(SENT_WITHIN, sent).await, Ok(Ok(())))
}

async fn goodbye(socket: &mut WebSocket, shared: &ServerState, code: &str, message: &str) {
    let last = shared.live.aside(LiveEvent::Goodbye { code: code.into(), message: message.into() });
    if send(socket, last).await {
        let _ = timeout(SENT_WITHIN, socket.send(Frame::Close(None))).await;
    }
}
