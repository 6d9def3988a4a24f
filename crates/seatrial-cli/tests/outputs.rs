//! No output of any verb takes the place of what is to be kept.
#![cfg(unix)]

use std::fs;
use std::path::Path;

use seatrial_dev::{run_in, text};

fn run(folder: &Path, line: &str) -> (Option<i32>, String) {
    let arguments: Vec<&str> = line.split(' ').collect();
    let output = run_in(folder, &arguments);
    let told = text(&output.stdout) + &text(&output.stderr);
    (output.status.code(), told)
}

/// A trial in `a.db`, a log in `l.csv`, a plan in `p.toml`, and other names of the first two.
fn kept(folder: &Path) {
    for line in [
        "trial --yes --logbook a.db",
        "sim log --seed 1 --thrust 0.8 --out l.csv",
        "plan --thrust 0.8 --out p.toml",
    ] {
        let (code, told) = run(folder, line);
        assert_eq!(code, Some(0), "{line}: {told}");
    }
    for (file, link, hard) in [("a.db", "a.link", "a.hard"), ("l.csv", "l.link", "l.hard")] {
        std::os::unix::fs::symlink(file, folder.join(link)).unwrap();
        fs::hard_link(folder.join(file), folder.join(hard)).unwrap();
    }
}

#[test]
fn cli_no_output_takes_the_place_of_an_input_a_logbook_or_a_log() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    kept(folder);
    fs::write(folder.join("left.restore.toml"), "system = 1\n").unwrap();
    let files = ["a.db", "l.csv", "p.toml", "left.restore.toml"];
    let bytes = files.map(|name| fs::read(folder.join(name)).unwrap());
    let mut lines = Vec::new();
    for name in ["a.db", "a.link", "a.hard", "l.csv", "l.link", "l.hard"] {
        lines.extend([
            format!("trial --yes --logbook a.db --report {name}"),
            format!("trial --yes --logbook new.db --record {name}"),
            format!("logbook export --logbook a.db --json --out {name}"),
            format!("gains --logbook a.db --rehearsal --export ardupilot --out {name}"),
            format!("report --logbook a.db --out {name}"),
            format!("report l.csv --out {name}"),
            format!("plan --out {name}"),
            format!("export --to vehicle --logbook a.db --out {name}"),
            format!("identify l.csv --schedule {name}"),
            format!("inspect l.csv --report {name}"),
            format!("sim log --seed 2 --thrust 0.8 --out q.csv --truth {name}"),
            format!("manoeuvres read l.csv --report {name}"),
            format!("study --runs 1 --report {name}"),
            #[cfg(feature = "parquet")]
            format!("fleet l.csv --out {name}"),
        ]);
    }
    lines.extend(
        [
            "plan --plan p.toml --out p.toml",
            "trial --yes --plan p.toml --logbook new.db --report ./p.toml",
            "trial --yes --logbook new.db --record same.csv --report same.csv",
            "trial --yes --logbook new.db --report new.db",
            "trial --yes --logbook new.db --vehicle ros2:p.toml --report p.toml",
            "plan --out left.restore.toml",
            "sim log --seed 2 --thrust 0.8 --out l.csv",
        ]
        .map(str::to_owned),
    );
    for line in lines {
        let (code, told) = run(folder, &line);
        assert_eq!(code, Some(2), "{line}: {told}");
    }
    for (name, before) in files.iter().zip(bytes) {
        assert!(fs::read(folder.join(name)).unwrap() == before, "{name}");
    }
    for name in ["new.db", "same.csv", "q.csv", "fleet.parquet"] {
        assert!(!folder.join(name).exists(), "{name}");
    }
    // The log that is there already is no loss.
    assert_eq!(run(folder, "sim log --seed 1 --thrust 0.8 --out l.csv").0, Some(0));
}

#[test]
fn cli_a_page_says_which_page_it_takes_the_place_of() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (seed, name) in [("1", "one.csv"), ("2", "two.csv")] {
        let line = format!("sim log --seed {seed} --thrust 0.8 --out {name}");
        assert_eq!(run(folder, &line).0, Some(0));
    }
    assert!(!run(folder, "report one.csv --out page.html").1.contains("takes the place"));
    assert!(!run(folder, "report one.csv --out page.html").1.contains("takes the place"));
    let told = run(folder, "report two.csv --out page.html").1;
    assert!(told.contains("takes the place of") && told.contains("one.csv"), "{told}");
}

