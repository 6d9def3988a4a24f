//! What a seed chooses: vehicle, plan, faults, operator, and how deep the world is looked into.

use seatrial_core::plan::Manoeuvre;
use seatrial_core::settle::Settle;
use seatrial_core::{List, Plan};
use seatrial_sim::faults::{Fault, Kind, Onset, Rehearsable};
use seatrial_sim::sensors::Chance;
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};
use serde::Serialize;

/// How much of the program takes part. Most worlds are quick, so that there can be very many.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Depth {
    /// The trial on a vehicle, its runs judged by the trial alone.
    Quick,
    /// And its logbook on a disk; the process or the power may go.
    Kept,
    /// Through MAVLink on a bad link, from the preflight to the hand-back.
    Linked,
    /// Through MAVLink, whose messages with the rudder are thinned, lost and late one by one; judged whole.
    Outputs,
    /// The paper's plan, refined estimates and verdicts, a logbook, and the trial replayed from it.
    Whole,
}

impl Depth {
    /// Every depth.
    pub const ALL: [Self; 5] = [Self::Quick, Self::Kept, Self::Linked, Self::Outputs, Self::Whole];

    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Quick => "quick",
            Self::Kept => "kept",
            Self::Linked => "linked",
            Self::Outputs => "outputs",
            Self::Whole => "whole",
        }
    }

    /// From 0 up to 1: one world in 128 is whole, one in 256 has thinned outputs, one in 32 is linked, one in 32 kept.
    fn of(share: f64) -> Self {
        match share * 128.0 {
            s if s < 1.0 => Self::Whole,
            s if s < 5.0 => Self::Linked,
            s if s < 9.0 => Self::Kept,
            s if s < 9.5 => Self::Outputs,
            _ => Self::Quick,
        }
    }
}

/// What happens besides the vehicle's own faults.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interruption {
    /// When, as a fraction of the longest time that the trial can take.
    pub at: f64,
    /// What interrupts it.
    pub kind: Interrupted,
}

/// Kinds of interruptions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interrupted {
    /// The operator wants the vehicle back.
    Abort,
    /// The process is killed: what it gave to the operating system stays.
    Killed,
    /// The power goes: what was not synchronised with the disk is gone or garbage.
    PowerLost,
}

/// A world.
#[derive(Clone, Debug)]
pub struct World {
    /// Its seed.
    pub seed: u64,
    /// How much of the program takes part.
    pub depth: Depth,
    /// The vehicle, its sensors and the sea.
    pub vehicle: VehicleConfig,
    /// The plan.
    pub plan: Plan<f64>,
    /// The vehicle's faults.
    pub faults: Vec<Fault>,
    /// How the trial is interrupted, if it is.
    pub interruption: Option<Interruption>,
    /// For what else is left to chance.
    pub chance: Chance,
    /// For what is held up.
    pub stalls: Chance,
}

impl World {
    /// The world of a seed, as deep as is asked for or as the seed chooses.
    pub fn of(seed: u64, depth: Option<Depth>) -> Self {
        // Apart from the vehicle's noise, which has the seed itself.
        let [mut kind, mut hull, mut trouble, mut who, chance, stalls] = Chance::sources(!seed);
        let depth = depth.unwrap_or_else(|| Depth::of(kind.uniform()));
        let vehicle = drawn_vehicle(&mut hull);
        let plan = match depth {
            Depth::Outputs | Depth::Whole => {
                Plan { thrusts: List::from_slice(&[0.8]).unwrap_or_default(), ..Plan::paper() }
            }
            _ => short_plan(),
        };
        let faults = drawn_faults(&vehicle, plan.longest_s(), seed, &mut trouble);
        Self {
            seed,
            depth,
            vehicle,
            plan,
            faults,
            interruption: drawn_interruption(depth, &mut who),
            chance,
            stalls,
        }
    }
}

/// Two speeds in 40 s.
fn short_plan() -> Plan<f64> {
    let paper = Plan::paper();
    let short =
        |manoeuvre: Manoeuvre<f64>| Manoeuvre { lead_in_s: 0.5, observe_s: 2.0, ..manoeuvre };
    Plan {
        thrusts: List::from_slice(&[0.6, 0.8]).unwrap_or_default(),
        max_repeats: 1,
        settle: Settle { steady_for_s: 1.0, at_least_s: 2.0, at_most_s: 6.0, ..paper.settle },
        training: short(paper.training),
        validation: short(paper.validation),
        ..paper
    }
}

/// The paper's vehicle, more or less: quicker or slower, with more or less rudder and noise.
fn drawn_vehicle(chance: &mut Chance) -> VehicleConfig {
    let mut config = VehicleConfig::starfish();
    let mut factor = |least: f64, most: f64| least * (most / least).powf(chance.uniform());
    let (damping, effect, noise, sea) =
        (factor(0.7, 1.4), factor(0.7, 1.4), factor(0.3, 3.0), factor(0.3, 3.0));
    for speed in &mut config.speeds {
        speed.a22_per_s *= damping;
        speed.b2_per_s2 *= effect;
    }
    config.sensors.compass.noise_rad *= noise;
    config.disturbance.standard_deviation_rad_s2 *= sea;
    config
}

/// None, one or two faults of any kind that the vehicle can play, at any instant.
fn drawn_faults(
    vehicle: &VehicleConfig,
    longest_s: f64,
    seed: u64,
    chance: &mut Chance,
) -> Vec<Fault> {
    let playable: Vec<Kind> = FirstOrderVehicle::new(vehicle.clone(), seed)
        .map(|vehicle| vehicle.playable())
        .unwrap_or_default();
    let count = (3.0 * chance.uniform()) as usize;
    (0..count)
        .filter_map(|_| {
            let place = (playable.len() as f64 * chance.uniform()) as usize;
            let onset = Onset::Time(longest_s * chance.uniform());
            Some(Fault::drawn(*playable.get(place)?, onset, chance))
        })
        .collect()
}

/// A quarter of the trials is aborted by the operator; a logbook is taken from its process more often.
fn drawn_interruption(depth: Depth, chance: &mut Chance) -> Option<Interruption> {
    let (share, at) = (chance.uniform(), chance.uniform());
    let kind = match depth {
        Depth::Kept | Depth::Whole if share < 0.4 => Interrupted::Killed,
        Depth::Kept | Depth::Whole if share < 0.6 => Interrupted::PowerLost,
        _ if !(0.25..=0.9).contains(&share) => Interrupted::Abort,
        _ => return None,
    };
    Some(Interruption { at, kind })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A failing seed can be played again: it chooses the same world each time.
    #[test]
    fn parity_a_seed_chooses_one_world() {
        for seed in 0..200 {
            let [one, other] = [World::of(seed, None), World::of(seed, None)];
            assert_eq!(format!("{one:?}"), format!("{other:?}"));
        }
    }

    #[test]
    fn prop_every_depth_interruption_and_number_of_faults_is_drawn() {
        let worlds: Vec<World> = (0..2000).map(|seed| World::of(seed, None)).collect();
        for depth in Depth::ALL {
            assert!(worlds.iter().any(|world| world.depth == depth), "{depth:?}");
        }
        for kind in [Interrupted::Abort, Interrupted::Killed, Interrupted::PowerLost] {
            let is_there = |world: &World| world.interruption.is_some_and(|i| i.kind == kind);
            assert!(worlds.iter().any(is_there), "{kind:?}");
        }
        for count in 0..3 {
            assert!(worlds.iter().any(|world| world.faults.len() == count));
        }
        for world in &worlds {
            seatrial_core::Trial::new(world.plan).unwrap();
            world.vehicle.check().unwrap();
        }
    }
}
