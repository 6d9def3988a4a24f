//! A run or a log as the figures see it.

use seatrial::campaign::{Stage, StageSpan};
use seatrial::identification::Identification;
use seatrial::words::capitalised;
use seatrial::{Record, Window};
use seatrial_core::Axis;

/// A run or a log as the figures see it.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    /// What heading and rudder of the samples are.
    pub axis: Axis,
    pub record: &'a Record,
    /// Where the validation window lies; the same record in a trial.
    pub validation: &'a Record,
    pub stages: &'a [StageSpan],
    pub identification: Option<&'a Identification>,
    /// Its name in alternative texts.
    pub name: &'a str,
    /// The record's time at the left end of the manoeuvre's axis, s.
    pub origin_s: f64,
    /// A run of a trial, whose manoeuvres are known; otherwise a log of anything.
    pub is_trial: bool,
}

impl Source<'_> {
    pub(super) fn window(&self, stage: Stage) -> Option<Window> {
        let span = self.stages.iter().find(|span| span.stage == stage)?;
        let record = match stage {
            Stage::Validate => self.validation,
            Stage::Settle | Stage::Train => self.record,
        };
        let samples = record.window(span.window);
        Some(Window {
            from_s: span.window.from_s.max(samples.first()?.time_s),
            to_s: span.window.to_s.min(samples.last()?.time_s),
        })
    }

    /// The angle as the first word of a label: `Heading`.
    pub(super) fn angle(&self) -> String {
        capitalised(self.axis.angle())
    }

    /// The control surface as the first word of a label: `Rudder`.
    pub(super) fn surface(&self) -> String {
        capitalised(self.axis.surface())
    }

    /// Are both windows on one time axis?
    pub(super) fn one_record(&self) -> bool {
        std::ptr::eq(self.record, self.validation)
    }
}

/// The name of a stage and the CSS class of its shade.
pub(super) fn stage_name(stage: Stage) -> (&'static str, &'static str) {
    match stage {
        Stage::Settle => ("settle", "span-settle"),
        Stage::Train => ("train", "span-train"),
        Stage::Validate => ("validate", "span-validate"),
    }
}
