//! Campaigns of the logbook: runs, comparisons, schedules, files.

use seatrial::campaign::speeds::{Difference as ModelDifference, ThrustDifference};
use seatrial::gains::DAMPING_RATIO;
use seatrial::health::{Finding, HealthSettings, Reference, SpeedModel, compare};
use seatrial::{Campaign, Run};
use seatrial_app::Error;
use seatrial_app::gains::{LoopFigures, LoopRequirements};
use seatrial_app::models::{ModelPoint, Models};
use seatrial_app::trials::{campaign_models::check_undamaged, campaign_page::campaign_page};
use seatrial_app::turning::TurningLimits;
use seatrial_core::YawModel;
use seatrial_core::schedule::{Beyond, ScheduleKey};
use seatrial_logbook::{CampaignId, Logbook};
use seatrial_logs::{Estimate, Row, write_csv, write_mcap};

use crate::api::{
    CampaignDetail, CampaignSummary, Comparison, Difference, Figure, Model, OperatingPoint, Reason,
    Schedule, SchedulePoint, ThrustComparison, WhatChanged,
};
use crate::convert::{run_summary, verdict_with_promises};
use crate::refusal::Refusal;

/// How often an unchanged vehicle is called changed: as `seatrial health`.
const FALSE_ALARM_RATE: f64 = 0.05;

/// The heading change whose time the turning limits give, rad; no document has it.
const HEADING_CHANGE_RAD: f64 = std::f64::consts::PI;

/// Every campaign, oldest first.
pub fn list(logbook: &Logbook, running: Option<i64>) -> Result<Vec<CampaignSummary>, Refusal> {
    let entries = logbook.campaigns()?.into_iter();
    let summaries = entries.map(|entry| {
        // One that cannot be read does not hide the others.
        let whole = logbook.campaign_of(&entry).map(|found| found.verdict());
        CampaignSummary::of(entry, running, whole.ok().as_ref())
    });
    Ok(summaries.collect())
}

/// A campaign with its runs.
pub fn detail(logbook: &Logbook, id: i64, running: Option<i64>) -> Result<CampaignDetail, Refusal> {
    let entry = logbook.entry(CampaignId(id))?;
    let campaign = logbook.campaign_of(&entry)?;
    let reviews = logbook.reviews(entry.id)?;
    let whole = campaign.verdict();
    let review_of = |run: &Run| {
        let found = reviews.iter().find(|(number, _)| *number == run.number);
        found.map(|(_, review)| review.clone().into())
    };
    Ok(CampaignDetail {
        plan: entry.plan.clone(),
        verdict: verdict_with_promises(&campaign, &whole),
        reasons: whole.reasons.iter().cloned().map(Reason::from).collect(),
        runs: campaign
            .runs
            .iter()
            .map(|run| run_summary(run, Some(&whole), review_of(run)))
            .collect(),
        counting_runs: campaign.accepted_runs().iter().map(|run| run.number).collect(),
        campaign: CampaignSummary::of(entry, running, Some(&whole)),
    })
}

/// Two campaigns side by side.
pub fn comparison(
    logbook: &Logbook,
    [a, b]: [i64; 2],
    running: Option<i64>,
) -> Result<Comparison, Refusal> {
    let (a_entry, b_entry) = (logbook.entry(CampaignId(a))?, logbook.entry(CampaignId(b))?);
    let (a, b) = (logbook.campaign_of(&a_entry)?, logbook.campaign_of(&b_entry)?);
    let difference = ModelDifference::between(&a, &b);
    let thrusts = difference.thrusts.iter();
    Ok(Comparison {
        thrusts: thrusts.map(|at| at_thrust(at, [&a, &b])).collect(),
        what_changed: what_changed(&a, &b),
        a: CampaignSummary::of(a_entry, running, Some(&a.verdict())),
        b: CampaignSummary::of(b_entry, running, Some(&b.verdict())),
        only_in_a: difference.only_in_a,
        only_in_b: difference.only_in_b,
    })
}

