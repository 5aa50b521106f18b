/* SPDX-License-Identifier: MIT */
#include "rest.h"

#include "fixed.h"
#include "port_assert.h"
#include "port_hot.h"
#include "port_i16.h"
#include "port_rom.h"
#include "rest_configs.h"

enum {
    AXES         = 3,
    VISITS       = 6,
    ROUND_WEIGHS = REST_BLOCK_ROUNDS,
    ROUND_LEARNS = REST_BLOCK_ROUNDS + 1,
    MEAN_Q16     = 65536L / REST_BLOCK_ROUNDS /* of a sum; a product is quicker than a shift */
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
    const int16_t gyro_max = config->leave_gyro_counts, bias_max = config->bias_max_counts;

    return config->enter_gyro_counts >= 0 && config->enter_gyro_counts <= gyro_max &&
           bias_max >= 0 && gyro_max <= REST_GYRO_LIMIT_MAX - bias_max &&
           config->enter_acc_counts >= 0 && config->leave_acc_counts <= REST_ACC_LIMIT_MAX &&
           config->enter_acc_counts <= config->leave_acc_counts && config->lowpass_q16 > 0 &&
           config->still_rounds >= 1U && config->gain_len >= 1U &&
           config->gain_len <= REST_GAIN_LEN_MAX;
}

void rest_init(rest_t *rest, const rest_config_t *config, const int16_t gyro_b_counts[3],
               const int16_t acc_b_counts[3])
{
    PORT_ASSERT(rest_is_lawful(config));

    *rest        = (rest_t){0};
    rest->config = config;
    for (uint8_t axis = 0U; axis < AXES; ++axis) {
        rest->low_q16[axis]        = acc_b_counts[axis] * 65536L;
        rest->low_q16[AXES + axis] = gyro_b_counts[axis] * 65536L;
    }
}

void rest_interrupt(rest_t *rest)
{
    rest->flags &= (uint8_t)~REST_AT_REST;
    rest->rounds = 0U;
}

/* One axis of the last block goes into the bias. */
static PORT_OUTLINE void learn(rest_t *rest, uint8_t axis)
{
    const int32_t  bias_q16 = rest->bias_q16[axis];
    const int32_t  mean_q16 = port_mac_i16(0, rest->sum_counts[axis], MEAN_Q16); /* <= 2^27 */
    const uint16_t gain_q15 = port_rom_u16(&rest_gain_q15[rest->blocks - 1U]);

    /* gain <= 1: the bias never passes the mean */
    rest->bias_q16[axis] = bias_q16 + fixed_mul_q15(mean_q16 - bias_q16, gain_q15);
}

/* One axis more of the low-passed acceleration's square. */
static PORT_OUTLINE void weigh(rest_t *rest, uint8_t axis)
{
    const int16_t  low    = whole(rest->low_q16[axis]);
    const uint32_t square = (uint32_t)port_mac_i16(0, low, low); /* <= 2^30 */

    rest->gravity2 = axis == 0U ? square : rest->gravity2 + square;
}

/* Six visits without motion. */
static PORT_OUTLINE void end_round(rest_t *rest)
{
    const rest_config_t *config = rest->config;
    const uint8_t        ended  = rest->rounds;

    rest->rounds = (uint8_t)(ended + 1U);
    if ((rest->flags & REST_AT_REST) == 0U) {
        if (rest->rounds == config->still_rounds) {
            rest->flags |= REST_AT_REST;
            rest->rounds = 0U;
        }
    } else if (ended == ROUND_WEIGHS) {
        if (rest->gravity2 < config->gravity2_min || rest->gravity2 > config->gravity2_max) {
            fixed_count(&rest->implausible);
            rest->rounds = 0U;
        } else if (rest->blocks != config->gain_len) {
            ++rest->blocks;
        }
    } else if (ended == ROUND_LEARNS) {
        rest->flags |= REST_BIAS_KNOWN;
        rest->rounds = 0U;
    }
}

/* Move the low-pass towards the sample; gives how far off the sample was, in whole counts. With
 * a gain below 1/2 the low-pass stays inside int16, as the samples do (notes). */
static inline int16_t follow(int32_t *low_q16, int16_t sample, int16_t gain_q16)
{
    const int32_t low = *low_q16;
    const int16_t off = port_sub_sat_i16(sample, whole(low));

    *low_q16 = port_mac_i16(low, gain_q16, off);
    return off;
}

static bool refused(rest_t *rest, int16_t sample)
{
    if (sample != INT16_MAX && sample != INT16_MIN) { return false; }
    fixed_count(&rest->rejected);
    return true;
}

/* Both give whether the axis is still, and do the block's work. */

static PORT_OUTLINE bool visit_acc(rest_t *rest, uint8_t axis, int16_t sample)
{
    const rest_config_t *config  = rest->config;
    const bool           at_rest = (rest->flags & REST_AT_REST) != 0U;

    if (refused(rest, sample)) { return false; }
    const int16_t off = follow(&rest->low_q16[axis], sample, config->lowpass_q16);
    if (!at_rest) { return !beyond(off, config->enter_acc_counts); }
    if (beyond(off, config->leave_acc_counts)) { return false; }
    if (rest->rounds == ROUND_WEIGHS) { weigh(rest, axis); }
    return true;
}

static PORT_OUTLINE bool visit_gyro(rest_t *rest, uint8_t axis, int16_t sample)
{
    const rest_config_t *config  = rest->config;
    int32_t             *low_q16 = &rest->low_q16[AXES + axis];

    if (refused(rest, sample)) { return false; }
    const int16_t off = follow(low_q16, sample, config->lowpass_q16);
    if (beyond(whole(*low_q16), config->bias_max_counts)) { return false; }
    if ((rest->flags & REST_AT_REST) == 0U) { return !beyond(off, config->enter_gyro_counts); }
    if (beyond(off, config->leave_gyro_counts)) { return false; }
    if (rest->rounds < REST_BLOCK_ROUNDS) {
        const int16_t before   = rest->rounds == 0U ? 0 : rest->sum_counts[axis];
        rest->sum_counts[axis] = (int16_t)(before + sample); /* |sample| <= GYRO_LIMIT_MAX + 1 */
    }
    return true;
}

/* Whether this visit showed no motion. */
static bool visit_next(rest_t *rest, uint8_t visit, const int16_t gyro[3], const int16_t acc[3])
{
    if (visit >= AXES) { return visit_gyro(rest, (uint8_t)(visit - AXES), gyro[visit - AXES]); }
    if (rest->rounds != ROUND_LEARNS || (rest->flags & REST_AT_REST) == 0U) {
        return visit_acc(rest, visit, acc[visit]);
    }
    learn(rest, visit); /* in place of a look, so that no call costs both */
    return true;
}

uint8_t rest_update(rest_t *rest, const int16_t gyro_b_counts[3], const int16_t acc_b_counts[3])
{
    const uint8_t visit = rest->visit;

    rest->visit = visit == VISITS - 1U ? 0U : (uint8_t)(visit + 1U);
    if (!visit_next(rest, visit, gyro_b_counts, acc_b_counts)) {
        rest_interrupt(rest);
    } else if (visit == VISITS - 1U) {
        end_round(rest);
    }
    return rest->flags;
}
