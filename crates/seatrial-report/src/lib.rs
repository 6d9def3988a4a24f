#![doc = include_str!("../README.md")]

mod axis;
mod chart;
mod control_figures;
mod curves;
mod field;
mod fit;
mod headline;
mod log;
mod log_model;
mod number;
mod pitch;
mod plan_view;
mod recorded;
mod run_figures;
mod segmentation;
mod source;
mod speed_figures;
mod standard;
mod study;
mod tables;
mod turning_figure;

use askama::Template;

use chart::Chart;
pub use field::render as render_field;
pub use fit::{Overlaid, overlay};
use headline::{Headline, Tone};
pub use log::{Log, render as render_log};
pub use log_model::LogModel;
use number::{decimals, percent, sentence};
pub use pitch::render as render_pitch;
use seatrial::campaign::{Campaign, Run};
use seatrial::identification::{Reason, Verdict};
use seatrial::plain_text::plain;
pub use segmentation::{Found, render as render_found};
use source::Source;
pub use standard::render as render_standard;
pub use study::render as render_study;
use tables::Table;

/// A name and a value for the list of what was recorded.
pub type Fact = (&'static str, String);

/// When a campaign was started, among the facts of its provenance.
pub const STARTED: &str = "Started (UTC)";

/// The page of a whole trial. `provenance` is what else is known of it: its plan, its place in a
/// logbook, when it was [started](STARTED). `command` is what to type next.
pub fn render(campaign: &Campaign, provenance: &[Fact], command: &str) -> String {
    let campaign = &*campaign.with_acting_rudder();
    let speeds = speed_figures::accepted(campaign);
    let method_tables = if speeds.is_empty() {
        Vec::new()
    } else {
        vec![tables::online(&speeds), tables::offline(&speeds)]
    };
    let page = Page {
        title: format!("Sea trial of {}", campaign.vehicle),
        subtitle: subtitle(campaign, provenance),
        headline: headline::of_campaign(campaign, &speeds, command),
        summary: (!campaign.runs.is_empty()).then(|| tables::summary(campaign, &speeds)),
        runs: campaign.runs.iter().map(run_section).collect(),
        together: speed_figures::together(&speeds).into_iter().collect(),
        methods: method_tables,
        over_speed: [
            speed_figures::authority(&speeds),
            turning_figure::turning(&speeds, campaign.rudder_limit_rad),
        ]
        .into_iter()
        .flatten()
        .collect(),
        controller: (!speeds.is_empty()).then(|| tables::controller(&speeds)),
        control: [
            control_figures::gains(&speeds),
            control_figures::heading_steps(&speeds, campaign.rudder_limit_rad),
        ]
        .into_iter()
        .flatten()
        .collect(),
        every_run: (!campaign.runs.is_empty()).then(|| tables::runs(campaign)),
        recorded: [recorded::of_campaign(campaign), provenance.to_vec()].concat(),
    };
    page.text()
}

/// Configuration and date, as far as they are known.
fn subtitle(campaign: &Campaign, provenance: &[Fact]) -> String {
    let configuration = format!("Configuration {}", campaign.configuration);
    let started = provenance.iter().find(|(name, _)| *name == STARTED);
    match started {
        Some((_, date)) => format!("{configuration}, started {}", minute(date)),
        None => configuration,
    }
}

/// A time of the logbook, `2026-11-24T00:39:11.123Z`, to the minute.
fn minute(time: &str) -> String {
    match (time.get(..10), time.get(11..16)) {
        (Some(day), Some(minute)) => format!("{day} {minute} UTC"),
        _ => time.to_owned(),
    }
}

/// A chart with its caption.
struct Figure {
    svg: String,
    caption: String,
}

impl Figure {
    fn new(chart: &Chart, caption: String) -> Self {
        Self {
            svg: chart.svg(),
            caption,
        }
    }
}

/// One run with its figures.
struct RunSection {
    anchor: String,
    title: String,
    /// The tone and the outcome.
    verdict: Option<(Tone, &'static str)>,
    reasons: Vec<String>,
    facts: Vec<Fact>,
    figures: Vec<Figure>,
}

fn run_section(run: &Run) -> RunSection {
    let speed = run.surge_speed_m_s.map_or(String::new(), |speed| {
        format!(", {} m/s", decimals(speed, 2))
    });
    let attempt = if run.attempt > 1 {
        format!(", attempt {}", run.attempt)
    } else {
        String::new()
    };
    let title = format!(
        "Run {}: {} thrust{speed}{attempt}",
        run.number,
        percent(run.thrust)
    );
    let source = Source {
        record: &run.record,
        validation: &run.record,
        stages: &run.stages,
        identification: run.identification.as_ref(),
        name: &title,
        origin_s: {
            let mut times = run.record.samples.iter().map(|s| s.time_s);
            times.find(|time| time.is_finite()).unwrap_or(0.0)
        },
        is_trial: true,
    };
    let figures = run_figures_of(&source);
    RunSection {
        anchor: format!("run-{}", run.number),
        verdict: Some((run.verdict.outcome().into(), run.verdict.outcome().name())),
        reasons: reasons(&run.verdict),
        facts: run
            .identification
            .as_ref()
            .map_or(Vec::new(), recorded::method),
        figures,
        title,
    }
}

/// Each reason with what was measured.
fn reasons(verdict: &Verdict) -> Vec<String> {
    let told = |reason: &Reason| match reason.detail.is_empty() {
        true => sentence(&reason.text),
        false => format!("{} {}", sentence(&reason.text), sentence(&reason.detail)),
    };
    verdict.reasons.iter().map(told).collect()
}

fn run_figures_of(source: &Source) -> Vec<Figure> {
    let figures = [
        run_figures::manoeuvre(source),
        run_figures::estimates(source),
        fit::figure(source),
        run_figures::track(source),
    ];
    figures.into_iter().flatten().collect()
}

/// The page. Parts that are empty are left out.
#[derive(Template)]
#[template(path = "page.html")]
struct Page {
    title: String,
    subtitle: String,
    headline: Headline,
    summary: Option<Table>,
    runs: Vec<RunSection>,
    together: Vec<Figure>,
    methods: Vec<Table>,
    over_speed: Vec<Figure>,
    controller: Option<Table>,
    control: Vec<Figure>,
    every_run: Option<Table>,
    recorded: Vec<Fact>,
}

impl Page {
    const STYLE: &'static str = concat!(include_str!("tokens.css"), include_str!("style.css"));
    const SCRIPT: &'static str = include_str!("theme.js");

    fn text(&self) -> String {
        let page = self.render().expect("writing into a string cannot fail");
        plain(&page).into_owned()
    }
}
