//! What a reason says to people, in one place: the cause in one sentence, and what to do about it where it is read.

use super::code::ReasonCode;

/// Where a reason is read. What to do is said in the words of that place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reader {
    /// A terminal, with the options of the command.
    Terminal,
    /// The dashboard, with its buttons and fields.
    Dashboard,
    /// Python, with the arguments of its functions.
    Python,
}

/// The cause of a reason and what to do about it.
pub(super) struct Words {
    pub cause: &'static str,
    terminal: &'static str,
    dashboard: &'static str,
    python: &'static str,
}

impl Words {
    pub fn action(&self, reader: Reader) -> &'static str {
        match reader {
            Reader::Terminal => self.terminal,
            Reader::Dashboard => self.dashboard,
            Reader::Python => self.python,
        }
    }
}

const fn same(cause: &'static str, action: &'static str) -> Option<Words> {
    each(cause, action, action, action)
}

const fn each(
    cause: &'static str,
    terminal: &'static str,
    dashboard: &'static str,
    python: &'static str,
) -> Option<Words> {
    Some(Words {
        cause,
        terminal,
        dashboard,
        python,
    })
}

/// The words of a code. `None` where every reason of this code says its own.
pub(super) fn of(code: &ReasonCode) -> Option<Words> {
    of_samples(code)
        .or_else(|| of_units(code))
        .or_else(|| of_compass(code))
        .or_else(|| of_rudder(code))
        .or_else(|| of_model(code))
        .or_else(|| of_validation(code))
        .or_else(|| of_pitch(code))
        .or_else(|| of_several(code))
}

/// What cures a reason in a trial, where the cure of a log is of no use: a trial has no columns, units and windows to be chosen.
pub(super) fn in_a_trial(code: &ReasonCode) -> Option<&'static str> {
    Some(match code {
        ReasonCode::TooFewSamples => {
            "Plan a longer manoeuvre, or let the vehicle send its state faster."
        }
        ReasonCode::RejectedSamples => "Check the clock and the compass of the vehicle.",
        ReasonCode::SamplesMissing | ReasonCode::ClockJitter => {
            "Check the link to the vehicle, then repeat the run."
        }
        ReasonCode::TimesShared | ReasonCode::ClockJumped | ReasonCode::TimeUnitDoubtful => {
            "Check the clock of the vehicle, then repeat the run."
        }
        ReasonCode::SampledTooSeldom => {
            "Let the vehicle send heading and rudder faster: ten samples in the time that a turn takes to die out."
        }
        ReasonCode::HeadingUnitDoubtful | ReasonCode::CourseForHeading => {
            "Check which heading the vehicle sends, and in which unit."
        }
        ReasonCode::RudderUnitDoubtful | ReasonCode::RudderScaleUnknown => {
            "Check which angle the rudder has at full steering, and set it for this vehicle."
        }
        ReasonCode::YawRateContradicts => "Check compass and gyro: one of them is wrong.",
        ReasonCode::YawRateReversed => "Check how the gyro is mounted; the model does without it.",
        ReasonCode::LagUnknown => {
            "Let the vehicle send the measured rudder angle, or put the lag of the servo into the plan."
        }
        ReasonCode::NotValidated => "Repeat the run with a validation manoeuvre.",
        ReasonCode::SpeedUnknown => "Let the vehicle send its speed through the water.",
        _ => return None,
    })
}

