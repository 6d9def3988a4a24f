//! `seatrial inspect`: what is in a log, and can a model be identified from it?

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args as ClapArgs;
use seatrial::Window;
use seatrial::identification::{Reason, ReasonCode, Verdict};
use seatrial::manoeuvre::{Manoeuvre, Stroke};
use seatrial::segmentation::{Kind, Proposal, Segment, find, propose};
use seatrial::verdict::refuse_record;
use seatrial_app::documents::Source;
use seatrial_app::logs::OpenedLog;
use seatrial_core::{Real, Sample};
use seatrial_logs::{Channel, Quantity, UnitSource};
use seatrial_report::{Found, render_found};
use serde::Serialize;

use crate::log::{self, LogArgs};
use crate::model_text::windows_text;
use crate::output::{Exit, Failure, Output, save_page};
use crate::report::source;
use crate::table::Table;
use seatrial_core::RudderUnit;

/// What is in a log: channels, rates, gaps, units and signs, manoeuvres; is it usable and if not why.
#[derive(ClapArgs, Debug)]
#[command(
    after_help = "Example:\n  seatrial sim log --seed 1 --out run.csv && seatrial inspect run.csv"
)]
pub struct Args {
    #[command(flatten)]
    log: LogArgs,
    /// Write a page with the record and its manoeuvres shaded.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

/// An interval longer than this many median intervals is a gap.
const GAP_INTERVALS: f64 = 3.0;

/// Manoeuvres that the text lists; JSON lists all.
const LISTED_MANOEUVRES: usize = 24;

/// Characters of a sparkline.
const SPARKLINE_WIDTH: usize = 64;

/// `inspect --json`.
#[derive(Debug, Serialize)]
pub struct Inspection {
    schema: &'static str,
    source: Source,
    sampling: Sampling,
    ranges: Vec<Range>,
    /// Does the heading turn up where the rudder is positive? `None` where the log does not show it.
    positive_rudder_turns_up: Option<bool>,
    manoeuvres: Vec<Segment>,
    /// Which of them `identify` takes, where no windows are given.
    windows: Vec<Proposal>,
    verdict: Verdict,
}

/// When the samples were taken.
#[derive(Debug, Serialize)]
struct Sampling {
    samples: usize,
    span: Option<Window>,
    median_interval_s: Option<f64>,
    rate_hz: Option<f64>,
    /// Robust standard deviation of the intervals, s.
    jitter_s: Option<f64>,
    gaps: usize,
    largest_gap: Option<Window>,
}

/// The values of one quantity in SI units; the heading is unwrapped.
#[derive(Debug, Serialize)]
struct Range {
    quantity: Quantity,
    samples: usize,
    lowest: f64,
    highest: f64,
    mean: f64,
    standard_deviation: f64,
}

/// Inspects a log.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let opened = log::open(&args.log.log, &args.log.channels, None)?;
    let inspection = Inspection::of(&opened);
    output.print(&inspection, || text(&opened, &inspection))?;
    if let Some(path) = &args.report {
        save_page(path, &report_page(&opened, &inspection))?;
    }
    Ok(if inspection.verdict.accepted {
        Exit::Done
    } else {
        Exit::Rejected
    })
}

fn report_page(opened: &OpenedLog, inspection: &Inspection) -> String {
    let name = opened.path.file_name().unwrap_or(opened.path.as_os_str());
    render_found(&Found {
        name: &name.to_string_lossy(),
        record: &opened.record,
        segments: &inspection.manoeuvres,
        proposals: &inspection.windows,
        rudder_unit: opened.rudder_unit().for_people(),
        provenance: &source("Log", opened),
    })
}

