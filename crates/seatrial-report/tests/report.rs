//! The report is read from outside: as a browser and a person would.

mod made_up_trial;

use seatrial::identification::{
    EstimateMethod, Outcome as Usable, Reason, ReasonCode, Subject, Verdict,
};
use seatrial::log::LambdaReason;
use seatrial::{Campaign, Record};
use seatrial_core::{AbortReason, Outcome, Plan, RudderUnit};
use seatrial_report::{self as report, About, Log, LogModel};

/// Keeps a page where a person can open it and returns its text.
fn kept(name: &str, page: String) -> String {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("report");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join(format!("{name}.html")), &page).unwrap();
    page
}

fn aborted() -> Campaign {
    let mut campaign = made_up_trial::campaign(&[0.6, 0.7]);
    campaign.outcome = Some(Outcome::Aborted(AbortReason::Roll));
    made_up_trial::interrupt(campaign.runs.last_mut().unwrap());
    campaign
}

fn rejected() -> Campaign {
    let mut campaign = made_up_trial::campaign(&[0.6, 0.8]);
    campaign.runs.iter_mut().for_each(made_up_trial::reject);
    campaign
}

fn empty() -> Campaign {
    Campaign { outcome: None, ..made_up_trial::campaign(&[]) }
}

/// Every kind of page that there is.
fn pages() -> Vec<(&'static str, String)> {
    let mut partly = made_up_trial::campaign(&[0.6, 0.7, 0.8, 0.9, 1.0]);
    made_up_trial::reject(&mut partly.runs[2]);
    let mut again = partly.runs[2].clone();
    (again.number, again.attempt) = (6, 2);
    partly.runs.push(again);
    let one = made_up_trial::campaign(&[0.8]);
    let run = &one.runs[0];
    let models = [LogModel::new(
        [Some(run.thrust), run.surge_speed_m_s],
        run.identification.as_ref(),
        &run.verdict,
        None,
    )];
    let log = Log {
        axis: seatrial_core::Axis::Yaw,
        name: "run_80.csv",
        record: &run.record,
        validation: None,
        identification: run.identification.as_ref(),
        verdict: &run.verdict,
        models: &models,
        command: "seatrial gains --model model.json",
        about: &[],
        provenance: &[("Format", "csv".to_owned())],
    };
    let verdict = Verdict::refused(Reason::new(
        ReasonCode::Constant.of(Subject::Rudder),
        "the rudder stays within 0.01 deg",
    ));
    let refused = Log { identification: None, verdict: &verdict, models: &[], ..log };
    vec![
        ("refused", report::render_log(&refused)),
        (
            "finished",
            report::render(
                &made_up_trial::campaign(&[0.6, 0.7, 0.8, 0.9, 1.0]),
                &About::default(),
                "",
            ),
        ),
        ("partly", report::render(&partly, &About::default(), "")),
        ("rejected", report::render(&rejected(), &About::default(), "")),
        ("aborted", report::render(&aborted(), &About::default(), "")),
        ("empty", report::render(&empty(), &About::default(), "")),
        ("one_speed", report::render(&one, &About::default(), "")),
        ("log", report::render_log(&log)),
    ]
}

#[test]
fn prop_page_asks_for_nothing_outside() {
    for (name, page) in pages() {
        let page = kept(name, page);
        for outside in ["http:", "https:", "src=", "url(", "@import", "<link rel=\"style", "//"] {
            assert!(!page.contains(outside), "{name} holds {outside}");
        }
        assert!(page.contains("default-src 'none'"), "{name} has no policy");
    }
}

/// Names of the elements that are open at each closing tag: a page whose tags do not balance is
/// shown as the browser guesses.
#[test]
fn prop_tags_balance_and_attributes_are_closed() {
    const EMPTY_ELEMENTS: [&str; 2] = ["meta", "link"];
    for (name, page) in pages() {
        let mut open: Vec<&str> = Vec::new();
        // Style and script hold no tags, but may hold a comparison.
        let mut rest = page.as_str();
        while let Some(start) = rest.find('<') {
            rest = &rest[start + 1..];
            let end = rest.find('>').unwrap_or_else(|| panic!("{name}: tag without end"));
            let tag = &rest[..end];
            rest = &rest[end + 1..];
            assert_eq!(tag.matches('"').count() % 2, 0, "{name}: open quote in {tag}");
            let element = tag.trim_start_matches('/').split([' ', '/', '\n']).next().unwrap();
            if tag.starts_with('/') {
                assert_eq!(open.pop(), Some(element), "{name}: </{element}>");
            } else if !tag.ends_with('/')
                && !tag.starts_with('!')
                && !EMPTY_ELEMENTS.contains(&element)
            {
                open.push(element);
            }
        }
        assert!(open.is_empty(), "{name}: {open:?} not closed");
    }
}

