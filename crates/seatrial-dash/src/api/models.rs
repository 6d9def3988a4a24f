//! What is made of models.

use seatrial_app::model_request::ModelRequest;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The model of a log, and what is said of its vehicle besides.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct ModelOrder {
    /// Where the model comes from, for people: the name of the log.
    #[cfg_attr(feature = "openapi", schema(max_length = 200))]
    pub origin: String,
    /// The document of `seatrial identify --json`.
    #[cfg_attr(feature = "openapi", schema(value_type = Object))]
    pub document: Value,
    /// What is said besides.
    #[serde(default)]
    pub stated: ModelRequest,
}