/// An export of a gain that is warned of is asked for twice.
#[test]
fn cli_a_gain_that_is_warned_of_is_exported_only_where_that_is_accepted() {
    let folder = tempfile::tempdir().unwrap();
    let schedule = "[[point]]\nsurge_speed_m_s = 1.0\na22_per_s = -1.0\nb2_per_s2 = 0.4\n\
                    covariance = [[0.01, 0, 0], [0, 0.09, 0], [0, 0, 0.0001]]\n";
    fs::write(folder.path().join("s.toml"), schedule).unwrap();
    let gains = |format| format!("gains --schedule s.toml --export {format} --out gains");
    let mut lines = ["json", "ardupilot", "ros2"].map(gains).to_vec();
    lines.push("export --to ros2_control --schedule s.toml --name b --out gains".into());
    // The vehicle file keeps how sure its model is.
    let (code, told) =
        run(folder.path(), "export --to vehicle --schedule s.toml --name b --out b.toml");
    assert_eq!(code, Some(0), "{told}");
    lines.push("export --to ros2_control --vehicle sim:b.toml --out gains".into());
    for line in lines {
        let (code, told) = run(folder.path(), &line);
        assert_eq!(code, Some(4), "{told}");
        assert!(told.contains("--accept") && told.contains("holds 0"), "{told}");
        assert!(!folder.path().join("gains").exists());
        let (code, told) = run(folder.path(), &(line + " --accept"));
        assert_eq!(code, Some(0), "{told}");
        fs::remove_file(folder.path().join("gains")).unwrap();
    }
}

/// Logs whose columns say nothing by their names, and files of somebody else: read or not, they are not written over.
#[test]
fn cli_what_is_no_earlier_output_of_the_same_kind_is_not_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    kept(folder);
    let long = "\"Series\";\"Time\";\"Value\"\n\"navigation.headingMagnetic\";\"2021-03-04T00:29:58.000+00:00\";0.7872\n";
    let page = "<!doctype html><title>The harbour</title>";
    // A logbook, a log and a document whose first byte was damaged: what they are is not seen any more.
    for (name, damaged) in [("a.db", "b.db"), ("l.csv", "d.csv"), ("p.toml", "d.toml")] {
        let mut bytes = fs::read(folder.join(name)).unwrap();
        bytes[0] ^= 1;
        fs::write(folder.join(damaged), &bytes).unwrap();
        for line in [
            format!("report --logbook a.db --out {damaged}"),
            format!("trial --yes --logbook new.db --report {damaged}"),
            format!("sim log --seed 3 --thrust 0.8 --out {damaged}"),
            #[cfg(feature = "parquet")]
            format!("fleet l.csv --out {damaged}"),
        ] {
            let (code, told) = run(folder, &line);
            assert_eq!(code, Some(2), "{line}: {told}");
        }
        assert!(fs::read(folder.join(damaged)).unwrap() == bytes, "{damaged}");
    }
    #[cfg(feature = "parquet")]
    assert_eq!(run(folder, "fleet l.csv --out p.toml").0, Some(2));
    let strange = [
        ("long.csv", long),
        ("abc.csv", "a,b,c\n0,1,2\n1,2,3\n2,3,4\n"),
        ("bare.csv", "0,1,2\n1,2,3\n"),
        ("lines.json", "{\"t\":0,\"yaw\":1}\n{\"t\":1,\"yaw\":1}\n"),
        ("packed.zip", "PK\u{3}\u{4}run.csv"),
        ("mine.html", page),
        ("mine.toml", "x = 1\n"),
        ("notes.md", "What seatrial said on Monday\n"),
    ];
    for (name, content) in strange {
        fs::write(folder.join(name), content).unwrap();
        for line in [
            format!("plan --thrust 0.8 --out {name}"),
            format!("trial --yes --logbook new.db --report {name}"),
            format!("trial --yes --logbook new.db --record {name}"),
            format!("gains --logbook a.db --rehearsal --export json --out {name}"),
            format!("report l.csv --out {name}"),
            format!("identify l.csv --schedule {name}"),
            format!("logbook export --logbook a.db --out {name}"),
        ] {
            let (code, told) = run(folder, &line);
            assert_eq!(code, Some(2), "{line}: {told}");
            assert!(told.contains("give another name"), "{line}: {told}");
        }
        assert_eq!(fs::read_to_string(folder.join(name)).unwrap(), content);
    }
    assert!(!folder.join("new.db").exists());
    // What was written here before is written again, and only by what wrote it.
    for again in [
        "plan --thrust 0.9 --out p.toml",
        "report l.csv --out page.html",
        "inspect l.csv --report page.html",
        "report l.csv --out page.html",
        "identify l.csv --schedule s.toml",
        "identify l.csv --rudder-lag 0.1 --schedule s.toml",
        "gains --schedule s.toml --export px4 --out g",
        "gains --schedule s.toml --zeta 0.8 --export px4 --out g",
    ] {
        let (code, told) = run(folder, again);
        assert_eq!(code, Some(0), "{again}: {told}");
    }
    for other in [
        "gains --schedule s.toml --export ros2 --out g",
        "plan --out s.toml",
        "plan --out page.html",
    ] {
        let (code, told) = run(folder, other);
        assert_eq!(code, Some(2), "{other}: {told}");
    }
}

