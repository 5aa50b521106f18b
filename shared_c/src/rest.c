/* SPDX-License-Identifier: MIT */
#include "rest.h"

#include "fixed.h"
#include "port_i16.h"
#include "port_outline.h"
#include "port_reach.h"

enum {
    AXES         = 3,
    VISITS       = 6,
    ACC          = 0, /* of a limit: whose, */
    GYRO         = 1,
    MOTION       = 0, /* and when: REST_AT_REST or not */
    STILL        = 1,
    ROUND_LEARNS = REST_BLOCK_ROUNDS,
    MEAN_Q16     = 65536L / REST_BLOCK_ROUNDS /* of a sum */
};

_Static_assert((REST_GYRO_LIMIT_MAX + 1) * REST_BLOCK_ROUNDS <= INT16_MAX, "a block's sum fits");

static int16_t whole(int32_t value_q16)
{
    return (int16_t)(value_q16 >> 16);
}

/* |value| > limit, with one comparison: whatever lies below wraps round to the top. */
static bool beyond(int16_t value, int16_t limit) /* 0 <= limit <= 16383 */
{
    return (uint16_t)((uint16_t)value + (uint16_t)limit) > (uint16_t)(2 * limit);
}

bool rest_is_lawful(const rest_config_t *config)
{
    const int16_t *acc = config->limit_counts[ACC], *gyro = config->limit_counts[GYRO];
    const int16_t  bias_max = config->bias_max_counts;

    return 0 <= acc[MOTION] && acc[MOTION] <= acc[STILL] && acc[STILL] <= REST_ACC_LIMIT_MAX &&
           0 <= gyro[MOTION] && gyro[MOTION] <= gyro[STILL] && 0 <= bias_max &&
           gyro[STILL] <= REST_GYRO_LIMIT_MAX - bias_max && config->lowpass_q16 > 0 &&
           config->still_rounds >= 1U && config->gain_len >= 1U;
}

void rest_init(rest_t *rest, const rest_config_t *config)
{
    *rest        = (rest_t){0};
    rest->config = config;
}

void rest_interrupt(rest_t *rest)
{
    rest->flags &= (uint8_t)~REST_AT_REST;
    rest->rounds = 0U;
}

/* One axis of the last block goes into the bias: down, and the gain is at most 1, so that the bias
 * never passes the mean. The mean's factor is no constant to the compiler: a product is shorter and
 * quicker than the loop of shifts that it would make. */
static void learn(rest_t *rest, uint8_t visit)
{
    int32_t *bias_q16 = PORT_REACH(&rest->bias_q16[visit - AXES]);
    int32_t  off_q16  = (int32_t)rest->sum_counts[visit - AXES] * PORT_REACH((int16_t)MEAN_Q16) -
                      *bias_q16; /* <= 2^28 */

    for (uint8_t blocks = rest->blocks; (blocks >>= 1) != 0U;) { off_q16 >>= 1; }
    *bias_q16 += off_q16;
}

/* Whether the axis is still; gathers what the block wants of it. */
static bool look(rest_t *rest, uint8_t visit, int16_t sample)
{
    const rest_config_t *config  = rest->config;
    const uint8_t        at_rest = rest->flags & REST_AT_REST;
    int32_t             *low_q16 = PORT_REACH(&rest->low_q16[visit]);

    if ((uint16_t)((uint16_t)sample - 0x7FFFU) <= 1U) { /* 32767 or -32768 */
        fixed_count(&rest->rejected);
        return false;
    }
    const int16_t  off   = port_sub_sat_i16(sample, whole(*low_q16));
    const int16_t *limit = config->limit_counts[ACC];
    if (visit >= AXES) { limit = config->limit_counts[GYRO]; }
    if (at_rest) { ++limit; }
    if (beyond(off, *limit)) {
        *low_q16 = sample * 65536L;
        return false;
    }
    /* With a gain below 1/2 the low-pass stays inside int16, as the samples do (notes). */
    *low_q16 = port_mac_i16(*low_q16, config->lowpass_q16, off);
    if (visit < AXES) { return true; }
    if (beyond(whole(*low_q16), config->bias_max_counts)) { return false; }
    if (at_rest && rest->rounds < REST_BLOCK_ROUNDS) {
        int16_t *sum = PORT_REACH(&rest->sum_counts[visit - AXES]);
        if (rest->rounds == 0U) { *sum = 0; }
        *sum = (int16_t)(*sum + sample); /* |sample| <= GYRO_LIMIT_MAX + 1 */
    }
    return true;
}

/* Whether the block that has been gathered may be learnt: the accelerometer feels about what it
 * should at rest. */
static void end_block(rest_t *rest)
{
    const rest_config_t *config   = rest->config;
    uint16_t             gravity2 = 0U; /* <= 3 * 2^14 */

    for (uint8_t axis = 0U; axis < AXES; ++axis) {
        /* half a step below full scale wraps to -128, whose square is the same */
        const int8_t low = (int8_t)((uint16_t)(whole(rest->low_q16[axis]) + 128) >> 8);
        gravity2         = (uint16_t)(gravity2 + (uint16_t)(low * low));
    }
    if (gravity2 < config->gravity2_min || gravity2 > config->gravity2_max) {
        fixed_count(&rest->implausible);
        rest->rounds = 0U;
    } else if (rest->blocks != config->gain_len) {
        ++rest->blocks;
    }
}

/* Six visits without motion. */
static void end_round(rest_t *rest)
{
    ++rest->rounds;
    if ((rest->flags & REST_AT_REST) == 0U) {
        uint8_t asked = rest->config->still_rounds;
        if ((rest->flags & REST_BIAS_KNOWN) == 0U) { asked >>= REST_FIRST_SHIFT; }
        if (rest->rounds < asked) { return; }
        rest->flags |= REST_AT_REST;
    } else {
        if (rest->rounds <= ROUND_LEARNS) { return; }
        rest->flags |= REST_BIAS_KNOWN;
    }
    rest->rounds = 0U;
}

PORT_OUTLINE uint8_t rest_update(rest_t *rest, const int16_t gyro_b_counts[3],
                                 const int16_t acc_b_counts[3])
{
    const uint8_t visit  = rest->visit++;
    const bool    learns = rest->rounds == ROUND_LEARNS && (rest->flags & REST_AT_REST) != 0U;
    bool          still  = true;

    if (learns && visit == 0U) {
        end_block(rest);
    } else if (learns && visit >= AXES) {
        learn(rest, visit);
    } else if (!look(rest, visit,
                     visit < AXES ? acc_b_counts[visit] : gyro_b_counts[visit - AXES])) {
        rest_interrupt(rest);
        still = false;
    }
    if (visit == VISITS - 1U) {
        rest->visit = 0U;
        if (still) { end_round(rest); }
    }
    return rest->flags;
}
