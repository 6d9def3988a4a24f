//! `seatrial report` at the process boundary.

#[path = "../../seatrial/tests/trial/mod.rs"]
mod trial;

use std::path::Path;
use std::process::{Command, Output};

use seatrial::Campaign;
use seatrial::logbook::{Logbook, NewCampaign, Recorder, Step};
use seatrial_core::{AbortReason, Action, Outcome, Steering};
use serde_json::Value;

fn seatrial(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_seatrial"))
        .arg("report")
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

fn record(logbook: &Path, campaign: &Campaign) {
    let new = NewCampaign {
        configuration: &campaign.configuration,
        notes: None,
        software_version: &campaign.software_version,
        vehicle: &campaign.vehicle,
        seed: campaign.seed,
        rudder_limit_rad: campaign.rudder_limit_rad,
        plan: "speeds = [0.6, 0.7]\n# <b>",
    };
    let mut recorder = Recorder::begin(Logbook::open(logbook).unwrap(), &new).unwrap();
    for run in &campaign.runs {
        recorder
            .begin_run(run.number, run.thrust, run.attempt)
            .unwrap();
        for sample in &run.record.samples {
            let step = Step {
                sample: *sample,
                stage: None,
                action: Action {
                    steering: Steering::Rudder(sample.rudder_rad),
                    thrust: Some(run.thrust),
                    outcome: None,
                },
                estimate: None,
            };
            recorder.step(step).unwrap();
        }
        recorder.finish_run(run).unwrap();
    }
    recorder.finish(campaign.outcome.unwrap()).unwrap();
}

fn charts(page: &str) -> Vec<&str> {
    let starts = page.match_indices("<svg class=\"chart\"");
    starts
        .map(|(from, _)| &page[from..from + page[from..].find("<figcaption>").unwrap()])
        .collect()
}

#[test]
fn cli_report_of_a_logbook_draws_what_was_run() {
    let folder = tempfile::tempdir().unwrap();
    let mut campaign = trial::campaign(&[0.6, 0.7, 0.8]);
    trial::reject(&mut campaign.runs[1]);
    trial::interrupt(&mut campaign.runs[2]);
    campaign.outcome = Some(Outcome::Aborted(AbortReason::Roll));
    record(&folder.path().join("seatrial.db"), &trial::campaign(&[0.6]));
    record(&folder.path().join("seatrial.db"), &campaign);

    let output = seatrial(&["--out", "page.html", "--json"], folder.path());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let saved: Value = serde_json::from_slice(&output.stdout).unwrap();
    let page = std::fs::read_to_string(folder.path().join("page.html")).unwrap();
    assert_eq!(saved["schema"], "seatrial.report.v1");
    assert_eq!(saved["bytes"], page.len());
    // A logbook keeps every bit, so the charts are those of the campaign itself.
    let direct = seatrial::report::render(&campaign, &[]);
    assert_eq!(charts(&page), charts(&direct));
    assert!(page.contains("The trial was stopped: the roll left its limits."));
    assert!(page.contains("seatrial.db, campaign 2"));
    assert!(page.contains("speeds = [0.6, 0.7]\n# &#60;b&#62;"));

    let output = seatrial(&["--campaign", "1"], folder.path());
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).starts_with("report.html ("));
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("A usable model at the one speed tried."));
}

#[test]
fn cli_report_says_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let output = seatrial(&[], folder.path());
    assert_eq!(output.status.code(), Some(3));
    assert!(text(&output.stderr).contains("seatrial.db"));

    record(&folder.path().join("seatrial.db"), &trial::campaign(&[0.6]));
    let output = seatrial(&["--campaign", "9"], folder.path());
    assert_eq!(output.status.code(), Some(3));
    assert!(
        text(&output.stderr).contains('9'),
        "{}",
        text(&output.stderr)
    );

    let output = seatrial(&["--out", "no/such/folder/page.html"], folder.path());
    assert_eq!(output.status.code(), Some(6));
    assert!(text(&output.stderr).contains("no/such/folder/page.html"));
}