/// What is wrong with samples and their times.
fn of_samples(code: &ReasonCode) -> Option<Words> {
    match code {
        ReasonCode::TooFewSamples => same(
            "The training window holds too few samples.",
            "Use a longer window, or log faster.",
        ),
        ReasonCode::RejectedSamples => same(
            "Many samples of the log are damaged.",
            "Check the clock and the heading channel of the log.",
        ),
        ReasonCode::Damaged => same(
            "A part of the record is damaged.",
            "Take a copy from before the damage.",
        ),
        ReasonCode::SamplesMissing => same(
            "Samples were lost while the rudder moved.",
            "Log without losses.",
        ),
        ReasonCode::ClockJitter => same(
            "The time between samples is uneven.",
            "Log without losses, with the time of the measurement.",
        ),
        ReasonCode::TimesShared => each(
            "Rows that differ have the same time.",
            "Write the time with more digits, or name another column with --time. Where the rows are of several vehicles, read one of them with --where COLUMN=VALUE.",
            "Write the time with more digits, or enter another column for the time. Keep the rows of one vehicle.",
            "Write the time with more digits, or pass columns={\"time\": ...}. Keep the rows of one vehicle.",
        ),
        ReasonCode::ClockJumped => each(
            "The clock of the log jumped.",
            "Use the part before or behind the jump, with --from and --to.",
            "Use the part before or behind the jump.",
            "Use the part before or behind the jump: pass training=(from, to).",
        ),
        ReasonCode::SampledTooSeldom => same(
            "Heading or rudder is logged too seldom for this vehicle.",
            "Log both faster: ten samples in the time that a turn takes to die out.",
        ),
        _ => None,
    }
}

/// What is wrong with units, signs and columns.
fn of_units(code: &ReasonCode) -> Option<Words> {
    match code {
        ReasonCode::HeadingUnitDoubtful => each(
            "The heading is not in the unit that it is read in.",
            "Give its unit with --unit heading=rad or --unit heading=deg.",
            "Choose rad or deg as “Heading is in” under “Columns and units”.",
            "Pass units={\"heading\": \"rad\"} or units={\"heading\": \"deg\"}.",
        ),
        ReasonCode::RudderUnitDoubtful => each(
            "The rudder is not in the unit that its column says.",
            "Give its unit with --unit rudder=rad or --unit rudder=deg.",
            "Choose rad or deg as “Rudder is in” under “Columns and units”.",
            "Pass units={\"rudder\": \"rad\"} or units={\"rudder\": \"deg\"}.",
        ),
        ReasonCode::RudderScaleUnknown => each(
            "Nothing in the log says in which unit the rudder is.",
            "Give its unit with --unit rudder=deg (or rad, fraction, percent).",
            "Choose deg, rad, fraction or percent as “Rudder is in” under “Columns and units”.",
            "Pass units={\"rudder\": \"deg\"} (or rad, fraction, percent).",
        ),
        ReasonCode::CourseForHeading => same(
            "The heading is a course or track, where the vehicle goes, not where it points.",
            "Log the heading of a compass, and take its column.",
        ),
        ReasonCode::TimeUnitDoubtful => each(
            "The time is not in the unit that its column says.",
            "Give its unit with --unit time=s (or ms, us, min, h, d), or another column with --time.",
            "Choose the unit as “Time is in” under “Columns and units”, or another column for the time.",
            "Pass units={\"time\": \"s\"} (or ms, us, min, h, d), or columns={\"time\": ...}.",
        ),
        ReasonCode::TimeUnchecked => each(
            "Nothing in the log shows that a row takes a second.",
            "Where it does, say --unit time=s.",
            "Where it does, choose s as “Time is in” under “Columns and units”.",
            "Where it does, pass units={\"time\": \"s\"}.",
        ),
        ReasonCode::YawRateContradicts => each(
            "The yaw rate contradicts the heading.",
            "Give the right unit, such as --unit yaw_rate=deg/s or --unit time=ms, or leave it out with --yaw-rate none.",
            "Choose the right unit of the yaw rate or the time under “Columns and units”, or leave the column of the yaw rate out.",
            "Pass the right unit, such as units={\"yaw_rate\": \"deg/s\"}, or columns={\"yaw_rate\": \"none\"}.",
        ),
        ReasonCode::YawRateReversed => each(
            "The yaw rate has the opposite sign of the heading and was not used.",
            "Reverse it in a --channels file, or leave it out with --yaw-rate none.",
            "Leave the column of the yaw rate out under “Columns and units”.",
            "Reverse it in a channels_file, or pass columns={\"yaw_rate\": \"none\"}.",
        ),
        _ => None,
    }
}

