/* Generated from crates/seatrial-ffi; docs/embedding.md says how to use it. */

#ifndef SEATRIAL_H
#define SEATRIAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Functions by which a program enters the library have names that say which library: this header, and with or without
 * SEATRIAL_SINGLE, links with its own library only. */
#if defined(SEATRIAL_SINGLE)
#define SEATRIAL_OF_THIS_LIBRARY(name) name##_abi1_single
#else
#define SEATRIAL_OF_THIS_LIBRARY(name) name##_abi1_double
#endif
#define seatrial_plan SEATRIAL_OF_THIS_LIBRARY(seatrial_plan)
#define seatrial_trial_new SEATRIAL_OF_THIS_LIBRARY(seatrial_trial_new)
#define seatrial_estimator_settings SEATRIAL_OF_THIS_LIBRARY(seatrial_estimator_settings)
#define seatrial_estimator_settings_paper SEATRIAL_OF_THIS_LIBRARY(seatrial_estimator_settings_paper)
#define seatrial_estimator_new SEATRIAL_OF_THIS_LIBRARY(seatrial_estimator_new)
#define seatrial_fixed_rate_settings SEATRIAL_OF_THIS_LIBRARY(seatrial_fixed_rate_settings)
#define seatrial_fixed_rate_new SEATRIAL_OF_THIS_LIBRARY(seatrial_fixed_rate_new)
#define seatrial_heading_gain SEATRIAL_OF_THIS_LIBRARY(seatrial_heading_gain)
#define seatrial_turn SEATRIAL_OF_THIS_LIBRARY(seatrial_turn)
#define seatrial_schedule_lookup SEATRIAL_OF_THIS_LIBRARY(seatrial_schedule_lookup)
#define seatrial_schedule_gain SEATRIAL_OF_THIS_LIBRARY(seatrial_schedule_gain)

/*
 Most points of a schedule.
 */
#define SEATRIAL_SCHEDULE_POINTS 16

/*
 Version of the sizes and layouts in the header. It goes up with every change of them that a program notices.
 */
#define SEATRIAL_ABI 1

/*
 The library's version.
 */
#define SEATRIAL_VERSION_MAJOR 0

/*
 The library's version.
 */
#define SEATRIAL_VERSION_MINOR 3

/*
 The library's version.
 */
#define SEATRIAL_VERSION_PATCH 0

/*
 Memory that a SeatrialEstimator needs, bytes.
 */
#define SEATRIAL_ESTIMATOR_BYTES 1024

/*
 Memory that a SeatrialFixedRate needs, bytes.
 */
#define SEATRIAL_FIXED_RATE_BYTES 208

/*
 Most speeds of a trial.
 */
#define SEATRIAL_SPEEDS 16

/*
 Most deflections of a switched manoeuvre.
 */
#define SEATRIAL_DEFLECTIONS 8

/*
 Most corners of the area.
 */
#define SEATRIAL_AREA_CORNERS 16

/*
 Memory that a SeatrialTrial needs, bytes.
 */
#define SEATRIAL_TRIAL_BYTES 6144

/*
 What became of a call.
 */
enum SeatrialStatus
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   Done.
   */
  SEATRIAL_STATUS_OK = 0,
  /*
   A pointer is null.
   */
  SEATRIAL_STATUS_NULL_POINTER = 1,
  /*
   The memory is smaller than the object.
   */
  SEATRIAL_STATUS_WRONG_SIZE = 2,
  /*
   A pointer is not aligned for what it points to.
   */
  SEATRIAL_STATUS_MISALIGNED = 3,
  /*
   There is no such object at this address.
   */
  SEATRIAL_STATUS_NOT_MADE = 4,
  /*
   A setting is out of range; SeatrialFault says which.
   */
  SEATRIAL_STATUS_INVALID_SETTING = 5,
  /*
   The sample is no number, or does not follow on the one before; nothing was learnt from it.
   */
  SEATRIAL_STATUS_REFUSED = 6,
  /*
   No event is waiting.
   */
  SEATRIAL_STATUS_NO_EVENT = 7,
  /*
   The model is unstable on course: no gain, no steady turn.
   */
  SEATRIAL_STATUS_COURSE_UNSTABLE = 8,
  /*
   The rudder does not turn the vehicle, or not to this side.
   */
  SEATRIAL_STATUS_NO_AUTHORITY = 9,
  /*
   Outside the schedule's range, and not to be extrapolated, or not so far.
   */
  SEATRIAL_STATUS_OUTSIDE_RANGE = 10,
  /*
   No schedule can be made of these points.
   */
  SEATRIAL_STATUS_INVALID_SCHEDULE = 11,
  /*
   The library is of another ABI, or its numbers are of another size.
   */
  SEATRIAL_STATUS_WRONG_LIBRARY = 12,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum SeatrialStatus SeatrialStatus;
