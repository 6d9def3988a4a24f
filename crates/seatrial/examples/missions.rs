//! Ordinary missions of simulated boats under an autopilot, each identified as `seatrial identify LOG` does.
//!
//! ```text
//! cargo run -p seatrial --example missions -- SEED COUNT
//! cargo run -p seatrial --example missions -- SEED COUNT watch
//! cargo run -p seatrial --example missions -- SEED COUNT hulls
//! ```
//!
//! With `watch` each boat sails eleven missions: the first is the reference, and `health --watch` reads the other ten, of the same boat and of one
//! whose rudder is 20 % weaker.
//!
//! With `hulls` the boats are not of first order: damping that grows with the turn, sway, course-unstable or not, or a gear with play or a largest rate. Their steady turn at the
//! largest rudder of the log and the course change of 40 deg under the gain that is handed out are simulated.
//!
//! A boat is simulated in steps of 1 ms; its compass and, in seven of ten, its gyro are noisy, its rudder may lag, and the log says nothing of
//! that. The rough sea is a sum of fifteen waves and a Gauss-Markov disturbance: no hypothesis has that spectrum.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, TAU};

use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use seatrial::health::{
    Finding, HealthError, HealthSettings, Reference, SpeedModel, Watch, WatchReport,
};
use seatrial::identification::{interval_95, with_steady_gain};
use seatrial::identify::{IdentifySettings, identify};
use seatrial::{COURSE_CHANGE_RAD, GainAllowance, Identification, Record, Sample, Window};

const KINDS: [&str; 6] = [
    "survey, calm",
    "waypoints, calm",
    "waypoints, rudder lag",
    "survey, waves",
    "waypoints, sea",
    "waypoints, rough sea",
];

/// A boat with its sensors, its sea and its autopilot.
#[derive(Clone)]
struct Boat {
    kind: usize,
    a22_per_s: f64,
    b2_per_s2: f64,
    lag_s: f64,
    offset_rad: f64,
    rate_limit_rad_s: f64,
    interval_s: f64,
    duration_s: f64,
    leg_s: f64,
    compass_rad: f64,
    gyro_rad_s: f64,
    gyro_bias_rad_s: f64,
    has_gyro: bool,
    sea_rad_s2: f64,
    wave_rad_s2: f64,
    /// Frequency, amplitude over the whole, phase.
    waves: Vec<[f64; 3]>,
    /// Proportional, rate, integral.
    gains: [f64; 3],
    hull: Hull,
}

/// What a boat has beside first order.
#[derive(Clone, Copy, Default)]
struct Hull {
    /// Damping that grows with the yaw rate, 1/rad.
    quadratic_per_rad: f64,
    /// Yaw moment per sway, 1/s^2, and time constant of sway, s; 0 is none.
    sway: [f64; 2],
    /// Play of the gear from stop to stop, rad.
    play_rad: f64,
    /// Largest rate of the gear, which the log does not tell, rad/s; 0 is none.
    slew_rad_s: f64,
}

/// Motion of a boat.
#[derive(Clone, Copy, Default)]
struct Motion {
    heading_rad: f64,
    rate_rad_s: f64,
    sway: f64,
    lagging_rad: f64,
    acting_rad: f64,
}

const FULL_RAD: f64 = 0.524;
const STEP_S: f64 = 0.001;
/// Time in which every boat turns steadily, s.
const STEADY_S: f64 = 200.0;

