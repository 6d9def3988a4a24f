//! Autopilots that speak MAVLink: the options of the link, preflight, taking one, handing it back.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{SystemTime, UNIX_EPOCH};

use seatrial::FullRudder;
use seatrial::preview::Prior;
use seatrial_app::trial_run::{self, TakenVehicle, Terms, TrialVehicle, VehicleError, taken};
use seatrial_core::{Plan, RudderSense};
use seatrial_links::autopilot::{
    Autopilot, Backup, HandBack, Profile, Response, Settings, SteeringOutputs, Tended,
};
use seatrial_links::handover::{Change, Check, Preflight};
use seatrial_links::link::{Address, Key, Signing, Transport};

use crate::output::{Failure, say};
use crate::screen::{labelled, width};

/// How an autopilot is reached.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "An autopilot behind MAVLink")]
pub struct LinkArgs {
    /// Our system id; the autopilot's MAV_GCS_SYSID must be the same.
    #[arg(long, value_name = "ID", default_value_t = 255)]
    system_id: u8,
    /// System id of the vehicle [default: the first autopilot that is heard].
    #[arg(long, value_name = "ID")]
    vehicle_id: Option<u8>,
    /// Kind of autopilot [default: as it says].
    #[arg(long, value_name = "KIND", value_parser = parse_profile)]
    profile: Option<Profile>,
    /// Rudder angle at full steering, degrees; assumed to be 35 where it is not given. Parameters that are exported for the
    /// autopilot do not depend on it; angles, b2 and gains in rad do.
    #[arg(long, value_name = "DEG")]
    full_rudder_deg: Option<f64>,
    /// Outputs that steer, as in 1 or 1,-2 where the second turns against the first [default: as the parameters say].
    #[arg(
        long,
        value_name = "OUTPUTS",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    steering_outputs: Vec<i8>,
    /// Shortest, neutral and longest pulse of the steering outputs, us.
    #[arg(long, value_name = "US", value_delimiter = ',', default_values_t = [1100.0, 1500.0, 1900.0])]
    pulses_us: Vec<f64>,
    /// There is no remote control: a change of mode from a ground station takes the vehicle over.
    #[arg(long)]
    without_rc: bool,
    /// Lowest charge of the battery, percent.
    #[arg(long, value_name = "PERCENT", default_value_t = 20)]
    lowest_battery: i8,
    /// Rudder per heading error while a heading is held.
    #[arg(long, value_name = "GAIN", default_value_t = 0.4)]
    heading_gain: f64,
    /// A key of 32 bytes or 64 hexadecimal digits: every frame is signed, and none without a signature is taken.
    #[arg(long, value_name = "FILE")]
    signing_key: Option<PathBuf>,
}

/// A kind of autopilot by its name.
pub fn parse_profile(text: &str) -> Result<Profile, String> {
    match text {
        "rover" => Ok(Profile::Rover),
        "sub" => Ok(Profile::Sub),
        "px4" => Ok(Profile::Px4),
        "generic" => Ok(Profile::Generic),
        _ => Err("expected rover, sub, px4 or generic".into()),
    }
}

/// Signing with the key of a file.
pub fn signing(path: Option<&Path>, link_id: u8) -> Result<Option<Signing>, Failure> {
    let Some(path) = path else {
        return Ok(None);
    };
    let key = Key::load(path).map_err(Failure::input)?;
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    let now_s = now.map_err(Failure::internal)?.as_secs_f64();
    Ok(Some(Signing::new(key, link_id, now_s)))
}

/// The rudder at full steering where nobody says another, degrees.
const ASSUMED_FULL_RUDDER_DEG: f64 = 35.0;

impl LinkArgs {
    /// The rudder at full steering.
    pub fn full_rudder(&self) -> Result<FullRudder, Failure> {
        let degrees = self.full_rudder_deg.unwrap_or(ASSUMED_FULL_RUDDER_DEG);
        Ok(FullRudder {
            angle_rad: number("--full-rudder-deg", degrees, 90.0)?.to_radians(),
            is_assumed: self.full_rudder_deg.is_none(),
        })
    }

    fn address(address: &str) -> Result<Address, Failure> {
        address
            .parse()
            .map_err(|error| Failure::usage(format!("--vehicle mavlink:{error}")))
    }

