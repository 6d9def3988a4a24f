//! A speaking vehicle's mode and parameters before anybody changes them.

use std::collections::BTreeMap;

use super::Profile;

/// Neutral and half the range of every output and input, us.
pub(super) const TRIM_US: f64 = 1500.0;
pub(super) const HALF_US: f64 = 400.0;
/// Channels of the remote control.
pub(super) const STICKS: usize = 16;
/// What ArduSub makes of a full stick, as a fraction of full thrust.
pub(super) const SUB_GAIN: f64 = 0.5;

/// `custom_mode` in which it holds its heading: HOLD, ALT_HOLD, Loiter.
pub(super) fn resting_mode(profile: Profile) -> u32 {
    match profile {
        Profile::Sub => 2,
        Profile::Px4 => 4 << 16 | 3 << 24,
        Profile::Rover | Profile::Generic => 4,
    }
}

/// How Rover controls its heading as it comes, but for the speed.
const HEADING_CONTROL: [(&str, f32); 15] = [
    ("ATC_STR_ANG_P", 2.0),
    ("ATC_STR_RAT_FF", 0.2),
    ("ATC_STR_RAT_P", 0.2),
    ("ATC_STR_RAT_I", 0.2),
    ("ATC_STR_RAT_D", 0.0),
    ("ATC_STR_RAT_IMAX", 1.0),
    ("ATC_STR_RAT_FLTT", 0.0),
    ("ATC_STR_RAT_FLTE", 10.0),
    ("ATC_STR_RAT_FLTD", 0.0),
    ("ATC_STR_RAT_MAX", 120.0),
    ("ATC_STR_ACC_MAX", 120.0),
    ("CRUISE_SPEED", 2.0),
    ("CRUISE_THROTTLE", 80.0),
    ("WP_SPEED", 0.0),
    ("MOT_SPD_SCA_BASE", 1.0),
];

/// How Sub controls its heading as it comes, 4.7.
const HEADING_CONTROL_OF_SUB: [(&str, f32); 16] = [
    ("ATC_ANG_YAW_P", 6.0),
    ("ATC_RAT_YAW_P", 0.18),
    ("ATC_RAT_YAW_I", 0.018),
    ("ATC_RAT_YAW_D", 0.0),
    ("ATC_RAT_YAW_IMAX", 0.222),
    ("ATC_RAT_YAW_FLTT", 5.0),
    ("ATC_RAT_YAW_FLTE", 0.0),
    ("ATC_RAT_YAW_FLTD", 5.0),
    ("ATC_RAT_YAW_SMAX", 0.0),
    ("ATC_RAT_YAW_PDMX", 0.0),
    ("ATC_RAT_YAW_NEF", 0.0),
    ("ATC_SLEW_YAW", 6000.0),
    ("ATC_ACCEL_Y_MAX", 110_000.0),
    ("ATC_INPUT_TC", 0.15),
    ("ATC_RATE_Y_MAX", 0.0),
    ("ATC_RATE_FF_ENAB", 1.0),
];

/// Its parameters.
pub(super) fn parameters(profile: Profile, interval_s: f64) -> BTreeMap<String, f32> {
    if profile == Profile::Px4 {
        return BTreeMap::from([("COM_RC_LOSS_T".into(), 3.0)]);
    }
    let is_sub = profile == Profile::Sub;
    let mut parameters: BTreeMap<String, f32> = [
        ("MAV_GCS_SYSID", 255.0),
        ("RC_OVERRIDE_TIME", 3.0),
        // ArduSub's 2 disarms or what else FS_PILOT_INPUT says.
        ("FS_GCS_ENABLE", if is_sub { 2.0 } else { 0.0 }),
        ("FS_GCS_TIMEOUT", 5.0),
        ("SCHED_LOOP_RATE", (1.0 / interval_s) as f32),
    ]
    .map(|(name, value)| (name.into(), value))
    .into();
    let ranges = if is_sub {
        parameters.insert("FS_PILOT_INPUT".into(), 2.0);
        parameters.insert("FS_PILOT_TIMEOUT".into(), 3.0);
        parameters.insert("JS_GAIN_DEFAULT".into(), SUB_GAIN as f32);
        let control = HEADING_CONTROL_OF_SUB.iter();
        parameters.extend(control.map(|(name, value)| ((*name).into(), *value)));
        vec!["SERVO1", "SERVO2", "SERVO3", "SERVO4"]
    } else {
        parameters.insert("FS_ACTION".into(), 2.0);
        parameters.insert("FS_TIMEOUT".into(), 1.5);
        parameters.extend(HEADING_CONTROL.map(|(name, value)| (name.into(), value)));
        vec!["RC1", "RC3", "SERVO1", "SERVO3"]
    };
    for number in 1..=16_u8 {
        let function = match (is_sub, number) {
            (true, 1..=4) => 32.0 + f32::from(number),
            (false, 1) => 26.0,
            (false, 3) => 70.0,
            _ => 0.0,
        };
        parameters.insert(format!("SERVO{number}_FUNCTION"), function);
        if is_sub && number <= 4 {
            parameters.insert(format!("MOT_{number}_DIRECTION"), 1.0);
        }
    }
    for prefix in ranges {
        for (what, value) in [
            ("MIN", TRIM_US - HALF_US),
            ("TRIM", TRIM_US),
            ("MAX", TRIM_US + HALF_US),
            ("REVERSED", 0.0),
            ("DZ", 30.0),
        ] {
            parameters.insert(format!("{prefix}_{what}"), value as f32);
        }
    }
    parameters
}
