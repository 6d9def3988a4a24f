//! The manoeuvres that a vehicle makes by its equations, without noise or sea.

use seatrial::sea_trials::ship_manoeuvres::{Index, Instant, TurningCircle, ZigZag};
use seatrial_core::Side;
use seatrial_sim::IdentifiedVehicle;
use seatrial_sim::plant::Plant;

use super::{circle_indices, zig_zag_indices};

/// Steps of a manoeuvre in a time constant of the yaw.
const STEPS: f64 = 50.0;
/// The longest step, s.
const LONGEST_STEP_S: f64 = 20.0;
/// Longest manoeuvre, in steps.
const MOST_STEPS: usize = 20_000;
/// Executes of a zig-zag; the swings between them are measured.
const EXECUTES: usize = 5;
/// Halvings of the step in which the heading passes where the rudder is ordered over.
const HALVINGS: u32 = 20;
/// The part of its speed at which a coasting vehicle counts as stopped.
const STOPPED: f64 = 0.2;
/// Rudder angles of the spiral, degrees.
const SPIRAL_DEG: [f64; 3] = [5.0, 10.0, 15.0];

/// What a vehicle does at a thrust.
pub(super) struct SimulatedManoeuvres {
    pub surge_speed_m_s: f64,
    /// The 10/10 and the 20/20, where it can make them.
    pub zig_zags: [Option<ZigZag>; 2],
    /// That of another rudder angle and heading change.
    pub modified: Option<ZigZag>,
    /// Under full rudder to starboard and to port.
    pub circles: Vec<TurningCircle>,
    others: Vec<Index>,
}

impl SimulatedManoeuvres {
    /// `modified_rad`: rudder angle and heading change of one more zig-zag, rad.
    pub fn of(vehicle: &IdentifiedVehicle, thrust: f64, modified_rad: Option<[f64; 2]>) -> Self {
        let plant = vehicle.plant(thrust);
        let limit_rad = vehicle.rudder.limit_rad;
        let helm = Helm::new(&plant, thrust);
        let zig_zag = |[rudder_rad, heading_rad]: [f64; 2]| {
            (rudder_rad <= limit_rad * (1.0 + 1e-9))
                .then(|| helm.zig_zag(rudder_rad, heading_rad, 1.0))
                .flatten()
        };
        let circles: Vec<TurningCircle> = [limit_rad, -limit_rad]
            .into_iter()
            .filter_map(|rudder_rad| helm.circle(rudder_rad))
            .collect();
        let mut others = helm.pull_outs(limit_rad);
        others.extend(helm.spiral(limit_rad));
        others.extend(helm.inertia_stop());
        Self {
            surge_speed_m_s: plant.surge_speed_m_s,
            zig_zags: [10_f64, 20.0].map(|angle| zig_zag([angle.to_radians(); 2])),
            modified: modified_rad.and_then(zig_zag),
            circles,
            others,
        }
    }

    pub fn indices(&self) -> Vec<Index> {
        let zig_zags = self.zig_zags.iter().chain([&self.modified]).flatten();
        let zig_zags = zig_zags.flat_map(zig_zag_indices);
        let circles = self.circles.iter().flat_map(circle_indices);
        zig_zags.chain(circles).chain(self.others.iter().cloned()).collect()
    }
}

/// The zig-zag of a vehicle that a record has.
pub(super) fn same_zig_zag(
    vehicle: &IdentifiedVehicle,
    thrust: f64,
    recorded: &ZigZag,
) -> Option<ZigZag> {
    let plant = vehicle.plant(thrust);
    let side = match recorded.first_side {
        Side::Starboard => 1.0,
        Side::Port => -1.0,
    };
    Helm::new(&plant, thrust).zig_zag(recorded.rudder_rad, recorded.heading_rad, side)
}

/// Steers a vehicle that begins straight ahead.
struct Helm<'a> {
    plant: &'a Plant,
    thrust: f64,
    /// The side to which a positive rudder turns.
    sense: f64,
    step_s: f64,
}

impl<'a> Helm<'a> {
    fn new(plant: &'a Plant, thrust: f64) -> Self {
        let model = plant.truth(thrust).model;
        Self {
            plant,
            thrust,
            sense: model.b2_per_s2.signum(),
            step_s: (1.0 / (STEPS * model.a22_per_s.abs())).min(LONGEST_STEP_S),
        }
    }

    /// The vehicle `interval_s` later.
    fn after(&self, plant: &Plant, rudder_rad: f64, interval_s: f64) -> Plant {
        let mut plant = plant.clone();
        plant.advance(rudder_rad, self.thrust, 0.0, interval_s);
        plant
    }