#[test]
fn prop_no_number_that_is_none() {
    for (name, page) in pages() {
        for wrong in ["NaN", "inf ", "inf\"", ">inf", "-inf"] {
            assert!(!page.contains(wrong), "{name} holds {wrong}");
        }
    }
}

#[test]
fn prop_same_campaign_same_bytes() {
    assert_eq!(pages(), pages());
}

/// Every figure has a name for those who do not see it, and a caption.
#[test]
fn prop_every_chart_has_words() {
    for (name, page) in pages() {
        let charts = page.matches("<svg class=\"chart\"").count();
        assert_eq!(charts, page.matches("role=\"img\" aria-label=\"").count(), "{name}");
        assert_eq!(charts, page.matches("<figcaption>").count(), "{name}");
        assert!(!page.contains("aria-label=\"\""), "{name}");
        assert!(!page.contains("<figcaption></figcaption>"), "{name}");
    }
}

#[test]
fn exact_finished_trial_has_every_part() {
    let page =
        report::render(&made_up_trial::campaign(&[0.6, 0.7, 0.8, 0.9, 1.0]), &About::default(), "");
    for part in [
        "Usable models at all 5 speeds.",
        "What to do now",
        "Summary",
        "Controller",
        "Live estimates",
        "Offline simplex search",
        "Every run",
        "What the numbers assume",
        "What was recorded",
        "through zero",
        "U-turn mean radius",
        "Steady turning radius",
        "Phase margin",
        "Feed-forward",
        "Change per sample",
        "converged 10.0 s",
        "SHA-256",
    ] {
        assert!(page.contains(part), "{part} is missing");
    }
    for run in 1..=5 {
        assert!(page.contains(&format!("id=\"run-{run}\"")), "run {run}");
    }
    // The limit for five speeds.
    assert!(page.len() < 1_500_000, "{} bytes", page.len());
}

/// No plots when the analysis fails is the complaint; every run of a bad trial is drawn.
#[test]
fn exact_bad_trials_are_drawn() {
    let page = report::render(&aborted(), &About::default(), "");
    assert!(
        page.contains("the roll left its limits. A usable model")
            || page.contains("the roll left its limits. Usable models at 1 of 2 speeds.")
    );
    assert!(page.contains("Check trim and ballast"));
    assert!(page.contains("id=\"run-2\""));
    assert!(page.matches("The manoeuvre.").count() == 2);

    let page = report::render(&rejected(), &About::default(), "");
    assert!(page.contains("No usable model."));
    assert!(page.matches("The manoeuvre.").count() == 2);
    assert!(page.matches("Measured less model").count() == 2);
    assert!(!page.contains("Load the gains"));

    let page = report::render(&empty(), &About::default(), "");
    assert!(page.contains("No run was recorded so far."));
    assert!(page.contains("What was recorded"));
}

#[test]
fn prop_names_cannot_write_markup() {
    let hostile = "<script>alert(1)</script>\"'&<img onerror=x>";
    let mut campaign = made_up_trial::campaign(&[0.6]);
    campaign.vehicle = hostile.to_owned();
    campaign.configuration = hostile.to_owned();
    campaign.software_version = hostile.to_owned();
    campaign.runs[0].verdict.reasons[0].text = hostile.to_owned();
    let identification = campaign.runs[0].identification.as_mut().unwrap();
    identification.settings.lambda_because = LambdaReason::Recorded(hostile.to_owned());
    identification.online.method = EstimateMethod::Other(hostile.to_owned());
    identification.refined.as_mut().unwrap().method = EstimateMethod::Other(hostile.to_owned());
    let page = report::render(&campaign, &About::default(), "");
    assert!(!page.contains("<script>alert"));
    assert!(!page.contains("<img"));
    assert!(page.contains("alert(1)"));

    let run = &campaign.runs[0];
    let log = Log {
        axis: seatrial_core::Axis::Yaw,
        name: hostile,
        record: &run.record,
        validation: Some(&run.record),
        identification: run.identification.as_ref(),
        verdict: &run.verdict,
        models: &[],
        command: "seatrial gains --model model.json",
        about: &[],
        provenance: &[("Format", hostile.to_owned())],
    };
    let page = report::render_log(&log);
    assert!(!page.contains("<script>alert") && !page.contains("<img"));
}

