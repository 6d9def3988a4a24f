//! The page of the standard manoeuvres.

use super::chart::{Chart, Layer, Panel};
use super::headline::{Headline, Tone};
use super::number::{decimals, percent};
use super::tables::{Table, under};
use super::{Figure, Page};
use seatrial::sea_trials::field::{StandardManoeuvres, ZigZag};

/// The page of the standard manoeuvres of a vehicle.
pub fn render(vehicle: &str, manoeuvres: &[StandardManoeuvres]) -> String {
    let page = Page {
        title: format!("Standard manoeuvres of {vehicle}"),
        subtitle: "Zig-zag and spiral".to_owned(),
        headline: Headline {
            tone: Tone::Good,
            verdict: format!("{} thrusts", manoeuvres.len()),
            findings: Vec::new(),
            command: String::new(),
            next: Vec::new(),
        },
        summary: Some(zig_zag_table(manoeuvres)),
        over_speed: std::iter::once(spiral(manoeuvres))
            .chain(manoeuvres.iter().map(zig_zag))
            .collect(),
        every_run: Some(spiral_table(manoeuvres)),
        ..Page::default()
    };
    page.text()
}

fn zig_zag_table(manoeuvres: &[StandardManoeuvres]) -> Table {
    let row = |at: &StandardManoeuvres, zig_zag: &ZigZag| {
        let degrees = |k: usize| {
            let overshoot = zig_zag.overshoots_rad.get(k);
            decimals(overshoot.copied().unwrap_or(f64::NAN).to_degrees(), 2)
        };
        let angle = decimals(zig_zag.rudder_rad.to_degrees(), 0);
        vec![
            percent(at.thrust).into(),
            decimals(at.straight_speed_m_s, 2).into(),
            format!("{angle}/{angle}").into(),
            decimals(zig_zag.initial_turning_time_s, 2).into(),
            degrees(0).into(),
            degrees(1).into(),
            decimals(zig_zag.period_s, 2).into(),
        ]
    };
    Table {
        title: "Zig-zag",
        note: "Overshoot: heading past the change at which the rudder is laid over.".to_owned(),
        columns: under(
            "Thrust | Speed [m/s] | Zig-zag [°] | First turn [s] | First overshoot [°] | Second [°] | Period [s]",
        ),
        rows: manoeuvres
            .iter()
            .flat_map(|at| at.zig_zags.iter().map(move |zig_zag| row(at, zig_zag)))
            .collect(),
    }
}

fn spiral_table(manoeuvres: &[StandardManoeuvres]) -> Table {
    let rows = manoeuvres.iter().flat_map(|at| {
        at.spiral.iter().map(move |point| {
            vec![
                percent(at.thrust).into(),
                decimals(point.rudder_rad.to_degrees(), 1).into(),
                decimals(point.yaw_rate_rad_s.to_degrees(), 2).into(),
                decimals(point.surge_speed_m_s, 3).into(),
            ]
        })
    });
    Table {
        title: "Spiral",
        note: "From starboard to port and back.".to_owned(),
        columns: under("Thrust | Rudder [°] | Yaw rate [°/s] | Speed [m/s]"),
        rows: rows.collect(),
    }
}

fn spiral(manoeuvres: &[StandardManoeuvres]) -> Figure {
    const INKS: [&str; 5] = ["s1", "s2", "s3", "s4", "s5"];
    let layers = manoeuvres.iter().zip(INKS.iter().cycle()).map(|(at, ink)| {
        let points = at.spiral.iter();
        let points = points.map(|p| [p.rudder_rad.to_degrees(), p.yaw_rate_rad_s.to_degrees()]);
        Layer::line(ink, &percent(at.thrust), points.collect())
    });
    let widest = manoeuvres
        .iter()
        .flat_map(|at| &at.spiral)
        .map(|p| p.rudder_rad.abs().to_degrees())
        .fold(0.0, f64::max);
    let chart = Chart {
        alt: "Steady yaw rate over rudder angle, from starboard to port and back.".to_owned(),
        x_label: "Rudder, °",
        x_range: [-1.05 * widest, 1.05 * widest],
        spans: Vec::new(),
        marks: Vec::new(),
        panels: vec![Panel::linear("Yaw rate, °/s", 190.0, layers.collect())],
    };
    Figure::new(
        &chart,
        "Dieudonné's spiral, from starboard to port and back: one curve where the vehicle is stable on its course, a loop where not."
            .to_owned(),
    )
}

fn zig_zag(at: &StandardManoeuvres) -> Figure {
    let longest = at
        .zig_zags
        .iter()
        .filter_map(|zig_zag| Some(zig_zag.series.last()?[0]))
        .fold(0.0, f64::max);
    let panels = at.zig_zags.iter().map(|zig_zag| {
        let line = |index: usize| {
            let samples = zig_zag.series.iter();
            samples.map(|s| [s[0], s[index].to_degrees()]).collect()
        };
        let angle = decimals(zig_zag.rudder_rad.to_degrees(), 0);
        Panel::linear(
            format!("{angle}/{angle}, °"),
            90.0,
            vec![
                Layer::line("zero", "rudder", line(2)),
                Layer::line("a", "heading", line(1)),
            ],
        )
    });
    let chart = Chart {
        alt: format!("Zig-zags at {} thrust.", percent(at.thrust)),
        x_label: "Time since the rudder moved, s",
        x_range: [0.0, longest],
        spans: Vec::new(),
        marks: Vec::new(),
        panels: panels.collect(),
    };
    Figure::new(&chart, format!("Zig-zags at {}.", percent(at.thrust)))
}
