//! Exported gains and limits: their derivation, and every format read back by a parser that is not ours.

use std::collections::BTreeMap;
use std::process::Command;

use seatrial::GainAllowance;
use seatrial::gains::export::{OperatingPoint, Schedule, VehicleType, ardupilot, px4};
use seatrial_core::{SchedulePoint, YawModel};
use yaml_rust2::{Yaml, YamlLoader};

const ZETA: f64 = std::f64::consts::FRAC_1_SQRT_2;
const TYPES: [VehicleType; 2] = [VehicleType::Surface, VehicleType::Underwater];

fn point(thrust: Option<f64>, speed: Option<f64>, theta: [f64; 3]) -> SchedulePoint<f64> {
    SchedulePoint { thrust, surge_speed_m_s: speed, model: YawModel::from_theta(theta) }
}

/// Numbers that are easy by hand: alpha = 1/s, |b2| limit = 0.5 rad/s^2, |C0| = 0.1 rad/s^2.
fn easy(speed: Option<f64>) -> OperatingPoint {
    OperatingPoint {
        source: "log\n*/ # of\ta boat".into(),
        at: point(Some(0.5), speed, [-1.0, -2.0, 0.1]),
        damping_ratio: ZETA,
        full_rudder_rad: 0.25,
        seen_rudder_rad: Some(0.25),
        allowance: GainAllowance::default(),
        covariance: None,
        notes: Vec::new(),
    }
}

/// Models whose gains allow for nothing: (57).
fn for_nothing(models: &[SchedulePoint<f64>]) -> Vec<(SchedulePoint<f64>, GainAllowance)> {
    let models = models.iter();
    models.map(|model| (*model, GainAllowance::default())).collect()
}

fn named(parameters: Vec<seatrial::gains::export::Parameter>) -> BTreeMap<&'static str, f64> {
    parameters.into_iter().map(|p| (p.name, p.value)).collect()
}

fn assert_all(found: &BTreeMap<&str, f64>, expected: &[(&str, f64)]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (name, value) in expected {
        // A few roundings.
        let error = (found[name] - value).abs();
        assert!(error <= 1e-12 * value.abs(), "{name} {} {value}", found[name]);
    }
}

/// alpha = 1, w^2 = 1/2, p = 1/10, x^2 - 0.6 x + 0.055 = 0, r_max = 0.5 - 0.1.
#[test]
fn exact_parameters_by_hand() {
    let x = 0.3 - 0.035_f64.sqrt();
    // At 2 m/s Rover halves the steering, so that B = 0.25.
    assert_all(
        &named(ardupilot::parameters(&easy(Some(2.0)), VehicleType::Surface)),
        &[
            ("MOT_SPD_SCA_BASE", 1.0),
            ("ATC_STR_RAT_FF", 4.0),
            ("ATC_STR_RAT_P", 0.4),
            ("ATC_STR_RAT_I", 4.0 * x),
            ("ATC_STR_RAT_D", 0.0),
            ("ATC_STR_ANG_P", 0.05 / x),
            ("ATC_STR_RAT_MAX", 0.4_f64.to_degrees()),
            ("ATC_STR_ACC_MAX", 0.4_f64.to_degrees()),
            ("ATC_TURN_MAX_G", 0.8 / 9.80665),
            ("TURN_RADIUS", 5.0),
        ],
    );
    let slow = named(ardupilot::parameters(&easy(Some(0.5)), VehicleType::Surface));
    assert_eq!(slow["ATC_STR_RAT_FF"], 2.0);
    // Rover takes 0.5 m/s for 1 m/s.
    assert!((slow["ATC_TURN_MAX_G"] - 0.4 / 9.80665).abs() < 1e-15);
    let unknown = named(ardupilot::parameters(&easy(None), VehicleType::Surface));
    assert_eq!(unknown["MOT_SPD_SCA_BASE"], 0.0);
    assert_eq!(unknown["ATC_STR_RAT_FF"], 2.0);
    assert!(!unknown.contains_key("TURN_RADIUS") && !unknown.contains_key("ATC_TURN_MAX_G"));
    assert_all(
        &named(ardupilot::parameters(&easy(None), VehicleType::Underwater)),
        &[
            ("ATC_RAT_YAW_P", 2.0),
            ("ATC_RAT_YAW_I", 2.0),
            ("ATC_RAT_YAW_D", 0.0),
            ("ATC_ANG_YAW_P", 0.5),
            ("ATC_RATE_Y_MAX", 0.4_f64.to_degrees()),
            ("ATC_ACCEL_Y_MAX", 40_f64.to_degrees()),
        ],
    );
    assert_all(
        &named(px4::parameters(&easy(Some(2.0)), VehicleType::Surface)),
        &[
            ("RA_MAX_STR_ANG", 0.25),
            ("RA_WHEEL_BASE", 1.0),
            ("RO_MAX_THR_SPEED", 4.0),
            ("RO_YAW_RATE_P", 0.05),
            ("RO_YAW_RATE_I", 0.5 * x),
            ("RO_YAW_P", 0.05 / x),
            ("RO_YAW_RATE_LIM", 0.4_f64.to_degrees()),
            ("RO_YAW_ACCEL_LIM", 0.4_f64.to_degrees()),
        ],
    );
    let unknown = named(px4::parameters(&easy(None), VehicleType::Surface));
    let found: Vec<_> = unknown.into_keys().collect();
    assert_eq!(found, ["RA_MAX_STR_ANG", "RO_YAW_ACCEL_LIM", "RO_YAW_RATE_LIM"]);
    // K_p = 1/(2 * 2) rad/rad over 0.25 rad.
    assert_all(
        &named(px4::parameters(&easy(None), VehicleType::Underwater)),
        &[("UUV_YAW_P", 1.0), ("UUV_YAW_D", 0.0)],
    );
}

