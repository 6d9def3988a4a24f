//! `seatrial replay`: a recorded trial, once more, bit for bit.

use std::path::PathBuf;

use seatrial_app::TrialPlan;
use seatrial_app::trials::campaign_models::{Purpose, chosen_campaign};
use seatrial_app::trials::replay::Replay;
use seatrial_logbook::{CampaignEntry, Logbook};
use serde::Serialize;

use crate::damage;
use crate::output::{Exit, Failure, Output, say};
use crate::screen::{width, wrapped};

/// Takes a recorded trial through the same trial again and proves that every action, every
/// estimate and every result is the same, bit for bit. Exit 0: identical; 4: not.
#[derive(clap::Args)]
#[command(after_help = "Example:
  seatrial trial --logbook seatrial.db
  seatrial replay seatrial.db")]
pub struct Args {
    /// The logbook that holds the recording.
    #[arg(value_name = "REC")]
    logbook: PathBuf,
    /// Number of the campaign, or name of a configuration; without, the last that finished with an accepted model, else the
    /// last.
    #[arg(long, value_name = "CAMPAIGN")]
    campaign: Option<String>,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    campaign: i64,
    recorded_by: &'a str,
    replayed_by: &'static str,
    identical: bool,
    #[serde(flatten)]
    replay: Replay,
}

/// Runs the verb.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let logbook = Logbook::open_read_only(&args.logbook)?;
    let chosen = chosen_campaign(&logbook, args.campaign.as_deref(), Purpose::Record)?;
    chosen.passed_over.iter().for_each(say);
    damage::warn_of_missing(&logbook);
    let entry = damage::warn(&logbook, chosen.entry.id)?;
    let recording = logbook.recording(entry.id)?;
    if recording.steps.is_empty() {
        return Err(refusal(&logbook, &entry, "it holds no sample to replay"));
    }
    let replay = TrialPlan::parse(&entry.plan)
        .map_err(|error| error.to_string())
        .and_then(|plan| Replay::of(plan, &recording).map_err(|error| error.to_string()))
        .map_err(|error| {
            refusal(&logbook, &entry, &format!("its plan is not valid here: {error}"))
        })?;
    let document = Document {
        schema: "seatrial.replay.v1",
        campaign: entry.id.0,
        recorded_by: &entry.software_version,
        replayed_by: env!("CARGO_PKG_VERSION"),
        identical: replay.first_difference.is_none(),
        replay,
    };
    output.print(&document, || wrapped(&text(&document), width()))?;
    Ok(Exit::done_if(document.identical))
}

fn refusal(logbook: &Logbook, entry: &CampaignEntry, found: &str) -> Failure {
    let (path, campaign) = (logbook.path().display(), entry.id.0);
    Failure::input(format!("{path}: campaign {campaign}: {found}"))
}

fn text(document: &Document) -> String {
    let replay = &document.replay;
    let counted = format!(
        "campaign {}: {} actions, {} live estimates and {} results",
        document.campaign, replay.samples, replay.estimates, replay.results
    );
    let stopped = |run: &u32| {
        format!(
            "\nrun {run} was stopped after the last sample kept, because the process was killed: its reason is not replayed"
        )
    };
    let without_end: String = replay.runs_without_their_end.iter().map(stopped).collect();
    let Some(difference) = &replay.first_difference else {
        return format!("SAME\n{counted}\nreplayed, every one the same bit for bit{without_end}");
    };
    let run = difference.run.map_or(String::new(), |run| format!(" of run {run}"));
    format!(
        "DIFFERENT\n{counted}\nthe same, then a difference at sample {}{run}\n{}\nrecorded by seatrial {}, replayed by {}",
        difference.sample, difference.found, document.recorded_by, document.replayed_by
    )
}
