//! Steps that run beside others, in a process of their own that gives way to them.

use std::fs::File;
use std::io::Read;
use std::process::{ChildStdin, Stdio};
use std::thread::JoinHandle;

use anyhow::{Context, Result};

use crate::shell::command;
use crate::steps;
use crate::workspace::in_target;

/// `cargo xtask beside`, begun. What it prints comes when it has ended; where it failed, that ends the steps beside it.
pub struct Beside {
    ended: JoinHandle<bool>,
    /// The other process ends with it.
    life: Option<ChildStdin>,
}

impl Beside {
    /// Begins; an error where the process cannot be started.
    pub fn begin() -> Result<Self> {
        let log = in_target("beside.log");
        let output = File::create(&log).with_context(|| log.display().to_string())?;
        let program = std::env::current_exe()?;
        let mut process = command!("nice -n 10 {program} beside")
            .stdin(Stdio::piped())
            .stdout(output.try_clone()?)
            .stderr(output)
            .spawn()
            .context("nice")?;
        let life = process.stdin.take();
        let ended = std::thread::spawn(move || {
            let passed = process.wait().is_ok_and(|status| status.success());
            eprint!("{}", std::fs::read_to_string(log).unwrap_or_default());
            if !passed {
                steps::end();
            }
            passed
        });
        Ok(Self { ended, life })
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

/// Ends this process and its steps when its standard input ends, as it does with the process that began it.
pub fn end_with_the_other() {
    std::thread::spawn(|| {
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        steps::end();
        std::process::exit(1);
    });
}
