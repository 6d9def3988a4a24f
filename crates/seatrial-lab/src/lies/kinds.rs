//! Every kind of log.

use std::f64::consts::PI;

use super::draw::Draw;
use super::setup::Decidability::{Decidable, Sound, Undecidable};
use super::setup::{
    Column, DEG, Decidability, GyroChannel, IN_DEGREES, IN_RADIANS, Kind, Pattern, Setup, Waves,
};

/// The kind of a name.
pub fn kind_of_name(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.name == name)
}

const fn kind(
    name: &'static str,
    decidability: Decidability,
    sentence: &'static str,
    change: fn(&mut Setup, &mut Draw),
) -> Kind {
    Kind { name, sentence, decidability, wired: None, change }
}

/// A sound log of any vehicle with one column wired wrongly.
const fn wiring(
    name: &'static str,
    quantity: &'static str,
    sentence: &'static str,
    change: fn(&mut Setup, &mut Draw),
) -> Kind {
    Kind { wired: Some(quantity), ..kind(name, Decidable, sentence, change) }
}

/// Sound logs first, then lies of time, heading, rudder, units, and of the vehicle.
#[rustfmt::skip]
pub const KINDS: [Kind; 122] = [
    kind("sound_20_hz", Sound, "A doublet logged at 20 Hz.", |_, _| {}),
    kind("sound_low_noise", Sound, "A compass with 0.02 deg of noise.", |s, _| s.noise_rad = 0.02 / DEG),
    kind("sound_noisy", Sound, "A compass with 1 deg of noise.", |s, _| { s.noise_rad = 1.0 / DEG; s.disturbance = 0.003; }),
    kind("sound_50_hz", Sound, "A fast vehicle logged at 50 Hz.", |s, d| { let t = d.within(0.4, 0.9); s.with_interval(0.02); s.with_time_constant(t, 0.01, d); }),
    kind("sound_10_hz", Sound, "A vehicle with a time constant over 1 s logged at 10 Hz.", |s, d| { let t = d.within(1.0, 2.0); s.with_interval(0.1); s.with_time_constant(t, 0.0, d); }),
    kind("sound_boat_5_hz", Sound, "A boat with a time constant of 2 to 5 s logged at 5 Hz.", |s, d| boat(s, d, 0.2)),
    kind("sound_ship_1_hz", Sound, "A ship with a time constant of 15 to 40 s logged at 1 Hz.", |s, d| { ship(s, d); }),
    kind("sound_trim", Sound, "Straight ahead takes 2 to 4 deg of rudder.", |s, d| { let offset = d.sign() * d.within(2.0, 4.0) / DEG; for hull in &mut s.hulls { hull.delta0_rad = offset; } }),
    kind("sound_zig_zag", Sound, "Zig-zags in training and validation.", |s, _| zig_zag(s)),
    kind("sound_zig_zag_boat", Sound, "Zig-zags of a boat at 5 Hz with a trim.", |s, d| { boat(s, d, 0.2); zig_zag(s); for hull in &mut s.hulls { hull.delta0_rad = 0.03; } }),
    kind("sound_gyro", Sound, "A gyro beside the compass.", |s, d| s.with_gyro(d)),
    kind("sound_equal_amplitudes", Sound, "Training and validation with the same rudder.", |s, _| s.amplitudes_rad = [0.2, 0.2]),

    kind("slow_log_1_hz", Decidable, "A vehicle with a time constant of 1 s, steered at 20 Hz, logged at 1 Hz.", |s, d| { let t = d.within(0.8, 1.3); s.with_time_constant(t, 0.01, d); s.rows_every = 20; }),
    kind("slow_log_2_hz", Decidable, "A vehicle with a time constant of 1 s, steered at 20 Hz, logged at 2 Hz.", |s, d| { let t = d.within(0.8, 1.3); s.with_time_constant(t, 0.01, d); s.rows_every = 10; }),
    kind("slow_log_boat", Decidable, "A boat with a time constant of 2 s logged every 1.5 s.", |s, d| { let t = d.within(1.6, 2.6); s.with_time_constant(t, 0.0, d); s.with_interval(0.1); s.rows_every = 15; }),
    kind("time_in_milliseconds", Decidable, "`time_s` holds milliseconds.", |s, _| s.clock.per_second = 1000.0),
    kind("time_is_row_index", Undecidable, "`time_s` holds the number of the row.", |s, _| s.clock.per_second = 0.0),
    kind("time_is_row_index_gyro", Decidable, "`time_s` holds the number of the row, and there is a gyro.", |s, d| { s.clock.per_second = 0.0; s.with_gyro(d); }),
    kind("time_in_minutes_gyro", Decidable, "`time_s` holds minutes, and there is a gyro.", |s, d| { s.clock.per_second = 1.0 / 60.0; s.with_gyro(d); }),
    kind("time_rounded", Decidable, "Time is rounded to 0.1 s in a log of 20 Hz.", |s, _| s.clock.rounding_s = 0.1),
    kind("clock_jitter", Decidable, "Stamps are off by a fifth of the interval.", |s, _| s.clock.jitter = 0.2),
    kind("clock_jump", Decidable, "The clock jumps ahead within training.", |s, d| s.clock.jump_s = d.within(0.5, 3.0)),
    kind("rows_duplicated", Decidable, "Some rows stand twice in the log.", |s, d| s.clock.duplicate_every = d.one_of(&[3, 10, 40])),
    kind("rows_swapped", Decidable, "Some rows have changed places.", |s, d| s.clock.swap_every = d.one_of(&[7, 20, 60])),
    kind("blocks_missing", Decidable, "Blocks of half a time constant are missing.", |s, d| s.clock.missing = d.within(0.05, 0.2)),

    kind("heading_late", Decidable, "The heading is 0.2 to 0.5 s late, and there is no gyro.", |s, d| { s.heading.late_s = d.within(0.2, 0.5); s.gyro = None; }),
    kind("heading_late_gyro", Decidable, "The heading is 0.2 to 0.5 s late, and there is a gyro.", |s, d| { s.heading.late_s = d.within(0.2, 0.5); s.with_gyro(d); }),
    kind("heading_filtered", Decidable, "The heading went through a low-pass filter of 0.3 s, and there is no gyro.", |s, _| { s.heading.low_pass_s = 0.3; s.gyro = None; }),
    kind("heading_filtered_gyro", Decidable, "The heading went through a low-pass filter of 0.3 s, and there is a gyro.", |s, d| { s.heading.low_pass_s = 0.3; s.with_gyro(d); }),
    kind("heading_held", Decidable, "The heading is refreshed at 2.5 Hz in a log of 5 Hz.", |s, d| { let t = d.within(1.2, 2.0); s.with_time_constant(t, 0.0, d); s.with_interval(0.2); s.heading.held_s = 0.4; s.gyro = None; }),
    kind("heading_held_5_hz", Decidable, "The heading is refreshed at 5 Hz in a log of 20 Hz.", |s, _| s.heading.held_s = 0.2),
    kind("heading_stuck", Decidable, "The heading sticks for 0.4 s now and then.", |s, _| s.heading.stuck_share = 0.15),
    kind("heading_jumps", Decidable, "The heading jumps by 5 to 20 deg within training.", |s, d| s.heading.jump_rad = d.sign() * d.within(5.0, 20.0) / DEG),
    kind("heading_coarse_1_deg", Decidable, "The heading comes in steps of 1 deg.", |s, _| { s.columns = IN_DEGREES; s.heading.resolution = 1.0; s.noise_rad = 0.1 / DEG; }),
    kind("heading_coarse_5_deg", Decidable, "The heading comes in steps of 5 deg.", |s, _| { s.columns = IN_DEGREES; s.heading.resolution = 5.0; s.noise_rad = 0.1 / DEG; }),
    kind("heading_mod_180", Decidable, "The heading is taken modulo 180 deg.", |s, _| { s.columns = IN_DEGREES; s.heading.modulo_rad = Some(PI); s.start_rad = PI - 0.1; }),
    kind("heading_wraps_badly", Decidable, "The heading was averaged over north: it passes through south on its way from 355 to 5 deg.", |s, _| { s.columns = IN_DEGREES; s.heading.wraps_badly = true; s.start_rad = -0.1; }),
    kind("heading_constant", Decidable, "The first heading is copied over the whole channel.", |s, _| s.heading.constant = true),
    kind("compass_deviation_gyro", Decidable, "Hard iron of 5 to 15 deg at the compass, and there is a gyro.", |s, d| { deviation(s, d); s.with_gyro(d); }),
    kind("compass_deviation", Undecidable, "Hard iron of 5 to 15 deg at the compass, and there is no gyro.", |s, d| { deviation(s, d); s.gyro = None; }),
    kind("course_over_ground", Undecidable, "The course over ground in a current is logged as the heading, and there is no gyro.", |s, d| { course(s, d); s.gyro = None; }),
    kind("course_over_ground_gyro", Decidable, "The course over ground in a current is logged as the heading, and there is a gyro.", |s, d| { course(s, d); s.with_gyro(d); }),

    kind("rudder_stops_in_training", Decidable, "The rudder stops at half of what it was told in training.", |s, _| s.hulls[0].stop = Some(0.5)),
    kind("rudder_stops_in_validation", Decidable, "The rudder stops at half of what it was told in validation.", |s, _| s.hulls[1].stop = Some(0.5)),
    kind("rudder_stops_in_both", Undecidable, "The rudder stops at half of what it was told in both manoeuvres.", |s, _| s.hulls.iter_mut().for_each(|hull| hull.stop = Some(0.5))),
    kind("rudder_stops_at_an_angle", Decidable, "The rudder stops at 6 deg in both manoeuvres.", |s, _| { s.hulls[0].stop = Some(0.105 / s.amplitudes_rad[0]); s.hulls[1].stop = Some(0.105 / s.amplitudes_rad[1]); }),
    kind("rudder_reversed", Decidable, "The rudder's sign is turned over.", |s, _| s.rudder.sense = -1.0),
    kind("rudder_at_1_hz", Decidable, "The rudder is refreshed at 1 Hz beside a heading at 20 Hz.", |s, _| s.rudder.held_s = 1.0),
    kind("rudder_at_10_hz", Decidable, "The rudder is refreshed at 10 Hz beside a heading at 50 Hz.", |s, d| { let t = d.within(0.4, 0.9); s.with_interval(0.02); s.with_time_constant(t, 0.01, d); s.rudder.held_s = 0.1; }),
    kind("rudder_late", Decidable, "The rudder stands a row late.", |s, _| s.rudder.late_rows = 1),
    kind("rudder_early", Decidable, "The rudder stands a row early.", |s, _| s.rudder.late_rows = -1),
    kind("rudder_is_setpoint", Decidable, "The rudder channel is what a servo with a lag of 0.15 to 0.4 s was told.", |s, d| s.servo_lag_s = d.within(0.15, 0.4)),
    kind("rudder_backlash", Decidable, "The rudder has 2 deg of play and 1 deg of dead band.", |s, _| { s.backlash_rad = 2.0 / DEG; s.dead_band_rad = 1.0 / DEG; }),
    kind("rudder_constant", Decidable, "The first rudder angle is copied over the whole channel.", |s, _| s.rudder.constant = true),

    kind("heading_is_radians", Decidable, "`heading_deg` holds radians.", |s, _| { s.columns = IN_DEGREES; s.columns.heading.per_si = 1.0; s.gyro = None; }),
    kind("heading_is_radians_gyro", Decidable, "`heading_deg` holds radians, and there is a gyro.", |s, d| { s.columns = IN_DEGREES; s.columns.heading.per_si = 1.0; s.with_gyro(d); }),
    kind("rudder_is_radians", Decidable, "`rudder_deg` holds radians.", |s, _| { s.columns = IN_DEGREES; s.columns.rudder.per_si = 1.0; }),
    kind("rudder_fraction", Decidable, "`rudder` holds a fraction of its full angle without a unit.", |s, _| { s.columns.rudder = Column::new("rudder", 1.0 / s.full_rudder_rad); }),
    kind("rudder_percent", Decidable, "`rudder` holds percent of its full angle without a unit.", |s, _| { s.columns.rudder = Column::new("rudder", 100.0 / s.full_rudder_rad); }),
    kind("rudder_pwm", Decidable, "`rudder` holds a servo's pulse width without its full angle.", |s, _| { s.columns.rudder = Column { name: "rudder", per_si: 400.0 / s.full_rudder_rad, offset: 1500.0 }; }),
    kind("rudder_centidegrees", Decidable, "`rudder` holds hundredths of a degree without a unit.", |s, _| { s.columns.rudder = Column::new("rudder", 100.0 * DEG); }),
    kind("yaw_rate_in_degrees", Decidable, "`yaw_rate_rad_s` holds degrees a second.", |s, d| { s.columns = IN_RADIANS; s.with_gyro(d); scale_gyro(s, DEG); }),
    kind("yaw_rate_reversed", Decidable, "The yaw rate's sign is turned over.", |s, d| { s.with_gyro(d); scale_gyro(s, -1.0); }),

    kind("waves", Decidable, "A ship in waves.", |s, d| { ship(s, d); let share = d.within(0.5, 1.5); s.waves = Some(Waves { share, frequency_rad_s: d.within(0.5, 0.9) }); }),
    kind("another_vehicle_validates", Decidable, "The validation is another vehicle's: a22 and b2 are 1.7 and 2.2 times those of training.", |s, _| { s.hulls[1].a22_per_s *= 1.7; s.hulls[1].b2_per_s2 *= 2.2; }),
    kind("payload_changed", Decidable, "A payload makes the vehicle slower to turn by 40 % between training and validation.", |s, _| { s.hulls[1].a22_per_s /= 1.4; s.hulls[1].b2_per_s2 /= 1.4; }),
    kind("thrust_changed", Decidable, "The thrust changes within training, and the speed by a third.", |s, d| s.hulls[0].speed_change = d.one_of(&[0.67, 1.33])),
    kind("current_step", Decidable, "A current turns the vehicle from the middle of training on.", |s, d| s.current_step = d.sign() * d.within(0.1, 0.3)),
    kind("window_begins_in_turn", Decidable, "Both windows begin while the vehicle is turning.", |s, _| s.begins_in_turn = true),

    kind("any_sound", Sound, "Any vehicle, log and manoeuvre.", any),
    kind("any_noisy", Sound, "Any vehicle with 1 to 2 deg of noise in its compass.", |s, d| { any(s, d); s.noise_rad = d.within(1.0, 2.0) / DEG; }),
    kind("any_heading_late", Decidable, "A heading late by a tenth to half of the time constant, and no gyro.", |s, d| { any(s, d); s.heading.late_s = d.within(0.1, 0.5) * s.time_constant_s(); s.gyro = None; }),
    kind("any_heading_late_gyro", Decidable, "A heading late by a tenth to half of the time constant, and a gyro.", |s, d| { any(s, d); s.heading.late_s = d.within(0.1, 0.5) * s.time_constant_s(); s.with_gyro(d); }),
    kind("any_heading_filtered", Decidable, "A low-pass filter of a tenth to 0.4 of the time constant before the heading, and no gyro.", |s, d| { any(s, d); s.heading.low_pass_s = d.within(0.1, 0.4) * s.time_constant_s(); s.gyro = None; }),
    kind("any_heading_held", Decidable, "A heading refreshed every 2 to 5 rows.", |s, d| { any(s, d); s.heading.held_s = d.one_of(&[2.0, 3.0, 5.0]) * s.row_s(); s.gyro = None; }),
    kind("any_heading_coarse", Decidable, "A heading in steps of 1 to 3 deg.", |s, d| { any(s, d); s.columns = IN_DEGREES; s.heading.resolution = d.one_of(&[1.0, 2.0, 3.0]); }),
    kind("any_heading_stuck", Decidable, "A heading that sticks for eight rows now and then.", |s, d| { any(s, d); s.heading.stuck_share = 0.15; }),
    kind("any_compass_deviation", Undecidable, "Hard iron of 5 to 15 deg, and no gyro.", |s, d| { any(s, d); deviation(s, d); s.gyro = None; }),
    kind("any_gyro_late", Decidable, "A gyro late by a tenth to half of the time constant.", |s, d| { any(s, d); s.with_gyro(d); let late_s = d.within(0.1, 0.5) * s.time_constant_s(); s.gyro = s.gyro.map(|gyro| GyroChannel { late_s, ..gyro }); }),
    kind("any_gyro_scaled", Decidable, "A gyro whose scale is wrong by 0.7 to 1.4.", |s, d| { any(s, d); s.with_gyro(d); scale_gyro(s, d.one_of(&[0.7, 1.4])); }),
    kind("any_rudder_held", Decidable, "A rudder refreshed every 2 to 10 rows.", |s, d| { any(s, d); s.rudder.held_s = d.one_of(&[2.0, 4.0, 10.0]) * s.row_s(); }),
    kind("any_rudder_late", Decidable, "A rudder that stands one or two rows late or early.", |s, d| { any(s, d); s.rudder.late_rows = d.one_of(&[-2, -1, 1, 2]); }),
    kind("any_rudder_lags", Decidable, "What a servo was told, with a lag of 0.05 to 0.5 of the time constant.", |s, d| { any(s, d); s.servo_lag_s = d.within(0.05, 0.5) * s.time_constant_s(); }),
    kind("any_rudder_stops_in_training", Decidable, "A rudder that stops at half of what it was told in training.", |s, d| { any(s, d); s.hulls[0].stop = Some(0.5); }),
    kind("any_rudder_stops_in_both", Undecidable, "A rudder that stops at half of what it was told in both manoeuvres.", |s, d| { any(s, d); s.hulls.iter_mut().for_each(|hull| hull.stop = Some(0.5)); }),
    kind("any_rudder_backlash", Decidable, "A rudder with 1 to 3 deg of play.", |s, d| { any(s, d); s.backlash_rad = d.within(1.0, 3.0) / DEG; }),
    kind("any_clock_jump", Decidable, "A clock that jumps ahead by 0.2 to 2 time constants within training.", |s, d| { any(s, d); s.clock.jump_s = d.within(0.2, 2.0) * s.time_constant_s(); }),
    kind("any_clock_gains", Decidable, "A clock that gains or loses a thousandth.", |s, d| { any(s, d); s.clock.gains = 1e-3 * d.sign(); }),
    kind("any_clock_jitter", Decidable, "Stamps off by a third of the interval.", |s, d| { any(s, d); s.clock.jitter = 0.33; }),
    kind("any_clock_rounded", Decidable, "Stamps rounded to two or five rows.", |s, d| { any(s, d); s.clock.rounding_s = d.one_of(&[2.0, 5.0]) * s.row_s(); }),
    kind("any_blocks_missing", Decidable, "Blocks of half a time constant are missing.", |s, d| { any(s, d); s.clock.missing = d.within(0.05, 0.2); }),
    kind("any_waves", Decidable, "Waves of 0.2 to 1.5 of the rudder's effect.", |s, d| { any(s, d); let (share, frequency) = (d.within(0.2, 1.5), d.within(2.0, 10.0)); s.waves = Some(Waves { share, frequency_rad_s: frequency / s.time_constant_s() }); }),
    kind("any_speed_changes", Decidable, "Another speed in validation, by 0.7 to 1.4.", |s, d| { any(s, d); let by = d.one_of(&[0.7, 0.85, 1.2, 1.4]); s.hulls[1].a22_per_s *= by; s.hulls[1].b2_per_s2 *= by * by; }),
    kind("any_thrust_changes", Decidable, "The speed changes within training by 0.7 to 1.4.", |s, d| { any(s, d); s.hulls[0].speed_change = d.one_of(&[0.7, 0.85, 1.2, 1.4]); }),
    kind("any_trim_changes", Decidable, "Another trim in validation, by 2 to 6 deg.", |s, d| { any(s, d); s.hulls[1].delta0_rad += d.sign() * d.within(2.0, 6.0) / DEG; }),
    kind("any_current_step", Decidable, "A current turns the vehicle from the middle of training on.", |s, d| { any(s, d); s.current_step = d.sign() * d.within(0.1, 0.4); }),
    kind("any_other_vehicle", Decidable, "Another vehicle's validation: a22 and b2 are 1.4 and 1.8 times those of training.", |s, d| { any(s, d); s.hulls[1].a22_per_s *= 1.4; s.hulls[1].b2_per_s2 *= 1.8; }),

    wiring("wiring_time_milliseconds", "time", "`time` counts milliseconds.", |s, d| clock(s, d, "time", 1e3, 0.0)),
    wiring("wiring_time_microseconds", "time", "`timestamp` counts microseconds.", |s, d| clock(s, d, "timestamp", 1e6, 0.0)),
    wiring("wiring_time_ticks", "time", "`timestamp` counts 100 ns since 1601.", |s, d| clock(s, d, "timestamp", 1e7, 13_259_000_000.0)),
    wiring("wiring_time_hundredths", "time", "`time` counts hundredths of a second.", |s, d| clock(s, d, "time", 100.0, 0.0)),
    wiring("wiring_time_days", "time", "`time` counts the days of a spreadsheet.", |s, d| clock(s, d, "time", 1.0 / 86_400.0, 86_400.0 * 45_000.0)),
    wiring("wiring_time_rows", "time", "`time` counts rows.", |s, d| clock(s, d, "time", 0.0, 0.0)),
    wiring("wiring_heading_tenths", "heading", "`heading` holds tenths of a degree.", |s, d| scale(s, d, 3600.0)),
    wiring("wiring_heading_mils", "heading", "`heading` holds 6400 mils a turn.", |s, d| scale(s, d, 6400.0)),
    wiring("wiring_heading_counts_16", "heading", "`heading` holds 65536 counts a turn.", |s, d| scale(s, d, 65_536.0)),
    wiring("wiring_heading_counts_8", "heading", "`heading` holds 256 counts a turn.", |s, d| scale(s, d, 256.0)),
    wiring("wiring_heading_1e4_rad", "heading", "`heading` holds units of 1e-4 rad.", |s, d| scale(s, d, 62_831.853)),
    wiring("wiring_heading_mirrored", "heading", "The heading counts to port.", |s, d| { any(s, d); s.heading.mirrored = true; }),
    wiring("wiring_heading_late", "heading", "A heading late by a tenth to half of the time constant.", |s, d| { any(s, d); s.heading.late_s = d.within(0.1, 0.5) * s.time_constant_s(); }),
    wiring("wiring_heading_smoothed", "heading", "A low-pass filter of a tenth to 0.8 of the time constant behind the compass.", |s, d| { any(s, d); s.heading.low_pass_s = d.within(0.1, 0.8) * s.time_constant_s(); }),
    wiring("wiring_rudder_tenths", "rudder", "`rudder` holds tenths of a degree.", |s, d| { any(s, d); s.columns.rudder = Column::new("rudder", 10.0 * DEG); }),
    wiring("wiring_rudder_mirrored", "rudder", "The rudder's sign is turned over.", |s, d| { any(s, d); s.rudder.sense = -1.0; }),
    wiring("wiring_rudder_half_sum", "rudder", "Half the sum of two thrusters stands for half their difference.", |s, d| { any(s, d); s.rudder.half_sum = true; }),
    wiring("wiring_rudder_order", "rudder", "What a servo was told, with a lag of 0.05 to 0.5 of the time constant.", |s, d| { any(s, d); s.servo_lag_s = d.within(0.05, 0.5) * s.time_constant_s(); }),
    wiring("wiring_rudder_late", "rudder", "A rudder that stands one or two rows late.", |s, d| { any(s, d); s.rudder.late_rows = d.one_of(&[1, 2]); }),
    wiring("wiring_rate_computed", "yaw_rate", "The yaw rate is a difference of the heading.", |s, d| computed(s, d, 0)),
    wiring("wiring_rate_smoothed", "yaw_rate", "The yaw rate is a mean of differences of the heading.", |s, d| { let reach = d.one_of(&[1, 3, 6]); computed(s, d, reach) }),
    wiring("wiring_rate_computed_rows", "time", "`time_s` counts rows, and the yaw rate is a difference of the heading by it.", |s, d| { computed(s, d, 0); s.clock.per_second = 0.0; }),
    wiring("wiring_rate_smoothed_rows", "time", "`time_s` counts rows, and the yaw rate is a mean of differences of the heading by it.", |s, d| { let reach = d.one_of(&[1, 3, 6]); computed(s, d, reach); s.clock.per_second = 0.0; }),
    wiring("wiring_rate_a_minute", "yaw_rate", "`yaw_rate` holds degrees a minute.", |s, d| { any(s, d); s.with_gyro(d); s.columns.yaw_rate = Column::new("yaw_rate", 60.0 * DEG); }),
    wiring("wiring_rate_reversed", "yaw_rate", "The yaw rate's sign is turned over.", |s, d| { any(s, d); s.with_gyro(d); scale_gyro(s, -1.0); }),
];

