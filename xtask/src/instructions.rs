//! Instructions that the hot kernels execute, counted by callgrind: the same on every run, however busy the machine.

use std::collections::BTreeMap;
use std::process::Command;

use crate::cargo;
use crate::steps::{run, skipped};
use crate::target::in_target;

const COUNTS: &str = "callgrind.out";

/// A kernel may take this much more than is stated before the check fails: a compiler's release moves it by a few percent.
const MARGIN: f64 = 1.05;

/// Kernel, what is counted, how many of it are done, and instructions for one, measured on x86-64 with the toolchain of
/// rust-toolchain.toml.
const KERNELS: [(&str, &str, f64, f64); 6] = [
    ("kernel_online", "sample", 32_768.0, 156.0),
    ("kernel_trial", "sample", 32_768.0, 862.8),
    ("kernel_batch", "sample", 32_768.0, 66.7),
    ("kernel_refined", "fit", 1.0, 156_072.0),
    ("kernel_averaged", "record", 1.0, 6_260_294.0),
    ("kernel_identify", "log", 1.0, 47_874_802.0),
];

/// Counts and compares. Where valgrind is missing, or the machine has not the instructions that the counts hold for, this is said and
/// skipped; with `CI=true` a missing valgrind is a failure.
pub fn check() -> Result<(), String> {
    let valgrind = Command::new("valgrind").arg("--version").output();
    if !valgrind.is_ok_and(|found| found.status.success()) {
        return skipped("instructions", "valgrind is missing");
    }
    let build = ["build", "--release", "-p", "seatrial-instructions"];
    run(&mut cargo(&build), "seatrial-instructions does not build")?;
    let run = Command::new("valgrind")
        .args(["--tool=callgrind", "--quiet"])
        .arg(format!(
            "--callgrind-out-file={}",
            in_target(COUNTS).display()
        ))
        .arg(in_target("release/seatrial-instructions"))
        .output()
        .map_err(|error| format!("valgrind: {error}"))?;
    if !run.status.success() {
        return Err(format!(
            "valgrind: {}",
            String::from_utf8_lossy(&run.stderr)
        ));
    }
    if !run.stdout.is_empty() {
        eprintln!("== instructions skipped: the counts hold for x86-64");
        return Ok(());
    }
    let text =
        std::fs::read_to_string(in_target(COUNTS)).map_err(|error| format!("{COUNTS}: {error}"))?;
    let counts = inclusive(&text);
    let mut slower = Vec::new();
    for (kernel, unit, units, stated) in KERNELS {
        let counted = counts.iter().find(|(name, _)| name.contains(kernel));
        let (_, count) = counted.ok_or(format!("{COUNTS} has no {kernel}"))?;
        let each = *count as f64 / units;
        eprintln!("{kernel}: {each:.1} instructions a {unit}, stated {stated:.1}");
        if each > MARGIN * stated {
            slower.push(kernel);
        }
    }
    match slower.is_empty() {
        true => Ok(()),
        false => Err(format!(
            "more than {MARGIN} times the stated instructions: {}",
            slower.join(", ")
        )),
    }
}

/// Instructions of every function with all that it calls.
///
/// In callgrind's format a line `fn=(1) name` begins a function, later named `fn=(1)`; a line of costs ends in the count, that
/// after `calls=` in the count of the called function.
fn inclusive(text: &str) -> BTreeMap<String, u64> {
    let mut names = BTreeMap::new();
    let mut counts: BTreeMap<String, u64> = BTreeMap::new();
    let mut function = String::new();
    for line in text.lines() {
        let name = line.strip_prefix("fn=").or(line.strip_prefix("cfn="));
        if let Some(name) = name {
            let (id, rest) = name.split_once(' ').unwrap_or((name, ""));
            if !rest.is_empty() {
                names.insert(id.to_owned(), rest.to_owned());
            }
            if line.starts_with("fn=") {
                function = names.get(id).cloned().unwrap_or_default();
            }
        } else if line.starts_with(|c: char| c.is_ascii_digit() || "+-*".contains(c)) {
            let count = line.split_whitespace().nth(1);
            if let Some(count) = count.and_then(|count| count.parse::<u64>().ok()) {
                *counts.entry(function.clone()).or_default() += count;
            }
        }
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_counts_include_what_is_called() {
        let text = "fn=(1) main\n5 10\n+1 2\ncfn=(2) work\ncalls=1 9\n* 100\n\nfn=(2)\n9 100\nfn=(1)\n7 1\n";
        let counts = inclusive(text);
        assert_eq!(counts["main"], 113);
        assert_eq!(counts["work"], 100);
    }
}
