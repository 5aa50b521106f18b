/* SPDX-License-Identifier: MIT */
#include "imu_cal.h"

#include "fixed.h"
#include "port_assert.h"
#include "port_imu_cal.h"

enum {
    AXES      = 3,
    ROW_MAX   = 32767,   /* Q16: sum |D| of a row, so that |D raw| <= 2^30 - 2^15 */
    SLOPE_MAX = 1 << 14, /* Q16: so that |slope| * 2^15 <= 2^29 */
    PART_AXIS = 3,       /* which of the part's, in an orientation's code of one axis */
    CODE_BITS = 3        /* as long is such a code; the board's y lies above its x */
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

    if (orientation >= 1U << (2 * CODE_BITS)) { return false; }
    if (x == AXES || y == AXES) { return false; }
    return x != y;
}

void imu_cal_turn(uint8_t orientation, int16_t vector_b_counts[3])
{
    port_imu_turn(orientation, vector_b_counts);
}