    /// The link to an address, with the settings of a plan where there is one.
    pub fn open(
        &self,
        address: &str,
        plan: Option<&Plan<f64>>,
        is_given: bool,
        abort: &Arc<AtomicBool>,
    ) -> Result<Autopilot<Transport>, Failure> {
        let address = Self::address(address)?;
        let full_rudder = self.full_rudder()?;
        let defaults = Settings::default();
        let settings = Settings {
            system_id: self.system_id,
            vehicle: self.vehicle_id,
            profile: self.profile,
            full_rudder_rad: full_rudder.angle_rad,
            is_full_rudder_assumed: full_rudder.is_assumed,
            outputs: self.outputs()?,
            sample_interval_s: plan.map_or(defaults.sample_interval_s, |p| p.sample_interval_s),
            lowest_battery_percent: self.lowest_battery,
            without_remote_control: self.without_rc,
            heading_gain: number("--heading-gain", self.heading_gain, 10.0)?,
            heading_rudder_rad: plan
                .map_or(defaults.heading_rudder_rad, |p| 0.8 * p.rudder_limit_rad),
            trying_thrust: plan
                .and_then(|plan| plan.thrusts.first().copied())
                .unwrap_or(defaults.trying_thrust),
            most_asked: plan.map_or(defaults.most_asked, |plan| {
                let highest = plan.thrusts.iter().copied().fold(0.0, f64::max);
                highest + plan.rudder_limit_rad / full_rudder.angle_rad
            }),
            is_reversed: plan
                .is_some_and(|plan| plan.envelope.rudder_sense == RudderSense::Negative),
            envelope: plan.filter(|_| is_given).map(limits),
            abort: Arc::clone(abort),
            ..defaults
        };
        if let Some(plan) = plan
            && plan.rudder_limit_rad > settings.full_rudder_rad
        {
            return Err(Failure::usage(format!(
                "the plan's rudder_limit_rad is {:.1} degrees, more than the {:.1} degrees of --full-rudder-deg",
                plan.rudder_limit_rad.to_degrees(),
                full_rudder.angle_rad.to_degrees()
            )));
        }
        let wire = Transport::open(&address)
            .map_err(|error| Failure::input(format!("mavlink:{address}: {error}")))?;
        let signing = signing(self.signing_key.as_deref(), 0)?;
        Ok(Autopilot::new(wire, settings, signing))
    }

    fn outputs(&self) -> Result<Option<SteeringOutputs>, Failure> {
        if self.steering_outputs.is_empty() {
            return Ok(None);
        }
        let is_output = |output: &i8| (1..=16).contains(&output.unsigned_abs());
        if !self.steering_outputs.iter().all(is_output) {
            return Err(Failure::usage(
                "--steering-outputs: expected outputs from 1 to 16, negative where one turns the other way",
            ));
        }
        let pulses_us = match self.pulses_us[..] {
            [low, trim, high] if 0.0 < low && low < trim && trim < high => [low, trim, high],
            _ => {
                return Err(Failure::usage(
                    "--pulses-us: expected three rising numbers, as in 1100,1500,1900",
                ));
            }
        };
        Ok(Some(SteeringOutputs {
            outputs: self.steering_outputs.clone(),
            pulses_us,
        }))
    }
}

/// The address of a vehicle behind MAVLink.
pub fn address(vehicle: &str) -> Result<&str, Failure> {
    vehicle.strip_prefix("mavlink:").ok_or_else(|| {
        Failure::usage(format!(
            "--vehicle {vehicle}: expected mavlink:udp:HOST:PORT, mavlink:udpout:HOST:PORT, mavlink:tcp:HOST:PORT or mavlink:serial:DEVICE:BAUD"
        ))
    })
}

/// A setting that must be positive and below a limit.
fn number(name: &str, value: f64, limit: f64) -> Result<f64, Failure> {
    if value > 0.0 && value < limit {
        return Ok(value);
    }
    Err(Failure::usage(format!(
        "{name} {value}: expected a number above 0 and below {limit}"
    )))
}

/// An autopilot behind MAVLink that trials may be run on, and whose gains may be tried.
#[derive(Clone)]
pub struct OnMavlink {
    pub(crate) name: String,
    pub(crate) address: String,
    pub(crate) link: LinkArgs,
    /// What a trial changes is kept here until it is put back.
    backup: PathBuf,
    pub(crate) logbook: PathBuf,
}

impl OnMavlink {
    /// The autopilot at an address.
    pub fn new(
        name: &str,
        address: &str,
        link: &LinkArgs,
        logbook: &Path,
    ) -> Result<Self, VehicleError> {
        LinkArgs::address(address)?;
        Ok(Self {
            name: name.into(),
            address: address.into(),
            link: link.clone(),
            backup: logbook.with_extension("restore.toml"),
            logbook: logbook.into(),
        })
    }

