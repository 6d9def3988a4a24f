//! Codes of the reasons of a verdict, of what they are, and what each says to people where it is read: the cause in one sentence, and what to do.

use std::fmt;

use serde::{Deserialize, Serialize};

use ReasonCode::*;
use Subject::*;

/// What was decided about a model or a run; [of what](super::Subject) a reason says beside it. In documents its name is in snake case:
/// `too_few_samples`.
///
/// Causes are added: a program that answers to some has an answer to the others.
///
/// ```
/// use seatrial::identification::ReasonCode;
///
/// let next = |code| match code {
///     ReasonCode::TooFewSamples => "log faster",
///     _ => "read the verdict",
/// };
/// assert_eq!(next(ReasonCode::TooFewSamples), "log faster");
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ReasonCode {
    /// The model may be used.
    Ok,
    /// The log is of an aircraft.
    NotAVessel,
    /// The training window holds too few usable samples.
    TooFewSamples,
    /// Rudder, heading or elevator did not move, or hardly.
    Constant,
    /// The record does not determine the model.
    NotIdentifiable,
    /// The manoeuvre was too small: the intervals are too wide, or validation data are too uncertain to show a wrong model.
    UnderExcited,
    /// The model does not describe its own training record.
    DoesNotFit,
    /// The motion is not damped: a22, or a of pitch, is not negative.
    Unstable,
    /// A rudder lag that the log does not contain would matter.
    LagUnknown,
    /// The rudder moved far while samples were missing.
    SamplesMissing,
    /// A first-order model does not explain the record, or its prediction errors are not white.
    ModelOrder,
    /// Something other than the rudder turned the vehicle.
    Disturbed,
    /// The rudder (b2 is negative) or the yaw rate has the opposite sense of the heading.
    SignReversed,
    /// Speed or offset changed within the training, or from there to the validation.
    Drifted,
    /// A channel is logged too seldom for this vehicle, or refreshed more slowly than rows are written.
    SampledTooSeldom,
    /// Intervals between samples are uneven.
    ClockJitter,
    /// The clock jumped.
    ClockJumped,
    /// The rudder stopped short of the angle that was asked for, stuck, or follows through a linkage with play.
    RudderNotFollowed,
    /// The heading comes in coarse steps.
    Quantised,
    /// The heading parts from where the yaw rate takes it.
    CompassError,
    /// Heading or yaw rate is later than the other.
    Late,
    /// R^2 on validation data is too low.
    LowR2,
    /// There were no validation data.
    NotValidated,
    /// Other data, or another way to estimate, give another model.
    Contradicted,
    /// Validation data use more rudder than the training.
    Extrapolating,
    /// Manoeuvres of one speed, or of speeds that the log does not tell, differ by more than chance explains.
    ManoeuvresDiffer,
    /// A speed that was tried has no model.
    SpeedMissing,
    /// A fault of the vehicle spoiled a run that was then repeated.
    RunRepeated,
    /// Speed, b2 or a22 changes over the thrust in a way that one vehicle's does not.
    SpeedsDiffer,
    /// The numbers of a channel are not in the unit that its column says.
    UnitDoubtful,
    /// Nothing tells in which unit a channel is.
    UnitUnknown,
    /// The yaw rate contradicts heading and time.
    YawRateContradicts,
    /// The column of the heading names a course over ground.
    CourseForHeading,
    /// Nothing in the log shows whether a channel is right.
    Unchecked,
    /// Samples of the log, or a part of log or logbook, are damaged.
    Damaged,
    /// The trial was aborted.
    Aborted,
    /// The run was not finished.
    Interrupted,
    /// An operator accepted the run.
    AcceptedByOperator,
    /// An operator rejected the run.
    RejectedByOperator,
    /// A code that this version does not know, from a document that another version wrote.
    #[serde(untagged)]
    Other(String),
}

impl fmt::Display for ReasonCode {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.serialize(f)
    }
}

