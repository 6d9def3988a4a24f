//! Models, verdicts and where they come from, as text for people.

use std::fmt::Write;

use seatrial::identification::{Validation, Verdict};
use seatrial::words::{bounds_text, r2_text, three_figures, within};
use seatrial::{Identification, Window};
use seatrial_app::logs::OpenedLog;
use seatrial_core::RudderUnit;

/// The outcome in capitals, and each reason in a paragraph.
pub fn verdict_text(verdict: &Verdict) -> String {
    let mut text = verdict.outcome().name().to_uppercase() + "\n";
    for reason in &verdict.reasons {
        let _ = writeln!(text, "  {}: {}", reason.kind(), reason.measured());
    }
    text + "\n"
}

/// Parameters and intervals; `unit` is that of the rudder.
pub fn model_text(identification: &Identification, unit: RudderUnit) -> String {
    let model = identification.model();
    let intervals = identification.refined.as_ref().map(|r| r.interval_95);
    let delta0 = model.delta0_rad();
    let rows = [
        ("a22", Some(model.a22_per_s), "1/s", intervals.map(|i| i.a22_per_s)),
        ("b2", Some(model.b2_per_s2), "1/s^2", intervals.map(|i| i.b2_per_s2)),
        ("C0", Some(model.c0_rad_per_s2), "rad/s^2", intervals.map(|i| i.c0_rad_per_s2)),
        (
            "delta0",
            delta0,
            match unit {
                RudderUnit::Rad => "rad",
                RudderUnit::FullRudder => "of full",
            },
            intervals.and_then(|i| i.delta0_rad),
        ),
    ];
    let rudder = match unit {
        RudderUnit::Rad => "",
        RudderUnit::FullRudder => " (full rudder is 1)",
    };
    let mut text = format!("Model       psi' = r, r' = a22 r + b2 rudder + C0{rudder}\n");
    for (name, value, unit, interval) in rows {
        let Some(value) = value else { continue };
        let value = within(value, interval);
        let interval =
            interval.map_or(String::new(), |interval| format!("  95 % {}", bounds_text(interval)));
        let _ = writeln!(text, "  {name:<8}  {value:>9} {unit:<8}{interval}");
    }
    if let Some(nomoto) = identification.nomoto {
        let _ = writeln!(
            text,
            "  Nomoto    T {} s, K {} 1/s{}",
            three_figures(nomoto.t_s),
            three_figures(nomoto.k_per_s),
            unit.per()
        );
    }
    if let Some(range) = &identification.valid_range {
        let _ = writeln!(text, "  Seen for  {}", range.text(unit));
    }
    text
}

/// R^2 on validation data.
pub fn validation_text(identification: &Identification) -> String {
    let Some(validation) = identification.validation else {
        return "Validation  none\n".into();
    };
    let by = match identification.is_validated_within() {
        true => ", predicted by a model of the rest of the training",
        false => "",
    };
    format!(
        "Validation  {}, {} samples{by}: R^2 {}\n",
        span_text(validation.window),
        validation.samples,
        r2_sentence(&validation)
    )
}

/// R^2 of heading, also with the offset estimated again, and of yaw rate.
pub fn r2_sentence(validation: &Validation) -> String {
    format!(
        "of heading {}, with the offset estimated again {}, of yaw rate {}",
        r2_text(validation.r2_heading),
        r2_text(validation.r2_heading_offset_refit),
        r2_text(validation.r2_yaw_rate),
    )
}

/// A window in seconds, to two decimals.
pub fn span_text(window: Window) -> String {
    format!("{:.2} s to {:.2} s", window.from_s, window.to_s)
}

/// Digits of a checksum that tell logs apart; the document has all.
const SHOWN_OF_SHA256: usize = 12;

/// Where the samples came from and what was assumed on the way.
pub fn source_text(title: &str, log: &OpenedLog) -> String {
    let servo = log
        .servo
        .map_or_else(String::new, |servo| format!(", rudder behind the command by {servo}"));
    let sha256 = log.sha256.get(..SHOWN_OF_SHA256).unwrap_or(&log.sha256);
    format!(
        "{title:<11} {}, {} samples read{servo}, sha256 {sha256}...\n",
        log.path.display(),
        log.counts.samples,
    )
}

/// How the estimate was made.
pub fn training_text(identification: &Identification) -> String {
    let settings = &identification.settings;
    let online = &identification.online;
    let [a22, b2, c0] = online.model.theta().map(three_figures);
    let rejected = identification.samples_rejected;
    let mut text = format!(
        "Training    {}, {} samples used, {} rejected, {} gaps\n",
        span_text(identification.training),
        identification.samples_used,
        rejected.total(),
        rejected.gaps
    );
    let _ = writeln!(
        text,
        "Filter      lambda {} rad/s: {}",
        three_figures(settings.lambda_rad_s),
        settings.lambda_because
    );
    let _ = writeln!(
        text,
        "Online      {}: a22 {a22}, b2 {b2}, C0 {c0}; {}",
        online.method.words(),
        match online.convergence.detected_s {
            Some(after_s) => format!("converged (39) after {after_s:.2} s"),
            None => "not converged (39)".into(),
        }
    );
    if let Some(refined) = &identification.refined {
        let _ = writeln!(
            text,
            "Refined     {}; heading noise {} deg, yaw disturbance {} rad/s^2",
            refined.method.words(),
            three_figures(refined.heading_noise_rad.to_degrees()),
            three_figures(refined.disturbance_rad_s2)
        );
    }
    text
}
