//! Logs after public bug reports of neighbouring programs: each has its known model, or is refused with the option that settles it.

use seatrial_dev::{data, run_to_text};
use serde_json::Value;

/// What `identify` must say.
enum Right {
    /// T and K, each to this share.
    Model(f64, f64, f64),
    /// The code of the first reason, and what it is of.
    Refused([&'static str; 2]),
    /// What stands in the error of the reader.
    Unreadable(&'static str),
}
use Right::{Model, Refused, Unreadable};

/// Shares: noise of 0.2 to 0.3 deg leaves 2 %; times of days with six decimals 4 %.
const CASES: [(&str, Right); 20] = [
    ("01_time_100ns_ticks.csv", Model(2.0, 0.6, 0.02)),
    ("02_heading_tenths.csv", Unreadable("ddeg")),
    ("03_rudder_order_slow_gear.csv", Model(10.0, 0.1, 0.02)),
    ("03_truth_measured_rudder.csv", Model(10.0, 0.1, 0.02)),
    ("05_rowcount_time_derived_rate.csv", Refused(["unit_doubtful", "time"])),
    ("06_season1_rudder_deg.csv", Model(2.0, 0.6, 0.02)),
    // Per full rudder, whose angle is not known.
    ("06_season2_servo_pwm.csv", Model(2.0, 0.366, 0.02)),
    ("08_opencpn_vdr.csv", Model(3.0, 0.5, 0.02)),
    ("09_nmea_10hz_rmc_1hz.nmea", Model(3.0, 0.5, 0.02)),
    ("10_ydwg.raw", Model(2.0, 0.6, 0.02)),
    ("10c_ikonvert.log", Model(2.0, 0.6, 0.02)),
    ("11_ros_secs_nsecs.csv", Model(2.0, 0.6, 0.02)),
    ("12_outer_merge_empty_cells.csv", Model(2.0, 0.6, 0.02)),
    ("13_utc_in_brackets_rot_degmin.csv", Model(8.0, 0.4, 0.02)),
    ("14_expedition_sparse.csv", Model(2.0, 0.6, 0.04)),
    ("16_one_hz_from_zero.csv", Model(25.0, 0.06, 0.02)),
    ("16_truth_from_100.csv", Model(25.0, 0.06, 0.02)),
    ("18_grafana_long.csv", Model(2.0, 0.6, 0.02)),
    ("19_two_talkers.log", Model(3.0, 0.5, 0.02)),
    ("21_hhmmss_number.csv", Model(2.0, 0.6, 0.02)),
];

#[test]
fn cli_every_reported_case_is_identified_or_refused_by_name() {
    let Some(cases) = data("cases") else { return };
    for (name, right) in CASES {
        let (exit, said, error) = run_to_text(&cases, &["identify", name, "--json"]);
        if let Unreadable(option) = right {
            assert_eq!(exit, 3, "{name}");
            assert!(error.contains(option), "{name}: {error}");
            continue;
        }
        let document: Value =
            serde_json::from_str(&said).unwrap_or_else(|_| panic!("{name}: {error}"));
        let outcome = document["verdict"]["outcome"].as_str().unwrap();
        let (t_s, k_per_s, share) = match right {
            Model(t_s, k_per_s, share) => (t_s, k_per_s, share),
            Refused([code, of]) => {
                assert_eq!(outcome, "do_not_use", "{name}");
                let reason = &document["verdict"]["reasons"][0];
                assert_eq!((&reason["code"], &reason["of"]), (&code.into(), &of.into()), "{name}");
                continue;
            }
            Unreadable(_) => unreachable!("looked at above"),
        };
        let is_accepted = matches!(outcome, "use" | "use_with_care");
        assert!(is_accepted, "{name}: {outcome}");
        let found = &document["nomoto"];
        for (key, truth) in [("t_s", t_s), ("k_per_s", k_per_s)] {
            let found = found[key].as_f64().unwrap();
            assert!((found / truth - 1.0).abs() < share, "{name}: {key} {found}");
        }
    }
}

/// Damping that grows with the turn rate: a short and a long record of one ship have one answer, whose damping is that of output error on
/// each; b2 is that of the steady turn, where output error of first order has the mean of all turns, 5 to 8 % more.
#[test]
fn cli_growing_damping_has_one_answer() {
    let Some(cases) = data("cases") else { return };
    let found =
        [("15_cubic_damping_zigzag.csv", -0.509), ("15b_cubic_damping_zigzag_long.csv", -0.528)]
            .map(|(name, a22_per_s)| {
                let (_, said, error) = run_to_text(&cases, &["identify", name, "--json"]);
                let document: Value =
                    serde_json::from_str(&said).unwrap_or_else(|_| panic!("{error}"));
                let refined = &document["refined"];
                let interval = &refined["interval_95"]["a22_per_s"];
                let [low, high] = [0, 1].map(|end| interval[end].as_f64().unwrap());
                assert!(low < a22_per_s && a22_per_s < high, "{name}: {low} to {high}");
                ["a22_per_s", "b2_per_s2"].map(|key| refined[key].as_f64().unwrap())
            });
    let [short, long] = found;
    for (one, other) in short.iter().zip(long) {
        // The short record has half as many turns.
        assert!((one / other - 1.0).abs() < 0.02, "{short:?} {long:?}");
    }
}

/// A slow gear is told with its rate, 2.35 deg/s in truth, and the interval holds the vehicle behind it.
#[test]
fn cli_the_rate_of_a_slow_gear_is_told() {
    let Some(cases) = data("cases") else { return };
    let log = "03_rudder_order_slow_gear.csv";
    let (_, said, error) = run_to_text(&cases, &["identify", log, "--verbose"]);
    assert!(said.contains("rate-limited steering gear"), "{said}{error}");
    let rate = said.split("moves at most ").nth(1).unwrap();
    let rate: f64 = rate.split(' ').next().unwrap().parse().unwrap();
    assert!((rate / 2.35 - 1.0).abs() < 0.01, "{rate}");
    let (_, said, _) = run_to_text(&cases, &["identify", log, "--json"]);
    let document: Value = serde_json::from_str(&said).unwrap();
    for (key, truth) in [("a22_per_s", -0.1), ("b2_per_s2", 0.01)] {
        let interval = &document["refined"]["interval_95"][key];
        let [low, high] = [0, 1].map(|end| interval[end].as_f64().unwrap());
        assert!(low < truth && truth < high, "{key} {low} to {high}");
    }
}

/// Advance, transfer and tactical diameter of MARIN's circle, m: positions on a sphere in the place of the ellipsoid differ by 2 m.
#[test]
fn cli_a_turning_circle_is_read_from_positions() {
    let Some(cases) = data("cases") else { return };
    for name in [
        "04_turning_circle_latlon.csv",
        "04b_turning_circle_minus999.csv",
        "04c_turning_circle_one_blank.csv",
        "04_truth_positions_shifted.csv",
    ] {
        let (exit, said, error) = run_to_text(&cases, &["manoeuvres", "read", name, "--json"]);
        assert_eq!(exit, 0, "{name}: {error}");
        let document: Value = serde_json::from_str(&said).unwrap();
        let indices = document["indices"].as_array().unwrap();
        for (figure, truth_m) in
            [("advance", 948.0), ("transfer", 385.0), ("tactical diameter", 982.0)]
        {
            let found = indices.iter().find(|index| index["name"] == figure);
            let found_m = found.unwrap()["value"].as_f64().unwrap();
            assert!((found_m - truth_m).abs() < 2.0, "{name}: {figure} {found_m}");
        }
    }
}

#[test]
fn cli_a_rudder_in_two_units_is_not_compared() {
    let Some(cases) = data("cases") else { return };
    let logs = ["06_season1_rudder_deg.csv", "06_season2_servo_pwm.csv"];
    let (exit, said, error) = run_to_text(&cases, &["health", logs[0], logs[1]]);
    assert_eq!(exit, 4, "{said}{error}");
    assert!(said.contains("CANNOT TELL") && said.contains("--rudder-range-deg"), "{said}");
}
