//! Tracks for charts and maps, as GPX and KML.

use std::path::Path;

use seatrial_app::logs::OpenedLog;
use seatrial_app::series::track_of_runs;
use seatrial_logbook::CampaignEntry;
use seatrial_logs::TrackFormat;

use crate::output::Failure;

/// A latitude and a longitude, deg.
pub fn origin(text: &str) -> Result<[f64; 2], &'static str> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some([latitude, longitude]) if latitude.abs() < 90.0 && longitude.abs() <= 180.0 => {
            Ok([*latitude, *longitude])
        }
        _ => Err("expected a latitude and a longitude in degrees, as in 54.33,10.15"),
    }
}

/// The track of a log in the form that the name of the file says.
pub fn of_log(log: &OpenedLog, file: &Path) -> Result<String, Failure> {
    let format = TrackFormat::of(file).ok_or_else(|| {
        let file = file.display();
        Failure::usage(format!("{file}: expected the name of a track to end in .gpx or .kml"))
    })?;
    log.track(format).ok_or_else(|| {
        let log = log.path.display();
        Failure::input(format!(
            "{log}: the log has no latitude and longitude: a track for charts needs them"
        ))
    })
}

/// The track of runs, whose positions are metres from a place that the logbook does not know.
pub fn of_campaign(
    entry: &CampaignEntry,
    runs: &[seatrial::Run],
    format: TrackFormat,
    origin_deg: Option<[f64; 2]>,
) -> Result<String, Failure> {
    let number = entry.id.0;
    let origin_deg = origin_deg.ok_or_else(|| {
        Failure::usage(format!(
            "campaign {number}: its positions are metres from a place that the logbook does not know; name it with --origin LAT,LON"
        ))
    })?;
    track_of_runs(format, runs, origin_deg, &entry.started)
        .ok_or_else(|| Failure::input(format!("campaign {number}: the vehicle told no positions")))
}
