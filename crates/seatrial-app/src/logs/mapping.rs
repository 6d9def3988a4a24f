//! A file of channels: which columns, topics or fields of messages are which quantities.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use seatrial_logs::{ChannelChoice, Correction, Fault, Quantity, ReadError, Unit};
use serde::Deserialize;
use serde::de::{Deserializer, Error as _};
use toml::Spanned;

use crate::Error;

/// Other sections belong to others.
#[derive(Deserialize)]
struct Document {
    channels: BTreeMap<Quantity, Spanned<Channel>>,
}

/// A quantity: scale (value - offset) in its unit.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Channel {
    column: Option<String>,
    /// Half their difference: fins of a pair, thrusters of both sides; the second with a minus where it counts the other way.
    columns: Option<[String; 2]>,
    #[serde(default, deserialize_with = "unit")]
    unit: Option<Unit>,
    scale: Option<f64>,
    offset: Option<f64>,
    #[serde(default)]
    reversed: bool,
    /// Angle of a rudder at full deflection.
    full_deg: Option<f64>,
}

fn unit<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Unit>, D::Error> {
    let text = String::deserialize(deserializer)?;
    text.parse().map(Some).map_err(D::Error::custom)
}

/// A quantity that cannot be described so.
#[derive(Debug, thiserror::Error)]
enum InvalidChannel {
    #[error("`columns`, half the difference of two, is for rudder and thrust")]
    NotHalved,
    #[error("expected `column` or `columns`, found both")]
    ColumnAndColumns,
    #[error("expected `column = \"NAME\"` or `columns = [\"NAME\", \"NAME\"]`")]
    NoColumn,
    #[error("{field} = {value}: expected a finite number, a scale not 0")]
    Number { field: &'static str, value: f64 },
    #[error("full_deg = {full_deg}: expected the angle of a full rudder, up to 90")]
    FullAngle { full_deg: f64 },
    #[error("a time has a unit and a scale above 0, and no offset or sign")]
    CorrectedTime,
}

/// A file of channels.
#[derive(Debug, Default)]
pub struct Mapping {
    path: PathBuf,
    /// Where each quantity is described.
    lines: BTreeMap<Quantity, usize>,
    choice: ChannelChoice,
}

impl Mapping {
    /// Reads the section `channels` of a file.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| Error::Input(format!("{}: {error}", path.display())))?;
        let document: Document = toml::from_str(&text)
            .map_err(|error| Error::Input(format!("{}: {error}", path.display())))?;
        let mut mapping = Self { path: path.to_path_buf(), ..Self::default() };
        for (quantity, entry) in document.channels {
            let line = 1 + text[..entry.span().start].matches('\n').count();
            mapping.lines.insert(quantity, line);
            mapping
                .take(quantity, entry.into_inner())
                .map_err(|what| mapping.error(quantity, what))?;
        }
        Ok(mapping)
    }

    fn take(&mut self, quantity: Quantity, channel: Channel) -> Result<(), InvalidChannel> {
        let choice = &mut self.choice;
        let is_halved = matches!(quantity, Quantity::Rudder | Quantity::Thrust);
        match (channel.column, channel.columns) {
            (Some(column), None) => {
                choice.columns.insert(quantity, column);
            }
            (None, Some(pair)) if is_halved => {
                choice.half_differences.insert(quantity, pair);
            }
            (None, Some(_)) => return Err(InvalidChannel::NotHalved),
            (Some(_), Some(_)) => return Err(InvalidChannel::ColumnAndColumns),
            (None, None) => return Err(InvalidChannel::NoColumn),
        }
        for (field, value) in [("scale", channel.scale), ("offset", channel.offset)] {
            if let Some(value) = value.filter(|v| !v.is_finite() || (field == "scale" && *v == 0.0))
            {
                return Err(InvalidChannel::Number { field, value });
            }
        }
        if let Some(full_deg) = channel.full_deg {
            if quantity != Quantity::Rudder || !(full_deg > 0.0 && full_deg <= 90.0) {
                return Err(InvalidChannel::FullAngle { full_deg });
            }
            choice.full_rudder_rad = Some(full_deg.to_radians());
        }
        choice.units.extend(channel.unit.map(|unit| (quantity, unit)));
        let sign = if channel.reversed { -1.0 } else { 1.0 };
        let correction =
            Correction { scale: sign * channel.scale.unwrap_or(1.0), offset: channel.offset };
        let is_corrected = correction.scale != 1.0 || correction.offset.is_some();
        if quantity == Quantity::Time && (correction.scale < 0.0 || correction.offset.is_some()) {
            return Err(InvalidChannel::CorrectedTime);
        }
        if is_corrected {
            choice.corrections.insert(quantity, correction);
        }
        Ok(())
    }

    fn error(&self, quantity: Quantity, what: impl std::fmt::Display) -> Error {
        let line = self.lines.get(&quantity).copied().unwrap_or(1);
        Error::Input(format!("{} line {line}, channels.{quantity}: {what}", self.path.display()))
    }

    /// What the file says, where the options say nothing.
    pub fn under(&self, mut options: ChannelChoice) -> ChannelChoice {
        let own = self.choice.clone();
        let named = options.clone();
        let is_named = |quantity: &Quantity| {
            named.columns.contains_key(quantity) || named.half_differences.contains_key(quantity)
        };
        let (columns, pairs) = (own.columns.into_iter(), own.half_differences.into_iter());
        options.columns.extend(columns.filter(|(quantity, _)| !is_named(quantity)));
        options.half_differences.extend(pairs.filter(|(quantity, _)| !is_named(quantity)));
        for (quantity, unit) in own.units {
            options.units.entry(quantity).or_insert(unit);
        }
        options.corrections = own.corrections;
        options.full_rudder_rad = options.full_rudder_rad.or(own.full_rudder_rad);
        options
    }

    /// An error about a column or unit that this file names says where it does.
    pub fn error_of(&self, error: ReadError) -> Error {
        let quantity = match &error.fault {
            Fault::NoSuchColumn { quantity, .. }
            | Fault::AmbiguousColumn { quantity, .. }
            | Fault::UnknownUnit { quantity, .. }
            | Fault::ImplausibleValues { quantity, .. } => Some(*quantity),
            _ => None,
        };
        match quantity.filter(|quantity| self.lines.contains_key(quantity)) {
            Some(quantity) => self.error(quantity, error),
            None => error.into(),
        }
    }
}
