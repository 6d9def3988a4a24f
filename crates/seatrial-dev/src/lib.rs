//! What the tests of several crates need: recorded data, other tools, and seatrial as a process.
//!
//! ```
//! // A test on recorded data ends here where they are absent; with `CI=true` it fails.
//! let Some(log) = seatrial_dev::data("real/fuzhou_zz.csv") else {
//!     return;
//! };
//! assert!(log.exists());
//! ```

mod any_number;
mod damage;
mod needed;
mod process;

pub use any_number::with_any_number;
pub use damage::{Damage, damaged_copies};
pub use needed::{data, python_with, skip};
pub use process::{
    document, lab, program, program_path, run, run_in, run_to_text, start_in, text, unwrapped,
};
