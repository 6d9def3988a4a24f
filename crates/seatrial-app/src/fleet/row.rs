//! What is kept of a manoeuvre.

use seatrial::Window;
use seatrial::identification::{Identification, Verdict};
use serde::{Deserialize, Serialize};

/// A manoeuvre and its model, or a log that cannot be read. Missing things are `None`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[expect(missing_docs, reason = "each is a column, and COLUMNS says what it is")]
pub struct Row {
    pub source: String,
    pub run: Option<String>,
    pub format: Option<String>,
    pub bytes: u64,
    pub modified: Option<i64>,
    pub etag: Option<String>,
    pub sha256: Option<String>,
    pub start: Option<i64>,
    pub samples_read: Option<u64>,
    pub rows_left_out: Option<u64>,
    pub rudder_unit: Option<String>,
    pub warnings: Option<Vec<String>>,
    pub manoeuvre: Option<String>,
    pub from_s: Option<f64>,
    pub to_s: Option<f64>,
    pub thrust: Option<f64>,
    pub surge_speed_m_s: Option<f64>,
    pub rudder_amplitude_rad: Option<f64>,
    pub samples_used: Option<u64>,
    pub samples_rejected: Option<u64>,
    pub lambda_rad_s: Option<f64>,
    pub method: Option<String>,
    pub a22_per_s: Option<f64>,
    pub b2_per_s2: Option<f64>,
    pub c0_rad_per_s2: Option<f64>,
    pub delta0_rad: Option<f64>,
    pub a22_low_per_s: Option<f64>,
    pub a22_high_per_s: Option<f64>,
    pub b2_low_per_s2: Option<f64>,
    pub b2_high_per_s2: Option<f64>,
    pub c0_low_rad_per_s2: Option<f64>,
    pub c0_high_rad_per_s2: Option<f64>,
    pub nomoto_t_s: Option<f64>,
    pub nomoto_k_per_s: Option<f64>,
    pub online_a22_per_s: Option<f64>,
    pub online_b2_per_s2: Option<f64>,
    pub online_c0_rad_per_s2: Option<f64>,
    pub r2_heading: Option<f64>,
    pub r2_heading_offset_refit: Option<f64>,
    pub r2_yaw_rate: Option<f64>,
    pub accepted: Option<bool>,
    pub verdict: Option<String>,
    pub reasons: Option<Vec<String>>,
    pub verdict_text: Option<String>,
    pub error: Option<String>,
    pub error_text: Option<String>,
}

impl Row {
    /// Puts a model in.
    pub(super) fn identified(&mut self, found: &Identification) {
        let model = found.model();
        let online = found.online.model;
        self.window(found.training);
        self.samples_used = Some(found.samples_used as u64);
        self.samples_rejected = Some(u64::from(found.samples_rejected.total()));
        self.lambda_rad_s = finite(found.settings.lambda_rad_s);
        self.method = Some(found.method().to_string());
        self.a22_per_s = finite(model.a22_per_s);
        self.b2_per_s2 = finite(model.b2_per_s2);
        self.c0_rad_per_s2 = finite(model.c0_rad_per_s2);
        self.delta0_rad = model.delta0_rad();
        if let Some(intervals) = found.refined.as_ref().map(|r| r.interval_95) {
            [self.a22_low_per_s, self.a22_high_per_s] = intervals.a22_per_s.map(finite);
            [self.b2_low_per_s2, self.b2_high_per_s2] = intervals.b2_per_s2.map(finite);
            [self.c0_low_rad_per_s2, self.c0_high_rad_per_s2] = intervals.c0_rad_per_s2.map(finite);
        }
        self.nomoto_t_s = found.nomoto.map(|nomoto| nomoto.t_s);
        self.nomoto_k_per_s = found.nomoto.map(|nomoto| nomoto.k_per_s);
        self.online_a22_per_s = finite(online.a22_per_s);
        self.online_b2_per_s2 = finite(online.b2_per_s2);
        self.online_c0_rad_per_s2 = finite(online.c0_rad_per_s2);
        if let Some(validation) = found.validation {
            self.r2_heading = validation.r2_heading;
            self.r2_heading_offset_refit = validation.r2_heading_offset_refit;
            self.r2_yaw_rate = validation.r2_yaw_rate;
        }
        self.judged(&found.verdict);
    }

    /// Puts a verdict in.
    pub(super) fn judged(&mut self, verdict: &Verdict) {
        let codes: Vec<String> = verdict.reasons.iter().map(|r| r.code.to_string()).collect();
        self.accepted = Some(verdict.accepted);
        self.verdict = codes.first().cloned();
        self.reasons = Some(codes);
        self.verdict_text = verdict.reasons.first().map(|reason| reason.text.clone());
    }

    pub(super) fn window(&mut self, window: Window) {
        self.from_s = finite(window.from_s);
        self.to_s = finite(window.to_s);
    }

    /// Makes it an error row.
    pub(super) fn failed(&mut self, code: &str, text: String) {
        self.error = Some(code.into());
        self.error_text = Some(text);
    }
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}
