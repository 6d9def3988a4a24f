//! Logs that are opened in the page.

use seatrial_dev::program;
use serde_json::json;

use super::server::Server;

#[test]
fn cli_a_log_is_read_and_a_large_one_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("run.csv");
    let made = program().args(["sim", "log", "--seed", "1", "--out"]).arg(&log).output().unwrap();
    assert!(made.status.success());
    let server = Server::start(folder.path(), &["--largest-log", "1"]);
    let log = std::fs::read(log).unwrap();
    let (status, found) =
        server.ask("POST", "/logs/identify?name=run.csv").bytes(log.clone()).send();
    assert_eq!(status, 200, "{found}");
    assert_eq!(found["document"]["schema"], "seatrial.identification.v1");
    assert_eq!(found["document"]["source"]["path"], "run.csv");
    let rows = found["series"]["time_s"].as_array().unwrap().len();
    for column in ["heading_rad", "surge_speed_m_s"] {
        let values = found["series"][column].as_array().unwrap();
        assert_eq!(values.len(), rows, "{column}");
        assert!(values[100].is_number(), "{column}");
    }
    let (status, found) = server.ask("POST", "/logs/inspect?name=run.csv").bytes(log).send();
    assert_eq!((status, &found["document"]["schema"]), (200, &json!("seatrial.inspection.v1")));

    let (status, refused) =
        server.ask("POST", "/logs/identify").bytes(b"not a log".to_vec()).send();
    assert_eq!((status, &refused["code"]), (422, &json!("log_refused")));
    let said = refused["message"].as_str().unwrap();
    assert!(!said.contains("/tmp"), "no path of the server: {said}");
    let (status, refused) =
        server.ask("POST", "/logs/identify").bytes(vec![b'1'; 1_000_001]).send();
    assert_eq!((status, &refused["code"]), (413, &json!("too_large")));
}

/// A Slocum log needs a list of sensors, which is sent before it: then the answer is that of the terminal.
#[test]
fn cli_a_slocum_log_is_answered_as_in_the_terminal() {
    let Some(data) = seatrial_dev::data("native/slocum") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let name = "amadeus-2014-204-05-000.dbd";
    let log = data.join(name);
    let identify = || {
        let path = format!("/logs/identify?name={name}");
        let bytes = std::fs::read(&log).unwrap();
        server.ask("POST", &path).bytes(bytes).send()
    };
    let (status, refused) = identify();
    assert_eq!(status, 422, "{refused}");
    let said = refused["message"].as_str().unwrap();
    assert!(said.contains("choose it together with the log"), "{said}");
    for list in std::fs::read_dir(data.join("cac")).unwrap() {
        let list = list.unwrap();
        let name = list.file_name().into_string().unwrap();
        let bytes = std::fs::read(list.path()).unwrap();
        let path = format!("/logs/sensor-list?name={name}");
        assert_eq!(server.ask("POST", &path).bytes(bytes).send().0, 204);
    }
    let refused = server.ask("POST", "/logs/sensor-list?name=..%2Fa.cac");
    assert_eq!(refused.bytes(b"x".to_vec()).send().0, 422);
    let (status, found) = identify();
    assert_eq!(status, 200, "{found}");
    let terminal = program().args(["identify", "--json"]).arg(&log).output();
    let terminal: serde_json::Value = serde_json::from_slice(&terminal.unwrap().stdout).unwrap();
    assert_eq!(found["document"]["verdict"]["outcome"], terminal["verdict"]["outcome"]);
    assert_eq!(
        found["document"]["verdict"]["reasons"][0]["code"],
        terminal["verdict"]["reasons"][0]["code"]
    );
}

/// As the command does with options: columns, units and the rudder's range.
#[test]
fn cli_a_log_with_names_of_its_own_is_read_as_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let seatrial = |arguments: &[&str]| {
        let mut command = program();
        command.args(arguments).current_dir(folder.path());
        command.output().unwrap()
    };
    assert!(seatrial(&["sim", "log", "--seed", "1", "--out", "run.csv"]).status.success());
    let log = std::fs::read_to_string(folder.path().join("run.csv")).unwrap();
    let (head, rows) = log.split_once('\n').unwrap();
    let head = head.replace("heading_rad", "alpha").replace("rudder_rad", "beta");
    let log = format!("{head}\n{rows}");
    std::fs::write(folder.path().join("odd.csv"), &log).unwrap();

    let server = Server::start(folder.path(), &[]);
    let identify = |query: &str| {
        server
            .ask("POST", &format!("/logs/identify?name=odd.csv{query}"))
            .bytes(log.clone().into_bytes())
            .send()
    };
    let (status, refused) = identify("");
    assert_eq!((status, &refused["code"]), (422, &json!("log_refused")));
    let said = refused["message"].as_str().unwrap();
    assert!(said.contains("rudder") && said.contains("`beta`"), "{said}");
    let (status, refused) = identify("&heading=alpha&rudder=beta&units=heading=furlong");
    assert_eq!(status, 422);
    assert!(refused["message"].as_str().unwrap().contains("furlong"), "{refused}");

    let request =
        "&heading=alpha&rudder=beta&units=heading=rad,rudder=fraction&rudder_range_deg=57.3";
    let (status, found) = identify(request);
    assert_eq!(status, 200, "{found}");
    let output = seatrial(&[
        "--json",
        "identify",
        "odd.csv",
        "--heading",
        "alpha",
        "--rudder",
        "beta",
        "--unit",
        "heading=rad",
        "--unit",
        "rudder=fraction",
        "--rudder-range-deg",
        "57.3",
    ]);
    let same: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["document"], same);
    let (status, found) = server
        .ask("POST", "/logs/inspect?heading=alpha&rudder=beta&units=heading=rad,rudder=rad")
        .bytes(log.clone().into_bytes())
        .send();
    assert_eq!(status, 200, "{found}");
    assert!(found["series"]["heading_rad"][0].is_number());
}

