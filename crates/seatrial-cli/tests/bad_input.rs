//! Bad logs: each with its own message, exit 3 where it cannot be read and 4 where it can but no
//! model can come of it.

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use seatrial_dev::{program_path, run, run_to_text, text};

fn inspect(content: &[u8], arguments: &[&str]) -> (i32, String, String) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("run.csv"), content).unwrap();
    run_to_text(folder.path(), &[&["inspect", "run.csv"], arguments].concat())
}

/// What an error says of a file, or of an option, has an end.
#[test]
fn cli_an_error_does_not_repeat_a_whole_file() {
    let folder = tempfile::tempdir().unwrap();
    let thrusts = vec!["0.5"; 1_000_000].join(", ");
    std::fs::write(folder.path().join("p.toml"), format!("thrusts = [{thrusts}]")).unwrap();
    let many = format!("0.5{}", ",0.5".repeat(20_000));
    for line in [
        &["plan", "--plan", "p.toml"][..],
        &["trial", "--plan", "p.toml"],
        &["plan", "--thrust", &many],
    ] {
        let (code, _, told) = run_to_text(folder.path(), line);
        assert!([2, 3].contains(&code), "{line:.60?}: {code}");
        assert!(told.len() < 20_000, "{line:.60?}: {}", told.len());
    }
}

/// The exit code of `identify` on the same log, which is that of `inspect`.
fn identify(content: &[u8], arguments: &[&str]) -> i32 {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("run.csv"), content).unwrap();
    let arguments = [&["identify", "run.csv"], arguments].concat();
    run_to_text(folder.path(), &arguments).0
}

/// A doublet and the heading that follows it, in the units given.
fn log(header: &str, rows: u32, scale: f64) -> String {
    let mut text = format!("{header}\n");
    let (mut heading, mut rate) = (1.0, 0.0);
    for k in 0..rows {
        let rudder = match k {
            40..80 => 0.26,
            80..120 => -0.26,
            _ => 0.0,
        };
        let _ = writeln!(text, "{},{},{}", f64::from(k) * 0.05, heading * scale, rudder * scale);
        rate += 0.05 * (rudder - rate);
        heading += 0.05 * rate;
    }
    text
}

/// What people have on their disks and take for a log: each is named for what it is, with what to do.
#[test]
fn cli_files_that_are_no_logs_are_named_for_what_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let steady: String = (0..600)
        .map(|k| {
            format!(
                "{},{},{}\n",
                0.1 * f64::from(k),
                90.0 + 0.1 * f64::from(k % 7),
                0.1 * f64::from(k % 5)
            )
        })
        .collect();
    let steady = format!("time_s,heading_deg,rudder_deg\n{steady}");
    let track = "record the rudder and the heading";
    for (name, content, says, does) in [
        (
            "track.gpx",
            &b"<?xml version='1.0'?>\n<gpx version='1.1'><trk/></gpx>"[..],
            "a GPX track",
            track,
        ),
        ("track.kml", b"<kml xmlns='http://www.opengis.net/kml/2.2'/>", "a KML track", track),
        ("photo.png", b"\x89PNG\r\n\x1a\n\0\0", "a picture (PNG)", "give the log itself"),
        ("photo.jpg", b"\xff\xd8\xff\xe0\0", "a picture (JPEG)", "give the log itself"),
        (
            "track.json",
            b"{\"type\": \"FeatureCollection\"}",
            "a document in JSON",
            "export the log as CSV",
        ),
        ("film.mp4", b"\0\0\0\x18ftypmp42", "a film", "give the log itself"),
        ("paper.pdf", b"%PDF-1.4\n", "a document (PDF)", "give the log itself"),
        ("log.zip", b"PK\x03\x04\0\0", "a zip archive", "unpack it, and give the log"),
        ("nothing.zip", b"PK\x05\x06\0\0", "an empty zip archive", "give the log itself"),
        (
            "budget.csv",
            b"date,product,price\n2024-05-01,rope,12.5\n",
            "a table without heading and rudder",
            "give the log of a vehicle",
        ),
        (
            "phyphox.csv",
            b"\"Time (s)\",\"Gyroscope x (rad/s)\",\"Gyroscope z (rad/s)\"\n0,0,0\n",
            "the log of a phone",
            "record the rudder beside the heading",
        ),
        (
            "phone.csv",
            b"time,seconds_elapsed,z,y,x\n0,0,1,2,3\n",
            "the log of a phone",
            "record the rudder beside the heading",
        ),
        (
            "compass.csv",
            b"time_s,heading_deg\n0,90\n",
            "this log cannot tell how the boat steers",
            "record the rudder beside the heading",
        ),
        (
            "copter.csv",
            b"time_s,roll_deg,yaw_deg,motor1\n0,0,90,1500\n",
            "no column for rudder",
            "record the rudder beside the heading",
        ),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        let output = run(&["identify", path.to_str().unwrap()]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{name}: {said}");
        assert!(said.contains(says) && said.contains(does), "{name}: {said}");
        assert_eq!(said.trim().lines().count(), 1, "{name}: {said}");
    }
    let path = folder.path().join("steady_course.csv");
    std::fs::write(&path, steady).unwrap();
    let output = run(&["identify", path.to_str().unwrap()]);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(4), "{said}");
    assert!(said.contains("Cause  No manoeuvre: the rudder hardly moved."), "{said}");
}