#else
typedef uint32_t SeatrialStatus;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 What became of a sample.
 */
enum SeatrialIntake
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   The estimate learnt from it.
   */
  SEATRIAL_INTAKE_USED = 0,
  /*
   It only moved the filters, or the instrument could not learn from it.
   */
  SEATRIAL_INTAKE_WARMING = 1,
  /*
   It was refused.
   */
  SEATRIAL_INTAKE_REJECTED = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum SeatrialIntake SeatrialIntake;
#else
typedef uint32_t SeatrialIntake;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 How the vehicle is to steer.
 */
enum SeatrialSteering
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   Hold this rudder angle.
   */
  SEATRIAL_STEERING_RUDDER = 0,
  /*
   The vehicle's heading controller holds this heading.
   */
  SEATRIAL_STEERING_HOLD_HEADING = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum SeatrialSteering SeatrialSteering;
#else
typedef uint32_t SeatrialSteering;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 How a trial ended.
 */
enum SeatrialOutcome
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   It has not.
   */
  SEATRIAL_OUTCOME_UNDER_WAY = 0,
  /*
   Every speed was run.
   */
  SEATRIAL_OUTCOME_FINISHED = 1,
  /*
   Stopped, see the reason.
   */
  SEATRIAL_OUTCOME_ABORTED = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum SeatrialOutcome SeatrialOutcome;
#else
typedef uint32_t SeatrialOutcome;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Why a trial was stopped.
 */
enum SeatrialAbortReason
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   It was not.
   */
  SEATRIAL_ABORT_REASON_NONE = 0,
  /*
   The operator asked for it.
   */
  SEATRIAL_ABORT_REASON_OPERATOR = 1,
  /*
   Depth outside the envelope.
   */
  SEATRIAL_ABORT_REASON_DEPTH = 2,
  /*
   Too close to the bottom.
   */
  SEATRIAL_ABORT_REASON_ALTITUDE = 3,
  /*
   Roll outside the envelope.
   */
  SEATRIAL_ABORT_REASON_ROLL = 4,
  /*
   Pitch outside the envelope.
   */
  SEATRIAL_ABORT_REASON_PITCH = 5,
  /*
   Yaw rate outside the envelope.
   */
  SEATRIAL_ABORT_REASON_YAW_RATE = 6,
  /*
   Heading too far from the heading of the run.
   */
  SEATRIAL_ABORT_REASON_HEADING_EXCURSION = 7,
  /*
   Outside the area.
   */
  SEATRIAL_ABORT_REASON_AREA = 8,
  /*
   Speed changed too much during a stage.
   */
  SEATRIAL_ABORT_REASON_SPEED_DRIFT = 9,
  /*
   No new usable sample for too long.
   */
  SEATRIAL_ABORT_REASON_STALE_SAMPLES = 10,
  /*
   A stage took longer than its limit.
   */
  SEATRIAL_ABORT_REASON_STAGE_TIME_LIMIT = 11,
  /*
   The vehicle turned against the rudder.
   */
  SEATRIAL_ABORT_REASON_REVERSED_RUDDER = 12,
  /*
   The vehicle did not settle.
   */
  SEATRIAL_ABORT_REASON_NOT_SETTLED = 13,
  /*
   The link to the vehicle was lost.
   */
  SEATRIAL_ABORT_REASON_LINK_LOST = 14,
  /*
   The pilot changed the mode.
   */
  SEATRIAL_ABORT_REASON_MODE_CHANGED = 15,
  /*
   The pilot moved a stick.
   */
  SEATRIAL_ABORT_REASON_STICK_MOVED = 16,
  /*
   The vehicle was disarmed.
   */
  SEATRIAL_ABORT_REASON_DISARMED = 17,
  /*
   The battery was low.
   */
  SEATRIAL_ABORT_REASON_LOW_BATTERY = 18,
  /*
   The autopilot reported a failsafe.
   */
  SEATRIAL_ABORT_REASON_FAILSAFE = 19,
  /*
   The autopilot started again.
   */
  SEATRIAL_ABORT_REASON_RESTARTED = 20,
  /*
   Somebody else commanded the vehicle under our name.
   */
  SEATRIAL_ABORT_REASON_SECOND_STATION = 21,
  /*
   The rudder did something else than asked for.
   */
  SEATRIAL_ABORT_REASON_RUDDER_NOT_FOLLOWED = 22,
  /*
   The program that conducts the trial was held up.
   */
  SEATRIAL_ABORT_REASON_NOT_ATTENDED = 23,
  /*
   The heading did not answer the rudder.
   */
  SEATRIAL_ABORT_REASON_NO_ANSWER = 24,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum SeatrialAbortReason SeatrialAbortReason;
