//! `seatrial plan`: a plan, and what it will do, before anything moves.

use std::fmt::Write as _;
use std::path::PathBuf;

use seatrial::preview::{
    self, Comparison, Predicted, Preview, Recommendation, Target, compare_designs, parse_target,
    recommend,
};
use seatrial::verdict::{WIDEST_A22, WIDEST_B2};
use seatrial_core::{Excitation, List, Outcome, Plan, Trial};
use serde::Serialize;

use crate::output::{Exit, Failure, Output};
use crate::prior::{Named, PriorArgs, positive};
use crate::table::Table;
use crate::trial::load_plan;
use seatrial_app::models::SCHEDULE_FILE_HELP;

/// Print or write a plan, with the intervals, the track and the time to expect of it.
#[derive(clap::Args, Debug)]
#[command(after_help = help())]
pub struct Args {
    /// Begin with this plan instead of the paper's.
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,
    /// Begin with the paper's plan in the time of a vehicle whose yaw rate follows the rudder with this time constant,
    /// roughly; the paper's is 0.93 s, a ship's may be 100 s.
    #[arg(long, value_name = "S", conflicts_with = "plan", value_parser = positive)]
    time_constant: Option<f64>,
    /// Interval of the vehicle's samples.
    #[arg(long, value_name = "S", value_parser = positive)]
    sample_interval: Option<f64>,
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
    #[command(flatten)]
    prior: PriorArgs,
    /// Recommend the doublet whose 95 % intervals are this narrow, as in a22:10%,b2:5%.
    #[arg(long, value_name = "WIDTHS", value_parser = parse_target)]
    target: Option<Target>,
    /// End the training of a run as soon as its intervals are this narrow, as in a22:10%,b2:5%.
    #[arg(long, value_name = "WIDTHS", value_parser = parse_target)]
    stop_when: Option<Target>,
    /// Compare doublet, 3-2-1-1 and a designed manoeuvre at the amplitude and duration of the plan's training.
    #[arg(long)]
    compare: bool,
    /// Train with this manoeuvre instead of the plan's.
    #[arg(long, value_name = "MANOEUVRE")]
    adopt: Option<Adopt>,
    /// Write the plan to this file.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// A manoeuvre that the plan may take over.
#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
enum Adopt {
    /// The doublet recommended for the --target, for all speeds.
    Recommended,
    /// The 3-2-1-1 of the comparison.
    #[value(name = "3-2-1-1")]
    ThreeTwoOneOne,
    /// The manoeuvre designed within the envelope.
    Designed,
    /// The manoeuvre designed within the heading excursion of the doublet.
    DesignedCalm,
}

fn help() -> String {
    format!(
        "\
The plan goes to standard output as TOML, the preview to standard error; with --out the plan goes to the file and
the preview to standard output. The preview plays the plan on a noise-free vehicle of the expected kind; its
intervals are those that no unbiased estimator can beat with that vehicle's noise and disturbance.

Exit code 4: on the expected vehicle the plan leaves its envelope, its intervals would be too wide for a model to be
accepted, or the --target is not within reach.

Examples:
  seatrial plan --thrust 0.6 --thrust 0.8 --amplitude-deg 12 --out plan.toml && seatrial trial --plan plan.toml
  seatrial plan --time-constant 20 --sample-interval 0.5 --a22 -0.05 --b2 0.003 --speed 3 --out slow.toml
  seatrial plan --target a22:10%,b2:6% --adopt recommended --out plan.toml
  seatrial plan --a22 -0.9 --b2 0.7 --speed 1.2 --thrust 0.6 --noise-deg 1 --disturbance 0.005,2 --compare

{SCHEDULE_FILE_HELP}"
    )
}

/// What `plan --json` prints.
#[derive(Serialize)]
struct Document {
    schema: &'static str,
    plan: Plan<f64>,
    preview: OriginAndPreview,
    comparison: Option<Comparison>,
    recommendation: Option<RecommendationsFor>,
}

#[derive(Serialize)]
struct OriginAndPreview {
    /// Where the models and the noise come from.
    vehicle: String,
    #[serde(flatten)]
    preview: Preview,
}

#[derive(Serialize)]
struct RecommendationsFor {
    target: Target,
    /// One for each thrust, then one for all of them.
    doublets: Vec<Recommendation>,
}

/// Prints or writes the plan.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    if args.adopt == Some(Adopt::Recommended) && args.target.is_none() {
        return Err(Failure::usage(
            "--adopt recommended: name the widths to reach, as in --target a22:10%,b2:5%",
        ));
    }
    let mut plan = planned(args)?;
    let Named { origin, prior } = args.prior.read(&plan)?;
    let recommendation = args.target.map(|target| RecommendationsFor {
        target,
        doublets: recommend(&plan, &prior, target),
    });
    let wants_design = args.adopt.is_some_and(|adopt| adopt != Adopt::Recommended);
    let comparison = (args.compare || wants_design).then(|| compare_designs(&plan, &prior));
    if let Some(adopt) = args.adopt {
        plan = adopted(plan, adopt, comparison.as_ref(), recommendation.as_ref())?;
    }
    let preview = preview::preview(&plan, &prior)
        .map_err(|error| Failure::usage(format!("the plan: {error}")))?;
    let toml = toml::to_string_pretty(&plan).map_err(Failure::internal)?;
    if let Some(path) = &args.out {
        std::fs::write(path, &toml)
            .map_err(|error| Failure::not_saved(format!("{}: {error}", path.display())))?;
    }
    let document = Document {
        schema: "seatrial.plan.v1",
        plan,
        preview: OriginAndPreview {
            vehicle: origin,
            preview,
        },
        comparison,
        recommendation,
    };
    if args.out.is_none() && !output.json {
        eprintln!("{}", text(&document));
        output.print(&document, || toml)?;
    } else {
        output.print(&document, || text(&document))?;
    }
    let out_of_reach = document
        .recommendation
        .as_ref()
        .is_some_and(|r| r.doublets.is_empty() || r.doublets.iter().any(|d| !d.reachable));
    Ok(match document.preview.preview.outcome {
        Some(Outcome::Finished)
            if !out_of_reach && too_little(&document.preview.preview).is_empty() =>
        {
            Exit::Done
        }
        _ => Exit::Rejected,
    })
}

