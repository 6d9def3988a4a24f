//! Has the vehicle changed from one trial to the other?

use serde::Serialize;

use super::cause::{self, Explanation};
use super::not_compared::NotCompared;
use super::pool::{Deviation, PooledChange, ReferenceError};
use super::{Detectable, Effects, Finding, HealthSettings, Reference, ReferencePoint, SpeedModel};

/// The answer to whether the vehicle has changed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// How it was tested.
    pub settings: HealthSettings,
    /// What was found.
    pub finding: Finding,
    /// Each speed by itself.
    pub speeds: Vec<SpeedChange>,
    /// All speeds together: one change common to all, where there are several.
    pub together: Option<Together>,
    /// What has changed by how much.
    pub effects: Option<Effects>,
    /// The one cause that explains the change within the noise.
    pub explanation: Option<Explanation>,
    /// What would have been found.
    pub detectable: Option<Detectable>,
    /// Speeds that could not be compared, and why.
    pub left_out: Vec<String>,
    /// Why, in words.
    pub because: String,
    /// What to do; empty where the finding by itself says it.
    pub action: String,
}

/// The test at one speed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpeedChange {
    /// Thrust as a fraction of full.
    pub thrust: Option<f64>,
    /// Forward speed now, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// What is different.
    pub effects: Effects,
    /// Probability of such a difference, had nothing changed.
    pub p_value: f64,
    /// Under which the vehicle counts as changed.
    pub level: f64,
}

/// The test of a change common to all speeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Together {
    /// Probability of such a change, had nothing changed.
    pub p_value: f64,
    /// Under which the vehicle counts as changed.
    pub level: f64,
}

/// Tests whether models of now are those of the reference.
///
/// At one speed: the F test of [a22, b2, C0] at the false alarm rate. At n speeds the rate is halved: one half for a
/// change common to all, the other shared by the n tests of one speed each (Bonferroni), so that a change that shows
/// at one speed only is found as well. Speeds are matched by thrust where both sides know it, otherwise by speed.
///
/// ```
/// use seatrial::health::{Cause, Finding, HealthSettings, Reference, SpeedModel, compare};
/// use seatrial_core::YawModel;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let at = |b2| SpeedModel {
///     thrust: Some(0.8),
///     surge_speed_m_s: Some(1.6),
///     model: YawModel::from_theta([-1.07, b2, 0.012]),
///     covariance: [[4e-4, 0.0, 0.0], [0.0, 4e-4, 0.0], [0.0, 0.0, 1e-6]],
///     degrees_of_freedom: 20.0,
///     rudder_lag_s: 0.0,
/// };
/// let (reference, settings) =
///     (Reference::new(vec![at(1.08)])?, HealthSettings::new(0.01, 0.0, true)?);
/// assert_eq!(compare(&reference, &[at(1.09)], &settings).finding, Finding::Unchanged);
/// // A third of the rudder is gone.
/// let change = compare(&reference, &[at(0.72)], &settings);
/// assert_eq!(change.finding, Finding::Changed);
/// assert_eq!(change.explanation.map(|found| found.cause), Some(Cause::Rudder));
/// # Ok(())
/// # }
/// ```
pub fn compare(reference: &Reference, now: &[SpeedModel], settings: &HealthSettings) -> Change {
    let errors = reference.errors();
    let mut compared: Vec<(&SpeedModel, Deviation)> = Vec::new();
    let mut speed_is_known = true;
    let mut left_out = Vec::new();
    for model in now {
        let deviation = reference.at(model).and_then(|expected: ReferencePoint| {
            Deviation::between(&expected, model).ok_or(NotCompared::NotFinite)
        });
        match deviation {
            Ok(deviation) => {
                speed_is_known &= reference.has_speed_of(model);
                compared.push((model, deviation));
            }
            Err(why) => left_out.push(format!("{}: {why}", name(model))),
        }
    }
    Comparison {
        settings,
        errors,
        compared,
        delta0_rad: mean_delta0_rad(reference),
        speed_is_known,
    }
    .change(left_out)
}

impl Change {
    /// Where the data give no model of now that can be compared, and what to do; empty where nothing but another trial helps.
    ///
    /// ```
    /// use seatrial::health::{Change, Finding, HealthSettings};
    ///
    /// let settings = HealthSettings::new(0.01, 0.1, true)?;
    /// let change = Change::cannot_tell(&settings, "the rudder did not move".into(), "");
    /// assert_eq!((change.finding, &*change.because), (Finding::CannotTell, "the rudder did not move"));
    /// # Ok::<(), seatrial::health::HealthError>(())
    /// ```
    pub fn cannot_tell(settings: &HealthSettings, why: String, action: &str) -> Self {
        Self {
            settings: *settings,
            finding: Finding::CannotTell,
            speeds: Vec::new(),
            together: None,
            effects: None,
            explanation: None,
            detectable: None,
            left_out: Vec::new(),
            because: why,
            action: action.into(),
        }
    }
}

