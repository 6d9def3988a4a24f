//! Every campaign of a logbook, a line each.

use seatrial_logbook::{CampaignEntry, Error, Logbook};
use serde::Serialize;

use super::{axis_text, state_name};
use crate::damage;
use crate::output::{Exit, Failure, Output};
use crate::screen::width;
use crate::table::Table;

#[derive(Serialize)]
struct List {
    schema: &'static str,
    campaigns: Vec<CampaignEntry>,
}

/// Prints the list.
pub(super) fn list(logbook: &Logbook, output: &Output) -> Result<Exit, Failure> {
    let list = List { schema: "seatrial.logbook_list.v1", campaigns: logbook.campaigns()? };
    output.print(&list, || text(logbook, &list.campaigns, width()))?;
    Ok(Exit::Done)
}

fn text(logbook: &Logbook, campaigns: &[CampaignEntry], width: usize) -> String {
    if campaigns.is_empty() {
        return "no campaign yet".into();
    }
    let mut table = Table::under(
        "campaign | started [UTC] | verdict | accepted [runs] | state | vehicle | configuration",
    );
    let mut damaged: Vec<String> = Vec::new();
    for entry in campaigns {
        damaged.extend(entry.damage.as_ref().map(damage::text));
        let [verdict, accepted] =
            verdict_cells(logbook, entry).unwrap_or(["-", "-"].map(str::to_owned));
        table.row(vec![
            entry.id.0.to_string(),
            entry.started.clone(),
            verdict,
            accepted,
            state_name(entry.state).into(),
            entry.vehicle.clone(),
            format!("{}{}", entry.configuration, axis_text(entry)),
        ]);
    }
    // What concerns the whole file is said once.
    damaged.dedup();
    table.fitted(width, &["started", "vehicle", "state"]) + &damaged.concat()
}

/// The verdict on a campaign, and how many of its runs it accepts.
fn verdict_cells(logbook: &Logbook, entry: &CampaignEntry) -> Result<[String; 2], Error> {
    let campaign = logbook.campaign_of(entry)?;
    let whole = campaign.verdict();
    let runs = campaign.runs.iter();
    let accepted = runs.filter(|run| run.verdict_within(&whole).accepted).count();
    Ok([whole.outcome().name().into(), format!("{accepted} of {}", entry.runs)])
}
