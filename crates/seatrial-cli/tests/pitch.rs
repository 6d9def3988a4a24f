//! The pitch axis at the process boundary.

use std::process::Output;

use seatrial_dev::run_in;

fn said(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

#[test]
fn cli_a_pitch_trial_and_its_log_give_the_same_model() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("pitch.csv");
    let log = log.to_str().unwrap();
    let run = run_in(
        folder.path(),
        &[
            "trial",
            "--axis",
            "pitch",
            "--vehicle",
            "sim:remus100",
            "--log",
            log,
            "--json",
        ],
    );
    assert!(run.status.success(), "{run:?}");
    let trial: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    let live = &trial["runs"][2]["identification"];
    let time = |window: &serde_json::Value, end: &str| window[end].as_f64().unwrap().to_string();
    let run = run_in(
        folder.path(),
        &[
            "identify",
            log,
            "--axis",
            "pitch",
            "--json",
            "--from",
            &time(&live["training"], "from_s"),
            "--to",
            &time(&live["training"], "to_s"),
            "--validate-from",
            &time(&live["validation"]["window"], "from_s"),
            "--validate-to",
            &time(&live["validation"]["window"], "to_s"),
        ],
    );
    assert!(run.status.success(), "{run:?}");
    let read: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    let model = &read["refined"]["model"];
    for name in ["damping_per_s", "restoring_per_s2", "authority_per_s2"] {
        let (live, read) = (&live["refined"]["model"][name], &model[name]);
        // The file has every digit; the warming of the filters differs, where the search starts.
        let difference = live.as_f64().unwrap() - read.as_f64().unwrap();
        assert!(difference.abs() < 1e-4, "{name}: {live} {read}");
    }
}

#[test]
fn cli_a_vehicle_without_pitch_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let run = run_in(
        folder.path(),
        &["trial", "--axis", "pitch", "--vehicle", "sim:starfish"],
    );
    assert_eq!(run.status.code(), Some(2));
    let said = String::from_utf8(run.stderr).unwrap();
    assert!(
        said.contains("sim:starfish") && said.contains("no pitch"),
        "{said}"
    );
}

#[test]
fn cli_a_pitch_plan_is_followed_and_checked() {
    let folder = tempfile::tempdir().unwrap();
    let plan = folder.path().join("plan.toml");
    let page = folder.path().join("pitch.html");
    let run = |text: &str| {
        std::fs::write(&plan, text).unwrap();
        let plan = plan.to_str().unwrap();
        let options = [
            "--vehicle",
            "sim:starfish-6dof",
            "--plan",
            plan,
            "--json",
            "--report",
        ];
        let page = page.to_str().unwrap();
        run_in(
            folder.path(),
            &[&["trial", "--axis", "pitch"][..], &options, &[page]].concat(),
        )
    };
    let done = run("thrusts = [0.8]\ntraining_rad = 0.15\n");
    assert!(done.status.success(), "{done:?}");
    let document: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(document["runs"].as_array().unwrap().len(), 1);
    assert_eq!(document["plan"]["training_rad"], 0.15);
    assert_eq!(document["plan"]["validation_rad"], 0.12);
    let page = std::fs::read_to_string(&page).unwrap();
    assert!(page.contains("1 of 1 thrusts have a model") && page.contains("<svg"));
    for (text, named) in [
        ("thrusts = []", "thrusts must be"),
        ("doublet_s = -1", "doublet_s must be"),
        ("training_rad = 2", "training_rad must be"),
        ("amplitude = 1", "unknown field `amplitude`"),
    ] {
        let refused = run(text);
        assert_eq!(refused.status.code(), Some(3));
        let message = String::from_utf8(refused.stderr).unwrap();
        assert!(message.contains(named), "{message}");
    }
}

#[test]
fn cli_a_pitch_trial_is_kept_replayed_and_drawn_again() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("plan.toml"), "thrusts = [0.6, 0.9]\n").unwrap();
    let run = |arguments: &str| {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        run_in(folder.path(), &arguments)
    };
    let trial = "trial --axis pitch --vehicle sim:starfish-6dof --plan plan.toml --seed 3";
    let live = run(&format!("{trial} --log live.csv --report live.html"));
    assert!(live.status.success(), "{live:?}");
    assert!(said(&live).contains("seatrial.db, pitch trial 1"));
    assert!(said(&run("logbook list")).contains("  2 of 2  finished"));
    let shown = run("logbook show --axis pitch");
    let model = said(&live).lines().nth(4).unwrap().to_owned();
    assert!(said(&shown).contains(&model), "{}", said(&shown));
    assert!(
        run("logbook export --axis pitch --out kept.csv")
            .status
            .success()
    );
    assert!(
        run("report --logbook seatrial.db --axis pitch --out kept.html")
            .status
            .success()
    );
    let file = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert_eq!(file("kept.csv"), file("live.csv"));
    assert_eq!(file("kept.html"), file("live.html"));

    let replay = run("replay seatrial.db --axis pitch");
    assert!(replay.status.success() && said(&replay).contains("bit for bit"));
    assert!(run("logbook verify").status.success());
    let missing = run("logbook show 7 --axis pitch");
    assert_eq!(missing.status.code(), Some(3));
}