/// What is wrong with compass or gyro.
fn of_compass(code: &ReasonCode) -> Option<Words> {
    match code {
        ReasonCode::HeadingConstant => same(
            "The heading did not change while the rudder moved.",
            "Check that the compass works and is logged.",
        ),
        ReasonCode::Quantised => same(
            "The heading is logged in coarse steps.",
            "Log the heading with more digits, or turn further.",
        ),
        ReasonCode::CompassError => same(
            "The compass jumped, stuck or was disturbed.",
            "Repeat the run away from iron and electric currents.",
        ),
        ReasonCode::CompassDeviation => same(
            "Compass and gyro disagree on how far the vehicle turned.",
            "Swing the compass, or turn a full circle and compare the gyro with 360 deg.",
        ),
        ReasonCode::CompassLate => same(
            "The heading is logged later than it was measured.",
            "Log the heading with the time of its measurement.",
        ),
        ReasonCode::YawRateLate => same(
            "The yaw rate is logged later than the heading.",
            "Nothing for the model; filter the gyro less where a controller uses it.",
        ),
        ReasonCode::HeadingHeld => same(
            "The heading changes less often than rows are written.",
            "Log every heading once, with the time of its measurement.",
        ),
        ReasonCode::HeadingUnchecked => same(
            "The log has no yaw rate to check the compass with.",
            "Log the yaw rate of a gyro, or swing the compass.",
        ),
        _ => None,
    }
}

/// What is wrong with the rudder.
fn of_rudder(code: &ReasonCode) -> Option<Words> {
    match code {
        ReasonCode::RudderConstant => same(
            "No manoeuvre: the rudder hardly moved.",
            "Steer a doublet: the rudder to one side, then to the other.",
        ),
        ReasonCode::RudderHeld => same(
            "The rudder changes less often than rows are written.",
            "Log the rudder as often as the heading.",
        ),
        ReasonCode::RudderUnchecked => same(
            "Nothing in the log shows that the rudder reached its angle.",
            "Log the measured rudder angle.",
        ),
        ReasonCode::RudderSaturated => same(
            "The rudder seems to stop before the angle that was asked for.",
            "Look at the measured rudder angle, and repeat with a smaller one.",
        ),
        ReasonCode::RudderJammed => same(
            "The rudder seems to have stuck.",
            "Free the rudder and look at its linkage and servo, then repeat the run.",
        ),
        ReasonCode::RudderPlay => same(
            "The rudder seems to have play.",
            "Take the slack out of the linkage, or log the measured rudder angle.",
        ),
        ReasonCode::LagUnknown => each(
            "The rudder may follow its command late, and the log does not show how late.",
            "Log the measured rudder angle and say --rudder-lag 0, or give the lag of the servo with --rudder-lag.",
            "Log the measured rudder angle, or enter the time constant of the servo, 0 of a measured angle.",
            "Log the measured rudder angle and pass rudder_lag_s=0, or pass the lag of the servo.",
        ),
        ReasonCode::SignReversed => same(
            "A positive rudder angle turns the vehicle to decreasing heading.",
            "Keep this sign, or reverse the rudder channel.",
        ),
        _ => None,
    }
}

/// What is wrong with the model.
fn of_model(code: &ReasonCode) -> Option<Words> {
    match code {
        ReasonCode::NotIdentifiable => same(
            "The log does not show how the heading follows the rudder.",
            "Check both channels, then repeat with more rudder to both sides.",
        ),
        ReasonCode::UnderExcited => same(
            "The manoeuvre was too small: the model is too uncertain.",
            "Repeat the manoeuvre with more rudder, or several times.",
        ),
        ReasonCode::DoesNotFit => same(
            "The model does not describe its own record.",
            "Repeat the manoeuvre in calmer water, with more rudder and no autopilot; log the heading unfiltered.",
        ),
        ReasonCode::Unstable => same(
            "The vehicle does not stop turning by itself, or the log does not show it.",
            "Repeat the manoeuvre with a longer pause after it: gains need a stable model.",
        ),
        ReasonCode::Disagreement => same(
            "Two ways to estimate the model disagree.",
            "Repeat the manoeuvre in calmer water, with nothing but the rudder turning the vehicle.",
        ),
        ReasonCode::ResidualNotWhite => same(
            "The errors of the model are not random: a slow servo, waves or a filtered compass.",
            "Log the measured rudder angle and the unfiltered compass, in calmer water.",
        ),
        ReasonCode::ModelOrder => same(
            "The vehicle does more than a first-order model can describe.",
            "Use the model only for rudder angles and turns like those of the log.",
        ),
        ReasonCode::Disturbed => same(
            "Waves, gusts or a current turned the vehicle as well.",
            "For narrower bounds repeat in calmer water, or with more rudder.",
        ),
        ReasonCode::SpeedDrifted => same(
            "The speed was not the same throughout.",
            "Wait longer at each speed before the manoeuvre, or use less rudder.",
        ),
        _ => None,
    }
}