#else
typedef uint32_t SeatrialAbortReason;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 The stages of a run.
 */
enum SeatrialStage
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   Before the first sample or after the end.
   */
  SEATRIAL_STAGE_NONE = 0,
  /*
   Waiting for a steady vehicle.
   */
  SEATRIAL_STAGE_SETTLE = 1,
  /*
   Estimating.
   */
  SEATRIAL_STAGE_TRAIN = 2,
  /*
   Recording the validation manoeuvre.
   */
  SEATRIAL_STAGE_VALIDATE = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum SeatrialStage SeatrialStage;
#else
typedef uint32_t SeatrialStage;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Rudder manoeuvres.
 */
typedef enum SeatrialExcitation {
  /*
   One deflection to each side.
   */
  SEATRIAL_EXCITATION_DOUBLET = 0,
  /*
   Deflections of 3, 2, 1 and 1 units.
   */
  SEATRIAL_EXCITATION_THREE_TWO_ONE_ONE = 1,
  /*
   Deflections to alternating sides, each of its own length.
   */
  SEATRIAL_EXCITATION_SWITCHED = 2,
  /*
   A sum of cosines.
   */
  SEATRIAL_EXCITATION_MULTISINE = 3,
} SeatrialExcitation;

/*
 Where the filters start.
 */
typedef enum SeatrialFilterStart {
  /*
   At zero, as the paper does.
   */
  SEATRIAL_FILTER_START_ZERO = 0,
  /*
   As if the first value had always been.
   */
  SEATRIAL_FILTER_START_EQUILIBRIUM = 1,
} SeatrialFilterStart;

/*
 How a signal runs between two samples.
 */
typedef enum SeatrialHold {
  /*
   Constant.
   */
  SEATRIAL_HOLD_ZERO_ORDER = 0,
  /*
   On a straight line.
   */
  SEATRIAL_HOLD_FIRST_ORDER = 1,
} SeatrialHold;

/*
 How the rudder ran while samples were lost.
 */
typedef enum SeatrialLostRudder {
  /*
   It waited.
   */
  SEATRIAL_LOST_RUDDER_HELD = 0,
  /*
   It moved in equal steps.
   */
  SEATRIAL_LOST_RUDDER_INTERPOLATED = 1,
} SeatrialLostRudder;

/*
 How the parameters are estimated.
 */
typedef enum SeatrialMethod {
  /*
   Recursive least squares throughout.
   */
  SEATRIAL_METHOD_LEAST_SQUARES = 0,
  /*
   The recursive instrumental variable after the excitation.
   */
  SEATRIAL_METHOD_INSTRUMENTAL_VARIABLE = 1,
} SeatrialMethod;

/*
 What to do with a vehicle that does not become steady.
 */
typedef enum SeatrialNotSettled {
  /*
   Begin all the same.
   */
  SEATRIAL_NOT_SETTLED_GO_ON = 0,
  /*
   Abort the trial.
   */
  SEATRIAL_NOT_SETTLED_ABORT = 1,
} SeatrialNotSettled;

/*
 Which way the vehicle is expected to turn.
 */
typedef enum SeatrialRudderSense {
  /*
   Positive rudder increases the heading.
   */
  SEATRIAL_RUDDER_SENSE_POSITIVE = 0,
  /*
   Positive rudder decreases the heading.
   */
  SEATRIAL_RUDDER_SENSE_NEGATIVE = 1,
  /*
   Not known.
   */
  SEATRIAL_RUDDER_SENSE_UNKNOWN = 2,
} SeatrialRudderSense;

/*
 What a schedule is looked up by.
 */
typedef enum SeatrialScheduleKey {
  /*
   Thrust as a fraction of full.
   */
  SEATRIAL_SCHEDULE_KEY_THRUST = 0,
  /*
   Forward speed, m/s.
   */
  SEATRIAL_SCHEDULE_KEY_SPEED = 1,
} SeatrialScheduleKey;

/*
 The guarded estimator: seatrial_core::Estimator.
 */
typedef struct SeatrialEstimator SeatrialEstimator;

/*
 The lean estimator for a loop of fixed rate: seatrial_core::FixedRateEstimator.
 */
typedef struct SeatrialFixedRate SeatrialFixedRate;

/*
 A sea trial: seatrial_core::Trial.
 */
typedef struct SeatrialTrial SeatrialTrial;

#if !defined(SEATRIAL_SINGLE)
/*
 A number that is no time.
 */
typedef double SeatrialNumber;
#endif

#if defined(SEATRIAL_SINGLE)
/*
 A number that is no time.
 */
typedef float SeatrialNumber;
#endif

/*
 First-order yaw model r' = a22 r + b2 delta + C0.
 */
