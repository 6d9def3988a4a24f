//! Steps that run beside others, in a process of their own that gives way to them.

use std::fs::File;
use std::io::Read;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread::JoinHandle;

use crate::steps;
use crate::target::in_target;

/// `cargo xtask beside`, begun. What it prints comes when it has ended; where it failed, that ends the steps beside it.
pub struct Beside {
    ended: JoinHandle<bool>,
    /// The other process ends with it.
    life: Option<ChildStdin>,
}

impl Beside {
    /// Begins; an error where the process cannot be started.
    pub fn begin() -> Result<Self, String> {
        let log = in_target("beside.log");
        let failed = |error: std::io::Error| format!("{}: {error}", log.display());
        let output = File::create(&log).map_err(failed)?;
        let errors = output.try_clone().map_err(failed)?;
        let program = std::env::current_exe().map_err(|error| error.to_string())?;
        let mut process = Command::new("nice")
            .args(["-n", "10"])
            .arg(program)
            .arg("beside")
            .stdin(Stdio::piped())
            .stdout(output)
            .stderr(errors)
            .spawn()
            .map_err(|error| format!("nice: {error}"))?;
        Ok(Self {
            life: process.stdin.take(),
            ended: std::thread::spawn(move || passed(process, &log)),
        })
    }

    /// Waits for the end. Did all pass?
    pub fn passed(self) -> bool {
        self.ended.join().unwrap_or(false)
    }

    /// Ends it early.
    pub fn end(mut self) {
        self.life = None;
        let _ = self.ended.join();
    }
}

fn passed(mut process: Child, log: &std::path::Path) -> bool {
    let passed = process.wait().is_ok_and(|status| status.success());
    eprint!("{}", std::fs::read_to_string(log).unwrap_or_default());
    if !passed {
        steps::end();
    }
    passed
}

/// Ends this process and its steps when its standard input ends, as it does with the process that began it.
pub fn end_with_the_other() {
    std::thread::spawn(|| {
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        steps::end();
        std::process::exit(1);
    });
}
