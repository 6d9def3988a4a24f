//! The standard manoeuvres of ships, predicted from a vehicle with intervals, and read from a log.

mod manoeuvres;
mod own_error;
mod read;

use seatrial::sea_trials::ship_manoeuvres::{
    Index, Kind, RecordedManoeuvre, ShipManoeuvres, TurningCircle, ZigZag, criteria, recorded,
    stopping_criterion,
};
use seatrial::words::three_figures;
use seatrial_core::{Sample, Side};
use seatrial_sim::IdentifiedVehicle;

use crate::Error;
use manoeuvres::SimulatedManoeuvres;
pub use own_error::OwnError;

/// Draws of the vehicle for the intervals where nobody says how many.
pub const DRAWS: u64 = 400;
/// A figure has an interval where at least this share of the draws has the figure.
const SHARE_OF_DRAWS: f64 = 0.95;

/// What is wanted of the manoeuvres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManoeuvreRequest {
    /// Thrust as a fraction of full; the fastest of the vehicle without.
    pub thrust: Option<f64>,
    /// Length between perpendiculars, m, for the criteria of the IMO.
    pub length_m: Option<f64>,
    /// Vehicles drawn for the intervals; 0 for none.
    pub draws: u64,
    /// Seed of the first.
    pub seed: u64,
    /// A zig-zag besides the 10/10 and the 20/20: rudder angle and heading change, rad.
    pub zig_zag_rad: Option<[f64; 2]>,
    /// What the model lacks on the record that it was identified from.
    pub own_error: Option<OwnError>,
}

/// Every figure of a vehicle at a thrust, by its equations, without intervals.
pub fn figures(vehicle: &IdentifiedVehicle, thrust: f64) -> Vec<Index> {
    SimulatedManoeuvres::of(vehicle, thrust, None).indices()
}

impl ManoeuvreRequest {
    fn check(&self) -> Result<(), Error> {
        let refused = |what: String| Err(Error::Setting(what));
        match (self.thrust, self.length_m) {
            (Some(thrust), _) if !(thrust > 0.0 && thrust <= 1.0) => refused(format!(
                "--thrust {thrust}: expected a fraction of full, above 0 and at most 1"
            )),
            _ if self.zig_zag_rad.is_some_and(|[rudder, heading]| {
                !(rudder > 0.0 && rudder < 1.57 && heading > 0.0 && heading < 1.57)
            }) =>
            {
                refused("zig-zag: expected the angles of rudder and heading, degrees above 0 and below 90, as in 20/10".into())
            }
            (_, Some(length_m)) if !(length_m > 0.0 && length_m < 1000.0) => refused(format!(
                "--length {length_m}: expected the length between perpendiculars, above 0 and below 1000 m"
            )),
            _ => Ok(()),
        }
    }
}

/// Predicts the manoeuvres of a vehicle. Each interval holds 95 % of the figures of vehicles that are drawn from the covariance of its
/// model; lag, speed and what a turn costs are taken as exact.
pub fn predicted(
    vehicle: &IdentifiedVehicle,
    wanted: &ManoeuvreRequest,
) -> Result<ShipManoeuvres, Error> {
    wanted.check()?;
    let thrust = wanted.thrust.unwrap_or(vehicle.fastest_thrust());
    let a22_per_s = vehicle.plant(thrust).truth(thrust).model.a22_per_s;
    if a22_per_s >= 0.0 {
        return Err(Error::Rejected(format!(
            "{}: a22 is {} 1/s at {:.0} % thrust, and a vehicle that is not stable on its course has no such figures; choose another --thrust",
            vehicle.name,
            three_figures(a22_per_s),
            100.0 * thrust
        )));
    }
    let conducted = SimulatedManoeuvres::of(vehicle, thrust, wanted.zig_zag_rad);
    if wanted.zig_zag_rad.is_some() && conducted.modified.is_none() {
        return Err(Error::Rejected(format!(
            "{}: it cannot make the zig-zag that is wanted: the rudder's limit is {} deg",
            vehicle.name,
            three_figures(vehicle.rudder.limit_rad.to_degrees())
        )));
    }
    let mut indices = conducted.indices();
    add_intervals(&mut indices, vehicle, thrust, wanted);
    let mut notes = notes(vehicle, thrust);
    if let Some(error) = wanted.own_error {
        error.widen(&mut indices);
        notes.push(error.sentence());
    }
    let surge_speed_m_s = conducted.surge_speed_m_s;
    Ok(ShipManoeuvres {
        schema: "seatrial.ship_manoeuvres.v1",
        vehicle: vehicle.name.clone(),
        is_predicted: true,
        thrust: Some(thrust),
        surge_speed_m_s,
        length_m: wanted.length_m,
        straight_line_stable: Some(true),
        criteria: wanted.length_m.map_or(Vec::new(), |length_m| {
            let zig_zags = [0, 1].map(|k| conducted.zig_zags[k].as_ref());
            criteria(length_m, surge_speed_m_s, zig_zags, &conducted.circles)
        }),
        indices,
        notes,
    })
}

