//! The trial against scripted vehicles: its course, every way to end it, and garbage.

mod aborts;
mod course;
mod garbage;
mod scripted;