impl Boat {
    fn draw(seed: u64, rng: &mut Pcg64Mcg) -> Self {
        let kind = (seed % 6) as usize;
        let mut between = |from: f64, to: f64| from + (to - from) * rng.random::<f64>();
        let time_constant_s = between(0.6_f64.ln(), 8.0_f64.ln()).exp();
        let b2_per_s2 = 0.9 * between(0.4, 1.2) / time_constant_s.powf(1.5);
        let natural = between(0.8, 1.5) / time_constant_s;
        let gain = natural * natural / b2_per_s2;
        let slow = (time_constant_s / 2.0).clamp(1.0, 3.0);
        let lags = kind == 2 || between(0.0, 1.0) < 0.3;
        let [sea, wave] = match kind {
            3 => [0.15, between(0.5, 1.0)],
            4 => [between(0.5, 2.0), 0.0],
            5 => [between(0.5, 2.0), between(0.5, 1.5)],
            _ => [0.025, 0.0],
        };
        let peak = TAU / between(3.0, 8.0);
        let shapes = (0..15).map(|i| {
            let frequency = peak * (0.6 + 0.1 * f64::from(i));
            (frequency, (-((frequency - peak) / (0.25 * peak)).powi(2)).exp().sqrt())
        });
        let shapes: Vec<(f64, f64)> = shapes.collect();
        let total = (shapes.iter().map(|(_, a)| 0.5 * a * a).sum::<f64>()).sqrt();
        Self {
            kind,
            a22_per_s: -1.0 / time_constant_s,
            b2_per_s2,
            lag_s: if lags { between(0.05, 0.3) } else { 0.0 },
            offset_rad: between(-0.035, 0.035),
            rate_limit_rad_s: FULL_RAD / between(0.5, 1.5),
            interval_s: [0.2, 0.1, 0.05][(3.0 * between(0.0, 1.0)) as usize],
            duration_s: between(300.0, 700.0) * slow,
            leg_s: between(25.0, 60.0) * (time_constant_s / 2.0).max(1.0),
            compass_rad: between(0.1, 0.6).to_radians(),
            gyro_rad_s: between(0.1, 0.5).to_radians(),
            gyro_bias_rad_s: between(-0.2, 0.2).to_radians(),
            has_gyro: between(0.0, 1.0) < 0.7,
            sea_rad_s2: 0.03 * b2_per_s2 * sea,
            wave_rad_s2: 0.05 * b2_per_s2 * wave,
            waves: shapes.iter().map(|(w, a)| [*w, a / total, between(0.0, TAU)]).collect(),
            gains: [
                gain,
                ((1.6 * natural - 1.0 / time_constant_s) / b2_per_s2).max(0.0),
                0.02 * gain,
            ],
            hull: Hull::default(),
        }
    }

    /// With a hull or a gear beyond first order.
    fn beyond_first_order(mut self, hull: usize, rng: &mut Pcg64Mcg) -> Self {
        let mut between = |from: f64, to: f64| from + (to - from) * rng.random::<f64>();
        let damping = -self.a22_per_s;
        match hull {
            0 => {
                self.hull.quadratic_per_rad = between(1.5, 6.0);
                self.a22_per_s *= between(0.2, 0.6);
            }
            1 => {
                let sway_s = between(1.0, 4.0) / damping;
                self.hull.sway = [between(0.2, 0.6) * damping / sway_s, sway_s];
            }
            2 => self.hull.play_rad = between(0.02, 0.09),
            3 => self.hull.slew_rad_s = self.rate_limit_rad_s * between(0.3, 0.8),
            _ => {
                let sway_s = between(1.0, 4.0) / damping;
                self.hull.sway = [between(1.05, 1.4) * damping / sway_s, sway_s];
                self.hull.quadratic_per_rad = between(0.5, 2.0);
            }
        }
        self
    }

    /// One step under a command of the gear.
    fn step(&self, x: &mut Motion, command_rad: f64, disturbed_rad_s2: f64) {
        let share = if self.lag_s > 0.0 { 1.0 - (-STEP_S / self.lag_s).exp() } else { 1.0 };
        let mut moved_rad = share * (command_rad - x.lagging_rad);
        if self.hull.slew_rad_s > 0.0 {
            let most_rad = self.hull.slew_rad_s * STEP_S;
            moved_rad = moved_rad.clamp(-most_rad, most_rad);
        }
        x.lagging_rad += moved_rad;
        let half = 0.5 * self.hull.play_rad;
        x.acting_rad = x.acting_rad.clamp(x.lagging_rad - half, x.lagging_rad + half);
        let [coupling, sway_s] = self.hull.sway;
        let rate = x.rate_rad_s;
        let turning = self.a22_per_s * rate - self.hull.quadratic_per_rad * rate * rate.abs()
            + coupling * x.sway
            + self.b2_per_s2 * (x.acting_rad + self.offset_rad)
            + disturbed_rad_s2;
        if sway_s > 0.0 {
            x.sway += STEP_S * (rate - x.sway / sway_s);
        }
        x.heading_rad += STEP_S * rate + 0.5 * STEP_S * STEP_S * turning;
        x.rate_rad_s += STEP_S * turning;
    }

    /// In calm water without trim.
    fn calm(&self) -> Self {
        Self { offset_rad: 0.0, ..self.clone() }
    }

    /// Steady yaw rate at a rudder angle, rad/s.
    fn steady_rad_s(&self, rudder_rad: f64) -> f64 {
        let (calm, mut x) = (self.calm(), Motion::default());
        for _ in 0..(STEADY_S / STEP_S) as usize {
            calm.step(&mut x, rudder_rad, 0.0);
        }
        x.rate_rad_s
    }

