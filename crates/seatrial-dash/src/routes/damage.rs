//! What is damaged of a logbook, in every answer that is made of it.

use std::sync::Arc;

use axum::extract::{Request, State};
use axum::http::{HeaderName, HeaderValue, Method, Uri};
use axum::middleware::Next;
use axum::response::Response;
use seatrial_logbook::CampaignId;

use super::blocking;
use crate::server_state::ServerState;

/// The header that says it: the place, and what is wrong there.
const HEADER: HeaderName = HeaderName::from_static("seatrial-damage");

/// Adds the header to what is shown of campaigns that are damaged.
pub async fn told(
    State(shared): State<Arc<ServerState>>,
    request: Request,
    next: Next,
) -> Response {
    let asked = campaigns_of(request.uri()).filter(|_| request.method() == Method::GET);
    let mut response = next.run(request).await;
    let Some(asked) = asked.filter(|_| response.status().is_success()) else {
        return response;
    };
    let damage = blocking(shared, move |shared| Ok(shared.reader()?.damage_among(&asked)?));
    if let Ok(Some(damage)) = damage.await {
        let text = format!("{}: {}", damage.place, damage.found);
        let text = text.replace(|c: char| !(' '..='~').contains(&c), "?");
        if let Ok(value) = HeaderValue::from_str(&text) {
            response.headers_mut().insert(HEADER, value);
        }
    }
    response
}

/// The campaigns that an address names; none where it names all of them. `None`: it is about something else.
fn campaigns_of(uri: &Uri) -> Option<Vec<CampaignId>> {
    let mut parts = uri.path().split('/');
    let place = parts.find(|part| matches!(*part, "campaigns" | "compare"))?;
    let query = uri.query().unwrap_or_default();
    let named: Vec<&str> = match place {
        "campaigns" => parts.next().into_iter().collect(),
        _ => query.split('&').filter_map(|pair| Some(pair.split_once('=')?.1)).collect(),
    };
    let numbers = named.into_iter().filter_map(|number| number.parse().ok());
    Some(numbers.map(CampaignId).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_an_address_names_its_campaigns() {
        let of = |uri: &'static str| campaigns_of(&Uri::from_static(uri));
        let ids = |ids: &[i64]| Some(ids.iter().copied().map(CampaignId).collect::<Vec<_>>());
        assert_eq!(of("/campaigns"), ids(&[]));
        assert_eq!(of("/api/v1/campaigns/3/samples.csv"), ids(&[3]));
        assert_eq!(of("/compare?a=1&b=2"), ids(&[1, 2]));
        assert_eq!(of("/status"), None);
    }
}
