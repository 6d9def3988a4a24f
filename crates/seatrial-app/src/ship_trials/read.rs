//! Pull-outs, spirals and stops of a record as figures and sentences.

use seatrial::sea_trials::ship_manoeuvres::{Index, PullOut, Spiral, Stopping};

fn index(manoeuvre: &str, name: &'static str, unit: &'static str, value: f64) -> Index {
    Index { manoeuvre: manoeuvre.to_owned(), name, unit, value, interval_95: None }
}

pub(super) fn pull_out_indices(out: &PullOut) -> Vec<Index> {
    let sides = [
        ("residual yaw rate, from starboard", out.from_starboard_rad_s),
        ("residual yaw rate, from port", out.from_port_rad_s),
    ];
    let known = sides.into_iter().filter_map(|(name, rate)| Some((name, rate?.to_degrees())));
    known.map(|(name, deg_s)| index("pull-out", name, "deg/s", deg_s)).collect()
}

pub(super) fn of_pull_out(out: &PullOut) -> String {
    match out.straight_line_stable {
        Some(true) => "Straight-line stable: the yaw rates after the pull-outs from both sides are one.",
        Some(false) => "NOT straight-line stable: with the rudder amidships the ship goes on turning to the side that it came from.",
        None => "A pull-out from one side only: whether the ship is straight-line stable needs the other side too.",
    }
    .to_owned()
}

pub(super) fn spiral_indices(spiral: &Spiral) -> Vec<Index> {
    let points = spiral.points.iter().map(|point| {
        let degrees = point.rudder_rad.to_degrees();
        let angle = match degrees.abs() < 0.05 {
            true => "0".to_owned(),
            false => format!("{degrees:+.1}"),
        };
        let name = match point.is_back {
            false => "yaw rate",
            true => "yaw rate on the way back",
        };
        let rate = point.yaw_rate_rad_s.to_degrees();
        index(&format!("spiral, {angle} deg"), name, "deg/s", rate)
    });
    let found = spiral.loop_width.into_iter().flat_map(|found| {
        [
            index("spiral", "loop width", "deg", found.width_rad.to_degrees()),
            index("spiral", "loop height", "deg/s", found.height_rad_s.to_degrees()),
        ]
    });
    points.chain(found).collect()
}

pub(super) fn of_spiral(spiral: &Spiral) -> String {
    match spiral.loop_width.map(|found| found.is_stable()) {
        Some(true) => "Straight-line stable: the yaw rates of the spiral are the same there and back, there is no loop.",
        Some(false) => "NOT straight-line stable: the spiral has a loop. Its width is known to the steps of the rudder angle.",
        None => "The spiral does not come back: whether it has a loop is not seen.",
    }
    .to_owned()
}

pub(super) fn stopping_indices(stop: &Stopping) -> Vec<Index> {
    let name = match stop.is_dead_in_the_water {
        true => "stop, dead in the water",
        false => "inertia stop to 20 % of the speed",
    };
    vec![
        index(name, "track reach", "m", stop.track_reach_m),
        index(name, "head reach", "m", stop.head_reach_m),
        index(name, "lateral deviation", "m", stop.lateral_deviation_m),
        index(name, "time", "s", stop.time_s),
    ]
}