/// Both models at one thrust, and what follows from them.
fn at_thrust(at: &ThrustDifference, campaigns: [&Campaign; 2]) -> ThrustComparison {
    let runs = campaigns.map(|campaign| {
        let mut runs = campaign.accepted_runs().into_iter();
        runs.find(|run| run.thrust == at.thrust)
    });
    let models = runs.map(|run| Some(Model::from(run?.identification.as_ref()?)));
    let mut differences = match &models {
        [Some(a), Some(b)] => of_models(at, a, b),
        _ => Vec::new(),
    };
    let points = [0, 1].map(|k| {
        let mut models = models_of(campaigns[k])?;
        models.points.retain(|of| of.point.thrust == Some(at.thrust));
        points(&models, DAMPING_RATIO).ok()?.pop()
    });
    if let [Some(a), Some(b)] = points {
        differences.extend(of_points(&a, &b));
    }
    ThrustComparison { thrust: at.thrust, surge_speed_m_s: at.surge_speed_m_s, differences }
}

/// The parameters of two models.
fn of_models(at: &ThrustDifference, a: &Model, b: &Model) -> Vec<Difference> {
    let figures = |of: &Model| {
        let known = [of.a22_per_s, of.b2_per_s2, of.c0_rad_per_s2].map(Some);
        known.into_iter().chain([of.delta0_rad]).flatten()
    };
    let names = ["a22_per_s", "b2_per_s2", "c0_rad_per_s2", "delta0_rad"];
    let parameters = names.into_iter().zip(at.parameters());
    parameters
        .zip(figures(a).zip(figures(b)))
        .map(|((quantity, (_, of)), (a, b))| Difference {
            quantity: quantity.into(),
            a,
            b,
            difference: of.difference,
            ratio: of.ratio,
        })
        .collect()
}

/// The gain and the turning circles that follow from two models.
fn of_points(a: &OperatingPoint, b: &OperatingPoint) -> Vec<Difference> {
    let [a_starboard, a_port] = a.steady_turning_radius_m;
    let [b_starboard, b_port] = b.steady_turning_radius_m;
    let quantities = [
        ("proportional_gain", a.proportional_gain, b.proportional_gain),
        ("steady_turning_radius_starboard_m", a_starboard, b_starboard),
        ("steady_turning_radius_port_m", a_port, b_port),
    ];
    let quantities = quantities.into_iter();
    quantities.filter_map(|(quantity, a, b)| Some(between(quantity, a?, b?))).collect()
}

/// The difference of two independent figures in units of their combined interval.
fn between(quantity: &str, a: Figure, b: Figure) -> Difference {
    let half_width = |[low, high]: [f64; 2]| (high - low) / 2.0;
    let combined =
        a.interval_95.zip(b.interval_95).map(|(a, b)| half_width(a).hypot(half_width(b)));
    let difference = b.value - a.value;
    Difference {
        quantity: quantity.into(),
        a,
        b,
        difference,
        ratio: combined.map(|combined| difference / combined).filter(|ratio| ratio.is_finite()),
    }
}

fn what_changed(a: &Campaign, b: &Campaign) -> Option<WhatChanged> {
    let models = |campaign: &Campaign| -> Vec<SpeedModel> {
        let runs = campaign.accepted_runs();
        let model = |run: &Run| {
            SpeedModel::of(run.identification.as_ref()?, Some(run.thrust), run.surge_speed_m_s)
        };
        runs.into_iter().filter_map(model).collect()
    };
    let reference = Reference::new(models(a)).ok()?;
    let now = models(b);
    if now.is_empty() {
        return None;
    }
    let settings = HealthSettings::new(FALSE_ALARM_RATE, 0.0, true).ok()?;
    let change = compare(&reference, &now, &settings);
    let reason = |code: &str, text: &str| Reason {
        code: code.into(),
        of: None,
        text: text.into(),
        action: String::new(),
    };
    let because = reason(&change.finding.to_string(), &change.because);
    let left_out = change.left_out.iter();
    let left_out = left_out.map(|text| reason("left_out", text));
    Some(WhatChanged {
        changed: match change.finding {
            Finding::CannotTell => None,
            found => Some(found == Finding::Changed),
        },
        reasons: [because].into_iter().chain(left_out).collect(),
    })
}

