/* SPDX-License-Identifier: MIT */
#include "faults.h"

#include "faults_limits.h"
#include "fixed.h"

#include <string.h>

void faults_init(faults_t *faults)
{
    memset(faults, 0, sizeof *faults);
    faults_limit_noise(faults, FAULTS_NOISE_COUNTS);
}

void faults_limit_noise(faults_t *faults, uint16_t noise_counts)
{
    if (noise_counts < FAULTS_NOISE_LEAST) { noise_counts = FAULTS_NOISE_LEAST; }
    /* The filter lets 14 times as much through, in 256 counts: <= 3584 */
    faults->noise_limit = (int16_t)(((uint16_t)(noise_counts >> 4) * 7U) >> 3);
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

/* A difference of counts in 256 counts, rounded down, limited. */
static int16_t move_of(int32_t difference)
{
    const int32_t move = difference >> 8; /* |.| <= 2^16 */

    if (move > FAULTS_MOVE_LIMIT) { return FAULTS_MOVE_LIMIT; }
    return move < -FAULTS_MOVE_LIMIT ? -FAULTS_MOVE_LIMIT : (int16_t)move;
}

/* What (1 - 1/z)^4 (1 + 1/z^2) leaves of the counts, of whose moves the taps are 1 -3 4 -4 3 -1. */
static int16_t rest_of(const int16_t *moves)
{
    const int16_t inner = (int16_t)(moves[2] - moves[3]), outer = (int16_t)(moves[1] - moves[4]);

    return (int16_t)(moves[0] - moves[5] - 3 * outer + 4 * inner); /* |.| <= 16 * 2047 */
}

/* Whether counts that did not stir had left and are back by the newest move. */
static bool is_spike(const int16_t *moves, uint8_t stirred)
{
    const int16_t *left = &moves[1];
    int16_t        sum  = (int16_t)(moves[0] + moves[1]);

    if ((stirred & 0x1CU) == 0x04U) { /* they left with the move before the last */
        left++;
        sum = (int16_t)(sum + *left);
    } else if ((stirred & 0x0EU) != 0x02U) { /* nor with the last */
        return false;
    }
    return is_within(sum, FAULTS_BACK) && !is_within(*left, FAULTS_LEAVE);
}

static void judge_noise(faults_t *faults, int16_t move)
{
    int16_t *moves   = faults->moves;
    uint8_t  noisy   = faults->noisy;
    uint8_t  stirred = (uint8_t)(faults->stirred << 1);

    for (uint8_t at = FAULTS_MOVES - 1U; at != 0U; at--) { moves[at] = moves[at - 1U]; }
    moves[0] = move;
    if (!is_within(move, FAULTS_STIRRED)) { stirred |= 1U; }
    faults->stirred = stirred;

    uint8_t bits = stirred & 0x3FU; /* of the moves that the filter sees */
    bits &= (uint8_t)(bits - 1U);
    bits &= (uint8_t)(bits - 1U); /* not 0: 3 or more */

    const int16_t rest = rest_of(moves), limit = faults->noise_limit;
    if ((faults->held & FAULTS_NOISE) != 0U) {
        const bool is_quiet = is_within(rest, (int16_t)(limit >> FAULTS_QUIET_SHIFT));
        noisy               = is_quiet ? (uint8_t)(noisy - 1U) : (uint8_t)FAULTS_CALM;
    } else if (bits != 0U && !is_within(rest, limit)) {
        noisy++;
    } else if (noisy != 0U) {
        noisy--;
    }
    if (noisy == FAULTS_NOISY || is_spike(moves, stirred)) {
        noisy = FAULTS_CALM;
        faults->held |= FAULTS_NOISE;
    }
    if (noisy == 0U) { faults->held &= (uint8_t)~FAULTS_NOISE; }
    faults->noisy = noisy;
}

/* The counts of a conversion. */
static uint8_t judge_counts(faults_t *faults, int32_t counts)
{
    const int32_t difference = counts - faults->previous_counts;

    faults->previous_counts = counts;
    if (counts == FIXED_COUNTS_MIN || counts == FIXED_COUNTS_MAX) {
        faults->in_run = false;
        return FAULTS_AT_RAIL;
    }
    if (!faults->in_run) {
        memset(faults->moves, 0, sizeof faults->moves);
        faults->in_run  = true;
        faults->equal   = 0U;
        faults->stirred = 0U;
        return 0U;
    }
    judge_noise(faults, move_of(difference));
    if (difference != 0) {
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
