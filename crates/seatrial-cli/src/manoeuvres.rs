//! `seatrial sim manoeuvres`: the standard manoeuvres of ship trials on a simulated vehicle.

use seatrial::sea_trials::field::{SpiralPoint, StandardManoeuvres};
use seatrial_app::simulated;
use seatrial_report as report;
use serde::Serialize;

use crate::output::{Exit, Failure, Output, OutputPath};
use crate::table::Table;

/// Rudder angles of the spiral, degrees.
const SPIRAL_DEG: [f64; 13] = [
    14.9, 12.0, 10.0, 5.0, 2.0, 1.0, 0.0, -1.0, -2.0, -5.0, -10.0, -12.0, -14.9,
];

/// Zig-zags of 10 and 20 degrees and Dieudonne's spiral.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Writes manoeuvres.html and manoeuvres.json.

Example:
  seatrial sim manoeuvres --vehicle sim:remus100 --thrust 0.8 --out manoeuvres")]
pub struct Args {
    /// The vehicle: sim:remus100, sim:starfish-6dof, sim:starfish or sim:FILE.toml.
    #[arg(long, value_name = "VEHICLE", default_value = "sim:remus100")]
    vehicle: String,
    /// Seed of noise and disturbance.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Thrust as a fraction of full; repeatable [default: 0.7, 0.8 and 0.9].
    #[arg(long, value_name = "FRACTION")]
    thrust: Vec<f64>,
    /// Directory for the files; made where it is missing.
    #[arg(long, value_name = "DIR")]
    out: OutputPath,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    vehicle: &'a str,
    seed: u64,
    manoeuvres: Vec<StandardManoeuvres>,
}

/// Runs the manoeuvres.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let thrusts = match &args.thrust[..] {
        [] => &[0.7, 0.8, 0.9][..],
        given => given,
    };
    if let Some(wrong) = thrusts.iter().find(|t| !(**t > 0.0 && **t <= 1.0)) {
        return Err(Failure::usage(format!(
            "--thrust {wrong}: expected a fraction of full, above 0 and at most 1"
        )));
    }
    let mut manoeuvres = Vec::new();
    for thrust in thrusts {
        let mut vehicle = simulated::vehicle(&args.vehicle, args.seed)?;
        let rudders = SPIRAL_DEG.map(f64::to_radians);
        let made = StandardManoeuvres::make(&mut vehicle, *thrust, &rudders)
            .map_err(|error| Failure::rejected(format!("{}: {error}", args.vehicle)))?;
        manoeuvres.push(made);
    }
    let page = report::render_standard(&args.vehicle, &manoeuvres);
    let document = Document {
        schema: "seatrial.manoeuvres.v1",
        vehicle: &args.vehicle,
        seed: args.seed,
        manoeuvres,
    };
    let json = serde_json::to_string_pretty(&document).map_err(Failure::internal)?;
    let files = [("manoeuvres.json", json + "\n"), ("manoeuvres.html", page)];
    output.save_in(&args.out, &files)?;
    output.print(&document, || text(&document))?;
    Ok(Exit::Done)
}

fn text(document: &Document) -> String {
    let mut zig_zags = Table::under(
        "thrust [%] | speed [m/s] | zig-zag [deg] | first turn [s] | overshoots [deg] | period [s]",
    );
    let mut spiral = Table::under(
        "thrust [%] | rudder [deg] | yaw rate [deg/s] | on the way back [deg/s] | speed [m/s] | \
            speed/rate [m]",
    );
    for at in &document.manoeuvres {
        let thrust = || format!("{:.0}", 100.0 * at.thrust);
        for zig_zag in &at.zig_zags {
            let angle = zig_zag.rudder_rad.to_degrees();
            let overshoots = zig_zag.overshoots_rad.iter();
            let overshoots: Vec<String> = overshoots
                .map(|o| format!("{:.2}", o.to_degrees()))
                .collect();
            zig_zags.row(vec![
                thrust(),
                format!("{:.2}", at.straight_speed_m_s),
                format!("{angle:.0}/{angle:.0}"),
                format!("{:.2}", zig_zag.initial_turning_time_s),
                overshoots.join(", "),
                format!("{:.2}", zig_zag.period_s),
            ]);
        }
        let (there, back) = at.spiral.split_at(at.spiral.len() / 2 + 1);
        for (k, point) in there.iter().enumerate() {
            let returned = (there.len() - 1)
                .checked_sub(k + 1)
                .and_then(|k| back.get(k));
            let rate = |point: &SpiralPoint| format!("{:.2}", point.yaw_rate_rad_s.to_degrees());
            spiral.row(vec![
                thrust(),
                format!("{:.1}", point.rudder_rad.to_degrees()),
                rate(point),
                returned.map_or("-".into(), rate),
                format!("{:.3}", point.surge_speed_m_s),
                format!("{:.2}", point.surge_speed_m_s / point.yaw_rate_rad_s.abs()),
            ]);
        }
    }
    format!(
        "{}\n{zig_zags}\nSpiral, from starboard to port and back\n{spiral}",
        document.vehicle
    )
}
