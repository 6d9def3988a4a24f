//! Checks that run beside others, in a process of their own that gives way to them.

use std::fs::File;
use std::process::{Child, Command, Stdio};

const LOG: &str = "target/beside.log";

/// `cargo xtask beside`, begun. What it prints comes when it has ended.
pub struct Beside(Child);

impl Beside {
    /// Begins; an error where the process cannot be started.
    pub fn begin() -> Result<Self, String> {
        std::fs::create_dir_all("target").map_err(|error| format!("target: {error}"))?;
        let log = File::create(LOG).map_err(|error| format!("{LOG}: {error}"))?;
        let errors = log.try_clone().map_err(|error| format!("{LOG}: {error}"))?;
        let program = std::env::current_exe().map_err(|error| error.to_string())?;
        Command::new("nice")
            .args(["-n", "10"])
            .arg(program)
            .arg("beside")
            .stdin(Stdio::null())
            .stdout(log)
            .stderr(errors)
            .spawn()
            .map(Self)
            .map_err(|error| format!("nice: {error}"))
    }

    /// Waits for the end and prints what was printed. Did all pass?
    pub fn passed(mut self) -> bool {
        let status = self.0.wait();
        eprint!("{}", std::fs::read_to_string(LOG).unwrap_or_default());
        status.is_ok_and(|status| status.success())
    }
}
