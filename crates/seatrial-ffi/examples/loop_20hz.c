/* A bare 20 Hz loop: one sea trial, then the gains and turning limits of what it found. The vehicle here is an equation;
 * put your sensors and your rudder where read_sensors and steer stand. */
#include <math.h>
#include <stdio.h>

#include "seatrial.h"

#define INTERVAL_S 0.05
#define RUDDER_LIMIT_RAD 0.26
#define MOST_SAMPLES 20000

static double trial_memory[SEATRIAL_TRIAL_BYTES / sizeof(double)];

static double heading_rad, yaw_rate_rad_s, rudder_rad, thrust = 0.7, time_s;

static SeatrialSample read_sensors(void)
{
    SeatrialSample sample;
    sample.time_s = time_s;
    sample.heading_rad = (SeatrialNumber)heading_rad;
    sample.rudder_rad = (SeatrialNumber)rudder_rad;
    sample.surge_speed_m_s = (SeatrialNumber)(2.0 * thrust);
    sample.yaw_rate_rad_s = (SeatrialNumber)yaw_rate_rad_s;
    sample.depth_m = sample.altitude_m = (SeatrialNumber)NAN; /* not measured */
    sample.roll_rad = sample.pitch_rad = (SeatrialNumber)NAN;
    sample.north_m = sample.east_m = (SeatrialNumber)NAN;
    return sample;
}

static void steer(const SeatrialAction *action)
{
    if (action->steering == SEATRIAL_STEERING_RUDDER) {
        rudder_rad = action->steering_rad;
    } else {
        rudder_rad = 0.3 * (action->steering_rad - heading_rad); /* the vehicle's own heading controller */
    }
    if (!isnan(action->thrust)) {
        thrust = action->thrust;
    }
}

static void wait_for_the_next_tick(void)
{
    double b2_per_s2 = 0.42 * (2.0 * thrust) * (2.0 * thrust);
    int millisecond;
    for (millisecond = 0; millisecond < 50; millisecond++) {
        heading_rad += 0.001 * yaw_rate_rad_s;
        yaw_rate_rad_s += 0.001 * (-1.07 * yaw_rate_rad_s + b2_per_s2 * rudder_rad + 0.012);
    }
    time_s += INTERVAL_S;
}

int main(void)
{
    SeatrialPlan plan;
    SeatrialTrial *trial;
    SeatrialFault fault;
    SeatrialAction action;
    SeatrialRunResult result;
    SeatrialSchedulePoint points[SEATRIAL_SPEEDS];
    SeatrialHeadingGain gain;
    SeatrialTurn turn;
    SeatrialStatus status;
    size_t runs = 0;
    long sample_number;

    (void)seatrial_plan(1.0 / 1.07, INTERVAL_S, &plan);
    plan.speeds = 2;
    plan.thrusts[0] = (SeatrialNumber)0.7;
    plan.thrusts[1] = (SeatrialNumber)0.9;
    plan.rudder_limit_rad = (SeatrialNumber)RUDDER_LIMIT_RAD;
    status = seatrial_trial_new(trial_memory, sizeof trial_memory, &plan, &trial, &fault);
    if (status == SEATRIAL_STATUS_INVALID_SETTING) {
        printf("%.*s must be %.*s\n", (int)fault.field_length, fault.field,
               (int)fault.requirement_length, fault.requirement);
    }
    if (status != SEATRIAL_STATUS_OK) {
        return 1;
    }

    action.outcome = SEATRIAL_OUTCOME_UNDER_WAY;
    for (sample_number = 0; sample_number < MOST_SAMPLES; sample_number++) {
        SeatrialSample sample = read_sensors();
        if (seatrial_trial_step(trial, &sample, &action) != SEATRIAL_STATUS_OK) {
            return 1;
        }
        while (seatrial_trial_take_result(trial, &result) == SEATRIAL_STATUS_OK) {
            printf("thrust %.1f: a22 %.4f 1/s, b2 %.4f 1/s^2, C0 %.4f rad/s^2, R2 %.3f\n",
                   (double)result.thrust, (double)result.model.a22_per_s,
                   (double)result.model.b2_per_s2, (double)result.model.c0_rad_per_s2,
                   (double)result.r2_heading);
            if (result.accepted && runs < SEATRIAL_SPEEDS) {
                points[runs].thrust = result.thrust;
                points[runs].surge_speed_m_s = result.surge_speed_m_s;
                points[runs].model = result.model;
                runs += 1;
            }
        }
        if (action.outcome != SEATRIAL_OUTCOME_UNDER_WAY) {
            break;
        }
        /* A sample says which rudder acts from its own time on. An action carried out at once, after the sample, would
         * contradict it and shift a22 by 10 %: so it is carried out at the next tick, before that tick's sample. */
        wait_for_the_next_tick();
        steer(&action);
    }
    if (action.outcome != SEATRIAL_OUTCOME_FINISHED || runs < 2) {
        return 1;
    }

    status = seatrial_schedule_gain(points, runs, SEATRIAL_SCHEDULE_KEY_THRUST,
                                    (SeatrialNumber)0.7071, (SeatrialNumber)0.8, false, &gain, NULL);
    if (status != SEATRIAL_STATUS_OK) {
        return 1;
    }
    printf("thrust 0.8: rudder = %.4f * heading error %+.4f rad\n", (double)gain.proportional_gain,
           (double)gain.feed_forward_rudder_rad);
    status = seatrial_turn(&points[0].model, (SeatrialNumber)RUDDER_LIMIT_RAD,
                           points[0].surge_speed_m_s, true, &turn);
    if (status != SEATRIAL_STATUS_OK) {
        return 1;
    }
    printf("thrust %.1f: U-turn of %.1f s, steady radius %.2f m\n", (double)points[0].thrust,
           (double)turn.u_turn_time_s, (double)turn.steady_turning_radius_m);
    return 0;
}
