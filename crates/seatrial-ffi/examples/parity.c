/* Reads a table of parity vectors, passes its samples to the library and compares what comes out, bit for bit.
 *
 *   parity TABLE FILE        TABLE: trial, estimator or fixed_rate
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "seatrial.h"

#define FIELDS 24
#define LINE 1024

static double memory[SEATRIAL_TRIAL_BYTES / sizeof(double)];

static unsigned long line_number;
static unsigned long differences;

static double time_of(const char *field)
{
    uint64_t bits = strtoull(field, NULL, 16);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* NaN where the field is empty: not measured. */
static SeatrialNumber number_of(const char *field)
{
    SeatrialNumber value;
#ifdef SEATRIAL_SINGLE
    uint32_t bits = *field == '\0' ? 0x7fc00000u : (uint32_t)strtoul(field, NULL, 16);
#else
    uint64_t bits = *field == '\0' ? 0x7ff8000000000000u : strtoull(field, NULL, 16);
#endif
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void expect(int holds, const char *what)
{
    if (!holds) {
        printf("line %lu: %s differs\n", line_number, what);
        differences += 1;
    }
}

static void expect_ok(SeatrialStatus status, const char *call)
{
    if (status != SEATRIAL_STATUS_OK) {
        printf("line %lu: %s: %s\n", line_number, call, seatrial_status_text((uint32_t)status));
        differences += 1;
    }
}

static void expect_number(SeatrialNumber found, const char *field, const char *what)
{
    SeatrialNumber expected = number_of(field);
    int both_missing = *field == '\0' && found != found;
    expect(both_missing || memcmp(&found, &expected, sizeof found) == 0, what);
}

static void expect_model(const SeatrialModel *model, char **fields)
{
    expect_number(model->a22_per_s, fields[0], "a22");
    expect_number(model->b2_per_s2, fields[1], "b2");
    expect_number(model->c0_rad_per_s2, fields[2], "C0");
}

/* Six numbers: the upper triangle, row by row. */
static void expect_covariance(SeatrialNumber covariance[3][3], char **fields)
{
    int i, j, k = 0;
    for (i = 0; i < 3; i++) {
        for (j = i; j < 3; j++) {
            expect_number(covariance[i][j], fields[k], "P");
            k += 1;
        }
    }
}

static void trial_row(char **fields)
{
    static const char *const stages[] = {"", "settle", "train", "validate"};
    static const char *const steerings[] = {"rudder", "hold_heading"};
    static const char *const outcomes[] = {"", "finished", "aborted"};
    static SeatrialTrial *trial;
    SeatrialSample sample;
    SeatrialAction action;
    SeatrialTrialStatus now;
    SeatrialRunResult result;

    if (trial == NULL) {
        SeatrialPlan plan;
        expect_ok(seatrial_plan(1.0 / 1.07, 0.05, &plan), "seatrial_plan");
        plan.speeds = 2;
        plan.thrusts[0] = (SeatrialNumber)0.7;
        plan.thrusts[1] = (SeatrialNumber)0.9;
        expect_ok(seatrial_trial_new(memory, sizeof memory, &plan, &trial, NULL),
                  "seatrial_trial_new");
    }
    sample.time_s = time_of(fields[0]);
    sample.heading_rad = number_of(fields[1]);
    sample.rudder_rad = number_of(fields[2]);
    sample.surge_speed_m_s = number_of(fields[3]);
    sample.depth_m = number_of(fields[4]);
    sample.altitude_m = number_of(fields[5]);
    sample.roll_rad = number_of(fields[6]);
    sample.pitch_rad = number_of(fields[7]);
    sample.yaw_rate_rad_s = number_of(fields[8]);
    sample.north_m = number_of("");
    sample.east_m = number_of("");

    expect_ok(seatrial_trial_step(trial, &sample, &action), "seatrial_trial_step");
    expect_ok(seatrial_trial_status(trial, &now), "seatrial_trial_status");
    expect(strcmp(stages[now.stage], fields[9]) == 0, "stage");
    expect(strcmp(steerings[action.steering], fields[10]) == 0, "steering");
    expect_number(action.steering_rad, fields[11], "steering_rad");
    expect_number(action.thrust, fields[12], "thrust");
    expect(strcmp(outcomes[action.outcome], fields[13]) == 0, "outcome");
    expect_model(&now.estimate.model, fields + 14);
    expect_model(&now.estimate.least_squares_model, fields + 17);
    expect_number(now.estimate.step_norm, fields[20], "step_norm");
    while (seatrial_trial_take_result(trial, &result) == SEATRIAL_STATUS_OK) {
        expect(result.accepted, "accepted");
        expect(memcmp(&result.model, &now.estimate.model, sizeof result.model) == 0
                   || now.stage == SEATRIAL_STAGE_SETTLE,
               "model of the run");
    }
}

static void estimator_row(char **fields)
{
    static const char *const intakes[] = {"used", "warming", "rejected"};
    static SeatrialEstimator *estimator;
    SeatrialEstimate now;
    SeatrialIntake intake = SEATRIAL_INTAKE_USED;
    const char *call = fields[0];
    double time_s = time_of(fields[1]);
    SeatrialNumber heading_rad = number_of(fields[2]);
    SeatrialNumber rudder_rad = number_of(fields[3]);

    if (estimator == NULL) {
        SeatrialEstimatorSettings settings;
        expect_ok(seatrial_estimator_settings((SeatrialNumber)1.5, &settings), "settings");
        expect_ok(seatrial_estimator_new(memory, sizeof memory, &settings, &estimator, NULL),
                  "seatrial_estimator_new");
    }
    if (strcmp(call, "warm") == 0) {
        expect_ok(seatrial_estimator_warm(estimator, time_s, heading_rad, rudder_rad, &intake),
                  call);
    } else if (strcmp(call, "update") == 0) {
        expect_ok(seatrial_estimator_update(estimator, time_s, heading_rad, rudder_rad, &intake),
                  call);
    } else if (strcmp(call, "restart") == 0) {
        expect_ok(seatrial_estimator_restart(estimator), call);
    } else {
        expect_ok(seatrial_estimator_excitation_ended(estimator), call);
    }
    expect(*fields[4] == '\0' || strcmp(intakes[intake], fields[4]) == 0, "intake");
    expect_ok(seatrial_estimator_estimate(estimator, &now), "seatrial_estimator_estimate");
    expect_model(&now.model, fields + 5);
    expect_model(&now.least_squares_model, fields + 8);
    expect_covariance(now.covariance, fields + 11);
    expect_number(now.step_norm, fields[17], "step_norm");
    if (*fields[18] == '\0') {
        expect(now.converged_s != now.converged_s, "converged_s");
    } else {
        double expected_s = time_of(fields[18]);
        expect(memcmp(&now.converged_s, &expected_s, sizeof expected_s) == 0, "converged_s");
    }
}

static void fixed_rate_row(char **fields)
{
    static SeatrialFixedRate *estimator;
    SeatrialStatus status = SEATRIAL_STATUS_OK;
    SeatrialModel model;
    SeatrialNumber covariance[3][3];
    const char *call = fields[0];
    SeatrialNumber heading_rad = number_of(fields[1]);
    SeatrialNumber rudder_rad = number_of(fields[2]);

    if (strcmp(call, "new") == 0) {
        SeatrialFixedRateSettings settings;
        expect_ok(seatrial_fixed_rate_settings((SeatrialNumber)1.5, (SeatrialNumber)0.05, &settings),
                  "settings");
        expect_ok(seatrial_fixed_rate_new(memory, sizeof memory, &settings, heading_rad, rudder_rad,
                                          &estimator, NULL),
                  "seatrial_fixed_rate_new");
    } else if (strcmp(call, "settle") == 0) {
        status = seatrial_fixed_rate_settle(estimator, heading_rad, rudder_rad);
    } else if (strcmp(call, "update") == 0) {
        status = seatrial_fixed_rate_update(estimator, heading_rad, rudder_rad);
    } else {
        expect_ok(seatrial_fixed_rate_restart(estimator), call);
    }
    expect((status == SEATRIAL_STATUS_REFUSED) == (strcmp(fields[3], "rejected") == 0), "intake");
    expect_ok(seatrial_fixed_rate_model(estimator, &model), "seatrial_fixed_rate_model");
    expect_ok(seatrial_fixed_rate_covariance(estimator, &covariance[0][0]),
              "seatrial_fixed_rate_covariance");
    expect_model(&model, fields + 4);
    expect_covariance(covariance, fields + 7);
}

/* Cuts a line at its commas; the fields that are left over are empty. */
static void cut(char *line, char **fields)
{
    int i;
    line[strcspn(line, "\r\n")] = '\0';
    for (i = 0; i < FIELDS; i++) {
        size_t length = strcspn(line, ",");
        fields[i] = line;
        line += length;
        if (*line == ',') {
            *line = '\0';
            line += 1;
        }
    }
}

int main(int count, char **arguments)
{
    static char line[LINE];
    char *fields[FIELDS];
    void (*row)(char **) = NULL;
    FILE *file;

    if (count == 3) {
        row = strcmp(arguments[1], "trial") == 0        ? trial_row
              : strcmp(arguments[1], "estimator") == 0  ? estimator_row
              : strcmp(arguments[1], "fixed_rate") == 0 ? fixed_rate_row
                                                        : NULL;
    }
    if (row == NULL) {
        fprintf(stderr, "usage: parity trial|estimator|fixed_rate FILE\n");
        return 2;
    }
    file = fopen(arguments[2], "r");
    if (file == NULL || fgets(line, sizeof line, file) == NULL) {
        fprintf(stderr, "parity: no table in %s\n", arguments[2]);
        return 3;
    }
    while (fgets(line, sizeof line, file) != NULL) {
        line_number += 1;
        cut(line, fields);
        row(fields);
    }
    fclose(file);
    printf("%s: %lu lines, %lu differences\n", arguments[1], line_number, differences);
    return differences == 0 && line_number > 0 ? 0 : 1;
}
