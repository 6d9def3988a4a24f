//! The library for C and the core under Miri, which finds wrong memory and undefined operations in every access that a test makes.
//! It needs a nightly toolchain: `rustup toolchain install nightly --component miri,rust-src`.

use anyhow::{Context, Result};

use crate::shell::{Run, command};

/// Big-endian, and without the inline assembly that `libm` has for other machines, which Miri does not know.
const MACHINE: &str = "s390x-unknown-linux-gnu";
/// What takes some minutes there, where an instruction takes some hundred times as long. Left out are properties of many drawn
/// numbers and a test that simulates many loops, which take hours.
const TESTS: [&str; 2] = [
    "-p seatrial-ffi --test misuse",
    "-p seatrial-core --lib -- --skip prop_ --skip exact_sampled_gain_margin_is_the_edge_of_stability",
];

/// Runs the tests.
pub fn check() -> Result<()> {
    for tests in TESTS.map(str::split_whitespace) {
        command!("rustup run nightly cargo miri test --target {MACHINE} {tests...}")
            .run()
            .context(
                "Miri comes with rustup toolchain install nightly --component miri,rust-src",
            )?;
    }
    Ok(())
}
