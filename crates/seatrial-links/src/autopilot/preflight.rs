//! Before the vehicle is taken: what must be so, what is changed.

use super::profile::Rudder;
use super::{Autopilot, Profile, health};
use crate::handover::{CONNECT_S, Controls, Preflight};
use crate::link::{Sender, Wire};

/// Every autopilot says once a second that it is there.
const OTHERS_S: f64 = 1.2;

impl<W: Wire> Autopilot<W> {
    /// Looks at the vehicle without touching its controls. It is asked for messages more often.
    pub fn inspect(&mut self) -> Preflight {
        let mut found = Preflight::begin();
        let is_there = self.wait(CONNECT_S, |autopilot| autopilot.heard.heartbeat.is_some());
        let damage = self.damage();
        if !is_there {
            let refused = match damage.refused_frames {
                0 => String::new(),
                count => format!("; {count} frames were refused for their signature"),
            };
            found.check(
                "heartbeat",
                false,
                format!("no autopilot was heard for {CONNECT_S} s{refused}: check the address, the cable and the key"),
            );
            return found;
        }
        // Whoever else is there is heard before anybody is asked for anything.
        self.wait(OTHERS_S, |_| false);
        found.vehicle = format!("{}, system {}", self.profile().name(), self.system());
        found.check("heartbeat", true, found.vehicle.clone());
        if let Some(text) = self.unclear_vehicle() {
            found.check("one autopilot", false, text);
            return found;
        }
        let missing = self.read_parameters();
        if !missing.is_empty() && self.damage().unchecked_frames > 0 {
            found.check(
                "signature",
                false,
                "it signs its frames and does not answer ours, which are not signed: give its key with --signing-key",
            );
            return found;
        }
        found.check(
            "parameters",
            missing.is_empty(),
            match missing.is_empty() {
                true => "read".into(),
                false => format!("no answer for {}", missing.join(", ")),
            },
        );
        self.find_rudder(&mut found);
        self.check_rates(&mut found);
        self.check_gain(&mut found);
        self.wait(CONNECT_S, |autopilot| autopilot.heard.heartbeats > 1);
        self.check_pilot(&mut found);
        health::check(&self.heard, self.profile(), &self.settings, &mut found);
        self.check_failsafes(&mut found);
        self.check_station(&mut found);
        self.check_takeover(&mut found);
        match &self.settings.envelope {
            Some(limits) => found.check("envelope", true, limits.clone()),
            None => found.check(
                "envelope",
                false,
                "no plan was given: its envelope must be this vehicle's (--plan FILE)",
            ),
        }
        found
    }

    fn find_rudder(&mut self, found: &mut Preflight) {
        let profile = self.profile();
        self.rudder = Rudder::find(profile, &self.parameters, self.settings.outputs.as_ref());
        match &self.rudder {
            Some(rudder) => found.check("rudder", true, rudder.text()),
            None => found.check(
                "rudder",
                false,
                format!(
                    "no output is known to steer ({}); say which with --steering-outputs",
                    self.parameters.functions()
                ),
            ),
        }
        found.check("full rudder", true, self.settings.full_rudder_text());
        if profile == Profile::Rover {
            let dead_us = self.parameters.get("RC1_DZ").unwrap_or(f64::NAN);
            let known = dead_us.is_finite();
            found.check(
                "dead zone",
                known,
                format!("RC1_DZ is {dead_us:.0} us; commands step over it"),
            );
        }
    }

    /// ArduSub makes less of a stick than its full, by a gain that the pilot's buttons change.
    fn check_gain(&mut self, found: &mut Preflight) {
        if self.profile() != Profile::Sub {
            return;
        }
        let reported = self.heard.pilot_gain.map(|gain| ("PilotGain", gain));
        let set = self.parameters.get("JS_GAIN_DEFAULT");
        let Some((name, gain)) = reported.or(set.map(|gain| ("JS_GAIN_DEFAULT", gain))) else {
            return;
        };
        let is_gain = gain > 0.0 && gain <= 1.0;
        if is_gain {
            self.stick_gain = gain;
        }
        let most_asked = self.settings.most_asked;
        // Each horizontal thruster does both.
        let fits = gain * most_asked <= 1.0 || self.settings.outputs.is_some();
        found.check(
            "stick gain",
            is_gain && fits,
            format!(
                "{name} is {gain:.2}: full steering and full thrust are that much of the thrusters'{}",
                match fits {
                    true => String::new(),
                    false => format!(
                        ", too much for the {most_asked:.2} that the plan asks for together: {:.2} would do",
                        1.0 / most_asked
                    ),
                }
            ),
        );
    }

