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

#define BEYOND UINT32_MAX

_Static_assert((int)PORT_GRU_UNITS == (int)ZUPT_GRU_UNITS &&
                   (int)PORT_GRU_INPUTS == (int)ZUPT_GRU_INPUTS &&
                   (int)PORT_GRU_SPLIT == (int)ZUPT_GRU_FIRST,
               "one network");

void zupt_gru_interrupt(zupt_gru_t *gru)
{
    memset(gru->seen, 0, sizeof gru->seen);
    memset(gru->best, 0, sizeof gru->best);
    gru->wait_ms = 0U;
    gru->steps   = 0U;
    gru->still   = 0U;
}

void zupt_gru_init(zupt_gru_t *gru, uint8_t sample_ms)
{
    gru->sample_ms = sample_ms;
    zupt_gru_interrupt(gru);
}

/* Of a logarithm above its floor, in Q10 after this shift. */
static int16_t octaves(int16_t above, uint8_t shift)
{
    if (above <= 0) { return 0; }
    above = (int16_t)(above << shift); /* below 2^14: 15 octaves by 2^10, or 28 by 2^9 */
    return above < TEN ? above : TEN;
}

/* |v|^2 of a vector, or BEYOND. */
static PORT_OUTLINE uint32_t square(zupt_gru_t *gru, const int16_t vector[AXES])
{
    bool is_beyond = false;

    for (uint8_t axis = 0U; axis < AXES; ++axis) {
        const int16_t value = vector[axis];
        if ((uint8_t)((uint8_t)(value >> 8) + RANGE_HIGH) < 2 * RANGE_HIGH) { continue; }
        if ((uint16_t)((uint16_t)value + 0x8001U) <= 1U) { /* one comparison for both rails */
            fixed_count(&gru->rejected);
            return BEYOND;
        }
        is_beyond = true;
    }
    return is_beyond ? BEYOND : (uint32_t)port_dot(vector, vector); /* <= 3 * 2^26 */
}

/* | |a| - g | in half counts, as octaves. */
static int16_t away_from_gravity(uint32_t square)
{
    if (square == BEYOND) { return TEN; }
    const int16_t away = (int16_t)(port_root(4U * square) - ZUPT_GRU_GRAVITY_HALVES);
    if (away == 0) { return 0; }
    return octaves(
        (int16_t)(port_gru_log2_q8((uint16_t)(away < 0 ? -away : away)) - ZUPT_GRU_ACC_FLOOR), 2U);
}

/* |w| as octaves, which are half of its square's: of that the upper bytes, where there are more
 * than two. */
static int16_t turning(uint32_t square)
{
    int16_t floor_q8 = ZUPT_GRU_RATE_FLOOR;

    if (square == BEYOND) { return TEN; }
    if (square == 0U) { return 0; }
    while (square > UINT16_MAX) {
        square >>= 8;
        floor_q8 = (int16_t)(floor_q8 - (8 << 8));
    }
    return octaves((int16_t)(port_gru_log2_q8((uint16_t)square) - floor_q8), 1U);
}

/* The least score that is still, after a step of this one: 0, which is accept's, or less where
 * nothing near came up to that. */
static int16_t asked(zupt_gru_t *gru, int16_t score)
{
    int16_t *const best = gru->best;

    if (gru->steps == ZUPT_GRU_BLOCK_LEN) {
        memmove(&best[1], best, sizeof gru->best - sizeof *best);
        best[0]    = score;
        gru->steps = 0U;
    }
    gru->steps++;
    if (best[0] < score) { best[0] = score; }
    int16_t least = best[0];
    for (uint8_t n = 1U; n < ZUPT_GRU_BLOCKS; ++n) {
        if (least < best[n]) { least = best[n]; }
    }
    least = (int16_t)(least - ZUPT_GRU_MARGIN);
    if (least > 0) { return 0; }
    return least < ZUPT_GRU_LEAST ? ZUPT_GRU_LEAST : least;
}

/* The units that are left, and what comes of them all. */
static PORT_OUTLINE void finish_step(zupt_gru_t *gru)
{
    int16_t *const state = &gru->seen[ZUPT_GRU_INPUTS];
    int16_t        last[ZUPT_GRU_UNITS - ZUPT_GRU_FIRST];

    port_gru_units(last, gru->seen, &zupt_gru_units[ZUPT_GRU_FIRST], ZUPT_GRU_FIRST);
    memcpy(state, gru->next, sizeof gru->next);
    memcpy(&state[ZUPT_GRU_FIRST], last, sizeof last);
    const int16_t score = port_gru_score(state, zupt_gru_out, ZUPT_GRU_OUT_BIAS);
    const bool    quiet = score >= asked(gru, score);
    gru->still          = quiet && gru->seen[0] < TEN && gru->seen[1] < TEN ? ZUPT_STILL : 0U;
}

uint8_t zupt_gru_update(zupt_gru_t *gru, const int16_t gyro_b_counts[3],
                        const int16_t acc_b_counts[3])
{
    const uint8_t wait_ms = gru->wait_ms;

    gru->wait_ms = (uint8_t)(wait_ms - gru->sample_ms);
    if (wait_ms < gru->sample_ms) { /* the next sample comes after the step's time */
        gru->wait_ms = (uint8_t)(gru->wait_ms + ZUPT_GRU_STEP_MS);
        gru->seen[0] = away_from_gravity(square(gru, acc_b_counts));
        gru->seen[1] = turning(square(gru, gyro_b_counts));
        port_gru_units(gru->next, gru->seen, zupt_gru_units, 0U);
    } else if ((uint8_t)(wait_ms + gru->sample_ms) >= ZUPT_GRU_STEP_MS) { /* one call later */
        finish_step(gru);
    }
    return gru->still;
}
