//! The track of samples in GPX and KML, which charts and maps open.

use std::fmt::Write;
use std::path::Path;

use jiff::Timestamp;
use seatrial_core::Sample;

use crate::coordinates::place;

/// Points are at least this far apart, s.
const INTERVAL_S: f64 = 1.0;

/// A form of tracks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrackFormat {
    /// GPX 1.1.
    Gpx,
    /// KML 2.2.
    Kml,
}

impl TrackFormat {
    /// The form that the end of a file's name says.
    pub fn of(file: &Path) -> Option<Self> {
        let end = file.extension()?.to_ascii_lowercase();
        let forms = [Self::Gpx, Self::Kml];
        forms.into_iter().find(|form| end == form.extension())
    }

    /// How a file of it ends.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Gpx => "gpx",
            Self::Kml => "kml",
        }
    }
}

/// The track of samples whose north and east are metres from a place, latitude and longitude in degrees; one point a second.
/// `start_utc` is second 0. `None`: fewer than two samples have a position.
pub fn write_track(
    format: TrackFormat,
    samples: &[Sample<f64>],
    origin_deg: [f64; 2],
    start_utc: Option<&str>,
) -> Option<String> {
    let start: Option<Timestamp> = start_utc.and_then(|start| start.parse().ok());
    let mut points: Vec<(f64, [f64; 2])> = Vec::new();
    for sample in samples {
        let (Some(north_m), Some(east_m)) = (sample.north_m, sample.east_m) else {
            continue;
        };
        let is_due = points.last().is_none_or(|(last_s, _)| sample.time_s >= last_s + INTERVAL_S);
        if is_due && north_m.is_finite() && east_m.is_finite() {
            points.push((sample.time_s, place([north_m, east_m], origin_deg)));
        }
    }
    if points.len() < 2 {
        return None;
    }
    Some(match format {
        TrackFormat::Gpx => gpx(&points, start),
        TrackFormat::Kml => kml(&points),
    })
}

fn gpx(points: &[(f64, [f64; 2])], start: Option<Timestamp>) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<gpx version=\"1.1\" creator=\"seatrial\" xmlns=\"http://www.topografix.com/GPX/1/1\">\n<trk><trkseg>\n",
    );
    for (time_s, [latitude, longitude]) in points {
        let _ = write!(text, "<trkpt lat=\"{latitude:.7}\" lon=\"{longitude:.7}\">");
        if let Some(time) = start.and_then(|start| at(start, *time_s)) {
            let _ = write!(text, "<time>{time}</time>");
        }
        text += "</trkpt>\n";
    }
    text + "</trkseg></trk>\n</gpx>\n"
}

fn at(start: Timestamp, time_s: f64) -> Option<Timestamp> {
    let unix_s = start.as_microsecond() as f64 / 1e6 + time_s;
    Timestamp::from_millisecond((unix_s * 1e3).round() as i64).ok()
}

fn kml(points: &[(f64, [f64; 2])]) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document><Placemark><name>Track</name><LineString><tessellate>1</tessellate><coordinates>\n",
    );
    for (_, [latitude, longitude]) in points {
        let _ = writeln!(text, "{longitude:.7},{latitude:.7}");
    }
    text + "</coordinates></LineString></Placemark></Document>\n</kml>\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coordinates::metres;

    #[test]
    fn exact_a_place_is_that_of_its_metres() {
        let origin = [54.3, 179.999_9];
        let there = [54.31, -179.98];
        let back = place(metres(there, origin), origin);
        // A tenth of a millimetre on the chart.
        assert!((back[0] - there[0]).abs() < 1e-9 && (back[1] - there[1]).abs() < 1e-9, "{back:?}");
    }

    #[test]
    fn exact_a_track_has_a_point_a_second_with_its_time() {
        let sample = |k: i32| Sample {
            time_s: 0.25 * f64::from(k),
            north_m: Some(f64::from(k)),
            east_m: Some(0.0),
            ..Sample::default()
        };
        let samples: Vec<Sample<f64>> = (0..9).map(sample).collect();
        let written = |format| {
            write_track(format, &samples, [50.0, 8.0], Some("2026-05-01T10:00:00Z")).unwrap()
        };
        let gpx = written(TrackFormat::Gpx);
        assert_eq!(gpx.matches("<trkpt").count(), 3);
        assert!(
            gpx.contains("lat=\"50.0000000\" lon=\"8.0000000\"><time>2026-05-01T10:00:00Z</time>"),
            "{gpx}"
        );
        assert!(gpx.contains("<time>2026-05-01T10:00:02Z</time>"), "{gpx}");
        assert!(written(TrackFormat::Kml).contains("8.0000000,50.0000000\n"));
        assert_eq!(write_track(TrackFormat::Gpx, &samples[..3], [50.0, 8.0], None), None);
    }
}
