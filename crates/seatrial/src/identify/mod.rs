//! From a record to a model: the online estimate, offline methods and the verdict.

pub mod batch;
pub mod simplex;