fn name(model: &SpeedModel) -> String {
    let thrust = model.thrust.map(|thrust| format!("{:.0} % thrust", 100.0 * thrust));
    let speed = model.surge_speed_m_s.map(|speed| format!("{speed:.2} m/s"));
    let known: Vec<String> = thrust.into_iter().chain(speed).collect();
    if known.is_empty() { "the model".into() } else { known.join(", ") }
}

pub(super) fn mean_delta0_rad(reference: &Reference) -> f64 {
    let points = reference.points();
    let sum: f64 = points.iter().filter_map(|p| p.model.delta0_rad()).sum();
    sum / points.len() as f64
}

struct Comparison<'a> {
    settings: &'a HealthSettings,
    errors: Vec<ReferenceError>,
    compared: Vec<(&'a SpeedModel, Deviation)>,
    delta0_rad: f64,
    speed_is_known: bool,
}

impl Comparison<'_> {
    fn change(self, left_out: Vec<String>) -> Change {
        let settings = self.settings;
        let levels = Levels::of(settings.false_alarm_rate, self.compared.len());
        let deviations: Vec<Deviation> = self.compared.iter().map(|(_, d)| d.clone()).collect();
        let speeds = self.speeds(levels.of_speed);
        let all = (!deviations.is_empty()).then(|| self.pool(&deviations)).flatten();
        let together = all
            .as_ref()
            .filter(|_| deviations.len() > 1)
            .map(|pooled| Together { p_value: pooled.p_value(settings), level: levels.of_all });
        let effects = all.as_ref().map(|pooled| pooled.effects(&deviations, &self.errors));
        let detectable = all.as_ref().and_then(|pooled| pooled.detectable(levels.of_all, settings));
        let differs_together = together.is_some_and(|test| test.p_value < test.level);
        let differing: Vec<&SpeedChange> = speeds.iter().filter(|s| s.p_value < s.level).collect();
        let is_changed = differs_together || !differing.is_empty();
        let explanation = all
            .as_ref()
            .filter(|_| is_changed)
            .and_then(|pooled| Explanation::of(pooled, self.delta0_rad, self.speed_is_known));
        let (finding, because) = match (effects, detectable) {
            (Some(effects), _) if is_changed => {
                let words = cause::words(explanation.as_ref(), &effects);
                let only_at = (deviations.len() > 1 && !differs_together).then_some(&*differing);
                (Finding::Changed, changed_text(words, only_at))
            }
            (Some(_), Some(detectable)) => not_changed(&detectable),
            _ => (Finding::CannotTell, nothing_compared(&left_out)),
        };
        Change {
            settings: *settings,
            finding,
            speeds,
            together,
            effects,
            explanation,
            detectable,
            left_out,
            because,
            action: String::new(),
        }
    }

    fn pool(&self, of: &[Deviation]) -> Option<PooledChange> {
        PooledChange::of(of, &self.errors, self.settings.parameters())
    }

    /// Each speed by itself, tested at this level.
    fn speeds(&self, level: f64) -> Vec<SpeedChange> {
        let test = |(model, deviation): &(&SpeedModel, Deviation)| {
            let alone = std::slice::from_ref(deviation);
            let pooled = self.pool(alone)?;
            Some(SpeedChange {
                thrust: model.thrust,
                surge_speed_m_s: model.surge_speed_m_s,
                effects: pooled.effects(alone, &self.errors),
                p_value: pooled.p_value(self.settings),
                level,
            })
        };
        self.compared.iter().filter_map(test).collect()
    }
}

/// The rate of false alarms, shared among the tests of n speeds.
struct Levels {
    of_speed: f64,
    of_all: f64,
}

impl Levels {
    fn of(rate: f64, n: usize) -> Self {
        match n {
            0 | 1 => Self { of_speed: rate, of_all: rate },
            n => Self { of_speed: 0.5 * rate / n as f64, of_all: 0.5 * rate },
        }
    }
}

/// `only_at`: the speeds at which it shows, where it does not show at all of them together.
fn changed_text(words: String, only_at: Option<&[&SpeedChange]>) -> String {
    let Some(speeds) = only_at else { return words };
    let at: Vec<String> = speeds.iter().map(|speed| speed.name()).collect();
    format!("not at all speeds alike, but at {}; over all of them {words}", at.join(", "))
}

fn not_changed(detectable: &Detectable) -> (Finding, String) {
    let words = detectable.words();
    if detectable.is_enough() {
        (
            Finding::Unchanged,
            format!("no change found; nine times in ten this test finds a change of {words}"),
        )
    } else {
        (
            Finding::CannotTell,
            format!("this test finds only a change of {words}: excite with more rudder, or longer"),
        )
    }
}

fn nothing_compared(left_out: &[String]) -> String {
    if left_out.is_empty() {
        "there is no model of now with an uncertainty".into()
    } else {
        left_out.join("; ")
    }
}

impl SpeedChange {
    /// `80 % thrust` or `1.63 m/s`
    pub fn name(&self) -> String {
        match (self.thrust, self.surge_speed_m_s) {
            (Some(thrust), _) => format!("{:.0} % thrust", 100.0 * thrust),
            (None, Some(speed)) => format!("{speed:.2} m/s"),
            (None, None) => "its speed".into(),
        }
    }
}
