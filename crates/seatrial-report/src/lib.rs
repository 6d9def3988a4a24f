#![doc = include_str!("../README.md")]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod axis;
mod chart;
mod control_figures;
mod curves;
mod field;
mod fit;
mod headline;
mod layer;
mod log;
mod log_model;
mod number;
mod plan_view;
mod recorded;
mod run_figures;
mod segmentation;
mod ship_manoeuvres;
mod source;
mod speed_figures;
mod study;
mod tables;
mod turning_figure;

use askama::Template;

use chart::Chart;
pub use field::render as render_field;
pub use fit::{Overlaid, overlay};
use headline::{Headline, Tone};
pub use log::{Log, render as render_log};
pub use log_model::{LogModel, promises};
use number::{decimals, percent, sentence};
use seatrial::campaign::{Campaign, Run};
use seatrial::identification::{Reason, Verdict};
use seatrial::words::plain;
use seatrial_core::{Axis, Plan};
pub use segmentation::{LogManoeuvres, render as render_found};
pub use ship_manoeuvres::render as render_ship_manoeuvres;
use source::Source;
pub use study::render as render_study;
use tables::Table;

/// A name and a value for the list of what was recorded.
pub type Fact = (&'static str, String);

/// What is known of a trial beside its campaign. What is not known is left out of the page.
#[derive(Clone, Copy, Debug, Default)]
pub struct About<'a> {
    /// When it was started, UTC, as the logbook has it.
    pub started: Option<&'a str>,
    /// Where it was.
    pub place: Option<&'a str>,
    /// The operator of the trial.
    pub operator: Option<&'a str>,
    /// What the vehicle's autopilot runs.
    pub firmware: Option<&'a str>,
    /// Notes on the configuration.
    pub notes: Option<&'a str>,
    /// What it was told to do.
    pub plan: Option<&'a Plan<f64>>,
    /// The plan as text, to run it again.
    pub plan_text: &'a str,
    /// Where it is kept, and what proves that it is unchanged.
    pub provenance: &'a [Fact],
}

/// The page of a whole trial. `command` is what to type next.
pub fn render(campaign: &Campaign, about: &About, command: &str) -> String {
    let campaign = &*campaign.with_acting_rudder();
    let speeds = speed_figures::accepted(campaign);
    // Gains and turning limits are made of yaw.
    let steered = match campaign.axis {
        Axis::Yaw => speeds.as_slice(),
        Axis::Pitch => &[],
    };
    let whole = campaign.verdict();
    // Models that are not to be used give neither gains nor limits; their methods are shown side by side all the same.
    let usable = match whole.accepted {
        true => steered,
        false => &[],
    };
    let mut method_tables = Vec::new();
    if !steered.is_empty() {
        method_tables.extend([tables::online(steered), tables::offline(steered)]);
    }
    if !usable.is_empty() {
        method_tables.push(tables::gains_of_paper(usable));
    }
    let page = Page {
        title: match campaign.axis {
            Axis::Yaw => format!("Sea trial of {}", campaign.vehicle),
            Axis::Pitch => format!("Sea trial of {}, pitch", campaign.vehicle),
        },
        about: circumstances(campaign, about),
        headline: headline::of_campaign(campaign, &speeds, command),
        summary: (!campaign.runs.is_empty()).then(|| {
            let speeds = if whole.accepted { speeds.as_slice() } else { &[] };
            tables::summary(campaign, &whole, speeds)
        }),
        is_folded: campaign.runs.len() > 1,
        runs: (campaign.runs.iter()).map(|run| run_section(run, campaign.axis, &whole)).collect(),
        together: speed_figures::together(steered).into_iter().collect(),
        methods: method_tables,
        over_speed: [
            speed_figures::authority(steered),
            turning_figure::turning(usable, campaign.rudder_limit_rad),
        ]
        .into_iter()
        .flatten()
        .collect(),
        control: [
            control_figures::gains(usable),
            control_figures::heading_steps(usable, campaign.rudder_limit_rad),
        ]
        .into_iter()
        .flatten()
        .collect(),
        every_run: (!campaign.runs.is_empty()).then(|| tables::runs(campaign, &whole)),
        plan: about.plan.map_or_else(Vec::new, recorded::plan),
        plan_text: about.plan_text.to_owned(),
        recorded: [recorded::of_campaign(campaign), about.provenance.to_vec()].concat(),
        ..Page::default()
    };
    page.text()
}

