//! Vehicles that are not of first order, each identified from one doublet each way: `cargo run -p seatrial --example hulls -- SEED COUNT`.
//!
//! Each is simulated by itself, with steps of 2 ms. Of each kind: how many are accepted, how often the steady yaw rates at the
//! manoeuvre's rudder to both sides are told and inside their intervals, how often there is a gain that overshoots a course change of 40 deg by more than a
//! quarter or swings for ever on the vehicle itself, how often that overshoot is inside the one that is promised, and what was said of sound parts.

use std::collections::BTreeMap;

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};
use seatrial::identification::{interval_95, with_steady_gain};
use seatrial::identify::{IdentifySettings, ValidationData, identify};
use seatrial::{
    COURSE_CHANGE_RAD, CourseChange, GainAllowance, Identification, Record, Sample, Window,
};
use seatrial_core::YawModel;

/// Yaw, sway and surge of a vehicle, its gear, and its sensors.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hull {
    /// Linear damping and quadratic damping of yaw, 1/s and 1/rad.
    pub damping: [f64; 2],
    /// Rudder effect at the first speed, 1/s^2.
    pub authority_per_s2: f64,
    /// Yaw moment per sway, 1/s^2, and time constant of sway, s; 0 is none.
    pub sway: [f64; 2],
    /// Share of the speed lost per rad/s of turn, s; time constant of the speed, s.
    pub speed_loss: [f64; 2],
    /// Dead time, s; lag, s; largest rate, rad/s; play from stop to stop, rad; 0 is none.
    pub gear: [f64; 4],
    /// Compass noise, rad.
    pub noise_rad: f64,
    /// Deviation of the sea, rad/s^2, with a time constant of 3 s.
    pub sea_rad_s2: f64,
    /// Yaw acceleration without rudder, rad/s^2.
    pub offset_rad_s2: f64,
    /// Two thrusters in place of the rudder.
    pub thrusters: Option<Thrusters>,
    /// Rudder angle to each side without effect, rad.
    pub dead_band_rad: f64,
    /// Rudder angle d at which a stalling rudder has tanh(1) of the effect it would have, rad: d tanh(delta/d); 0 is none.
    pub stall_rad: f64,
}

/// Two thrusters that steer and drive at once; the record has half the difference of what each was asked for.
#[derive(Clone, Copy, Debug)]
pub struct Thrusters {
    /// Strength of the port and the starboard one, shares of the usual.
    pub strength: [f64; 2],
    /// Strength of one that runs in reverse, a share of ahead.
    pub reverse: f64,
    /// What both are asked for to drive, a share of full.
    pub ahead: f64,
    /// Exponent of the force over what is asked for: 1 of a force, 2 of turns per second.
    pub exponent: f64,
}

impl Thrusters {
    /// The rudder angle, rad, at which half the difference of what is asked for is full.
    const FULL_RAD: f64 = 0.6;

    /// The rudder angle that turns as they do, rad.
    fn effect_rad(&self, rudder_rad: f64) -> f64 {
        let share = rudder_rad / Self::FULL_RAD;
        let force = |asked: f64| {
            let force = asked.abs().min(1.0).powf(self.exponent);
            if asked < 0.0 { -self.reverse * force } else { force }
        };
        let [port, starboard] = self.strength;
        let moment = port * force(self.ahead + share) - starboard * force(self.ahead - share);
        0.5 * Self::FULL_RAD * moment
    }
}

/// Where a simulation stands.
#[derive(Clone, Debug, Default)]
struct State {
    heading_rad: f64,
    rate_rad_s: f64,
    sway: f64,
    speed_lost: f64,
    lagging_rad: f64,
    rudder_rad: f64,
    asked: std::collections::VecDeque<f64>,
}

const STEP_S: f64 = 0.002;

