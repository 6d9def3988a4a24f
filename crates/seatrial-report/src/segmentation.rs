//! The page of what was found in a log: the record with its manoeuvres shaded, and a table of them.

use seatrial_core::Sample;

use super::axis::extent;
use super::chart::{Chart, Layer, Panel, Span};
use super::curves::{degrees, present, series, unwrapped};
use super::headline::{Headline, Tone};
use super::number::{decimals, decimals_or_missing};
use super::tables::{Table, under};
use super::{Fact, Figure, Page, RunSection};
use seatrial::Record;
use seatrial::identify::Proposal;
use seatrial::log::segmentation::{Kind, Segment};

/// A log and what was found in it.
#[derive(Clone, Copy, Debug)]
pub struct LogManoeuvres<'a> {
    /// Name of the log, as the reader knows it.
    pub name: &'a str,
    /// The record.
    pub record: &'a Record,
    /// What was found, in order of time.
    pub segments: &'a [Segment],
    /// Which windows an identification takes.
    pub proposals: &'a [Proposal],
    /// How many of the rudder's unit for people are 1, and its name.
    pub rudder_unit: (f64, &'static str),
    /// What else is known about where it came from, name and value.
    pub provenance: &'a [Fact],
}

/// The page.
pub fn render(found: &LogManoeuvres) -> String {
    let manoeuvres = found.segments.iter().filter(|s| s.kind != Kind::Steady);
    let count = manoeuvres.count();
    let page = Page {
        title: format!("Manoeuvres in {}", found.name),
        headline: Headline {
            tone: if found.proposals.is_empty() { Tone::Partly } else { Tone::Good },
            verdict: format!("{count} manoeuvres, {} speeds to learn from.", found.proposals.len()),
            findings: found.proposals.iter().map(|p| p.because.clone()).collect(),
            command: String::new(),
            next: Vec::new(),
        },
        summary: (!found.segments.is_empty()).then(|| table(found)),
        runs: vec![RunSection {
            anchor: "run-1".to_owned(),
            title: "The record".to_owned(),
            verdict: None,
            reasons: Vec::new(),
            facts: Vec::new(),
            figures: figure(found, None)
                .into_iter()
                .chain(found.proposals.iter().filter_map(|p| figure(found, Some(p))))
                .collect(),
        }],
        recorded: found.provenance.to_vec(),
        ..Page::default()
    };
    page.text()
}

fn table(found: &LogManoeuvres) -> Table {
    let (scale, unit) = found.rudder_unit;
    let row = |segment: &Segment| {
        vec![
            segment.kind.name().to_owned().into(),
            decimals(segment.window.from_s, 1).into(),
            decimals(segment.window.to_s, 1).into(),
            decimals(scale * segment.amplitude_rad, 1).into(),
            decimals_or_missing(segment.thrust.map(|thrust| 100.0 * thrust), 0).into(),
            decimals_or_missing(segment.surge_speed_m_s, 2).into(),
            decimals(segment.excitation_rad.to_degrees(), 1).into(),
            decimals(100.0 * segment.completeness, 0).into(),
        ]
    };
    Table {
        title: "What was found",
        note: "Turned: standard deviation of the heading about its own straight line. Samples: found over expected at the \
               usual interval."
            .to_owned(),
        columns: under(&format!(" | From [s] | To [s] | Rudder [{unit}] | Thrust [%] | Speed [m/s] | Turned [°] | Samples [%]")),
        rows: found.segments.iter().map(row).collect(),
    }
}

/// The whole record with its manoeuvres shaded, or, of a proposal, its windows and a quarter around them. `None` of
/// fewer than two samples.
fn figure(found: &LogManoeuvres, proposal: Option<&Proposal>) -> Option<Figure> {
    let all = &found.record.samples;
    let (first_s, last_s) = (all.first()?.time_s, all.last()?.time_s);
    let [from_s, to_s] = proposal.and_then(used_s).map_or([first_s, last_s], |[from_s, to_s]| {
        let margin_s = 0.25 * (to_s - from_s);
        [first_s.max(from_s - margin_s), last_s.min(to_s + margin_s)]
    });
    if to_s <= from_s {
        return None;
    }
    let from = all.partition_point(|s| s.time_s < from_s);
    let to = all.partition_point(|s| s.time_s <= to_s);
    let chart = Chart {
        alt: format!(
            "{}: heading, rudder and speed over {:.0} seconds, manoeuvres shaded.",
            found.name,
            to_s - from_s
        ),
        x_label: "Time in the log, s",
        x_range: [from_s, to_s],
        spans: match proposal {
            None => found.segments.iter().map(shaded).collect(),
            Some(proposal) => windows_shaded(proposal),
        },
        marks: Vec::new(),
        panels: measurements(&all[from..to.max(from)], found.rudder_unit),
    };
    let caption = match proposal {
        None => "The whole record. Manoeuvres to both sides are shaded in one colour, steps and turning circles in another, steady runs in grey.".to_owned(),
        Some(proposal) => format!("Windows: {}.", proposal.because),
    };
    Some(Figure::new(&chart, caption))
}

/// From the first to the last time of a proposal's windows, s.
fn used_s(proposal: &Proposal) -> Option<[f64; 2]> {
    let windows = || proposal.training.iter().chain(proposal.validation.iter());
    windows().next()?;
    let [from_s, _] = extent(windows().map(|w| w.from_s));
    let [_, to_s] = extent(windows().map(|w| w.to_s));
    Some([from_s, to_s])
}

/// Heading, rudder and, where they were measured, speed and thrust.
fn measurements(samples: &[Sample<f64>], rudder_unit: (f64, &str)) -> Vec<Panel> {
    let (scale, unit) = rudder_unit;
    let heading = series(&unwrapped(samples), 0.0, |s| degrees(Some(s.heading_rad)));
    let rudder = series(samples, 0.0, |s| Some(scale * s.rudder_rad));
    let mut panels = vec![
        Panel::linear("Heading, °", 92.0, vec![Layer::line("a", "", heading)]),
        Panel::linear(format!("Rudder, {unit}"), 66.0, vec![Layer::line("b", "", rudder)]),
    ];
    let speed = series(samples, 0.0, |s| s.surge_speed_m_s);
    let thrust = series(samples, 0.0, |s| s.thrust.map(|t| 100.0 * t));
    for (label, least_span, points) in [("Speed, m/s", 0.4, speed), ("Thrust, %", 5.0, thrust)] {
        if present(&points) {
            let layers = vec![Layer::line("a", "", points)];
            panels.push(Panel::linear(label, 44.0, layers).spanning_at_least(least_span));
        }
    }
    panels
}

/// The windows for training and for validation, shaded.
fn windows_shaded(proposal: &Proposal) -> Vec<Span> {
    let span = |shade: &'static str, label: &str, window: &seatrial::Window| Span {
        from: window.from_s,
        to: window.to_s,
        shade,
        label: label.to_owned(),
    };
    let training = proposal.training.iter();
    let validation = proposal.validation.iter();
    training
        .map(|window| span("span-train", "train", window))
        .chain(validation.map(|window| span("span-validate", "validate", window)))
        .collect()
}

fn shaded(segment: &Segment) -> Span {
    let (shade, label) = match segment.kind {
        Kind::Steady => ("span-settle", String::new()),
        kind if kind.uses_both_sides() => ("span-train", kind.name().to_owned()),
        kind => ("span-validate", kind.name().to_owned()),
    };
    Span { from: segment.window.from_s, to: segment.window.to_s, shade, label }
}
