//! Pull-outs, spirals and stops read from records of simulated ships, against the ships' own parameters.

use seatrial::sea_trials::ship_manoeuvres::{Kind, ShipManoeuvres};
use seatrial_app::ship_trials::{ManoeuvreRequest, OwnError, of_record, predicted};
use seatrial_core::Sample;
use seatrial_sim::IdentifiedVehicle;

const INTERVAL_S: f64 = 0.5;
const SHIP: &str = "schema = \"seatrial.vehicle.v1\"\nname = \"ship\"\n[rudder]\nlimit_rad = 0.62\nlag_s = 2.0\n[surge]\ntime_constant_s = 60.0\n\
                    drag_length_m = 800.0\n[[speed]]\nthrust = 0.8\nsurge_speed_m_s = 7.7\na22_per_s = -0.05\nb2_per_s2 = 0.0026\nc0_rad_per_s2 = 0.000026\n";

/// Our simulated ship under rudders, deg, each for some seconds.
fn sailed(orders: &[(f64, f64)], thrust: f64) -> Vec<Sample<f64>> {
    let mut plant = IdentifiedVehicle::from_toml(SHIP).unwrap().plant(0.8);
    let mut samples: Vec<Sample<f64>> = Vec::new();
    for (rudder_deg, lasts_s) in orders {
        for _ in 0..(lasts_s / INTERVAL_S) as usize {
            samples.push(Sample {
                time_s: samples.len() as f64 * INTERVAL_S,
                heading_rad: plant.yaw.heading_rad,
                rudder_rad: rudder_deg.to_radians(),
                surge_speed_m_s: Some(plant.surge_speed_m_s),
                north_m: Some(plant.position_m[0]),
                east_m: Some(plant.position_m[1]),
                ..Sample::default()
            });
            plant.advance(rudder_deg.to_radians(), thrust, 0.0, INTERVAL_S);
        }
    }
    samples
}

/// A ship that is not straight-line stable: r' = a r - c r^3 + b d (Norrbin), which with the rudder amidships turns by sqrt(a/c), and
/// whose spiral turns over at d = 2 a^1.5/(3 b sqrt(3 c)).
struct Unstable {
    a: f64,
    b: f64,
    c: f64,
}

const UNSTABLE: Unstable = Unstable { a: 0.02, b: 0.0026, c: 312.5 };

impl Unstable {
    fn sailed(&self, orders: &[(f64, f64)]) -> Vec<Sample<f64>> {
        let (mut heading_rad, mut rate) = (0.0, 0.0);
        let mut samples: Vec<Sample<f64>> = Vec::new();
        for (rudder_deg, lasts_s) in orders {
            let rudder_rad = rudder_deg.to_radians();
            for _ in 0..(lasts_s / INTERVAL_S) as usize {
                samples.push(Sample {
                    time_s: samples.len() as f64 * INTERVAL_S,
                    heading_rad,
                    rudder_rad,
                    ..Sample::default()
                });
                for _ in 0..50 {
                    let h = INTERVAL_S / 50.0;
                    let change = self.a * rate - self.c * rate.powi(3) + self.b * rudder_rad;
                    heading_rad += h * (rate + 0.5 * h * change);
                    rate += h * change;
                }
            }
        }
        samples
    }

    /// The steady yaw rate of a rudder on the side of another, by Newton's method.
    fn steady(&self, rudder_rad: f64, near: f64) -> f64 {
        let mut rate = near;
        for _ in 0..200 {
            let value = self.a * rate - self.c * rate.powi(3) + self.b * rudder_rad;
            rate -= value / (self.a - 3.0 * self.c * rate * rate);
        }
        rate
    }
}

fn read(samples: &[Sample<f64>], kind: Option<Kind>) -> ShipManoeuvres {
    of_record("ship", samples, Some(170.0), kind).unwrap()
}

fn value(found: &ShipManoeuvres, manoeuvre: &str, name: &str) -> f64 {
    let mut indices = found.indices.iter();
    let index = indices.find(|index| index.manoeuvre == manoeuvre && index.name == name);
    index.unwrap_or_else(|| panic!("{manoeuvre}, {name}\n{found:#?}")).value
}

fn spiral_at(angle_deg: f64) -> String {
    match angle_deg {
        0.0 => "spiral, 0 deg".into(),
        _ => format!("spiral, {angle_deg:+.1} deg"),
    }
}

fn is_within_1_percent(found: f64, truth: f64) {
    assert!((found / truth - 1.0).abs() < 0.01, "{found} {truth}");
}