impl Inspection {
    /// What is in a log.
    pub fn of(opened: &OpenedLog) -> Self {
        let samples = opened.record.samples.as_slice();
        let channels = &opened.description.channels;
        let ranges: Vec<Range> = channels
            .iter()
            .filter(|channel| channel.quantity != Quantity::Time)
            .filter_map(|channel| Range::of(channel.quantity, &series(samples, channel.quantity)))
            .collect();
        let rudder = Manoeuvre::find(samples);
        let manoeuvres = find(samples);
        Self {
            schema: "seatrial.inspection.v1",
            source: opened.source(),
            sampling: Sampling::of(opened),
            positive_rudder_turns_up: rudder
                .as_ref()
                .and_then(|rudder| positive_rudder_turns_up(samples, &rudder.strokes)),
            windows: propose(&opened.record, &manoeuvres),
            manoeuvres,
            verdict: verdict(samples.len(), &ranges, opened.rudder_unit()),
            ranges,
        }
    }
}

fn verdict(samples: usize, ranges: &[Range], rudder_unit: RudderUnit) -> Verdict {
    let spread_rad = |quantity: Quantity| {
        ranges
            .iter()
            .find(|range| range.quantity == quantity)
            .map_or(0.0, |range| range.highest - range.lowest)
    };
    let refusal = refuse_record(
        samples,
        0.5 * spread_rad(Quantity::Rudder),
        rudder_unit,
        spread_rad(Quantity::Heading),
    );
    Verdict {
        accepted: refusal.is_none(),
        reasons: vec![refusal.unwrap_or_else(|| Reason {
            code: ReasonCode::Ok,
            text: "rudder and heading both move: a model may be identified".into(),
        })],
    }
}

impl Sampling {
    fn of(opened: &OpenedLog) -> Self {
        let samples = &opened.record.samples;
        let median_interval_s = opened.record.median_interval_s();
        let intervals = || {
            samples.windows(2).map(|pair| Window {
                from_s: pair[0].time_s,
                to_s: pair[1].time_s,
            })
        };
        let length = |window: &Window| window.to_s - window.from_s;
        let is_gap = |window: &Window| {
            median_interval_s.is_some_and(|median| length(window) > GAP_INTERVALS * median)
        };
        let mut deviations: Vec<f64> = intervals()
            .map(|window| (length(&window) - median_interval_s.unwrap_or(0.0)).abs())
            .collect();
        deviations.sort_by(f64::total_cmp);
        Self {
            samples: samples.len(),
            span: match samples.as_slice() {
                [first, .., last] => Some(Window {
                    from_s: first.time_s,
                    to_s: last.time_s,
                }),
                _ => None,
            },
            median_interval_s,
            rate_hz: median_interval_s.map(|interval| 1.0 / interval),
            // 1.4826 median absolute deviations are one standard deviation of a normal distribution.
            jitter_s: deviations
                .get(deviations.len() / 2)
                .map(|median| 1.4826 * median),
            gaps: intervals().filter(is_gap).count(),
            largest_gap: intervals()
                .filter(is_gap)
                .max_by(|a, b| length(a).total_cmp(&length(b))),
        }
    }
}

impl Range {
    fn of(quantity: Quantity, values: &[Option<f64>]) -> Option<Self> {
        let present = || values.iter().flatten();
        let samples = present().count();
        if samples == 0 {
            return None;
        }
        let count = samples as f64;
        let mean = present().sum::<f64>() / count;
        let variance = present().map(|v| (v - mean).powi(2)).sum::<f64>() / count;
        Some(Self {
            quantity,
            samples,
            lowest: present().fold(f64::INFINITY, |a, b| a.min(*b)),
            highest: present().fold(f64::NEG_INFINITY, |a, b| a.max(*b)),
            mean,
            standard_deviation: variance.sqrt(),
        })
    }
}