impl Hull {
    fn advance(&self, x: &mut State, command_rad: f64, sea_rad_s2: f64) {
        let [dead_s, lag_s, rate_limit, play_rad] = self.gear;
        x.asked.push_back(command_rad);
        let asked_rad = match x.asked.len() as f64 > dead_s / STEP_S {
            true => x.asked.pop_front().unwrap_or(command_rad),
            false => x.lagging_rad,
        };
        let mut step = match lag_s > 0.0 {
            true => (asked_rad - x.lagging_rad) * -(-STEP_S / lag_s).exp_m1(),
            false => asked_rad - x.lagging_rad,
        };
        if rate_limit > 0.0 {
            step = step.clamp(-rate_limit * STEP_S, rate_limit * STEP_S);
        }
        x.lagging_rad += step;
        let half = 0.5 * play_rad;
        x.rudder_rad = x.rudder_rad.clamp(x.lagging_rad - half, x.lagging_rad + half);
        let u = 1.0 - x.speed_lost;
        let [linear, quadratic] = self.damping;
        let r = x.rate_rad_s;
        let effect_rad = match &self.thrusters {
            Some(thrusters) => thrusters.effect_rad(x.rudder_rad),
            None => {
                let beyond_rad = (x.rudder_rad.abs() - self.dead_band_rad).max(0.0);
                let effect_rad = match self.stall_rad > 0.0 {
                    true => self.stall_rad * (beyond_rad / self.stall_rad).tanh(),
                    false => beyond_rad,
                };
                effect_rad.copysign(x.rudder_rad)
            }
        };
        let push = u * u * self.authority_per_s2 * effect_rad + self.offset_rad_s2 + sea_rad_s2;
        let [coupling, sway_s] = self.sway;
        x.rate_rad_s +=
            STEP_S * (push - u * linear * r - quadratic * r * r.abs() + coupling * x.sway);
        if sway_s > 0.0 {
            x.sway += STEP_S * (r - x.sway / sway_s);
        }
        let [loss_s, speed_s] = self.speed_loss;
        if speed_s > 0.0 {
            x.speed_lost += STEP_S / speed_s * ((loss_s * r.abs()).min(0.7) - x.speed_lost);
        }
        x.heading_rad += STEP_S * 0.5 * (r + x.rate_rad_s);
    }

    /// Steady yaw rates to starboard and to port at this rudder angle over the speed, of which it is 1 at first, rad/s.
    fn steady_rad_s(&self, rudder_rad: f64, length_s: f64) -> [f64; 2] {
        let to = |sign: f64| {
            let mut x = State::default();
            for _ in 0..(length_s / STEP_S) as usize {
                self.advance(&mut x, sign * rudder_rad, 0.0);
            }
            x.rate_rad_s / (1.0 - x.speed_lost)
        };
        [to(1.0), to(-1.0)]
    }

    /// Overshoot of a course change of 40 deg and how far it swings in the end, shares of it, under a gain and a largest rudder.
    fn step(&self, gain: f64, largest_rad: f64, interval_s: f64, length_s: f64) -> [f64; 2] {
        // What is left of it is trim, not the gain.
        let hull = Self {
            offset_rad_s2: self
                .thrusters
                .map_or(0.0, |thrusters| -self.authority_per_s2 * thrusters.effect_rad(0.0)),
            ..*self
        };
        let mut x = State::default();
        let (mut most, mut lowest, mut highest) = (0.0_f64, f64::INFINITY, f64::NEG_INFINITY);
        let (parts, steps) = ((interval_s / STEP_S) as usize, (length_s / interval_s) as usize);
        for k in 0..steps {
            let command =
                (gain * (COURSE_CHANGE_RAD - x.heading_rad)).clamp(-largest_rad, largest_rad);
            for _ in 0..parts {
                hull.advance(&mut x, command, 0.0);
            }
            most = most.max(x.heading_rad - COURSE_CHANGE_RAD);
            if 4 * k > 3 * steps {
                lowest = lowest.min(x.heading_rad);
                highest = highest.max(x.heading_rad);
            }
        }
        [most / COURSE_CHANGE_RAD, (highest - lowest) / COURSE_CHANGE_RAD]
    }
}