/// The thrusts, in percent, whose training would not tell enough for a model to be accepted.
fn too_little(preview: &Preview) -> Vec<String> {
    preview
        .speeds
        .iter()
        .filter(|speed| !speed.expected.is_some_and(|expected| expected.is_enough()))
        .map(|speed| format!("{:.0} %", 100.0 * speed.prior.thrust))
        .collect()
}

fn planned(args: &Args) -> Result<Plan<f64>, Failure> {
    let mut plan = load_plan(args.plan.as_deref())?;
    let sample_interval_s = args.sample_interval.unwrap_or(plan.sample_interval_s);
    if let Some(time_constant_s) = args.time_constant {
        plan = Plan::for_time_constant(time_constant_s, sample_interval_s);
    }
    plan.sample_interval_s = sample_interval_s;
    plan.rudder_limit_rad = args
        .prior
        .source
        .rudder_limit_rad()
        .unwrap_or(plan.rudder_limit_rad);
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
    plan.stop_when = args.stop_when.or(plan.stop_when);
    plan.max_repeats = args.repeats.unwrap_or(plan.max_repeats);
    checked(plan)
}

fn checked(plan: Plan<f64>) -> Result<Plan<f64>, Failure> {
    Trial::new(plan)
        .map(|_| plan)
        .map_err(|error| Failure::usage(format!("the plan: {error}")))
}

fn adopted(
    plan: Plan<f64>,
    adopt: Adopt,
    comparison: Option<&Comparison>,
    recommendation: Option<&RecommendationsFor>,
) -> Result<Plan<f64>, Failure> {
    let design = |name: &str| {
        let designs = &comparison?.designs;
        designs
            .iter()
            .find(|d| d.name == name)
            .map(|d| d.excitation)
    };
    let found = match adopt {
        Adopt::Recommended => recommendation.and_then(|r| {
            let Recommendation {
                amplitude_rad,
                period_s,
                ..
            } = *r.doublets.last().filter(|doublet| doublet.reachable)?;
            Some(Excitation::Doublet {
                amplitude_rad,
                period_s,
            })
        }),
        Adopt::ThreeTwoOneOne => design("3-2-1-1"),
        Adopt::Designed => design("designed"),
        Adopt::DesignedCalm => design("designed_calm"),
    };
    let excitation = found.ok_or_else(|| {
        Failure::rejected(match adopt {
            Adopt::Recommended => {
                "--adopt recommended: no doublet within the rudder limit and the envelope reaches the target at every speed; without --adopt the preview says what comes nearest"
            }
            _ => "--adopt: no manoeuvre of this amplitude and duration fits the envelope; lower --amplitude-deg or --period-s",
        })
    })?;
    let mut plan = plan;
    plan.training.excitation = excitation;
    checked(plan)
}