/// No name brings a command of a terminal, or turns the lines around, for who reads the page's source or copies from it.
#[test]
fn prop_names_cannot_command_a_terminal() {
    let hostile = "pay\u{1b}[2Jload\u{9b}31m\u{202e}";
    let mut campaign = made_up_trial::campaign(&[0.6]);
    campaign.vehicle = hostile.to_owned();
    campaign.configuration = hostile.to_owned();
    let page = report::render(
        &campaign,
        &About {
            place: Some(hostile),
            operator: Some(hostile),
            plan_text: hostile,
            provenance: &[("Plan", hostile.to_owned())],
            ..About::default()
        },
        "",
    );
    assert!(!page.contains(['\u{1b}', '\u{9b}', '\u{202e}']));
    assert!(page.contains("pay\\u{1b}[2Jload"));
}

/// A rudder of which nobody said the angle is in per cent of full, and is never called degrees.
#[test]
fn exact_a_fraction_of_full_rudder_is_no_angle() {
    let campaign = made_up_trial::campaign(&[0.6]);
    let run = &campaign.runs[0];
    let mut record = run.record.clone();
    let page = |record: &Record| {
        report::render_log(&Log {
            axis: seatrial_core::Axis::Yaw,
            name: "run.csv",
            record,
            validation: None,
            identification: run.identification.as_ref(),
            verdict: &run.verdict,
            models: &[LogModel::new([None, None], run.identification.as_ref(), &run.verdict, None)],
            command: "",
            about: &[],
            provenance: &[],
        })
    };
    let angles = page(&record);
    assert!(angles.contains("Rudder, °") && angles.contains("°/°"));
    record.rudder_unit = RudderUnit::FullRudder;
    let fractions = page(&record);
    assert!(!fractions.contains("Rudder, °") && !fractions.contains("°/°"));
    for shown in ["Rudder, % of full", "full/rad", "1/s² per full rudder"] {
        assert!(fractions.contains(shown), "{shown}");
    }
}

/// What a reader looks for first: verdict, circumstances, contents; runs and plan behind folds that print open.
#[test]
fn exact_the_head_says_when_where_and_by_whom_and_the_rest_is_folded() {
    let campaign = made_up_trial::campaign(&[0.6, 0.8]);
    let plan = Plan::paper();
    let about = About {
        started: Some("2026-11-24T07:38:14.123Z"),
        place: Some("Lake of Constance"),
        operator: Some("Ada"),
        plan: Some(&plan),
        plan_text: "thrusts = [0.6]",
        ..About::default()
    };
    let page = report::render(&campaign, &about, "seatrial gains");
    for fact in ["2026-11-24 07:38 UTC", "Lake of Constance", "Ada"] {
        assert!(page.contains(&format!("<dd>{fact}</dd>")), "{fact}");
    }
    assert_eq!(page.matches("<details class=\"run\">").count(), 2);
    for part in ["summary", "run-1", "run-2", "plan", "recorded"] {
        assert!(page.contains(&format!("href=\"#{part}\"")), "{part}");
        assert!(page.contains(&format!("id=\"{part}\"")), "{part}");
    }
    assert!(page.contains("doublet of 14.9° over 4.00 s"));
    assert!(page.contains("thrusts = [0.6]"));
    // One model table of trial: its columns are not repeated in another one that is not folded.
    assert_eq!(page.matches("Damping a₂₂<span").count(), 1);
    // A single run is what the page is about.
    let single = report::render(&made_up_trial::campaign(&[0.6]), &about, "");
    assert!(single.contains("<details class=\"run\" open>"));
}

/// The script tells values from the axes of a panel, and a legend by its ink.
#[test]
fn exact_charts_carry_what_the_script_reads() {
    let page = report::render(&made_up_trial::campaign(&[0.6]), &About::default(), "");
    let plots = page.matches("<svg class=\"plot\"").count();
    assert!(plots > 10, "{plots}");
    assert_eq!(plots, page.matches(" data-x=\"").count());
    assert_eq!(plots, page.matches(" data-y=\"").count());
    assert!(page.contains("data-log=\"\""));
    assert!(page.contains("<g class=\"key\" data-ink=\""));
}