/// A device has no end.
#[test]
fn cli_a_device_is_never_read() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    kept(folder);
    for (line, expected) in [
        ("report l.csv --out /dev/full", 6),
        ("report l.csv --out /dev/null", 0),
        ("identify /dev/zero", 2),
        ("inspect /dev/zero", 2),
        ("gains --schedule /dev/zero", 2),
        ("plan --plan /dev/zero", 2),
        ("turn --model /dev/zero", 2),
        ("trial --vehicle sim:/dev/zero --logbook n.db --yes", 2),
    ] {
        let (code, told) = run(folder, line);
        assert_eq!(code, Some(expected), "{line}: {told}");
    }
}

/// Names are bytes.
#[test]
fn cli_a_name_that_is_no_text_is_a_name() {
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    kept(folder);
    let name = std::ffi::OsStr::from_bytes(b"b\xff'd.csv");
    fs::copy(folder.join("l.csv"), folder.join(name)).unwrap();
    for verb in ["identify", "inspect"] {
        let ran = seatrial_dev::program().current_dir(folder).arg(verb).arg(name).output().unwrap();
        let told = text(&ran.stdout) + &String::from_utf8_lossy(&ran.stderr);
        assert_eq!(ran.status.code(), Some(0), "{told}");
    }
    #[cfg(feature = "parquet")]
    for pattern in ["*.csv", "[bl]*.csv", "**/*.csv"] {
        let out = format!("fleet-{}.parquet", pattern.len());
        let (code, told) = run(folder, &format!("fleet {pattern} --out {out} --json"));
        assert_eq!(code, Some(0), "{told}");
        assert!(told.contains("\"files\": 2"), "{pattern}: {told}");
    }
}

/// A pipe takes 64 kB; this one is full.
#[test]
fn io_a_trial_ends_though_nobody_reads_what_it_prints() {
    let folder = tempfile::tempdir().unwrap();
    let (_reader, mut full) = std::io::pipe().unwrap();
    std::io::Write::write_all(&mut full, &[b'x'; 1 << 16]).unwrap();
    let mut unread = seatrial_dev::program()
        .args(["trial", "--yes", "--json", "--logbook", "a.db"])
        .current_dir(folder.path())
        .stdout(full)
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let begun = std::time::Instant::now();
    let exit = loop {
        match unread.try_wait().unwrap() {
            Some(exit) => break exit,
            None if begun.elapsed().as_secs() > 120 => {
                unread.kill().unwrap();
                panic!("it waits for a reader");
            }
            None => std::thread::sleep(std::time::Duration::from_millis(100)),
        }
    };
    assert_eq!(exit.code(), Some(6));
    assert!(folder.path().join("a.db").exists());
}

/// A pipe that nobody opens keeps whoever writes to it waiting.
#[test]
fn io_a_trial_that_writes_to_a_pipe_without_a_reader_ends_when_asked() {
    for option in ["--report", "--record"] {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe.csv");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        let mut trial = seatrial_dev::program()
            .args(["trial", "--yes", "--logbook", "a.db", option, "pipe.csv"])
            .current_dir(folder.path())
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .unwrap();
        let pause = std::time::Duration::from_millis(100);
        let begun = std::time::Instant::now();
        // The logbook is opened after the recording.
        while option == "--report" && !folder.path().join("a.db").exists() {
            std::thread::sleep(pause);
        }
        std::thread::sleep(20 * pause);
        crate::signal::send(trial.id(), "TERM");
        let exit = loop {
            match trial.try_wait().unwrap() {
                Some(exit) => break exit,
                None if begun.elapsed().as_secs() > 60 => {
                    trial.kill().unwrap();
                    panic!("{option}: it waits for a reader");
                }
                None => std::thread::sleep(pause),
            }
        };
        assert_eq!(exit.code(), Some(6), "{option}");
    }
}
