//! The parameters of the heading controllers of ArduPilot's Rover and Sub as [`CascadeSettings`].

use std::f64::consts::PI;

use seatrial_core::CascadeSettings;

use super::Profile;
use crate::handover::Change;

/// Degrees in a radian.
const DEGREES: f64 = 180.0 / PI;

/// A parameter: name, unit, what one of its units is of ours, and where it stands.
struct Row {
    name: &'static str,
    per_unit: f64,
    field: fn(&mut CascadeSettings<f64>) -> &mut f64,
    /// What it is where a firmware does not have it; `None`: every firmware has it.
    otherwise: Option<f64>,
    /// Why it is changed.
    why: &'static str,
}

macro_rules! row {
    ($name:literal, $field:ident, $per_unit:expr, $otherwise:expr, $why:literal) => {
        Row {
            name: $name,
            per_unit: $per_unit,
            field: |settings| &mut settings.$field,
            otherwise: $otherwise,
            why: $why,
        }
    };
}

/// One that shapes the heading target.
macro_rules! shaping {
    ($name:literal, $field:ident, $per_unit:expr) => {
        Row {
            name: $name,
            per_unit: $per_unit,
            field: |settings| &mut settings.shaping.get_or_insert_default().$field,
            otherwise: None,
            why: "stays as it is",
        }
    };
}

const ROVER: [Row; 11] = [
    row!(
        "ATC_STR_ANG_P",
        angle_gain_per_s,
        1.0,
        None,
        "turn rate for a heading error, as quick as the rudder's lag and the least favourable model allow"
    ),
    row!(
        "ATC_STR_RAT_FF",
        feed_forward_s,
        1.0,
        None,
        "the steering of a steady turn: damping by rudder effect"
    ),
    row!(
        "ATC_STR_RAT_P",
        rate_gain_s,
        1.0,
        None,
        "damping added by feedback of the turn rate, as far as lag and noise allow"
    ),
    row!(
        "ATC_STR_RAT_I",
        rate_integral_gain,
        1.0,
        None,
        "takes out the steady offset slowly, without overshoot"
    ),
    row!(
        "ATC_STR_RAT_D",
        rate_derivative_gain_s2,
        1.0,
        None,
        "none: the rudder would follow the noise of the turn rate"
    ),
    row!("ATC_STR_RAT_IMAX", integral_limit, 1.0, None, "most steering that the integral takes"),
    row!(
        "ATC_STR_RAT_FLTT",
        target_filter_hz,
        1.0,
        Some(0.0),
        "filter of the wanted turn rate, so that the rudder does not follow the noise of the heading"
    ),
    row!("ATC_STR_RAT_FLTE", error_filter_hz, 1.0, Some(0.0), "filter of the turn rate's error"),
    row!("ATC_STR_RAT_FLTD", derivative_filter_hz, 1.0, Some(0.0), "filter of the derivative"),
    row!(
        "ATC_STR_RAT_MAX",
        rate_limit_rad_s,
        DEGREES,
        None,
        "the model's steady turn at 85 % of full steering, beyond what the trial tried"
    ),
    row!(
        "ATC_STR_ACC_MAX",
        acceleration_limit_rad_s2,
        DEGREES,
        None,
        "80 % of the acceleration that full steering gives, so that a turn can be stopped in time"
    ),
];

