//! `seatrial manoeuvres`: the standard manoeuvres of ships, predicted from a model or read from a log.

use std::path::PathBuf;

use clap::{Args as ClapArgs, Subcommand};
use seatrial::Window;
use seatrial::sea_trials::ship_manoeuvres::{Kind, ShipManoeuvres};
use seatrial::words::within;
use seatrial_app::ship_trials::{DRAWS, ManoeuvreRequest, OwnError, of_record, predicted};
use seatrial_report::render_ship_manoeuvres;

use crate::choice::one_of;
use crate::export::VehicleArgs;
use crate::log::{self, ChannelArgs, LogArgs};
use crate::output::{Exit, Failure, Output, OutputPath};
use crate::screen::{width, wrapped};
use crate::table::Table;

/// Zig-zags, turning circles, pull-out, spiral and inertia stop, with intervals, against the criteria of the IMO.
///
/// They are predicted from a model: the interval of each figure holds 95 % of those of vehicles drawn from what is known of it.
#[derive(ClapArgs)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "\
Example:
  seatrial manoeuvres --a22 -0.05 --b2 0.0026 --speed 7.7 \\
      --rudder-limit-deg 35 --length 170 --report form.html"
)]
pub struct Args {
    #[command(subcommand)]
    what: Option<What>,
    #[command(flatten)]
    predict: Predict,
}

#[derive(Subcommand)]
enum What {
    Read(Box<Read>),
}

#[derive(ClapArgs)]
struct Predict {
    /// Thrust as a fraction of full [default: the fastest of the models].
    #[arg(long, value_name = "FRACTION")]
    thrust: Option<f64>,
    /// Vehicles drawn for the intervals; 0 for none.
    #[arg(long, value_name = "N", default_value_t = DRAWS, value_parser = clap::value_parser!(u64).range(0..=100_000))]
    draws: u64,
    /// Seed of the first of them.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// A zig-zag besides the 10/10 and the 20/20, by rudder angle and heading change, degrees.
    #[arg(long, value_name = "RUDDER/HEADING", value_parser = zig_zag)]
    zig_zag: Option<[f64; 2]>,
    /// The log that the model was identified from, with a zig-zag: what the model lacks on it widens the intervals of the overshoots.
    #[arg(long, value_name = "LOG")]
    own_log: Option<PathBuf>,
    #[command(flatten)]
    form: FormArgs,
    #[command(flatten)]
    vehicle: VehicleArgs,
}

/// Read zig-zag, turning circle, pull-out, spiral and stop from a log.
#[derive(ClapArgs)]
#[command(after_help = "\
Exit code 4: the log does not hold the manoeuvre; the message says why.

Example:
  seatrial sim log --seed 1 --out run.csv && \\
      seatrial manoeuvres read run.csv --manoeuvre pull-out --length 1.7")]
struct Read {
    /// The manoeuvre to read [default: all that the log holds].
    #[arg(long, value_name = "KIND", value_parser = one_of(Kind::ALL.map(|kind| (kind, kind.name(), ""))))]
    manoeuvre: Option<Kind>,
    /// Where the manoeuvre begins in the log, s.
    #[arg(long, value_name = "S")]
    from: Option<f64>,
    /// Where it ends, s.
    #[arg(long, value_name = "S")]
    to: Option<f64>,
    #[command(flatten)]
    form: FormArgs,
    #[command(flatten)]
    log: LogArgs,
}

/// The whole of a log.
const EVERYTHING: Window = Window { from_s: f64::NEG_INFINITY, to_s: f64::INFINITY };

#[derive(ClapArgs)]
struct FormArgs {
    /// Length between perpendiculars, m: the figures are held against the criteria of MSC.137(76).
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    length: Option<f64>,
    /// Write the form, to print.
    #[arg(long, value_name = "FILE.html")]
    report: Option<OutputPath>,
}

fn zig_zag(text: &str) -> Result<[f64; 2], String> {
    let angles = text
        .split_once('/')
        .and_then(|(rudder, heading)| Some([rudder.parse().ok()?, heading.parse().ok()?]));
    angles
        .filter(|angles| angles.iter().all(|angle: &f64| *angle > 0.0 && *angle < 90.0))
        .ok_or_else(|| "expected the angles of rudder and heading, degrees, as in 20/10".into())
}

/// Runs the verb.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    if let Some(What::Read(args)) = &args.what {
        return read(args, output);
    }
    let args = &args.predict;
    let (vehicle, exit) = args.vehicle.vehicle()?;
    let own = |path: &PathBuf| {
        let opened = log::open(path, &ChannelArgs::default(), None)?;
        let all = opened.record.window(EVERYTHING);
        let name = path.display().to_string();
        Ok::<_, Failure>(OwnError::of(&vehicle, args.thrust, &name, all)?)
    };
    let wanted = ManoeuvreRequest {
        zig_zag_rad: args.zig_zag.map(|angles| angles.map(f64::to_radians)),
        own_error: args.own_log.as_ref().map(own).transpose()?,
        thrust: args.thrust,
        length_m: args.form.length,
        draws: args.draws,
        seed: args.seed,
    };
    print(&predicted(&vehicle, &wanted)?, &args.form, output)?;
    Ok(exit)
}

fn read(args: &Read, output: &Output) -> Result<Exit, Failure> {
    let window = Window {
        from_s: args.from.unwrap_or(f64::NEG_INFINITY),
        to_s: args.to.unwrap_or(f64::INFINITY),
    };
    let opened = log::open(&args.log.log, &args.log.channels, None)?;
    let name = args.log.log.display().to_string();
    let kind = args.manoeuvre;
    let samples = opened.record.window(window);
    let document = of_record(&name, samples, args.form.length, kind)?;
    print(&document, &args.form, output)?;
    Ok(Exit::Done)
}

fn print(document: &ShipManoeuvres, form: &FormArgs, output: &Output) -> Result<(), Failure> {
    if let Some(path) = &form.report {
        output.save(path, render_ship_manoeuvres(document))?;
    }
    output.print(document, || text(document))
}

fn text(document: &ShipManoeuvres) -> String {
    let how = if document.is_predicted { "predicted" } else { "read from the record" };
    let mut indices = Table::under("manoeuvre | figure |  | 95 % | unit");
    for index in &document.indices {
        let interval = index.interval_95.map_or("-".into(), |interval| {
            let ends = interval.map(|end| within(end, Some(interval)));
            format!("{} to {}", ends[0], ends[1])
        });
        indices.row(vec![
            index.manoeuvre.clone(),
            index.name.into(),
            within(index.value, index.interval_95),
            interval,
            index.unit.into(),
        ]);
    }
    let mut text = format!(
        "Manoeuvres of {}, {how}, at {:.2} m/s\n\n{indices}",
        document.vehicle, document.surge_speed_m_s
    );
    if !document.criteria.is_empty() {
        text += &format!("\n{}", criteria(document));
    }
    for note in &document.notes {
        text += &format!("\n{}\n", wrapped(note, width()));
    }
    text
}

fn criteria(document: &ShipManoeuvres) -> Table {
    let mut criteria = Table::under("MSC.137(76) | figure | value | at most | unit | ");
    for criterion in &document.criteria {
        criteria.row(vec![
            criterion.clause.into(),
            criterion.name.into(),
            format!("{:.2}", criterion.value),
            format!("{:.2}", criterion.limit),
            criterion.unit.into(),
            if criterion.holds { "holds" } else { "DOES NOT HOLD" }.into(),
        ]);
    }
    criteria
}
