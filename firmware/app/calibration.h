/* SPDX-License-Identifier: MIT */
/* calibration - the points of a calibration under way, in the order of their masses.
 *
 * Model     a point of a mass that is there already takes its place
 * Context   single caller, not from an ISR
 */
#ifndef CALIBRATION_H
#define CALIBRATION_H

#include "messages.h"
#include "scale.h"

#include <stdint.h>

typedef struct {
    uint8_t count; /* 0..SCALE_POINTS_MAX */
    int32_t counts_q7[SCALE_POINTS_MAX];
    int32_t mass_mg[SCALE_POINTS_MAX]; /* rising */
} calibration_t;

/* Take a point's counts and mass, give its index. A MESSAGES_RESULT_... */
uint8_t calibration_put(calibration_t *calibration, messages_point_t *point);

/* Exchange these points for those of a configuration. */
void calibration_swap(calibration_t *calibration, scale_config_t *config);

#endif
