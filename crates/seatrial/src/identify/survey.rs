//! A record with what is doubtful about all of it, looked for once however many windows of it are identified.

use super::joined::Joined;
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
    ) -> Result<(Identification, Option<Joined>), IdentifyError> {
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
