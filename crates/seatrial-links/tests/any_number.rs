//! No number in any field of the file of a vehicle on ROS 2 ends the program: it is refused by name, or used.

use seatrial_dev::{Damage, damaged_copies, with_any_number};
use seatrial_links::ros2_vehicle::{Demand, Description};

const FILE: &str = "
    domain = 3
    command_timeout_s = 0.5
    [odometry]
    topic = '/odom'
    [rudder]
    topic = '/rudder'
    units_per_rad = 57.3
    trim_units = 0.5
    limit_rad = 0.35
    [thrust]
    topic = '/thrust'
    units_at_full = 100.0
    neutral_units = 0.1
    [feedback]
    topic = '/joints'
    joint = 'rudder'
    units_per_rad = 1.0
    trim_units = 0.1
";

#[test]
fn prop_any_number_in_the_file_of_a_vehicle_on_ros_2() {
    let table = FILE.parse().unwrap();
    let (mut used, mut refused) = (0, 0);
    for table in with_any_number(&table) {
        let read: Result<Description, _> = toml::from_str(&toml::to_string(&table).unwrap());
        let Ok(description) = read else {
            refused += 1;
            continue;
        };
        if description.check().is_err() {
            refused += 1;
            continue;
        }
        used += 1;
        for rudder_rad in [-1.0, 0.0, 1.0] {
            let demand = Demand { rudder_rad, thrust: 1.0 };
            for command in description.commands(demand) {
                let is_sound = command.numbers.iter().all(|number| number.is_finite());
                assert!(is_sound, "{command:?} of {description:?}");
            }
        }
        let feedback = description.feedback.as_ref().unwrap();
        assert!(feedback.rudder_rad(0.5).is_finite(), "{feedback:?}");
    }
    assert!(used > 5 && refused > 20, "{used} {refused}");
}

/// Damaged copies of the file.
const DAMAGED: u64 = 5000;

#[test]
fn prop_no_damaged_file_of_a_vehicle_on_ros_2_ends_the_program() {
    let (mut used, mut refused) = (0, 0);
    for seed in 0..damaged_copies(DAMAGED) {
        let text = Damage::new(seed).of_text(FILE);
        let read: Result<Description, _> = toml::from_str(&text);
        match read.is_ok_and(|description| description.check().is_ok()) {
            true => used += 1,
            false => refused += 1,
        }
    }
    assert!(used > 0 && refused > 0, "{used} {refused}");
}
