/* SPDX-License-Identifier: MIT */
/* mahony_internal - what the sources of mahony share. */
#ifndef MAHONY_INTERNAL_H
#define MAHONY_INTERNAL_H

#include "fixed.h"
#include "mahony.h"
#include "port_hot.h"

enum { MAHONY_ONE_Q14 = 16384 };

static inline int16_t mahony_limit_i16(int32_t value)
{
    if (value > INT16_MAX) { return INT16_MAX; }
    return value < INT16_MIN ? INT16_MIN : (int16_t)value;
}

/* Shifts that avr-gcc would make loops of, by whole bytes and a few bits. |value| < 2^30 */
static inline int32_t mahony_shift_14(int32_t value)
{
    return ((value >> 8) * 4 + 128) >> 8; /* half up, of what is left without the last byte */
}

static inline int32_t mahony_floor_7(int32_t value)
{
    return (value * 2) >> 8;
}

/* value 2^(2 shift) = m 2^32 with m in [1/4, 1);  inverse_q15 = 2^15 / sqrt(m) within 1e-4,
 * relative, and at most 65535.  value > 0 */
typedef struct {
    uint16_t m_q16;
    uint16_t inverse_q15;
    uint8_t  shift; /* 0..15 */
} mahony_root_t;

mahony_root_t mahony_root(uint32_t value);

/* component / sqrt(value), where |component| <= sqrt(value). */
int16_t mahony_unit_q14(int16_t component, const mahony_root_t *root);

/* sqrt(value) */
uint16_t mahony_length(const mahony_root_t *root);

/* Of half an angle: the larger one of cosine and sine, and its inverse. */
typedef struct {
    int16_t  larger_q14;
    uint16_t inverse_q15;
} mahony_half_t;

mahony_half_t mahony_half(int16_t cos_q14);

/* The smaller one of cosine and sine of half the angle, from the sine of the whole. */
int16_t mahony_half_sine_q14(int16_t sin_q14, const mahony_half_t *half);

/* Third row of the rotation matrix: the other two's cross product. */
void mahony_up_b_q14(const mahony_step_t *step, int16_t up_b_q14[3]);

/* Turn the world: quat = left quat, normalised; the rows follow. |left| = 1 within 2e-4 */
void mahony_turn_world(mahony_step_t *step, const int16_t left_q14[4]);

/* Let everything follow from a quaternion that was set: a step that does not turn. */
void mahony_still(mahony_step_t *step);

/* Bring a norm that is 1 within 2^-9 within 2e-7 of it. */
void mahony_normalise(int32_t quat_q30[4]);

/* Set the inclination so that acc points up, keeping the heading as far as that is possible;
 * gains begin anew. Nothing happens where acc is too small to have a direction. */
void mahony_start(mahony_t *mahony, const int16_t acc_b_counts[3]);

/* gain as the ramp raises it, at most 32767. */
uint16_t mahony_raised(const mahony_t *mahony, uint16_t gain);

/* kp dt as the ramp raises it, at most 4095. */
uint16_t mahony_correct_q18(const mahony_t *mahony);

#endif
