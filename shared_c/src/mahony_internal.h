/* SPDX-License-Identifier: MIT */
/* mahony_internal - what the sources of mahony share. */
#ifndef MAHONY_INTERNAL_H
#define MAHONY_INTERNAL_H

#include "fixed.h"
#include "mahony.h"
#include "port_outline.h"

enum { MAHONY_MAG_CORRECT_MAX = 14000 };

/* port_turn while mahony_is_starting. */
uint8_t mahony_stand(mahony_t *mahony, const int16_t gyro_b_counts[3],
                     const int16_t acc_b_counts[3], const int32_t bias_q16[3]);

/* A step with the last rate, without acceleration. */
void mahony_bridge(mahony_step_t *step);

/* The axis that the next step averages. */
static inline uint8_t mahony_next_axis(const mahony_step_t *step)
{
    return (uint8_t)((step->sample + 1U) & 1U);
}

static inline bool mahony_is_starting(const mahony_t *mahony)
{
    return mahony->ramp_left > MAHONY_RAMP_LEN;
}

static inline int16_t mahony_limit_i16(int32_t value)
{
    if (value > INT16_MAX) { return INT16_MAX; }
    return value < INT16_MIN ? INT16_MIN : (int16_t)value;
}

#endif
