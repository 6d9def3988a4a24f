//! `seatrial paper` at the process boundary.

use std::fs;
use std::path::Path;

use seatrial_dev::program;
use serde_json::Value;

fn paper(out: &Path) -> Value {
    let run = program().args(["paper", "--json", "--out"]).arg(out).output().unwrap();
    assert!(run.status.success(), "{run:?}");
    serde_json::from_slice(&run.stdout).unwrap()
}

#[test]
fn cli_paper_recreates_tables_ii_iii_and_v_by_simulated_trials() {
    let folder = tempfile::tempdir().unwrap();
    let first = folder.path().join("first");
    let document = paper(&first);
    let tables = document["recreated"].as_array().unwrap();
    let sizes: Vec<(&str, usize)> = tables
        .iter()
        .map(|t| (t["table"].as_str().unwrap(), t["rows"].as_array().unwrap().len()))
        .collect();
    assert_eq!(sizes, [("II", 5), ("III", 5), ("V", 6)]);

    let (mut inside, mut all) = (0, 0);
    for row in tables.iter().flat_map(|t| t["rows"].as_array().unwrap()) {
        assert!(row["r2"].as_f64().unwrap() > 0.6, "{row}");
        let Some(intervals) = row["interval_95"].as_array() else {
            continue;
        };
        for (name, interval) in ["a22_per_s", "b2_per_s2", "c0_rad_per_s2"].iter().zip(intervals) {
            let truth = row["truth"][name].as_f64().unwrap();
            let bound = |side: usize| interval[side].as_f64().unwrap();
            all += 1;
            inside += u32::from(bound(0) <= truth && truth <= bound(1));
        }
    }
    assert_eq!(all, 33);
    // 95 % intervals; the seeds are fixed.
    assert!(10 * inside >= 9 * all, "{inside} of {all}");

    let second = folder.path().join("second");
    paper(&second);
    for name in ["paper.md", "paper.csv", "recreated.csv", "paper.json"] {
        assert_eq!(
            fs::read(first.join(name)).unwrap(),
            fs::read(second.join(name)).unwrap(),
            "{name}"
        );
    }
    let page = fs::read_to_string(first.join("paper.md")).unwrap();
    assert!(page.contains("## Tables II, III and V re-created"));
}
