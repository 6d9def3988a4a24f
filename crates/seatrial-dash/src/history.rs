//! Campaigns of the logbook: runs, comparisons, schedules, files.

use std::fmt::Display;

use seatrial::difference::{Difference as ModelDifference, ParameterDifference, ThrustDifference};
use seatrial::gain_allowance::{GainAllowance, least_damped_schedule};
use seatrial::health::{HealthSettings, Reference, SpeedModel, compare};
use seatrial::identification::Reader;
use seatrial::propagation::interval_95;
use seatrial::{Campaign, Run};
use seatrial_app::advice::addressed;
use seatrial_app::models::check_undamaged;
use seatrial_app::report::campaign_page;
use seatrial_core::schedule::{Beyond, ScheduleKey};
use seatrial_core::{
    GainSchedule, HeadingGain, HeadingLoop, SchedulePoint as ModelAt, Side, SpeedSchedule, Turn,
    YawModel,
};
use seatrial_logbook::{CampaignId, Logbook};
use seatrial_logs::{Estimate, Row, write_csv, write_mcap};

use crate::api::{
    CampaignDetail, CampaignSummary, Comparison, Difference, Figure, Model, OperatingPoint, Reason,
    Schedule, SchedulePoint, ThrustComparison, WhatChanged,
};
use crate::convert::run_summary;
use crate::refusal::Refusal;

/// The damping ratio that gains are designed for where none is asked for.
pub const DAMPING_RATIO: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// How often an unchanged vehicle is called changed: as `seatrial health`.
const FALSE_ALARM_RATE: f64 = 0.05;

const SIDES: [Side; 2] = [Side::Starboard, Side::Port];

/// A campaign with its runs.
pub fn detail(logbook: &Logbook, id: i64, running: Option<i64>) -> Result<CampaignDetail, Refusal> {
    let entry = logbook.entry(CampaignId(id))?;
    let campaign = logbook.campaign(entry.id)?;
    let reviews = logbook.reviews(entry.id)?;
    let whole = campaign.verdict();
    let review_of = |run: &Run| {
        let found = reviews.iter().find(|(number, _)| *number == run.number);
        found.map(|(_, review)| review.clone().into())
    };
    Ok(CampaignDetail {
        plan: entry.plan.clone(),
        verdict: (&whole).into(),
        runs: campaign
            .runs
            .iter()
            .map(|run| run_summary(run, Some(&whole), review_of(run)))
            .collect(),
        counting_runs: campaign
            .accepted_runs()
            .iter()
            .map(|run| run.number)
            .collect(),
        campaign: CampaignSummary::of(entry, running),
    })
}

/// Two campaigns side by side.
pub fn comparison(
    logbook: &Logbook,
    [a, b]: [i64; 2],
    running: Option<i64>,
) -> Result<Comparison, Refusal> {
    let (a_entry, b_entry) = (logbook.entry(CampaignId(a))?, logbook.entry(CampaignId(b))?);
    let (a, b) = (logbook.campaign(a_entry.id)?, logbook.campaign(b_entry.id)?);
    let difference = ModelDifference::between(&a, &b);
    let thrusts = difference.thrusts.iter();
    Ok(Comparison {
        thrusts: thrusts.map(|at| at_thrust(at, [&a, &b])).collect(),
        what_changed: what_changed(&a, &b),
        a: CampaignSummary::of(a_entry, running),
        b: CampaignSummary::of(b_entry, running),
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
        let limit_rad = campaigns[k].rudder_limit_rad;
        Some(Identified::of(runs[k]?)?.point(DAMPING_RATIO, limit_rad))
    });
    if let [Some(a), Some(b)] = points {
        differences.extend(of_points(&a, &b));
    }
    ThrustComparison {
        thrust: at.thrust,
        surge_speed_m_s: at.surge_speed_m_s,
        differences,
    }
}

/// The parameters of two models.
fn of_models(at: &ThrustDifference, a: &Model, b: &Model) -> Vec<Difference> {
    let parameters = [
        (
            "a22_per_s",
            Some(&at.a22_per_s),
            Some(a.a22_per_s),
            Some(b.a22_per_s),
        ),
        (
            "b2_per_s2",
            Some(&at.b2_per_s2),
            Some(a.b2_per_s2),
            Some(b.b2_per_s2),
        ),
        (
            "c0_rad_per_s2",
            Some(&at.c0_rad_per_s2),
            Some(a.c0_rad_per_s2),
            Some(b.c0_rad_per_s2),
        ),
        (
            "delta0_rad",
            at.delta0_rad.as_ref(),
            a.delta0_rad,
            b.delta0_rad,
        ),
    ];
    let parameter = |(quantity, of, a, b): (&str, Option<&ParameterDifference>, _, _)| {
        let of = of?;
        Some(Difference {
            quantity: quantity.into(),
            a: a?,
            b: b?,
            difference: of.difference,
            ratio: of.ratio,
        })
    };
    parameters.into_iter().filter_map(parameter).collect()
}