#[test]
fn cli_a_mistyped_kind_of_vehicle_lists_all_kinds() {
    let output = run(&["trial", "--vehicle", "mavlnk:udp:127.0.0.1:14550"]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    for kind in
        ["sim:FILE.toml", "mavlink:udp:HOST:PORT", "mavlink:serial:DEVICE:BAUD", "ros2:FILE.toml"]
    {
        assert!(said.contains(kind), "{kind}: {said}");
    }
}

#[test]
fn cli_unreadable_logs_say_what_is_wrong_and_exit_3() {
    for (content, says) in [
        (&b""[..], "is empty"),
        (b"t,yaw,rudder\n", "header and no samples"),
        (b"t,yaw,wheel\n0,0,0\n", "no column for rudder; found the columns `t`, `yaw`, `wheel`"),
        (
            b"t,yaw,heading,rudder\n0,0,0,0\n",
            "2 columns could be heading: `yaw`, `heading`; say which with --heading",
        ),
        (
            b"t,yaw,rudder\n0,0,0\n1,north,0\n",
            "line 3, column `yaw`: found \"north\", expected a number",
        ),
        (
            b"t,alpha,wheel,speed\n0,0,0,1\n",
            "say which with --heading NAME; 1 more: no column for rudder: --rudder NAME",
        ),
        (
            b"t,yaw,rudder\n0,0,0\n1,north,0\n2,0,0\n3,east,0\n",
            "--drop-invalid; 1 more row is damaged",
        ),
        (
            b"t,yaw,rudder\n0,0,0\n1,NaN,0\n",
            "line 3, column `yaw`: found NaN, expected a finite number",
        ),
        (
            b"t,yaw,rudder\n0,0,0\n1,0,0\n0.5,0,0\n",
            "line 4, column `t`: time goes back from 1 s to 0.5 s",
        ),
        (b"t,yaw,rudder\n0,0\n1,0,0\n", "line 2: found 2 cells, expected 3"),
        (
            b"\x1f\x8b\x08\0",
            "is packed by gzip: unpack it, or give it on standard input: gzip -dc FILE |",
        ),
        (b"\x28\xb5\x2f\xfd", "zstd -dc FILE | seatrial"),
        (b"s: T    0    0 4 m_heading rad\n", "cache file of a Slocum glider"),
        (b"\x7fELF\x02\x01\x01\x00", "byte 0 is 0x7f"),
        (b"PAR1 and nothing more", "Parquet file is truncated or damaged"),
    ] {
        let (exit, stdout, stderr) = inspect(content, &[]);
        assert_eq!(exit, 3, "{stderr}");
        assert_eq!(stdout, "");
        assert!(stderr.contains("seatrial: run.csv: "), "{stderr}");
        assert!(stderr.contains(says), "{stderr}");
    }
}

#[test]
fn cli_folders_and_missing_files_exit_3() {
    let folder = tempfile::tempdir().unwrap();
    let (exit, _, stderr) = run_to_text(folder.path(), &["inspect", "."]);
    assert_eq!(exit, 3);
    assert!(stderr.contains("is a folder; expected a log file"), "{stderr}");
    let (exit, _, stderr) = run_to_text(folder.path(), &["inspect", "nowhere.csv"]);
    assert_eq!(exit, 3);
    assert!(stderr.contains("nowhere.csv: cannot be opened: No such file"), "{stderr}");
}

/// Root may read every file of its own, but not a kernel setting that is write-only.
#[cfg(unix)]
#[test]
fn cli_a_log_without_permission_exits_3() {
    use std::os::unix::fs::PermissionsExt;

    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("secret.csv");
    std::fs::write(&own, log("t,yaw,rudder", 300, 1.0)).unwrap();
    std::fs::set_permissions(&own, std::fs::Permissions::from_mode(0o000)).unwrap();
    let kernel = Path::new("/proc/sys/vm/drop_caches");
    let denied = [own.as_path(), kernel].into_iter().find(|path| {
        std::fs::File::open(path)
            .is_err_and(|error| error.kind() == std::io::ErrorKind::PermissionDenied)
    });
    let Some(denied) = denied else {
        eprintln!("skipped: this user may read everything");
        return;
    };
    let (exit, _, stderr) = run_to_text(folder.path(), &["inspect", denied.to_str().unwrap()]);
    assert_eq!(exit, 3);
    assert!(stderr.contains("cannot be opened: Permission denied"), "{stderr}");
    assert!(stderr.contains("give yourself the right to read it"), "{stderr}");
}

#[test]
fn cli_readable_logs_that_give_no_model_exit_4_with_the_reason() {
    let still_rudder: String = log("t,yaw,rudder", 300, 1.0)
        .lines()
        .map(|line| match line.rsplit_once(',') {
            Some((rest, "rudder")) => format!("{rest},rudder\n"),
            Some((rest, _)) => format!("{rest},0.1\n"),
            None => String::new(),
        })
        .collect();
    let mut still_heading = String::from("t,yaw,rudder\n");
    for k in 0..300 {
        let _ = writeln!(still_heading, "{},1.5,{}", f64::from(k) * 0.05, k / 40 % 2);
    }
    for (content, kind) in [
        (
            "t,yaw,rudder\n0,0,0.1\n".to_string(),
            serde_json::json!({"code": "too_few_samples", "of": null}),
        ),
        (still_rudder, serde_json::json!({"code": "constant", "of": "rudder"})),
        (still_heading, serde_json::json!({"code": "constant", "of": "heading"})),
    ] {
        let (exit, stdout, stderr) = inspect(content.as_bytes(), &["--json"]);
        assert_eq!(exit, 4, "{stderr}");
        let document: serde_json::Value = serde_json::from_str(&stdout).unwrap();
        assert_eq!(document["schema"], "seatrial.inspection.v1");
        assert_eq!(document["verdict"]["accepted"], false);
        let reason = &document["verdict"]["reasons"][0];
        assert_eq!(serde_json::json!({"code": reason["code"], "of": reason["of"]}), kind);
    }
}

#[test]
fn cli_units_are_said_and_doubts_are_warned_of() {
    let plain = log("t,yaw,rudder", 300, 1.0);
    let (exit, _, stderr) = inspect(plain.as_bytes(), &[]);
    assert_eq!(exit, identify(plain.as_bytes(), &[]));
    assert!(stderr.contains("heading from yaw [rad, assumed]"), "{stderr}");
    assert!(!stderr.contains("warning"), "{stderr}");

    let degrees = 1_f64.to_degrees();
    let unlabelled = log("t,yaw,rudder", 300, degrees);
    let (exit, stdout, stderr) = inspect(unlabelled.as_bytes(), &["--json"]);
    assert_eq!(exit, identify(unlabelled.as_bytes(), &[]));
    assert!(stderr.contains("warning: heading has no unit and is taken as deg"), "{stderr}");
    let document: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(document["source"]["warnings"].as_array().unwrap().len(), 2);
    let amplitude_rad = document["manoeuvres"][0]["amplitude_rad"].as_f64().unwrap();
    // Degrees and back.
    assert!((amplitude_rad - 0.26).abs() < 1e-12);

    let labelled = log("time_s,yaw_rad,rudder_rad", 300, degrees);
    let (_, _, stderr) = inspect(labelled.as_bytes(), &[]);
    assert!(stderr.contains("rudder is given as rad but reaches 14.8"), "{stderr}");
    let chosen = ["--unit", "heading=deg", "--unit", "rudder=deg"];
    let (exit, _, stderr) = inspect(labelled.as_bytes(), &chosen);
    assert_eq!(exit, identify(labelled.as_bytes(), &chosen));
    assert!(!stderr.contains("warning"), "{stderr}");
}

#[test]
fn cli_invalid_rows_are_left_out_when_asked() {
    let content = b"t,yaw,rudder\n0,0,0\n1,north,0\n2,0.1,0.2\n";
    let (exit, stdout, stderr) = inspect(content, &["--drop-invalid", "--json"]);
    assert_eq!(exit, 4);
    assert!(stderr.contains("warning: 1 of 3 rows are invalid and are left out"), "{stderr}");
    let document: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(document["source"]["rows"]["invalid"], 1);
    assert_eq!(document["source"]["samples_read"], 2);
}

#[test]
fn cli_options_that_make_no_sense_exit_2() {
    for arguments in [
        ["--unit", "heading"],
        ["--unit", "heading=furlong"],
        ["--unit", "course=deg"],
        ["--rudder-range-deg", "0"],
    ] {
        let (exit, _, stderr) = inspect(log("t,yaw,rudder", 300, 1.0).as_bytes(), &arguments);
        assert_eq!(exit, 2, "{stderr}");
    }
}

/// Once more than 500,000 samples were read memory no longer grows: what holds for these 1.3 million
/// rows holds for a file of any length.
#[cfg(unix)]
#[test]
fn cli_a_long_log_needs_less_than_300_mb() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::from("t,yaw,rudder,speed\n");
    for k in 0..1_300_000_u32 {
        let rudder = if k / 40 % 2 == 0 { 0.2 } else { -0.2 };
        let _ = writeln!(text, "{}.{:02},0.1,{rudder},1", k / 20, k % 20 * 5);
    }
    std::fs::write(folder.path().join("long.csv"), text).unwrap();
    // All of the address space, of which resident memory is a part.
    let limited = format!("ulimit -v 300000; exec {} inspect long.csv", program_path().display());
    let output =
        Command::new("sh").args(["-c", &limited]).current_dir(folder.path()).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(stderr.contains("of 1300000 samples the 500000"), "{stderr}");
    // Readable; the heading of this log is constant.
    assert_eq!(output.status.code(), Some(4), "{stderr}");
}

