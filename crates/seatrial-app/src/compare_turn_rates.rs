//! Several logs of one hull: whether its damping grows with the turn rate, speed by speed.

use std::path::PathBuf;

use seatrial::campaign::speeds::{OverAmplitude, SeenModel, ValueInterval, seen_amplitude_rad_s};
use seatrial::identification::{Outcome, Verdict};
use seatrial::{Identification, Sample, Window};
use seatrial_core::{Nomoto, RudderUnit};
use serde::Serialize;

use crate::Error;
use crate::identify_log::{IdentifiedLog, Options, identify_log_observed};
use crate::log_page::speed_text;
use crate::logs::{Observer, ReadSettings, Source};

/// Speeds that differ by more than this share are compared by themselves.
const SAME_SPEED: f64 = 0.1;

/// This share of a manoeuvre's samples is slower than the speed that it is known by: that of the straight, as a turn costs speed. A ship
/// is slower after the first turn of its zig-zag for good.
const STRAIGHT_SHARE: f64 = 0.99;

/// The document of `compare --json` of several logs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TurnRates {
    /// `seatrial.turn_rates.v1`
    pub schema: &'static str,
    /// The logs, as they were given.
    pub sources: Vec<Source>,
    /// The model of each log or, of a log of several speeds, of each of its speeds.
    pub models: Vec<LogModel>,
    /// The models of each speed together.
    pub speeds: Vec<OneSpeed>,
}

/// A model and the amplitudes that it was seen at.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LogModel {
    /// The log, as an index of the sources.
    pub log: usize,
    /// Thrust as a fraction of full.
    pub thrust: Option<f64>,
    /// Speed on the straight, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// Amplitude of the yaw rate, rad/s.
    pub yaw_rate_amplitude_rad_s: Option<f64>,
    /// Half of the rudder's range, in the rudder's unit.
    pub rudder_amplitude: Option<f64>,
    /// In what the rudder is.
    pub rudder_unit: RudderUnit,
    /// Nomoto form.
    pub nomoto: Option<Nomoto<f64>>,
    /// a22, 1/s.
    pub a22_per_s: Option<ValueInterval>,
    /// b2, 1/s^2 for each unit of the rudder.
    pub b2_per_s2: Option<ValueInterval>,
    /// What may be done with it.
    pub outcome: Outcome,
    #[serde(skip)]
    seen: Option<SeenModel>,
}

/// The models of one speed together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OneSpeed {
    /// The speed in words.
    pub name: String,
    /// Its models, as indices of all.
    pub models: Vec<usize>,
    /// What those that may be used say together. `None` of fewer than two.
    pub over_amplitude: Option<OverAmplitude>,
    /// In a sentence or two.
    pub text: String,
}

/// Identifies each log as `identify` does and fits the models of each speed, within 10 %, over the amplitude of the yaw rate.
pub fn compare_turn_rates(
    paths: &[PathBuf],
    reading: &ReadSettings,
    observer: &mut dyn Observer,
) -> Result<TurnRates, Error> {
    let options = Options { reading: reading.clone(), ..Options::default() };
    let mut sources = Vec::new();
    let mut models = Vec::new();
    for (log, path) in paths.iter().enumerate() {
        let found = identify_log_observed(path, &options, observer)?;
        sources.push(found.logs.log.source());
        models.extend(models_of(log, &found));
    }
    let speeds = groups(&models).into_iter().map(|group| OneSpeed::of(group, &models)).collect();
    Ok(TurnRates { schema: "seatrial.turn_rates.v1", sources, models, speeds })
}

fn models_of(log: usize, found: &IdentifiedLog) -> Vec<LogModel> {
    match &found.models {
        Some(models) => models
            .iter()
            .map(|model| {
                let identification = model.identification.as_ref();
                let windows = &model.windows.training;
                LogModel {
                    thrust: model.thrust,
                    ..LogModel::of(log, found, windows, identification, &model.verdict)
                }
            })
            .collect(),
        None => {
            let identification = found.identification();
            let window = identification.map(|identification| identification.training);
            let windows = Vec::from_iter(window);
            let verdict = found.verdict();
            vec![LogModel::of(log, found, &windows, identification, verdict)]
        }
    }
}

impl LogModel {
    fn of(
        log: usize,
        found: &IdentifiedLog,
        windows: &[Window],
        identification: Option<&Identification>,
        verdict: &Verdict,
    ) -> Self {
        let record = &found.logs.log.record;
        let parts: Vec<&[Sample<f64>]> = windows.iter().map(|w| record.window(*w)).collect();
        let refined = identification.and_then(|found| found.refined.as_ref());
        let range = identification.and_then(|found| found.valid_range);
        let rudder_amplitude = range.map(|range| 0.5 * (range.rudder[1] - range.rudder[0]));
        let amplitude = (refined.zip(rudder_amplitude))
            .and_then(|(refined, rudder)| seen_amplitude_rad_s(refined, rudder, &parts));
        let seen =
            refined.zip(amplitude).map(|(refined, amplitude)| SeenModel::of(refined, amplitude));
        Self {
            log,
            thrust: None,
            surge_speed_m_s: speed_on_the_straight(&parts),
            yaw_rate_amplitude_rad_s: amplitude,
            rudder_amplitude,
            rudder_unit: record.rudder_unit,
            nomoto: identification.and_then(|found| found.nomoto),
            a22_per_s: refined.map(|refined| ValueInterval {
                value: refined.model.a22_per_s,
                interval_95: refined.interval_95.a22_per_s,
            }),
            b2_per_s2: refined.map(|refined| ValueInterval {
                value: refined.model.b2_per_s2,
                interval_95: refined.interval_95.b2_per_s2,
            }),
            outcome: verdict.outcome(),
            seen: seen.filter(|_| verdict.accepted),
        }
    }