/// Intervals between rows of usual logs, s.
const INTERVALS_S: [f64; 12] = [0.01, 0.02, 0.04, 0.05, 0.1, 0.2, 0.25, 0.5, 1.0, 2.0, 4.0, 5.0];

/// Any vehicle with a time constant of 0.3 to 100 s, with 12 to 60 rows in a time constant.
fn any(setup: &mut Setup, draw: &mut Draw) {
    let time_constant_s = draw.log_within(0.3, 100.0);
    let usual: Vec<f64> = INTERVALS_S
        .into_iter()
        .filter(|row_s| (12.0..60.0).contains(&(time_constant_s / row_s)))
        .collect();
    setup.with_interval(draw.one_of(&usual));
    let amplitude_rad = draw.within(0.15, 0.35);
    setup.amplitudes_rad = [amplitude_rad, draw.within(0.6, 1.0) * amplitude_rad];
    setup.pattern = draw.one_of(&[Pattern::Doublet, Pattern::ZigZag(0.26), Pattern::Random]);
    setup.noise_rad = draw.log_within(0.02, 0.6) / DEG;
    setup.disturbance = draw.log_within(0.001, 0.012);
    setup.speed_m_s = draw.within(0.5, 8.0);
    let delta0_rad = draw.within(-0.05, 0.05);
    setup.with_time_constant(time_constant_s, delta0_rad, draw);
    setup.gyro = None;
    if draw.chance(0.4) {
        setup.with_gyro(draw);
    }
}