/// The 2.5 and 97.5 % points of the figures of drawn vehicles.
fn add_intervals(
    indices: &mut [Index],
    vehicle: &IdentifiedVehicle,
    thrust: f64,
    wanted: &ManoeuvreRequest,
) {
    if vehicle.speeds.iter().any(|speed| speed.covariance.is_none()) {
        return;
    }
    let drawn: Vec<Vec<Index>> = (0..wanted.draws)
        .map(|k| {
            let drawn = vehicle.drawn(wanted.seed.wrapping_add(k));
            SimulatedManoeuvres::of(&drawn, thrust, wanted.zig_zag_rad).indices()
        })
        .collect();
    for index in indices {
        let same =
            |other: &&Index| (&other.manoeuvre, other.name) == (&index.manoeuvre, index.name);
        let mut values: Vec<f64> =
            drawn.iter().filter_map(|indices| Some(indices.iter().find(same)?.value)).collect();
        values.sort_by(f64::total_cmp);
        let enough = values.len() as f64 >= SHARE_OF_DRAWS * wanted.draws as f64;
        index.interval_95 = (enough && values.len() >= 40)
            .then(|| [quantile(&values, 0.025), quantile(&values, 0.975)]);
    }
}

/// Linear between the values in their order.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * (sorted.len() - 1) as f64;
    let below = place as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

fn notes(vehicle: &IdentifiedVehicle, thrust: f64) -> Vec<String> {
    let mut notes = vec![
        "Straight-line stable, as a22 is below 0: the model's yaw rate is proportional to the rudder, so its spiral has no loop and a pull-out ends \
         from both sides with the yaw rate of the offset. A hull whose damping falls at small yaw rates may be unstable there all the same; a recorded spiral tells."
            .to_owned(),
        "Predicted for a vehicle that does not drift: a hull that does turns wider, by 12 to 35 % on the simulated vehicles.".to_owned(),
        "Stopping is not predicted: it needs reverse thrust, which the trial does not have. The inertia stop is with the propeller's thrust at zero.".to_owned(),
    ];
    let seen = vehicle.speeds.iter().filter_map(|p| p.seen_rudder_rad);
    if let Some(seen_rad) = seen.reduce(f64::min).filter(|s| 1.1 * s < vehicle.rudder.limit_rad) {
        notes.push(format!(
            "The records had at most {} deg of rudder; figures beyond it are extrapolated.",
            three_figures(seen_rad.to_degrees())
        ));
    }
    if vehicle.rudder.rate_limit_rad_s.is_none() {
        notes.push(
            "The rudder's rate is not known and taken as unlimited: a real one moves by 2 to 20 deg a second, and overshoots and periods are larger. \
             State it: `seatrial manoeuvres --model MODEL --rudder-rate-deg 10`."
                .to_owned(),
        );
    }
    if vehicle.speeds.iter().any(|speed| speed.covariance.is_none()) {
        notes.push("No intervals: the covariance of the model is not known.".to_owned());
    }
    let known =
        [vehicle.speeds.first(), vehicle.speeds.last()].map(|p| p.map_or(0.0, |p| p.thrust));
    if thrust < known[0] || thrust > known[1] {
        notes.push("The thrust lies beyond those of the trial: extrapolated.".to_owned());
    }
    let assumptions = vehicle.provenance.assumptions.iter().cloned();
    notes.extend(assumptions);
    notes
}

/// Positions over which the speed before a manoeuvre is taken, s.
const APPROACH_S: f64 = 10.0;

/// The figures of the manoeuvres of a record: of one kind, or of all that it holds.
pub fn of_record(
    name: &str,
    samples: &[Sample<f64>],
    length_m: Option<f64>,
    kind: Option<Kind>,
) -> Result<ShipManoeuvres, Error> {
    let wanted = ManoeuvreRequest {
        thrust: None,
        length_m,
        draws: 0,
        seed: 0,
        zig_zag_rad: None,
        own_error: None,
    };
    wanted.check()?;
    let found = recorded(samples, kind).map_err(|why| Error::Rejected(format!("{name}: {why}")))?;
    let speed_m_s = approach_m_s(samples);
    let mut document = ShipManoeuvres {
        schema: "seatrial.ship_manoeuvres.v1",
        vehicle: name.to_owned(),
        is_predicted: false,
        thrust: None,
        surge_speed_m_s: speed_m_s.unwrap_or(f64::NAN),
        length_m,
        straight_line_stable: None,
        indices: Vec::new(),
        criteria: Vec::new(),
        notes: Vec::new(),
    };
    for one in &found {
        add_recorded(&mut document, one, length_m.zip(speed_m_s));
    }
    Ok(document)
}

