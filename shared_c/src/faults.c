/* SPDX-License-Identifier: MIT */
#include "faults.h"

#include "faults_limits.h"
#include "fixed.h"

#include <string.h>

void faults_init(faults_t *faults)
{
    memset(faults, 0, sizeof *faults);
}

void faults_pause(faults_t *faults)
{
    faults->in_run = false;
    faults->off    = false;
}

static bool is_within(int16_t move, int16_t limit)
{
    return move < limit && move > -limit;
}

/* How far counts went, in 2^FAULTS_MOVE_SHIFT counts, rounded down, limited. */
static int16_t move_of(int32_t counts, int32_t previous_counts)
{
    const int32_t move = (counts - previous_counts) >> FAULTS_MOVE_SHIFT; /* |.| <= 2^20 */

    if (move > FAULTS_MOVE_LIMIT) { return FAULTS_MOVE_LIMIT; }
    return move < -FAULTS_MOVE_LIMIT ? -FAULTS_MOVE_LIMIT : (int16_t)move;
}

/* Whether counts that were quiet had left and are back by this move. */
static bool is_spike(const int16_t *moves, int16_t move)
{
    int16_t sum = move; /* <= 3 * 2047 */

    for (uint8_t left = FAULTS_WITHIN; left != 0U; left--, moves++) {
        sum = (int16_t)(sum + moves[0]);
        if (is_within(sum, FAULTS_BACK) && !is_within(moves[0], FAULTS_LEAVE) &&
            is_within(moves[1], FAULTS_BACK) && is_within(moves[2], FAULTS_BACK)) {
            return true;
        }
    }
    return false;
}

/* (1 - 1/z)^4 (1 + 1/z^2) of the counts, from their moves: 1 -3 4 -4 3 -1. */
static int16_t rest_of(const int16_t *moves, int16_t move)
{
    const int16_t inner = (int16_t)(moves[1] - moves[2]), outer = (int16_t)(moves[0] - moves[3]);

    return (int16_t)(move - moves[4] - 3 * outer + 4 * inner); /* |.| <= 16 * 2047 < 2^15 */
}

static void judge_noise(faults_t *faults, int16_t move)
{
    int16_t *moves = faults->moves;
    int8_t   noisy = (int8_t)faults->noisy;

    noisy = (int8_t)(noisy + (is_within(rest_of(moves, move), FAULTS_NOISE_LIMIT)
                                  ? -FAULTS_NOISY_FALL
                                  : FAULTS_NOISY_RISE));
    if (noisy > FAULTS_NOISY_FULL || is_spike(moves, move)) { noisy = FAULTS_NOISY_FULL; }
    if (noisy == FAULTS_NOISY_FULL) { faults->held |= FAULTS_NOISE; }
    if (noisy <= 0) {
        noisy = 0;
        faults->held &= (uint8_t)~FAULTS_NOISE;
    }
    faults->noisy = (uint8_t)noisy;
    memmove(&moves[1], moves, sizeof moves[0] * (FAULTS_MOVES - 1U));
    moves[0] = move;
}

/* The counts of a conversion. */
static uint8_t judge_counts(faults_t *faults, int32_t counts)
{
    const int32_t previous = faults->previous_counts;

    faults->previous_counts = counts;
    if (counts == FIXED_COUNTS_MIN || counts == FIXED_COUNTS_MAX) {
        faults->in_run = false;
        return FAULTS_AT_RAIL;
    }
    if (!faults->in_run) {
        memset(faults->moves, 0, sizeof faults->moves);
        faults->in_run = true;
        faults->equal  = 0U;
        return 0U;
    }
    judge_noise(faults, move_of(counts, previous));
    if (counts != previous) {
        faults->equal = 0U;
        return 0U;
    }
    if (faults->equal != FAULTS_REPEATS) { faults->equal++; }
    return faults->equal == FAULTS_REPEATS ? FAULTS_DOUT_STUCK : 0U;
}

static uint8_t judge(faults_t *faults, faults_event_t event, int32_t counts)
{
    const bool was_off = faults->off, was_in_run = faults->in_run;

    if (event == FAULTS_EVENT_CONVERSION) {
        faults->off = false;
        return judge_counts(faults, counts);
    }
    faults_pause(faults);
    switch (event) {
    case FAULTS_EVENT_BAD_FRAME: return FAULTS_FRAMES_LOST;
    case FAULTS_EVENT_TIMED_OUT: return FAULTS_CABLE_OUT;
    case FAULTS_EVENT_STUCK_LOW: return FAULTS_DOUT_STUCK;
    case FAULTS_EVENT_OFF_BEAT:
        faults->off = true;
        return was_off ? FAULTS_RATE : FAULTS_FRAMES_LOST;
    default: return was_in_run ? FAULTS_FRAMES_LOST : 0U;
    }
}

uint8_t faults_update(faults_t *faults, faults_event_t event, int32_t counts)
{
    const uint8_t before = faults->held;

    if (event != FAULTS_EVENT_NOTHING) {
        const uint8_t found = judge(faults, event, counts);
        uint8_t       good  = faults->good;
        if (event != FAULTS_EVENT_CONVERSION || found != 0U) {
            good = 0U;
        } else if (++good >= FAULTS_GOOD) {
            good = FAULTS_GOOD;
            faults->held &= FAULTS_NOISE;
        }
        faults->good = good;
        faults->held |= found;
        faults->seen |= faults->held;
    }
    const uint8_t held = faults->held;

    if (held != 0U) { return held == before ? FAULTS_SPOILT : FAULTS_SPOILT | FAULTS_CHANGED; }
    return before == 0U ? 0U : FAULTS_RESTART | FAULTS_CHANGED;
}