fn text(document: &Document) -> String {
    let mut text = preview_text(&document.preview, &document.plan);
    if let Some(comparison) = &document.comparison {
        let _ = write!(text, "\n{}", comparison_text(comparison));
    }
    if let Some(recommendation) = &document.recommendation {
        let _ = write!(text, "\n{}", recommendation_text(recommendation));
    }
    text
}

fn preview_text(
    OriginAndPreview { vehicle, preview }: &OriginAndPreview,
    plan: &Plan<f64>,
) -> String {
    let mut text = String::new();
    let _ = match preview.outcome {
        Some(Outcome::Finished) => writeln!(
            text,
            "On {vehicle} this plan takes {:.0} s with {} (at most {:.0} s, repeats of rejected runs aside).",
            preview.duration_s,
            match plan.thrusts.len() {
                1 => "1 speed".into(),
                speeds => format!("{speeds} speeds"),
            },
            preview.longest_s
        ),
        Some(Outcome::Aborted(reason)) => writeln!(
            text,
            "On {vehicle} this plan is ABORTED after {:.0} s: {reason}. Change the plan or its envelope.",
            preview.duration_s
        ),
        None => writeln!(text, "The plan did not end."),
    };
    let _ = match (preview.track_box_m, preview.track_margin_m) {
        (Some([south, north, west, east]), Some(margin)) => writeln!(
            text,
            "Track: from {south:.0} to {north:.0} m north and from {west:.0} to {east:.0} m east of the start, {margin:.0} m on each side for the compass and the waves included."
        ),
        _ => writeln!(text, "Track: unknown without a speed; give --speed."),
    };
    let mut table = Table::new(&[
        ("thrust", "%"),
        ("speed", "m/s"),
        ("settle", "s"),
        ("train", "s"),
        ("validate", "s"),
        ("heading", "± deg"),
        ("a22", "± %"),
        ("b2", "± %"),
        ("C0", "± rad/s^2"),
        ("K_p", "± %"),
        ("radius", "± %"),
        ("noise", "deg"),
        ("disturbance", "rad/s^2, s"),
    ]);
    for speed in &preview.speeds {
        let expected = speed.expected;
        let relative =
            |index: usize| percent(expected.and_then(|e| e.relative_half_width_95[index]));
        let radius = expected.and_then(|e| {
            let widths = e
                .steady_turning_radius_m
                .iter()
                .flatten()
                .map(relative_width);
            widths.reduce(f64::max)
        });
        let noise = speed.prior.noise;
        table.row(vec![
            format!("{:.0}", 100.0 * speed.prior.thrust),
            number(speed.prior.surge_speed_m_s, 2),
            format!("{:.1}", speed.settle_s),
            format!("{:.1}", speed.train_s),
            format!("{:.1}", speed.validate_s),
            format!("{:.0}", speed.heading_excursion_rad.to_degrees()),
            relative(0),
            relative(1),
            number(expected.map(|e| e.half_width_95[2]), 4),
            percent(
                expected
                    .and_then(|e| e.proportional_gain)
                    .as_ref()
                    .map(relative_width),
            ),
            percent(radius),
            format!("{:.2}", noise.heading_rad.to_degrees()),
            format!(
                "{:.2e}, {:.1}",
                noise.disturbance_rad_s2, noise.disturbance_time_s
            ),
        ]);
    }
    let _ = writeln!(
        text,
        "\n{table}\nHalf widths of the 95 % intervals to expect at best; K_p for a damping ratio of 0.7071, the radius of the steady circle under the full rudder."
    );
    let too_little = too_little(preview);
    if !too_little.is_empty() {
        let _ = writeln!(
            text,
            "TOO LITTLE to accept a model at {} thrust (a22 within {:.0} %, b2 within {:.0} %): plan more rudder or a longer period.",
            too_little.join(", "),
            100.0 * WIDEST_A22,
            100.0 * WIDEST_B2
        );
    }
    text
}