/// The gain and the turning circles that follow from two models.
fn of_points(a: &OperatingPoint, b: &OperatingPoint) -> Vec<Difference> {
    let [a_starboard, a_port] = a.steady_turning_radius_m;
    let [b_starboard, b_port] = b.steady_turning_radius_m;
    let quantities = [
        (
            "proportional_gain",
            a.proportional_gain,
            b.proportional_gain,
        ),
        (
            "steady_turning_radius_starboard_m",
            a_starboard,
            b_starboard,
        ),
        ("steady_turning_radius_port_m", a_port, b_port),
    ];
    let quantities = quantities.into_iter();
    quantities
        .filter_map(|(quantity, a, b)| Some(between(quantity, a?, b?)))
        .collect()
}

/// The difference of two independent figures in units of their combined interval.
fn between(quantity: &str, a: Figure, b: Figure) -> Difference {
    let half_width = |[low, high]: [f64; 2]| (high - low) / 2.0;
    let combined = a
        .interval_95
        .zip(b.interval_95)
        .map(|(a, b)| half_width(a).hypot(half_width(b)));
    let difference = b.value - a.value;
    Difference {
        quantity: quantity.into(),
        a,
        b,
        difference,
        ratio: combined
            .map(|combined| difference / combined)
            .filter(|ratio| ratio.is_finite()),
    }
}

