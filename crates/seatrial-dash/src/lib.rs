//! The dashboard: a server over HTTP and WebSocket, with its page inside.
//!
//! [`Server::start`] serves on a thread of its own until [`Server::stop`]. It runs trials, shows them live, looks up the
//! logbook and reads logs; the vehicles come from whoever starts it. A trial that somebody else conducts is shown with
//! [`Server::attach`]. `docs/dashboard.md` says how it is used, `docs/openapi.json` what it answers.
//!
//! A trial never waits for who watches it: what it shows goes into a queue.

pub mod api;

mod access;
mod background;
mod connections;
mod convert;
mod guard;
mod history;
mod live;
mod logs;
mod page;
mod refusal;
mod routes;
mod series;
mod server;
mod shared;
mod slot;
mod stream;
mod trials;

pub use access::NewTokens;
pub use routes::openapi_json;
pub use server::{Server, Settings, StartError};
pub use slot::Shown;