    /// Overshoot of a course change of 40 deg under a gain, and how far the heading swings in the end, shares of it.
    fn course_change(&self, gain: f64) -> [f64; 2] {
        let (calm, mut x) = (self.calm(), Motion::default());
        let parts = (self.interval_s / STEP_S).round() as usize;
        let rows = (STEADY_S / self.interval_s) as usize;
        let (mut most, mut low, mut high) = (0.0_f64, f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..rows {
            let command = (gain * (COURSE_CHANGE_RAD - x.heading_rad)).clamp(-FULL_RAD, FULL_RAD);
            for _ in 0..parts {
                calm.step(&mut x, command, 0.0);
            }
            most = most.max(x.heading_rad - COURSE_CHANGE_RAD);
            if 4 * k > 3 * rows {
                (low, high) = (low.min(x.heading_rad), high.max(x.heading_rad));
            }
        }
        [most, high - low].map(|rad| rad / COURSE_CHANGE_RAD)
    }

    fn disturbance_rad_s2(&self, time_s: f64, wander: f64) -> f64 {
        let waves = self
            .waves
            .iter()
            .map(|[frequency, amplitude, phase]| amplitude * (frequency * time_s + phase).sin());
        wander + self.wave_rad_s2 * waves.sum::<f64>()
    }

    /// The next heading to steer, rad, and until when, s.
    fn next_leg(&self, leg: u32, from_rad: f64, from_s: f64, rng: &mut Pcg64Mcg) -> (f64, f64) {
        match self.kind {
            0 | 3 => {
                let side = if leg % 4 < 2 { 1.0 } else { -1.0 };
                let share = if leg.is_multiple_of(2) { 0.4 } else { 1.0 };
                (from_rad + side * FRAC_PI_2, from_s + share * self.leg_s)
            }
            _ => (
                from_rad + rng.random_range(-1.6..1.6),
                from_s + rng.random_range(0.5..1.3) * self.leg_s,
            ),
        }
    }

    fn sail(&self, rng: &mut Pcg64Mcg) -> Record {
        let normal = |rng: &mut Pcg64Mcg| -> f64 { StandardNormal.sample(rng) };
        let steps = (self.interval_s / STEP_S).round() as usize;
        let forget_s = -2.0 / self.a22_per_s;
        let mut goal_rad = rng.random_range(-3.0..3.0);
        let (mut x, mut command) = (Motion::default(), 0.0);
        x.heading_rad = goal_rad;
        let (mut wander, mut integral, mut until_s, mut leg) = (0.0, 0.0, self.leg_s, 0);
        let mut record = Record::default();
        for k in 0..(self.duration_s / self.interval_s) as usize {
            let time_s = k as f64 * self.interval_s;
            let seen_rad = x.heading_rad + self.compass_rad * normal(rng);
            let gyro = x.rate_rad_s + self.gyro_bias_rad_s + self.gyro_rad_s * normal(rng);
            if time_s > until_s {
                (goal_rad, until_s) = self.next_leg(leg, goal_rad, until_s, rng);
                leg += 1;
            }
            let off = (goal_rad - seen_rad).clamp(-0.8, 0.8);
            let [proportional, damping, integrating] = self.gains;
            integral = (integral + integrating * off * self.interval_s).clamp(-0.1, 0.1);
            let asked = (proportional * off - damping * gyro + integral).clamp(-FULL_RAD, FULL_RAD);
            let most = self.rate_limit_rad_s * self.interval_s;
            command += (asked - command).clamp(-most, most);
            record.samples.push(Sample {
                time_s,
                heading_rad: seen_rad,
                rudder_rad: command,
                yaw_rate_rad_s: self.has_gyro.then_some(gyro),
                ..Sample::default()
            });
            for step in 0..steps {
                wander += -wander * STEP_S / forget_s
                    + self.sea_rad_s2 * (2.0 * STEP_S / forget_s).sqrt() * normal(rng);
                let disturbed = self.disturbance_rad_s2(time_s + step as f64 * STEP_S, wander);
                self.step(&mut x, command, disturbed);
            }
        }
        record
    }
}

#[derive(Default)]
struct Row {
    missions: u32,
    accepted: u32,
    hold_both: u32,
    beyond_two: u32,
    errors: Vec<[f64; 2]>,
}

/// What ten missions say of a boat whose rudder does this share of what it did in the first one; `None` where that one has no model.
fn watch(boat: &Boat, seed: u64, share: f64) -> Result<Option<WatchReport>, HealthError> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let first = boat.sail(&mut rng);
    let found = identify(&first, Window::ALL, None, &IdentifySettings::default()).ok();
    let found = found.filter(|found| found.verdict.accepted);
    let Some(reference) = found.and_then(|found| SpeedModel::of(&found, None, None)) else {
        return Ok(None);
    };
    let settings = HealthSettings::new(0.05, 0.05, false)?;
    let mut watch = Watch::new(Reference::new(vec![reference])?, settings)?;
    let now = Boat { b2_per_s2: share * boat.b2_per_s2, ..boat.clone() };
    for mission in 1..=10 {
        watch.read(&mission.to_string(), &now.sail(&mut rng));
    }
    Ok(Some(watch.report()))
}

