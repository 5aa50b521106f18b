/* SPDX-License-Identifier: MIT */
#include "calibration.h"

uint8_t calibration_put(calibration_t *calibration, messages_point_t *point)
{
    int32_t *const counts_q7 = calibration->counts_q7, *const mass_mg = calibration->mass_mg;
    uint8_t at = 0;

    while (at < calibration->count && mass_mg[at] < point->mass_mg) { at++; }
    if (at == calibration->count || mass_mg[at] != point->mass_mg) {
        if (calibration->count == SCALE_POINTS_MAX) { return MESSAGES_RESULT_TOO_MANY_POINTS; }
        for (uint8_t to = calibration->count++; to > at; to--) {
            counts_q7[to] = counts_q7[to - 1U];
            mass_mg[to]   = mass_mg[to - 1U];
        }
    }
    counts_q7[at] = point->counts_q7;
    mass_mg[at]   = point->mass_mg;
    point->index  = at;
    return MESSAGES_RESULT_OK;
}

static void swap(int32_t *a, int32_t *b)
{
    const int32_t kept = *a;

    *a = *b;
    *b = kept;
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
