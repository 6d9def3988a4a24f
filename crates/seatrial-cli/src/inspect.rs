//! `seatrial inspect`: what is in a log, and can a model be identified from it?

use std::fmt::Write;

use clap::Args as ClapArgs;
use seatrial::identification::Verdict;
use seatrial::log::segmentation::{Kind, Segment};
use seatrial_app::inspect_log::{Inspection, Range, series};
use seatrial_app::log_page::{source, windows_text};
use seatrial_app::logs::OpenedLog;
use seatrial_app::next;
use seatrial_core::{RudderUnit, Sample};
use seatrial_logs::{Channel, Quantity, UnitSource};
use seatrial_report::{LogManoeuvres, render_found};

use crate::identify::{call, cause_text};
use crate::log::{self, LogArgs};
use crate::output::{Exit, Failure, Output, OutputPath};
use crate::screen::{command, labelled, width, wrapped};
use crate::table::Table;
use crate::track;

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
    report: Option<OutputPath>,
    /// Write the track for charts and maps, where the log has latitude and longitude.
    #[arg(long, value_name = "FILE.gpx|FILE.kml")]
    track: Option<OutputPath>,
}

/// Manoeuvres that the text lists; JSON lists all.
const LISTED_MANOEUVRES: usize = 24;

/// Columns that the unit of a channel takes at least; with less room it has lines of its own, so far in.
const LEAST_ROOM: usize = 24;
const INDENT: &str = "          ";

/// Most characters of a sparkline.
const SPARKLINE_WIDTH: usize = 64;

/// Inspects a log.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let opened = log::open(&args.log.log, &args.log.channels, None)?;
    let inspection = Inspection::of(&opened);
    if let Some(path) = &args.report {
        output.save(path, report_page(&opened, &inspection))?;
    }
    if let Some(path) = &args.track {
        output.save(path, track::of_log(&opened, path)?)?;
    }
    output.print(&inspection, || text(&opened, &inspection))?;
    Ok(Exit::of(&inspection.verdict))
}

fn report_page(opened: &OpenedLog, inspection: &Inspection) -> String {
    let name = opened.path.file_name().unwrap_or(opened.path.as_os_str());
    render_found(&LogManoeuvres {
        name: &name.to_string_lossy(),
        record: &opened.record,
        segments: &inspection.manoeuvres,
        proposals: &inspection.windows,
        rudder_unit: opened.rudder_unit().for_people(),
        provenance: &source("Log", opened),
    })
}

fn text(opened: &OpenedLog, inspection: &Inspection) -> String {
    let mut text = String::new();
    let _ = write_text(&mut text, opened, inspection);
    text
}

fn write_text(text: &mut String, opened: &OpenedLog, inspection: &Inspection) -> std::fmt::Result {
    let sampling = &inspection.sampling;
    writeln!(text, "{}", opened.path.display())?;
    write!(text, "{} samples of {} rows", sampling.samples, opened.counts.rows)?;
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
    let (head, width) = (std::mem::take(text), width());
    text.push_str(&wrapped(&head, width));
    writeln!(text)?;

    text.push_str(&channels_text(opened, inspection));
    let samples = &opened.record.samples;
    writeln!(text)?;
    let bars = SPARKLINE_WIDTH.min(width.saturating_sub(INDENT.len()));
    for quantity in [Quantity::Rudder, Quantity::Heading] {
        writeln!(text, "{:9} {}", quantity.name(), sparkline(&series(samples, quantity), bars))?;
    }
    let ruler = ruler(samples, &inspection.manoeuvres, bars);
    writeln!(text, "{INDENT}{}", ruler.trim_end())?;

    writeln!(text)?;
    text.push_str(&manoeuvres_text(opened, inspection));
    let side = match inspection.positive_rudder_turns_up {
        Some(true) => "positive rudder turns towards increasing heading: b2 will be positive",
        Some(false) => "positive rudder turns towards decreasing heading: b2 will be negative",
        None => "the strokes do not show to which side positive rudder turns",
    };
    text.push_str(&labelled("", side, width));
    text.push_str(&verdict_text(&inspection.verdict));
    Ok(())
}

