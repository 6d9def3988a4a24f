//! A record with what is doubtful about all of it, looked for once however many windows of it are identified.

use super::joint_estimate::JointEstimate;
use super::{IdentifyError, IdentifySettings, ValidationData};
use crate::identification::Identification;
use crate::plausibility::{self, Doubt};
use crate::record::{Record, Window};

/// A survey of a record, made once for the identification of several of its windows.
///
/// [`identify`](super::identify()) and [`identify_joined`](super::identify_joined) look through the whole record at each call; of a long
/// record with many manoeuvres this takes longer than the estimates.
#[derive(Clone, Debug)]
pub struct RecordSurvey<'a> {
    record: &'a Record,
    unit_doubts: Vec<Doubt>,
    unchecked: Vec<Doubt>,
}

impl<'a> RecordSurvey<'a> {
    /// Looks through a record.
    ///
    /// ```
    /// use seatrial::Window;
    /// use seatrial::identify::{IdentifySettings, RecordSurvey, identify};
    ///
    /// # let vehicle = seatrial_core::YawModel::from_theta([-1.07, 1.08, 0.012]);
    /// # let mut state = seatrial_core::model::YawState::<f64>::default();
    /// # let sample = |k: u32| {
    /// #     let rudder_rad = match k % 330 { 40..80 => 0.26, 80..120 => -0.26, _ => 0.0 };
    /// #     let heading_rad = (1000.0 * state.heading_rad).round() / 1000.0;
    /// #     state = vehicle.advance(state, rudder_rad, 0.05);
    /// #     seatrial::Sample { time_s: 0.05 * f64::from(k), heading_rad, rudder_rad, ..Default::default() }
    /// # };
    /// # let record: seatrial::Record = (0..660).map(sample).collect();
    /// // Two doublets of 0.26 rad on a vehicle with a22 = -1.07 1/s, b2 = 1.08 1/s^2.
    /// let (survey, settings) = (RecordSurvey::of(&record), IdentifySettings::paper());
    /// for from_s in [0.0, 16.5] {
    ///     let window = Window { from_s, to_s: from_s + 16.5 };
    ///     let found = survey.identify(window, None, &settings)?;
    ///     assert_eq!(found, identify(&record, window, None, &settings)?);
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of(record: &'a Record) -> Self {
        Self {
            record,
            unit_doubts: plausibility::unit_doubts(record),
            unchecked: plausibility::unchecked(record),
        }
    }

    /// [`identify`](super::identify()) of a window of this record, with the same answer.
    pub fn identify(
        &self,
        training: Window,
        data: Option<ValidationData>,
        settings: &IdentifySettings,
    ) -> Result<Identification, IdentifyError> {
        super::model_of(self, training, data, settings)
    }

    /// [`identify_joined`](super::identify_joined) of manoeuvres of this record, with the same answer.
    pub fn identify_joined(
        &self,
        training: &[Window],
        data: Option<ValidationData>,
        settings: &IdentifySettings,
    ) -> Result<(Identification, Option<JointEstimate>), IdentifyError> {
        super::joined_model(self, training, data, settings)
    }

    /// The record.
    pub fn record(&self) -> &'a Record {
        self.record
    }

    /// Whether the columns are in the units that they say.
    pub(super) fn unit_doubts(&self) -> &[Doubt] {
        &self.unit_doubts
    }

    /// What no model of the record can show.
    pub(super) fn unchecked(&self) -> &[Doubt] {
        &self.unchecked
    }

    /// The doubts about the units of a record, which may be this one.
    pub(super) fn unit_doubts_of(&self, other: &Record) -> Vec<Doubt> {
        if std::ptr::eq(self.record, other) {
            return self.unit_doubts.clone();
        }
        plausibility::unit_doubts(other)
    }
}