/// Any vehicle and a clock: the name of its column, numbers for a second, and seconds before the first row.
fn clock(setup: &mut Setup, draw: &mut Draw, name: &'static str, per_second: f64, start_s: f64) {
    any(setup, draw);
    setup.columns.time = name;
    setup.clock.per_second = per_second;
    setup.clock.start_s = start_s;
}

/// Any vehicle and a compass in whole counts of a turn; half of them pass through north.
fn scale(setup: &mut Setup, draw: &mut Draw, turn: f64) {
    any(setup, draw);
    setup.columns = IN_DEGREES;
    setup.columns.heading = Column::new("heading", turn / (2.0 * PI));
    setup.heading.resolution = 1.0;
    if draw.chance(0.5) {
        setup.start_rad = draw.within(-0.2, 0.2);
    }
}

/// Any vehicle and a yaw rate of so many differences of its heading on either side.
fn computed(setup: &mut Setup, draw: &mut Draw, reach: usize) {
    any(setup, draw);
    setup.columns = IN_DEGREES;
    // From 0 at whole seconds the time would count rows.
    setup.clock.start_s = 12.35;
    setup.with_gyro(draw);
    setup.gyro = setup.gyro.map(|gyro| GyroChannel { computed: Some(reach), ..gyro });
}

fn boat(setup: &mut Setup, draw: &mut Draw, interval_s: f64) {
    setup.with_interval(interval_s);
    let time_constant_s = draw.within(2.0, 5.0);
    setup.with_time_constant(time_constant_s, 0.01, draw);
    setup.gyro = None;
}

fn ship(setup: &mut Setup, draw: &mut Draw) {
    setup.with_interval(1.0);
    let time_constant_s = draw.within(15.0, 40.0);
    setup.with_time_constant(time_constant_s, 0.0, draw);
    setup.gyro = None;
    setup.speed_m_s = draw.within(4.0, 9.0);
    setup.clock.start_s = 412.0;
}

fn zig_zag(setup: &mut Setup) {
    setup.pattern = Pattern::ZigZag(0.26);
    setup.amplitudes_rad = [0.26, 0.2];
}

fn deviation(setup: &mut Setup, draw: &mut Draw) {
    setup.heading.deviation_rad = [draw.within(5.0, 15.0) / DEG, draw.within(0.0, 2.0 * PI)];
}

fn course(setup: &mut Setup, draw: &mut Draw) {
    let (speed, towards) = (draw.within(0.15, 0.4) * setup.speed_m_s, draw.within(0.0, 2.0 * PI));
    setup.heading.course_over_ground =
        Some([speed * libm::cos(towards), speed * libm::sin(towards)]);
}

fn scale_gyro(setup: &mut Setup, factor: f64) {
    setup.gyro = setup.gyro.map(|gyro| GyroChannel { factor, ..gyro });
}
