//! The matrix of faults as text.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use seatrial_cli::table::number;
use seatrial_sim::faults::Moment;

use super::{Cell, FaultMatrix};
use crate::runner::Found;

/// Models, rejected and aborted trials.
fn counts(cell: &Cell) -> String {
    let counts = format!("{}/{}/{}", cell.models, cell.rejected, cell.aborted);
    match cell.failed.len() {
        0 => counts,
        failed => format!("{counts} ({failed} WRONG)"),
    }
}

fn summary(document: &FaultMatrix) -> String {
    let largest =
        |of: fn(&Cell) -> Option<f64>| document.cells.iter().filter_map(of).fold(0.0, f64::max);
    format!(
        "{} trials of {}, {} each, seeds from {}: {} did not end as they must. The farthest accepted model is {:.2} half widths of its \
         95 % interval from the truth; the longest from the condition of an abort to neutral rudder and heading hold {:.2} s.\n",
        document.trials,
        document.vehicle,
        document.seeds,
        document.seed,
        document.failed,
        largest(|cell| cell.farthest),
        largest(|cell| cell.handed_back_after_s),
    )
}

/// One row a fault, its stages beside each other.
fn rows(document: &FaultMatrix) -> Vec<Vec<String>> {
    document
        .cells
        .chunks(document.stages.len())
        .map(|cells| {
            let mut reasons = BTreeMap::new();
            for (reason, count) in cells.iter().flat_map(|cell| &cell.reasons) {
                *reasons.entry(reason.as_str()).or_insert(0) += count;
            }
            let reasons: Vec<String> = reasons
                .iter()
                .map(|(reason, count)| format!("{reason} {count}"))
                .collect();
            let largest = |of: fn(&Cell) -> Option<f64>, digits: usize| {
                let largest = cells.iter().filter_map(of).max_by(f64::total_cmp);
                number(largest, digits)
            };
            let name = cells.first().map_or("", |cell| cell.kind.name());
            std::iter::once(name.to_owned())
                .chain(cells.iter().map(counts))
                .chain([
                    largest(|cell| cell.farthest, 1),
                    largest(|cell| cell.handed_back_after_s, 2),
                    reasons.join(", "),
                ])
                .collect()
        })
        .collect()
}

fn headings(stages: &[Moment]) -> Vec<&'static str> {
    let names = stages.iter().map(|stage| stage.name());
    std::iter::once("fault")
        .chain(names)
        .chain(["farthest", "back, s", "reasons"])
        .collect()
}

impl Found for FaultMatrix {
    fn text(&self) -> String {
        let mut text = summary(self);
        text += "Trials with models at every speed / rejected / aborted, the farthest accepted model, the longest to hand back, and why:\n\n";
        let widths = [18]
            .into_iter()
            .chain(vec![10; self.stages.len()])
            .chain([8, 7, 0]);
        let widths: Vec<usize> = widths.collect();
        let headings: Vec<String> = headings(&self.stages)
            .into_iter()
            .map(String::from)
            .collect();
        for row in std::iter::once(headings).chain(rows(self)) {
            for (cell, width) in row.iter().zip(&widths) {
                let _ = write!(text, "{cell:width$}  ");
            }
            text.truncate(text.trim_end().len());
            text.push('\n');
        }
        for (cell, ending) in self
            .cells
            .iter()
            .flat_map(|cell| cell.failed.iter().map(move |ending| (cell, ending)))
        {
            let _ = writeln!(
                text,
                "WRONG: {} in {}, seed {}: {}",
                cell.kind.name(),
                cell.stage.name(),
                ending.seed,
                ending.faults.join("; ")
            );
        }
        text
    }

    fn is_good(&self) -> bool {
        self.failed == 0
    }
}

/// The matrix as a page of Markdown.
pub fn markdown(document: &FaultMatrix) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let headings: Vec<String> = headings(&document.stages)
        .into_iter()
        .map(String::from)
        .collect();
    let mark = "<!-- Fault matrix by seatrial -->\n";
    let mut text = mark.to_owned() + &summary(document) + "\n" + &line(&headings);
    text += &line(&vec!["---".into(); headings.len()]);
    for row in rows(document) {
        text += &line(&row);
    }
    text
}