fn refusal(samples: &[Sample<f64>], kind: Option<Kind>) -> String {
    of_record("ship", samples, None, kind).unwrap_err().to_string()
}

/// What remains is -C0/a22 from both sides: a stable ship with an offset.
#[test]
fn exact_pull_outs_of_a_stable_ship() {
    let orders = [(0.0, 100.0), (20.0, 300.0), (0.0, 300.0), (-20.0, 300.0), (0.0, 300.0)];
    let found = read(&sailed(&orders, 0.8), Some(Kind::PullOut));
    let truth_deg_s = (0.000026_f64 / 0.05).to_degrees();
    for side in ["from starboard", "from port"] {
        let residual = value(&found, "pull-out", &format!("residual yaw rate, {side}"));
        is_within_1_percent(residual, truth_deg_s);
    }
    assert_eq!(found.straight_line_stable, Some(true));
    // Without being asked for, the turn before it is read as well.
    let all = read(&sailed(&orders, 0.8), None);
    assert!(all.indices.iter().any(|index| index.manoeuvre == "pull-out"));
    assert!(all.indices.iter().any(|index| index.name == "tactical diameter"));
    assert!(!all.indices.iter().any(|index| index.name == "first overshoot angle"), "{all:#?}");
}

#[test]
fn exact_pull_outs_of_a_ship_that_goes_on_turning() {
    let orders = [(20.0, 400.0), (0.0, 600.0), (-20.0, 400.0), (0.0, 600.0)];
    let found = read(&UNSTABLE.sailed(&orders), None);
    let truth = (UNSTABLE.a / UNSTABLE.c).sqrt().to_degrees();
    is_within_1_percent(value(&found, "pull-out", "residual yaw rate, from starboard"), truth);
    is_within_1_percent(value(&found, "pull-out", "residual yaw rate, from port"), -truth);
    assert_eq!(found.straight_line_stable, Some(false));
    assert!(found.notes[0].starts_with("NOT straight-line stable"));
    let one_side = read(&UNSTABLE.sailed(&orders[..2]), None);
    assert_eq!(one_side.straight_line_stable, None);
}

fn spiral_orders(angles_deg: &[f64], lasts_s: f64) -> Vec<(f64, f64)> {
    let back = angles_deg.iter().rev().skip(1);
    let angles = angles_deg.iter().chain(back);
    angles.map(|angle| (*angle, lasts_s)).collect()
}

/// K (delta + delta0) there and back, and no loop.
#[test]
fn exact_a_spiral_of_a_stable_ship_has_no_loop() {
    let angles = [20.0, 10.0, 5.0, 0.0, -5.0, -10.0, -20.0];
    let mut orders = vec![(0.0, 60.0)];
    orders.extend(spiral_orders(&angles, 200.0));
    orders.push((0.0, 200.0));
    let found = read(&sailed(&orders, 0.8), None);
    for angle in angles {
        let truth = ((0.0026 * f64::to_radians(angle) + 0.000026) / 0.05).to_degrees();
        let manoeuvre = spiral_at(angle);
        is_within_1_percent(value(&found, &manoeuvre, "yaw rate"), truth);
        if angle != -20.0 {
            is_within_1_percent(value(&found, &manoeuvre, "yaw rate on the way back"), truth);
        }
    }
    assert_eq!(value(&found, "spiral", "loop width"), 0.0);
    assert_eq!(found.straight_line_stable, Some(true));
    let there = read(&sailed(&orders[..8], 0.8), Some(Kind::Spiral));
    assert_eq!(there.straight_line_stable, None);
}

/// The rates are those of the branch that the ship is on, and the loop is as wide as the two folds are apart, up to the steps.
#[test]
fn exact_a_spiral_of_an_unstable_ship_has_its_loop() {
    let step_deg = 0.25;
    let angles: Vec<f64> = (0..=32).map(|k| 4.0 - step_deg * f64::from(k)).collect();
    let found = read(&UNSTABLE.sailed(&spiral_orders(&angles, 1200.0)), Some(Kind::Spiral));
    for (angle, near) in [(4.0_f64, 0.01), (0.0, 0.01), (-1.0, 0.01), (-4.0, -0.01)] {
        let truth = UNSTABLE.steady(angle.to_radians(), near).to_degrees();
        is_within_1_percent(value(&found, &spiral_at(angle), "yaw rate"), truth);
    }
    let Unstable { a, b, c } = UNSTABLE;
    let fold_deg = (2.0 * a.powf(1.5) / (3.0 * b * (3.0 * c).sqrt())).to_degrees();
    let width = value(&found, "spiral", "loop width");
    // Each side is the middle of a step.
    assert!((width - 2.0 * fold_deg).abs() <= step_deg, "{width} {fold_deg}");
    let height = value(&found, "spiral", "loop height");
    is_within_1_percent(height, 2.0 * (a / c).sqrt().to_degrees());
    assert_eq!(found.straight_line_stable, Some(false));
}

