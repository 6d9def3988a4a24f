//! What a person does with seatrial, each once for every edge: the terminal, the dashboard, Python.

pub mod conduct;
pub mod fleet;
pub mod paper;
pub mod replay;