fn watched(seed: u64, count: u64) -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "| kind | boats | hours unchanged | false alarms | weaker rudder seen | in the first three missions |\n|---|---|---|---|---|---|"
    );
    let mut rows: BTreeMap<usize, [f64; 5]> = BTreeMap::new();
    for seed in seed..seed + count {
        let boat = Boat::draw(seed, &mut Pcg64Mcg::seed_from_u64(seed));
        let (same, weak) = (watch(&boat, seed, 1.0)?, watch(&boat, seed, 0.8)?);
        let row = rows.entry(boat.kind).or_default();
        let (Some(same), Some(weak)) = (same, weak) else {
            continue;
        };
        row[0] += 1.0;
        row[1] += same.read_s / 3600.0;
        row[2] += f64::from(u8::from(same.finding == Finding::Changed));
        row[3] += f64::from(u8::from(weak.finding == Finding::Changed));
        let first = weak.windows.iter().find(|window| window.alarm);
        let first = first.and_then(|window| window.log.parse::<u32>().ok());
        row[4] += f64::from(u8::from(first.is_some_and(|mission| mission <= 3)));
    }
    for (kind, [boats, hours, alarms, seen, early]) in rows {
        let name = KINDS[kind];
        println!("| {name} | {boats} | {hours:.0} | {alarms} | {seen} | {early} |");
    }
    Ok(())
}

const HULLS: [&str; 5] = ["quadratic damping", "stable sway", "play", "slow gear", "unstable sway"];

#[derive(Default)]
struct OfHulls {
    missions: u32,
    accepted: u32,
    /// Steady turns told, and inside their intervals.
    turns: [u32; 2],
    gains: u32,
    overshooting: u32,
}

fn of_hulls(seed: u64, count: u64) {
    println!(
        "| hull | missions | accepted | turn inside of those told | gains | overshooting over 25 % or swinging |\n|---|---|---|---|---|---|"
    );
    let mut rows: [OfHulls; 5] = Default::default();
    for seed in seed..seed + count {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let hull = (seed / 6 % 5) as usize;
        let boat = Boat::draw(seed, &mut rng).beyond_first_order(hull, &mut rng);
        let record = boat.sail(&mut rng);
        let row = &mut rows[hull];
        row.missions += 1;
        let found = identify(&record, Window::ALL, None, &IdentifySettings::default());
        let Ok(found) = found else { continue };
        let gain =
            GainAllowance::of(&found).design(&found.model(), core::f64::consts::FRAC_1_SQRT_2).ok();
        let amplitude_rad = amplitude_rad(&record);
        let truth = boat.steady_rad_s(amplitude_rad);
        let told = steady_95(&found, amplitude_rad);
        let step = gain.as_ref().map(|gain| boat.course_change(gain.proportional_gain));
        if std::env::var("VERBOSE").is_ok() {
            println!(
                "{seed} {} {} {} {:.3?} b2 {:.3}: {:.3?} turn {truth:.4} {told:.4?} step {step:.2?} {:?}",
                HULLS[hull],
                KINDS[boat.kind],
                found.verdict.accepted,
                found.model().theta(),
                boat.b2_per_s2,
                found.method(),
                found.verdict.reasons.iter().map(|r| r.kind().to_string()).collect::<Vec<_>>()
            );
        }
        if !found.verdict.accepted {
            continue;
        }
        row.accepted += 1;
        if let Some([low, high]) = told {
            row.turns[0] += 1;
            row.turns[1] += u32::from((low..=high).contains(&truth));
        }
        if let Some([over, swing]) = step {
            row.gains += 1;
            row.overshooting += u32::from(over > 0.25 || swing > 0.1);
        }
    }
    for (name, row) in HULLS.iter().zip(rows) {
        let [told, inside] = row.turns;
        println!(
            "| {name} | {} | {} | {inside} of {told} | {} | {} |",
            row.missions, row.accepted, row.gains, row.overshooting
        );
    }
}

