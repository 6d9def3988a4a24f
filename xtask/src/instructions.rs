//! Instructions that the hot kernels execute, counted by callgrind: the same on every run, however busy the machine.

use anyhow::{Context, Result, ensure};

use crate::shell::{Run, command, has};
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
    ("kernel_refined", "fit", 1.0, 460_231.0),
    ("kernel_averaged", "record", 1.0, 6_260_294.0),
    ("kernel_identify", "log", 1.0, 47_874_802.0),
];

/// Counts and compares.
pub fn check() -> Result<()> {
    if !has("valgrind") {
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
    // Instructions of every function with all that it calls.
    let counts = command!("callgrind_annotate --inclusive=yes --threshold=100 {counts}").read()?;
    let mut slower = Vec::new();
    for (kernel, unit, units, stated) in KERNELS {
        let counted = counts.lines().find(|line| line.contains(kernel) && line.contains('('));
        let count = counted.and_then(|line| line.split_whitespace().next());
        let count = count.with_context(|| format!("callgrind.out has no {kernel}"))?;
        let count: f64 = count.replace(',', "").parse()?;
        let each = count / units;
        eprintln!("{kernel}: {each:.1} instructions a {unit}, stated {stated:.1}");
        if each > MARGIN * stated {
            slower.push(kernel);
        }
    }
    ensure!(slower.is_empty(), "more than {MARGIN} times the stated instructions: {slower:?}");
    Ok(())
}