    /// ArduSub without a remote control is in a failsafe whenever nobody steers it.
    fn check_pilot(&mut self, found: &mut Preflight) {
        let is_alone = self.profile() == Profile::Sub && !self.heard.has_sticks();
        let action = self.parameters.get("FS_PILOT_INPUT").filter(|_| is_alone);
        if action == Some(2.0) && !self.heard.is_armed() {
            let text = "FS_PILOT_INPUT is 2, which disarms it when nobody steers: 1 makes its controls neutral and leaves it armed";
            found.check("pilot", false, text);
        }
        let failsafe = self.heard.failsafe.clone();
        if failsafe.is_none() && self.heard.is_critical() && action == Some(1.0) {
            let text = "its state is critical, as FS_PILOT_INPUT makes it while nobody steers; it must be over when we do";
            found.check("state", true, text);
        } else if failsafe.is_some() || self.heard.is_critical() {
            let text = failsafe.unwrap_or("its state is critical".into());
            found.check("state", false, text);
        }
    }

    fn check_station(&mut self, found: &mut Preflight) {
        let ours = self.settings.system_id;
        if self.profile().is_ardupilot() {
            let obeyed = ["MAV_GCS_SYSID", "SYSID_MYGCS"]
                .iter()
                .find_map(|name| Some((name, self.parameters.get(name)?)));
            match obeyed {
                Some((name, id)) => found.check(
                    "system id",
                    id == f64::from(ours),
                    format!("{name} is {id}, ours is {ours}; commands of any other are ignored without a word"),
                ),
                None => found.check("system id", false, "neither MAV_GCS_SYSID nor SYSID_MYGCS is there"),
            }
        }
        found.check(
            "one station",
            self.heard.double.is_none(),
            match self.heard.double {
                Some(sender) => format!(
                    "{} has our system id {ours}: stop it, or give one of both another id",
                    station_name(sender)
                ),
                None => format!("nobody else has our system id {ours}"),
            },
        );
        let unclear = self.unclear_vehicle();
        let text = unclear.clone();
        let text = text.unwrap_or_else(|| format!("system {}", self.system()));
        found.check("one autopilot", unclear.is_none(), text);
    }

    /// Why it is not clear which autopilot is the vehicle, where several are heard. None of them is asked for anything then.
    fn unclear_vehicle(&self) -> Option<String> {
        let heard = &self.heard.autopilots;
        let namesakes: Vec<String> = heard
            .iter()
            .filter(|sender| sender.system == self.system())
            .map(|sender| sender.component.to_string())
            .collect();
        if namesakes.len() > 1 {
            return Some(format!(
                "components {} of system {} say that they are its autopilot, and one of them is not: find out which, or sign the link (--signing-key)",
                namesakes.join(" and "),
                self.system()
            ));
        }
        let systems: Vec<String> = heard.iter().map(|sender| sender.system.to_string()).collect();
        (systems.len() > 1 && self.settings.vehicle.is_none()).then(|| {
            format!(
                "autopilots of the systems {} are heard: say which is yours with --vehicle-id",
                systems.join(" and ")
            )
        })
    }

    fn check_takeover(&mut self, found: &mut Preflight) {
        let channels = self.heard.remote_control.map_or(0, |channels| channels.count);
        let (passed, text) = match (channels, self.settings.without_remote_control) {
            (_, true) => (true, "a change of mode from a ground station; no remote control".into()),
            (0, false) => (
                false,
                "no remote control is heard; if a change of mode from a ground station shall do, say --without-rc".into(),
            ),
            (count, false) => (
                true,
                format!("a change of mode, or any of {count} channels of the remote control that is not ours"),
            ),
        };
        found.check("takeover", passed, text);
    }
}

/// What a ground station is, as far as its component tells.
fn station_name(sender: Sender) -> String {
    // MAV_COMP_ID_MISSIONPLANNER, which QGroundControl has as well.
    let name = match sender.component {
        190 => "Mission Planner or QGroundControl",
        _ => "another ground station",
    };
    format!("{name} (component {})", sender.component)
}
