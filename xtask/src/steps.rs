//! Steps of a check, in order or side by side. The first that fails ends the others.

use std::fmt::Display;
use std::process::{Command, Output};
use std::sync::Mutex;
use std::time::Instant;

use anyhow::{Context, Result};

use crate::shell::words;

/// A name, and what is done.
pub type Step = (&'static str, fn() -> Result<()>);

/// The processes that steps wait for; `None` once a step has failed.
static RUNNING: Mutex<Option<Vec<u32>>> = Mutex::new(Some(Vec::new()));

/// What a step needs and is not there: the step is skipped, which is said; with `CI=true` it fails.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Missing(pub String);

/// Ends a step for want of something.
pub fn missing<T>(what: impl Display) -> Result<T> {
    Err(Missing(what.to_string()).into())
}

/// Runs a step and prints its name, its time and what it failed for.
pub fn passes(name: &str, step: impl FnOnce() -> Result<()>) -> bool {
    if is_over() {
        return false;
    }
    let start = Instant::now();
    eprintln!("== {name}");
    match step() {
        _ if is_over() => {
            eprintln!("== {name} ended");
            false
        }
        Ok(()) => {
            let seconds = start.elapsed().as_secs_f64();
            eprintln!("== {name} passed in {seconds:.0} s");
            true
        }
        Err(error)
            if error.is::<Missing>() && !std::env::var("CI").is_ok_and(|ci| ci == "true") =>
        {
            eprintln!("== {name} skipped: {error}");
            true
        }
        Err(error) => {
            eprintln!("{error:#}\n== {name} failed");
            end();
            false
        }
    }
}

/// Steps until the first that fails; did all pass?
pub fn in_order(steps: &[Step]) -> bool {
    steps.iter().all(|(name, step)| passes(name, step))
}

/// Rows of steps, each row until its first that fails; did all pass?
pub fn side_by_side(rows: &[&[Step]]) -> bool {
    std::thread::scope(|scope| {
        let running: Vec<_> = (rows.iter())
            .map(|row| scope.spawn(|| in_order(row)))
            .collect();
        (running.into_iter()).all(|row| row.join().unwrap_or(false))
    })
}

/// Runs a command to its end, or until another step fails.
pub fn wait_for(command: &mut Command) -> Result<Output> {
    let child = {
        let mut running = RUNNING.lock().expect("no panic");
        let running = running.as_mut().context("another step has failed")?;
        let child = command.spawn().with_context(|| words(command))?;
        running.push(child.id());
        child
    };
    let id = child.id();
    let output = child.wait_with_output();
    if let Some(running) = RUNNING.lock().expect("no panic").as_mut() {
        running.retain(|other| *other != id);
    }
    output.with_context(|| words(command))
}

/// Ends every command that a step waits for; no other begins.
pub fn end() {
    let running = RUNNING.lock().expect("no panic").take();
    running.unwrap_or_default().into_iter().for_each(ask_to_end);
}

/// Asks a process to end, by the shell's own `kill`: the smallest systems have no program of that name.
pub fn ask_to_end(process: impl Display) {
    let kill = format!("kill -TERM {process}");
    // One that has ended already cannot be asked.
    let _ = Command::new("sh").args(["-c", &kill]).status();
}

fn is_over() -> bool {
    RUNNING.lock().expect("no panic").is_none()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shell::{Run, command};

    /// One test, as the state is the process's.
    #[test]
    fn exact_a_step_that_fails_ends_the_others() {
        assert!(passes("one that passes", || Ok(())));
        let begun = Instant::now();
        let waits: Step = ("a step of a minute", || command!("sleep 60").run());
        let fails: Step = ("one that fails", || {
            std::thread::sleep(std::time::Duration::from_millis(200));
            anyhow::bail!("as it should")
        });
        let after: Step = ("one after it", || {
            panic!("nothing begins after a failure in its row")
        });
        assert!(!side_by_side(&[&[waits, after], &[fails, after]]));
        assert!(begun.elapsed().as_secs() < 30);
        assert!(!command!("true").works());
        assert!(!passes("another", || Ok(())));
    }
}
