//! Other programs that do the same work, each waiting for its turn.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use crate::Outcome;

pub struct Peer {
    child: Child,
    ask: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Peer {
    /// `None`, and a line about it, where the program is missing.
    pub fn start(command: &mut Command, folder: &Path) -> Option<Self> {
        let name = format!("{command:?}");
        let started = command.arg(folder).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn();
        let Ok(mut child) = started else {
            eprintln!("refbench: {name} does not start: its lines are left out");
            return None;
        };
        let (ask, answers) = (child.stdin.take()?, child.stdout.take()?);
        Some(Self { child, ask, answers: BufReader::new(answers) })
    }

    /// Seconds for one unit of work, and the numbers it gave.
    pub fn run(&mut self, work: &str) -> Outcome<(f64, Vec<f64>)> {
        writeln!(self.ask, "{work}")?;
        self.ask.flush()?;
        let mut line = String::new();
        self.answers.read_line(&mut line)?;
        let numbers: Vec<f64> =
            line.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
        match numbers.split_first() {
            Some((seconds, rest)) => Ok((*seconds, rest.to_vec())),
            None => Err(format!("{work}: the peer stopped").into()),
        }
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
