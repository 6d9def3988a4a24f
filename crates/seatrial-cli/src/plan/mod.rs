//! `seatrial plan`: a plan, and what it will do, before anything moves.

mod text;

use std::path::PathBuf;

use seatrial::preview::{
    self, Comparison, Preview, Recommendation, Target, compare_designs, parse_target, recommend,
};
use seatrial_app::TrialPlan;
use seatrial_app::planned::{Changes, ExpectedTrial, PlannedTrial, Recommendations};
use seatrial_core::Excitation;

use crate::output::{Exit, Failure, Output};
use crate::prior::{Named, PriorArgs, positive};
use crate::trial::ServoArgs;
use seatrial_app::models::SCHEDULE_FILE_HELP;
use text::text;

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
    #[command(flatten)]
    servo: ServoArgs,
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
The plan goes to standard output as TOML, the preview to standard error; with --out the plan goes to the file and \
the preview to standard output. The preview plays the plan on a noise-free vehicle of the expected kind; its \
intervals are those that no unbiased estimator can beat with that vehicle's noise and disturbance.

Exit code 4: on the expected vehicle the plan leaves its envelope, its intervals would be too wide for a model to be \
accepted, or the --target is not within reach.

Examples:
  seatrial plan --thrust 0.6 --thrust 0.8 --amplitude-deg 12 \\
      --out plan.toml && seatrial trial --plan plan.toml
  seatrial plan --time-constant 20 --sample-interval 0.5 --a22 -0.05 \\
      --b2 0.003 --speed 3 --out slow.toml
  seatrial plan --target a22:10%,b2:6% --adopt recommended --out plan.toml
  seatrial plan --a22 -0.9 --b2 0.7 --speed 1.2 --thrust 0.6 \\
      --noise-deg 1 --disturbance 0.005,2 --compare

{SCHEDULE_FILE_HELP}"
    )
}

/// Prints or writes the plan.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    if args.adopt == Some(Adopt::Recommended) && args.target.is_none() {
        return Err(Failure::usage(
            "--adopt recommended: name the widths to reach, as in --target a22:10%,b2:5%",
        ));
    }
    let mut plan = planned(args)?;
    let Named { origin, prior } = args.prior.read(&plan, args.time_constant)?;
    let recommendation = args.target.map(|target| Recommendations {
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
    let document = PlannedTrial {
        schema: "seatrial.plan.v1",
        plan,
        preview: ExpectedTrial {
            vehicle: origin,
            preview,
        },
        comparison,
        recommendation,
        warnings: Vec::new(),
    };
    if args.out.is_none() && !output.json {
        eprintln!("{}", text(&document));
        output.print(&document, || toml)?;
    } else {
        output.print(&document, || text(&document))?;
    }
    Ok(match document.will_do() {
        true => Exit::Done,
        false => Exit::Rejected,
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

fn planned(args: &Args) -> Result<TrialPlan, Failure> {
    let changes = Changes {
        file: args.plan.clone(),
        time_constant_s: args.time_constant,
        sample_interval_s: args.sample_interval,
        thrusts: args.thrust.clone(),
        amplitude_rad: args.amplitude_deg.map(f64::to_radians),
        validation_amplitude_rad: args.validation_amplitude_deg.map(f64::to_radians),
        period_s: args.period_s,
        rudder_limit_rad: args.prior.source.rudder_limit_rad(),
        // Applied below: its errors name the options.
        servo_s: [None, None],
        stop_when: args.stop_when,
        max_repeats: args.repeats,
    };
    let mut plan = changes.plan()?;
    args.servo.apply(&mut plan)?;
    checked(plan)
}

fn checked(plan: TrialPlan) -> Result<TrialPlan, Failure> {
    plan.check()
        .map(|()| plan)
        .map_err(|error| Failure::usage(format!("the plan: {error}")))
}

fn adopted(
    plan: TrialPlan,
    adopt: Adopt,
    comparison: Option<&Comparison>,
    recommendation: Option<&Recommendations>,
) -> Result<TrialPlan, Failure> {
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