typedef struct SeatrialModel {
  /*
   a22, 1/s.
   */
  SeatrialNumber a22_per_s;
  /*
   b2, 1/s^2.
   */
  SeatrialNumber b2_per_s2;
  /*
   C0, rad/s^2.
   */
  SeatrialNumber c0_rad_per_s2;
} SeatrialModel;

/*
 Rudder = proportional_gain times heading error + feed_forward_rudder_rad.
 */
typedef struct SeatrialHeadingGain {
  /*
   Rudder per heading error; has the sign of b2.
   */
  SeatrialNumber proportional_gain;
  /*
   The rudder that holds a constant heading, rad.
   */
  SeatrialNumber feed_forward_rudder_rad;
} SeatrialHeadingGain;

/*
 A turn under the full rudder to one side.
 */
typedef struct SeatrialTurn {
  /*
   The full rudder to that side with its sign, rad.
   */
  SeatrialNumber rudder_rad;
  /*
   Magnitude of the steady yaw rate, rad/s.
   */
  SeatrialNumber yaw_rate_rad_s;
  /*
   Time until the yaw rate is within 2 %, s.
   */
  SeatrialNumber rise_time_s;
  /*
   Time of a U-turn by the paper's profile, s.
   */
  SeatrialNumber u_turn_time_s;
  /*
   Its path length over pi, m.
   */
  SeatrialNumber u_turn_mean_radius_m;
  /*
   Radius of the circle that a long turn draws, m.
   */
  SeatrialNumber steady_turning_radius_m;
} SeatrialTurn;

/*
 The model of one speed. NaN: not known.
 */
typedef struct SeatrialSchedulePoint {
  /*
   Thrust as a fraction of full.
   */
  SeatrialNumber thrust;
  /*
   Forward speed, m/s.
   */
  SeatrialNumber surge_speed_m_s;
  /*
   The model identified there.
   */
  struct SeatrialModel model;
} SeatrialSchedulePoint;

/*
 How a SeatrialEstimator works: seatrial_core::EstimatorSettings, with NaN for what is absent.
 */
typedef struct SeatrialEstimatorSettings {
  /*
   The filters' double pole, rad/s.
   */
  SeatrialNumber lambda_rad_s;
  /*
   P0 = this times I.
   */
  SeatrialNumber initial_covariance;
  /*
   Factor on the weight of every earlier sample when the next one comes, in (0, 1]; 1 forgets nothing.
   */
  SeatrialNumber forgetting_factor;
  /*
   Largest step of the estimate that counts as converged.
   */
  SeatrialNumber convergence_threshold;
  /*
   A longer silence than this many filter time constants 1/lambda is a gap. NaN: none is.
   */
  SeatrialNumber gap_time_constants;
  /*
   After a gap nothing is learnt for this many filter time constants 1/lambda.
   */
  SeatrialNumber warm_time_constants;
  /*
   A heading further off than this is a spike, rad. NaN: none is.
   */
  SeatrialNumber heading_jump_rad;
  /*
   Fastest change of heading, rad/s.
   */
  SeatrialNumber max_yaw_rate_rad_s;
  /*
   Samples in a row that must stay under the threshold.
   */
  uint32_t convergence_consecutive;
  /*
   Both in the vehicle's own time? 0 or 1.
   */
  uint32_t convergence_in_own_time;
  /*
   After this many samples refused in a row the last of them is the new level.
   */
  uint32_t refused_in_a_row;
  /*
   A SeatrialHold, of the heading.
   */
  uint32_t heading_hold;
  /*
   A SeatrialFilterStart.
   */
  uint32_t filter_start;
  /*
   A SeatrialLostRudder.
   */
  uint32_t lost_rudder;
  /*
   A SeatrialMethod.
   */
  uint32_t method;
} SeatrialEstimatorSettings;

/*
 Which setting is out of range, and what it has to be: texts that live as long as the program, not ended by a zero.
 */
typedef struct SeatrialFault {
  /*
   The field.
   */
  const char *field;
  /*
   Its length.
   */
  size_t field_length;
  /*
   What it has to be.
   */
  const char *requirement;
  /*
   Its length.
   */
  size_t requirement_length;
} SeatrialFault;

/*
 What an estimator knows.
 */