const SUB: [Row; 12] = [
    row!(
        "ATC_ANG_YAW_P",
        angle_gain_per_s,
        1.0,
        None,
        "turn rate for a heading error, as quick as the thrusters' lag and the least favourable model allow"
    ),
    row!(
        "ATC_RAT_YAW_P",
        rate_gain_s,
        1.0,
        None,
        "yaw for an error of the turn rate, as far as lag and noise allow"
    ),
    row!(
        "ATC_RAT_YAW_I",
        rate_integral_gain,
        1.0,
        None,
        "damping by P: its zero cancels the vehicle's own pole"
    ),
    row!(
        "ATC_RAT_YAW_D",
        rate_derivative_gain_s2,
        1.0,
        None,
        "none: the thrusters would follow the noise of the turn rate"
    ),
    row!(
        "ATC_RAT_YAW_IMAX",
        integral_limit,
        1.0,
        None,
        "most yaw that the integral gives: what the quickest turn takes, and a third more"
    ),
    row!(
        "ATC_RAT_YAW_FLTT",
        target_filter_hz,
        1.0,
        None,
        "filter of the wanted turn rate, so that the thrusters do not follow the noise of the heading"
    ),
    row!("ATC_RAT_YAW_FLTE", error_filter_hz, 1.0, None, "filter of the turn rate's error"),
    row!("ATC_RAT_YAW_FLTD", derivative_filter_hz, 1.0, None, "filter of the derivative"),
    row!(
        "ATC_SLEW_YAW",
        rate_limit_rad_s,
        100.0 * DEGREES,
        None,
        "the quickest turn to a heading: a share of what the thrusters have left beside the way ahead"
    ),
    row!(
        "ATC_ACCEL_Y_MAX",
        acceleration_limit_rad_s2,
        100.0 * DEGREES,
        None,
        "how quickly a turn begins and ends: the other share of what the thrusters have left"
    ),
    shaping!("ATC_INPUT_TC", time_constant_s, 1.0),
    shaping!("ATC_RATE_Y_MAX", rate_limit_rad_s, DEGREES),
];

/// The parameters of a kind of autopilot.
fn rows(profile: Profile) -> &'static [Row] {
    match profile {
        Profile::Rover => &ROVER,
        Profile::Sub => &SUB,
        Profile::Px4 | Profile::Generic => &[],
    }
}

/// Those that settings are of.
fn rows_of(settings: &CascadeSettings<f64>) -> &'static [Row] {
    match settings.shaping {
        Some(_) => &SUB,
        None => &ROVER,
    }
}

/// The names of the parameters of a kind of autopilot.
pub fn names(profile: Profile) -> impl Iterator<Item = &'static str> {
    rows(profile).iter().map(|row| row.name)
}

/// Those of every kind.
pub(super) fn all_names() -> impl Iterator<Item = &'static str> {
    ROVER.iter().chain(&SUB).map(|row| row.name)
}

/// More than any autopilot has in a parameter of this name, of whatever kind; `None` where it is no gain of the controller.
pub(super) fn most_of(name: &str) -> Option<f64> {
    let row = ROVER.iter().chain(&SUB).find(|row| row.name == name)?;
    Some(100.0 * row.per_unit.max(1.0))
}

/// The names of those that every firmware of a kind has.
pub(super) fn needed_names(profile: Profile) -> impl Iterator<Item = &'static str> {
    let needed = rows(profile).iter().filter(|row| row.otherwise.is_none());
    needed.map(|row| row.name)
}

/// The settings that parameters stand for; else the name of one that is not there.
pub fn settings(
    profile: Profile,
    get: impl Fn(&str) -> Option<f64>,
) -> Result<CascadeSettings<f64>, &'static str> {
    let mut settings = CascadeSettings::default();
    for row in rows(profile) {
        let value = get(row.name).or(row.otherwise).ok_or(row.name)?;
        *(row.field)(&mut settings) = value / row.per_unit;
    }
    Ok(settings)
}

/// The parameters in which some settings differ from others of the same autopilot, rounded as they are sent, and why.
pub fn differences(from: &CascadeSettings<f64>, to: &CascadeSettings<f64>) -> Vec<Change> {
    let value = |row: &Row, mut settings: CascadeSettings<f64>| {
        rounded(*(row.field)(&mut settings) * row.per_unit)
    };
    rows_of(from)
        .iter()
        .map(|row| Change {
            name: row.name.into(),
            from: value(row, *from),
            to: value(row, *to),
            why: row.why.into(),
        })
        .filter(|change| change.from != change.to)
        .collect()
}

