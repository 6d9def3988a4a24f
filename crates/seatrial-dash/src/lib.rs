//! The dashboard: a server over HTTP and WebSocket, with its page inside.
//!
//! [`Server::start`] serves on a thread of its own until [`Server::stop`]. It runs trials, shows them live, looks up the
//! logbook and reads logs; vehicles and log formats come from the [`Workshop`] of whoever starts it. A trial that somebody
//! else conducts is shown with [`Server::attach`]. `docs/dashboard.md` says how it is used, `docs/openapi.json` what
//! it answers.
//!
//! The trial tells and never waits: see [`Tap`].

pub mod api;

mod access;
mod background;
mod connections;
mod convert;
mod guard;
mod history;
mod live;
mod page;
mod refusal;
mod routes;
mod series;
mod server;
mod shared;
mod stream;
mod trials;
mod workshop;

pub use access::NewTokens;
pub use live::Tap;
pub use server::{Server, Settings, StartError};
pub use workshop::{Craft, ReadLog, Take, Workshop};
