//! Steps that run beside others, in a process of their own that gives way to them.

use std::fs::File;
use std::io::Read;
use std::process::Stdio;

use anyhow::{Context, Result};

use crate::shell::{command, end_all};
use crate::workspace::in_target;

/// Runs steps with `cargo xtask beside` beside them, which prints when it has ended. Where one of both fails, that ends the other.
/// Did both pass?
pub fn beside(steps: impl Fn() -> bool) -> bool {
    run(steps).unwrap_or_else(|error| {
        eprintln!("xtask: {error:#}");
        false
    })
}

fn run(steps: impl Fn() -> bool) -> Result<bool> {
    let log = in_target("beside.log");
    let output = File::create(&log).with_context(|| log.display().to_string())?;
    let program = std::env::current_exe()?;
    let mut other = command!("nice -n 10 {program} beside")
        .stdin(Stdio::piped())
        .stdout(output.try_clone()?)
        .stderr(output)
        .spawn()
        .context("nice")?;
    // The other process ends with it.
    let life = other.stdin.take();
    std::thread::scope(|scope| {
        let other = scope.spawn(|| {
            let passed = other.wait().is_ok_and(|status| status.success());
            eprint!("{}", std::fs::read_to_string(&log).unwrap_or_default());
            if !passed {
                end_all();
            }
            passed
        });
        let life = life.filter(|_| steps());
        let passed = life.is_some();
        let other_passed = other.join().unwrap_or(false);
        drop(life);
        Ok(passed && other_passed)
    })
}

/// Ends this process and its steps when its standard input ends, as it does with the process that began it.
pub fn end_with_the_other() {
    std::thread::spawn(|| {
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        end_all();
        std::process::exit(1);
    });
}