/// u' = -u^2/l without thrust: a fifth after 4 l/u, over l ln 5. The order is found where the speed begins to fall.
#[test]
fn exact_an_inertia_stop() {
    let mut orders = sailed(&[(0.0, 100.0)], 0.8);
    let mut plant = IdentifiedVehicle::from_toml(SHIP).unwrap().plant(0.8);
    let begins_s = orders.len() as f64 * INTERVAL_S;
    // The rudder that holds the course: -C0/b2.
    let rudder_rad = -0.01;
    for sample in &mut orders {
        sample.heading_rad = 0.0;
        sample.rudder_rad = rudder_rad;
        sample.north_m = Some(7.7 * (sample.time_s - begins_s));
        sample.east_m = Some(0.0);
    }
    for k in 0..1200 {
        orders.push(Sample {
            time_s: begins_s + f64::from(k) * INTERVAL_S,
            heading_rad: 0.0,
            rudder_rad,
            surge_speed_m_s: Some(plant.surge_speed_m_s),
            north_m: Some(plant.position_m[0]),
            east_m: Some(0.0),
            ..Sample::default()
        });
        plant.advance(rudder_rad, 0.0, 0.0, INTERVAL_S);
    }
    let with_speed = read(&orders, None);
    let name = "inertia stop to 20 % of the speed";
    for sample in &mut orders {
        sample.surge_speed_m_s = None;
    }
    let with_position = read(&orders, Some(Kind::Stopping));
    for found in [&with_speed, &with_position] {
        is_within_1_percent(value(found, name, "time"), 4.0 * 800.0 / 7.7);
        is_within_1_percent(value(found, name, "track reach"), 800.0 * 5_f64.ln());
        is_within_1_percent(value(found, name, "head reach"), 800.0 * 5_f64.ln());
        assert!(value(found, name, "lateral deviation").abs() < 1e-6);
        assert!(found.criteria.is_empty(), "coasting is not judged");
    }
}

/// Full astern: u' = -(u^2 + w^2)/l is dead in the water after (l/w) atan(u/w), over (l/2) ln(1 + u^2/w^2), on a turn to port whose
/// heading grows as the way: a circle of 1000 m.
#[test]
fn exact_a_stop_with_full_astern() {
    let (l, w, radius): (f64, f64, f64) = (800.0, 5.0, 1000.0);
    let phase = (7.7 / w).atan();
    let way = |t: f64| l * ((phase - t * w / l).cos() / phase.cos()).ln();
    let samples: Vec<Sample<f64>> = (0..400)
        .map(|k| {
            let t = f64::from(k) * INTERVAL_S;
            let turned = way(t) / radius;
            let heading_0: f64 = 1.0;
            let (ahead, aside) = (radius * turned.sin(), -radius * (1.0 - turned.cos()));
            Sample {
                time_s: t,
                heading_rad: heading_0 - turned,
                surge_speed_m_s: Some(w * (phase - t * w / l).tan()),
                thrust: Some(-1.0),
                north_m: Some(ahead * heading_0.cos() - aside * heading_0.sin()),
                east_m: Some(ahead * heading_0.sin() + aside * heading_0.cos()),
                ..Sample::default()
            }
        })
        .take_while(|sample| sample.surge_speed_m_s.unwrap() > -1.0)
        .collect();
    let found = read(&samples, None);
    let name = "stop, dead in the water";
    let reach = 0.5 * l * (1.0 + (7.7 / w).powi(2)).ln();
    is_within_1_percent(value(&found, name, "track reach"), reach);
    is_within_1_percent(value(&found, name, "time"), l / w * phase);
    is_within_1_percent(value(&found, name, "head reach"), radius * (reach / radius).sin());
    let aside = value(&found, name, "lateral deviation");
    is_within_1_percent(aside, -radius * (1.0 - (reach / radius).cos()));
    assert_eq!(found.criteria.len(), 1);
    assert!((found.criteria[0].value * 170.0 / reach - 1.0).abs() < 0.01);
}

