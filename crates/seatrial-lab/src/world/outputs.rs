//! A trial through MAVLink whose messages with the rudder are thinned, lost and late one by one, from the start or from some instant
//! on: when the rudder moved is then known badly, and an accepted model must say so in its intervals.

use seatrial::campaign::{Run, Stage};
use seatrial_links::autopilot::{Autopilot, Profile};
use seatrial_sim::faults::Upset;
use seatrial_sim::sensors::Chance;
use seatrial_sim::{FirstOrderVehicle, SimulatedConfig};

use crate::faults::Rehearsal;
use crate::observer::Instant;
use seatrial_app::Error;
use seatrial_app::conduct::{Judging, NoWatch};

use super::drawn::World;
use super::ending::Ending;
use super::linked::{conducted, settings};
use super::wire::{SERVO_OUTPUT_RAW, Sea, Single, Weather, boat};

/// Share of the messages that is lost, up to.
const MOST_LOSS: f64 = 0.5;
/// Messages in a second, from and to.
const RATES_HZ: [f64; 2] = [2.0, 10.0];
/// How late they come, s, up to.
const LATEST_S: f64 = 0.3;
/// When that begins, s, where it does not from the start: in the preflight or in the trial.
const WITHIN_S: f64 = 60.0;

/// One of the three, or all together.
fn drawn(chance: &mut Chance) -> Single {
    let mut uniform = |least: f64, most: f64| least + (most - least) * chance.uniform();
    let [least_hz, most_hz] = RATES_HZ;
    let (loss, rate_hz, late_s) =
        (uniform(0.0, MOST_LOSS), uniform(least_hz, most_hz), uniform(0.0, LATEST_S));
    let begins = [0.0, uniform(0.0, WITHIN_S)];
    let from_s = begins[uniform(0.0, 2.0) as usize];
    let which = uniform(0.0, 4.0) as u8;
    let of = |number: u8, value: f64| match which == number || which == 3 {
        true => value,
        false => 0.0,
    };
    Single {
        id: SERVO_OUTPUT_RAW,
        from_s,
        loss: of(0, loss),
        interval_s: of(1, 1.0 / rate_hz),
        late_s: of(2, late_s),
    }
}

/// Plays a world on a boat whose messages with the rudder are thinned.
pub fn play(world: &World, ending: &mut Ending) -> Result<(), Error> {
    let weather = Weather { single: Some(drawn(&mut world.stalls.clone())), ..Weather::default() };
    let (vehicle, profile) = (&world.vehicle, Profile::Rover);
    let mut sea = Sea::new(vehicle, profile, weather, None, world.chance.clone())?;
    sea.boat = boat(vehicle, profile, world.seed)?;
    let mut autopilot = Autopilot::new(sea, settings(), None);
    let trial = conducted(&mut autopilot, world, Judging::Whole, &mut NoWatch)?;
    ending.outcome = "not_taken".into();
    ending.samples = autopilot.wire().sent;
    let Some(campaign) = trial.campaign else {
        return Ok(());
    };
    ending.take(&campaign);
    let config = SimulatedConfig::FirstOrder(Box::new(vehicle.clone()));
    let rehearsal = Rehearsal::new(config, world.plan);
    for run in campaign.runs.iter().filter(|run| run.verdict.accepted) {
        let truth = truth(world, run)?;
        let found = run.identification.as_ref().zip(truth);
        match found.and_then(|(found, truth)| rehearsal.distances(run, found, &[truth])) {
            Some(distances) => ending.take_model(run.number, distances),
            None => ending.broken.push("accepted without a refined model".into()),
        }
    }
    Ok(())
}

/// What is true during the training of a run.
fn truth(world: &World, run: &Run) -> Result<Option<Instant>, Error> {
    let vehicle = FirstOrderVehicle::new(world.vehicle.clone(), world.seed);
    let vehicle = vehicle.map_err(|error| Error::Setting(error.to_string()))?;
    Ok(run.stage(Stage::Train).map(|training| Instant {
        time_s: training.from_s,
        upset: Upset::default(),
        model: Some(vehicle.truth(run.thrust).model),
    }))
}
