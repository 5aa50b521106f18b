/* SPDX-License-Identifier: MIT */
#include "zupt.h"

#include "fixed.h"
#include "port_assert.h"
#include "port_dot.h"
#include "port_outline.h"
#include "port_rom.h"
#include "zupt_configs.h"

enum {
    AXES             = 3,
    LIMIT_HIGH       = (ZUPT_VALUE_MAX + 1) / 256, /* its upper byte is enough to compare */
    MAGNITUDE_WEIGHT = ZUPT_BLOCK * ZUPT_BLOCK     /* |sum a|^2 of a block is 16 |m|^2 too */
};

_Static_assert(ZUPT_GRAVITY_COUNTS == 1 << 11 && ZUPT_BLOCK == 4, "32 g is a shift by 16");

/* (2 (x - g^2) / 2g)^2, where x is |a|^2 or |m|^2, from 16 x.  16 x <= 3 * 2^28, result < 2^29 */
static PORT_OUTLINE int32_t off_gravity(int32_t sixteenfold)
{
    const uint16_t high = (uint16_t)((uint32_t)sixteenfold >> 16);
    const int16_t  off  = (int16_t)(high - (ZUPT_GRAVITY_COUNTS >> 1)); /* -1024..11264 counts */
    const int16_t  two  = (int16_t)(off * 2);

    return (int32_t)two * two;
}

/* Whether the accelerometer's weight is what the detector's equation says. */
static bool fits(const zupt_config_t *config)
{
    const uint8_t acc = config->acc_weight;

    switch (config->detector) {
    case ZUPT_SHOE:
    case ZUPT_MOVING_VARIANCE: return acc == 1U;
    case ZUPT_ARE: return acc == 0U;
    case ZUPT_MAGNITUDE: return acc == MAGNITUDE_WEIGHT;
    default: return false;
    }
}

bool zupt_is_lawful(const zupt_config_t *config)
{
    const bool turns = config->detector <= ZUPT_ARE; /* shoe, are */

    return fits(config) && config->begin_squares[1] <= config->begin_squares[0] &&
           config->begin_squares[0] < 0 && (config->gyro_weight != 0U) == turns &&
           config->gyro_weight <= ZUPT_WEIGHT_MAX && config->still_blocks >= 1U &&
           config->stride >= 1U;
}

static PORT_OUTLINE void begin_block(zupt_t *zupt)
{
    zupt->visit   = 0U;
    zupt->squares = zupt->config.begin_squares[zupt->still];
    for (uint8_t axis = 0U; axis < AXES; ++axis) { zupt->sum_acc[axis] = 0; }
}

PORT_OUTLINE void zupt_interrupt(zupt_t *zupt)
{
    zupt->quiet = 0U;
    zupt->still = 0U;
    begin_block(zupt);
}

void zupt_init(zupt_t *zupt, const zupt_config_t *config)
{
    PORT_ASSERT(zupt_is_lawful(config));

    *zupt        = (zupt_t){0};
    zupt->config = *config;
    begin_block(zupt);
}

void zupt_choose(zupt_t *zupt, uint8_t detector, uint8_t rate)
{
    const uint8_t at = (uint8_t)(detector - 1U);

    zupt->config = (zupt_config_t){0};
    if (at < ZUPT_CONFIGS_LEN) {
        const uint8_t *from = (const uint8_t *)&zupt_configs[at];
        uint8_t       *to   = (uint8_t *)&zupt->config;
        for (uint8_t left = sizeof(zupt_config_t); left != 0U; --left) {
            *to++ = port_rom_u8(from++);
        }
    }
    zupt->config.stride = rate;
    zupt->wait          = 0U;
    zupt_interrupt(zupt);
}

static void judge(zupt_t *zupt)
{
    const uint8_t detector = zupt->config.detector;
    int32_t       more     = 0;

    if ((detector & 1U) != 0U) {
        const int32_t mean = port_dot(zupt->sum_acc, zupt->sum_acc); /* |sum a|^2 <= 3 * 2^28 */
        if (detector == ZUPT_SHOE) { more = off_gravity(mean); }
        more -= mean >> 2; /* ZUPT_BLOCK: sum |a - m|^2 = sum |a|^2 - |sum a|^2 / n */
    }
    if (zupt->squares + more >= 0) {
        zupt_interrupt(zupt);
        return;
    }
    if (zupt->still == 0U && ++zupt->quiet == zupt->config.still_blocks) {
        zupt->still = ZUPT_STILL;
    }
    begin_block(zupt);
}

/* value < -4096 or value > 4095 */
static bool beyond(int16_t value)
{
    return (uint8_t)((uint8_t)(value >> 8) + LIMIT_HIGH) >= 2 * LIMIT_HIGH;
}

static bool on_rail(int16_t value)
{
    return (uint16_t)((uint16_t)value + 0x8001U) <= 1U; /* one comparison for both rails */
}

/* Put one vector into the block.  weight > 0 */
static void gather(zupt_t *zupt, const int16_t vector[AXES], uint8_t weight, bool is_acc)
{
    for (uint8_t axis = 0U; axis < AXES; ++axis) {
        const int16_t value = vector[axis];
        if (beyond(value)) {
            if (on_rail(value)) { fixed_count(&zupt->rejected); }
            zupt_interrupt(zupt);
            return;
        }
        if (is_acc) { zupt->sum_acc[axis] = (int16_t)(zupt->sum_acc[axis] + value); } /* <= 2^14 */
    }
    int32_t square = port_dot(vector, vector) * weight; /* 3 * 2^24, weighed 3 * 2^28 at most */
    if (zupt->config.detector == ZUPT_MAGNITUDE) { square = off_gravity(square); }
    zupt->squares += square; /* below 2^31 whatever comes, as it begins below zero (notes) */
}

uint8_t zupt_update(zupt_t *zupt, const int16_t gyro_b_counts[3], const int16_t acc_b_counts[3])
{
    const zupt_config_t *config = &zupt->config;

    if (zupt->wait != 0U) {
        --zupt->wait;
        return zupt->still;
    }
    zupt->wait          = (uint8_t)(config->stride - 1U);
    const uint8_t visit = zupt->visit++;
    if (visit == ZUPT_VISITS - 1U) {
        judge(zupt);
        return zupt->still;
    }
    const bool    is_acc = (visit & 1U) == 0U;
    const uint8_t weight = is_acc ? config->acc_weight : config->gyro_weight;
    if (weight != 0U) { gather(zupt, is_acc ? acc_b_counts : gyro_b_counts, weight, is_acc); }
    return zupt->still;
}
