//! From measured rounds to ratios beside their goals.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::{Value, json};

/// Seconds of each round, by the name of the work.
#[derive(Default)]
pub struct Rounds(pub BTreeMap<&'static str, Vec<f64>>);

/// A ratio and the most that it should be.
pub struct Goal {
    pub work: &'static str,
    pub beside: &'static str,
    pub most: f64,
    /// How the issue puts it.
    pub text: &'static str,
}

pub struct Spread {
    pub median: f64,
    pub least: f64,
    pub most: f64,
}

impl Spread {
    pub fn of(values: &[f64]) -> Option<Self> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        Some(Self {
            median: *sorted.get(sorted.len() / 2)?,
            least: *sorted.first()?,
            most: *sorted.last()?,
        })
    }
}

impl Rounds {
    pub fn add(&mut self, work: &'static str, seconds: f64) {
        self.0.entry(work).or_default().push(seconds);
    }

    /// The ratio of each round.
    pub fn ratio(&self, work: &str, beside: &str) -> Option<Spread> {
        let (ours, theirs) = (self.0.get(work)?, self.0.get(beside)?);
        let ratios: Vec<f64> = ours.iter().zip(theirs).map(|(a, b)| a / b).collect();
        Spread::of(&ratios)
    }

    pub fn json_lines(&self) -> impl Iterator<Item = Value> {
        self.0.iter().filter_map(|(work, seconds)| {
            let spread = Spread::of(seconds)?;
            Some(json!({
                "work": work, "median_ns": spread.median * 1e9, "least_ns": spread.least * 1e9,
                "most_ns": spread.most * 1e9, "rounds": seconds.len(),
            }))
        })
    }

    pub fn times(&self) -> String {
        let mut text = String::from("| work | median | least | most |\n|---|---|---|---|\n");
        for (work, seconds) in &self.0 {
            if let Some(Spread { median, least, most }) = Spread::of(seconds) {
                let _ =
                    writeln!(text, "| {work} | {} | {} | {} |", ns(median), ns(least), ns(most));
            }
        }
        text
    }

    pub fn goals(&self, goals: &[Goal]) -> (String, Vec<Value>) {
        let mut text = String::from(
            "| work | beside | goal | measured | least to most | |\n|---|---|---|---|---|---|\n",
        );
        let mut lines = Vec::new();
        for goal in goals {
            let Goal { work, beside, most, text: asked } = goal;
            let Some(ratio) = self.ratio(work, beside) else {
                let _ = writeln!(text, "| {work} | {beside} | {asked} | not measured | | |");
                continue;
            };
            let is_met = ratio.median <= *most;
            let mark = if is_met { "met" } else { "**missed**" };
            let show = |value: f64| match asked.contains('/') {
                true => format!("1/{:.0}", 1.0 / value),
                false => format!("{value:.2}"),
            };
            let _ = writeln!(
                text,
                "| {work} | {beside} | {asked} | {} | {} to {} | {mark} |",
                show(ratio.median),
                show(ratio.least),
                show(ratio.most)
            );
            lines.push(json!({
                "work": work, "beside": beside, "goal": most, "ratio": ratio.median,
                "least": ratio.least, "most": ratio.most, "met": is_met,
            }));
        }
        (text, lines)
    }
}

fn ns(seconds: f64) -> String {
    match seconds {
        s if s < 1e-6 => format!("{:.2} ns", s * 1e9),
        s if s < 1e-3 => format!("{:.2} us", s * 1e6),
        s => format!("{:.2} ms", s * 1e3),
    }
}