/// Half the damping is not certain: w^2 = (1/2)^2/2 instead of 1/2, so K_p and A are a quarter.
#[test]
fn exact_every_export_allows_for_less_damping() {
    let mut point = easy(Some(2.0));
    point.allowance.damping_per_s = 0.5;
    let gain = |point: &OperatingPoint, vehicle, name: &str| {
        let mut found = named(ardupilot::parameters(point, vehicle));
        found.extend(named(px4::parameters(point, vehicle)));
        found[name]
    };
    for (vehicle, name) in [
        (VehicleType::Underwater, "ATC_ANG_YAW_P"),
        (VehicleType::Underwater, "UUV_YAW_P"),
        // The pole of the integral goes with w^2.
        (VehicleType::Surface, "ATC_STR_RAT_P"),
        (VehicleType::Surface, "RO_YAW_RATE_P"),
    ] {
        let whole = gain(&easy(Some(2.0)), vehicle, name);
        // A few roundings and the bisection.
        assert!((gain(&point, vehicle, name) / whole - 0.25).abs() < 1e-13, "{name}");
    }
    let models = [(point.at, point.allowance)];
    let schedule = Schedule::design("model", &models, ZETA, 0.25).unwrap();
    let schedule = serde_json::to_value(schedule).unwrap();
    let found = schedule["points"][0]["proportional_gain"].as_f64().unwrap();
    assert!((found / -0.0625 - 1.0).abs() < 1e-13, "{found}");
}

/// ATC_RAT_YAW_P = -4 a22/|b2| and ATC_ANG_YAW_P = -a22/2: a tenth of a22 is a tenth of both.
#[test]
fn exact_intervals_follow_from_the_covariance() {
    let mut point = easy(None);
    point.covariance = Some([[0.01, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1e-4]]);
    for parameter in ardupilot::parameters(&point, VehicleType::Underwater) {
        let half_width = match parameter.name {
            "ATC_RAT_YAW_P" => 0.2 * 1.96,
            "ATC_ANG_YAW_P" => 0.05 * 1.96,
            // |b2| limit - |C0|, and it alone depends on C0 alone.
            "ATC_ACCEL_Y_MAX" => 1_f64.to_degrees() * 1.96,
            "ATC_RAT_YAW_D" => {
                assert_eq!(parameter.interval_95, None);
                continue;
            }
            _ => continue,
        };
        let [low, high] = parameter.interval_95.unwrap();
        // 1.96 is 1.959964 rounded.
        let error = 0.5 * (high - low) / half_width - 1.0;
        assert!(error.abs() < 1e-4, "{} {error}", parameter.name);
    }
    let file = ardupilot::param_file(&point, VehicleType::Underwater);
    assert!(file.contains("[1/s]; 95 %: 0.4020\n#  to 0.5980\nATC_ANG_YAW_P,0.5\n"), "{file}");
}

