//! `seatrial-lab field`: the field experiments of section VI on a simulated vehicle.

use std::fmt::Write as _;

use seatrial::campaign::Campaign;
use seatrial::sea_trials::field::Control;
use seatrial::sea_trials::field::{Claim, Field, FieldSettings, Repeatability};
use seatrial_app::trials::order::rehearse;
use seatrial_app::trials::simulator;
use seatrial_app::workers::Workers;
use seatrial_cli::output::{Failure, Output, OutputPath};
use seatrial_cli::table::{Table, number};
use seatrial_core::{Outcome, Plan};
use seatrial_report as report;
use seatrial_sim::SimulatedVehicle;
use serde::Serialize;

use crate::runner::{Found, Study};

/// Re-enact the paper's field experiments: trials, U-turns, heading steps, repeated trials.
///
/// A whole trial of the paper's plan, then on the same vehicle a U-turn at each thrust with a circle
/// through its track, and heading steps with the gain of the lowest thrust, the scheduled gains and gains
/// from the two end points; the trial is repeated with other seeds.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Writes field.html and field.json.

Exit code 0: everything the paper claims holds here; 4: something does not, or a speed has no model.

Example:
  seatrial-lab field --vehicle sim:starfish --trials 2 --out field")]
pub struct FieldStudy {
    /// The vehicle: sim:starfish-6dof, sim:remus100, sim:starfish or sim:FILE.toml.
    #[arg(long, value_name = "VEHICLE", default_value = "sim:starfish-6dof")]
    vehicle: String,
    /// Trials in all, each with a seed of its own.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=1000))]
    trials: u64,
    /// Directory for the files; made where it is missing.
    #[arg(long, value_name = "DIR")]
    out: OutputPath,
}

/// `field --json`.
#[derive(Serialize)]
pub struct Document {
    schema: &'static str,
    vehicle: String,
    seed: u64,
    claims: Vec<Claim>,
    #[serde(flatten)]
    field: Field,
    /// The first trial, which the page shows.
    #[serde(skip)]
    first: Campaign,
}

impl Study for FieldStudy {
    type Found = Document;

    fn runs(&self) -> Result<u64, Failure> {
        Ok(self.trials)
    }

    fn run(&self, seed: u64, workers: &Workers) -> Result<Document, Failure> {
        let conducted =
            workers.each(self.trials, |run| Some(trial(&self.vehicle, seed.wrapping_add(run))));
        let conducted: Vec<_> = conducted.into_iter().collect::<Result<_, _>>()?;
        let (mut vehicles, trials): (Vec<SimulatedVehicle>, Vec<Campaign>) =
            conducted.into_iter().unzip();
        let field = Field::experiments(&mut vehicles[0], &trials, FieldSettings::default())
            .map_err(|error| Failure::rejected(format!("{}: {error}", self.vehicle)))?;
        Ok(Document {
            schema: "seatrial.field.v1",
            vehicle: self.vehicle.clone(),
            seed,
            claims: field.claims(),
            field,
            first: trials[0].clone(),
        })
    }

    fn save(&self, found: &Document, output: &Output) -> Result<(), Failure> {
        let json = serde_json::to_string_pretty(found).map_err(Failure::internal)?;
        let files = [
            ("field.json", json + "\n"),
            ("field.html", report::render_field(&found.first, &found.field)),
        ];
        output.save_in(&self.out, &files)
    }
}

/// The paper's trial, and the vehicle after it.
fn trial(name: &str, seed: u64) -> Result<(SimulatedVehicle, Campaign), Failure> {
    let mut vehicle = simulator::vehicle(name, seed)?;
    let conducted = rehearse(&mut vehicle, name, seed, Plan::paper()).map_err(Failure::internal)?;
    match conducted.campaign.outcome {
        Some(Outcome::Finished) => Ok((vehicle, conducted.campaign)),
        _ => Err(Failure::rejected(format!("{name}: the trial with seed {seed} was aborted"))),
    }
}

