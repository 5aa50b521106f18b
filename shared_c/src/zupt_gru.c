/* SPDX-License-Identifier: MIT */
#include "zupt_gru.h"

#include <stdbool.h>
#include <string.h>

#include "fixed.h"
#include "port_dot.h"
#include "port_gru.h"
#include "port_outline.h"
#include "port_root.h"
#include "zupt_gru_weights.h"

enum { AXES = 3, TEN = ZUPT_GRU_OCTAVES, RANGE_HIGH = (ZUPT_GRU_VALUE_MAX + 1) / 256 };

_Static_assert((int)PORT_GRU_UNITS == (int)ZUPT_GRU_UNITS &&
                   (int)PORT_GRU_INPUTS == (int)ZUPT_GRU_INPUTS &&
                   (int)PORT_GRU_SPLIT == (int)ZUPT_GRU_FIRST,
               "one network");

void zupt_gru_interrupt(zupt_gru_t *gru)
{
    memset(gru->seen, 0, sizeof gru->seen);
    gru->wait_ms = 0U;
    gru->still   = 0U;
}

void zupt_gru_init(zupt_gru_t *gru, uint8_t sample_ms)
{
    gru->sample_ms = sample_ms;
    zupt_gru_interrupt(gru);
}

/* How far a vector's length is from `from`, in half counts, as octaves. */
static PORT_OUTLINE int16_t magnitude(zupt_gru_t *gru, const int16_t vector[AXES], uint16_t from,
                                      uint16_t floor_q8)
{
    bool is_beyond = false;

    for (uint8_t axis = 0U; axis < AXES; ++axis) {
        const int16_t value = vector[axis];
        if ((uint8_t)((uint8_t)(value >> 8) + RANGE_HIGH) < 2 * RANGE_HIGH) { continue; }
        if ((uint16_t)((uint16_t)value + 0x8001U) <= 1U) { /* one comparison for both rails */
            fixed_count(&gru->rejected);
            return TEN;
        }
        is_beyond = true;
    }
    if (is_beyond) { return TEN; }
    const uint32_t square = (uint32_t)port_dot(vector, vector); /* <= 3 * 2^26 */
    const int16_t  away   = (int16_t)(port_root(4U * square) - from);

    return port_gru_octaves((uint16_t)(away < 0 ? -away : away), floor_q8);
}

/* The units that are left, and what comes of them all. */
static PORT_OUTLINE void finish_step(zupt_gru_t *gru)
{
    int16_t *const state = &gru->seen[ZUPT_GRU_INPUTS];
    int16_t        last[ZUPT_GRU_UNITS - ZUPT_GRU_FIRST];

    port_gru_units(last, gru->seen, &zupt_gru_units[ZUPT_GRU_FIRST], ZUPT_GRU_FIRST);
    memcpy(state, gru->next, sizeof gru->next);
    memcpy(&state[ZUPT_GRU_FIRST], last, sizeof last);
    gru->still = 0U;
    if (gru->seen[0] < TEN && gru->seen[1] < TEN &&
        port_gru_score(state, zupt_gru_out, ZUPT_GRU_OUT_BIAS) >= 0) {
        gru->still = ZUPT_STILL;
    }
}

uint8_t zupt_gru_update(zupt_gru_t *gru, const int16_t gyro_b_counts[3],
                        const int16_t acc_b_counts[3])
{
    const uint8_t wait_ms = gru->wait_ms;

    gru->wait_ms = (uint8_t)(wait_ms - gru->sample_ms);
    if (wait_ms < gru->sample_ms) { /* the next sample comes after the step's time */
        gru->wait_ms = (uint8_t)(gru->wait_ms + ZUPT_GRU_STEP_MS);
        gru->seen[0] = magnitude(gru, acc_b_counts, ZUPT_GRU_GRAVITY_HALVES, ZUPT_GRU_ACC_FLOOR);
        gru->seen[1] = magnitude(gru, gyro_b_counts, 0U, ZUPT_GRU_RATE_FLOOR);
        port_gru_units(gru->next, gru->seen, zupt_gru_units, 0U);
    } else if ((uint8_t)(wait_ms + gru->sample_ms) >= ZUPT_GRU_STEP_MS) { /* one call later */
        finish_step(gru);
    }
    return gru->still;
}
