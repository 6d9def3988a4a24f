//! Campaigns of the logbook.

use std::sync::Arc;

use axum::extract::State;
use axum::response::Response;
use axum::{Extension, Json};
use seatrial::gains::DAMPING_RATIO;
use seatrial_core::Stage;
use seatrial_logbook::CampaignId;
use serde::{Deserialize, Serialize};

use super::extract::{At, Body, FromQuery};
use super::{blocking, download};
#[cfg(feature = "openapi")]
use crate::api::ErrorBody;
use crate::api::{CampaignDetail, CampaignSummary, Comparison, ReviewOrder, RunSummary, Schedule};
use crate::history::{self, Format};
use crate::refusal::Refusal;
use crate::server_state::{Caller, LONGEST_NOTE, ServerState};
use seatrial_app::series::{LogSeries, series_of};

/// Every campaign, oldest first.
#[cfg_attr(feature = "openapi", utoipa::path(get, path = "/api/v1/campaigns", tag = "history",
    responses((status = 200, body = [CampaignSummary]), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn campaigns(
    State(shared): State<Arc<ServerState>>,
) -> Result<Json<Vec<CampaignSummary>>, Refusal> {
    let campaigns =
        blocking(shared, |shared| history::list(&shared.reader()?, shared.slot.campaign()));
    Ok(Json(campaigns.await?))
}

/// One campaign with its runs.
#[cfg_attr(feature = "openapi", utoipa::path(get, path = "/api/v1/campaigns/{id}", tag = "history",
    params(("id" = i64, Path, description = "Number of the campaign")),
    responses((status = 200, body = CampaignDetail), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn campaign(
    State(shared): State<Arc<ServerState>>,
    At(id): At<i64>,
) -> Result<Json<CampaignDetail>, Refusal> {
    let detail = blocking(shared, move |shared| {
        let running = shared.slot.campaign();
        history::detail(&shared.reader()?, id, running)
    });
    Ok(Json(detail.await?))
}

/// Accepts or rejects a run; the decision goes before the program's verdict wherever the run is used.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/campaigns/{id}/runs/{run}/review", tag = "history", request_body = ReviewOrder,
    params(("id" = i64, Path, description = "Number of the campaign"), ("run" = u32, Path, description = "Number of the run"),
        ("seatrial-lease" = Option<String>, Header, description = "The lease of control")),
    responses((status = 200, body = RunSummary), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn review(
    State(shared): State<Arc<ServerState>>,
    Extension(caller): Extension<Caller>,
    At((id, run)): At<(i64, u32)>,
    Body(order): Body<ReviewOrder>,
) -> Result<Json<RunSummary>, Refusal> {
    let reviewed = blocking(shared, move |shared| {
        #[derive(Serialize)]
        struct ReviewDetails<'a> {
            campaign: i64,
            run: u32,
            #[serde(flatten)]
            order: &'a ReviewOrder,
        }
        let details = ReviewDetails { campaign: id, run, order: &order };
        let entered = shared.command(&caller, "review_run", &details, |name| {
            let note = order.note.trim();
            if note.is_empty() || note.chars().count() > LONGEST_NOTE {
                let expected = "note: expected 1 to 4000 characters";
                return Err(Refusal::unprocessable("out_of_range", expected));
            }
            let mut writer = shared.writer.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            let entered = writer.review(CampaignId(id), run, order.accepted, note, name)?;
            entered.ok_or_else(|| {
                Refusal::unprocessable(
                    "not_reviewable",
                    format!("campaign {id} has no finished run {run}, or it has no model that could be accepted"),
                )
            })
        });
        entered?;
        let detail = history::detail(&shared.reader()?, id, shared.slot.campaign())?;
        let found = detail.runs.into_iter().find(|found| found.number == run);
        found.ok_or_else(|| Refusal::not_found(format!("campaign {id} has no run {run}")))
    });
    Ok(Json(reviewed.await?))
}

/// The samples of a run, with the simulation over its validation stage.
#[cfg_attr(feature = "openapi", utoipa::path(get, path = "/api/v1/campaigns/{id}/runs/{run}/series", tag = "history",
    params(("id" = i64, Path, description = "Number of the campaign"), ("run" = u32, Path, description = "Number of the run")),
    responses((status = 200, body = LogSeries), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn series(
    State(shared): State<Arc<ServerState>>,
    At((id, run)): At<(i64, u32)>,
) -> Result<Json<LogSeries>, Refusal> {
    let series = blocking(shared, move |shared| {
        let campaign = shared.reader()?.campaign(CampaignId(id))?;
        let run = campaign.runs.iter().find(|found| found.number == run).ok_or_else(|| {
            Refusal::not_found(format!(
                "campaign {id} has no run {run}; it has {}",
                campaign.runs.len()
            ))
        })?;
        let model = run.identification.as_ref();
        Ok(series_of(&run.acting_record(), model.zip(run.stage(Stage::Validate))))
    });
    Ok(Json(series.await?))
}

/// Where in a schedule.
#[derive(Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::IntoParams))]
#[cfg_attr(feature = "openapi", into_params(parameter_in = Query))]
pub struct Place {
    /// Gains and limits at this speed, m/s.
    speed_m_s: Option<f64>,
    /// Damping ratio of the closed loop [default: 0.7071].
    #[cfg_attr(feature = "openapi", param(exclusive_minimum = 0.0, maximum = 10.0))]
    damping_ratio: Option<f64>,
}

/// The models of a campaign over speed: gains, margins and turning limits.
#[cfg_attr(feature = "openapi", utoipa::path(get, path = "/api/v1/campaigns/{id}/schedule", tag = "history",
    params(("id" = i64, Path, description = "Number of the campaign"), Place),
    responses((status = 200, body = Schedule), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn schedule(
    State(shared): State<Arc<ServerState>>,
    At(id): At<i64>,
    FromQuery(place): FromQuery<Place>,
) -> Result<Json<Schedule>, Refusal> {
    let damping_ratio = place.damping_ratio.unwrap_or(DAMPING_RATIO);
    if !(damping_ratio > 0.0 && damping_ratio <= 10.0) {
        return Err(Refusal::unprocessable(
            "out_of_range",
            "damping_ratio: expected a number above 0 and at most 10",
        ));
    }
    let schedule = blocking(shared, move |shared| {
        history::schedule(&shared.reader()?, id, place.speed_m_s, damping_ratio)
    });
    Ok(Json(schedule.await?))
}

/// The report of a campaign.
#[cfg_attr(feature = "openapi", utoipa::path(get, path = "/api/v1/campaigns/{id}/report.html", tag = "downloads",
    params(("id" = i64, Path, description = "Number of the campaign")),
    responses((status = 200, description = "A page that needs nothing else", body = String, content_type = "text/html"),
        (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn report(
    State(shared): State<Arc<ServerState>>,
    At(id): At<i64>,
) -> Result<Response, Refusal> {
    let page = blocking(shared, move |shared| history::report(&shared.reader()?, id)).await?;
    Ok(download("text/html; charset=utf-8", &format!("campaign-{id}.html"), page))
}

/// The samples of a campaign as CSV.
#[cfg_attr(feature = "openapi", utoipa::path(get, path = "/api/v1/campaigns/{id}/samples.csv", tag = "downloads",
    params(("id" = i64, Path, description = "Number of the campaign")),
    responses((status = 200, description = "As `trial --record FILE.csv` writes it", body = String, content_type = "text/csv"),
        (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn csv(
    State(shared): State<Arc<ServerState>>,
    At(id): At<i64>,
) -> Result<Response, Refusal> {
    let file = blocking(shared, move |shared| history::samples(&shared.reader()?, id, Format::Csv));
    Ok(download("text/csv; charset=utf-8", &format!("campaign-{id}.csv"), file.await?))
}

/// The samples of a campaign as MCAP.
#[cfg_attr(feature = "openapi", utoipa::path(get, path = "/api/v1/campaigns/{id}/samples.mcap", tag = "downloads",
    params(("id" = i64, Path, description = "Number of the campaign")),
    responses((status = 200, description = "As `trial --record FILE.mcap` writes it", body = Vec<u8>, content_type = "application/octet-stream"),
        (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn mcap(
    State(shared): State<Arc<ServerState>>,
    At(id): At<i64>,
) -> Result<Response, Refusal> {
    let file =
        blocking(shared, move |shared| history::samples(&shared.reader()?, id, Format::Mcap));
    Ok(download("application/octet-stream", &format!("campaign-{id}.mcap"), file.await?))
}

/// Two campaigns.
#[derive(Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::IntoParams))]
#[cfg_attr(feature = "openapi", into_params(parameter_in = Query))]
pub struct Pair {
    /// Number of the first.
    a: i64,
    /// Number of the second.
    b: i64,
}

/// Two campaigns side by side: parameters with intervals, gains, turning limits, what changed.
#[cfg_attr(feature = "openapi", utoipa::path(get, path = "/api/v1/compare", tag = "history", params(Pair),
    responses((status = 200, body = Comparison), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn compare(
    State(shared): State<Arc<ServerState>>,
    FromQuery(Pair { a, b }): FromQuery<Pair>,
) -> Result<Json<Comparison>, Refusal> {
    let comparison = blocking(shared, move |shared| {
        let running = shared.slot.campaign();
        history::comparison(&shared.reader()?, [a, b], running)
    });
    Ok(Json(comparison.await?))
}
