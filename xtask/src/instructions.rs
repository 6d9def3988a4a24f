//! Instructions that the hot kernels execute, counted by callgrind: the same on every run, however busy the machine.

use std::collections::BTreeMap;

use anyhow::{Context, Result, ensure};

use crate::shell::{Run, command, shell};
use crate::steps::missing;
use crate::workspace::in_target;

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

/// Counts and compares.
pub fn check() -> Result<()> {
    if !command!("valgrind --version").works() {
        return missing("valgrind is missing");
    }
    command!("cargo build --release -p seatrial-instructions").run()?;
    let [kernels, counts] = ["release/seatrial-instructions", "callgrind.out"].map(in_target);
    let said =
        command!("valgrind --tool=callgrind --quiet --callgrind-out-file={counts} {kernels}")
            .read()?;
    if !said.is_empty() {
        eprintln!("== instructions skipped: the counts hold for x86-64");
        return Ok(());
    }
    let counts = inclusive(&shell().read_file(counts)?);
    let mut slower = Vec::new();
    for (kernel, unit, units, stated) in KERNELS {
        let counted = counts.iter().find(|(name, _)| name.contains(kernel));
        let (_, count) = counted.with_context(|| format!("callgrind.out has no {kernel}"))?;
        let each = *count as f64 / units;
        eprintln!("{kernel}: {each:.1} instructions a {unit}, stated {stated:.1}");
        if each > MARGIN * stated {
            slower.push(kernel);
        }
    }
    ensure!(
        slower.is_empty(),
        "more than {MARGIN} times the stated instructions: {slower:?}"
    );
    Ok(())
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
