//! The vehicle's own report of its health.

use super::heard::Heard;
use super::{Profile, Settings};
use crate::handover::Preflight;

/// Flags of EKF_STATUS_REPORT: attitude known; not started.
const EKF_ATTITUDE: u16 = 1;
const EKF_UNINITIALISED: u16 = 1024;
/// Above this an estimator's check of its compass fails.
const HIGHEST_VARIANCE: f32 = 1.0;
/// What the flags of EKF_STATUS_REPORT and ESTIMATOR_STATUS say is known, from the lowest on.
const KNOWN: [&str; 5] = [
    "attitude",
    "horizontal speed",
    "vertical speed",
    "position relative to the start",
    "position",
];
/// GPS_FIX_TYPE_3D_FIX, and the fixes by their numbers.
const FIX_3D: u8 = 3;
const FIXES: [&str; 9] = [
    "no receiver",
    "no fix",
    "a fix without height",
    "a fix in three dimensions",
    "a fix with differential corrections",
    "RTK, not yet fixed",
    "RTK, fixed",
    "a fixed place that was entered",
    "PPP",
];

/// Armed, estimator, compass, satellites, battery.
pub(super) fn check(heard: &Heard, profile: Profile, settings: &Settings, found: &mut Preflight) {
    found.check(
        "armed",
        heard.is_armed(),
        match heard.is_armed() {
            true => "armed",
            false => "disarmed: arm it; the trial never does",
        },
    );
    let (is_healthy, compass, text) = match (heard.ekf, heard.estimator) {
        (Some(ekf), _) => {
            let flags = ekf.flags;
            let is_known = flags & EKF_ATTITUDE != 0 && flags & EKF_UNINITIALISED == 0;
            (is_known, ekf.compass_variance, estimator_text(flags))
        }
        (None, Some(status)) => {
            let is_known = status.flags & EKF_ATTITUDE != 0;
            (is_known, status.compass_ratio, estimator_text(status.flags))
        }
        (None, None) => (false, f32::NAN, "no report of the estimator has come".into()),
    };
    found.check("estimator", is_healthy, text);
    found.check("heading source", compass <= HIGHEST_VARIANCE, compass_text(compass));
    if profile.is_boat() {
        let fix = heard.gps.map_or(0, |gps| gps.fix_type);
        found.check("satellites", fix >= FIX_3D, fix_text(fix));
    }
    match heard.battery_percent() {
        Some(percent) => found.check(
            "battery",
            percent >= settings.lowest_battery_percent,
            format!("{percent} %, at least {} %", settings.lowest_battery_percent),
        ),
        None => found.check(
            "battery",
            true,
            "not measured; the autopilot's own failsafe is all there is",
        ),
    }
}

/// What the estimator says that it knows.
fn estimator_text(flags: u16) -> String {
    let is_set = |bit: &usize| flags & (1 << bit) != 0;
    let known: Vec<&str> = (0..KNOWN.len()).filter(is_set).map(|bit| KNOWN[bit]).collect();
    match (known.is_empty(), flags & EKF_UNINITIALISED != 0) {
        (_, true) => "it has not started yet: wait, with the vehicle still".into(),
        (true, _) => "it knows nothing yet: wait, with the vehicle still".into(),
        (false, _) => format!("it knows {}", known.join(", ")),
    }
}

/// How far the compass is from the estimator, as a share of the most.
fn compass_text(share: f32) -> String {
    match share.is_finite() {
        true => format!(
            "the compass differs from the estimator by {:.0} % of the most that it may",
            100.0 * share
        ),
        false => "the estimator does not tell how far the compass differs".into(),
    }
}

fn fix_text(fix: u8) -> String {
    let name = FIXES.get(usize::from(fix)).copied();
    let name = name.unwrap_or("a fix of an unknown kind");
    match fix >= FIX_3D {
        true => name.to_owned(),
        false => format!("{name}; a boat needs {}", FIXES[usize::from(FIX_3D)]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_flags_fixes_and_modes_are_words() {
        assert_eq!(
            estimator_text(0x1f),
            "it knows attitude, horizontal speed, vertical speed, position relative to the start, position"
        );
        assert!(estimator_text(EKF_UNINITIALISED | 1).contains("not started"));
        assert!(estimator_text(0).contains("nothing yet"));
        assert_eq!(fix_text(3), "a fix in three dimensions");
        assert_eq!(fix_text(1), "no fix; a boat needs a fix in three dimensions");
        assert_eq!(fix_text(77), "a fix of an unknown kind");
        assert!(compass_text(0.1).contains("10 %"));
        assert!(compass_text(f32::NAN).contains("does not tell"));
        assert_eq!(Profile::Rover.mode_text(15), "Guided (15)");
        assert_eq!(Profile::Sub.mode_text(19), "Manual (19)");
        assert_eq!(Profile::Px4.mode_text(1 << 16), "Manual (65536)");
        assert_eq!(Profile::Generic.mode_text(7), "number 7");
    }
}
