//! Is a description one that can be used?

use thiserror::Error;

use super::{Description, FeedbackType, Middleware, Zenoh, is_absolute_name, loopback};

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
        let (rudder, thrust) = (&self.rudder, &self.thrust);
        for (name, kind, field) in [
            ("rudder", rudder.kind, rudder.field()),
            ("thrust", thrust.kind, thrust.field()),
        ] {
            if kind.index(field).is_none() {
                return Err(format!(
                    "{name}.field is {field:?}: its type has {}",
                    kind.expected()
                )
                .into());
            }
        }
        if rudder.topic == thrust.topic
            && (rudder.kind != thrust.kind || rudder.field() == thrust.field())
        {
            return Err(format!(
                "rudder and thrust are both on {}: expected the same type and different fields",
                rudder.topic
            )
            .into());
        }
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

    fn check_zenoh(&self, zenoh: &Zenoh) -> Result<(), InvalidDescription> {
        let address = zenoh.endpoint.strip_prefix("tcp/");
        let parts = address.and_then(|address| address.rsplit_once(':'));
        let is_host = |host: &str| {
            !host.is_empty()
                && host
                    .chars()
                    .all(|c| c.is_ascii_alphanumeric() || "[]:.-_".contains(c))
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
            ("rudder.topic", Some(&self.rudder.topic)),
            ("thrust.topic", Some(&self.thrust.topic)),
            (
                "odometry.topic",
                self.odometry.as_ref().map(|odometry| &odometry.topic),
            ),
            ("imu.topic", self.imu.as_ref().map(|imu| &imu.topic)),
            (
                "feedback.topic",
                self.feedback.as_ref().map(|feedback| &feedback.topic),
            ),
            (
                "enable.service",
                self.enable.as_ref().map(|enable| &enable.service),
            ),
        ];
        for (key, name) in names {
            if let Some(name) = name.filter(|name| !is_absolute_name(name)) {
                return Err(format!(
                    "{key} is {name:?}: expected a whole name of letters, digits and single underscores, as in /boat/rudder"
                ).into());
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
                "rudder.units_per_rad, either way,",
                self.rudder.units_per_rad.abs(),
                1e-6,
                1e6,
            ),
            ("rudder.trim_units", self.rudder.trim_units, -1e6, 1e6),
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
            ("thrust.units_at_full", self.thrust.units_at_full, -1e9, 1e9),
            ("thrust.neutral_units", self.thrust.neutral_units, -1e9, 1e9),
        ] {
            if !(low..=high).contains(&value) {
                return Err(format!("{key} is {value}: expected {low} to {high}").into());
            }
        }
        if self.thrust.units_at_full == self.thrust.neutral_units {
            return Err("thrust.units_at_full is the same as neutral_units".into());
        }
        Ok(())
    }
}
