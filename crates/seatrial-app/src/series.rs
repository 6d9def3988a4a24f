//! Records as columns to be drawn.

use seatrial::{Identification, Record, Run, Window};
use seatrial_core::{Real, Sample};
use seatrial_logs::{TrackFormat, write_track};
use seatrial_report::overlay;

use serde::{Deserialize, Serialize};

/// Most samples of a record that are drawn.
const MOST_DRAWN: usize = 5000;

/// Columns of equal length; of a long log every n-th sample.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct LogSeries {
    /// The log's own seconds.
    pub time_s: Vec<Option<f64>>,
    /// Heading, unwrapped, rad.
    pub heading_rad: Vec<Option<f64>>,
    /// Rudder, rad or a fraction of full as the document says.
    pub rudder: Vec<Option<f64>>,
    /// Measured yaw rate, rad/s.
    pub yaw_rate_rad_s: Vec<Option<f64>>,
    /// Forward speed, m/s.
    pub surge_speed_m_s: Vec<Option<f64>>,
    /// Heading simulated over the validation window with the model, rad; null outside.
    pub simulated_heading_rad: Vec<Option<f64>>,
    /// Position north of the origin, m.
    pub north_m: Vec<Option<f64>>,
    /// Position east of the origin, m.
    pub east_m: Vec<Option<f64>>,
}

/// The columns of a record, and where it was validated the simulation of the model.
pub fn series_of(record: &Record, validated: Option<(&Identification, Window)>) -> LogSeries {
    let samples = &record.samples;
    let stride = samples.len().div_ceil(MOST_DRAWN).max(1);
    let simulated =
        validated.map_or_else(Vec::new, |(model, window)| overlay(record, window, model));
    let finite = |value: f64| Some(value).filter(|value| value.is_finite());
    let mut series = LogSeries::default();
    let mut heading_rad: Option<f64> = None;
    for (place, sample) in samples.iter().enumerate() {
        if sample.heading_rad.is_finite() {
            heading_rad =
                Some(heading_rad.map_or(sample.heading_rad, |last| {
                    last + (sample.heading_rad - last).wrapped()
                }));
        }
        if place % stride != 0 {
            continue;
        }
        let at = simulated.binary_search_by(|at| at.time_s.total_cmp(&sample.time_s));
        // The simulation is unwrapped from another turn than the record may be.
        let simulated_rad = at.ok().zip(heading_rad).map(|(k, heading_rad)| {
            let at = &simulated[k];
            heading_rad + at.simulated_rad - at.measured_rad
        });
        series.time_s.push(finite(sample.time_s));
        series.heading_rad.push(heading_rad.filter(|_| sample.heading_rad.is_finite()));
        series.rudder.push(finite(sample.rudder_rad));
        series.yaw_rate_rad_s.push(sample.yaw_rate_rad_s.and_then(finite));
        series.simulated_heading_rad.push(simulated_rad.and_then(finite));
        series.surge_speed_m_s.push(sample.surge_speed_m_s.and_then(finite));
        series.north_m.push(sample.north_m.and_then(finite));
        series.east_m.push(sample.east_m.and_then(finite));
    }
    series
}

/// The track of runs in a form that charts open. Their positions are metres from `origin_deg`, latitude and longitude; the first
/// sample was taken at `start_utc`. `None`: they have no positions.
pub fn track_of_runs(
    format: TrackFormat,
    runs: &[Run],
    origin_deg: [f64; 2],
    start_utc: &str,
) -> Option<String> {
    let samples = runs.iter().flat_map(|run| &run.record.samples);
    let begin_s = samples.clone().next()?.time_s;
    let since = |sample: &Sample<f64>| Sample { time_s: sample.time_s - begin_s, ..*sample };
    let samples: Vec<Sample<f64>> = samples.map(since).collect();
    write_track(format, &samples, origin_deg, Some(start_utc))
}
