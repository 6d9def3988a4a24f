//! Every test of the crate in one program: it links once.

mod commission;
mod examples;
mod field;
mod help;
mod study;
mod surge;