/// A record without the manoeuvre is refused with its cause.
#[test]
fn exact_what_a_record_does_not_hold_is_said() {
    let straight = sailed(&[(0.0, 300.0)], 0.8);
    assert!(refusal(&straight, None).contains("the rudder does not move"));
    assert!(refusal(&straight, Some(Kind::Stopping)).contains("the least speed is 100 %"));
    let short = sailed(&[(20.0, 100.0), (0.0, 25.0)], 0.8);
    assert!(refusal(&short, Some(Kind::PullOut)).contains("still changes"));
    assert!(refusal(&short, Some(Kind::Spiral)).contains("five or more angles"));
    assert!(refusal(&short, Some(Kind::ZigZag)).contains("three times"));
    let hasty = sailed(&spiral_orders(&[20.0, 10.0, 0.0, -10.0, -20.0], 20.0), 0.8);
    let said = refusal(&hasty, Some(Kind::Spiral));
    assert!(said.contains("deg of rudder, from") && said.contains("still changes"), "{said}");
    assert_eq!(refusal(&hasty, None), said);
    let slowed = sailed(&[(5.0, 20.0)], 0.0);
    assert!(refusal(&slowed, Some(Kind::Stopping)).contains("a stop needs 20 %"));
    let turn = sailed(&[(20.0, 60.0)], 0.8);
    assert!(refusal(&turn, Some(Kind::TurningCircle)).contains("180 degrees"));
    assert!(refusal(&[], None).contains("no forward speed"));
}

/// The zig-zag of a rudder and a heading change, by our own ship.
fn zig_zag(rudder_deg: f64, heading_deg: f64) -> Vec<Sample<f64>> {
    let mut plant = IdentifiedVehicle::from_toml(SHIP).unwrap().plant(0.8);
    let mut side = 1.0;
    (0..2000)
        .map(|k| {
            if side * plant.yaw.heading_rad >= heading_deg.to_radians() {
                side = -side;
            }
            let rudder_rad = side * rudder_deg.to_radians();
            let sample = Sample {
                time_s: 0.2 * f64::from(k),
                heading_rad: plant.yaw.heading_rad,
                rudder_rad,
                surge_speed_m_s: Some(plant.surge_speed_m_s),
                ..Sample::default()
            };
            plant.advance(rudder_rad, 0.8, 0.0, 0.2);
            sample
        })
        .collect()
}

/// A 20/10 is named so, is not judged as a 20/20, and is predicted by both angles; on the record of its own a true model has no error.
#[test]
fn exact_a_zig_zag_has_two_angles() {
    let record = zig_zag(20.0, 10.0);
    let found = read(&record, Some(Kind::ZigZag));
    assert!(found.criteria.is_empty(), "{found:#?}");
    let vehicle = IdentifiedVehicle::from_toml(SHIP).unwrap();
    let own = OwnError::of(&vehicle, None, "ship", &record).unwrap();
    // The rudder of the record is ordered over up to 0.2 s late.
    assert!(own.mean.abs() < 0.02 && own.half_width < 0.1, "{own:?}");
    let wanted = ManoeuvreRequest {
        thrust: None,
        length_m: None,
        draws: 0,
        seed: 1,
        zig_zag_rad: Some([20.0_f64, 10.0].map(f64::to_radians)),
        own_error: Some(OwnError { mean: 0.5, half_width: 0.25, overshoots: 3 }),
    };
    let predicted = predicted(&vehicle, &wanted).unwrap();
    for name in ["first overshoot angle", "second overshoot angle"] {
        let ours = value(&predicted, "zig-zag 20/10", name);
        let theirs = value(&found, "zig-zag 20/10", name);
        assert!((theirs / ours - 1.0).abs() < 0.02, "{name} {ours} {theirs}");
        let index =
            predicted.indices.iter().find(|i| i.manoeuvre == "zig-zag 20/10" && i.name == name);
        let [low, high] = index.unwrap().interval_95.unwrap();
        assert!((low / ours - 1.25).abs() < 1e-9 && (high / ours - 1.75).abs() < 1e-9);
    }
    assert!(predicted.notes.iter().any(|note| note.contains("its own record")));
    let too_far = ManoeuvreRequest { zig_zag_rad: Some([0.7, 0.2]), ..wanted };
    assert!(ship_trials_refusal(&vehicle, &too_far).contains("the rudder's limit is 35.5 deg"));
    let turn = sailed(&[(20.0, 60.0)], 0.8);
    let refused = OwnError::of(&vehicle, None, "ship", &turn).unwrap_err();
    assert!(refused.to_string().contains("no zig-zag"), "{refused}");
}

fn ship_trials_refusal(vehicle: &IdentifiedVehicle, wanted: &ManoeuvreRequest) -> String {
    predicted(vehicle, wanted).unwrap_err().to_string()
}
