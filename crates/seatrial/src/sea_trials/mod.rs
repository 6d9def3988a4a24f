//! What is measured at sea beside the steering model: the field experiments of the paper and the standard manoeuvres of ships.

pub mod field;
pub mod ship_manoeuvres;
