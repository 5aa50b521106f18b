/* SPDX-License-Identifier: MIT */
/* weighing_internal - what the sources of weighing share. */
#ifndef WEIGHING_INTERNAL_H
#define WEIGHING_INTERNAL_H

#include "calibration.h"
#include "checkweigher.h"
#include "scale.h"
#include "settings_table.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef union {
    checkweigher_t checkweigher;
    calibration_t  calibration;
} weighing_beside_t;

extern scale_t           weighing_scale;
extern weighing_beside_t weighing_beside;         /* as weighing_calibrating says */
extern bool              weighing_calibrating;    /* a calibration is under way */
extern int32_t           weighing_last_counts_q7; /* what the chain ended with */

/* The configuration in force to the scale, which goes on with that zero and tare. */
scale_status_t weighing_renew(const int32_t zero_and_tare_mg[2], bool firm);

_Static_assert(offsetof(scale_t, tare_mg) - offsetof(scale_t, zero_mg) == sizeof(int32_t) &&
                   offsetof(settings_t, tare_mg) - offsetof(settings_t, zero_mg) == sizeof(int32_t),
               "a tare stands behind its zero");

/* The same to the checkweigher, which begins anew; false where it contradicts itself. */
bool weighing_renew_checkweigher(void);

#endif