/// Where latitude and longitude are known, the track is had for charts; it is the way that the log tells.
#[test]
fn cli_a_log_with_coordinates_gives_its_track() {
    let folder = tempfile::tempdir().unwrap();
    let made = program()
        .args(["sim", "log", "--seed", "1", "--out", "run.csv"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(made.status.success());
    let log = std::fs::read_to_string(folder.path().join("run.csv")).unwrap();
    let head: Vec<&str> = log.lines().next().unwrap().split(',').collect();
    let at = |name: &str| head.iter().position(|column| *column == name).unwrap();
    let (north, east) = (at("north_m"), at("east_m"));
    let minute_m = 1852.0 * 60.0;
    let row = |line: &str| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        let [north_m, east_m] = [north, east].map(|k| cells[k].parse::<f64>().unwrap());
        let latitude = 54.0 + north_m / minute_m;
        let longitude = 10.0 + east_m / (minute_m * 54_f64.to_radians().cos());
        (cells[north], cells[east]) = (format!("{latitude:.9}"), format!("{longitude:.9}"));
        cells.join(",")
    };
    let rows: Vec<String> = log.lines().skip(1).map(row).collect();
    let head = log.lines().next().unwrap();
    let head = head.replace("north_m", "latitude").replace("east_m", "longitude");
    let located = format!("{head}\n{}\n", rows.join("\n"));

    let server = Server::start(folder.path(), &[]);
    let ask = |what: &str, log: &str| {
        let request = server.ask("POST", &format!("/logs/{what}?name=run.csv"));
        request.bytes(log.as_bytes().to_vec())
    };
    let (status, found) = ask("identify", &located).send();
    assert_eq!((status, &found["is_located"]), (200, &json!(true)), "{found}");
    let (status, gpx) = ask("track/gpx", &located).send_for_bytes();
    let gpx = String::from_utf8(gpx).unwrap();
    assert_eq!(status, 200, "{gpx}");
    let points: Vec<&str> = gpx.lines().filter(|line| line.starts_with("<trkpt")).collect();
    // 225 s of log, a point a second.
    assert!((220..=226).contains(&points.len()), "{}", points.len());
    let last = rows.last().unwrap().split(',').nth(north).unwrap();
    let shown = points.last().unwrap().split('"').nth(1).unwrap();
    let [last, shown] = [last, shown].map(|text| text.parse::<f64>().unwrap());
    // Less than a second of way at 2.2 m/s.
    assert!((last - shown).abs() * minute_m < 2.2, "{last} {shown}");
    assert_eq!(ask("track/kml", &located).send_for_bytes().0, 200);
    let (status, refused) = ask("track/gpx", &log).send();
    assert_eq!((status, &refused["code"]), (422, &json!("no_track")));

    // The terminal writes the same.
    std::fs::write(folder.path().join("located.csv"), &located).unwrap();
    let inspect = |log: &str, track: &str| {
        let line = ["inspect", log, "--track", track];
        program().args(line).current_dir(folder.path()).output().unwrap()
    };
    let written = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(inspect("located.csv", "track.gpx").status.success());
    assert_eq!(written("track.gpx"), gpx);
    assert!(inspect("located.csv", "track.KML").status.success());
    assert!(written("track.KML").contains("<LineString>"));
    for (log, track, code, why) in [
        ("run.csv", "none.gpx", 3, "no latitude and longitude"),
        ("located.csv", "track.txt", 2, ".gpx or .kml"),
    ] {
        let refused = inspect(log, track);
        let said = String::from_utf8(refused.stderr).unwrap();
        assert_eq!(refused.status.code(), Some(code), "{said}");
        assert!(said.contains(why), "{said}");
        assert!(!folder.path().join(track).exists());
    }
}