/// One quantity of every sample, in SI units; the heading is unwrapped.
fn series(samples: &[Sample<f64>], quantity: Quantity) -> Vec<Option<f64>> {
    let of = |sample: &Sample<f64>| match quantity {
        Quantity::Time => Some(sample.time_s),
        Quantity::Heading => Some(sample.heading_rad),
        Quantity::Rudder => Some(sample.rudder_rad),
        Quantity::Speed => sample.surge_speed_m_s,
        Quantity::Depth => sample.depth_m,
        Quantity::Altitude => sample.altitude_m,
        Quantity::Roll => sample.roll_rad,
        Quantity::Pitch => sample.pitch_rad,
        Quantity::YawRate => sample.yaw_rate_rad_s,
        Quantity::North => sample.north_m,
        Quantity::East => sample.east_m,
        Quantity::Thrust => sample.thrust,
    };
    let mut values: Vec<Option<f64>> = samples.iter().map(of).collect();
    if quantity == Quantity::Heading {
        let mut before: Option<f64> = None;
        for value in values.iter_mut().flatten() {
            if let Some(before) = before {
                *value = before + (*value - before).wrapped();
            }
            before = Some(*value);
        }
    }
    values
}

/// The heading bends towards the hand to which the rudder is laid: second difference over each stroke.
fn positive_rudder_turns_up(samples: &[Sample<f64>], strokes: &[Stroke]) -> Option<bool> {
    let heading = series(samples, Quantity::Heading);
    let at = |time_s: f64| {
        let index = samples.partition_point(|sample| sample.time_s < time_s);
        heading
            .get(index.min(samples.len().saturating_sub(1)))
            .copied()
            .flatten()
    };
    let mut votes = [0_usize; 2];
    for stroke in strokes {
        let Window { from_s, to_s } = stroke.window;
        let bend = at(from_s)? - 2.0 * at(0.5 * (from_s + to_s))? + at(to_s)?;
        if bend != 0.0 {
            votes[usize::from((bend > 0.0) == stroke.positive)] += 1;
        }
    }
    // Under three quarters of the strokes the log does not show it.
    let [down, up] = votes;
    match (4 * up >= 3 * (up + down), 4 * down >= 3 * (up + down)) {
        (true, false) => Some(true),
        (false, true) => Some(false),
        _ => None,
    }
}

fn text(opened: &OpenedLog, inspection: &Inspection) -> String {
    let mut text = String::new();
    let _ = write_text(&mut text, opened, inspection);
    text
}

fn write_text(text: &mut String, opened: &OpenedLog, inspection: &Inspection) -> std::fmt::Result {
    let sampling = &inspection.sampling;
    writeln!(text, "{}", opened.path.display())?;
    write!(
        text,
        "{} samples of {} rows",
        sampling.samples, opened.counts.rows
    )?;
    if let (Some(span), Some(rate_hz), Some(jitter_s)) =
        (sampling.span, sampling.rate_hz, sampling.jitter_s)
    {
        write!(
            text,
            ", {:.3} to {:.3} s at {rate_hz:.4} Hz, jitter {:.1} ms, ",
            span.from_s,
            span.to_s,
            1e3 * jitter_s
        )?;
        match sampling.largest_gap {
            None => write!(text, "no gaps")?,
            Some(gap) => write!(
                text,
                "{} gaps, the largest of {:.3} s at {:.3} s",
                sampling.gaps,
                gap.to_s - gap.from_s,
                gap.from_s
            )?,
        }
    }
    writeln!(text, "\n")?;

    text.push_str(&channels_text(opened, inspection));
    let samples = &opened.record.samples;
    writeln!(text)?;
    for quantity in [Quantity::Rudder, Quantity::Heading] {
        writeln!(
            text,
            "{:9} {}",
            quantity.name(),
            sparkline(&series(samples, quantity))
        )?;
    }
    writeln!(text, "{:9} {}", "", ruler(samples, &inspection.manoeuvres))?;

    writeln!(text)?;
    text.push_str(&manoeuvres_text(opened, inspection));
    writeln!(
        text,
        "{}",
        match inspection.positive_rudder_turns_up {
            Some(true) => "positive rudder turns towards increasing heading: b2 will be positive",
            Some(false) => "positive rudder turns towards decreasing heading: b2 will be negative",
            None => "the strokes do not show to which side positive rudder turns",
        }
    )?;
    writeln!(
        text,
        "\n{}",
        if inspection.verdict.accepted {
            "usable"
        } else {
            "not usable"
        }
    )?;
    for reason in &inspection.verdict.reasons {
        writeln!(text, "  {}", reason.text)?;
    }
    Ok(())
}