/// The models of the accepted runs; none where no run was accepted.
fn models_of(campaign: &Campaign) -> Option<Models> {
    Models::of_trial("campaign".into(), campaign).ok()
}

/// Gains, margins and turning limits of each model.
fn points(models: &Models, damping_ratio: f64) -> Result<Vec<OperatingPoint>, Error> {
    let wanted = LoopRequirements { damping_ratio, ..LoopRequirements::default() };
    let limits = TurningLimits::of(models, HEADING_CHANGE_RAD, None, None)?;
    let with_gain = wanted.gains(models)?.points.into_iter().zip(limits_of(limits));
    Ok(with_gain
        .map(|(gains, limits)| OperatingPoint {
            surge_speed_m_s: gains.surge_speed_m_s,
            no_gain: gains.refused,
            proportional_gain: gains.proportional_gain,
            feed_forward_rudder_rad: gains.feed_forward_rudder_rad.map(|rudder| rudder.value),
            ..with_loop(limits, gains.closed_loop)
        })
        .collect())
}

/// Turning limits of each model, with the model and without gains.
fn limits_of(limits: TurningLimits) -> impl Iterator<Item = OperatingPoint> {
    limits.points.into_iter().map(|limits| {
        let YawModel { a22_per_s, b2_per_s2, c0_rad_per_s2 } = limits.model;
        let [starboard, port] = &limits.sides;
        let sides = [starboard, port];
        OperatingPoint {
            surge_speed_m_s: limits.surge_speed_m_s,
            a22_per_s,
            b2_per_s2,
            c0_rad_per_s2,
            yaw_rate_limit_rad_s: sides.map(|side| side.yaw_rate_rad_s),
            steady_turning_radius_m: sides.map(|side| side.steady_turning_radius_m),
            u_turn_time_s: sides.map(|side| Some(side.u_turn_time_s?.value)),
            ..OperatingPoint::default()
        }
    })
}

fn with_loop(point: OperatingPoint, closed: Option<LoopFigures>) -> OperatingPoint {
    let of = |figure: fn(&LoopFigures) -> Option<Figure>| {
        closed.as_ref().and_then(figure).map(|figure| figure.value)
    };
    OperatingPoint {
        natural_frequency_rad_s: of(|closed| closed.natural_frequency_rad_s),
        overshoot: of(|closed| closed.overshoot),
        gain_margin: of(|closed| closed.gain_margin),
        phase_margin_rad: of(|closed| closed.phase_margin_rad),
        delay_margin_s: of(|closed| closed.delay_margin_s),
        ..point
    }
}

/// The models of a campaign over speed, and what follows at one speed.
pub fn schedule(
    logbook: &Logbook,
    id: i64,
    speed_m_s: Option<f64>,
    damping_ratio: f64,
) -> Result<Schedule, Refusal> {
    let refused = |error: Error| Refusal::unprocessable("no_model", error);
    check_undamaged(logbook).map_err(refused)?;
    let campaign = logbook.campaign(CampaignId(id))?;
    let runs: Vec<(&Run, Model)> = campaign
        .accepted_runs()
        .into_iter()
        .filter_map(|run| Some((run, run.identification.as_ref()?.into())))
        .collect();
    let speeds: Option<Vec<f64>> = runs.iter().map(|(run, _)| run.surge_speed_m_s).collect();
    let slowest_and_fastest = |speeds: Vec<f64>| {
        let slowest = speeds.iter().copied().reduce(f64::min)?;
        Some([slowest, speeds.into_iter().reduce(f64::max)?])
    };
    let models = models_of(&campaign);
    let found = models.as_ref().map(|models| points(models, damping_ratio));
    let found = found.transpose().map_err(refused)?.unwrap_or_default();
    let at = models
        .zip(speed_m_s)
        .map(|(models, speed_m_s)| at_speed(&models, speed_m_s, damping_ratio));
    Ok(Schedule {
        campaign: id,
        damping_ratio,
        rudder_limit_rad: campaign.rudder_limit_rad,
        speed_range_m_s: speeds.and_then(slowest_and_fastest),
        points: runs
            .into_iter()
            .zip(found)
            .map(|((run, model), point)| SchedulePoint {
                run: run.number,
                thrust: run.thrust,
                model,
                point,
            })
            .collect(),
        at: at.transpose().map_err(|error| Refusal::unprocessable("no_schedule", error))?,
    })
}

