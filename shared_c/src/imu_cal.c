/* SPDX-License-Identifier: MIT */
#include "imu_cal.h"

#include "fixed.h"
#include "port_assert.h"
#include "port_hot.h"
#include "port_i16.h"
#include "port_imu_cal.h"

enum {
    AXES      = 3,
    ROW_MAX   = 32767,  /* Q16: sum |D| of a row, so that |D raw| <= 2^30 - 2^15 */
    SLOPE_MAX = 1 << 14 /* Q16: so that |slope| * 2^15 <= 2^29 */
};

#define OFFSET_LIMIT (1L << 29) /* Q16; with the two above, |sum| < 2^31 (notes) */

static uint16_t magnitude(int16_t value)
{
    return value < 0 ? (uint16_t)(0U - (uint16_t)value) : (uint16_t)value;
}

bool imu_cal_is_lawful(const imu_cal_config_t *config)
{
    for (uint8_t row = 0U; row < AXES; ++row) {
        uint32_t sum = 0U;
        for (uint8_t at = 0U; at < AXES; ++at) { sum += magnitude(config->matrix_q16[row][at]); }
        if (sum > ROW_MAX || magnitude(config->slope_q16[row]) > SLOPE_MAX) { return false; }
        const int32_t offset = config->offset_q16[row];
        if (offset >= OFFSET_LIMIT || offset <= -OFFSET_LIMIT) { return false; }
    }
    return true;
}

void imu_cal_init(imu_cal_t *cal, const imu_cal_config_t *config)
{
    PORT_ASSERT(imu_cal_is_lawful(config));

    cal->config  = config;
    cal->clipped = 0U;
    imu_cal_set_temperature(cal, 0);
}

void imu_cal_set_temperature(imu_cal_t *cal, int16_t above_reference_counts)
{
    const imu_cal_config_t *config = cal->config;

    for (uint8_t row = 0U; row < AXES; ++row) {
        const int32_t warm  = port_mac_i16(config->offset_q16[row], config->slope_q16[row],
                                           above_reference_counts); /* |.| < 2^30 */
        cal->added_q16[row] = (1L << 15) - warm;
    }
}

void imu_cal_apply(imu_cal_t *cal, const int16_t raw_b_counts[3], int16_t true_b_counts[3])
{
    if (port_imu_cal(cal, raw_b_counts, true_b_counts)) { fixed_count(&cal->clipped); }
}