    /// The first execute is a turn to starboard for `side` 1, to port for -1. The rudder is ordered over at the instant at which the heading
    /// passes the angle.
    fn zig_zag(&self, angle_rad: f64, heading_rad: f64, mut side: f64) -> Option<ZigZag> {
        let mut plant = self.plant.clone();
        let mut time_s = 0.0;
        let mut track = vec![instant(time_s, &plant)];
        let mut executes = vec![0];
        for _ in 0..MOST_STEPS {
            let rudder_rad = side * self.sense * angle_rad;
            let has_passed = |plant: &Plant| side * plant.yaw.heading_rad >= heading_rad;
            let next = self.after(&plant, rudder_rad, self.step_s);
            if !has_passed(&next) {
                plant = next;
                time_s += self.step_s;
                track.push(instant(time_s, &plant));
                continue;
            }
            let [mut before_s, mut passed_s] = [0.0, self.step_s];
            for _ in 0..HALVINGS {
                let middle_s = 0.5 * (before_s + passed_s);
                match has_passed(&self.after(&plant, rudder_rad, middle_s)) {
                    true => passed_s = middle_s,
                    false => before_s = middle_s,
                }
            }
            plant = self.after(&plant, rudder_rad, passed_s);
            time_s += passed_s;
            track.push(instant(time_s, &plant));
            executes.push(track.len() - 1);
            side = -side;
            if executes.len() == EXECUTES {
                return ZigZag::of(&track, &executes, angle_rad);
            }
        }
        None
    }

    fn circle(&self, rudder_rad: f64) -> Option<TurningCircle> {
        let mut plant = self.plant.clone();
        let mut track = vec![instant(0.0, &plant)];
        for k in 1..=MOST_STEPS {
            plant.advance(rudder_rad, self.thrust, 0.0, self.step_s);
            track.push(instant(k as f64 * self.step_s, &plant));
            if plant.yaw.heading_rad.abs() > 1.02 * std::f64::consts::PI {
                return TurningCircle::of(&track, rudder_rad.abs());
            }
        }
        None
    }

    /// The vehicle in the steady turn of a rudder: after eight time constants of yaw and of speed.
    fn steady(&self, rudder_rad: f64) -> Plant {
        let mut plant = self.plant.clone();
        let settled_s = 8.0 * STEPS * self.step_s;
        let mut last = f64::INFINITY;
        for _ in 0..20 {
            plant.advance(rudder_rad, self.thrust, 0.0, settled_s);
            let rate = plant.yaw.yaw_rate_rad_s;
            if (rate - last).abs() <= 1e-6 * rate.abs() {
                break;
            }
            last = rate;
        }
        plant
    }

    /// Out of the steady turn of full rudder to either side with the rudder amidships: the yaw rates that remain.
    fn pull_outs(&self, limit_rad: f64) -> Vec<Index> {
        let out = |rudder_rad: f64| {
            let mut plant = self.steady(rudder_rad);
            plant.advance(0.0, self.thrust, 0.0, 16.0 * STEPS * self.step_s);
            plant.yaw.yaw_rate_rad_s.to_degrees()
        };
        let index = |name, value| Index {
            manoeuvre: "pull-out".into(),
            name,
            unit: "deg/s",
            value,
            interval_95: None,
        };
        vec![
            index("residual yaw rate, from starboard", out(self.sense * limit_rad)),
            index("residual yaw rate, from port", out(-self.sense * limit_rad)),
        ]
    }

    fn spiral(&self, limit_rad: f64) -> Vec<Index> {
        let sides = [(1.0, "yaw rate to starboard"), (-1.0, "yaw rate to port")];
        let angles = SPIRAL_DEG.into_iter().filter(|deg| deg.to_radians() <= limit_rad);
        angles
            .flat_map(|degrees| sides.map(|(side, name)| (degrees, side, name)))
            .map(|(degrees, side, name)| Index {
                manoeuvre: format!("spiral, {degrees:.0} deg"),
                name,
                unit: "deg/s",
                value: self
                    .steady(side * self.sense * degrees.to_radians())
                    .yaw
                    .yaw_rate_rad_s
                    .to_degrees(),
                interval_95: None,
            })
            .collect()
    }

    /// The way ahead from the order of no thrust until a fifth of the speed is left.
    fn inertia_stop(&self) -> Vec<Index> {
        let mut plant = self.plant.clone();
        let straight_rad = plant.fin_rad;
        let start_m_s = plant.surge_speed_m_s;
        let mut way_m = 0.0;
        for k in 1..=MOST_STEPS {
            let before_m_s = plant.surge_speed_m_s;
            plant.advance(straight_rad, 0.0, 0.0, self.step_s);
            way_m += 0.5 * (before_m_s + plant.surge_speed_m_s) * self.step_s;
            if plant.surge_speed_m_s <= STOPPED * start_m_s {
                let index = |name, unit, value| Index {
                    manoeuvre: "inertia stop to 20 % of the speed".into(),
                    name,
                    unit,
                    value,
                    interval_95: None,
                };
                return vec![
                    index("track reach", "m", way_m),
                    index("time", "s", k as f64 * self.step_s),
                ];
            }
        }
        Vec::new()
    }
}

fn instant(time_s: f64, plant: &Plant) -> Instant {
    Instant {
        time_s,
        heading_rad: plant.yaw.heading_rad,
        surge_speed_m_s: plant.surge_speed_m_s,
        north_m: plant.position_m[0],
        east_m: plant.position_m[1],
    }
}