    /// Looks at the vehicle, asks, and takes it. Whatever fails, it is handed back.
    fn taken(&self, terms: &Terms) -> Result<Tended<Transport>, Failure> {
        let backup = &self.backup;
        if backup.exists() {
            return Err(Failure::aborted(format!(
                "{}: a trial before has not put everything back; run `seatrial vehicle restore {} --vehicle {}`",
                backup.display(),
                backup.display(),
                self.name
            )));
        }
        let opened = self.link.open(
            &self.address,
            Some(terms.plan),
            terms.plan_is_given,
            terms.stop,
        );
        // The link stays alive while we think, ask and judge.
        let mut autopilot = Tended::new(opened?);
        let preflight = autopilot.autopilot().inspect();
        text(&preflight).lines().for_each(say);
        refuse(&preflight.checks)?;
        if !terms.is_agreed && !agrees()? {
            return Err(Failure::aborted("not agreed to; nothing was changed"));
        }
        let checks = autopilot
            .autopilot()
            .take_control(&preflight.changes, &mut |stored| keep(backup, stored));
        checks.iter().map(line).for_each(say);
        if let Err(failure) = refuse(&checks) {
            hand_back(&mut autopilot, backup, &self.name)
                .iter()
                .for_each(say);
            return Err(failure);
        }
        Ok(autopilot)
    }
}

impl TrialVehicle for OnMavlink {
    fn name(&self) -> &str {
        &self.name
    }

    fn description(&self) -> &str {
        "an autopilot that speaks MAVLink: it moves"
    }

    fn is_simulated(&self) -> bool {
        false
    }

    fn full_rudder(&self) -> Option<FullRudder> {
        self.link.full_rudder().ok()
    }

    fn prior(&self, _: &Plan<f64>) -> Result<Prior, VehicleError> {
        Err(no_prior(&self.name))
    }

    fn inspect(&self, plan: &Plan<f64>) -> Result<trial_run::Preflight, VehicleError> {
        let opened = self
            .link
            .open(&self.address, Some(plan), true, &Arc::default());
        Ok(for_trial(opened?.inspect()))
    }

    fn take(&self, terms: &Terms) -> Result<Box<dyn TakenVehicle>, VehicleError> {
        let (backup, name) = (self.backup.clone(), self.name.clone());
        let hand_back = move |autopilot: &mut _| hand_back(autopilot, &backup, &name);
        let autopilot = self.taken(terms)?;
        let firmware = autopilot.autopilot().firmware();
        Ok(taken(autopilot, hand_back, None, Some(firmware)))
    }
}

/// A vehicle whose model nobody knows yet.
pub fn no_prior(name: &str) -> VehicleError {
    VehicleError::setting(format!(
        "{name}: how it steers is not known before its trial; preview the plan on a simulator"
    ))
}

/// A preflight as a trial's order asks for it.
pub fn for_trial(found: Preflight) -> trial_run::Preflight {
    let checks = found.checks.into_iter();
    let changes = found.changes.into_iter();
    trial_run::Preflight {
        checks: checks
            .map(|check| trial_run::Check::new(check.name, check.passed, check.text))
            .collect(),
        changes: changes.map(trial_change).collect(),
    }
}

/// A change of a parameter as a trial's order asks for it.
pub fn trial_change(change: Change) -> trial_run::Change {
    trial_run::Change {
        name: change.name,
        from: change.from,
        to: change.to,
        why: change.why.into(),
    }
}

/// Hands an autopilot back; what could not be put back.
fn hand_back(autopilot: &mut Tended<Transport>, backup: &Path, vehicle: &str) -> Option<String> {
    let (done, response) = {
        let mut autopilot = autopilot.autopilot();
        (autopilot.hand_back(), autopilot.response().clone())
    };
    say(hand_back_text(&done));
    say_response(&response);
    left_over(&done, backup, vehicle)
}

/// What a hand-back has left, the backup being there only while something can be restored from it.
pub fn left_over(done: &HandBack, backup: &Path, vehicle: &str) -> Option<String> {
    if done.needs_restoring() {
        return Some(format!(
            "not everything was put back; run `seatrial vehicle restore {} --vehicle {vehicle}`",
            backup.display()
        ));
    }
    let removed = match std::fs::remove_file(backup) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Some(format!("{}: {error}", backup.display()))
        }
        _ => None,
    };
    let neutral = "the outputs were not seen neutral: look at the vehicle";
    removed.or((!done.is_complete()).then(|| neutral.into()))
}

