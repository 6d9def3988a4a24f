//! What a page asks of models: gains and turning limits, and the files that are made of them.
//!
//! ```no_run
//! use std::path::Path;
//!
//! use seatrial::gains::export::VehicleType;
//! use seatrial_app::gains_export::Format;
//! use seatrial_app::model_request::{ModelFile, ModelRequest};
//! use seatrial_app::models::of_document;
//!
//! let models = of_document(Path::new("run.model.json"), None)?;
//! let request = ModelRequest {
//!     full_rudder_deg: Some(34.4),
//!     ..ModelRequest::default()
//! };
//! let limits = request.limits(&models)?;
//! println!("{:?}", limits.gains.points[0].proportional_gain);
//! let file = request.file(&models, ModelFile::Gains(Format::Ardupilot, VehicleType::Surface))?;
//! std::fs::write(format!("run.{}", file.extension), file.bytes).expect("a folder to write to");
//! # Ok::<(), seatrial_app::Error>(())
//! ```

use seatrial::gains::export::VehicleType;
use seatrial::identification::Reader;
use seatrial_core::RudderUnit;
use seatrial_core::schedule::ScheduleKey;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

use crate::Error;
use crate::advice::addressed;
use crate::file_form::FileForm;
use crate::gains::{HeadingGains, LoopRequirements};
use crate::gains_export::{Format, GainsFile, check_usable};
use crate::models::Models;
use crate::turning::TurningLimits;
use crate::vehicle_export::{self, Form};
use crate::vehicle_file::VehicleOverrides;

/// What is said of a vehicle beside its models: options of `seatrial gains`, `turn` and `export`. Everything has a default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema, utoipa::IntoParams))]
#[cfg_attr(feature = "openapi", into_params(parameter_in = Query))]
pub struct ModelRequest {
    /// Forward speed of a single model, m/s, where its record has none.
    pub surge_speed_m_s: Option<f64>,
    /// Damping ratio of the closed loop [default: 0.7071].
    pub damping_ratio: Option<f64>,
    /// Parameters of an autopilot at this speed, m/s [default: the fastest model's].
    pub at_speed_m_s: Option<f64>,
    /// Largest rudder angle, degrees.
    pub rudder_limit_deg: Option<f64>,
    /// Rudder angle at full steering, degrees, where the models do not tell it.
    pub full_rudder_deg: Option<f64>,
    /// Uses models of a rehearsal on a simulator as well.
    pub rehearsal: bool,
    /// Writes gains that are warned of, too: of models that are not to be used, or whose interval holds 0.
    pub accept: bool,
}

/// A file that is made of models: those of `seatrial gains --export` and of `seatrial export --to`.
///
/// In documents it has the name of its form, with the vehicle behind parameters of an autopilot: `ardupilot_surface`, `px4_underwater`, `ros2`,
/// `vehicle_json`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ModelFile {
    /// Gains and limits. Only parameters of an autopilot ask for the vehicle.
    Gains(Format, VehicleType),
    /// The vehicle.
    Vehicle(Form),
}

impl ModelFile {
    /// Every file.
    fn all() -> impl Iterator<Item = Self> {
        use VehicleType::{Surface, Underwater};
        let vehicles = |format| match format {
            Format::Ardupilot | Format::Px4 => &[Surface, Underwater][..],
            Format::Ros2 | Format::Json | Format::C => &[Surface],
        };
        let gains = Format::ALL.iter().flat_map(move |row| {
            let of_each = vehicles(row.form).iter();
            of_each.map(|vehicle| Self::Gains(row.form, *vehicle))
        });
        gains.chain(Form::ALL.iter().map(|row| Self::Vehicle(row.form)))
    }