typedef struct SeatrialEstimate {
  /*
   The estimate.
   */
  struct SeatrialModel model;
  /*
   That of plain least squares, which runs on beside the instrument.
   */
  struct SeatrialModel least_squares_model;
  /*
   P of plain least squares.
   */
  SeatrialNumber covariance[3][3];
  /*
   Length of the latest step of the estimate.
   */
  SeatrialNumber step_norm;
  /*
   Seconds from the first training sample to convergence; NaN before.
   */
  double converged_s;
  /*
   Samples refused: no number.
   */
  uint32_t rejected_non_finite;
  /*
   Samples refused: same time again.
   */
  uint32_t rejected_repeated_time;
  /*
   Samples refused: time ran backwards.
   */
  uint32_t rejected_reversed_time;
  /*
   Samples refused: impossible heading.
   */
  uint32_t rejected_spike;
  /*
   Silences over which the filters could not be carried.
   */
  uint32_t gaps;
  /*
   Lasting jumps of heading or clock.
   */
  uint32_t discontinuities;
} SeatrialEstimate;

/*
 How a SeatrialFixedRate works.
 */
typedef struct SeatrialFixedRateSettings {
  /*
   Time between samples, s.
   */
  SeatrialNumber sample_interval_s;
  /*
   The filters' double pole, rad/s.
   */
  SeatrialNumber lambda_rad_s;
  /*
   P0 = this times I.
   */
  SeatrialNumber initial_covariance;
  /*
   A SeatrialHold, of the heading.
   */
  uint32_t heading_hold;
  /*
   A SeatrialFilterStart.
   */
  uint32_t filter_start;
} SeatrialFixedRateSettings;

/*
 A stage with a manoeuvre: steady, manoeuvre, observe.
 */
typedef struct SeatrialManoeuvre {
  /*
   Heading hold before the manoeuvre, s.
   */
  double lead_in_s;
  /*
   Heading hold after it, s.
   */
  double observe_s;
  /*
   Period of a doublet or multisine, unit of a 3-2-1-1, s.
   */
  double period_s;
  /*
   Lengths of the deflections of a switched manoeuvre, s.
   */
  double deflections_s[SEATRIAL_DEFLECTIONS];
  /*
   The first deflection, rad.
   */
  SeatrialNumber amplitude_rad;
  /*
   A SeatrialExcitation.
   */
  uint32_t excitation;
  /*
   Deflections of a switched manoeuvre.
   */
  uint32_t deflections;
  /*
   Tones of a multisine.
   */
  uint32_t tones;
} SeatrialManoeuvre;

/*
 The plan of a trial: seatrial_core::Plan.
 */
typedef struct SeatrialPlan {
  /*
   Training stage.
   */
  struct SeatrialManoeuvre training;
  /*
   Validation stage.
   */
  struct SeatrialManoeuvre validation;
  /*
   Time between samples that the vehicle is expected to keep, s.
   */
  double sample_interval_s;
  /*
   Settling: length of a piece of record that must be steady, s.
   */
  double settle_steady_for_s;
  /*
   Settle at least so long, s.
   */
  double settle_at_least_s;
  /*
   Settle at most so long, s.
   */
  double settle_at_most_s;
  /*
   Longest silence, s.
   */
  double stale_after_s;
  /*
   Longest stage, s.
   */
  double stage_time_limit_s;
  /*
   The speeds, as thrust in fractions of full.
   */
  SeatrialNumber thrusts[SEATRIAL_SPEEDS];
  /*
   Corners [north, east] of the area, m.
   */
  SeatrialNumber area_m[SEATRIAL_AREA_CORNERS][2];
  /*
   Largest rudder that the trial commands, rad.
   */
  SeatrialNumber rudder_limit_rad;
  /*
   A run is accepted from this R^2 of heading on.
   */
  SeatrialNumber accept_from_r2;
  /*
   Settling: mean heading from the heading of the run, rad.
   */
  SeatrialNumber settle_heading_tolerance_rad;
  /*
   Settling: slope of the heading, rad/s.
   */
  SeatrialNumber settle_yaw_rate_tolerance_rad_s;
  /*
   Settling: change of depth, m.
   */
  SeatrialNumber settle_depth_tolerance_m;
  /*
   Settling: change of speed, as a fraction of it.
   */
  SeatrialNumber settle_speed_tolerance;
  /*
   Shallowest depth, m.
   */
  SeatrialNumber depth_min_m;
  /*
   Greatest depth, m.
   */
  SeatrialNumber depth_max_m;
  /*
   Least height above the bottom, m.
   */
  SeatrialNumber altitude_min_m;
  /*
   Greatest roll, rad.
   */
  SeatrialNumber roll_max_rad;
  /*
   Greatest pitch, rad.
   */
  SeatrialNumber pitch_max_rad;
  /*
   Fastest turn, rad/s.
   */
  SeatrialNumber yaw_rate_max_rad_s;
  /*
   Farthest heading from the heading of the run, rad.
   */
  SeatrialNumber heading_excursion_max_rad;
  /*
   Greatest change of speed, as a fraction.
   */
  SeatrialNumber speed_drift_max;
  /*
   Speeds in thrusts.
   */
  uint32_t speeds;
  /*
   Corners in area_m; 0: anywhere.
   */
  uint32_t area_corners;
  /*
   Times a run that is not accepted is repeated.
   */
  uint32_t max_repeats;
  /*
   End training when the estimate has converged? 0 or 1.
   */
  uint32_t stop_on_convergence;
  /*
   A SeatrialNotSettled.
   */
  uint32_t not_settled;
  /*
   A SeatrialRudderSense.
   */
  uint32_t rudder_sense;
} SeatrialPlan;

