//! The report: one HTML file without any outside reference, for the person who ran the trial.
//!
//! [`render`] draws a whole trial, [`render_log`] one identification on a log, [`render_field`] the field
//! experiments after a trial, [`render_pitch`] a pitch trial. The verdict and the next
//! action come first, then one table, then the figures; every run is drawn, also where the trial
//! was stopped or nothing was accepted. The same input gives the same bytes.

mod axis;
mod chart;
mod field;
mod fit;
mod headline;
mod number;
mod pitch;
mod recorded;
mod run_figures;
mod segmentation;
mod speed_figures;
mod standard;
mod study;
mod tables;

use askama::Template;

use chart::Chart;
pub use field::render as render_field;
pub use fit::{Overlaid, overlay};
use headline::{Headline, Tone};
use number::{decimals, percent, spoken};
pub use pitch::render as render_pitch;
use run_figures::Source;
use seatrial::campaign::{Campaign, Run, Stage, StageSpan};
use seatrial::gain_allowance::GainAllowance;
use seatrial::identification::{Identification, Reason};
use seatrial::record::Record;
pub use segmentation::{Found, render as render_found};
pub use standard::render as render_standard;
pub use study::render as render_study;
use tables::Table;

/// A name and a value for the list of what was recorded.
pub type Fact = (&'static str, String);

/// The page of a whole trial. `provenance` is what else is known of it: its plan, its place in a
/// logbook.
pub fn render(campaign: &Campaign, provenance: &[Fact]) -> String {
    let campaign = &*campaign.with_acting_rudder();
    let speeds = speed_figures::accepted(campaign);
    let method_tables = if speeds.is_empty() {
        Vec::new()
    } else {
        vec![tables::online(&speeds), tables::offline(&speeds)]
    };
    let page = Page {
        title: format!("Sea trial of {}", campaign.vehicle),
        subtitle: format!("Configuration {}", campaign.configuration),
        headline: headline::of_campaign(campaign, &speeds),
        summary: (!campaign.runs.is_empty()).then(|| tables::summary(campaign, &speeds)),
        runs: campaign.runs.iter().map(run_section).collect(),
        together: speed_figures::together(&speeds).into_iter().collect(),
        methods: method_tables,
        over_speed: [
            speed_figures::authority(&speeds),
            speed_figures::turning(&speeds, campaign.rudder_limit_rad),
        ]
        .into_iter()
        .flatten()
        .collect(),
        controller: (!speeds.is_empty()).then(|| tables::controller(&speeds)),
        control: [
            speed_figures::gains(&speeds),
            speed_figures::heading_steps(&speeds, campaign.rudder_limit_rad),
        ]
        .into_iter()
        .flatten()
        .collect(),
        every_run: (!campaign.runs.is_empty()).then(|| tables::runs(campaign)),
        recorded: [recorded::of_campaign(campaign), provenance.to_vec()].concat(),
    };
    page.text()
}

/// A record with its identification, and what to call it.
#[derive(Clone, Copy, Debug)]
pub struct Log<'a> {
    /// Name of the log, as the reader knows it.
    pub name: &'a str,
    /// The record that the model was made from.
    pub record: &'a Record,
    /// The record of fresh data, where it is another one.
    pub fresh: Option<&'a Record>,
    /// The model, or why there is none.
    pub identification: Result<&'a Identification, &'a Reason>,
    /// What else is known about where it came from, name and value.
    pub provenance: &'a [Fact],
}

/// The page of one identification on a log. Without a model the record is drawn all the same.
pub fn render_log(log: &Log) -> String {
    let identification = log.identification.ok();
    let mut stages = Vec::new();
    stages.extend(identification.map(|i| StageSpan {
        stage: Stage::Train,
        window: i.training,
    }));
    let validation = identification.and_then(|i| i.validation);
    stages.extend(validation.map(|validation| StageSpan {
        stage: Stage::Validate,
        window: validation.window,
    }));
    let source = Source {
        record: log.record,
        fresh: log.fresh.unwrap_or(log.record),
        stages: &stages,
        identification,
        name: log.name,
        origin_s: 0.0,
        is_trial: false,
    };
    let gain = identification.and_then(|i| {
        GainAllowance::of(i)
            .design(&i.model(), speed_figures::DAMPING_RATIO)
            .ok()
            .filter(|_| i.verdict.accepted)
    });
    let mut recorded = vec![(
        "Software",
        format!("seatrial {}", env!("CARGO_PKG_VERSION")),
    )];
    recorded.extend(log.provenance.iter().cloned());
    let records: Vec<&Record> = [Some(log.record), log.fresh]
        .into_iter()
        .flatten()
        .collect();
    recorded.push(("SHA-256 of the samples", recorded::fingerprint(&records)));
    let page = Page {
        title: format!("Steering of {}", log.name),
        subtitle: String::new(),
        headline: match log.identification {
            Ok(identification) => headline::of_identification(identification),
            Err(reason) => headline::of_refusal(reason),
        },
        summary: identification
            .map(|i| tables::log_summary(i, gain.map(|gain| gain.proportional_gain))),
        runs: vec![RunSection {
            anchor: "run-1".to_owned(),
            title: "The record".to_owned(),
            verdict: None,
            reasons: Vec::new(),
            facts: identification.map_or(Vec::new(), recorded::method),
            figures: run_figures(&source),
        }],
        together: Vec::new(),
        methods: Vec::new(),
        over_speed: Vec::new(),
        controller: None,
        control: Vec::new(),
        every_run: None,
        recorded,
    };
    page.text()
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
    verdict: Option<Tone>,
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
        fresh: &run.record,
        stages: &run.stages,
        identification: run.identification.as_ref(),
        name: &title,
        origin_s: {
            let mut times = run.record.samples.iter().map(|s| s.time_s);
            times.find(|time| time.is_finite()).unwrap_or(0.0)
        },
        is_trial: true,
    };
    let figures = run_figures(&source);
    RunSection {
        anchor: format!("run-{}", run.number),
        verdict: Some(if run.verdict.accepted {
            Tone::Good
        } else {
            Tone::Bad
        }),
        reasons: run
            .verdict
            .reasons
            .iter()
            .map(|r| spoken(&r.text))
            .collect(),
        facts: run
            .identification
            .as_ref()
            .map_or(Vec::new(), recorded::method),
        figures,
        title,
    }
}

fn run_figures(source: &Source) -> Vec<Figure> {
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
        self.render().expect("writing into a string cannot fail")
    }
}