    fn name(self) -> String {
        match self {
            Self::Gains(format @ (Format::Ardupilot | Format::Px4), vehicle) => {
                let vehicle = match vehicle {
                    VehicleType::Surface => "surface",
                    VehicleType::Underwater => "underwater",
                };
                format!("{}_{vehicle}", format.row().name)
            }
            Self::Gains(format, _) => format.row().name.to_owned(),
            Self::Vehicle(form) => form.row().name.replace('-', "_"),
        }
    }

    /// Is it one of `seatrial gains --export`, which needs [`rehearsal`](ModelRequest::rehearsal) for models of a simulator?
    pub fn is_gains(self) -> bool {
        matches!(self, Self::Gains(..))
    }

    /// How the name of the file ends.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Gains(format, _) => format.row().extension,
            Self::Vehicle(form) => form.row().extension,
        }
    }

    /// What a button says.
    fn label(self) -> String {
        use VehicleType::{Surface, Underwater};
        match self {
            Self::Gains(format @ (Format::Ardupilot | Format::Px4), vehicle) => {
                let vehicle = match (format, vehicle) {
                    (Format::Ardupilot, Surface) => "Rover",
                    (Format::Ardupilot, Underwater) => "Sub",
                    (_, Surface) => "rover",
                    (_, Underwater) => "UUV",
                };
                let row = format.row();
                format!("{} {vehicle}, .{}", row.label, row.extension)
            }
            Self::Gains(format, _) => format.row().label.to_owned(),
            Self::Vehicle(form) => form.row().label.to_owned(),
        }
    }
}

impl<'de> Deserialize<'de> for ModelFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        Self::all().find(|file| file.name() == name).ok_or_else(|| {
            let names: Vec<String> = Self::all().map(|file| format!("`{}`", file.name())).collect();
            let expected = names.join(", ");
            D::Error::custom(format!("unknown variant `{name}`, expected one of {expected}"))
        })
    }
}

/// A file that a page offers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct OfferedFile {
    /// The name by which it is asked for.
    pub name: String,
    /// What its button says.
    pub label: String,
    /// How its name ends.
    pub extension: &'static str,
    /// Is it one of `seatrial gains --export`?
    pub is_gains: bool,
}

impl From<ModelFile> for OfferedFile {
    fn from(file: ModelFile) -> Self {
        Self {
            name: file.name(),
            label: file.label(),
            extension: file.extension(),
            is_gains: file.is_gains(),
        }
    }
}

/// A file, and what to know about it.
#[derive(Clone, Debug, PartialEq)]
pub struct FileOfModels {
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// How its name ends.
    pub extension: &'static str,
    /// What to know about it.
    pub notes: Vec<String>,
}

/// The documents of `seatrial gains --json` and `seatrial turn --json`, and the files that can be made beside them.
#[derive(Clone, Debug, Serialize)]
pub struct GainsAndLimits {
    /// What the source says against its models, and where they are used beyond what they were seen for.
    pub warnings: Vec<String>,
    /// Why no file of gains is written unless that is accepted.
    pub unusable: Option<String>,
    /// Gains, feed-forward and margins.
    pub gains: HeadingGains,
    /// Turning limits.
    pub turning: TurningLimits,
    /// Every file that can be made of the models: first those of gains, then those of the vehicle.
    pub files: Vec<OfferedFile>,
}

/// What is said of models in the words of a page, which has a field for the rudder at full steering; that of a vehicle is said when its server
/// is started.
fn on_page(text: String) -> String {
    let field = "“Rudder at full steering” under “Choose damping, speed or rudder angle”";
    addressed(&text.replace("--full-rudder-deg DEG", field), Reader::Dashboard)
}

impl ModelRequest {
    /// Gains and turning limits of models, those of `seatrial gains` and `seatrial turn`.
    ///
    /// # Errors
    /// What these refuse: a setting that no model could satisfy.
    pub fn limits(&self, models: &Models) -> Result<GainsAndLimits, Error> {
        let models = self.limited(models)?;
        let wanted = self.wanted();
        Ok(GainsAndLimits {
            warnings: models.warnings().into_iter().map(on_page).collect(),
            unusable: check_usable(&wanted, &models).err().map(|error| on_page(error.to_string())),
            gains: wanted.gains(&models)?,
            turning: TurningLimits::of(&models, std::f64::consts::PI, None, None)?,
            files: ModelFile::all().map(OfferedFile::from).collect(),
        })
    }

