//! A log format, a vehicle and an estimator of one's own, outside seatrial's repository as far as code is concerned: it uses what is public.

pub mod helm;
pub mod integrated;
pub mod text_boat;