impl Found for Document {
    fn text(&self) -> String {
        let field = &self.field;
        let mut text = format!(
            "Trials of {}, {} in all\n{}",
            self.vehicle,
            field.trials.first().map_or(0, |t| t.accepted[1]),
            trials(field)
        );
        if let Some(surge) = &field.surge {
            let fastest_m_s = surge.points.last().map_or(0.0, |p| p.steady_speed_m_s);
            let _ = writeln!(
                text,
                "\nSurge: speed = {:.2} m/s (thrust - {:.3}), rms {:.3} m/s; time constant {} s at {fastest_m_s:.2} m/s",
                surge.speed_per_thrust_m_s,
                surge.dead_band,
                surge.rms_residual_m_s,
                surge.time_constant_s(fastest_m_s).map_or("unknown".into(), |s| format!("{s:.2}")),
            );
        }
        let _ = write!(
            text,
            "\nU-turns under {:.2} rad of rudder (Fig. 15): predicted against a circle through the track\n{}",
            field.rudder_limit_rad,
            u_turns(field)
        );
        let _ = write!(
            text,
            "\nHeading steps of {:.0} degrees (Figs. 17 and 18), step away and step back\n{}",
            field.settings.steps.step_rad.to_degrees(),
            heading_steps(field)
        );
        let _ = write!(
            text,
            "\nK_p (57) between the ends of the schedule (Fig. 18), from the models there and from those of the two ends alone\n{}",
            gains_from_ends(field)
        );
        if let Some(repeated) = &field.repeatability {
            text += &repeatability(repeated);
        }
        text + &claims(self)
    }

    fn is_good(&self) -> bool {
        self.claims.iter().all(|claim| claim.holds)
    }
}

fn repeatability(repeated: &Repeatability) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "\nRepeated at {:.0} % thrust, {} trials",
        100.0 * repeated.thrust,
        repeated.repeats.len()
    );
    for (name, spread) in [("a22", repeated.a22_per_s), ("b2", repeated.b2_per_s2)] {
        let _ = writeln!(
            text,
            "  {name:<3} mean {:.3}, standard deviation {:.3}, stated by the intervals {:.3}; {} of {} intervals hold the mean",
            spread.mean,
            spread.standard_deviation,
            spread.stated,
            spread.intervals_with_mean,
            repeated.repeats.len()
        );
    }
    let [low_gain, high_gain] = repeated.proportional_gain;
    let [low_m, high_m] = repeated.u_turn_mean_radius_m;
    let _ =
        writeln!(text, "  K_p {low_gain:.2} to {high_gain:.2}, R (50) {low_m:.2} to {high_m:.2} m");
    text
}

fn claims(document: &Document) -> String {
    let mut text = String::from("\nThe paper's claims here\n");
    for claim in &document.claims {
        let _ = writeln!(
            text,
            "  {:<4} {}: {}: {:.3} {unit}, limit {} {unit}",
            if claim.holds { "ok" } else { "NOT" },
            claim.place,
            claim.claim,
            claim.found,
            claim.limit,
            unit = claim.unit
        );
    }
    text
}

fn trials(field: &Field) -> Table {
    let mut table = Table::under(
        "thrust [%] | speed [m/s] | a22 [1/s] | b2 [1/s^2] | C0 [rad/s^2] | accepted | \
            converged [s, latest] | R^2 [least] | R^2 [greatest]",
    );
    for at in &field.trials {
        let greatest = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let least = at.r2_heading.iter().copied().fold(f64::INFINITY, f64::min);
        table.row(vec![
            format!("{:.0}", 100.0 * at.thrust),
            number(at.surge_speed_m_s, 2),
            format!("{:.3}", at.model.a22_per_s),
            format!("{:.3}", at.model.b2_per_s2),
            format!("{:.4}", at.model.c0_rad_per_s2),
            format!("{} of {}", at.accepted[0], at.accepted[1]),
            format!("{:.2}", greatest(&at.converged_s)),
            format!("{least:.3}"),
            format!("{:.3}", greatest(&at.r2_heading)),
        ]);
    }
    table
}

