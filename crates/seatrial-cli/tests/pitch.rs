//! The axis of pitch at the process boundary: the same verbs, logbook, report and exit codes as yaw.

use std::process::Output;

use seatrial_dev::run_in;

fn said(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn json(output: &Output) -> serde_json::Value {
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A trial is kept, shown, exported, replayed and drawn as one of yaw is, and its log gives the model that it gave.
#[test]
fn cli_a_pitch_trial_and_its_log_give_the_same_model() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &str| {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        run_in(folder.path(), &arguments)
    };
    let text = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    std::fs::write(folder.path().join("plan.toml"), "thrusts = [0.6, 0.9]\n").unwrap();
    let trial =
        "trial --axis pitch --vehicle sim:remus100 --plan plan.toml --seed 3 --report live.html";
    let trial = run(&format!("{trial} --json"));
    assert!(trial.status.success(), "{trial:?}");
    let trial = json(&trial);
    assert_eq!((&trial["axis"], &trial["plan"]["axis"]), (&"pitch".into(), &"pitch".into()));
    assert_eq!(trial["verdict"]["outcome"], "use");

    let list = said(&run("logbook list"));
    assert!(list.contains("  2 of 2  finished") && list.contains("default, pitch"), "{list}");
    let shown = said(&run("logbook 1"));
    assert!(shown.contains("default, pitch") && shown.contains("1/s^2"), "{shown}");
    let replay = run("replay seatrial.db");
    assert!(replay.status.success() && said(&replay).contains("bit for bit"), "{replay:?}");
    assert!(run("logbook --verify").status.success());
    assert!(run("report --logbook seatrial.db --out kept.html").status.success());
    let page = text("kept.html");
    assert_eq!(page, text("live.html"));
    for part in ["Usable models at all 2 speeds", "Elevator, °", "Restoring m", "of the pitch (R²"]
    {
        assert!(page.contains(part), "{part}");
    }
    for absent in ["Rudder, °", "Nomoto T", "seatrial gains"] {
        assert!(!page.contains(absent), "{absent}");
    }

    assert!(run("logbook export --run 2 --out run.csv").status.success());
    let live = &trial["runs"][1]["identification"];
    let time = |window: &serde_json::Value, end: &str| window[end].as_f64().unwrap().to_string();
    let [training, validation] = [&live["training"], &live["validation"]["window"]];
    let trained = format!(
        "identify run.csv --axis pitch --from {} --to {}",
        time(training, "from_s"),
        time(training, "to_s")
    );
    let validated = format!(
        "{trained} --validate-from {} --validate-to {}",
        time(validation, "from_s"),
        time(validation, "to_s")
    );
    let read = run(&format!("{validated} --json"));
    assert!(read.status.success(), "{read:?}");
    let read = json(&read);
    for (group, name) in
        [("refined", "a22_per_s"), ("refined", "b2_per_s2"), ("restoring", "refined_per_s2")]
    {
        let (live, read) = (&live[group][name], &read[group][name]);
        // The file has every digit; the warming of the filters differs, where the search starts.
        let difference = live.as_f64().unwrap() - read.as_f64().unwrap();
        assert!(difference.abs() < 1e-4, "{name}: {live} {read}");
    }
    let printed = said(&run(&validated));
    assert!(printed.starts_with("USE\n") && printed.contains("R^2 of pitch"), "{printed}");
    // The outcomes are those of yaw.
    let unvalidated = run(&trained);
    assert_eq!(unvalidated.status.code(), Some(4));
    assert!(said(&unvalidated).starts_with("NOT VALIDATED"), "{unvalidated:?}");
    let accepted = run(&format!("{trained} --accept-unvalidated"));
    assert_eq!(accepted.status.code(), Some(0));
    assert!(run(&format!("{trained} --json")).stdout.len() > 100);
}

/// Gains and turning limits are made of yaw, and refuse what is of pitch by its name.
#[test]
fn cli_pitch_gives_no_heading_gains() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &str| {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        run_in(folder.path(), &arguments)
    };
    std::fs::write(folder.path().join("plan.toml"), "axis = \"pitch\"\nthrusts = [0.8]\n").unwrap();
    let trial = run("trial --vehicle sim:starfish-6dof --plan plan.toml");
    assert!(trial.status.success(), "{trial:?}");
    for verb in ["gains", "turn", "gains --campaign 1"] {
        let refused = run(&format!("{verb} --logbook seatrial.db"));
        assert_eq!(refused.status.code(), Some(3), "{refused:?}");
        let message = String::from_utf8(refused.stderr).unwrap();
        assert!(message.contains("pitch"), "{message}");
    }
}

#[test]
fn cli_a_vehicle_without_pitch_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let run = run_in(folder.path(), &["trial", "--axis", "pitch", "--vehicle", "sim:starfish"]);
    assert_eq!(run.status.code(), Some(2));
    let said = String::from_utf8(run.stderr).unwrap();
    assert!(said.contains("sim:starfish cannot be steered in pitch"), "{said}");
    assert!(!folder.path().join("seatrial.db").exists());
}

#[test]
fn cli_a_pitch_plan_is_followed_and_checked() {
    let folder = tempfile::tempdir().unwrap();
    let plan = folder.path().join("plan.toml");
    let run = |text: &str| {
        std::fs::write(&plan, text).unwrap();
        let plan = plan.to_str().unwrap();
        let options = ["--vehicle", "sim:starfish-6dof", "--plan", plan, "--json"];
        run_in(folder.path(), &[&["trial", "--axis", "pitch"][..], &options].concat())
    };
    let training =
        "[training]\nexcitation = { doublet = { amplitude_rad = 0.15, period_s = 2.0 } }\n";
    let done = run(&format!("thrusts = [0.8]\n{training}"));
    assert!(done.status.success(), "{done:?}");
    let document = json(&done);
    assert_eq!(document["runs"].as_array().unwrap().len(), 1);
    let amplitude =
        |stage: &str| &document["plan"][stage]["excitation"]["doublet"]["amplitude_rad"];
    assert_eq!((amplitude("training"), amplitude("validation")), (&0.15.into(), &0.12.into()));
    for (text, named) in [
        ("thrusts = []", "thrusts must be"),
        ("sample_interval_s = -1.0", "sample_interval_s must be"),
        ("rudder_limit_rad = 2.0", "rudder_limit_rad must be"),
        ("amplitude = 1", "unknown field `amplitude`"),
        ("axis = \"yaw\"", "a plan for heading, not for pitch"),
    ] {
        let refused = run(text);
        assert_eq!(refused.status.code(), Some(3));
        let message = String::from_utf8(refused.stderr).unwrap();
        assert!(message.contains(named), "{message}");
    }
}
