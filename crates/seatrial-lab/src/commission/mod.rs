//! `seatrial-lab commission`: commissions of many simulated boats, beside the autopilot's defaults and QuickTune's rule.

mod boat;
mod vehicles;

use seatrial::gains::commission::Response;
use seatrial_app::workers::Workers;
use seatrial_cli::output::{Exit, Failure, Output, OutputPath};
use seatrial_cli::table::{Table, number};
use serde::Serialize;

use crate::runner::{Args, Found, Study};
use boat::commission_one;
pub use boat::{CLASSES_S, Commissioning, Method};

/// Commissions of simulated boats in three classes, beside the autopilot's defaults and QuickTune's rule.
///
/// Each boat is of first order with a rudder that lags by up to 0.3 s and is up to 0.06 s late, under the heading controller of
/// ArduPilot's Rover; its trial errs by 4 % of a22 and of the rudder's effect. Steps of 30 degrees there and back.
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:
  seatrial-lab commission --boats 3")]
pub struct CommissionStudy {
    /// Boats of each class.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    boats: u64,
    /// Loops of the autopilot per second.
    #[arg(long, value_name = "HZ", default_value_t = 50, value_parser = clap::value_parser!(u32).range(10..=1000))]
    loop_rate: u32,
    /// Each boat in a sea of its own, up to 2 % of what full steering gives, with a compass of 0.1 to 0.5 degrees.
    #[arg(long)]
    sea: bool,
    /// Write each boat into this folder, for `seatrial sim serve --ardupilot-json`, and commission none.
    #[arg(long, value_name = "DIR")]
    vehicles: Option<OutputPath>,
}

/// `commission --json`.
#[derive(Clone, Debug, Serialize)]
pub struct Commissions {
    /// `seatrial.commission_study.v1`
    pub schema: &'static str,
    /// The first seed.
    pub seed: u64,
    /// Boats of each class.
    pub boats: u64,
    /// Loops of the autopilot per second.
    pub loop_rate_hz: u32,
    /// Is each boat in a sea of its own?
    pub has_sea: bool,
    /// Classes of boats.
    pub classes: Vec<Class>,
}

/// Boats of a range of time constants.
#[derive(Clone, Debug, Serialize)]
pub struct Class {
    /// Least and greatest time constant, s.
    pub time_constant_s: [f64; 2],
    /// Boats for which no gains were proposed.
    pub refused: u64,
    /// Boats whose proposed gains were kept.
    pub kept: usize,
    /// Boats whose proposed gains would be kept, were there no sea and no noise.
    pub better: usize,
    /// Of these, how many were kept.
    pub better_kept: usize,
    /// Boats whose measured overshoot was in the interval that was foreseen.
    pub as_foreseen: usize,
    /// What each method makes of them.
    pub methods: Vec<Row>,
}

/// The steps of a class under the gains of a method.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Where the gains come from.
    pub method: Method,
    /// Median overshoot as a fraction of the step.
    pub overshoot_median: f64,
    /// Largest overshoot as a fraction of the step.
    pub overshoot_most: f64,
    /// Boats that do not settle.
    pub unsettled: usize,
    /// Median time to settle of those that do, s.
    pub settling_median_s: Option<f64>,
    /// Boats that settle later than with the defaults.
    pub later_than_defaults: usize,
    /// Median of the rudder's activity, full deflections per second.
    pub activity_median_per_s: f64,
    /// Largest activity, full deflections per second.
    pub activity_most_per_s: f64,
}

/// Commissions the boats, or writes them as files of vehicles.
pub fn run(args: &Args<CommissionStudy>, output: &Output) -> Result<Exit, Failure> {
    match &args.study.vehicles {
        Some(folder) => vehicles::write(&args.study, args.seed, folder, output),
        None => args.conduct(output),
    }
}

/// Seeds between the first boats of two classes.
const SEEDS_OF_A_CLASS: u64 = 1_000_000;

/// The seed of the first boat of a class.
fn first_of(class: usize, seed: u64) -> u64 {
    seed.wrapping_add(SEEDS_OF_A_CLASS * class as u64)
}

impl Study for CommissionStudy {
    type Found = Commissions;

    fn runs(&self) -> Result<u64, Failure> {
        Ok(self.boats * CLASSES_S.len() as u64)
    }