fn what_changed(a: &Campaign, b: &Campaign) -> Option<WhatChanged> {
    let models = |campaign: &Campaign| -> Vec<SpeedModel> {
        let runs = campaign.accepted_runs();
        let model = |run: &Run| {
            SpeedModel::of(
                run.identification.as_ref()?,
                Some(run.thrust),
                run.surge_speed_m_s,
            )
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
    let mut reasons: Vec<Reason> = change
        .verdict
        .reasons
        .into_iter()
        .map(Reason::from)
        .collect();
    reasons.extend(change.left_out.into_iter().map(|text| Reason {
        code: "left_out".into(),
        text: addressed(&text, Reader::Dashboard),
        action: String::new(),
    }));
    Some(WhatChanged {
        changed: match change.finding {
            seatrial::health::Finding::Changed => Some(true),
            seatrial::health::Finding::Unchanged => Some(false),
            seatrial::health::Finding::CannotTell => None,
        },
        reasons,
    })
}

/// A model of a run with its uncertainty.
struct Identified {
    at: ModelAt<f64>,
    allowance: GainAllowance,
    covariance: Option<[[f64; 3]; 3]>,
}

impl Identified {
    fn of(run: &Run) -> Option<Self> {
        let identification = run.identification.as_ref()?;
        Some(Self {
            at: ModelAt {
                thrust: Some(run.thrust),
                surge_speed_m_s: run.surge_speed_m_s,
                model: identification.model(),
            },
            allowance: GainAllowance::of(identification),
            covariance: identification
                .refined
                .as_ref()
                .map(|refined| refined.covariance),
        })
    }

    fn figure(&self, quantity: impl Fn(&YawModel<f64>) -> Option<f64>) -> Option<Figure> {
        Some(Figure {
            value: quantity(&self.at.model)?,
            interval_95: self
                .covariance
                .and_then(|covariance| interval_95(&self.at.model, &covariance, &quantity)),
        })
    }

    /// Gains, margins and turning limits of the model, with the gain that is designed for it.
    fn point(&self, damping_ratio: f64, rudder_limit_rad: f64) -> OperatingPoint {
        let gain = self.allowance.design(&self.at.model, damping_ratio);
        let mut point = self.with_gain(gain.as_ref().ok(), rudder_limit_rad);
        point.no_gain = gain.err().map(|reason| reason.to_string());
        point.proportional_gain = self.figure(|model| {
            let gain = self.allowance.design(model, damping_ratio).ok()?;
            Some(gain.proportional_gain)
        });
        point
    }

    fn with_gain(&self, gain: Option<&HeadingGain<f64>>, rudder_limit_rad: f64) -> OperatingPoint {
        let model = &self.at.model;
        let closed = gain.and_then(|gain| HeadingLoop::new(model, gain.proportional_gain).ok());
        let margins = closed.and_then(|closed| closed.margins(self.allowance.timing).ok());
        let turn = |model: &YawModel<f64>, side| Turn::new(model, rudder_limit_rad, side).ok();
        OperatingPoint {
            surge_speed_m_s: self.at.surge_speed_m_s,
            extrapolated: false,
            a22_per_s: model.a22_per_s,
            b2_per_s2: model.b2_per_s2,
            c0_rad_per_s2: model.c0_rad_per_s2,
            no_gain: None,
            proportional_gain: gain.map(|gain| Figure {
                value: gain.proportional_gain,
                interval_95: None,
            }),
            feed_forward_rudder_rad: gain.map(|gain| gain.feed_forward_rudder_rad),
            natural_frequency_rad_s: closed.map(|closed| closed.natural_frequency_rad_s()),
            overshoot: closed.map(|closed| closed.overshoot()),
            gain_margin: margins.and_then(|margins| margins.gain_margin),
            phase_margin_rad: margins.and_then(|margins| margins.phase_margin_rad),
            delay_margin_s: margins.and_then(|margins| margins.delay_margin_s),
            yaw_rate_limit_rad_s: SIDES
                .map(|side| self.figure(|model| Some(turn(model, side)?.yaw_rate_rad_s))),
            steady_turning_radius_m: SIDES.map(|side| {
                let speed = self.at.surge_speed_m_s?;
                self.figure(|model| Some(turn(model, side)?.steady_turning_radius_m(speed)))
            }),
            u_turn_time_s: SIDES.map(|side| Some(turn(model, side)?.u_turn_time_s())),
        }
    }
}

/// The models of a campaign over speed, and what follows at one speed.
pub fn schedule(
    logbook: &Logbook,
    id: i64,
    speed_m_s: Option<f64>,
    damping_ratio: f64,
) -> Result<Schedule, Refusal> {
    check_undamaged(logbook).map_err(|error| Refusal::unprocessable("no_model", error))?;
    let campaign = logbook.campaign(CampaignId(id))?;
    let limit = campaign.rudder_limit_rad;
    let mut points: Vec<(u32, f64, Model, Identified)> = campaign
        .accepted_runs()
        .into_iter()
        .filter_map(|run| {
            let model = Model::from(run.identification.as_ref()?);
            Some((run.number, run.thrust, model, Identified::of(run)?))
        })
        .collect();
    let speed = |point: &(u32, f64, Model, Identified)| point.3.at.surge_speed_m_s;
    if points.iter().all(|point| speed(point).is_some()) {
        points.sort_by(|a, b| {
            speed(a)
                .partial_cmp(&speed(b))
                .unwrap_or(std::cmp::Ordering::Equal)
        });
    }
    let speeds: Option<Vec<f64>> = points.iter().map(speed).collect();
    let at = speed_m_s
        .map(|speed_m_s| {
            let identified: Vec<_> = points.iter().map(|(.., identified)| identified).collect();
            at_speed(&identified, speed_m_s, damping_ratio, limit)
        })
        .transpose()?;
    Ok(Schedule {
        campaign: id,
        damping_ratio,
        rudder_limit_rad: limit,
        speed_range_m_s: speeds.and_then(|speeds| Some([*speeds.first()?, *speeds.last()?])),
        points: points
            .into_iter()
            .map(|(run, thrust, model, identified)| SchedulePoint {
                run,
                thrust,
                model,
                point: identified.point(damping_ratio, limit),
            })
            .collect(),
        at,
    })
}

fn at_speed(
    identified: &[&Identified],
    speed_m_s: f64,
    damping_ratio: f64,
    rudder_limit_rad: f64,
) -> Result<OperatingPoint, Refusal> {
    let refused = |error: &dyn Display| Refusal::unprocessable("no_schedule", error);
    let models: Vec<_> = identified.iter().map(|i| i.at).collect();
    let found = SpeedSchedule::new(ScheduleKey::Speed, &models)
        .and_then(|schedule| schedule.lookup(speed_m_s, Beyond::Extrapolate))
        .map_err(|e| refused(&e))?;
    let allowed = identified.iter().map(|i| (i.at, i.allowance));
    let (cautious, timing) =
        least_damped_schedule(ScheduleKey::Speed, allowed).map_err(|e| refused(&e))?;
    let gain = GainSchedule::design(cautious, damping_ratio, timing)
        .map_err(|e| e.to_string())
        .and_then(|gains| {
            let gain = gains.lookup(speed_m_s, Beyond::Extrapolate);
            gain.map(|gain| *gain.value()).map_err(|e| e.to_string())
        });
    let here = Identified {
        at: *found.value(),
        allowance: GainAllowance {
            damping_per_s: 0.0,
            timing,
        },
        covariance: None,
    };
    Ok(OperatingPoint {
        surge_speed_m_s: Some(speed_m_s),
        extrapolated: found.is_extrapolated(),
        no_gain: gain.as_ref().err().cloned(),
        ..here.with_gain(gain.as_ref().ok(), rudder_limit_rad)
    })
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
