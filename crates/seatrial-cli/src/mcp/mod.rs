//! `seatrial mcp`: what programs that assist people may ask, by the Model Context Protocol on standard input and output.

mod answers;
mod moving;
mod rpc;
mod tools;

use std::io::{BufRead, Read, Write};

use serde_json::{Value, json};

use crate::output::{Exit, Failure, Output};
use moving::Lock;
use rpc::{Fault, Request};

/// Longest message that is read, bytes.
const LONGEST_MESSAGE: u64 = 1 << 20;

/// Versions of the protocol whose messages these are, newest first.
const VERSIONS: [&str; 3] = ["2025-06-18", "2025-03-26", "2024-11-05"];

/// Serve tools for AI assistants: inspect, identify, compare, plan, explain a verdict, simulate.
///
/// The protocol is the Model Context Protocol, on standard input and output. Tools that move a vehicle are locked.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Nothing is written but by the tools that move a vehicle, and what a program is told of a model that is not to be used has no numbers.
docs/mcp.md says how an assistant is set up, and lists the tools.

Example:
  echo '{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"tools/list\"}' | seatrial mcp")]
pub struct Args {
    /// Unlock the tools that move a vehicle: each call is then shown at this terminal and runs only where `yes` is typed there.
    #[arg(long)]
    allow_vehicle: bool,
}

/// Answers until standard input ends.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    if output.json {
        return Err(Failure::usage("mcp: its messages are JSON already; leave --json out"));
    }
    let lock = match args.allow_vehicle {
        true => Lock::AskedAtTheTerminal,
        false => Lock::Locked,
    };
    let mut input = std::io::stdin().lock();
    let mut answers = std::io::stdout().lock();
    while let Some(line) = next_line(&mut input).map_err(Failure::input)? {
        let Some(answer) = answer(&line, lock) else {
            continue;
        };
        let written = writeln!(answers, "{answer}").and_then(|()| answers.flush());
        if written.is_err() {
            // Nobody listens any more.
            break;
        }
    }
    Ok(Exit::Done)
}

/// The next line, or what is wrong with it; `None` at the end.
fn next_line(input: &mut impl BufRead) -> std::io::Result<Option<Result<Vec<u8>, Fault>>> {
    let mut line = Vec::new();
    if (&mut *input).take(LONGEST_MESSAGE).read_until(b'\n', &mut line)? == 0 {
        return Ok(None);
    }
    if line.last() != Some(&b'\n') && line.len() as u64 == LONGEST_MESSAGE {
        input.skip_until(b'\n')?;
        return Ok(Some(Err(Fault::request("the message is longer than 1 MiB"))));
    }
    Ok(Some(Ok(line)))
}

/// The answer to a message; `None` to a notification and to an empty line.
fn answer(line: &Result<Vec<u8>, Fault>, lock: Lock) -> Option<Value> {
    let line = match line {
        Ok(line) if line.iter().all(u8::is_ascii_whitespace) => return None,
        Ok(line) => line,
        Err(fault) => return Some(fault.answer(&Value::Null)),
    };
    let request = match Request::read(line) {
        Ok(request) => request,
        Err((id, fault)) => return Some(fault.answer(&id)),
    };
    let id = request.id.clone()?;
    Some(match result(&request, lock) {
        Ok(result) => json!({"jsonrpc": "2.0", "id": id, "result": result}),
        Err(fault) => fault.answer(&id),
    })
}

fn result(request: &Request, lock: Lock) -> Result<Value, Fault> {
    match request.method.as_str() {
        "initialize" => Ok(initialized(&request.params)),
        "ping" => Ok(json!({})),
        "tools/list" => Ok(json!({"tools": tools::list()})),
        "tools/call" => tools::call(&request.params, lock),
        other => Err(Fault::method(other)),
    }
}

/// The version that is asked for where it is known, else the newest.
fn initialized(params: &Value) -> Value {
    let asked = params["protocolVersion"].as_str().unwrap_or_default();
    let version = VERSIONS.iter().find(|version| **version == asked);
    json!({
        "protocolVersion": version.unwrap_or(&VERSIONS[0]),
        "capabilities": {"tools": {}},
        "serverInfo": {"name": "seatrial", "version": env!("CARGO_PKG_VERSION")},
        "instructions": tools::INSTRUCTIONS,
    })
}