/// What `identify` says of the log, and the command that says more.
fn verdict_text(verdict: &Verdict) -> String {
    let width = width();
    let call = next::with_verb(&call(), "identify");
    let mut text = format!("\n{}\n", verdict.outcome().name().to_uppercase());
    text += &cause_text(verdict, &format!("{call} --verbose"), width);
    text + &command("Next   ", &call, width)
}

/// Quantity, column, range and unit of every channel, each beneath the other.
fn channels_text(opened: &OpenedLog, inspection: &Inspection) -> String {
    let ranges = &inspection.ranges;
    let range = |channel: &Channel| {
        let range = ranges.iter().find(|r| r.quantity == channel.quantity);
        range.map_or(String::new(), |range| range_text(range, opened.rudder_unit()))
    };
    let channels = &opened.description.channels;
    let rows = || channels.iter().map(|channel| (channel, range(channel)));
    let column_width = rows().map(|(channel, _)| channel.column.chars().count()).max();
    let range_width = rows().map(|(_, range)| range.chars().count()).max();
    let (column_width, range_width) = (column_width.unwrap_or(0), range_width.unwrap_or(0));
    let screen = width();
    let line = |(channel, range): (&Channel, String)| {
        let start = format!(
            "{:9} {:column_width$}  {range:range_width$}  ",
            channel.quantity.name(),
            channel.column,
        );
        let unit = unit_text(channel);
        let (has_begun, length) = (start.trim_end(), start.chars().count());
        if length + unit.chars().count().min(LEAST_ROOM) <= screen {
            labelled(&start, &unit, screen)
        } else if has_begun.chars().count() <= screen {
            format!("{has_begun}\n{}", labelled(INDENT, &unit, screen))
        } else {
            let name = format!("{:9} {}", channel.quantity.name(), channel.column);
            let range = format!("{INDENT}{}  ", range.trim());
            format!("{name}\n{}", labelled(&range, &unit, screen))
        }
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
    let mut table = Table::under(&format!(
        " | from [s] | to [s] | rudder [{rudder_unit}] | thrust [%] | speed [m/s] | turned [deg rms] | \
            samples [%]"
    ));
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
            segment.thrust.map_or_else(missing, |thrust| format!("{:.0}", 100.0 * thrust)),
            segment.surge_speed_m_s.map_or_else(missing, |speed| format!("{speed:.2}")),
            format!("{:.1}", segment.excitation_rad.to_degrees()),
            format!("{:.0}", 100.0 * segment.completeness),
        ]);
    }
    let mut text = if found.is_empty() {
        "no manoeuvre from rest\n".to_string()
    } else {
        table.fitted(width(), &["samples", "turned"])
    };
    if let Some(more @ 1..) = found.len().checked_sub(LISTED_MANOEUVRES) {
        let _ = writeln!(text, "and {more} more, which --json lists");
    }
    for proposal in &inspection.windows {
        let taken = format!("at {}", windows_text(proposal));
        text += &labelled("identify takes, ", &taken, width());
    }
    text
}

/// The first letter of each manoeuvre under the sparklines, a line under steady runs.
fn ruler(samples: &[Sample<f64>], found: &[Segment], bars: usize) -> String {
    samples
        .chunks(samples.len().div_ceil(bars).max(1))
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

/// The values over time in at most so many bars.
fn sparkline(values: &[Option<f64>], bars: usize) -> String {
    const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let bins: Vec<Option<f64>> = values
        .chunks(values.len().div_ceil(bars).max(1))
        .map(|bin| {
            let count = bin.iter().flatten().count();
            (count > 0).then(|| bin.iter().flatten().sum::<f64>() / count as f64)
        })
        .collect();
    let lowest = bins.iter().flatten().fold(f64::INFINITY, |a, b| a.min(*b));
    let highest = bins.iter().flatten().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
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

    #[test]
    fn exact_sparkline_shows_low_and_high() {
        assert_eq!(sparkline(&[Some(0.0), None, Some(1.0)], 3), "▁ █");
        assert_eq!(sparkline(&[Some(2.0), Some(2.0)], 2), "▁▁");
        assert_eq!(sparkline(&[], 64), "");
    }
}