/// Speed before the manoeuvre: as measured, else between the positions of the first seconds.
fn approach_m_s(samples: &[Sample<f64>]) -> Option<f64> {
    let between_positions = || {
        let place = |s: &Sample<f64>| Some((s.time_s, s.north_m?, s.east_m?));
        let mut places = samples.iter().filter_map(place);
        let (from_s, north_m, east_m) = places.next()?;
        let last = places.take_while(|(time_s, ..)| *time_s <= from_s + APPROACH_S);
        let (to_s, to_north_m, to_east_m) = last.last()?;
        Some(libm::hypot(to_north_m - north_m, to_east_m - east_m) / (to_s - from_s))
    };
    let measured = samples.first().and_then(|s| s.surge_speed_m_s);
    measured.or_else(between_positions)
}

/// Adds the figures and criteria of a manoeuvre; `ship` is the length, m, and the speed, m/s, where both are known.
fn add_recorded(document: &mut ShipManoeuvres, one: &RecordedManoeuvre, ship: Option<(f64, f64)>) {
    let judged = |zig_zags: [Option<&ZigZag>; 2], circles: &[TurningCircle]| {
        ship.map_or(Vec::new(), |(l, v)| criteria(l, v, zig_zags, circles))
    };
    let (indices, criteria) = match one {
        RecordedManoeuvre::ZigZag(zig_zag) => {
            // The criteria are those of the 10/10 and the 20/20.
            let place = [10.0, 20.0].map(|angle| zig_zag.is_of(angle).then_some(zig_zag));
            (zig_zag_indices(zig_zag), judged(place, &[]))
        }
        RecordedManoeuvre::TurningCircle(circle) => {
            let circles = std::slice::from_ref(circle);
            (circle_indices(circle), judged([None; 2], circles))
        }
        RecordedManoeuvre::PullOut(out) => {
            document.straight_line_stable = out.straight_line_stable;
            document.notes.push(read::of_pull_out(out));
            (read::pull_out_indices(out), Vec::new())
        }
        RecordedManoeuvre::Spiral(spiral) => {
            document.straight_line_stable = spiral.loop_width.map(|found| found.is_stable());
            document.notes.push(read::of_spiral(spiral));
            (read::spiral_indices(spiral), Vec::new())
        }
        RecordedManoeuvre::Stopping(stop) => {
            document.surge_speed_m_s = stop.surge_speed_m_s;
            let judged = document.length_m.and_then(|length_m| stopping_criterion(length_m, stop));
            (read::stopping_indices(stop), judged.into_iter().collect())
        }
        _ => return,
    };
    document.indices.extend(indices);
    document.criteria.extend(criteria);
}

/// `20/10`, by rudder angle and heading change.
fn zig_zag_name(zig_zag: &ZigZag) -> String {
    let [rudder, heading] = [zig_zag.rudder_rad, zig_zag.heading_rad].map(f64::to_degrees);
    format!("zig-zag {rudder:.0}/{heading:.0}")
}

fn zig_zag_indices(zig_zag: &ZigZag) -> Vec<Index> {
    const OVERSHOOTS: [&str; 4] = [
        "first overshoot angle",
        "second overshoot angle",
        "third overshoot angle",
        "fourth overshoot angle",
    ];
    let index = |name, unit, value| Index {
        manoeuvre: zig_zag_name(zig_zag),
        name,
        unit,
        value,
        interval_95: None,
    };
    let mut indices = vec![
        index("initial turning time", "s", zig_zag.initial_turning_time_s),
        index("initial turning track", "m", zig_zag.initial_turning_track_m),
    ];
    for (name, overshoot) in OVERSHOOTS.into_iter().zip(&zig_zag.overshoots_rad) {
        indices.push(index(name, "deg", overshoot.to_degrees()));
    }
    indices.extend(zig_zag.period_s.map(|period_s| index("period", "s", period_s)));
    indices
}

fn circle_indices(circle: &TurningCircle) -> Vec<Index> {
    let side = match circle.side {
        Side::Starboard => "starboard",
        Side::Port => "port",
    };
    let index = |name, unit, value| Index {
        manoeuvre: format!("turning circle, {:.0} deg to {side}", circle.rudder_rad.to_degrees()),
        name,
        unit,
        value,
        interval_95: None,
    };
    vec![
        index("advance", "m", circle.advance_m),
        index("transfer", "m", circle.transfer_m),
        index("tactical diameter", "m", circle.tactical_diameter_m),
        index("time to 90 deg", "s", circle.times_s[0]),
        index("time to 180 deg", "s", circle.times_s[1]),
    ]
}