    /// A file made of models.
    ///
    /// # Errors
    /// What `seatrial gains --export` and `seatrial export` refuse: [`Error::Rejected`] where only [`accept`](Self::accept) writes it.
    pub fn file(&self, models: &Models, file: ModelFile) -> Result<FileOfModels, Error> {
        let models = self.limited(models)?;
        let form = match file {
            ModelFile::Gains(format, vehicle) => return self.gains_file(&models, format, vehicle),
            ModelFile::Vehicle(form) => form,
        };
        let stated = VehicleOverrides {
            full_rudder_rad: self.full_rudder_deg.map(f64::to_radians),
            ..VehicleOverrides::default()
        };
        let vehicle = stated.vehicle(&models)?;
        if !self.accept {
            let not_to_be_used = "its models are not to be used".to_owned();
            let rejected = (!models.rejected.is_empty()).then_some(&not_to_be_used);
            vehicle_export::check_usable(&vehicle, form, None, rejected)?;
        }
        let (bytes, note) = vehicle_export::file(&vehicle, form, None)?;
        let notes = vehicle.provenance.assumptions.into_iter().chain(note);
        Ok(FileOfModels {
            bytes,
            extension: form.row().extension,
            notes: notes.map(on_page).collect(),
        })
    }

    fn gains_file(
        &self,
        models: &Models,
        format: Format,
        vehicle: VehicleType,
    ) -> Result<FileOfModels, Error> {
        let wanted = self.wanted();
        models.unless_rehearsed(self.rehearsal)?;
        if !self.accept {
            check_usable(&wanted, models)?;
        }
        let made = GainsFile::new(format, &wanted, models, vehicle, self.rehearsal)?;
        Ok(FileOfModels {
            bytes: made.text.into_bytes(),
            extension: format.row().extension,
            notes: made.notes.into_iter().map(on_page).collect(),
        })
    }

    fn wanted(&self) -> LoopRequirements {
        let usual = LoopRequirements::default();
        LoopRequirements {
            damping_ratio: self.damping_ratio.unwrap_or(usual.damping_ratio),
            at: self.at_speed_m_s.map(|speed| (ScheduleKey::Speed, speed)),
            ..usual
        }
    }

    /// The models with what is said of the rudder. One that is a share of full needs no angle.
    fn limited(&self, models: &Models) -> Result<Models, Error> {
        let angle_rad = self.full_rudder_deg.map(f64::to_radians);
        models
            .clone()
            .limited(self.rudder_limit_deg.map(f64::to_radians))?
            .with_full_rudder(angle_rad.filter(|_| models.rudder_unit == RudderUnit::Rad))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_page_has_a_field_for_the_full_rudder_of_models() {
        let text = "if full steering is another angle, say --full-rudder-deg DEG";
        let shown = on_page(text.into());
        assert!(shown.contains("say “Rudder at full steering” under"), "{shown}");
        assert!(addressed(text, Reader::Dashboard).contains("in a terminal"));
    }

    #[test]
    fn exact_every_file_on_offer_is_taken_by_its_name_and_has_an_ending_of_its_own() {
        let mut endings = Vec::new();
        for file in ModelFile::all() {
            let offered = OfferedFile::from(file);
            let taken: ModelFile = serde_json::from_value(offered.name.into()).unwrap();
            assert_eq!(taken, file);
            if let ModelFile::Vehicle(form) = file {
                assert_eq!(Form::named(form.row().name), Some(form));
                assert!(!offered.is_gains && !endings.contains(&offered.extension));
                endings.push(offered.extension);
            }
        }
    }
}
