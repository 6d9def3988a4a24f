//! Files that describe a vehicle on ROS 2.

use std::process::Output;

use seatrial_dev::program;

const VEHICLE: &str = "\
command_timeout_s = 0.5
[odometry]
topic = '/odom'
[rudder]
topic = '/rudder/command'
limit_rad = 0.35
[thrust]
topic = '/thrust/command'
";

fn check(description: &str) -> Output {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("boat.toml");
    std::fs::write(&path, description).unwrap();
    program()
        .args(["vehicle", "check", "--vehicle"])
        .arg(format!("ros2:{}", path.display()))
        .output()
        .unwrap()
}

#[test]
fn cli_a_file_that_describes_no_vehicle_is_refused_with_its_line() {
    for (from, to, expected) in [
        ("'/odom'", "'odom'", "odometry.topic is \"odom\""),
        ("0.35", "0.35\ntype = 'std_msgs/Int8'", "std_msgs/Int8"),
        ("0.35", "0.1", "more than rudder.limit_rad"),
        ("[thrust]", "[trust]", "trust"),
        ("0.5", "50.0", "command_timeout_s is 50: expected 0.1 to 5"),
        ("0.5", "0.5\nzenoh.endpoint = 'udp/127.0.0.1:7447'", "expected tcp/HOST:PORT"),
        ("0.5", "0.5\nservices = 'cyclonedds'\n[zenoh]", "services are about DDS"),
    ] {
        let output = check(&VEHICLE.replace(from, to));
        let printed = String::from_utf8_lossy(&output.stderr);
        assert!(printed.contains("boat.toml"), "{printed}");
        assert!(printed.contains(expected), "{expected}: {printed}");
        assert!(matches!(output.status.code(), Some(2 | 3)), "{printed}");
    }
}

/// Without the feature it is said how to get it; with it, that DDS listens everywhere must be agreed to first, and where nobody
/// answers.
#[test]
fn cli_ros_2_is_never_joined_unasked() {
    let nobody = "0.5\nzenoh.endpoint = 'tcp/127.0.0.1:9'";
    let over_zenoh = VEHICLE.replace("0.5", nobody);
    for (description, is_built, refused, feature) in [
        (VEHICLE, cfg!(feature = "ros2"), "listens_on_all_addresses", "--features ros2"),
        (
            &over_zenoh,
            cfg!(feature = "ros2-zenoh"),
            "nobody answers at tcp/127.0.0.1:9",
            "--features ros2-zenoh",
        ),
    ] {
        let output = check(description);
        let printed = String::from_utf8_lossy(&output.stderr);
        let (code, expected) = match is_built {
            true => (3, refused),
            false => (2, feature),
        };
        assert_eq!(output.status.code(), Some(code), "{printed}");
        assert!(printed.contains(expected), "{printed}");
    }
}