/*
 One instant of a vehicle. NaN: not measured.
 */
typedef struct SeatrialSample {
  /*
   The vehicle's own clock, s.
   */
  double time_s;
  /*
   Heading, rad, wrapped or not.
   */
  SeatrialNumber heading_rad;
  /*
   Rudder angle that acts from this instant on, rad.
   */
  SeatrialNumber rudder_rad;
  /*
   Forward speed, m/s.
   */
  SeatrialNumber surge_speed_m_s;
  /*
   Depth below the surface, m.
   */
  SeatrialNumber depth_m;
  /*
   Height above the bottom, m.
   */
  SeatrialNumber altitude_m;
  /*
   Roll, rad.
   */
  SeatrialNumber roll_rad;
  /*
   Pitch, rad.
   */
  SeatrialNumber pitch_rad;
  /*
   Yaw rate, rad/s.
   */
  SeatrialNumber yaw_rate_rad_s;
  /*
   Position north of the origin, m.
   */
  SeatrialNumber north_m;
  /*
   Position east of the origin, m.
   */
  SeatrialNumber east_m;
} SeatrialSample;

/*
 What the vehicle is to do until the next action.
 */
typedef struct SeatrialAction {
  /*
   Rudder or heading hold.
   */
  SeatrialSteering steering;
  /*
   Its angle, rad.
   */
  SeatrialNumber steering_rad;
  /*
   Thrust as a fraction of full. NaN gives it back to the vehicle.
   */
  SeatrialNumber thrust;
  /*
   Other than under way: this is the last action.
   */
  SeatrialOutcome outcome;
  /*
   Why the trial was stopped, if it was.
   */
  SeatrialAbortReason reason;
} SeatrialAction;

/*
 Where a trial is.
 */
typedef struct SeatrialTrialStatus {
  /*
   Time in the stage, s.
   */
  double elapsed_s;
  /*
   Time until the stage ends at the latest, s.
   */
  double remaining_s;
  /*
   What the estimator knows.
   */
  struct SeatrialEstimate estimate;
  /*
   Thrust of the run as a fraction of full.
   */
  SeatrialNumber thrust;
  /*
   1 for the first run, 0 before it.
   */
  uint32_t run;
  /*
   1 for the first try at this thrust.
   */
  uint32_t attempt;
  /*
   The stage.
   */
  SeatrialStage stage;
  /*
   How the trial ended.
   */
  SeatrialOutcome outcome;
  /*
   Why it was stopped.
   */
  SeatrialAbortReason reason;
} SeatrialTrialStatus;

/*
 A run at one thrust with its result. NaN: not known.
 */
typedef struct SeatrialRunResult {
  /*
   Seconds from the start of training to convergence.
   */
  double converged_s;
  /*
   The estimate.
   */
  struct SeatrialModel model;
  /*
   The estimate of plain least squares on the same samples.
   */
  struct SeatrialModel least_squares_model;
  /*
   P of plain least squares.
   */
  SeatrialNumber covariance[3][3];
  /*
   Thrust as a fraction of full.
   */
  SeatrialNumber thrust;
  /*
   Mean forward speed over the training stage, m/s.
   */
  SeatrialNumber surge_speed_m_s;
  /*
   R^2 of the heading in validation.
   */
  SeatrialNumber r2_heading;
  /*
   R^2 of the yaw rate in validation.
   */
  SeatrialNumber r2_yaw_rate;
  /*
   1 for the first run of the trial.
   */
  uint32_t number;
  /*
   1 for the first try at this thrust.
   */
  uint32_t attempt;
  /*
   Samples that the estimate learnt from.
   */
  uint32_t samples_used;
  /*
   Samples refused during the run.
   */
  uint32_t samples_rejected;
  /*
   Was the vehicle steady before training?
   */
  bool settled;
  /*
   Is R^2 of the heading high enough?
   */
  bool accepted;
} SeatrialRunResult;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 The gain that gives the heading loop this damping ratio; 0.7071 is the paper's.
 */
SeatrialStatus seatrial_heading_gain(const struct SeatrialModel *model,
                                     SeatrialNumber damping_ratio,
                                     struct SeatrialHeadingGain *gain);

/*
 The turn of a model under its full rudder; to starboard, where the heading increases, or to port.
 */