/// Nothing is written for what the model does not have: a gain of an unstable vehicle, a turn that the offset
/// prevents.
#[test]
fn exact_what_the_model_does_not_determine_is_left_out() {
    let mut unstable = easy(Some(2.0));
    unstable.at.model.a22_per_s = 0.1;
    let mut overpowered = easy(Some(2.0));
    overpowered.at.model.c0_rad_per_s2 = 0.6;
    for vehicle in TYPES {
        assert_eq!(ardupilot::parameters(&unstable, vehicle), []);
        let rest = named(ardupilot::parameters(&overpowered, vehicle));
        assert!(rest.keys().all(|name| !name.ends_with("MAX")), "{rest:?}");
    }
    assert_eq!(px4::parameters(&unstable, VehicleType::Underwater), []);
}

#[test]
fn io_parameter_files_are_comments_and_parameters() {
    for vehicle in TYPES {
        let expected: Vec<_> = ardupilot::parameters(&easy(Some(2.0)), vehicle)
            .iter()
            .map(|p| (p.name.to_string(), p.value as f32))
            .collect();
        let file = ardupilot::param_file(&easy(Some(2.0)), vehicle);
        let lines = file.lines().filter(|line| !line.starts_with('#'));
        let found: Vec<_> = lines
            .map(|line| {
                let (name, value) = line.split_once(',').unwrap();
                (name.to_string(), value.parse::<f32>().unwrap())
            })
            .collect();
        assert_eq!(found, expected);

        let file = px4::params_file(&easy(Some(2.0)), vehicle);
        let lines = file.lines().filter(|line| !line.starts_with('#'));
        let found: Vec<Vec<&str>> = lines.map(|line| line.split('\t').collect()).collect();
        let expected = px4::parameters(&easy(Some(2.0)), vehicle);
        assert_eq!(found.len(), expected.len());
        for (fields, parameter) in found.iter().zip(expected) {
            let [system, component, name, value, kind] = fields[..] else {
                panic!("{fields:?}");
            };
            assert_eq!((system, component, kind), ("1", "1", "9"));
            assert_eq!(name, parameter.name);
            assert_eq!(value.parse(), Ok(parameter.value as f32));
        }
    }
}

#[test]
fn val_every_parameter_is_derived_in_the_docs() {
    let docs = include_str!("../../../docs/exports.md");
    let parameters = TYPES.into_iter().flat_map(|vehicle| {
        let ours = easy(Some(2.0));
        [ardupilot::parameters(&ours, vehicle), px4::parameters(&ours, vehicle)].concat()
    });
    for parameter in parameters {
        // MAVLink's limit, and a row of a table.
        assert!(parameter.name.len() <= 16);
        let row = format!("| `{}` |", parameter.name);
        assert!(docs.contains(&row), "{}", parameter.name);
    }
}

/// The two ends of Table V, the faster first.
fn schedule() -> Schedule {
    let models = [
        point(Some(1.0), Some(2.13), [-1.48, 2.02, 0.0312]),
        point(Some(0.6), Some(1.05), [-1.28, 0.65, 0.0129]),
    ];
    Schedule::design("a */ \"log\": #1\n", &for_nothing(&models), ZETA, 0.26).unwrap()
}

