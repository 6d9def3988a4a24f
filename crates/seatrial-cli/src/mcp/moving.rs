//! The tools that move a vehicle: locked, unless the server was started to unlock them and a person agrees at its terminal.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::time::Duration;

use serde::Deserialize;

use super::answers::{Answer, Content};

/// May a vehicle be moved?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lock {
    /// Never.
    Locked,
    /// Where a person agrees at the terminal, each time.
    AskedAtTheTerminal,
}

/// How long the program waits for a person to agree.
const PATIENCE: Duration = Duration::from_secs(120);

/// What is to be done on a vehicle.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleQuestion {
    vehicle: String,
    logbook: String,
    plan: Option<String>,
    campaign: Option<String>,
}

/// Runs a verb on a vehicle, where that is allowed: the verb itself, in a process of its own, which hands the vehicle back.
pub fn run(verb: &str, asked: &VehicleQuestion, lock: Lock) -> Answer {
    if lock == Lock::Locked {
        return Err(format!(
            "locked: {verb} moves a vehicle. A person starts the server with `seatrial mcp --allow-vehicle` in a terminal, and agrees there to each call."
        ));
    }
    let mut arguments = vec![
        verb.to_owned(),
        format!("--vehicle={}", asked.vehicle),
        format!("--logbook={}", asked.logbook),
        "--yes".to_owned(),
        "--json".to_owned(),
    ];
    for (option, value) in [("--plan", &asked.plan), ("--campaign", &asked.campaign)] {
        arguments.extend(value.as_ref().map(|value| format!("{option}={value}")));
    }
    agreed(&arguments)?;
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let done = Command::new(program)
        .args(&arguments)
        .stdin(Stdio::null())
        .output()
        .map_err(|error| error.to_string())?;
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    match serde_json::from_slice(&done.stdout) {
        Ok(document) => Ok(Content {
            say: format!("{verb} ended; its verdict is in the document. {}", said.trim()),
            document,
        }),
        Err(_) => Err(said.trim().to_owned()),
    }
}

/// The screen and the keyboard of the person, whatever standard input and output are.
fn terminal() -> std::io::Result<(File, File)> {
    let open = |name| File::options().read(true).write(true).open(name);
    match cfg!(windows) {
        true => Ok((open("CONOUT$")?, open("CONIN$")?)),
        false => open("/dev/tty").and_then(|both| Ok((both.try_clone()?, both))),
    }
}

/// Shows at the terminal what is asked for, and waits for `yes`.
fn agreed(arguments: &[String]) -> Result<(), String> {
    let no_terminal = |error: std::io::Error| {
        format!("refused: no terminal at which a person could agree ({error})")
    };
    let (mut screen, keyboard) = terminal().map_err(no_terminal)?;
    let shown: Vec<String> = arguments.iter().map(|a| a.escape_debug().to_string()).collect();
    writeln!(
        screen,
        "\nAn assistant wants to MOVE A VEHICLE:\n  seatrial {}\nType yes to let it; anything else refuses.",
        shown.join(" ")
    )
    .map_err(no_terminal)?;
    let (answer, answered) = mpsc::channel();
    std::thread::spawn(move || {
        let mut line = String::new();
        let read = BufReader::new(keyboard).read_line(&mut line);
        // Nobody waits any more where the time was up.
        let _ = answer.send(read.map(|_| line));
    });
    match answered.recv_timeout(PATIENCE) {
        Ok(Ok(line)) if line.trim() == "yes" => Ok(()),
        Ok(Ok(_)) => Err("refused at the terminal".into()),
        Ok(Err(error)) => Err(no_terminal(error)),
        Err(_) => Err("refused: nobody answered at the terminal".into()),
    }
}
