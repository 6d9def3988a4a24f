//! A trial in words and a table.

use std::fmt::Write as _;
use std::path::Path;

use seatrial::campaign::{Campaign, Run};
use seatrial_app::trials::next;
use seatrial_core::{Outcome, RudderUnit};
use seatrial_logbook::{CampaignId, Logbook};

use crate::identify::cause_text;
use crate::screen::{command, labelled};
use crate::speed_table::{SpeedRow, promise_text, run_row, speed_table};

pub(super) fn run_line(run: &Run) -> String {
    let cause = run.verdict.cause().map_or("", |r| r.text.as_str());
    let (number, outcome) = (run.number, run.verdict.outcome().name());
    format!("run {number} at {:.0} % thrust: {outcome}: {cause}", 100.0 * run.thrust)
}

fn aborted_text(campaign: &Campaign) -> String {
    let place = campaign.runs.last().map_or(String::new(), |run| {
        format!(" in run {} at {:.0} % thrust", run.number, 100.0 * run.thrust)
    });
    format!("The trial was aborted{place} and the vehicle handed back; what was recorded is kept.")
}

/// What is printed of the campaign: its outcome, what decides it, and a line for each speed. `logbook` is the one that holds all
/// of it: what was not kept leads nowhere.
pub(super) fn text(
    campaign: &Campaign,
    number: CampaignId,
    logbook: Option<&Path>,
    report: Option<&Path>,
    width: usize,
) -> String {
    let verdict = campaign.verdict();
    let mut text = verdict.outcome().name().to_uppercase() + "\n";
    if let Some(Outcome::Aborted(_)) = campaign.outcome {
        text += &labelled("", &aborted_text(campaign), width);
    }
    if let Some(why) = campaign.changed_by_the_whole(&verdict) {
        text += &labelled("", &why, width);
    }
    let rows: Vec<SpeedRow> =
        campaign.deciding_runs().into_iter().map(|run| run_row(campaign, run, &verdict)).collect();
    text += &promise_text(&rows, width);
    text += &speed_table(&rows, RudderUnit::Rad, width).map_or(String::new(), |table| table + "\n");
    let remarks = logbook.map(|logbook| next::remarks_of_trial(number, logbook));
    text += &cause_text(&verdict, &remarks.unwrap_or_default(), width);
    if campaign.is_rehearsal() {
        let about =
            format!("a rehearsal: the numbers are those of {}, not of a boat", campaign.vehicle);
        text += &labelled("About  ", &about, width);
    }
    if let Some(logbook) = logbook {
        let _ = writeln!(text, "Kept   {}", logbook.display());
    }
    if let Some(report) = report {
        let _ = writeln!(text, "Report {}", report.display());
    }
    if let Some(report) = report
        && next::is_looked_into(campaign)
    {
        return text
            + &labelled("Next   ", &format!("look at {} in a browser", report.display()), width);
    }
    let Some(logbook) = logbook else {
        return text;
    };
    let circumstances =
        Logbook::open_read_only(logbook).and_then(|kept| kept.circumstances(number));
    let firmware = circumstances.ok().and_then(|known| known.firmware);
    text + &command(
        "Next   ",
        &next::after_trial(campaign, number, logbook, firmware.as_deref()),
        width,
    )
}