/// Between the models, and beyond them. Where a gain cannot be designed the point says why.
fn at_speed(models: &Models, speed_m_s: f64, damping_ratio: f64) -> Result<OperatingPoint, Error> {
    let schedule = models.schedule(ScheduleKey::Speed)?;
    let found = schedule.lookup(speed_m_s, Beyond::Extrapolate);
    let found = found.map_err(|error| Error::Input(error.to_string()))?;
    let mut here = models.clone();
    here.points = vec![ModelPoint::exact(*found.value())];
    let limits = TurningLimits::of(&here, HEADING_CHANGE_RAD, None, None)?;
    let wanted = LoopRequirements {
        damping_ratio,
        at: Some((ScheduleKey::Speed, speed_m_s)),
        beyond: Beyond::Extrapolate,
        ..LoopRequirements::default()
    };
    let gain = wanted.gains(models).map(|gains| gains.at);
    let no_gain = gain.as_ref().err().map(Error::to_string);
    let gain = gain.ok().flatten();
    let point = OperatingPoint {
        surge_speed_m_s: Some(speed_m_s),
        extrapolated: found.is_extrapolated(),
        no_gain,
        proportional_gain: gain.as_ref().map(|gain| gain.proportional_gain),
        feed_forward_rudder_rad: gain.as_ref().map(|gain| gain.feed_forward_rudder_rad),
        ..limits_of(limits).next().unwrap_or_default()
    };
    Ok(with_loop(point, gain.and_then(|gain| gain.closed_loop)))
}

/// The report of a campaign, HTML.
pub fn report(logbook: &Logbook, id: i64) -> Result<String, Refusal> {
    let entry = logbook.entry(CampaignId(id))?;
    Ok(campaign_page(logbook, &entry)?)
}

/// Formats of a campaign's samples.
#[derive(Clone, Copy)]
pub enum Format {
    /// The format that `seatrial trial --record FILE.csv` writes.
    Csv,
    /// Which Foxglove opens.
    Mcap,
}

/// The samples of a campaign. Of one that is damaged none are given: away from their logbook nothing would say so.
pub fn samples(logbook: &Logbook, id: i64, format: Format) -> Result<Vec<u8>, Refusal> {
    let entry = logbook.entry(CampaignId(id))?;
    if let Some(damage) = &entry.damage {
        let refused = format!(
            "campaign {id} is damaged, and its samples are not given: {}: {}",
            damage.place, damage.found
        );
        return Err(Refusal::unprocessable("damaged", refused));
    }
    let steps = logbook.steps(entry.id)?;
    let rows: Vec<Row> = steps
        .into_iter()
        .map(|(_, step)| Row {
            sample: step.sample,
            stage: step.stage,
            estimate: step.estimate.map(|model| Estimate {
                model,
                half_widths: None,
                step_norm: f64::NAN,
            }),
        })
        .collect();
    let mut file = std::io::Cursor::new(Vec::new());
    match format {
        Format::Csv => write_csv(&mut file, &rows),
        Format::Mcap => write_mcap(&mut file, &rows),
    }
    .map_err(|error| Refusal::unprocessable("not_written", error))?;
    Ok(file.into_inner())
}
