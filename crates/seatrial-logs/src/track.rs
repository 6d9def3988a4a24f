//! Positions of a track in GPX or KML, which a log takes by their times.

use std::io::{BufRead, BufReader};
use std::path::Path;

#[cfg(feature = "containers")]
use quick_xml::Reader;
#[cfg(feature = "containers")]
use quick_xml::events::{BytesStart, Event};
use seatrial_core::Sample;

#[cfg(feature = "containers")]
use crate::clock::instant;
use crate::coordinates::metres;
use crate::error::{Fault, clipped};
use crate::input::{FileMap, Input};

/// Points that are kept.
#[cfg(feature = "containers")]
const MOST_POINTS: usize = 1 << 21;
/// Between points that are further apart no position is known, s.
const LONGEST_GAP_S: f64 = 30.0;

/// Points in the order of time.
pub(crate) struct Track {
    /// Seconds since 1970, metres north and east of the first point.
    points: Vec<[f64; 3]>,
    /// Latitude and longitude of the first point, deg.
    first: [f64; 2],
}

fn damaged(what: impl ToString) -> Fault {
    Fault::Damaged { format: "GPX or KML", what: clipped(&what.to_string()) }
}

impl Track {
    /// Reads `trkpt` of GPX, and `when` with `coord` or `coordinates` of KML.
    pub fn read(file: Input) -> Result<Self, Fault> {
        let Points { times_s, places } = points(BufReader::new(file))?;
        if times_s.len() != places.len() || times_s.len() < 2 {
            return Err(damaged(format!(
                "expected two points or more, each with its time; found {} times and {} places",
                times_s.len(),
                places.len()
            )));
        }
        let first = places[0];
        let mut points: Vec<[f64; 3]> = times_s
            .into_iter()
            .zip(places)
            .map(|(time_s, place)| {
                let [north_m, east_m] = metres(place, first);
                [time_s, north_m, east_m]
            })
            .collect();
        points.sort_by(|one, other| one[0].total_cmp(&other[0]));
        Ok(Self { points, first })
    }

    /// Metres north and east at a time, on the line between the points beside it.
    pub fn at(&self, unix_s: f64) -> Option<[f64; 2]> {
        let after = self.points.partition_point(|point| point[0] < unix_s);
        let [before_s, north_m, east_m] = self.points[after.saturating_sub(1)];
        let [after_s, next_north_m, next_east_m] = *self.points.get(after)?;
        if after_s == unix_s {
            return Some([next_north_m, next_east_m]);
        }
        let gap_s = after_s - before_s;
        if after == 0 || gap_s > LONGEST_GAP_S {
            return None;
        }
        let share = (unix_s - before_s) / gap_s;
        Some([north_m + share * (next_north_m - north_m), east_m + share * (next_east_m - east_m)])
    }
}

/// The positions of another file, for the samples of a log.
pub(crate) struct Positions {
    track: Track,
    named: String,
    /// Second 0 of the log.
    start_unix_s: f64,
    /// Samples with a position.
    found: u64,
}

impl Positions {
    /// Those of a track for a log that begins then.
    pub fn open(path: &Path, held: &FileMap, start_unix_s: Option<f64>) -> Result<Self, Fault> {
        let file = held.open(path).map_err(|source| Fault::Io { doing: "opened", source })?;
        Ok(Self {
            track: Track::read(file)?,
            named: path.display().to_string(),
            start_unix_s: start_unix_s.ok_or(Fault::NoDate)?,
            found: 0,
        })
    }

    /// Gives a sample its position, or none.
    pub fn place(&mut self, sample: &mut Sample<f64>) {
        let place = self.track.at(self.start_unix_s + sample.time_s);
        self.found += u64::from(place.is_some());
        (sample.north_m, sample.east_m) = place.map(|[north, east]| (north, east)).unzip();
    }

    /// The latitude and longitude from which they are metres, deg.
    pub fn origin_deg(&self) -> [f64; 2] {
        self.track.first
    }

    /// Where positions come from. Asked after the last sample.
    pub fn warning(&self) -> String {
        let named = clipped(&self.named);
        match self.found {
            0 => format!(
                "no sample is within the times of {named}: are both in UTC, and of one day?"
            ),
            found => format!("north and east of {found} samples are those of {named}, by time"),
        }
    }
}

/// What was read of points so far.
#[derive(Default)]
struct Points {
    times_s: Vec<f64>,
    /// Latitude and longitude, deg.
    places: Vec<[f64; 2]>,
}

#[cfg(not(feature = "containers"))]
fn points(_file: impl BufRead) -> Result<Points, Fault> {
    Err(Fault::NotBuilt { format: "a track", feature: "--features containers" })
}

