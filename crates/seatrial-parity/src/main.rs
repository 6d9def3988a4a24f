//! Prints the parity vectors: `parity-vectors TABLE f32|f64`, or all of them without arguments.

use std::io::{self, Write};
use std::process::ExitCode;

use seatrial_parity::{Table, write, write_all};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut text = String::new();
    let table = |name: &str| Table::ALL.into_iter().find(|table| table.name() == name);
    let written = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => write_all(&mut text),
        [name, number] => match (table(name), number) {
            (Some(table), "f32") => write::<f32>(table, &mut text),
            (Some(table), "f64") => write::<f64>(table, &mut text),
            _ => return usage(),
        },
        _ => return usage(),
    };
    if written.is_err() || io::stdout().write_all(text.as_bytes()).is_err() {
        eprintln!("parity-vectors: the rehearsal did not end, or nobody reads");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

fn usage() -> ExitCode {
    eprint!("usage: parity-vectors [TABLE f32|f64]; tables:");
    for table in Table::ALL {
        eprint!(" {}", table.name());
    }
    eprintln!();
    ExitCode::from(2)
}