/// The parameters that make some settings of others, in the order in which they are written. The integral gain is 0 meanwhile,
/// which empties the integral: what the old gains have gathered in it would push the vehicle aside for minutes.
pub fn writes(from: &CascadeSettings<f64>, to: &CascadeSettings<f64>) -> Vec<(&'static str, f64)> {
    let integral = match from.shaping {
        Some(_) => "ATC_RAT_YAW_I",
        None => "ATC_STR_RAT_I",
    };
    let mut writes = vec![(integral, 0.0)];
    let changes = differences(from, to);
    for row in rows_of(from).iter().filter(|row| row.name != integral) {
        let change = changes.iter().find(|change| change.name == row.name);
        writes.extend(change.map(|change| (row.name, change.to)));
    }
    writes.push((integral, rounded(to.rate_integral_gain)));
    writes
}

/// A number with six figures, of those that a parameter can hold.
fn rounded(value: f64) -> f64 {
    let short = format!("{value:.5e}").parse().unwrap_or(value);
    decimal(short as f32)
}

/// The shortest number that a parameter's bits stand for: 0.2, not 0.20000000298.
pub(super) fn decimal(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_parameters_become_settings_and_back() {
        let get = |name: &str| match name {
            "ATC_STR_RAT_MAX" => Some(120.0),
            "ATC_STR_RAT_FLTE" => None,
            _ => Some(0.2),
        };
        let found = settings(Profile::Rover, get).unwrap();
        assert!((found.rate_limit_rad_s - 120_f64.to_radians()).abs() < 1e-12);
        assert_eq!((found.rate_gain_s, found.error_filter_hz), (0.2, 0.0));
        assert_eq!(differences(&found, &found), []);
        let slower = CascadeSettings { rate_limit_rad_s: 0.5, rate_gain_s: 1.0 / 3.0, ..found };
        let changed = differences(&found, &slower);
        let numbers = changed.iter().map(|c| (c.name.as_str(), c.from, c.to));
        let expected = [("ATC_STR_RAT_P", 0.2, 0.333333), ("ATC_STR_RAT_MAX", 120.0, 28.6479)];
        assert!(numbers.eq(expected), "{changed:?}");
        let written = writes(&found, &slower);
        let integral = ("ATC_STR_RAT_I", 0.2);
        let expected = [
            ("ATC_STR_RAT_I", 0.0),
            ("ATC_STR_RAT_P", 0.333333),
            ("ATC_STR_RAT_MAX", 28.6479),
            integral,
        ];
        assert_eq!(written, expected);
        assert_eq!(settings(Profile::Rover, |_| None), Err("ATC_STR_ANG_P"));
    }

    /// Centidegrees, and the parameters that only shape the target.
    #[test]
    fn exact_parameters_of_a_submarine_become_settings_and_back() {
        let get = |name: &str| match name {
            "ATC_SLEW_YAW" => Some(6000.0),
            "ATC_RATE_Y_MAX" => Some(90.0),
            _ => Some(0.15),
        };
        let found = settings(Profile::Sub, get).unwrap();
        assert!((found.rate_limit_rad_s - 60_f64.to_radians()).abs() < 1e-12);
        let shaping = found.shaping.unwrap();
        assert!((shaping.rate_limit_rad_s - 90_f64.to_radians()).abs() < 1e-12);
        assert_eq!(shaping.time_constant_s, 0.15);
        let slower = CascadeSettings { rate_limit_rad_s: 0.5, ..found };
        let written = writes(&found, &slower);
        let expected = [("ATC_RAT_YAW_I", 0.0), ("ATC_SLEW_YAW", 2864.79), ("ATC_RAT_YAW_I", 0.15)];
        assert_eq!(written, expected);
        assert_eq!(settings(Profile::Sub, |_| None), Err("ATC_ANG_YAW_P"));
    }

    #[test]
    fn exact_parameters_are_the_numbers_that_people_set() {
        assert_eq!(decimal(0.2_f32), 0.2);
        assert_eq!(decimal(-1500.0), -1500.0);
        assert!(decimal(f32::NAN).is_nan());
    }
}