/// When, where, on what and by whom, as far as it is known.
fn circumstances(campaign: &Campaign, about: &About) -> Vec<Fact> {
    let configuration = match about.notes.filter(|notes| !notes.is_empty()) {
        Some(notes) => format!("{} ({notes})", campaign.configuration),
        None => campaign.configuration.clone(),
    };
    let vehicle = match campaign.is_rehearsal() {
        true => format!("{}, a rehearsal on a simulator", campaign.vehicle),
        false => campaign.vehicle.clone(),
    };
    let known = [
        ("Date", about.started.map(minute)),
        ("Place", about.place.map(str::to_owned)),
        ("Vehicle", Some(vehicle)),
        ("Faults played", campaign.scenario.clone()),
        ("Firmware", about.firmware.map(str::to_owned)),
        ("Configuration", Some(configuration)),
        ("Operator", about.operator.map(str::to_owned)),
    ];
    let known = known.into_iter();
    known.filter_map(|(name, value)| Some((name, value?))).collect()
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
        Self { svg: chart.svg(), caption }
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

fn run_section(run: &Run, axis: Axis, whole: &Verdict) -> RunSection {
    let outcome = run.verdict_within(whole).outcome();
    let speed =
        run.surge_speed_m_s.map_or(String::new(), |speed| format!(", {} m/s", decimals(speed, 2)));
    let attempt =
        if run.attempt > 1 { format!(", attempt {}", run.attempt) } else { String::new() };
    let title = format!("Run {}: {} thrust{speed}{attempt}", run.number, percent(run.thrust));
    let source = Source {
        axis,
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
        verdict: Some((outcome.into(), outcome.name())),
        reasons: reasons_of_run(run, whole),
        facts: run.identification.as_ref().map_or(Vec::new(), recorded::method),
        figures,
        title,
    }
}

/// Each reason of a run with what was measured. Why the whole campaign is refused stands at the top of the page.
fn reasons_of_run(run: &Run, whole: &Verdict) -> Vec<String> {
    if whole.accepted || !run.verdict.accepted {
        return reasons(&run.reasons_within(whole));
    }
    let refused = format!(
        "By itself: {}. The campaign is not to be used, for the cause at the top of this page.",
        run.verdict.outcome().name()
    );
    let own: Vec<Reason> = run.verdict.causes().cloned().collect();
    std::iter::once(refused).chain(reasons(&own)).collect()
}

/// Each reason with what was measured, once.
fn reasons(reasons: &[Reason]) -> Vec<String> {
    let text = |reason: &Reason| match reason.detail.is_empty() {
        true => sentence(&reason.text),
        false if begin_alike(&reason.text, &reason.detail) => sentence(&reason.detail),
        false => format!("{} {}", sentence(&reason.text), sentence(&reason.detail)),
    };
    let mut texts: Vec<String> = Vec::new();
    for text in reasons.iter().map(text) {
        if !texts.contains(&text) {
            texts.push(text);
        }
    }
    texts
}

/// Do two sentences say the same, by their first words? The second, which was measured, says more.
fn begin_alike(cause: &str, measured: &str) -> bool {
    const SAME_WORDS: usize = 4;
    let begin = |text: &str| -> Vec<String> {
        let words = text.split_whitespace().take(SAME_WORDS);
        words.map(str::to_lowercase).collect()
    };
    begin(cause) == begin(measured)
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
#[derive(Default, Template)]
#[template(path = "page.html")]
struct Page {
    title: String,
    subtitle: String,
    about: Vec<Fact>,
    headline: Headline,
    summary: Option<Table>,
    /// Each run is folded: a reader opens those that matter.
    is_folded: bool,
    runs: Vec<RunSection>,
    together: Vec<Figure>,
    methods: Vec<Table>,
    over_speed: Vec<Figure>,
    /// What goes beside the figures of the controller.
    controller: Option<Table>,
    control: Vec<Figure>,
    every_run: Option<Table>,
    plan: Vec<Fact>,
    plan_text: String,
    recorded: Vec<Fact>,
}

impl Page {
    const STYLE: &'static str = concat!(include_str!("tokens.css"), include_str!("style.css"));
    const SCRIPT: &'static str = concat!(include_str!("theme.js"), include_str!("figures.js"));

    fn text(&self) -> String {
        let page = self.render().expect("writing into a string cannot fail");
        plain(&page).into_owned()
    }

    fn controller_title(&self) -> &str {
        self.controller.as_ref().map_or("Controller", |table| table.title)
    }

    /// The parts that stand on the page below the headline: where a click leads, and what it is called.
    fn contents(&self) -> Vec<(String, String)> {
        let part = |is_there: bool, anchor: &str, name: &str| {
            is_there.then(|| (format!("#{anchor}"), name.to_owned()))
        };
        let named = |table: &Option<Table>| table.as_ref().map_or("", |table| table.title);
        let runs = self.runs.iter().map(|run| {
            let sign = run.verdict.map_or("", |(tone, _)| tone.sign());
            (format!("#{}", run.anchor), format!("{} {sign}", run.title))
        });
        let has_plan = !self.plan.is_empty() || !self.plan_text.is_empty();
        let before = [
            part(self.summary.is_some(), "summary", named(&self.summary)),
            part(
                !self.control.is_empty() || self.controller.is_some(),
                "controller",
                self.controller_title(),
            ),
            part(!self.over_speed.is_empty(), "over-speed", "Turning"),
        ];
        let after = [
            part(!self.methods.is_empty(), "methods", "Methods side by side"),
            part(self.every_run.is_some(), "every-run", named(&self.every_run)),
            part(has_plan, "plan", "Plan"),
            part(true, "assumptions", "What the numbers assume"),
            part(true, "recorded", "What was recorded"),
        ];
        let before: Vec<(String, String)> = before.into_iter().flatten().collect();
        let after: Vec<(String, String)> = after.into_iter().flatten().collect();
        [before, runs.collect(), after].concat()
    }
}
