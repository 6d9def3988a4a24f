//! The page of a Monte Carlo study.

use super::chart::{Chart, Layer, Panel};
use super::headline::{Headline, Tone};
use super::number::{decimals, decimals_or_missing, significant};
use super::tables::{Table, under};
use super::{Figure, Page, RunSection};
use seatrial::study::{Accuracy, Cell, QuantityAccuracy};

/// The page of a study: `title` names what was studied, `runs` those of a cell.
pub fn render(title: &str, runs: u64, cells: &[Cell]) -> String {
    let page = Page {
        title: format!("Accuracy on {title}"),
        subtitle: format!("{runs} simulated runs for each noise and disturbance"),
        headline: Headline {
            tone: Tone::Good,
            verdict: format!(
                "{} disturbances, {} estimators",
                cells.len(),
                estimators(cells).count()
            ),
            findings: cells.iter().filter_map(convergence).collect(),
            command: String::new(),
            next: Vec::new(),
        },
        runs: vec![RunSection {
            anchor: "against-the-bound".to_owned(),
            title: "Against the bound".to_owned(),
            verdict: None,
            reasons: Vec::new(),
            facts: Vec::new(),
            figures: (0..estimators(cells).count())
                .filter_map(|estimator| figure(cells, estimator))
                .collect(),
        }],
        every_run: Some(table(cells)),
        ..Page::default()
    };
    page.text()
}

fn estimators(cells: &[Cell]) -> impl Iterator<Item = &Accuracy> {
    cells.iter().take(1).flat_map(|cell| &cell.estimators)
}

fn sea(cell: &Cell) -> String {
    let noise = format!("{}°", cell.compass_noise_deg);
    if cell.disturbance_rad_s2 > 0.0 {
        format!("{noise}, {} rad/s² for {} s", cell.disturbance_rad_s2, cell.disturbance_time_s)
    } else {
        format!("{noise}, no disturbance")
    }
}

fn convergence(cell: &Cell) -> Option<String> {
    let found = cell.convergence?;
    Some(format!(
        "{}: the 95 % half widths of a22 and b2 are under {} % after {} s, the bound allows {} s ({} of {} runs).",
        sea(cell),
        decimals(100.0 * found.width, 0),
        decimals(found.found_s, 2),
        decimals(found.bound_s, 2),
        found.reached,
        found.possible
    ))
}

fn table(cells: &[Cell]) -> Table {
    let rows = cells.iter().zip(1..).flat_map(|(cell, number)| {
        cell.estimators.iter().flat_map(move |accuracy| {
            accuracy.quantities.iter().map(move |quantity| {
                vec![
                    format!("{number}").into(),
                    sea(cell).into(),
                    accuracy.estimator.name().to_owned().into(),
                    format!("{}, {}", quantity.name, quantity.unit).into(),
                    decimals(quantity.truth, 4).into(),
                    significant(quantity.bias, 2).into(),
                    significant(quantity.standard_deviation, 2).into(),
                    decimals_or_missing(quantity.efficiency, 2).into(),
                    decimals_or_missing(quantity.coverage, 3).into(),
                ]
            })
        })
    });
    Table {
        title: "Every sea and estimator",
        note: "Efficiency: Cramér-Rao bound over mean square error. Coverage: share of the 95 % intervals that hold the truth.".to_owned(),
        columns: under("Sea | Compass noise, disturbance | Estimator | Quantity | Truth | Bias | Deviation | Efficiency | \
            Coverage"),
        rows: rows.collect(),
    }
}

/// Efficiency and coverage over the disturbances; `None` where the estimator has neither.
fn figure(cells: &[Cell], estimator: usize) -> Option<Figure> {
    const INKS: [&str; 5] = ["s1", "s2", "s3", "s4", "s5"];
    let name = cells.first()?.estimators.get(estimator)?.estimator.name();
    let layers = |value: fn(&QuantityAccuracy) -> Option<f64>| -> Vec<Layer> {
        let quantities = &cells[0].estimators[estimator].quantities;
        let of = |quantity: &QuantityAccuracy| -> Vec<[f64; 2]> {
            let numbered = cells.iter().zip(1..);
            numbered
                .filter_map(|(cell, number)| {
                    let all = &cell.estimators.get(estimator)?.quantities;
                    let same = all.iter().find(|other| other.name == quantity.name)?;
                    Some([f64::from(number), value(same)?])
                })
                .collect()
        };
        let dots = quantities.iter().zip(INKS);
        dots.map(|(quantity, ink)| Layer::dots(ink, quantity.name, of(quantity)))
            .filter(|layer| !layer.is_empty())
            .collect()
    };
    let panel = |label: &str, goal: f64, mut layers: Vec<Layer>| {
        layers.push(Layer::level("zero", "", goal));
        Panel::linear(label, 120.0, layers)
    };
    let panels: Vec<Panel> =
        [("Efficiency", 1.0, layers(|q| q.efficiency)), ("Coverage", 0.95, layers(|q| q.coverage))]
            .into_iter()
            .filter(|(_, _, layers)| !layers.is_empty())
            .map(|(label, goal, layers)| panel(label, goal, layers))
            .collect();
    let chart = Chart {
        alt: format!("Efficiency and coverage of {name} in each sea."),
        x_label: "Sea, as numbered in the table",
        x_range: [0.5, cells.len() as f64 + 0.5],
        panels,
        ..Chart::default()
    };
    (!chart.panels.is_empty())
        .then(|| Figure::new(&chart, format!("How near {name} comes to the bound, and how often its 95 % intervals hold the truth.")))
}
