//! What is kept of a manoeuvre.

use seatrial::Window;
use seatrial::identification::{Identification, Verdict};

use super::Row;

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
        let codes: Vec<String> = verdict.reasons.iter().map(|r| r.kind().to_string()).collect();
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
