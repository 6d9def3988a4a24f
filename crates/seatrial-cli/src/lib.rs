//! What the programs of a terminal share, `seatrial` and the project's own `seatrial-lab`: exit codes, standard output as text or JSON,
//! tables, progress, signals.

pub mod interrupt;
pub mod output;
pub mod progress;
pub mod screen;
pub mod standard_error;
pub mod table;
