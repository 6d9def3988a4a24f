//! Steps of a check, in order or side by side. The first that fails ends the others.

use std::fmt::Display;
use std::process::Command;
use std::sync::Mutex;
use std::time::Instant;

/// The processes that steps wait for; `None` once a step has failed.
static RUNNING: Mutex<Option<Vec<u32>>> = Mutex::new(Some(Vec::new()));

/// Runs a step and prints its name, its time and what it failed for.
pub fn passes(name: &str, step: impl FnOnce() -> Result<(), String>) -> bool {
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
        Err(message) => {
            eprintln!("{message}\n== {name} failed");
            end();
            false
        }
    }
}

/// A name, and what is done.
pub type Step = (&'static str, fn() -> Result<(), String>);

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
pub fn succeeds(command: &mut Command) -> bool {
    let Some(mut child) = started(command) else {
        return false;
    };
    let status = child.wait();
    if let Ok(Some(running)) = RUNNING.lock().as_deref_mut().map(Option::as_mut) {
        running.retain(|id| *id != child.id());
    }
    status.is_ok_and(|status| status.success())
}

/// Runs a command as [`succeeds`] does; what failed where it fails.
pub fn run(command: &mut Command, failed: impl Into<String>) -> Result<(), String> {
    match succeeds(command) {
        true => Ok(()),
        false => Err(failed.into()),
    }
}

fn started(command: &mut Command) -> Option<std::process::Child> {
    let mut running = RUNNING.lock().ok()?;
    let running = running.as_mut()?;
    match command.spawn() {
        Ok(child) => {
            running.push(child.id());
            Some(child)
        }
        Err(error) => {
            let program = command.get_program().display();
            eprintln!("{program}: {error}");
            None
        }
    }
}

/// Ends every command that a step waits for; no other begins.
pub fn end() {
    let running = RUNNING.lock().ok().and_then(|mut running| running.take());
    for id in running.unwrap_or_default() {
        ask_to_end(id);
    }
}

/// Asks a process to end, by the shell's own `kill`: the smallest systems have no program of that name.
pub fn ask_to_end(process: impl Display) {
    let kill = format!("kill -TERM {process}");
    // One that has ended already cannot be asked.
    let _ = Command::new("sh").args(["-c", &kill]).status();
}

fn is_over() -> bool {
    RUNNING.lock().is_ok_and(|running| running.is_none())
}

/// A step for which something is missing: said and skipped; with `CI=true` a failure.
pub fn skipped(step: &str, missing: &str) -> Result<(), String> {
    match std::env::var("CI").as_deref() {
        Ok("true") => Err(missing.into()),
        _ => {
            eprintln!("== {step} skipped: {missing}");
            Ok(())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One test, as the state is the process's.
    #[test]
    fn exact_a_step_that_fails_ends_the_others() {
        assert!(passes("one that passes", || Ok(())));
        let begun = Instant::now();
        let waits: Step = ("a step of a minute", || {
            run(Command::new("sleep").arg("60"), "sleep")
        });
        let fails: Step = ("one that fails", || {
            std::thread::sleep(std::time::Duration::from_millis(200));
            Err("as it should".into())
        });
        let after: Step = ("one after it", || {
            panic!("nothing begins after a failure in its row")
        });
        assert!(!side_by_side(&[&[waits, after], &[fails, after]]));
        assert!(begun.elapsed().as_secs() < 30);
        assert!(!succeeds(&mut Command::new("true")));
        assert!(!passes("another", || Ok(())));
    }
}
