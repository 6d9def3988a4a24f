//! `seatrial report`: the self-contained HTML page of a trial.

use std::path::{Path, PathBuf};

use seatrial::logbook::{CampaignEntry, Logbook};
use seatrial::report::{self, Fact};
use serde::Serialize;

use crate::logbook::chosen_campaign;
use crate::output::{Exit, Failure, Output};

/// One HTML page that shows a trial: verdict, models, turning limits, gains, every run.
#[derive(clap::Args)]
#[command(after_help = "Example:
  seatrial trial --yes --logbook seatrial.db
  seatrial report --logbook seatrial.db --out report.html")]
pub struct Args {
    /// The logbook that holds the trial.
    #[arg(long, default_value = "seatrial.db", value_name = "FILE")]
    logbook: PathBuf,
    /// Number of the campaign; the last one where it is left out.
    #[arg(long, value_name = "NUMBER")]
    campaign: Option<i64>,
    /// The page.
    #[arg(long, default_value = "report.html", value_name = "FILE")]
    out: PathBuf,
}

/// Runs the verb.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let logbook = Logbook::open_read_only(&args.logbook)?;
    let entry = chosen_campaign(&logbook, args.campaign)?;
    let campaign = logbook.campaign(entry.id)?;
    let page = report::render(&campaign, &provenance(&logbook, &entry));
    save(&args.out, &page)?;
    say(&args.out, &page, output)?;
    Ok(Exit::Done)
}

/// Where a campaign lies and what it was told to do.
fn provenance(logbook: &Logbook, entry: &CampaignEntry) -> Vec<Fact> {
    vec![
        (
            "Logbook",
            format!("{}, campaign {}", logbook.path().display(), entry.id.0),
        ),
        ("Started (UTC)", entry.started.clone()),
        ("SHA-256 of the campaign", entry.head_sha256.clone()),
        ("SHA-256 of the plan", entry.plan_sha256.clone()),
        ("Plan", entry.plan.clone()),
    ]
}

/// Writes a page.
pub fn save(path: &Path, page: &str) -> Result<(), Failure> {
    std::fs::write(path, page)
        .map_err(|error| Failure::not_saved(format!("{}: the report: {error}", path.display())))
}

#[derive(Serialize)]
struct Saved<'a> {
    schema: &'static str,
    path: &'a Path,
    bytes: usize,
}

fn say(path: &Path, page: &str, output: &Output) -> Result<(), Failure> {
    let saved = Saved {
        schema: "seatrial.report.v1",
        path,
        bytes: page.len(),
    };
    output.print(&saved, || {
        format!(
            "{} ({} kB): open it in a browser",
            path.display(),
            page.len() / 1000
        )
    })
}
