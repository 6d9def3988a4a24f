//! `seatrial plan`: a plan, and what it will do, before anything moves.

use std::fmt::Write as _;
use std::path::PathBuf;

use seatrial::campaign::{Campaign, Run, Stage};
use seatrial::conduct::{Unwatched, conduct};
use seatrial::identify::bound::{Noise, cramer_rao_bound};
use seatrial_core::{Excitation, List, Outcome, Plan, Trial, YawModel};
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};
use serde::Serialize;

use crate::output::{Exit, Failure, Output};
use crate::table::Table;
use crate::trial::load_plan;
use crate::vehicle;

/// Half width of a 95 % interval in standard deviations.
const NORMAL_95: f64 = 1.96;

/// Print or write a plan, with the intervals, the track and the time to expect of it.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
The plan goes to standard output as TOML, the preview to standard error; with --out the plan goes to the file and
the preview to standard output. The preview runs the plan on a noise-free vehicle of the expected kind; its
intervals are those that no unbiased estimator can beat with that vehicle's noise and disturbance.

Example:
  seatrial plan --thrust 0.6 --thrust 0.8 --amplitude-deg 12 --out plan.toml && seatrial trial --plan plan.toml")]
pub struct Args {
    /// Begin with this plan instead of the paper's.
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,
    /// Thrust as a fraction of full; repeatable.
    #[arg(long, value_name = "FRACTION")]
    thrust: Vec<f64>,
    /// Amplitude of the training doublet, deg.
    #[arg(long, value_name = "DEG")]
    amplitude_deg: Option<f64>,
    /// Amplitude of the validation doublet, deg.
    #[arg(long, value_name = "DEG")]
    validation_amplitude_deg: Option<f64>,
    /// Period of both doublets, s.
    #[arg(long, value_name = "S")]
    period_s: Option<f64>,
    /// Times a run below R^2 0.60 is repeated.
    #[arg(long, value_name = "N")]
    repeats: Option<u32>,
    /// The vehicle to expect, with its noise and disturbance.
    #[arg(long, value_name = "VEHICLE", default_value = "sim:starfish")]
    vehicle: String,
    /// Write the plan to this file.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// What `plan --json` prints.
#[derive(Serialize)]
struct Document {
    schema: &'static str,
    plan: Plan<f64>,
    preview: Preview,
}

/// What the plan will do on the expected vehicle.
#[derive(Serialize)]
struct Preview {
    vehicle: String,
    /// How the plan ends on it: aborted where it does not fit the envelope.
    outcome: Option<Outcome>,
    duration_s: f64,
    /// Southernmost, northernmost, westernmost, easternmost point from the start, m.
    track_box_m: Option<[f64; 4]>,
    speeds: Vec<Expected>,
}

/// One speed of the preview.
#[derive(Serialize)]
struct Expected {
    thrust: f64,
    surge_speed_m_s: Option<f64>,
    duration_s: f64,
    heading_excursion_rad: f64,
    /// Half widths of the 95 % intervals of a22, b2 and C0.
    half_width_95: Option<[f64; 3]>,
    /// Those of a22 and b2 as a fraction of the parameter.
    relative_half_width_95: Option<[f64; 2]>,
}

/// Prints or writes the plan.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let plan = planned(args)?;
    let preview = preview(args, plan)?;
    let toml = toml::to_string_pretty(&plan).map_err(Failure::internal)?;
    if let Some(path) = &args.out {
        std::fs::write(path, &toml)
            .map_err(|error| Failure::not_saved(format!("{}: {error}", path.display())))?;
    }
    let text = text(&preview, &plan);
    let document = Document {
        schema: "seatrial.plan.v1",
        plan,
        preview,
    };
    if args.out.is_none() && !output.json {
        eprintln!("{text}");
        output.print(&document, || toml)?;
    } else {
        output.print(&document, || text)?;
    }
    Ok(match document.preview.outcome {
        Some(Outcome::Finished) => Exit::Done,
        _ => Exit::Rejected,
    })
}

fn planned(args: &Args) -> Result<Plan<f64>, Failure> {
    let mut plan = load_plan(args.plan.as_deref())?;
    if !args.thrust.is_empty() {
        plan.thrusts = List::from_slice(&args.thrust)
            .ok_or_else(|| Failure::usage("--thrust: more speeds than a trial has"))?;
    }
    let training_deg = args.amplitude_deg;
    for (manoeuvre, amplitude_deg) in [
        (&mut plan.training, training_deg),
        (&mut plan.validation, args.validation_amplitude_deg),
    ] {
        if amplitude_deg.is_none() && args.period_s.is_none() {
            continue;
        }
        let Excitation::Doublet {
            amplitude_rad,
            period_s,
        } = &mut manoeuvre.excitation
        else {
            return Err(Failure::usage(
                "amplitudes and periods are set for doublets only; edit the plan file",
            ));
        };
        *amplitude_rad = amplitude_deg.map_or(*amplitude_rad, f64::to_radians);
        *period_s = args.period_s.unwrap_or(*period_s);
    }
    plan.max_repeats = args.repeats.unwrap_or(plan.max_repeats);
    Trial::new(plan)
        .map(|_| plan)
        .map_err(|error| Failure::usage(format!("the plan: {error}")))
}

