//! The OpenAPI document made from the routes and their types.

use utoipa::OpenApi;

use super::{commission, control, history, logs, models, trial};
use crate::api;

/// The OpenAPI document.
#[derive(OpenApi)]
#[openapi(
    info(
        title = "seatrial",
        description = "Watch, command and look up sea trials. Quantities are SI, angles radians; missing things are null. \
Where a token is needed it goes into `Authorization: Bearer TOKEN`. Commands need control: take it with POST /api/v1/control \
and send its lease in the header `seatrial-lease`; aborting a trial needs none.",
        license(name = "MIT OR Apache-2.0")
    ),
    paths(
        control::status,
        control::openapi,
        control::take,
        control::release,
        control::audit,
        control::live,
        trial::vehicles,
        trial::default_plan,
        trial::preview,
        trial::preflight,
        trial::start,
        trial::abort,
        trial::repeat,
        trial::go_on,
        commission::preview_commission,
        commission::start_commission,
        commission::commission_state,
        commission::preview_undo,
        commission::undo_commission,
        history::campaigns,
        history::campaign,
        history::review,
        history::schedule,
        history::series,
        history::report,
        history::csv,
        history::mcap,
        models::param,
        models::gains,
        models::campaign_limits,
        models::campaign_file,
        models::model_limits,
        models::model_file,
        history::compare,
        logs::identify,
        logs::inspect,
        logs::report_log,
        logs::track,
        logs::columns,
        logs::sensor_list,
    ),
    components(schemas(api::Hello, api::LiveMessage))
)]
struct Api;

/// The OpenAPI document as the types and routes make it, pretty JSON.
pub fn openapi_of_types() -> String {
    Api::openapi().to_pretty_json().expect("the document is made of plain data") + "\n"
}
