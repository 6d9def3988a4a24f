//! `seatrial plan`: a plan, and what it will do, before anything moves.

mod text;

use std::path::PathBuf;

use seatrial::preview::{Preview, Target, parse_target};
use seatrial_app::trials::plan::{Adopt, Changes, PreviewRequest, plan_trial};
use seatrial_app::trials::surge_step::SurgeOverrides;

use crate::choice::one_of;
use crate::output::{Exit, Failure, Output, OutputPath, say};
use crate::prior::{PriorArgs, positive};
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
    #[arg(long, value_name = "MANOEUVRE", value_parser = one_of(ADOPTED))]
    adopt: Option<Adopt>,
    /// Add the cheapest run, at another thrust, that makes drag length and lag of the thrust identifiable for `seatrial surge`, where
    /// the plan's own changes of thrust do not.
    #[arg(long)]
    surge: bool,
    /// Time constant of the speed after a change of thrust [default: the simulated vehicle's, or 3 time constants of the yaw rate].
    #[arg(long, value_name = "S", value_parser = positive, requires = "surge", allow_hyphen_values = true)]
    surge_time_constant: Option<f64>,
    /// Standard deviation of each reading of the speed [default: the simulated vehicle's, or 0.02].
    #[arg(long, value_name = "M_S", value_parser = positive, requires = "surge", allow_hyphen_values = true)]
    speed_noise: Option<f64>,
    /// Write the plan to this file.
    #[arg(long, value_name = "FILE")]
    out: Option<OutputPath>,
}

/// The manoeuvres that the plan may take over.
const ADOPTED: [(Adopt, &str, &str); 4] = [
    (Adopt::Recommended, "recommended", "The doublet recommended for the --target, for all speeds"),
    (Adopt::ThreeTwoOneOne, "3-2-1-1", "The 3-2-1-1 of the comparison"),
    (Adopt::Designed, "designed", "The manoeuvre designed within the envelope"),
    (
        Adopt::DesignedCalm,
        "designed-calm",
        "The manoeuvre designed within the heading excursion of the doublet",
    ),
];

fn help() -> String {
    format!(
        "\
The plan goes to standard output as TOML, the preview to standard error; with --out the plan goes to the file and \
the preview to standard output. The preview plays the plan on a noise-free vehicle of the expected kind; its \
intervals are those that no unbiased estimator can beat with that vehicle's noise and disturbance.

Exit code 4: on the expected vehicle the plan leaves its envelope, its intervals would be too wide for a model to be \
accepted, the --target is not within reach, or no run makes the --surge identifiable.

Examples:
  seatrial plan --thrust 0.6 --thrust 0.8 --amplitude-deg 12 \\
      --out plan.toml && seatrial trial --plan plan.toml
  seatrial plan --time-constant 20 --sample-interval 0.5 --a22 -0.05 \\
      --b2 0.003 --speed 3 --out slow.toml
  seatrial plan --target a22:15%,b2:8% --adopt recommended --out plan.toml
  seatrial plan --thrust 1 --surge --out plan.toml
  seatrial plan --a22 -0.9 --b2 0.7 --speed 1.2 --thrust 0.6 \\
      --noise-deg 1 --disturbance 0.005,2 --compare

{SCHEDULE_FILE_HELP}"
    )
}

/// Prints or writes the plan.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let wanted = PreviewRequest {
        target: args.target,
        comparison: args.compare,
        adopt: args.adopt,
        surge: args.surge.then_some(SurgeOverrides {
            time_constant_s: args.surge_time_constant,
            noise_m_s: args.speed_noise,
        }),
    };
    let document = plan_trial(&args.changes(), &args.prior.expected()?, wanted)?;
    for warning in &document.warnings {
        say(format!("warning: {warning}"));
    }
    let toml = toml::to_string_pretty(&document.plan).map_err(Failure::internal)?;
    if let Some(path) = &args.out {
        output.save(path, format!("# Trial plan by seatrial\n{toml}"))?;
    }
    if args.out.is_none() && !output.json {
        eprintln!("{}", text(&document, None));
        output.print(&document, || toml)?;
    } else {
        output.print(&document, || text(&document, args.out.as_deref()))?;
    }
    Ok(Exit::done_if(document.will_do()))
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

impl Args {
    fn changes(&self) -> Changes {
        Changes {
            file: self.plan.clone(),
            time_constant_s: self.time_constant,
            sample_interval_s: self.sample_interval,
            thrusts: self.thrust.clone(),
            amplitude_rad: self.amplitude_deg.map(f64::to_radians),
            validation_amplitude_rad: self.validation_amplitude_deg.map(f64::to_radians),
            period_s: self.period_s,
            rudder_limit_rad: self.prior.source.rudder_limit_rad(),
            servo_s: [self.servo.rudder_delay, self.servo.rudder_lag],
            stop_when: self.stop_when,
            max_repeats: self.repeats,
        }
    }
}
