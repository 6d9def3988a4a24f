#![doc = include_str!("../README.md")]

pub mod api;

mod access;
mod background;
mod blueos;
mod board;
mod commission;
mod connections;
mod convert;
mod guard;
mod history;
mod live;
mod logs;
mod models;
mod page;
mod refusal;
mod routes;
mod server;
mod server_state;
mod slot;
mod stream;
mod trials;
mod uploads;

pub use access::NewTokens;
pub use routes::OPENAPI_JSON;
#[cfg(feature = "openapi")]
pub use routes::openapi_of_types;
pub use server::{Server, Settings, StartError};
pub use slot::TrialPlace;