    /// What its speed is known by, and how much that is.
    fn speed(&self) -> (u8, f64) {
        match (self.surge_speed_m_s, self.thrust) {
            (Some(speed), _) => (0, speed),
            (None, Some(thrust)) => (1, thrust),
            (None, None) => (2, 0.0),
        }
    }
}

fn speed_on_the_straight(parts: &[&[Sample<f64>]]) -> Option<f64> {
    let samples = parts.iter().copied().flatten();
    let speeds = samples.filter_map(|sample| sample.surge_speed_m_s);
    let mut speeds: Vec<f64> = speeds.filter(|speed| speed.is_finite()).collect();
    speeds.sort_by(f64::total_cmp);
    let last = speeds.len().checked_sub(1)?;
    speeds.get((STRAIGHT_SHARE * last as f64) as usize).copied()
}

/// The models of each speed, slowest first, those of unknown speed last.
fn groups(models: &[LogModel]) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..models.len()).collect();
    order.sort_by(|a, b| {
        let [(kind_a, a), (kind_b, b)] = [a, b].map(|index| models[*index].speed());
        kind_a.cmp(&kind_b).then(a.total_cmp(&b))
    });
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for index in order {
        let (kind, speed) = models[index].speed();
        let open = groups.last_mut().filter(|group| {
            let (of_kind, least) = models[group[0]].speed();
            of_kind == kind && speed <= (1.0 + SAME_SPEED) * least
        });
        match open {
            Some(group) => group.push(index),
            None => groups.push(vec![index]),
        }
    }
    groups.iter_mut().for_each(|group| group.sort_unstable());
    groups
}

impl OneSpeed {
    fn of(group: Vec<usize>, models: &[LogModel]) -> Self {
        let members = || group.iter().map(|index| &models[*index]);
        let usable = || members().filter(|model| model.seen.is_some());
        let seen: Vec<SeenModel> = usable().filter_map(|model| model.seen).collect();
        let unit = usable().next().map(|model| model.rudder_unit);
        let has_one_unit = usable().all(|model| Some(model.rudder_unit) == unit);
        let has_one_side = seen.iter().all(|model| model.b2_per_s2 * seen[0].b2_per_s2 > 0.0);
        let over_amplitude = OverAmplitude::of(&seen).filter(|_| has_one_unit && has_one_side);
        let text = match &over_amplitude {
            Some(together) => together.text(),
            None if !has_one_unit => "The rudders are in different units: say what full rudder is, so that all are angles.".into(),
            None if !has_one_side => "Their rudders, or their headings, count to different sides: turn the column of one with reversed = true in a [channels] file.".into(),
            None if seen.len() < 2 => format!(
                "Nothing to compare: {} of {} models may be used, and two are needed.",
                seen.len(),
                group.len()
            ),
            None => "Nothing to compare: the uncertainty of a model is not known.".into(),
        };
        let speed = members().map(|model| model.surge_speed_m_s).next();
        let thrust = members().next().and_then(|model| model.thrust);
        Self { name: speed_text(thrust, speed.flatten()), over_amplitude, text, models: group }
    }
}

impl TurnRates {
    /// What the logs tell, speed by speed, in sentences.
    pub fn text(&self) -> String {
        if let [only] = &self.speeds[..] {
            return only.text.clone();
        }
        let lines = self.speeds.iter().map(|speed| format!("\n{}: {}", speed.name, speed.text));
        let together = "The speeds differ by more than 10 %: each is compared by itself.";
        together.to_owned() + &lines.collect::<String>()
    }

    /// Was anything compared?
    pub fn has_compared(&self) -> bool {
        self.speeds.iter().any(|speed| speed.over_amplitude.is_some())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(surge_speed_m_s: Option<f64>, thrust: Option<f64>) -> LogModel {
        LogModel {
            log: 0,
            thrust,
            surge_speed_m_s,
            yaw_rate_amplitude_rad_s: None,
            rudder_amplitude: None,
            rudder_unit: RudderUnit::Rad,
            nomoto: None,
            a22_per_s: None,
            b2_per_s2: None,
            outcome: Outcome::DoNotUse,
            seen: None,
        }
    }

    #[test]
    fn exact_speeds_within_ten_per_cent_are_one() {
        let models = [
            model(Some(1.3), None),
            model(None, None),
            model(Some(1.0), None),
            model(Some(1.09), Some(0.5)),
            model(None, Some(0.8)),
        ];
        let expected: [&[usize]; 4] = [&[2, 3], &[0], &[4], &[1]];
        assert_eq!(groups(&models), expected);
        let alone = OneSpeed::of(vec![0], &models);
        assert!(alone.over_amplitude.is_none());
        assert_eq!(alone.name, "1.30 m/s");
        assert!(alone.text.contains("0 of 1 models may be used"), "{}", alone.text);
    }
}
