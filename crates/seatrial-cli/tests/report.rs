//! `seatrial report` at the process boundary.

#[path = "../../seatrial-report/tests/made_up_trial/mod.rs"]
mod made_up_trial;

use std::path::Path;
use std::process::Output;

use seatrial::{Campaign, Step};
use seatrial_core::{AbortReason, Action, Outcome, Steering};
use seatrial_dev::{run_in, text};
use seatrial_logbook::{Logbook, NewCampaign, Recorder};
use serde_json::Value;

fn seatrial(arguments: &[&str], folder: &Path) -> Output {
    run_in(folder, &[&["report"], arguments].concat())
}

fn record(logbook: &Path, campaign: &Campaign) {
    let new = NewCampaign {
        configuration: &campaign.configuration,
        notes: None,
        software_version: &campaign.software_version,
        vehicle: &campaign.vehicle,
        seed: campaign.seed,
        rudder_limit_rad: campaign.rudder_limit_rad,
        full_rudder: None,
        scenario: None,
        plan: "speeds = [0.6, 0.7]\n# <b>",
    };
    let mut recorder = Recorder::begin(Logbook::open(logbook).unwrap(), &new).unwrap();
    for run in &campaign.runs {
        recorder.begin_run(run.number, run.thrust, run.attempt).unwrap();
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
    starts.map(|(from, _)| &page[from..from + page[from..].find("<figcaption>").unwrap()]).collect()
}

#[test]
fn cli_report_of_a_logbook_draws_what_was_run() {
    let folder = tempfile::tempdir().unwrap();
    let mut campaign = made_up_trial::campaign(&[0.6, 0.7, 0.8]);
    made_up_trial::reject(&mut campaign.runs[1]);
    made_up_trial::interrupt(&mut campaign.runs[2]);
    campaign.outcome = Some(Outcome::Aborted(AbortReason::Roll));
    record(&folder.path().join("seatrial.db"), &made_up_trial::campaign(&[0.6]));
    record(&folder.path().join("seatrial.db"), &campaign);

    let output = seatrial(
        &["--logbook", "seatrial.db", "--campaign", "2", "--out", "page.html", "--json"],
        folder.path(),
    );
    assert!(output.status.success(), "{}", text(&output.stderr));
    let saved: Value = serde_json::from_slice(&output.stdout).unwrap();
    let page = std::fs::read_to_string(folder.path().join("page.html")).unwrap();
    assert_eq!(saved["schema"], "seatrial.report.v1");
    assert_eq!(saved["bytes"], page.len());
    // A logbook keeps every bit, so the charts are those of the campaign itself.
    let direct = seatrial_report::render(&campaign, &seatrial_report::About::default(), "");
    assert_eq!(charts(&page), charts(&direct));
    assert!(page.contains("The trial was stopped: the roll left its limits."));
    assert!(page.contains("seatrial.db, campaign 2"));
    assert!(page.contains("speeds = [0.6, 0.7]\n# &#60;b&#62;"));

    let output = seatrial(&["--logbook", "seatrial.db"], folder.path());
    assert!(output.status.success(), "{}", text(&output.stderr));
    // The last that was accepted; the one that was aborted is named.
    let printed = text(&output.stderr);
    assert!(
        printed.contains("campaign 1 is taken; the newest, campaign 2, was aborted"),
        "{printed}"
    );
    assert!(text(&output.stdout).starts_with("report.html ("));
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("A usable model at the one speed tried."));
}

/// A run as a log, with the rudder as steered or held still.
fn write_log(path: &Path, still: bool) {
    let campaign = made_up_trial::campaign(&[0.8]);
    let mut log = String::from("time_s,heading_rad,rudder_rad\n");
    for sample in &campaign.runs[0].record.samples {
        let rudder_rad = if still { 0.01 } else { sample.rudder_rad };
        let (time_s, heading_rad) = (sample.time_s, sample.heading_rad);
        log += &format!("{time_s},{heading_rad},{rudder_rad}\n");
    }
    std::fs::write(path, log).unwrap();
}

#[test]
fn cli_report_of_a_log_draws_it_with_and_without_a_model() {
    let folder = tempfile::tempdir().unwrap();
    write_log(&folder.path().join("run.csv"), false);
    let (larger, smaller) = (["120", "136.5"], ["136.5", "153"]);
    let page_of = |[from, to]: [&str; 2], [validate_from, validate_to]: [&str; 2]| {
        let windows = ["run.csv", "--from", from, "--to", to];
        let held_out = ["--validate-from", validate_from, "--validate-to", validate_to];
        let output = seatrial(&[&windows[..], &held_out].concat(), folder.path());
        let page = std::fs::read_to_string(folder.path().join("run.html")).unwrap();
        assert_eq!(charts(&page).len(), 3);
        (page, output.status.code())
    };
    // In this much disturbance the smaller doublet cannot show what the larger one missed.
    let (page, code) = page_of(larger, smaller);
    assert_eq!(code, Some(4));
    assert!(page.contains("</span> Do not use.</h2>"));
    assert!(page.contains("The validation manoeuvre was too small to show a wrong model."));
    let (page, code) = page_of(smaller, larger);
    assert_eq!(code, Some(0));
    assert!(page.contains("</span> Use"));
    assert!(page.contains("seatrial gains --model model.json"));
    assert!(page.contains("heading from heading_rad [rad]"));

    write_log(&folder.path().join("still.csv"), true);
    let output = seatrial(&["still.csv", "--out", "still.html"], folder.path());
    assert_eq!(output.status.code(), Some(4), "{}", text(&output.stderr));
    let page = std::fs::read_to_string(folder.path().join("still.html")).unwrap();
    assert!(page.contains("</span> Do not use.</h2>"));
    assert!(page.contains("No manoeuvre: the rudder hardly moved."));
    assert_eq!(charts(&page).len(), 1);
}

#[test]
fn cli_report_says_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, code, said) in [
        (&[][..], 2, "name a log"),
        (&["--from", "3"], 2, "name a log"),
        (&["run.csv", "--logbook", "seatrial.db"], 2, "--logbook"),
        (&["--campaign", "1"], 2, "--logbook"),
        (&["--logbook", "none.db"], 3, "none.db"),
        (&["none.csv"], 3, "none.csv"),
    ] {
        let output = seatrial(arguments, folder.path());
        assert_eq!(output.status.code(), Some(code), "{arguments:?}");
        assert!(text(&output.stderr).contains(said), "{arguments:?}");
    }

    record(&folder.path().join("seatrial.db"), &made_up_trial::campaign(&[0.6]));
    let logbook = ["--logbook", "seatrial.db"];
    let output = seatrial(&[&logbook[..], &["--campaign", "9"]].concat(), folder.path());
    assert_eq!(output.status.code(), Some(3));
    assert!(text(&output.stderr).contains('9'), "{}", text(&output.stderr));

    let nowhere = [&logbook[..], &["--out", "no/such/folder/page.html"]].concat();
    let output = seatrial(&nowhere, folder.path());
    assert_eq!(output.status.code(), Some(6));
    assert!(text(&output.stderr).contains("no/such/folder/page.html"));
}