SeatrialStatus seatrial_turn(const struct SeatrialModel *model,
                             SeatrialNumber rudder_limit_rad,
                             SeatrialNumber surge_speed_m_s,
                             bool to_starboard,
                             struct SeatrialTurn *turn);

/*
 The model at a key (a SeatrialScheduleKey) among `count` points in any order. `extrapolated` may be null.
 */
SeatrialStatus seatrial_schedule_lookup(const struct SeatrialSchedulePoint *points,
                                        size_t count,
                                        uint32_t key,
                                        SeatrialNumber at,
                                        bool extrapolate,
                                        struct SeatrialSchedulePoint *found,
                                        bool *extrapolated);

/*
 The heading gain at a key (a SeatrialScheduleKey) among `count` points in any order. `extrapolated` may be null.
 */
SeatrialStatus seatrial_schedule_gain(const struct SeatrialSchedulePoint *points,
                                      size_t count,
                                      uint32_t key,
                                      SeatrialNumber damping_ratio,
                                      SeatrialNumber at,
                                      bool extrapolate,
                                      struct SeatrialHeadingGain *gain,
                                      bool *extrapolated);

/*
 Is the library of the header's ABI and numbers: `seatrial_check_abi(SEATRIAL_ABI, sizeof(SeatrialNumber))`?
 SEATRIAL_STATUS_WRONG_LIBRARY where it is not. For programs that look functions up while they run; any other does not
 link with the wrong library.
 */
SeatrialStatus seatrial_check_abi(uint32_t abi,
                                  size_t number_bytes);

/*
 The improved settings with filters of this lambda, rad/s; 1.5 for the paper's vehicle.
 */
SeatrialStatus seatrial_estimator_settings(SeatrialNumber lambda_rad_s,
                                           struct SeatrialEstimatorSettings *settings);

/*
 What the paper does.
 */
SeatrialStatus seatrial_estimator_settings_paper(struct SeatrialEstimatorSettings *settings);

/*
 Makes an estimator in `memory` of `size` bytes. `fault` may be null.
 */
SeatrialStatus seatrial_estimator_new(void *memory,
                                      size_t size,
                                      const struct SeatrialEstimatorSettings *settings,
                                      struct SeatrialEstimator **estimator,
                                      struct SeatrialFault *fault);

/*
 A sample of the settling phase: moves the filters, learns nothing. `answer` may be null.
 */
SeatrialStatus seatrial_estimator_warm(struct SeatrialEstimator *estimator,
                                       double time_s,
                                       SeatrialNumber heading_rad,
                                       SeatrialNumber rudder_rad,
                                       SeatrialIntake *answer);

/*
 A sample of the training phase. The rudder acts from this instant on. `answer` may be null.
 */
SeatrialStatus seatrial_estimator_update(struct SeatrialEstimator *estimator,
                                         double time_s,
                                         SeatrialNumber heading_rad,
                                         SeatrialNumber rudder_rad,
                                         SeatrialIntake *answer);

/*
 The doublet is over: convergence counts from now on, and the instrument takes over.
 */
SeatrialStatus seatrial_estimator_excitation_ended(struct SeatrialEstimator *estimator);

/*
 Forgets the estimate for the next speed; filters and guard run on.
 */
SeatrialStatus seatrial_estimator_restart(struct SeatrialEstimator *estimator);

/*
 What the estimator knows now.
 */
SeatrialStatus seatrial_estimator_estimate(struct SeatrialEstimator *estimator,
                                           struct SeatrialEstimate *estimate);

/*
 Settings for filters of this lambda at this interval: seatrial_core::FixedRateSettings::for_lambda.
 */
SeatrialStatus seatrial_fixed_rate_settings(SeatrialNumber lambda_rad_s,
                                            SeatrialNumber sample_interval_s,
                                            struct SeatrialFixedRateSettings *settings);

/*
 Makes a lean estimator in `memory` of `size` bytes, at a first sample. `fault` may be null.
 */
SeatrialStatus seatrial_fixed_rate_new(void *memory,
                                       size_t size,
                                       const struct SeatrialFixedRateSettings *settings,
                                       SeatrialNumber heading_rad,
                                       SeatrialNumber rudder_rad,
                                       struct SeatrialFixedRate **estimator,
                                       struct SeatrialFault *fault);

/*
 A sample of the settling phase: moves the filters, learns nothing.
 */
SeatrialStatus seatrial_fixed_rate_settle(struct SeatrialFixedRate *estimator,
                                          SeatrialNumber heading_rad,
                                          SeatrialNumber rudder_rad);

/*
 A sample of the training phase. The rudder acts from this instant on.
 */
SeatrialStatus seatrial_fixed_rate_update(struct SeatrialFixedRate *estimator,
                                          SeatrialNumber heading_rad,
                                          SeatrialNumber rudder_rad);