/// What validation data say.
fn of_validation(code: &ReasonCode) -> Option<Words> {
    match code {
        ReasonCode::LowR2 => same(
            "The model does not predict data that it was not trained on.",
            "Check that the rudder goes where it is told and that the compass did not jump, then repeat the run.",
        ),
        ReasonCode::NotValidated => each(
            "No data were held out to check the model.",
            "Validate on a second manoeuvre: --validate-from and --validate-to, or --validate-on LOG; of several logs, one more.",
            "Record a second manoeuvre at this speed, and open the log that holds both.",
            "Check it on a second manoeuvre: pass validation=(from, to), or validate_on.",
        ),
        ReasonCode::OffsetDrifted => same(
            "The rudder that holds a straight course changed between training and validation.",
            "Use the gains. Find that rudder again; if wind, current and trim were steady, look for play in the linkage.",
        ),
        ReasonCode::Contradicted => same(
            "The validation data give another model than the training data.",
            "Check the measured rudder angle and the compass, then train again.",
        ),
        ReasonCode::WeaklyValidated => same(
            "The validation manoeuvre was too small to show a wrong model.",
            "Validate with more rudder, with more manoeuvres or in calmer water.",
        ),
        ReasonCode::Extrapolating => same(
            "The validation data leave the range of rudder, heading or speed that the model was trained in.",
            "Train with the rudder and at the speed that you mean to use.",
        ),
        _ => None,
    }
}

/// What is wrong on the axis of pitch.
fn of_pitch(code: &ReasonCode) -> Option<Words> {
    match code {
        ReasonCode::ElevatorConstant => same(
            "The elevator did not move.",
            "Command an elevator doublet of some degrees: up, then down.",
        ),
        ReasonCode::PitchUndamped => same(
            "The pitch is not damped, or the log does not show it.",
            "Repeat the manoeuvre with a longer pause after it: gains need a damped vehicle.",
        ),
        ReasonCode::PitchNotExplained => same(
            "The elevator does not explain how the vehicle pitched.",
            "Check both channels, then repeat with more elevator to both sides.",
        ),
        _ => None,
    }
}

/// What several manoeuvres or speeds say together.
fn of_several(code: &ReasonCode) -> Option<Words> {
    match code {
        ReasonCode::ManoeuvresDiffer => same(
            "Manoeuvres at one speed give different models.",
            "Check load, trim and fins, and repeat the manoeuvres.",
        ),
        ReasonCode::SpeedUnknown => each(
            "The manoeuvres give different models, and the log has no speed: they may be of several speeds.",
            "Name the column of the speed with --speed, or take the manoeuvres of one speed with --from and --to.",
            "Choose “Forward speed from column” under “Columns and units”, or drag the windows over the manoeuvres of one speed.",
            "Pass columns={\"speed\": ...}, or training=(from, to) with the manoeuvres of one speed.",
        ),
        ReasonCode::RunRepeated => same(
            "A run was refused and repeated.",
            "Find the fault before the vehicle relies on it: the models are those of sound runs, but it may come back.",
        ),
        ReasonCode::SpeedFalls => same(
            "The speed fell although the thrust rose.",
            "Check propeller, battery and current, and repeat both speeds.",
        ),
        ReasonCode::AuthorityChanged => same(
            "The rudder's effect changes over speed as that of one vehicle does not.",
            "Look at fins, propeller and load, then repeat both speeds.",
        ),
        ReasonCode::DampingChanged => same(
            "The damping changes over speed as that of one vehicle does not.",
            "Look at fins, propeller and load, then repeat both speeds.",
        ),
        _ => None,
    }
}
