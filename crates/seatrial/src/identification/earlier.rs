//! The kind of a reason as documents hold it, those of earlier versions too.

use serde::{Deserialize, Deserializer};

use super::code::{ReasonCode, ReasonKind, Subject};

/// As a document holds it.
#[derive(Deserialize)]
struct StoredKind {
    code: ReasonCode,
    #[serde(default)]
    of: Option<Subject>,
}

impl<'de> Deserialize<'de> for ReasonKind {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let StoredKind { code, of } = StoredKind::deserialize(deserializer)?;
        let earlier = of.is_none().then(|| of_earlier(&code.to_string()));
        Ok(earlier.flatten().unwrap_or(Self { code, of }))
    }
}

/// What a code of a document of an earlier version is called now, where that is something else.
fn of_earlier(code: &str) -> Option<ReasonKind> {
    use ReasonCode::*;
    use Subject::*;
    Some(match code {
        "rudder_constant" => Constant.of(Rudder),
        "heading_constant" => Constant.of(Heading),
        "elevator_constant" => Constant.of(Elevator),
        "heading_unit_doubtful" => UnitDoubtful.of(Heading),
        "rudder_unit_doubtful" => UnitDoubtful.of(Rudder),
        "time_unit_doubtful" => UnitDoubtful.of(Time),
        "rudder_scale_unknown" => UnitUnknown.of(Rudder),
        "heading_held" => SampledTooSeldom.of(Heading),
        "rudder_held" => SampledTooSeldom.of(Rudder),
        "times_shared" => SampledTooSeldom.of(Time),
        "heading_unchecked" => Unchecked.of(Heading),
        "rudder_unchecked" => Unchecked.of(Rudder),
        "time_unchecked" => Unchecked.of(Time),
        "compass_late" => Late.of(Heading),
        "yaw_rate_late" => Late.of(YawRate),
        "compass_deviation" => YawRateContradicts.of(Heading),
        "sign_reversed" => SignReversed.of(Rudder),
        "yaw_rate_reversed" => SignReversed.of(YawRate),
        "pitch_undamped" => Unstable.of(Pitch),
        "pitch_not_explained" => NotIdentifiable.of(Pitch),
        "speed_unknown" => ManoeuvresDiffer.of(Speed),
        "speed_falls" => SpeedsDiffer.of(Speed),
        "authority_changed" => SpeedsDiffer.of(Rudder),
        "damping_changed" => SpeedsDiffer.of(Damping),
        "rejected_samples" => Damaged.of(Samples),
        "disagreement" => Contradicted.of(Training),
        "residual_not_white" => ModelOrder.of(Residual),
        "weakly_validated" => UnderExcited.of(Validation),
        "rudder_saturated" => RudderNotFollowed.alone(),
        "rudder_jammed" => RudderNotFollowed.of(Rudder),
        "rudder_play" => RudderNotFollowed.of(Linkage),
        "speed_drifted" => Drifted.of(Speed),
        "offset_drifted" => Drifted.of(Offset),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::{Reader, Reason};

    /// Every code of earlier versions that a document with a model or a run may hold.
    const OF_EARLIER: &str = "ok not_a_vessel too_few_samples rudder_constant heading_constant not_identifiable \
        under_excited does_not_fit unstable disagreement lag_unknown residual_not_white samples_missing model_order disturbed \
        sign_reversed rejected_samples speed_drifted sampled_too_seldom clock_jitter times_shared clock_jumped \
        rudder_saturated rudder_jammed rudder_play quantised compass_error compass_deviation compass_late low_r2 not_validated \
        offset_drifted contradicted weakly_validated extrapolating elevator_constant pitch_undamped pitch_not_explained \
        manoeuvres_differ speed_unknown speed_missing run_repeated speed_falls authority_changed damping_changed \
        heading_unit_doubtful rudder_unit_doubtful rudder_scale_unknown time_unit_doubtful yaw_rate_contradicts \
        yaw_rate_reversed yaw_rate_late course_for_heading heading_held rudder_held heading_unchecked rudder_unchecked \
        time_unchecked damaged aborted interrupted accepted_by_operator rejected_by_operator";
    const FAULTS: &str = "compass_error compass_deviation compass_late clock_jumped rudder_jammed";
    const OF_THE_VEHICLE: &str = "low_r2 contradicted does_not_fit disagreement";
    const WITHOUT_LIMIT: &str = "ok sign_reversed rejected_samples quantised yaw_rate_reversed yaw_rate_late \
        heading_unchecked rudder_unchecked accepted_by_operator";
    /// Codes whose reasons say it all themselves.
    const WITHOUT_WORDS: &str = "ok not_a_vessel speed_missing aborted interrupted accepted_by_operator rejected_by_operator";

    #[test]
    fn io_every_code_of_the_version_before_is_read() {
        let is_in = |codes: &str, code| codes.split_whitespace().any(|other| other == code);
        let mut kinds: Vec<ReasonKind> = Vec::new();
        for code in OF_EARLIER.split_whitespace() {
            let text = format!(r#"{{"code":"{code}","text":"measured"}}"#);
            let reason: Reason = serde_json::from_str(&text).unwrap();
            let kind = reason.kind();
            assert!(!matches!(kind.code, ReasonCode::Other(_)), "{code}");
            assert_eq!(kind.is_fault(), is_in(FAULTS, code), "{code}");
            assert_eq!(
                kind.is_of_the_vehicle(),
                is_in(FAULTS, code) || is_in(OF_THE_VEHICLE, code),
                "{code}"
            );
            assert_eq!(kind.limits(), !is_in(WITHOUT_LIMIT, code), "{code}");
            let of_now = Reason::new(kind.clone(), "measured");
            assert_eq!(of_now.detail.is_empty(), is_in(WITHOUT_WORDS, code), "{code}");
            assert_eq!(of_now.action_for(Reader::Terminal), of_now.action);
            let again: ReasonKind =
                serde_json::from_value(serde_json::to_value(&kind).unwrap()).unwrap();
            assert_eq!(again, kind);
            kinds.push(kind);
        }
        let are_apart = (1..kinds.len()).all(|k| !kinds[..k].contains(&kinds[k]));
        assert!(are_apart, "{kinds:?}");
    }

    #[test]
    fn io_what_another_version_calls_it_is_kept() {
        let text = r#"{"code":"of_tomorrow","of":"keel"}"#;
        let kind: ReasonKind = serde_json::from_str(text).unwrap();
        assert_eq!(serde_json::to_string(&kind).unwrap(), text);
        assert_eq!(kind.to_string(), "of_tomorrow of keel");
    }

    #[test]
    fn io_codes_are_in_snake_case_and_unknown_ones_are_kept() {
        for (code, name) in [
            (ReasonCode::LowR2, "low_r2"),
            (ReasonCode::ClockJitter, "clock_jitter"),
            (ReasonCode::Other("of_tomorrow".into()), "of_tomorrow"),
        ] {
            assert_eq!(code.to_string(), name);
            let json = serde_json::to_string(&code).unwrap();
            assert_eq!(json, format!("\"{name}\""));
            assert_eq!(serde_json::from_str::<ReasonCode>(&json).unwrap(), code);
        }
    }
}