/// Quantity, column, range and unit of every channel, each beneath the other.
fn channels_text(opened: &OpenedLog, inspection: &Inspection) -> String {
    let ranges = &inspection.ranges;
    let range = |channel: &Channel| {
        let range = ranges.iter().find(|r| r.quantity == channel.quantity);
        range.map_or(String::new(), |range| {
            range_text(range, opened.rudder_unit())
        })
    };
    let channels = &opened.description.channels;
    let rows = || channels.iter().map(|channel| (channel, range(channel)));
    let column_width = rows()
        .map(|(channel, _)| channel.column.chars().count())
        .max();
    let range_width = rows().map(|(_, range)| range.chars().count()).max();
    let (column_width, range_width) = (column_width.unwrap_or(0), range_width.unwrap_or(0));
    let line = |(channel, range): (&Channel, String)| {
        format!(
            "{:9} {:column_width$}  {range:range_width$}  {}\n",
            channel.quantity.name(),
            channel.column,
            unit_text(channel)
        )
    };
    rows().map(line).collect()
}

fn unit_text(channel: &Channel) -> String {
    match (channel.unit_source, &channel.because) {
        (UnitSource::Chosen, _) => format!("{} (chosen)", channel.unit),
        (UnitSource::Stated, None) => format!("{} (stated)", channel.unit),
        (UnitSource::Stated, Some(because)) => format!("{} (stated: {because})", channel.unit),
        (UnitSource::Assumed, None) => format!("{} (assumed)", channel.unit),
        (UnitSource::Assumed, Some(because)) => {
            format!("{} (assumed: {because})", channel.unit)
        }
    }
}

fn range_text(range: &Range, rudder_unit: RudderUnit) -> String {
    let (scale, unit) = match range.quantity {
        Quantity::Rudder => rudder_unit.for_people(),
        Quantity::Thrust => (100.0, "% of full"),
        Quantity::Heading | Quantity::Roll | Quantity::Pitch => (1_f64.to_degrees(), "deg"),
        Quantity::YawRate => (1_f64.to_degrees(), "deg/s"),
        Quantity::Speed => (1.0, "m/s"),
        _ => (1.0, "m"),
    };
    format!(
        "{:.2} to {:.2} {unit}, mean {:.2}",
        range.lowest * scale,
        range.highest * scale,
        range.mean * scale
    )
}

/// What was found, in a table.
fn manoeuvres_text(opened: &OpenedLog, inspection: &Inspection) -> String {
    let found = &inspection.manoeuvres;
    let missing = || "-".to_string();
    let (rudder_scale, rudder_unit) = opened.rudder_unit().for_people();
    let mut table = Table::new(&[
        ("", ""),
        ("from", "s"),
        ("to", "s"),
        ("rudder", rudder_unit),
        ("thrust", "%"),
        ("speed", "m/s"),
        ("turned", "deg rms"),
        ("samples", "%"),
    ]);
    for segment in found.iter().take(LISTED_MANOEUVRES) {
        let rudder = match segment.kind {
            Kind::Steady => missing(),
            _ => format!("{:.1}", rudder_scale * segment.amplitude_rad),
        };
        table.row(vec![
            segment.kind.name().to_string(),
            format!("{:.2}", segment.window.from_s),
            format!("{:.2}", segment.window.to_s),
            rudder,
            segment
                .thrust
                .map_or_else(missing, |thrust| format!("{:.0}", 100.0 * thrust)),
            segment
                .surge_speed_m_s
                .map_or_else(missing, |speed| format!("{speed:.2}")),
            format!("{:.1}", segment.excitation_rad.to_degrees()),
            format!("{:.0}", 100.0 * segment.completeness),
        ]);
    }
    let mut text = if found.is_empty() {
        "no manoeuvre from rest\n".to_string()
    } else {
        table.to_string()
    };
    if let Some(more @ 1..) = found.len().checked_sub(LISTED_MANOEUVRES) {
        let _ = writeln!(text, "and {more} more, which --json lists");
    }
    for proposal in &inspection.windows {
        let _ = writeln!(text, "identify takes, at {}", windows_text(proposal));
    }
    text
}