/// Numbers of a model that is not to be used do not stand in the summary.
#[test]
fn exact_a_rejected_model_has_no_numbers_in_the_summary() {
    let page = report::render(&rejected(), &About::default(), "");
    let (_, rest) = page.split_once("id=\"summary\"").unwrap();
    let (summary, _) = rest.split_once("</section>").unwrap();
    assert!(summary.contains("do not use"));
    assert!(!summary.contains("class=\"interval\""), "{summary}");
}

/// Values that no vehicle sends must not break the page.
#[test]
fn prop_wild_samples_are_drawn_or_left_out() {
    for wild in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 0.0] {
        let mut campaign = made_up_trial::campaign(&[0.6, 0.7]);
        for run in &mut campaign.runs {
            for sample in run.record.samples.iter_mut().step_by(7) {
                sample.heading_rad = wild;
                sample.yaw_rate_rad_s = Some(wild);
                sample.depth_m = Some(wild);
            }
            for k in [0, 500, run.record.samples.len() - 1] {
                run.record.samples[k].time_s = wild;
            }
            let identification = run.identification.as_mut().unwrap();
            identification.online.trace[0].time_s = wild;
            identification.online.trace[100].theta = [wild; 3];
            identification.online.trace[100].step_norm = wild;
            let refined = identification.refined.as_mut().unwrap();
            refined.model.a22_per_s = wild;
            refined.interval_95.b2_per_s2 = [wild; 2];
            run.surge_speed_m_s = Some(wild);
        }
        let page = report::render(&campaign, &About::default(), "");
        for wrong in ["NaN", "inf ", "inf\"", ">inf", "-inf"] {
            assert!(!page.contains(wrong), "{wild}: {wrong}");
        }
    }
}

#[test]
fn prop_records_of_none_and_one_sample() {
    for count in [0, 1, 2] {
        let mut campaign = made_up_trial::campaign(&[0.6]);
        let run = &mut campaign.runs[0];
        run.record.samples.truncate(count);
        let page = report::render(&campaign, &About::default(), "");
        assert!(page.contains("id=\"run-1\""), "{count} samples");
    }
}

/// A campaign is judged as a whole: by what its speeds gave, and by how it ended.
#[test]
fn exact_a_campaign_has_an_outcome_of_its_own() {
    let mut partly = made_up_trial::campaign(&[0.6, 0.8]);
    made_up_trial::reject(&mut partly.runs[1]);
    for (mut campaign, outcome, cause) in [
        (made_up_trial::campaign(&[0.6]), Usable::Use, ReasonCode::Ok),
        (partly, Usable::UseWithCare, ReasonCode::SpeedMissing),
        (aborted(), Usable::UseWithCare, ReasonCode::Aborted),
        (rejected(), Usable::DoNotUse, ReasonCode::SpeedMissing),
        (empty(), Usable::DoNotUse, ReasonCode::Interrupted),
    ] {
        let verdict = campaign.verdict();
        assert_eq!(verdict.outcome(), outcome, "{verdict:?}");
        assert_eq!(verdict.cause().unwrap().code, cause, "{verdict:?}");
        // What goes on from a rehearsal is a trial on a vehicle.
        let rehearsal = report::render(&campaign, &About::default(), "seatrial gains");
        assert!(!rehearsal.contains("<pre class=\"command\">"));
        campaign.seed = None;
        let page = report::render(&campaign, &About::default(), "seatrial gains");
        let name = outcome.name();
        let capital = name[..1].to_uppercase() + &name[1..];
        assert!(page.contains(&format!("</span> {capital}.")), "{name}");
        // What goes on from a trial that was aborted, or from a model that is not to be used, is the page itself.
        let has_command = page.contains("<pre class=\"command\">seatrial gains</pre>");
        let is_aborted = cause == ReasonCode::Aborted;
        assert_eq!(has_command, !is_aborted && outcome != Usable::DoNotUse, "{name}");
    }
}

/// Where the offset drifted, the verdict rests on R^2 with the offset estimated again, and that one is shown.
#[test]
fn exact_r2_below_zero_never_stands_beside_use() {
    let mut campaign = made_up_trial::campaign(&[0.6]);
    let run = &mut campaign.runs[0];
    let validation = run.identification.as_mut().unwrap().validation.as_mut();
    let validation = validation.unwrap();
    validation.r2_heading = Some(-0.001);
    validation.r2_heading_offset_refit = Some(0.87);
    assert_eq!(validation.judged_r2_heading(), Some(0.87));
    let page = report::render(&campaign, &About::default(), "");
    assert!(page.contains(">0.87<") && !page.contains(">−0.00"));
}

