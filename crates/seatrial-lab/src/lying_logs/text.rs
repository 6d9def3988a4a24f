//! What became of lying logs, as text.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::{LyingLogs, Total};
use crate::runner::Found;

impl Found for LyingLogs {
    fn text(&self) -> String {
        let mut text = String::new();
        let share = |count: usize, of: usize| 100.0 * count as f64 / of as f64;
        for total in &self.totals {
            let _ = writeln!(
                text,
                "{:<12} {} logs: {} accepted ({:.1} %), {} of them wrong ({:.1} %)",
                total.decidability.name(),
                total.logs,
                total.accepted,
                share(total.accepted, total.logs),
                total.wrong,
                share(total.wrong, total.logs)
            );
        }
        if let Some(wiring) = self.wiring {
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
        for row in &self.kinds {
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

    fn is_good(&self) -> bool {
        self.totals.iter().map(Total::failed).sum::<usize>() == 0
    }
}