    fn run(&self, seed: u64, workers: &Workers) -> Result<Commissions, Failure> {
        let loop_interval_s = 1.0 / f64::from(self.loop_rate);
        let classes = CLASSES_S.iter().enumerate().map(|(number, class_s)| {
            let first = first_of(number, seed);
            let found = workers.each(self.boats, |boat| {
                commission_one(*class_s, first.wrapping_add(boat), loop_interval_s, self.sea)
            });
            class(*class_s, self.boats, &found)
        });
        Ok(Commissions {
            schema: "seatrial.commission_study.v1",
            seed,
            boats: self.boats,
            loop_rate_hz: self.loop_rate,
            has_sea: self.sea,
            classes: classes.collect(),
        })
    }
}

fn class(time_constant_s: [f64; 2], asked: u64, boats: &[Commissioning]) -> Class {
    let count = |is: fn(&Commissioning) -> bool| boats.iter().filter(|boat| is(boat)).count();
    Class {
        time_constant_s,
        refused: asked - boats.len() as u64,
        kept: count(|boat| boat.is_kept),
        better: count(|boat| boat.is_better),
        better_kept: count(|boat| boat.is_better && boat.is_kept),
        as_foreseen: count(|boat| boat.is_as_foreseen),
        methods: Method::ALL
            .iter()
            .enumerate()
            .map(|(number, method)| row(*method, number, boats))
            .collect(),
    }
}

fn row(method: Method, number: usize, boats: &[Commissioning]) -> Row {
    let of = |quantity: fn(&Response) -> f64| {
        let mut values: Vec<f64> = boats.iter().map(|b| quantity(&b.responses[number])).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let middle = |values: &[f64]| values.get(values.len() / 2).copied();
    let most = |values: &[f64]| values.last().copied().unwrap_or(f64::NAN);
    let (overshoot, activity) = (of(|r| r.overshoot), of(|r| r.activity_per_s));
    let settling = |boat: &Commissioning, number: usize| boat.responses[number].settling_s;
    let mut settled: Vec<f64> = boats.iter().filter_map(|b| settling(b, number)).collect();
    settled.sort_by(f64::total_cmp);
    let is_later = |boat: &&Commissioning| match (settling(boat, number), settling(boat, 0)) {
        (Some(found_s), Some(default_s)) => found_s > default_s,
        (None, found) => found.is_some(),
        (Some(_), None) => false,
    };
    Row {
        method,
        overshoot_median: middle(&overshoot).unwrap_or(f64::NAN),
        overshoot_most: most(&overshoot),
        unsettled: boats.len() - settled.len(),
        settling_median_s: middle(&settled),
        later_than_defaults: boats.iter().filter(is_later).count(),
        activity_median_per_s: middle(&activity).unwrap_or(f64::NAN),
        activity_most_per_s: most(&activity),
    }
}

impl Found for Commissions {
    fn text(&self) -> String {
        let mut table = Table::under(
            "T [s] | gains | overshoot [median %] | [most %] | unsettled [boats] | settled after [median s] | \
                later than defaults [boats] | rudder [median %/s] | [most %/s]",
        );
        for class in &self.classes {
            for row in &class.methods {
                let name = match row.method {
                    Method::Defaults => "defaults",
                    Method::QuickTune => "QuickTune's rule",
                    Method::Proposed => "proposed",
                    Method::Commissioned => "commissioned",
                };
                let [low, high] = class.time_constant_s;
                table.row(vec![
                    format!("{low} to {high}"),
                    name.into(),
                    format!("{:.1}", 100.0 * row.overshoot_median),
                    format!("{:.1}", 100.0 * row.overshoot_most),
                    row.unsettled.to_string(),
                    number(row.settling_median_s, 1),
                    row.later_than_defaults.to_string(),
                    format!("{:.0}", 100.0 * row.activity_median_per_s),
                    format!("{:.0}", 100.0 * row.activity_most_per_s),
                ]);
            }
        }
        let count = |of: fn(&Class) -> u64| self.classes.iter().map(of).sum::<u64>();
        format!(
            "{} boats of each class, {} loops a second; kept {}, no gains proposed for {}; without sea and noise {} would be kept, of them {} were; measured as foreseen {}\n\n{table}",
            self.boats,
            self.loop_rate_hz,
            count(|class| class.kept as u64),
            count(|class| class.refused),
            count(|class| class.better as u64),
            count(|class| class.better_kept as u64),
            count(|class| class.as_foreseen as u64),
        )
    }
}