/// A zig-zag of 35 s a period from a course of 350 deg: a hull with T = 4 s, K = 0.25 1/s, and noise of 0.5 deg in its heading.
fn zigzag() -> Record {
    let model = seatrial_core::YawModel::from_theta([-0.25, 0.0625, 0.001]);
    let mut state = seatrial_core::model::YawState { heading_rad: 6.1, yaw_rate_rad_s: 0.0 };
    let mut seed = 1_u64;
    let samples = (0..420).map(|k| {
        let time_s = 0.5 * f64::from(k);
        let side = if (k / 35) % 2 == 0 { 0.5 } else { -0.5 };
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let noise_deg = (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0;
        let sample = seatrial_core::Sample {
            time_s,
            heading_rad: state.heading_rad + 0.5_f64.to_radians() * noise_deg,
            rudder_rad: side,
            surge_speed_m_s: Some(1.2 - 0.3 * (time_s / 210.0)),
            ..seatrial_core::Sample::default()
        };
        state = model.advance(state, side, 0.5);
        sample
    });
    samples.collect()
}

fn identified(record: &Record, validate_from_s: f64) -> seatrial::Identification {
    let data =
        seatrial::identify::ValidationData { record, window: window(validate_from_s, 210.0) };
    let settings = seatrial::identify::IdentifySettings::default();
    let training = window(0.0, validate_from_s);
    seatrial::identify::identify(record, training, Some(data), &settings).unwrap()
}

fn window(from_s: f64, to_s: f64) -> seatrial::Window {
    seatrial::Window { from_s, to_s }
}

/// The line of the model is the one whose R^2 is printed below it, where the data for validation begin in a turn, too.
#[test]
fn exact_the_line_of_the_model_has_the_r2_that_is_printed() {
    let record = zigzag();
    for validate_from_s in [98.0, 117.5] {
        let found = identified(&record, validate_from_s);
        let drawn = report::overlay(&record, window(validate_from_s, 210.0), &found);
        let measured = || drawn.iter().map(|at| at.measured_rad);
        let mean = measured().sum::<f64>() / drawn.len() as f64;
        let variation: f64 = measured().map(|heading| (heading - mean).powi(2)).sum();
        let missed = drawn.iter().map(|at| at.measured_rad - at.simulated_rad);
        let r2 = 1.0 - missed.map(|error| error * error).sum::<f64>() / variation;
        let judged = found.validation.unwrap().judged_r2_heading().unwrap();
        // Sums of 200 products, rounded.
        assert!((r2 - judged).abs() < 1e-6, "{r2} {judged}");
    }
}

#[test]
fn exact_the_page_of_a_log_says_each_thing_once() {
    let mut found = identified(&zigzag(), 98.0);
    found.verdict.reasons = vec![
        Reason {
            detail: "the log has no yaw rate to compare the heading with".into(),
            text: "The log has no yaw rate to check the compass with.".into(),
            ..Reason::new(ReasonCode::Unchecked.of(Subject::Heading), "")
        },
        Reason::new(ReasonCode::Ok, "twice"),
        Reason::new(ReasonCode::Ok, "twice"),
    ];
    // The whole trains, and a model of its first part predicts the rest.
    found.training = window(0.0, 210.0);
    let record = zigzag();
    let verdict = found.verdict.clone();
    let range = found.valid_range.unwrap();
    let speed = range.usual_surge_speed_m_s;
    let model = LogModel::new([None, speed], Some(&found), &verdict, None);
    let page = report::render_log(&Log {
        axis: seatrial_core::Axis::Yaw,
        name: "zigzag.csv",
        record: &record,
        validation: None,
        identification: Some(&found),
        verdict: &verdict,
        models: &[model],
        command: "",
        about: &[],
        provenance: &[],
    });
    // The cause at the top, what was measured with the figures.
    for said in ["to check the compass with", "to compare the heading with"] {
        assert_eq!(page.matches(said).count(), 1, "{said}");
    }
    assert_eq!(page.matches("Twice").count(), 1);
    assert!(page.contains("A model of the rest of the record explains"));
    assert!(page.contains("All of the shaded part is for training"));
    assert!(page.contains("1.05"), "the speed of the log");
}