/// A kind of vehicle, and one of it.
type Kind = (&'static str, fn(&mut Pcg64) -> (Hull, f64));

/// Of a random generator: uniform between two ends.
fn between(random: &mut Pcg64, low: f64, high: f64) -> f64 {
    low + (high - low) * (random.next_u64() as f64 / u64::MAX as f64)
}

/// A vehicle of first order, and its time constant.
fn plain(random: &mut Pcg64) -> (Hull, f64) {
    let time_s = between(random, 0.6, 3.0);
    let hull = Hull {
        damping: [1.0 / time_s, 0.0],
        authority_per_s2: between(random, 0.6, 1.6) / time_s,
        noise_rad: between(random, 0.1, 0.4f64).to_radians(),
        offset_rad_s2: between(random, -0.03, 0.03) / time_s,
        ..Hull::default()
    };
    (hull, time_s)
}

fn rov(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = plain(random);
    hull.damping = [between(random, 0.05, 0.3) / time_s, between(random, 1.5, 6.0)];
    (hull, time_s)
}

fn stable_ship(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = plain(random);
    let sway_s = time_s * between(random, 1.0, 4.0);
    // The part of the damping that sway takes in the long run.
    let taken = between(random, 0.2, 0.7);
    hull.sway = [taken / (time_s * sway_s), sway_s];
    // T1 + T2 - T3
    let nomoto_s = (sway_s + time_s) / (1.0 - taken) - sway_s;
    (hull, nomoto_s)
}

fn unstable_ship(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = plain(random);
    let sway_s = time_s * between(random, 1.0, 4.0);
    hull.sway = [between(random, 1.05, 1.5) / (time_s * sway_s), sway_s];
    hull.damping[1] = between(random, 0.5, 2.0);
    (hull, time_s)
}

fn slow_gear(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = plain(random);
    hull.gear[2] = 0.26 / (between(random, 0.3, 1.2) * time_s);
    (hull, time_s)
}

fn loose_gear(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = plain(random);
    hull.gear[3] = between(random, 0.03, 0.12);
    (hull, time_s)
}

fn late_gear(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = plain(random);
    hull.gear[0] = between(random, 0.05, 0.4) * time_s;
    (hull, time_s)
}

fn lagging_gear(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = plain(random);
    hull.gear[1] = between(random, 0.0, 0.3);
    (hull, time_s)
}

fn slowing(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = plain(random);
    hull.speed_loss = [between(random, 0.3, 1.0), between(random, 1.0, 4.0) * time_s];
    (hull, time_s)
}

fn in_a_sea(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = plain(random);
    hull.sea_rad_s2 = between(random, 0.005, 0.02);
    (hull, time_s)
}

fn lagging_in_a_sea(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = plain(random);
    hull.gear[1] = between(random, 0.1, 0.2);
    hull.sea_rad_s2 = between(random, 0.01, 0.02);
    hull.noise_rad = between(random, 0.01, 0.1f64).to_radians();
    (hull, time_s)
}

fn two_thrusters(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = plain(random);
    hull.offset_rad_s2 = 0.0;
    hull.gear[1] = between(random, 0.0, 0.2);
    hull.thrusters = Some(Thrusters {
        strength: [1.0, between(random, 0.6, 1.0)],
        reverse: between(random, 0.5, 1.0),
        ahead: between(random, 0.1, 0.6),
        exponent: between(random, 1.0, 2.0),
    });
    (hull, time_s)
}

fn dead_band(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = plain(random);
    hull.dead_band_rad = between(random, 0.01, 0.06);
    (hull, time_s)
}

fn stalling_rudder(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = plain(random);
    hull.stall_rad = between(random, 0.15, 0.4);
    (hull, time_s)
}

fn thruster_rov(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = rov(random);
    hull.gear[1] = between(random, 0.05, 0.25);
    hull.dead_band_rad = between(random, 0.0, 0.03);
    hull.sea_rad_s2 = between(random, 0.0, 0.01);
    (hull, time_s)
}

fn sea_of(random: &mut Pcg64) -> f64 {
    between(random, 0.003, 0.012)
}

fn quadratic_in_a_sea(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = rov(random);
    hull.sea_rad_s2 = sea_of(random);
    (hull, time_s)
}

fn sway_in_a_sea(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = stable_ship(random);
    hull.sea_rad_s2 = sea_of(random);
    (hull, time_s)
}

fn sway_behind_a_lag(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = stable_ship(random);
    hull.gear[1] = between(random, 0.1, 0.3);
    (hull, time_s)
}

fn quadratic_behind_a_lag(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = rov(random);
    hull.gear[1] = between(random, 0.1, 0.3);
    (hull, time_s)
}

fn slow_gear_in_a_sea(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = slow_gear(random);
    hull.sea_rad_s2 = sea_of(random);
    (hull, time_s)
}

fn play_in_a_sea(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = loose_gear(random);
    hull.sea_rad_s2 = sea_of(random);
    (hull, time_s)
}

fn quadratic_slow_gear(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = rov(random);
    hull.gear[2] = 0.26 / (between(random, 0.3, 1.2) * time_s);
    (hull, time_s)
}

fn sway_with_play(random: &mut Pcg64) -> (Hull, f64) {
    let (mut hull, time_s) = stable_ship(random);
    hull.gear[3] = between(random, 0.03, 0.12);
    (hull, time_s)
}

const KINDS: [Kind; 23] = [
    ("dead band", dead_band),
    ("stalling rudder", stalling_rudder),
    ("ROV with thrusters", thruster_rov),
    ("quadratic in a sea", quadratic_in_a_sea),
    ("sway in a sea", sway_in_a_sea),
    ("sway behind a lag", sway_behind_a_lag),
    ("quadratic behind a lag", quadratic_behind_a_lag),
    ("slow gear in a sea", slow_gear_in_a_sea),
    ("play in a sea", play_in_a_sea),
    ("quadratic behind a slow gear", quadratic_slow_gear),
    ("sway with play", sway_with_play),
    ("two thrusters", two_thrusters),
    ("first order", plain),
    ("in a sea", in_a_sea),
    ("lag to 0.3 s", lagging_gear),
    ("delay", late_gear),
    ("rate limit", slow_gear),
    ("play", loose_gear),
    ("speed loss", slowing),
    ("quadratic damping", rov),
    ("stable sway", stable_ship),
    ("unstable sway", unstable_ship),
    ("lag in a sea", lagging_in_a_sea),
];

const AMPLITUDE_RAD: f64 = 0.26;
const INTERVAL_S: f64 = 0.05;
/// The smallest overshoot that the promise tells from none, 1 deg.
const LEAST_OVERSHOOT_RAD: f64 = 0.01745;

/// Doublets to starboard and port first, each with calm water before and after, and the window of each.
pub fn record(hull: &Hull, time_s: f64, random: &mut Pcg64) -> (Record, [Window; 2]) {
    let (calm_s, half_s) = (2.0, (2.0 * time_s).max(1.0));
    let rest_s = 3.0 * time_s;
    let stage_s = calm_s + 2.0 * half_s + rest_s;
    let command = |at_s: f64| {
        let stage = (at_s / stage_s).floor();
        let in_s = at_s - stage * stage_s - calm_s;
        // The validation as the paper's: 8.6 deg for 15, and to the other side.
        let sign = if stage < 1.0 { 1.0 } else { -0.57 };
        match in_s {
            s if s < 0.0 || s >= 2.0 * half_s => 0.0,
            s if s < half_s => sign * AMPLITUDE_RAD,
            _ => -sign * AMPLITUDE_RAD,
        }
    };
    let mut normal = || -> f64 { StandardNormal.sample(random) };
    let mut x = State::default();
    let mut sea = hull.sea_rad_s2 * normal();
    let kept = (-STEP_S / 3.0_f64).exp();
    let mut samples = Vec::new();
    let parts = (INTERVAL_S / STEP_S) as usize;
    for k in 0..(2.0 * stage_s / INTERVAL_S) as usize {
        let at_s = k as f64 * INTERVAL_S;
        samples.push(Sample {
            time_s: at_s,
            heading_rad: x.heading_rad + hull.noise_rad * normal(),
            rudder_rad: command(at_s),
            ..Sample::default()
        });
        for _ in 0..parts {
            sea = kept * sea + hull.sea_rad_s2 * (1.0 - kept * kept).sqrt() * normal();
            hull.advance(&mut x, command(at_s), sea);
        }
    }
    let window = |from_s: f64| Window { from_s, to_s: from_s + stage_s };
    (samples.into_iter().collect(), [window(0.0), window(stage_s)])
}

/// Steady yaw rates to starboard and to port at the manoeuvre's rudder, rad/s, each with its 95 % interval, as `seatrial turn` takes them.
/// `None` where the hypotheses leave the turn open.
fn steady_95(found: &Identification) -> Option<[(f64, [f64; 2]); 2]> {
    let refined = found.refined.as_ref()?;
    let (mut model, mut covariance) = (refined.model, refined.covariance);
    if let Some(turn) = found.steady_turn() {
        let log_gain = turn.log_gain_at(AMPLITUDE_RAD);
        (model, covariance) = with_steady_gain(&model, &covariance, log_gain)?;
    }
    let side = |sign: f64| {
        let rate = |model: &YawModel<f64>| {
            let acceleration = sign * model.b2_per_s2 * AMPLITUDE_RAD + model.c0_rad_per_s2;
            Some(-acceleration / model.a22_per_s)
        };
        Some((rate(&model)?, interval_95(&model, &covariance, rate)?))
    };
    Some([side(1.0)?, side(-1.0)?])
}

#[derive(Default)]
struct Tally {
    accepted: usize,
    inside: usize,
    overshooting: usize,
    /// Of those promised, how many overshoot as promised.
    promised: [usize; 2],
    errors: Vec<f64>,
    said: BTreeMap<String, usize>,
}

fn main() {
    let arguments: Vec<u64> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let [seed, count] = arguments[..] else {
        eprintln!("usage: hulls SEED COUNT [with the name of one kind in HULL]");
        std::process::exit(2);
    };
    let only = std::env::var("HULL").unwrap_or_default();
    println!(
        "kind: accepted, steady rate inside of those told, overshooting (of {count}), overshoot inside of those promised; median error of the rate"
    );
    for (name, draw) in KINDS.iter().filter(|(name, _)| name.contains(&only)) {
        let mut tally = Tally::default();
        for k in 0..count {
            let mut random = Pcg64::seed_from_u64(seed * 1000 + k);
            let (hull, time_s) = draw(&mut random);
            tally.add(&hull, time_s, &mut random);
        }
        tally.errors.sort_by(f64::total_cmp);
        let median = tally.errors.get(tally.errors.len() / 2).copied().unwrap_or(f64::NAN);
        println!(
            "{name}: {}, {} of {}, {}, {} of {}; {:.1} %  {:?}",
            tally.accepted,
            tally.inside,
            tally.errors.len(),
            tally.overshooting,
            tally.promised[1],
            tally.promised[0],
            100.0 * median,
            tally.said
        );
    }
}

impl Tally {
    fn add(&mut self, hull: &Hull, time_s: f64, random: &mut Pcg64) {
        let (record, [training, window]) = record(hull, time_s, random);
        let data = ValidationData { record: &record, window };
        let Ok(found) = identify(&record, training, Some(data), &IdentifySettings::default())
        else {
            *self.said.entry("error".into()).or_default() += 1;
            return;
        };
        let truth = hull.steady_rad_s(AMPLITUDE_RAD, 30.0 * time_s);
        let verbose = std::env::var_os("VERBOSE").is_some();
        let is_accepted = found.verdict.accepted;
        for reason in &found.verdict.reasons {
            let mark = if is_accepted { "" } else { "!" };
            *self.said.entry(format!("{mark}{}", reason.kind())).or_default() += 1;
        }
        let gain =
            GainAllowance::of(&found).design(&found.model(), core::f64::consts::FRAC_1_SQRT_2);
        let [over, swing] = gain.as_ref().map_or([0.0; 2], |gain| {
            hull.step(gain.proportional_gain, AMPLITUDE_RAD, INTERVAL_S, 60.0 * time_s)
        });
        let steady = steady_95(&found);
        if verbose {
            println!(
                "R2 {:.3?} beyond {:.3?} {} {:?} {:?} truth {truth:.4?} found {steady:.4?} over {over:.2} of {:.2?} swing {swing:.2} {:?}",
                found.validation.and_then(|v| v.r2_heading_offset_refit),
                found.higher_order.as_ref().and_then(|h| h.validation?.r2_heading_offset_refit),
                if is_accepted { "use" } else { "no" },
                found.model().theta().map(|x| (1e3 * x).round() / 1e3),
                found.higher_order.as_ref().map(|h| h.structure.in_words()),
                CourseChange::of(&found, Some(AMPLITUDE_RAD))
                    .map(|promise| promise.overshoot_95_rad.map(|rad| rad / COURSE_CHANGE_RAD)),
                found.verdict.reasons.iter().map(|r| r.kind().to_string()).collect::<Vec<_>>()
            );
        }
        if !is_accepted {
            return;
        }
        self.accepted += 1;
        self.overshooting += usize::from(over > 0.25 || swing > 0.1);
        if let Some(promise) = CourseChange::of(&found, Some(AMPLITUDE_RAD)) {
            let [low, high] = promise.overshoot_95_rad;
            let over_rad = over * COURSE_CHANGE_RAD;
            // An overshoot of less than a degree is none, and is said so.
            let is_inside = (low..=high.max(LEAST_OVERSHOOT_RAD)).contains(&over_rad);
            self.promised[0] += 1;
            self.promised[1] += usize::from(is_inside);
        }
        for ((rate, [low, high]), truth) in steady.into_iter().flatten().zip(truth) {
            self.inside += usize::from((low..=high).contains(&truth));
            self.errors.push((rate / truth - 1.0).abs());
        }
    }
}
