//! Joining the middleware that a vehicle's description names.

use thiserror::Error;

use super::middleware_error::MiddlewareError;
use super::{Description, EstimateTopic, Graph, Zenoh};

/// A vehicle's topics and services, and its topic of estimates.
pub type VehicleTopics = (Box<dyn Graph>, EstimateTopic);

/// Why the middleware of a vehicle could not be joined.
#[derive(Debug, Error)]
pub enum JoinError {
    /// This build has no such middleware.
    #[error("this seatrial was built without; build it with --features {feature}")]
    NotBuilt {
        /// The feature that builds it in.
        feature: &'static str,
    },
    /// The middleware refused.
    #[error(transparent)]
    Middleware(#[from] MiddlewareError),
}

/// Joins the middleware that a description names: DDS, or zenoh where it has a section for it.
pub fn join(description: &Description) -> Result<VehicleTopics, JoinError> {
    match &description.zenoh {
        None => over_dds(description),
        Some(zenoh) => over_zenoh(description, zenoh),
    }
}

#[cfg(feature = "ros2")]
fn over_dds(description: &Description) -> Result<VehicleTopics, JoinError> {
    let mut graph = super::middleware::Dds::open(description.clone())?;
    let estimates = graph.estimates()?;
    Ok((Box::new(graph), estimates))
}

#[cfg(not(feature = "ros2"))]
fn over_dds(_: &Description) -> Result<VehicleTopics, JoinError> {
    Err(JoinError::NotBuilt { feature: "ros2" })
}

#[cfg(feature = "ros2-zenoh")]
fn over_zenoh(description: &Description, zenoh: &Zenoh) -> Result<VehicleTopics, JoinError> {
    let opened = super::middleware::OverZenoh::open(description.clone(), zenoh);
    let mut graph = opened?;
    let estimates = graph.estimates()?;
    Ok((Box::new(graph), estimates))
}

#[cfg(not(feature = "ros2-zenoh"))]
fn over_zenoh(_: &Description, _: &Zenoh) -> Result<VehicleTopics, JoinError> {
    Err(JoinError::NotBuilt { feature: "ros2-zenoh" })
}