/// Speed, thrust, K_p = a22^2/(2 b2), -delta0, r_max = (b2 limit - C0)/-a22 and V/r_max, slowest first.
fn rows() -> [[f64; 6]; 2] {
    [[1.05, 0.6, -1.28, 0.65, 0.0129], [2.13, 1.0, -1.48, 2.02, 0.0312]].map(
        |[speed, thrust, a22, b2, c0]| {
            let limit = (b2 * 0.26 - c0) / -a22;
            [speed, thrust, a22 * a22 / (2.0 * b2), -c0 / b2, limit, speed / limit]
        },
    )
}

const COLUMNS: [&str; 6] = [
    "surge_speed_m_s",
    "thrust",
    "proportional_gain",
    "feed_forward_rudder_rad",
    "yaw_rate_limit_rad_s",
    "turning_radius_m",
];

fn assert_rows(found: impl Fn(usize, usize) -> f64) {
    for (row, expected) in rows().iter().enumerate() {
        for (column, expected) in expected.iter().enumerate() {
            // A few roundings: zeta squared is not exactly a half.
            let error = (found(row, column) - expected).abs();
            assert!(error < 1e-14, "{} of row {row}", COLUMNS[column]);
        }
    }
}

#[test]
fn io_json_is_the_schedule() {
    let text = serde_json::to_string(&schedule()).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["source"], "a */ \"log\": #1\n");
    assert_rows(|row, column| json["points"][row][COLUMNS[column]].as_f64().unwrap());
}

#[test]
fn io_ros2_parameters_are_numbers_of_one_node() {
    let yaml = YamlLoader::load_from_str(&schedule().ros2_yaml()).unwrap();
    let parameters = &yaml[0]["heading_controller"]["ros__parameters"];
    assert_eq!(parameters["rudder_limit_rad"].as_f64(), Some(0.26));
    // ROS 2 refuses an array of whole and other numbers.
    assert_rows(|row, column| match &parameters["schedule"][COLUMNS[column]][row] {
        number @ Yaml::Real(_) => number.as_f64().unwrap(),
        other => panic!("{other:?}"),
    });
    let unknown = [point(None, None, [-1.0, 1.0, 0.0])];
    let single = Schedule::design("model", &for_nothing(&unknown), ZETA, 0.26).unwrap().ros2_yaml();
    let yaml = YamlLoader::load_from_str(&single).unwrap();
    let schedule = &yaml[0]["heading_controller"]["ros__parameters"]["schedule"];
    let names: Vec<_> = schedule.as_hash().unwrap().keys().collect();
    let expected = ["proportional_gain", "feed_forward_rudder_rad", "yaw_rate_limit_rad_s"];
    assert_eq!(names, expected.map(|name| Yaml::String(name.into())).iter().collect::<Vec<_>>());
}

#[test]
fn io_the_header_compiles_and_holds_the_schedule() {
    const PROGRAM: &str = r#"
#include <stdio.h>
#include "gains.h"
#include "gains.h"
int main(void) {
    for (int i = 0; i < SEATRIAL_GAINS_COUNT; i++) {
        struct seatrial_gains g = seatrial_gains[i];
        printf("%.17g %.17g %.17g %.17g %.17g %.17g\n", g.surge_speed_m_s, g.thrust, g.proportional_gain,
               g.feed_forward_rudder_rad, g.yaw_rate_limit_rad_s, g.turning_radius_m);
    }
    return SEATRIAL_RUDDER_LIMIT_RAD == 0.26 ? 0 : 1;
}
"#;
    if Command::new("gcc").arg("--version").output().is_err() {
        seatrial_dev::skip("no gcc");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("gains.h"), schedule().c_header()).unwrap();
    std::fs::write(folder.path().join("main.c"), PROGRAM).unwrap();
    let compiled = Command::new("gcc")
        .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "main.c", "-o", "main"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    let run = Command::new(folder.path().join("main")).output().unwrap();
    assert!(run.status.success());
    let printed = String::from_utf8(run.stdout).unwrap();
    let values: Vec<Vec<f64>> = printed
        .lines()
        .map(|line| line.split(' ').map(|number| number.parse().unwrap()).collect())
        .collect();
    assert_eq!(values.len(), 2);
    assert_rows(|row, column| values[row][column]);
}
