/* SPDX-License-Identifier: MIT */
#include "calibration.h"

#include <stddef.h>

_Static_assert(offsetof(calibration_t, mass_mg) - offsetof(calibration_t, counts_q7) ==
                       offsetof(scale_config_t, point_mass_mg) -
                           offsetof(scale_config_t, point_counts_q7) &&
                   sizeof(((calibration_t *)0)->mass_mg) ==
                       sizeof(((scale_config_t *)0)->point_mass_mg),
               "both hold counts, and masses behind them");

static __attribute__((noinline)) void swap(void *a, void *b, uint8_t len)
{
    uint8_t *left = a, *right = b;

    for (; len != 0U; len--) {
        const uint8_t kept = *left;
        *left++            = *right;
        *right++           = kept;
    }
}

uint8_t calibration_put(calibration_t *calibration, messages_point_t *point)
{
    int32_t *mass_mg   = calibration->mass_mg;
    int32_t *counts_q7 = calibration->counts_q7;
    uint8_t  at        = 0;

    for (; at < calibration->count && *mass_mg != point->mass_mg; at++) {
        mass_mg++;
        counts_q7++;
    }
    if (at == SCALE_POINTS_MAX) { return MESSAGES_RESULT_TOO_MANY_POINTS; }
    if (at == calibration->count) { calibration->count++; }
    *mass_mg   = point->mass_mg;
    *counts_q7 = point->counts_q7;
    for (; at != 0U && mass_mg[0] < mass_mg[-1]; at--) {
        swap(mass_mg, &mass_mg[-1], sizeof *mass_mg);
        swap(counts_q7, &counts_q7[-1], sizeof *counts_q7);
        mass_mg--;
        counts_q7--;
    }
    point->index = at;
    return MESSAGES_RESULT_OK;
}

void calibration_swap(calibration_t *calibration, scale_config_t *config)
{
    swap(&calibration->count, &config->points, sizeof calibration->count);
    swap(calibration->counts_q7, config->point_counts_q7, 2U * sizeof calibration->counts_q7);
}
