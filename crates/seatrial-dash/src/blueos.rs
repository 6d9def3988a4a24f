//! What BlueOS asks every service on a vehicle, to list it in its own menu.

use axum::Json;
use serde::Serialize;

/// BlueOS asks this path of each open port, without a token.
pub const PATH: &str = "/register_service";

const REPOSITORY: &str = env!("CARGO_PKG_REPOSITORY");

/// The fields that BlueOS's helper reads; those without an `Option` there are all needed.
#[derive(Serialize)]
pub struct Service {
    name: &'static str,
    description: &'static str,
    /// A name of Material Design Icons.
    icon: &'static str,
    company: &'static str,
    version: &'static str,
    webpage: &'static str,
    /// Where the programming interface is described.
    api: String,
    /// The menu opens the page by its port in a tab of its own: our pages refuse to be shown in a frame, where another page
    /// could be laid over the buttons.
    avoid_iframes: bool,
}

pub async fn register_service() -> Json<Service> {
    Json(Service {
        name: "seatrial",
        description: "Finds out how this vehicle steers",
        icon: "mdi-ship-wheel",
        company: "seatrial",
        version: env!("CARGO_PKG_VERSION"),
        webpage: REPOSITORY,
        api: format!("{REPOSITORY}/blob/main/docs/dashboard.md#programming-interface"),
        avoid_iframes: true,
    })
}