fn say_response(response: &Response) {
    if let Some(most_s) = response.quantile_s(0.999) {
        say(format!(
            "{} commands, 99.9 % of them within {:.2} ms of their sample, the longest {:.2} ms",
            response.count(),
            1e3 * most_s,
            1e3 * response.longest_s()
        ));
    }
}

/// Writes a backup so that it survives a crash of this machine.
pub fn keep(path: &Path, backup: &Backup) -> std::io::Result<()> {
    let text = toml::to_string_pretty(backup).map_err(std::io::Error::other)?;
    let mut file = std::fs::File::create_new(path)
        .map_err(|error| std::io::Error::other(format!("{}: {error}", path.display())))?;
    file.write_all(text.as_bytes())?;
    file.sync_all()
}

/// Fails where a check has not passed.
pub fn refuse(checks: &[Check]) -> Result<(), Failure> {
    let refused: Vec<&str> = checks
        .iter()
        .filter(|check| !check.passed)
        .map(|check| check.name)
        .collect();
    if refused.is_empty() {
        return Ok(());
    }
    Err(Failure::aborted(format!(
        "the trial is refused for: {}",
        refused.join(", ")
    )))
}

pub fn agrees() -> Result<bool, Failure> {
    if !std::io::stdin().is_terminal() {
        return Err(Failure::aborted(
            "a vehicle that moves must be agreed to: say --yes",
        ));
    }
    let mut stderr = std::io::stderr();
    let _ = write!(
        stderr,
        "Take this vehicle, change what is listed and move it? [y/N] "
    );
    let mut answer = String::new();
    let read = std::io::stdin().read_line(&mut answer);
    read.map_err(Failure::internal)?;
    Ok(["y", "yes"].contains(&answer.trim().to_lowercase().as_str()))
}

/// The limits of a plan for people.
pub fn limits(plan: &Plan<f64>) -> String {
    let envelope = &plan.envelope;
    let area = match envelope.area.len() {
        0 => "no area".into(),
        corners => format!("an area of {corners} corners"),
    };
    format!(
        "heading within {:.0} degrees, yaw rate up to {:.0} degrees/s, depth {} to {} m, {area}",
        envelope.heading_excursion_max_rad.to_degrees(),
        envelope.yaw_rate_max_rad_s.to_degrees(),
        envelope.depth_min_m,
        envelope.depth_max_m
    )
}

/// A check for people.
pub fn line(check: &Check) -> String {
    check_line(check.passed, check.name, &check.text)
}

/// A check for people, by its parts.
pub fn check_line(is_passed: bool, name: &str, text: &str) -> String {
    let mark = if is_passed { "ok      " } else { "REFUSED " };
    labelled(&format!("{mark}{name:15} "), text, width())
        .trim_end()
        .to_owned()
}

/// A change until the hand-back, for people.
fn change_line(change: &Change) -> String {
    let text = format!(
        "{} -> {} until the hand-back: {}",
        change.from, change.to, change.why
    );
    labelled(&format!("change  {:15} ", change.name), &text, width())
        .trim_end()
        .to_owned()
}

/// A preflight for people, what it came to and what to do first.
pub fn text(preflight: &Preflight) -> String {
    let mut lines: Vec<String> = preflight.checks.iter().map(line).collect();
    lines.extend(preflight.changes.iter().map(change_line));
    lines.join("\n")
}

/// A hand-back for people.
pub fn hand_back_text(done: &HandBack) -> String {
    let known = |name: &str, known: Option<bool>, yes: &str, no: &str| match known {
        Some(true) => format!("{name} {yes}"),
        Some(false) => format!("{name} {no}"),
        None => format!("{name} left to whoever has it"),
    };
    let mut parts = vec![
        known("rudder", done.rudder_neutral, "neutral", "NOT SEEN NEUTRAL"),
        known(
            "throttle",
            done.throttle_neutral,
            "neutral",
            "NOT SEEN NEUTRAL",
        ),
        known("mode", done.mode_restored, "restored", "NOT RESTORED"),
    ];
    if !done.restored.is_empty() {
        parts.push(format!("restored {}", done.restored.join(", ")));
    }
    if !done.not_restored.is_empty() {
        parts.push(format!("NOT RESTORED {}", done.not_restored.join(", ")));
    }
    format!("handed back: {}", parts.join("; "))
}