/// Largest rudder that is used for a hundredth of the time to either side, rad.
fn amplitude_rad(record: &Record) -> f64 {
    let mut rudders: Vec<f64> = record.samples.iter().map(|s| s.rudder_rad).collect();
    rudders.sort_by(f64::total_cmp);
    let at = |share: f64| rudders[(share * rudders.len() as f64) as usize];
    0.5 * (at(0.99) - at(0.01))
}

/// 95 % interval of the steady yaw rate at a rudder angle, rad/s, as `seatrial turn` takes it.
fn steady_95(found: &Identification, rudder_rad: f64) -> Option<[f64; 2]> {
    let refined = found.refined.as_ref()?;
    let (mut model, mut covariance) = (refined.model, refined.covariance);
    if let Some(turn) = found.steady_turn() {
        let log_gain = turn.log_gain_at(rudder_rad);
        (model, covariance) = with_steady_gain(&model, &covariance, log_gain)?;
    }
    interval_95(&model, &covariance, |model| Some(-model.b2_per_s2 / model.a22_per_s * rudder_rad))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut numbers = std::env::args().skip(1).take(2).map(|text| text.parse::<u64>());
    let seed = numbers.next().unwrap_or(Ok(0))?;
    let count = numbers.next().unwrap_or(Ok(60))?;
    match std::env::args().nth(3).as_deref() {
        Some("watch") => return watched(seed, count),
        Some("hulls") => {
            of_hulls(seed, count);
            return Ok(());
        }
        _ => {}
    }
    let is_verbose = std::env::var("VERBOSE").is_ok();
    let mut rows: BTreeMap<usize, Row> = BTreeMap::new();
    for seed in seed..seed + count {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let boat = Boat::draw(seed, &mut rng);
        let record = boat.sail(&mut rng);
        let found = identify(&record, Window::ALL, None, &IdentifySettings::default());
        let row = rows.entry(boat.kind).or_default();
        row.missions += 1;
        let Ok(found) = found else { continue };
        let Some(refined) = found.refined.as_ref() else {
            continue;
        };
        let truth = [boat.a22_per_s, boat.b2_per_s2];
        let intervals = [refined.interval_95.a22_per_s, refined.interval_95.b2_per_s2];
        let widths: Vec<f64> = (truth.iter().zip(intervals))
            .map(|(truth, [low, high])| (truth - 0.5 * (low + high)) / (0.5 * (high - low)))
            .collect();
        if is_verbose {
            println!(
                "{seed} {} T {:.2} lag {:.2} {}: half widths {widths:.2?}, {}, {:?}",
                KINDS[boat.kind],
                -1.0 / boat.a22_per_s,
                boat.lag_s,
                found.method(),
                found.verdict.accepted,
                found.verdict.reasons.first().map(|r| r.measured().to_string())
            );
        }
        if !found.verdict.accepted {
            continue;
        }
        row.accepted += 1;
        row.hold_both += u32::from(widths.iter().all(|w| w.abs() <= 1.0));
        row.beyond_two += u32::from(widths.iter().any(|w| w.abs() > 2.0));
        let model = [refined.model.a22_per_s, refined.model.b2_per_s2];
        row.errors.push([0, 1].map(|i| (model[i] / truth[i] - 1.0).abs()));
    }
    println!(
        "| kind | missions | accepted | hold both | beyond two half widths | median error of a22, b2 |\n|---|---|---|---|---|---|"
    );
    for (kind, mut row) in rows {
        let median = |row: &mut Row, i: usize| {
            row.errors.sort_by(|a, b| a[i].total_cmp(&b[i]));
            row.errors.get(row.errors.len() / 2).map_or(f64::NAN, |e| 100.0 * e[i])
        };
        let medians = [0, 1].map(|i| median(&mut row, i));
        println!(
            "| {} | {} | {} | {} | {} | {:.1} %, {:.1} % |",
            KINDS[kind],
            row.missions,
            row.accepted,
            row.hold_both,
            row.beyond_two,
            medians[0],
            medians[1]
        );
    }
    Ok(())
}
