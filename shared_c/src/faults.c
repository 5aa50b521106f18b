/* SPDX-License-Identifier: MIT */
#include "faults.h"

#include "faults_limits.h"
#include "fixed.h"
#include "port_outline.h"

#include <string.h>

void faults_init(faults_t *faults)
{
    memset(faults, 0, sizeof *faults);
    faults_limit_noise(faults, FAULTS_NOISE_COUNTS);
}

PORT_OUTLINE void faults_limit_noise(faults_t *faults, uint16_t noise_counts)
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

static uint16_t size_of(int16_t value)
{
    return (uint16_t)(value < 0 ? -value : value);
}

/* A difference of counts in 256 counts, rounded down, limited. */
static int16_t move_of(int32_t difference)
{
    if ((uint32_t)(difference + FAULTS_MOVE_LIMIT * 256L) < (2U * FAULTS_MOVE_LIMIT + 1U) * 256UL) {
        return (int16_t)((uint32_t)difference >> 8);
    }
    return difference < 0 ? -FAULTS_MOVE_LIMIT : FAULTS_MOVE_LIMIT;
}

/* What (1 - 1/z)^4 (1 + 1/z^2) leaves of the counts, of whose moves the taps are 1 -3 4 -4 3 -1. */
static int16_t rest_of(const int16_t *moves)
{
    const int16_t inner = (int16_t)(moves[2] - moves[3]), outer = (int16_t)(moves[1] - moves[4]);

    return (int16_t)(moves[0] - moves[5] + outer + 4 * (inner - outer)); /* |.| <= 16 * 2047 */
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
    return size_of(sum) < FAULTS_BACK && size_of(*left) >= FAULTS_LEAVE;
}

static void judge_noise(faults_t *faults, int16_t move)
{
    int16_t *moves   = faults->moves;
    uint8_t  noisy   = faults->noisy;
    uint8_t  stirred = (uint8_t)(faults->stirred << 1);

    for (uint8_t at = FAULTS_MOVES - 1U; at != 0U; at--) { moves[at] = moves[at - 1U]; }
    moves[0] = move;
    if (size_of(move) >= FAULTS_STIRRED) { stirred |= 1U; }
    faults->stirred = stirred;

    uint8_t  many  = stirred & 0x3FU; /* of the moves that the filter sees */
    uint16_t limit = (uint16_t)faults->noise_limit;
    uint8_t  more  = (uint8_t)(noisy + 1U);
    many &= (uint8_t)(many - 1U);
    many &= (uint8_t)(many - 1U); /* not 0: 3 or more */
    if ((faults->held & FAULTS_NOISE) != 0U) {
        limit >>= FAULTS_QUIET_SHIFT;
        more = FAULTS_NOISY;
        many = 1;
    }
    if (many != 0U && size_of(rest_of(moves)) >= limit) {
        noisy = more;
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
    if (difference != 0) {
        faults->equal = 0U;
    } else if (faults->equal != FAULTS_REPEATS) {
        faults->equal++;
    }
    judge_noise(faults, move_of(difference));
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

PORT_OUTLINE uint8_t faults_update(faults_t *faults, faults_event_t event, int32_t counts)
{
    const uint8_t before = faults->held;

    if (event != FAULTS_EVENT_NOTHING) {
        const uint8_t found = judge(faults, event, counts);
        uint8_t       held  = faults->held | found;
        if (event != FAULTS_EVENT_CONVERSION || found != 0U) {
            faults->good = 0U;
        } else if (++faults->good >= FAULTS_GOOD) {
            faults->good = FAULTS_GOOD;
            held &= FAULTS_NOISE;
        }
        faults->held = held;
        faults->seen |= held;
    }
    const uint8_t held   = faults->held;
    uint8_t       answer = before == 0U ? 0U : FAULTS_RESTART;

    if (held != 0U) { answer = FAULTS_SPOILT; }
    if (held != before) { answer |= FAULTS_CHANGED; }
    return answer;
}