#[cfg(feature = "containers")]
fn points(file: impl BufRead) -> Result<Points, Fault> {
    let mut reader = Reader::from_reader(file);
    let (mut points, mut buffer) = (Points::default(), Vec::new());
    let mut within = String::new();
    // Times of a GPX file stand in its head, too.
    let mut is_point = false;
    loop {
        buffer.clear();
        match reader.read_event_into(&mut buffer).map_err(damaged)? {
            Event::Start(start) => {
                within = start.local_name().as_ref().to_owned();
                if within == "trkpt" {
                    is_point = true;
                    points.places.extend(place(&start));
                }
            }
            Event::End(end) => {
                is_point &= end.local_name().as_ref() != "trkpt";
                within.clear();
            }
            Event::Text(text) => {
                let text = text.trim();
                match within.as_str() {
                    "time" if is_point => points.times_s.extend(unix_s(text)),
                    "when" => points.times_s.extend(unix_s(text)),
                    "coord" => points.places.extend(coordinates(text, ' ')),
                    "coordinates" => points.places.extend(coordinates(text, ',')),
                    _ => {}
                }
            }
            Event::Eof => return Ok(points),
            _ => {}
        }
        if points.places.len() > MOST_POINTS || points.times_s.len() > MOST_POINTS {
            return Err(damaged("it has more points than a track of any log"));
        }
    }
}

#[cfg(feature = "containers")]
fn unix_s(text: &str) -> Option<f64> {
    Some(instant(text)?.as_duration().as_secs_f64())
}

/// Longitude and latitude, and a height or none.
#[cfg(feature = "containers")]
fn coordinates(text: &str, between: char) -> Option<[f64; 2]> {
    let mut numbers = text.split(between).map(|number| number.trim().parse().ok());
    let (longitude, latitude) = (numbers.next()??, numbers.next()??);
    Some([latitude, longitude])
}

/// The attributes of a point.
#[cfg(feature = "containers")]
fn place(start: &BytesStart) -> Option<[f64; 2]> {
    let number = |name: &str| -> Option<f64> {
        let attribute = start.try_get_attribute(name).ok()??;
        attribute.value.trim().parse().ok()
    };
    Some([number("lat")?, number("lon")?])
}

#[cfg(all(test, feature = "containers"))]
mod tests {
    use super::*;

    fn track(text: &str) -> Result<Track, Fault> {
        Track::read(Input::of_memory(text.as_bytes().to_vec()))
    }

    #[test]
    fn exact_positions_lie_between_those_of_a_track() {
        let gpx = r#"<gpx><metadata><time>2020-01-01T00:00:00Z</time></metadata><trk><trkseg>
            <trkpt lat="50.0" lon="8.0"><ele>3</ele><time>2026-03-04T00:00:00Z</time></trkpt>
            <trkpt lat="50.001" lon="8.001"><time>2026-03-04T00:00:10Z</time></trkpt>
            <trkpt lat="50.002" lon="8.001"><time>2026-03-04T00:01:00Z</time></trkpt>
            </trkseg></trk></gpx>"#;
        let kml = r#"<kml><gx:Track><when>2026-03-04T00:00:00Z</when><when>2026-03-04T00:00:10Z</when>
            <when>2026-03-04T00:01:00Z</when><gx:coord>8.0 50.0 0</gx:coord><gx:coord>8.001 50.001 0</gx:coord>
            <gx:coord>8.001 50.002 0</gx:coord></gx:Track></kml>"#;
        let points = r#"<kml><Placemark><TimeStamp><when>2026-03-04T00:00:00Z</when></TimeStamp><Point><coordinates>8.0,50.0</coordinates></Point></Placemark>
            <Placemark><TimeStamp><when>2026-03-04T00:00:10Z</when></TimeStamp><Point><coordinates>8.001,50.001,2</coordinates></Point></Placemark></kml>"#;
        let start_s = 1_772_582_400.0;
        for (text, has_gap) in [(gpx, true), (kml, true), (points, false)] {
            let track = track(text).unwrap();
            assert_eq!(track.at(start_s), Some([0.0, 0.0]));
            let [north_m, east_m] = track.at(start_s + 5.0).unwrap();
            // Half a thousandth of a degree, and that times the cosine of 50 deg.
            assert!((north_m - 55.56).abs() < 0.01, "{north_m}");
            assert!((east_m - 35.71).abs() < 0.01, "{east_m}");
            assert_eq!(track.at(start_s - 1.0), None);
            assert_eq!(track.at(start_s + 61.0), None);
            assert!(!has_gap || track.at(start_s + 40.0).is_none());
        }
    }

    #[test]
    fn io_what_is_no_track_is_named() {
        for text in
            ["", "<gpx></gpx>", "<gpx><trkpt lat='1' lon='2'></trkpt></gpx>", "<gpx", "\u{0}"]
        {
            assert!(matches!(track(text), Err(Fault::Damaged { .. })), "{text}");
        }
    }
}