/// The channel, the part of the vehicle or the part of the model that a reason is about. In documents its name is in snake case: `yaw_rate`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Subject {
    /// The heading, or the compass that measures it.
    Heading,
    /// The rudder.
    Rudder,
    /// The elevator.
    Elevator,
    /// The motion in pitch.
    Pitch,
    /// The yaw rate, or the gyro that measures it.
    YawRate,
    /// The samples.
    Samples,
    /// The time.
    Time,
    /// The speed.
    Speed,
    /// The constant C0, which holds the rudder of a straight course.
    Offset,
    /// The yaw damping, a22.
    Damping,
    /// What moves the rudder.
    Linkage,
    /// The errors of one-step predictions.
    Residual,
    /// The training data.
    Training,
    /// The validation data.
    Validation,
    /// One that this version does not know, from a document that another version wrote.
    #[serde(untagged)]
    Other(String),
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.serialize(f)
    }
}

/// A code and, where it has several subjects, of which. Shown as `low_r2` or `constant of rudder`.
///
/// ```
/// use seatrial::identification::{ReasonCode, ReasonKind, Subject};
///
/// let kind = ReasonCode::Constant.of(Subject::Rudder);
/// assert_eq!(kind.to_string(), "constant of rudder");
/// assert_eq!(ReasonKind::from(ReasonCode::LowR2).to_string(), "low_r2");
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ReasonKind {
    /// What is wrong.
    pub code: ReasonCode,
    /// Of what; `None` where the code says it all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub of: Option<Subject>,
}

impl ReasonCode {
    /// This code, of this subject.
    pub const fn of(self, subject: Subject) -> ReasonKind {
        ReasonKind { code: self, of: Some(subject) }
    }

    /// This code, of no subject.
    pub(super) const fn alone(self) -> ReasonKind {
        ReasonKind { code: self, of: None }
    }
}

impl ReasonKind {
    /// Does it name a fault of compass, clock or rudder, of which a low R^2 is a consequence?
    pub(super) fn is_fault(&self) -> bool {
        matches!(
            (&self.code, &self.of),
            (ReasonCode::CompassError | ReasonCode::ClockJumped, _)
                | (ReasonCode::YawRateContradicts | ReasonCode::Late, Some(Subject::Heading))
                | (ReasonCode::RudderNotFollowed, Some(Subject::Rudder))
        )
    }

    /// Does it say that the vehicle, or what measures it, did not do what a sound one does?
    pub(super) fn is_of_the_vehicle(&self) -> bool {
        let is_misfit = matches!(
            self.code,
            ReasonCode::LowR2 | ReasonCode::Contradicted | ReasonCode::DoesNotFit
        );
        is_misfit || self.is_fault()
    }

    /// Does it limit what an accepted model may be used for?
    pub(super) fn limits(&self) -> bool {
        !matches!(
            (&self.code, &self.of),
            (
                ReasonCode::Ok
                    | ReasonCode::SignReversed
                    | ReasonCode::Quantised
                    | ReasonCode::AcceptedByOperator,
                _
            ) | (ReasonCode::Late, Some(Subject::YawRate))
                | (ReasonCode::Damaged, Some(Subject::Samples))
                | (ReasonCode::Unchecked, Some(Subject::Heading | Subject::Rudder))
        )
    }
}

impl From<ReasonCode> for ReasonKind {
    fn from(code: ReasonCode) -> Self {
        code.alone()
    }
}

impl From<&ReasonCode> for ReasonKind {
    fn from(code: &ReasonCode) -> Self {
        code.clone().alone()
    }
}

impl fmt::Display for ReasonKind {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match &self.of {
            Some(subject) => write!(f, "{} of {subject}", self.code),
            None => self.code.fmt(f),
        }
    }
}

/// Where a reason is read. What to do is said in the words of that place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reader {
    /// A terminal, with the options of the command.
    #[default]
    Terminal,
    /// The dashboard, with its buttons and fields.
    Dashboard,
    /// Python, with the arguments of its functions.
    Python,
}

/// The cause of a reason and what to do about it.
pub(super) struct Words {
    pub kind: ReasonKind,
    pub cause: &'static str,
    /// At a terminal, on the dashboard and in Python.
    actions: [&'static str; 3],
}

impl Words {
    pub fn action(&self, reader: Reader) -> &'static str {
        self.actions[reader as usize]
    }
}

