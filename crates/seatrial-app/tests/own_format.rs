//! The log format of the program in examples/extending, through `fleet`. That program is built without Parquet.

use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::path::Path;

use seatrial_app::fleet;

use crate::fleet::run;

#[path = "../../../examples/extending/src/helm.rs"]
mod helm;

/// A recording of the made-up autopilot.
fn write_helm(path: &Path, seed: u64) {
    let mut text = "HELMLOG 1\n".to_owned();
    let tenths = |angle_rad: f64| (10.0 * angle_rad.to_degrees()).round();
    for sample in run(seed) {
        let milliseconds = (1000.0 * sample.time_s).round();
        let heading = tenths(sample.heading_rad.rem_euclid(std::f64::consts::TAU));
        let to_port = -tenths(sample.rudder_rad);
        writeln!(text, "{milliseconds} SERVO {to_port}").unwrap();
        let rate = tenths(sample.yaw_rate_rad_s.unwrap_or(0.0));
        writeln!(text, "{milliseconds} COMPASS {heading:04} {rate}").unwrap();
    }
    std::fs::write(path, text).unwrap();
}

fn work_through(logs: &[String], table: &Path) -> fleet::Summary {
    let mut options = fleet::Options::default();
    options.channels.formats = helm::formats();
    let job = fleet::Job {
        sources: fleet::find(logs, table).unwrap().sources,
        options,
        out: table.to_path_buf(),
        workers: 1,
        resume: false,
    };
    job.run(|_| ControlFlow::Continue(())).unwrap().unwrap()
}

#[test]
fn io_a_fleet_reads_an_own_format_beside_the_built_in_ones() {
    let folder = tempfile::tempdir().unwrap();
    write_helm(&folder.path().join("own.log"), 1);
    std::fs::write(folder.path().join("bad.log"), "HELMLOG 9\n").unwrap();
    let rows: Vec<_> = run(2).into_iter().map(Into::into).collect();
    let csv = std::fs::File::create(folder.path().join("usual.csv")).unwrap();
    seatrial_logs::write_csv(csv, &rows).unwrap();

    let logs = [folder.path().display().to_string()];
    let mut options = fleet::Options::default();
    options.channels.formats = helm::formats();
    let table = folder.path().join("table.parquet");
    let rows: Vec<_> = fleet::find(&logs, &table)
        .unwrap()
        .sources
        .iter()
        .flat_map(|source| fleet::work_on(source, &options))
        .flat_map(|entry| entry.rows)
        .collect();
    assert_eq!(rows[0].error.as_deref(), Some("damaged"));
    let said = rows[0].error_text.as_deref().unwrap();
    assert!(said.contains("found HELMLOG 9"), "{said}");
    for (row, format) in rows[1..].iter().zip(["helm", "helm", "csv", "csv"]) {
        assert_eq!(row.format.as_deref(), Some(format));
        assert_eq!(row.error, None);
    }
    assert_eq!(rows.len(), 5);
    let summary = work_through(&logs, &table);
    assert_eq!(summary.manoeuvres, 4);
}
