//! Many logs at once: one row per manoeuvre, one error row per log that cannot be read.
//!
//! [`Job`] reads the logs that [`find`] found, on several threads, and writes a Parquet file. What is done goes to a
//! [`Journal`] beside that file at once, so that a job that was killed goes on where it stopped; the Parquet file is
//! made from the journal, in the order of the logs whatever the threads did. A later job takes the rows of unchanged logs
//! from that file. A worker on another machine does [`work_on`] and sends back what the journal takes.

mod columns;
mod earlier;
mod job;
mod journal;
mod log;
mod log_file;
mod objects;
mod row;
mod source;
mod table;

pub use columns::{COLUMNS, Column, Row, Value};
pub use job::{Job, Progress, work_on};
pub use journal::{Entry, Journal, JournalError, Summary};
pub use log::{Estimate, Options};
pub use log_file::{LogFiles, Source};
pub use objects::{ObjectError, is_object};
pub use source::{NotFound, find};
