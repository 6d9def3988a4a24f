//! Progress of many runs.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressStyle};

/// A bar on a terminal.
pub fn bar(runs: u64) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} runs {per_sec} {eta}");
    ProgressBar::new(runs).with_style(style.unwrap_or(ProgressStyle::default_bar()))
}
