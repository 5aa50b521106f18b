/* SPDX-License-Identifier: MIT */
#include "calibration.h"

#include "port_outline.h"

#include <stddef.h>

_Static_assert(offsetof(calibration_t, mass_mg) - offsetof(calibration_t, counts_q7) ==
                       offsetof(scale_config_t, point_mass_mg) -
                           offsetof(scale_config_t, point_counts_q7) &&
                   sizeof(((calibration_t *)0)->mass_mg) ==
                       sizeof(((scale_config_t *)0)->point_mass_mg),
               "both hold counts, and masses behind them");

enum { MASS = SCALE_POINTS_MAX };

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
    PORT_SAVE_BY_CALL();
    int32_t *taken = calibration->counts_q7; /* its counts, and MASS further on its mass */
    uint8_t  at    = 0;

    for (; at < calibration->count && taken[MASS] != point->mass_mg; at++) { taken++; }
    if (at == SCALE_POINTS_MAX) { return MESSAGES_RESULT_TOO_MANY_POINTS; }
    if (at == calibration->count) { calibration->count++; }
    taken[0]    = point->counts_q7;
    taken[MASS] = point->mass_mg;
    for (; at != 0U && taken[MASS] < taken[MASS - 1]; at--) {
        taken--;
        swap(&taken[0], &taken[1], sizeof *taken);
        swap(&taken[MASS], &taken[MASS + 1], sizeof *taken);
    }
    point->index = at;
    return MESSAGES_RESULT_OK;
}

void calibration_swap(calibration_t *calibration, scale_config_t *config)
{
    swap(&calibration->count, &config->points, sizeof calibration->count);
    swap(calibration->counts_q7, config->point_counts_q7, 2U * sizeof calibration->counts_q7);
}
