/* SPDX-License-Identifier: MIT */
#include "imu_cal.h"

#include "fixed.h"
#include "port_assert.h"
#include "port_imu_cal.h"
#include "port_outline.h"

enum {
    AXES      = 3,
    ROW_MAX   = 32767,   /* Q16: sum |D| of a row, so that |D raw| <= 2^30 - 2^15 */
    SLOPE_MAX = 1 << 14, /* Q16: so that |slope| * 2^15 <= 2^29 */
    PART_AXIS = 3,       /* an orientation's code of one axis: which of the part's */
    NEGATED   = 4,       /* and whether it points the other way */
    CODE_BITS = 3        /* of an axis; the board's y lies above its x */
};

static uint16_t magnitude(int16_t value)
{
    return value < 0 ? (uint16_t)(0U - (uint16_t)value) : (uint16_t)value;
}

bool imu_cal_is_lawful(const imu_cal_config_t *config)
{
    for (uint8_t row = 0U; row < AXES; ++row) {
        uint16_t sum = 0U; /* <= 2^15 - 1 before each addition of at most 2^15 */
        for (uint8_t at = 0U; at < AXES; ++at) {
            sum = (uint16_t)(sum + magnitude(config->matrix_q16[row][at]));
            if (sum > ROW_MAX) { return false; }
        }
    }
    return true;
}

void imu_cal_init(imu_cal_t *cal, const imu_cal_config_t *config)
{
    cal->config  = config;
    cal->clipped = 0U;
}

void imu_cal_apply(imu_cal_t *cal, int16_t vector_b_counts[3])
{
    if (port_imu_cal(cal->config, vector_b_counts)) { fixed_count(&cal->clipped); }
}

void imu_cal_at_temperature(const imu_cal_config_t *reference, const int16_t slope_q16[3],
                            int16_t above_reference_counts, imu_cal_config_t *warm)
{
    *warm = *reference;
    for (uint8_t row = 0U; row < AXES; ++row) {
        PORT_ASSERT(magnitude(slope_q16[row]) <= SLOPE_MAX);
        const int32_t more_q16 = (int32_t)slope_q16[row] * above_reference_counts; /* <= 2^29 */
        const int32_t wanted   = warm->offset_q3[row] + ((more_q16 + (1 << 12)) >> 13);
        warm->offset_q3[row]   = (int16_t)(wanted > INT16_MAX   ? INT16_MAX
                                           : wanted < INT16_MIN ? INT16_MIN
                                                                : wanted);
    }
}

bool imu_cal_orientation_is_lawful(uint8_t orientation)
{
    const uint8_t x = orientation & PART_AXIS, y = (uint8_t)(orientation >> CODE_BITS) & PART_AXIS;

    return orientation >> (2 * CODE_BITS) == 0 && x < AXES && y < AXES && x != y;
}

/* The axis of the part that the code names. */
static PORT_OUTLINE int16_t along(const int16_t vector[3], uint8_t code)
{
    const int16_t value = vector[code & PART_AXIS];

    if ((code & NEGATED) == 0U) { return value; }
    return value == INT16_MIN ? INT16_MAX : (int16_t)-value;
}

void imu_cal_turn(uint8_t orientation, int16_t vector_b_counts[3])
{
    const uint8_t x = orientation & PART_AXIS, y_code = (uint8_t)(orientation >> CODE_BITS);
    const uint8_t y = y_code & PART_AXIS, after_x = x == AXES - 1U ? 0U : (uint8_t)(x + 1U);
    uint8_t       z_code = (uint8_t)(((orientation ^ y_code) & NEGATED) | (AXES - x - y));

    if (y != after_x) { z_code ^= NEGATED; }
    const int16_t body_x = along(vector_b_counts, orientation);
    const int16_t body_y = along(vector_b_counts, y_code);
    vector_b_counts[2]   = along(vector_b_counts, z_code);
    vector_b_counts[1]   = body_y;
    vector_b_counts[0]   = body_x;
}
