//! Steps of a check, in order or side by side. The first that fails ends the others.

use std::fmt::Display;
use std::time::Instant;

use anyhow::Result;

use crate::shell::{end_all, is_over};

/// A name, and what is done.
pub type Step = (&'static str, fn() -> Result<()>);

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
            end_all();
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
        let running: Vec<_> = (rows.iter()).map(|row| scope.spawn(|| in_order(row))).collect();
        (running.into_iter()).all(|row| row.join().unwrap_or(false))
    })
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
        let after: Step = ("one after it", || panic!("nothing begins after a failure in its row"));
        assert!(!side_by_side(&[&[waits, after], &[fails, after]]));
        assert!(begun.elapsed().as_secs() < 30);
        assert!(!command!("true").works());
        assert!(!passes("another", || Ok(())));
    }
}
