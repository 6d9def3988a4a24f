//! What became of lying logs, as text.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::{LyingLogs, name};

/// The document for a person to read.
pub fn text(document: &LyingLogs) -> String {
    let mut text = String::new();
    let share = |count: usize, of: usize| 100.0 * count as f64 / of as f64;
    for total in &document.totals {
        let _ = writeln!(
            text,
            "{:<12} {} logs: {} accepted ({:.1} %), {} of them wrong ({:.1} %)",
            name(total.decidability),
            total.logs,
            total.accepted,
            share(total.accepted, total.logs),
            total.wrong,
            share(total.wrong, total.logs)
        );
    }
    if let Some(wiring) = document.wiring {
        let _ = writeln!(
            text,
            "{:<12} {} logs: {} right, {} wrong, {} refused with the column named ({:.1} % right or named), another column blamed in {}",
            "wired wrong",
            wiring.logs,
            wiring.right,
            wiring.wrong,
            wiring.named,
            share(wiring.right + wiring.named, wiring.logs),
            wiring.accused
        );
    }
    let _ = writeln!(
        text,
        "\n{:<28} {:>8} {:>6} {:>8}  refused because; noted",
        "kind", "accepted", "wrong", "outside"
    );
    let list = |codes: &BTreeMap<String, usize>| {
        let codes: Vec<String> = codes
            .iter()
            .map(|(code, n)| format!("{code} {n}"))
            .collect();
        codes.join(", ")
    };
    for row in &document.kinds {
        let line = format!(
            "{:<28} {:>5}/{:<2} {:>6} {:>8}  {}; {}",
            row.kind,
            row.total.accepted,
            row.total.logs,
            row.total.wrong,
            row.outside,
            list(&row.refused),
            list(&row.noted)
        );
        let _ = writeln!(text, "{}", line.trim_end_matches([';', ' ']));
        for (code, seeds) in &row.accused {
            let _ = writeln!(text, "    another column blamed by {code}: seeds {seeds:?}");
        }
    }
    text
}
