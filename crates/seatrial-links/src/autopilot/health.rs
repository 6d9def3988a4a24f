//! The vehicle's own report of its health.

use super::heard::Heard;
use super::{Profile, Settings};
use crate::handover::Preflight;

/// Flags of EKF_STATUS_REPORT: attitude known; not started.
const EKF_ATTITUDE: u16 = 1;
const EKF_UNINITIALISED: u16 = 1024;
/// Above this an estimator's check of its compass fails.
const HIGHEST_VARIANCE: f32 = 1.0;
/// GPS_FIX_TYPE_3D_FIX.
const FIX_3D: u8 = 3;

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
            (is_known, ekf.compass_variance, format!("flags {flags:#x}"))
        }
        (None, Some(status)) => {
            let is_known = status.flags & EKF_ATTITUDE != 0;
            (
                is_known,
                status.compass_ratio,
                format!("flags {:#x}", status.flags),
            )
        }
        (None, None) => (
            false,
            f32::NAN,
            "no report of the estimator has come".into(),
        ),
    };
    found.check("estimator", is_healthy, text);
    found.check(
        "heading source",
        compass <= HIGHEST_VARIANCE,
        format!("compass against estimator: {compass:.2} of what it may differ"),
    );
    if profile.is_boat() {
        let fix = heard.gps.map_or(0, |gps| gps.fix_type);
        let text = format!("fix type {fix}; a boat needs {FIX_3D}, a fix in three dimensions");
        found.check("satellites", fix >= FIX_3D, text);
    }
    match heard.battery_percent() {
        Some(percent) => found.check(
            "battery",
            percent >= settings.lowest_battery_percent,
            format!(
                "{percent} %, at least {} %",
                settings.lowest_battery_percent
            ),
        ),
        None => found.check(
            "battery",
            true,
            "not measured; the autopilot's own failsafe is all there is",
        ),
    }
}