fn relative_width(predicted: &Predicted) -> f64 {
    predicted.half_width_95 / predicted.value.abs()
}

fn comparison_text(comparison: &Comparison) -> String {
    let mut table = Table::new(&[
        ("manoeuvre", ""),
        ("thrust", "%"),
        ("a22", "± %"),
        ("b2", "± %"),
        ("C0", "± rad/s^2"),
        ("heading", "± deg"),
        ("track along", "m"),
        ("across", "m"),
    ]);
    for design in &comparison.designs {
        for speed in &design.speeds {
            let [a22, b2, _] = speed
                .expected
                .map_or([None; 3], |e| e.relative_half_width_95)
                .map(percent);
            table.row(vec![
                design.name.replace('_', ", "),
                format!("{:.0}", 100.0 * speed.thrust),
                a22,
                b2,
                number(speed.expected.map(|e| e.half_width_95[2]), 4),
                format!("{:.0}", speed.heading_excursion_rad.to_degrees()),
                number(speed.track_m.map(|track| track[0]), 0),
                number(speed.track_m.map(|track| track[1]), 1),
            ]);
        }
    }
    let mut text = format!(
        "Manoeuvres of {:.1} deg and {:.1} s side by side; \"designed\" may turn as far as the envelope allows, \"calm\" as far as the doublet.\n\n{table}",
        comparison.amplitude_rad.to_degrees(),
        comparison.duration_s
    );
    if comparison.designs.iter().all(|d| d.name != "designed") {
        text.push_str("No designed manoeuvre of this amplitude and duration stays within the envelope should the prior be 30 % wrong.\n");
    }
    for design in &comparison.designs {
        if let Excitation::Switched { deflections_s, .. } = design.excitation {
            let lengths: Vec<String> = deflections_s.iter().map(|s| format!("{s:.2}")).collect();
            let _ = writeln!(
                text,
                "{}: to alternating sides for {} s.",
                design.name.replace('_', ", "),
                lengths.join(", ")
            );
        }
    }
    text
}

fn recommendation_text(recommendation: &RecommendationsFor) -> String {
    let Target { a22, b2 } = recommendation.target;
    let wanted: Vec<String> = [("a22", a22), ("b2", b2)]
        .into_iter()
        .filter_map(|(name, width)| Some(format!("{name} ± {} %", (1e6 * width?).round() / 1e4)))
        .collect();
    let mut table = Table::new(&[
        ("thrust", "%"),
        ("amplitude", "deg"),
        ("period", "s"),
        ("a22", "± %, 9 of 10"),
        ("b2", "± %, 9 of 10"),
        ("a22", "± %, best"),
        ("b2", "± %, best"),
        ("heading", "± deg"),
        ("", ""),
    ]);
    for doublet in &recommendation.doublets {
        let widths = [doublet.nine_of_ten_within, doublet.relative_half_width_95];
        let mut row = vec![
            doublet
                .thrust
                .map_or("all".into(), |thrust| format!("{:.0}", 100.0 * thrust)),
            format!("{:.1}", doublet.amplitude_rad.to_degrees()),
            format!("{:.2}", doublet.period_s),
        ];
        row.extend(widths.iter().flatten().map(|width| percent(Some(*width))));
        row.push(format!("{:.0}", doublet.heading_excursion_rad.to_degrees()));
        row.push(
            if doublet.reachable {
                ""
            } else {
                "NOT REACHABLE"
            }
            .into(),
        );
        table.row(row);
    }
    if recommendation.doublets.is_empty() {
        return "No doublet tells anything of this vehicle.\n".into();
    }
    let mut text = format!(
        "The smallest doublets for {} in nine of ten trials:\n\n{table}",
        wanted.join(" and ")
    );
    if recommendation.doublets.iter().any(|d| !d.reachable) {
        text.push_str(
            "NOT REACHABLE within the rudder limit and the envelope: this doublet comes nearest.\n",
        );
    }
    text
}

fn percent(fraction: Option<f64>) -> String {
    number(fraction.map(|fraction| 100.0 * fraction), 1)
}

fn number(value: Option<f64>, decimals: usize) -> String {
    value.map_or("-".into(), |value| format!("{value:.decimals$}"))
}
