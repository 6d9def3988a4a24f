//! What became of worlds, as text.

use std::fmt::Write as _;

use seatrial_cli::table::{Table, number};

use super::{Depth, Models, Worlds};
use crate::faults::PARAMETERS;
use crate::runner::Found;

/// The word for a depth.
pub fn name(depth: Depth) -> String {
    format!("{depth:?}").to_lowercase()
}

impl Found for Worlds {
    fn text(&self) -> String {
        let mut text = format!(
            "{} worlds from seed {}: {} with a broken invariant\n\n",
            self.seeds, self.seed, self.broken
        );
        let mut table =
            Table::under("depth | worlds | runs | accepted | samples | neutral [s] | broken");
        for (depth, row) in &self.depths {
            table.row(vec![
                name(*depth),
                row.worlds.to_string(),
                row.runs.to_string(),
                row.runs_accepted.to_string(),
                row.samples.to_string(),
                number(row.neutral_after_s, 2),
                row.broken.to_string(),
            ]);
        }
        text += &table.to_string();
        let depths = self.depths.iter();
        for (depth, row) in depths.filter(|(_, row)| row.models.accepted > 0) {
            text.push_str(&models(*depth, &row.models));
        }
        let outcomes: Vec<String> = self
            .outcomes
            .iter()
            .map(|(outcome, count)| format!("{outcome} {count}"))
            .collect();
        let _ = writeln!(text, "\n{}", outcomes.join(", "));
        if let Some(bytes) = self.peak_memory_bytes {
            let _ = writeln!(text, "most memory: {:.0} MB", bytes as f64 / 1e6);
        }
        for broken in &self.broken_together {
            let _ = writeln!(text, "all worlds: {broken}");
        }
        for ending in &self.broken_worlds {
            for broken in &ending.broken {
                let _ = writeln!(
                    text,
                    "seatrial-lab world --seed {} --seeds 1: {broken}",
                    ending.seed
                );
            }
        }
        text
    }

    fn is_good(&self) -> bool {
        self.broken == 0 && self.broken_together.is_empty()
    }
}

/// Accepted models beside the truth.
fn models(depth: Depth, models: &Models) -> String {
    let mut table = Table::under(&format!(
        "{}, {} accepted models | beyond 1 half width | [%] | beyond 2 | farthest",
        name(depth),
        models.accepted
    ));
    for (k, name) in PARAMETERS.into_iter().enumerate() {
        let share = 100.0 * models.beyond_one[k] as f64 / models.accepted as f64;
        table.row(vec![
            name.into(),
            models.beyond_one[k].to_string(),
            format!("{share:.1}"),
            models.beyond_two[k].to_string(),
            format!("{:.2}", models.farthest[k]),
        ]);
    }
    format!("\n{table}")
}