fn preview(args: &Args, plan: Plan<f64>) -> Result<Preview, Failure> {
    let config = vehicle::config(&args.vehicle)?;
    let noise = Noise {
        heading_rad: config.sensors.compass_noise_rad.max(1e-6),
        disturbance_rad_s2: config.disturbance.standard_deviation_rad_s2,
        disturbance_time_s: config.disturbance.correlation_time_s,
    };
    let campaign = noise_free(config, &args.vehicle, plan)?;
    let samples = || campaign.runs.iter().flat_map(|run| &run.record.samples);
    let duration_s = match (samples().next(), samples().last()) {
        (Some(first), Some(last)) => last.time_s - first.time_s,
        _ => 0.0,
    };
    let range = |of: fn(&seatrial_core::Sample<f64>) -> Option<f64>| {
        samples()
            .filter_map(of)
            .fold(None, |range, at| match range {
                None => Some((at, at)),
                Some((low, high)) => Some((f64::min(low, at), f64::max(high, at))),
            })
    };
    Ok(Preview {
        vehicle: args.vehicle.clone(),
        outcome: campaign.outcome,
        duration_s,
        track_box_m: range(|s| s.north_m)
            .zip(range(|s| s.east_m))
            .map(|((south, north), (west, east))| [south, north, west, east]),
        speeds: campaign
            .runs
            .iter()
            .map(|run| expected(run, noise))
            .collect(),
    })
}

fn noise_free(config: VehicleConfig, name: &str, plan: Plan<f64>) -> Result<Campaign, Failure> {
    let about = Campaign {
        software_version: env!("CARGO_PKG_VERSION").into(),
        vehicle: name.into(),
        configuration: "preview".into(),
        seed: None,
        rudder_limit_rad: plan.rudder_limit_rad,
        runs: Vec::new(),
        outcome: None,
    };
    let mut vehicle = FirstOrderVehicle::new(config.noise_free(), 0).map_err(Failure::input)?;
    conduct(&mut vehicle, plan, about, &mut Unwatched)
        .map(|conducted| conducted.campaign)
        .map_err(|error| Failure::usage(format!("the plan: {error}")))
}

fn expected(run: &Run, noise: Noise) -> Expected {
    let samples = run.record.samples.as_slice();
    let training = run
        .stage(Stage::Train)
        .map(|window| run.record.window(window));
    let model = run.identification.as_ref().map(|i| i.model());
    let half_width_95 = training
        .zip(model)
        .and_then(|(training, model)| half_widths(training, model, noise));
    let heading = |s: &seatrial_core::Sample<f64>| s.heading_rad;
    let start = samples.first().map_or(0.0, heading);
    Expected {
        thrust: run.thrust,
        surge_speed_m_s: run.surge_speed_m_s,
        duration_s: match samples {
            [first, .., last] => last.time_s - first.time_s,
            _ => 0.0,
        },
        heading_excursion_rad: samples
            .iter()
            .map(|s| seatrial_core::Real::wrapped(heading(s) - start).abs())
            .fold(0.0, f64::max),
        half_width_95,
        relative_half_width_95: half_width_95.zip(model).map(|(widths, model)| {
            [
                widths[0] / model.a22_per_s.abs(),
                widths[1] / model.b2_per_s2.abs(),
            ]
        }),
    }
}

fn half_widths(
    training: &[seatrial_core::Sample<f64>],
    model: YawModel<f64>,
    noise: Noise,
) -> Option<[f64; 3]> {
    let bound = cramer_rao_bound(training, model, noise)?;
    Some(core::array::from_fn(|i| NORMAL_95 * bound[(i, i)].sqrt()))
}

fn text(preview: &Preview, plan: &Plan<f64>) -> String {
    let mut text = String::new();
    let _ = match preview.outcome {
        Some(Outcome::Finished) => writeln!(
            text,
            "On {} this plan takes {:.0} s with {} speeds (at most {:.0} s without repeats).",
            preview.vehicle,
            preview.duration_s,
            plan.thrusts.len(),
            plan.longest_s()
        ),
        Some(Outcome::Aborted(reason)) => writeln!(
            text,
            "On {} this plan is ABORTED after {:.0} s: {reason}. Change the plan or its envelope.",
            preview.vehicle, preview.duration_s
        ),
        None => writeln!(text, "The plan did not end."),
    };
    if let Some([south, north, west, east]) = preview.track_box_m {
        let _ = writeln!(
            text,
            "Track: {:.0} m north to south, {:.0} m east to west.",
            north - south,
            east - west
        );
    }
    let mut table = Table::new(&[
        ("thrust", "%"),
        ("speed", "m/s"),
        ("time", "s"),
        ("heading", "± deg"),
        ("a22", "± %"),
        ("b2", "± %"),
        ("C0", "± rad/s^2"),
    ]);
    for speed in &preview.speeds {
        let percent = |index: usize| {
            speed
                .relative_half_width_95
                .map_or_else(String::new, |widths| {
                    format!("{:.1}", 100.0 * widths[index])
                })
        };
        table.row(vec![
            format!("{:.0}", 100.0 * speed.thrust),
            speed
                .surge_speed_m_s
                .map_or_else(String::new, |v| format!("{v:.2}")),
            format!("{:.0}", speed.duration_s),
            format!("{:.0}", speed.heading_excursion_rad.to_degrees()),
            percent(0),
            percent(1),
            speed
                .half_width_95
                .map_or_else(String::new, |w| format!("{:.4}", w[2])),
        ]);
    }
    let _ = write!(
        text,
        "\n{table}\nHalf widths of the 95 % intervals to expect."
    );
    text
}