const fn same(kind: ReasonKind, cause: &'static str, action: &'static str) -> Words {
    each(kind, cause, [action; 3])
}

const fn each(kind: ReasonKind, cause: &'static str, actions: [&'static str; 3]) -> Words {
    Words { kind, cause, actions }
}

/// The words of a reason. `None` where every reason of this kind says its own.
pub(super) fn words(kind: &ReasonKind) -> Option<&'static Words> {
    WORDS.iter().find(|words| words.kind == *kind)
}

/// The words of every kind of reason that does not say its own.
#[rustfmt::skip]
pub(super) static WORDS: &[Words] = &[
    // What is wrong with samples and their times.
    same(TooFewSamples.alone(), "The training window holds too few samples.",
        "Use a longer window, or log faster."),
    same(Damaged.of(Samples), "Many samples of the log are damaged.",
        "Check the clock and the heading channel of the log."),
    same(Damaged.alone(), "A part of the record is damaged.",
        "Take a copy from before the damage."),
    same(SamplesMissing.alone(), "Samples were lost while the rudder moved.",
        "Log without losses."),
    same(ClockJitter.alone(), "The time between samples is uneven.",
        "Log without losses, with the time of the measurement."),
    each(SampledTooSeldom.of(Time), "Rows that differ have the same time.", [
        "Write the time with more digits, or name another column with --time. Where the rows are of several vehicles, read one of them with --where COLUMN=VALUE.",
        "Write the time with more digits, or enter another column for the time. Keep the rows of one vehicle.",
        "Write the time with more digits, or pass columns={\"time\": ...}. Keep the rows of one vehicle.",
    ]),
    each(ClockJumped.alone(), "The clock of the log jumped.", [
        "Use the part before or behind the jump, with --from and --to.",
        "Use the part before or behind the jump.",
        "Use the part before or behind the jump: pass training=(from, to).",
    ]),
    same(SampledTooSeldom.alone(), "Heading or rudder is logged too seldom for this vehicle.",
        "Log both faster: ten samples in the time that a turn takes to die out."),
    // What is wrong with units, signs and columns.
    each(UnitDoubtful.of(Heading), "The heading is not in the unit that it is read in.", [
        "Give its unit with --unit heading=rad or --unit heading=deg.",
        "Choose rad or deg as “Heading is in” under “Columns and units”.",
        "Pass units={\"heading\": \"rad\"} or units={\"heading\": \"deg\"}.",
    ]),
    each(UnitDoubtful.of(Rudder), "The rudder is not in the unit that its column says.", [
        "Give its unit with --unit rudder=rad or --unit rudder=deg.",
        "Choose rad or deg as “Rudder is in” under “Columns and units”.",
        "Pass units={\"rudder\": \"rad\"} or units={\"rudder\": \"deg\"}.",
    ]),
    each(UnitUnknown.of(Rudder), "Nothing in the log says in which unit the rudder is.", [
        "Give its unit with --unit rudder=deg (or rad, fraction, percent).",
        "Choose deg, rad, fraction or percent as “Rudder is in” under “Columns and units”.",
        "Pass units={\"rudder\": \"deg\"} (or rad, fraction, percent).",
    ]),
    same(CourseForHeading.alone(), "The heading is a course or track, where the vehicle goes, not where it points.",
        "Log the heading of a compass, and take its column."),
    each(UnitDoubtful.of(Time), "The time is not in the unit that its column says.", [
        "Give its unit with --unit time=s (or ms, us, min, h, d), or another column with --time.",
        "Choose the unit as “Time is in” under “Columns and units”, or another column for the time.",
        "Pass units={\"time\": \"s\"} (or ms, us, min, h, d), or columns={\"time\": ...}.",
    ]),
    each(Unchecked.of(Time), "Nothing in the log shows that a row takes a second.", [
        "Where it does, say --unit time=s.",
        "Where it does, choose s as “Time is in” under “Columns and units”.",
        "Where it does, pass units={\"time\": \"s\"}.",
    ]),
    each(YawRateContradicts.alone(), "The yaw rate contradicts the heading.", [
        "Give the right unit, such as --unit yaw_rate=deg/s or --unit time=ms, or leave it out with --yaw-rate none.",
        "Choose the right unit of the yaw rate or the time under “Columns and units”, or leave the column of the yaw rate out.",
        "Pass the right unit, such as units={\"yaw_rate\": \"deg/s\"}, or columns={\"yaw_rate\": \"none\"}.",
    ]),
    each(SignReversed.of(YawRate), "The yaw rate has the opposite sign of the heading and was not used.", [
        "Reverse it in a --channels file, or leave it out with --yaw-rate none.",
        "Leave the column of the yaw rate out under “Columns and units”.",
        "Reverse it in a channels_file, or pass columns={\"yaw_rate\": \"none\"}.",
    ]),
    // What is wrong with compass or gyro.
    same(Constant.of(Heading), "The heading did not change while the rudder moved.",
        "Check that the compass works and is logged."),
    same(Quantised.alone(), "The heading is logged in coarse steps.",
        "Log the heading with more digits, or turn further."),
    same(CompassError.alone(), "The compass jumped, stuck or was disturbed.",
        "Repeat the run away from iron and electric currents."),
    same(YawRateContradicts.of(Heading), "Compass and gyro disagree on how far the vehicle turned.",
        "Swing the compass, or turn a full circle and compare the gyro with 360 deg."),
    same(Late.of(Heading), "The heading is logged later than it was measured.",
        "Log the heading with the time of its measurement."),
    same(Late.of(YawRate), "The yaw rate is logged later than the heading.",
        "Nothing for the model; filter the gyro less where a controller uses it."),
    same(SampledTooSeldom.of(Heading), "The heading changes less often than rows are written.",
        "Log every heading once, with the time of its measurement."),
    same(Unchecked.of(Heading), "The log has no yaw rate to check the compass with.",
        "Log the yaw rate of a gyro, or swing the compass."),
    // What is wrong with the rudder.
    same(Constant.of(Rudder), "No manoeuvre: the rudder hardly moved.",
        "Steer a doublet: the rudder to one side, then to the other."),
    same(SampledTooSeldom.of(Rudder), "The rudder changes less often than rows are written.",
        "Log the rudder as often as the heading."),
    same(Unchecked.of(Rudder), "Nothing in the log shows that the rudder reached its angle.",
        "Log the measured rudder angle."),
    same(RudderNotFollowed.alone(), "The rudder seems to stop before the angle that was asked for.",
        "Look at the measured rudder angle, and repeat with a smaller one."),
    same(RudderNotFollowed.of(Rudder), "The rudder seems to have stuck.",
        "Free the rudder and look at its linkage and servo, then repeat the run."),
    same(RudderNotFollowed.of(Linkage), "The rudder seems to have play.",
        "Take the slack out of the linkage, or log the measured rudder angle."),
    each(LagUnknown.alone(), "The rudder may follow its command late, and the log does not show how late.", [
        "Log the measured rudder angle and say --rudder-lag 0, or give the lag of the servo with --rudder-lag.",
        "Log the measured rudder angle, or enter the time constant of the servo, 0 of a measured angle.",
        "Log the measured rudder angle and pass rudder_lag_s=0, or pass the lag of the servo.",
    ]),
    same(SignReversed.of(Rudder), "A positive rudder angle turns the vehicle to decreasing heading.",
        "Keep this sign, or reverse the rudder channel."),
    // What is wrong with the model.
    same(NotIdentifiable.alone(), "The log does not show how the heading follows the rudder.",
        "Check both channels, then repeat with more rudder to both sides."),
    same(UnderExcited.alone(), "The manoeuvre was too small: the model is too uncertain.",
        "Repeat the manoeuvre with more rudder, or several times."),
    same(DoesNotFit.alone(), "The model does not describe its own record.",
        "Repeat the manoeuvre in calmer water, with more rudder and no autopilot; log the heading unfiltered."),
    same(Unstable.alone(), "The vehicle does not stop turning by itself, or the log does not show it.",
        "Repeat the manoeuvre with a longer pause after it: gains need a stable model."),
    same(Contradicted.of(Training), "Two ways to estimate the model disagree.",
        "Repeat the manoeuvre in calmer water, with nothing but the rudder turning the vehicle."),
    same(ModelOrder.of(Residual), "The errors of the model are not random: a slow servo, waves or a filtered compass.",
        "Log the measured rudder angle and the unfiltered compass, in calmer water."),
    same(ModelOrder.alone(), "The vehicle does more than a first-order model can describe.",
        "Use the model only for rudder angles and turns like those of the log."),
    same(Disturbed.alone(), "Waves, gusts or a current turned the vehicle as well.",
        "For narrower bounds repeat in calmer water, or with more rudder."),
    same(Drifted.of(Speed), "The speed was not the same throughout.",
        "Wait longer at each speed before the manoeuvre, or use less rudder."),
    // What validation data say.
    same(LowR2.alone(), "The model does not predict data that it was not trained on.",
        "Check that the rudder goes where it is told and that the compass did not jump, then repeat the run."),
    each(NotValidated.alone(), "No data were held out to check the model.", [
        "Validate on a second manoeuvre: --validate-from and --validate-to, or --validate-on LOG; of several logs, one more.",
        "Record a second manoeuvre at this speed, and open the log that holds both.",
        "Check it on a second manoeuvre: pass validation=(from, to), or validate_on.",
    ]),
    same(Drifted.of(Offset), "The rudder that holds a straight course changed between training and validation.",
        "Use the gains. Find that rudder again; if wind, current and trim were steady, look for play in the linkage."),
    same(Contradicted.alone(), "The validation data give another model than the training data.",
        "Check the measured rudder angle and the compass, then train again."),
    same(UnderExcited.of(Validation), "The validation manoeuvre was too small to show a wrong model.",
        "Validate with more rudder, with more manoeuvres or in calmer water."),
    same(Extrapolating.alone(), "The validation data leave the range of rudder, heading or speed that the model was trained in.",
        "Train with the rudder and at the speed that you mean to use."),
    // What is wrong on the axis of pitch.
    same(Constant.of(Elevator), "The elevator did not move.",
        "Command an elevator doublet of some degrees: up, then down."),
    same(Unstable.of(Pitch), "The pitch is not damped, or the log does not show it.",
        "Repeat the manoeuvre with a longer pause after it: gains need a damped vehicle."),
    same(NotIdentifiable.of(Pitch), "The elevator does not explain how the vehicle pitched.",
        "Check both channels, then repeat with more elevator to both sides."),
    // What several manoeuvres or speeds say together.
    same(ManoeuvresDiffer.alone(), "Manoeuvres at one speed give different models.",
        "Check load, trim and fins, and repeat the manoeuvres."),
    each(ManoeuvresDiffer.of(Speed), "The manoeuvres give different models, and the log has no speed: they may be of several speeds.", [
        "Name the column of the speed with --speed, or take the manoeuvres of one speed with --from and --to.",
        "Choose “Forward speed from column” under “Columns and units”, or drag the windows over the manoeuvres of one speed.",
        "Pass columns={\"speed\": ...}, or training=(from, to) with the manoeuvres of one speed.",
    ]),
    same(RunRepeated.alone(), "A run was refused and repeated.",
        "Find the fault before the vehicle relies on it: the models are those of sound runs, but it may come back."),
    same(SpeedsDiffer.of(Speed), "The speed fell although the thrust rose.",
        "Check propeller, battery and current, and repeat both speeds."),
    same(SpeedsDiffer.of(Rudder), "The rudder's effect changes over speed as that of one vehicle does not.",
        "Look at fins, propeller and load, then repeat both speeds."),
    same(SpeedsDiffer.of(Damping), "The damping changes over speed as that of one vehicle does not.",
        "Look at fins, propeller and load, then repeat both speeds."),
];