fn u_turns(field: &Field) -> Table {
    let mut table = Table::under(
        "thrust [%] | straight [m/s] | in turn [m/s] | yaw rate [deg/s] | by model [deg/s] | U-turn [s] | \
            (49) [s] | circle [m] | R (50) [m] | in turn [m] | error [%] | by trial [m] | error [%] | \
            steady [m] | V/rate [m] | one turn [m] | error [%]",
    );
    for turn in &field.u_turns {
        let (predicted, measured) = (&turn.predicted, &turn.measured);
        let error =
            |predicted: f64, measured: f64| format!("{:+.1}", 100.0 * (predicted / measured - 1.0));
        table.row(vec![
            format!("{:.0}", 100.0 * turn.thrust),
            format!("{:.3}", measured.straight_speed_m_s),
            format!("{:.3}", measured.speed_in_turn_m_s),
            format!("{:.2}", measured.yaw_rate_rad_s.to_degrees()),
            format!("{:.2}", predicted.yaw_rate_rad_s.to_degrees()),
            format!("{:.1}", measured.u_turn_time_s),
            format!("{:.1}", predicted.u_turn_time_s),
            format!("{:.2}", measured.u_turn_radius_m),
            format!("{:.2}", predicted.u_turn_mean_radius_m),
            format!("{:.2}", predicted.at_speed_in_turn_m),
            error(predicted.at_speed_in_turn_m, measured.u_turn_radius_m),
            number(predicted.from_trial_m, 2),
            predicted
                .from_trial_m
                .map_or("-".into(), |radius_m| error(radius_m, measured.u_turn_radius_m)),
            format!("{:.2}", measured.steady_turning_radius_m),
            format!("{:.2}", predicted.steady_turning_radius_m),
            format!("{:.2}", predicted.from_one_u_turn_m),
            error(predicted.from_one_u_turn_m, measured.steady_turning_radius_m),
        ]);
    }
    table
}

fn heading_steps(field: &Field) -> Table {
    let mut table = Table::under(
        "thrust [%] | gain | K_p | overshoot [%] | settled [s] | swings | error [deg]",
    );
    for steps in &field.heading_steps {
        let [away, back] = &steps.measures;
        table.row(vec![
            format!("{:.0}", 100.0 * steps.point.thrust.unwrap_or(f64::NAN)),
            match steps.control {
                Control::Constant => "constant",
                Control::Scheduled => "scheduled",
                Control::Interpolated => "two ends",
            }
            .into(),
            format!("{:.2}", steps.gain.proportional_gain),
            format!("{:.1}, {:.1}", 100.0 * away.overshoot, 100.0 * back.overshoot),
            format!("{}, {}", number(away.settling_time_s, 1), number(back.settling_time_s, 1)),
            format!("{}, {}", steps.swings[0], steps.swings[1]),
            format!(
                "{:.2}, {:.2}",
                away.final_error_rad.to_degrees(),
                back.final_error_rad.to_degrees()
            ),
        ]);
    }
    table
}

fn gains_from_ends(field: &Field) -> Table {
    let mut table =
        Table::under("thrust [%] | K_p | model between | error [%] | straight line | error [%]");
    for gain in &field.gains_from_ends {
        let error = |found: f64| format!("{:+.1}", 100.0 * (found / gain.designed - 1.0));
        table.row(vec![
            format!("{:.0}", 100.0 * gain.thrust),
            format!("{:.3}", gain.designed),
            format!("{:.3}", gain.of_the_model_between),
            error(gain.of_the_model_between),
            format!("{:.3}", gain.on_the_line),
            error(gain.on_the_line),
        ]);
    }
    table
}