/// Who may write a file may not set any parameter of a vehicle with it.
#[test]
fn cli_a_backup_with_parameters_that_no_trial_changes_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let backup = folder.path().join("seatrial.restore.toml");
    let text = "system = 1\n[parameters.ARMING_CHECK]\nnumber = 0.0\nkind = 9\n";
    std::fs::write(&backup, text).unwrap();
    // Nobody is there: it is refused before anybody is asked for.
    let arguments = [
        "vehicle",
        "restore",
        "--yes",
        backup.to_str().unwrap(),
        "--vehicle",
        "mavlink:udpout:127.0.0.1:9",
    ];
    let (exit, _, told) = run_to_text(folder.path(), &arguments);
    assert_eq!(exit, 3, "{told}");
    assert!(told.contains("never change ARMING_CHECK"), "{told}");
    assert_eq!(std::fs::read_to_string(&backup).unwrap(), text);
    for wrong in [
        "[parameters.FS_TIMEOUT]\nnumber = nan\nkind = 9\n",
        "[parameters.FS_TIMEOUT]\nnumber = inf\nkind = 9\n",
        "[parameters.FS_ACTION]\nnumber = -3.0\nkind = 2\n",
        "[parameters.ATC_STR_RAT_FF]\nnumber = 1e9\nkind = 9\n",
        "[parameters.FS_TIMEOUT]\nnumber = 5.0\nkind = 77\n",
        "mode = 4294967295\n",
    ] {
        std::fs::write(&backup, format!("system = 1\n{wrong}")).unwrap();
        let (exit, _, told) = run_to_text(folder.path(), &arguments);
        assert_eq!(exit, 3, "{wrong}: {told}");
        assert!(told.contains("no autopilot had"), "{wrong}: {told}");
    }
}
