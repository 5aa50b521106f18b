/* SPDX-License-Identifier: MIT */
#include "calibration.h"

static __attribute__((noinline)) void swap(int32_t *a, int32_t *b)
{
    const int32_t kept = *a;

    *a = *b;
    *b = kept;
}

uint8_t calibration_put(calibration_t *calibration, messages_point_t *point)
{
    int32_t *mass_mg = calibration->mass_mg;
    uint8_t  at      = 0;

    while (at < calibration->count && mass_mg[at] != point->mass_mg) { at++; }
    if (at == SCALE_POINTS_MAX) { return MESSAGES_RESULT_TOO_MANY_POINTS; }
    if (at == calibration->count) { calibration->count++; }
    calibration->counts_q7[at] = point->counts_q7;
    mass_mg[at]                = point->mass_mg;
    for (; at != 0U && mass_mg[at] < mass_mg[at - 1U]; at--) {
        swap(&mass_mg[at], &mass_mg[at - 1U]);
        swap(&calibration->counts_q7[at], &calibration->counts_q7[at - 1U]);
    }
    point->index = at;
    return MESSAGES_RESULT_OK;
}

void calibration_swap(calibration_t *calibration, scale_config_t *config)
{
    const uint8_t count = calibration->count;

    calibration->count = config->points;
    config->points     = count;
    for (uint8_t at = 0; at < SCALE_POINTS_MAX; at++) {
        swap(&calibration->counts_q7[at], &config->point_counts_q7[at]);
        swap(&calibration->mass_mg[at], &config->point_mass_mg[at]);
    }
}