/// The first letter of each manoeuvre under the sparklines, a line under steady runs.
fn ruler(samples: &[Sample<f64>], found: &[Segment]) -> String {
    samples
        .chunks(samples.len().div_ceil(SPARKLINE_WIDTH).max(1))
        .map(|bin| {
            let (from_s, to_s) = (bin[0].time_s, bin[bin.len() - 1].time_s);
            let inside = |s: &&Segment| s.window.from_s <= to_s && s.window.to_s > from_s;
            let is_steady = |s: &&Segment| s.kind == Kind::Steady;
            match found.iter().filter(inside).min_by_key(is_steady) {
                Some(segment) if segment.kind == Kind::Steady => '-',
                Some(segment) => segment.kind.name().chars().next().unwrap_or(' '),
                None => ' ',
            }
        })
        .collect()
}

/// The values over time in 64 bars.
fn sparkline(values: &[Option<f64>]) -> String {
    const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let bins: Vec<Option<f64>> = values
        .chunks(values.len().div_ceil(SPARKLINE_WIDTH).max(1))
        .map(|bin| {
            let count = bin.iter().flatten().count();
            (count > 0).then(|| bin.iter().flatten().sum::<f64>() / count as f64)
        })
        .collect();
    let lowest = bins.iter().flatten().fold(f64::INFINITY, |a, b| a.min(*b));
    let highest = bins
        .iter()
        .flatten()
        .fold(f64::NEG_INFINITY, |a, b| a.max(*b));
    bins.iter()
        .map(|bin| match bin {
            Some(value) if highest > lowest => {
                let height = (value - lowest) / (highest - lowest);
                BARS[((height * 8.0) as usize).min(7)]
            }
            Some(_) => BARS[0],
            None => ' ',
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A doublet with the heading that 1 / s^2 makes of it.
    fn doublet() -> Vec<Sample<f64>> {
        let (mut heading_rad, mut rate) = (6.2, 0.0);
        (0..330)
            .map(|k| {
                let time_s = f64::from(k) * 0.05;
                let rudder_rad = match k {
                    40..80 => 0.26,
                    80..120 => -0.26,
                    _ => 0.0,
                };
                rate += 0.05 * rudder_rad;
                heading_rad += 0.05 * rate;
                Sample {
                    time_s,
                    heading_rad: Real::wrapped(heading_rad),
                    rudder_rad,
                    ..Sample::default()
                }
            })
            .collect()
    }

    #[test]
    fn exact_the_side_to_which_positive_rudder_turns() {
        let samples = doublet();
        let rudder = Manoeuvre::find(&samples).unwrap();
        assert_eq!(
            positive_rudder_turns_up(&samples, &rudder.strokes),
            Some(true)
        );
        let mirrored: Vec<_> = samples
            .iter()
            .map(|s| Sample {
                heading_rad: -s.heading_rad,
                ..*s
            })
            .collect();
        assert_eq!(
            positive_rudder_turns_up(&mirrored, &rudder.strokes),
            Some(false)
        );
    }

    #[test]
    fn exact_sparkline_shows_low_and_high() {
        assert_eq!(sparkline(&[Some(0.0), None, Some(1.0)]), "▁ █");
        assert_eq!(sparkline(&[Some(2.0), Some(2.0)]), "▁▁");
        assert_eq!(sparkline(&[]), "");
    }
}