/*
 Learns from where the filters stand; seatrial_fixed_rate_update does so by itself.
 */
SeatrialStatus seatrial_fixed_rate_learn(struct SeatrialFixedRate *estimator);

/*
 The next samples follow at this interval, s, positive and below 0.5/lambda.
 */
SeatrialStatus seatrial_fixed_rate_set_interval(struct SeatrialFixedRate *estimator,
                                                SeatrialNumber interval_s);

/*
 Forgets the estimate for the next speed; the filters run on.
 */
SeatrialStatus seatrial_fixed_rate_restart(struct SeatrialFixedRate *estimator);

/*
 The estimate.
 */
SeatrialStatus seatrial_fixed_rate_model(struct SeatrialFixedRate *estimator,
                                         struct SeatrialModel *model);

/*
 Its covariance P, row by row: 9 numbers.
 */
SeatrialStatus seatrial_fixed_rate_covariance(struct SeatrialFixedRate *estimator,
                                              SeatrialNumber *covariance);

/*
 The paper's plan for a vehicle whose yaw rate follows the rudder with this time constant, s: 1/1.07 s is the paper's.
 */
SeatrialStatus seatrial_plan(double time_constant_s,
                             double sample_interval_s,
                             struct SeatrialPlan *plan);

/*
 A status as a text, ended by a zero; that of an unknown number, too.
 */
const char *seatrial_status_text(uint32_t status);

/*
 Makes a trial in `memory` of `size` bytes. `fault` may be null.
 */
SeatrialStatus seatrial_trial_new(void *memory,
                                  size_t size,
                                  const struct SeatrialPlan *plan,
                                  struct SeatrialTrial **trial,
                                  struct SeatrialFault *fault);

/*
 Takes in the next sample; the action holds until the next one.
 */
SeatrialStatus seatrial_trial_step(struct SeatrialTrial *trial,
                                   const struct SeatrialSample *sample,
                                   struct SeatrialAction *action);

/*
 Ends the trial for a reason that the samples do not show: SEATRIAL_ABORT_REASON_OPERATOR or ..._LINK_LOST.
 The next action hands the vehicle back.
 */
SeatrialStatus seatrial_trial_abort(struct SeatrialTrial *trial,
                                    uint32_t reason);

/*
 The estimate is good enough: training ends with the next sample, or with the manoeuvre if that is not over yet.
 */
SeatrialStatus seatrial_trial_finish_training(struct SeatrialTrial *trial);

/*
 Where the trial is.
 */
SeatrialStatus seatrial_trial_status(struct SeatrialTrial *trial,
                                     struct SeatrialTrialStatus *value);

/*
 Takes the results of finished runs, the oldest first; SEATRIAL_STATUS_NO_EVENT when there are no more. Ask after
 every step: a trial keeps 8 events, the beginnings of stages among them, and loses what comes after.
 */
SeatrialStatus seatrial_trial_take_result(struct SeatrialTrial *trial,
                                          struct SeatrialRunResult *result);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SEATRIAL_H */


/* A compiler with other sizes or another layout than the library's does not get past these lines. */
#if defined(__cplusplus) && __cplusplus >= 201103L
#define SEATRIAL_HOLDS(condition) static_assert(condition, "not the library's layout")
#elif defined(__STDC_VERSION__) && __STDC_VERSION__ >= 201112L
#define SEATRIAL_HOLDS(condition) _Static_assert(condition, "not the library's layout")
#else
#define SEATRIAL_HOLDS(condition) typedef char seatrial_layout_holds[(condition) ? 1 : -1]
#endif
SEATRIAL_HOLDS(sizeof(bool) == 1 && sizeof(SeatrialStatus) == 4 && sizeof(SeatrialIntake) == 4 &&
               sizeof(SeatrialSteering) == 4 && sizeof(SeatrialOutcome) == 4 &&
               sizeof(SeatrialAbortReason) == 4 && sizeof(SeatrialStage) == 4 &&
               sizeof(SeatrialNumber) == (sizeof(SeatrialNumber) == sizeof(float) ? 4 : 8) &&
               offsetof(SeatrialAction, steering_rad) == sizeof(SeatrialNumber) &&
               offsetof(SeatrialAction, outcome) == 3 * sizeof(SeatrialNumber) &&
               offsetof(SeatrialAction, reason) == 3 * sizeof(SeatrialNumber) + 4 &&
               offsetof(SeatrialTrialStatus, outcome) == offsetof(SeatrialTrialStatus, stage) + 4 &&
               offsetof(SeatrialTrialStatus, reason) == offsetof(SeatrialTrialStatus, stage) + 8);
#undef SEATRIAL_HOLDS
