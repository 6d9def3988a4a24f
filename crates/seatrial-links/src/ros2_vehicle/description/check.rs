//! Is a description one that can be used?

use thiserror::Error;

use super::{Actuator, Description, FeedbackType, Middleware, Zenoh, is_absolute_name, loopback};

/// What is wrong with a description, and what was expected.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct InvalidDescription(String);

impl From<String> for InvalidDescription {
    fn from(text: String) -> Self {
        Self(text)
    }
}

impl From<&str> for InvalidDescription {
    fn from(text: &str) -> Self {
        Self(text.into())
    }
}

impl Description {
    /// Checks that the description can be used.
    pub fn check(&self) -> Result<(), InvalidDescription> {
        self.check_names()?;
        self.check_numbers()?;
        if let Some(zenoh) = &self.zenoh {
            self.check_zenoh(zenoh)?;
        }
        self.check_actuators()?;
        if self.odometry.is_none() && self.imu.is_none() {
            return Err("expected [odometry] or [imu]: the heading comes from one of them".into());
        }
        if let Some(feedback) = &self.feedback {
            let needs_joint = feedback.kind == FeedbackType::JointState;
            if needs_joint != feedback.joint.is_some() {
                return Err(
                    "feedback.joint: expected the name of a joint where its type is sensor_msgs/JointState, and only there"
                        .into(),
                );
            }
        }
        Ok(())
    }

    fn check_actuators(&self) -> Result<(), InvalidDescription> {
        let all = self.actuators();
        for (place, (name, actuator)) in all.iter().enumerate() {
            let (topic, kind, field) = (&actuator.topic, actuator.kind, actuator.field());
            if !is_absolute_name(topic) {
                return Err(no_name(&format!("{name}.topic"), topic));
            }
            if kind.index(field).is_none() {
                return Err(
                    format!("{name}.field is {field:?}: its type has {}", kind.expected()).into()
                );
            }
            for (before, other) in &all[..place] {
                if other.topic == *topic && (other.kind != kind || other.field() == field) {
                    return Err(format!(
                        "{before} and {name} are both on {topic}: expected the same type and different fields"
                    )
                    .into());
                }
            }
            for (key, value, low, high) in [
                ("units_per_rad", actuator.units_per_rad, -1e6, 1e6),
                ("neutral_units or trim_units", actuator.neutral_units, -1e9, 1e9),
                ("units_at_full", actuator.units_at_full.unwrap_or(0.0), -1e9, 1e9),
            ] {
                in_range(&format!("{name}.{key}"), value, low, high)?;
            }
            if actuator.units_at_full == Some(actuator.neutral_units) {
                return Err(format!("{name}.units_at_full is the same as neutral_units").into());
            }
        }
        let steers = |(_, actuator): &(_, Actuator)| actuator.units_per_rad.abs() >= 1e-6;
        if !all.iter().any(steers) {
            return Err("nothing steers: expected rudder.topic and rudder.units_per_rad, or [actuators.NAME] with units_per_rad, of 1e-6 or more either way".into());
        }
        if !all.iter().any(|(_, actuator)| actuator.units_at_full.is_some()) {
            return Err(
                "nothing drives: expected [thrust], or [actuators.NAME] with units_at_full".into(),
            );
        }
        Ok(())
    }

    fn check_zenoh(&self, zenoh: &Zenoh) -> Result<(), InvalidDescription> {
        let address = zenoh.endpoint.strip_prefix("tcp/");
        let parts = address.and_then(|address| address.rsplit_once(':'));
        let is_host = |host: &str| {
            !host.is_empty()
                && host.chars().all(|c| c.is_ascii_alphanumeric() || "[]:.-_".contains(c))
        };
        if !parts.is_some_and(|(host, port)| is_host(host) && port.parse::<u16>().is_ok()) {
            return Err(format!(
                "zenoh.endpoint is {:?}: expected tcp/HOST:PORT, as in tcp/127.0.0.1:7447",
                zenoh.endpoint
            )
            .into());
        }
        let is_of_dds = self.listens_on_all_addresses
            || self.addresses != loopback()
            || self.services != Middleware::default();
        match is_of_dds {
            true => Err("addresses, listens_on_all_addresses and services are about DDS: leave them out where there is [zenoh]".into()),
            false => Ok(()),
        }
    }

    fn check_names(&self) -> Result<(), InvalidDescription> {
        let names = [
            ("odometry.topic", self.odometry.as_ref().map(|odometry| &odometry.topic)),
            ("imu.topic", self.imu.as_ref().map(|imu| &imu.topic)),
            ("feedback.topic", self.feedback.as_ref().map(|feedback| &feedback.topic)),
            ("enable.service", self.enable.as_ref().map(|enable| &enable.service)),
        ];
        let namespace = ("namespace", Some(&self.namespace).filter(|name| !name.is_empty()));
        for (key, name) in names.into_iter().chain([namespace]) {
            if let Some(name) = name.filter(|name| !is_absolute_name(name)) {
                return Err(no_name(key, name));
            }
        }
        Ok(())
    }

    fn check_numbers(&self) -> Result<(), InvalidDescription> {
        let feedback = self.feedback.as_ref();
        for (key, value, low, high) in [
            // Above it the ports of DDS are no longer outside those that Linux gives to anybody.
            ("domain", f64::from(self.domain), 0.0, 101.0),
            ("command_timeout_s", self.command_timeout_s, 0.1, 5.0),
            ("rudder.limit_rad", self.rudder.limit_rad, 0.01, 1.5),
            (
                "feedback.units_per_rad, either way,",
                feedback.map_or(1.0, |feedback| feedback.units_per_rad.abs()),
                1e-6,
                1e6,
            ),
            (
                "feedback.trim_units",
                feedback.map_or(0.0, |feedback| feedback.trim_units),
                -1e6,
                1e6,
            ),
        ] {
            in_range(key, value, low, high)?;
        }
        Ok(())
    }
}

fn in_range(key: &str, value: f64, low: f64, high: f64) -> Result<(), InvalidDescription> {
    match (low..=high).contains(&value) {
        true => Ok(()),
        false => Err(format!("{key} is {value}: expected {low} to {high}").into()),
    }
}

fn no_name(key: &str, name: &str) -> InvalidDescription {
    format!("{key} is {name:?}: expected a whole name of letters, digits and single underscores, as in /boat/rudder").into()
}
