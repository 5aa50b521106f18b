/* SPDX-License-Identifier: MIT */
/* port_turn - one step of an attitude filter. Plain: as src/port_turn.h says it. */
#include "port_turn.h"

#include "port_dot.h"
#include "port_i16.h"

/* value + remainder: the upper part is the result, the lower one the new remainder. */
static int32_t carry(int64_t value, uint16_t *remainder)
{
    const int64_t sum = value + *remainder;

    *remainder = (uint16_t)sum;
    return (int32_t)(sum >> 16);
}

static bool near_end(int16_t value)
{
    return value >= 127 * 256 || value < -127 * 256;
}

static uint8_t flags_of(const int16_t gyro_b_counts[3], const int16_t acc_b_counts[3])
{
    bool railed = false;

    for (uint8_t i = 0U; i < 3U; ++i) {
        railed |= near_end(gyro_b_counts[i]) || near_end(acc_b_counts[i]);
    }
    return (uint8_t)(((acc_b_counts[0] | acc_b_counts[1] | acc_b_counts[2]) == 0 ? MAHONY_ACC_ZERO
                                                                                 : 0) |
                     (railed ? MAHONY_RAILED : 0));
}

static int32_t limited(int64_t value, int32_t end)
{
    return value < -end ? -end : value >= end ? end - 1 : (int32_t)value;
}

static void take_level(mahony_step_t *step, int32_t level_q14)
{
    const bool            north = step->sample % 2U != 0U;
    mahony_level_t *const level = &step->level_w[north ? 1 : 0];
    const int64_t diff_q14 = (int64_t)step->level_q14 + level_q14 - 2 * (int64_t)level->mean_q14;
    const int64_t mean_q14 = level->mean_q14 +
                             (int64_t)carry(diff_q14, &level->mean_res) * step->lowpass_q16;

    level->mean_q14    = limited(mean_q14, INT32_C(1) << 27);
    const int64_t turn = (int64_t)(level->mean_q14 >> 8) * step->correct_q18;
    const int32_t high = carry(north ? turn : -turn, &level->correct_res);
    step->correct_q19  = (int16_t)limited(high, 512);
}

static void take_turn(mahony_step_t *step, int32_t turn_q17[4])
{
    const int16_t *const row    = step->sample % 2U != 0U ? step->east_b_q14 : step->north_b_q14;
    const int64_t        square = (int64_t)step->rate_b[0] * step->rate_b[0] +
                           (int64_t)step->rate_b[1] * step->rate_b[1] +
                           (int64_t)step->rate_b[2] * step->rate_b[2];
    const int64_t loss_q33 = (int64_t)carry(square, &step->square_res) * step->square +
                             (int64_t)step->norm_error_q20 * 512;
    const int32_t loss_q17  = carry(loss_q33, &step->loss_res);
    const int32_t scale_q33 = carry(
        (int64_t)step->gyro_q33 * 65536 - (int64_t)loss_q17 * step->cubic, &step->scale_res);

    turn_q17[0] = -loss_q17;
    for (uint8_t i = 0U; i < 3U; ++i) {
        turn_q17[1U + i] = carry((int64_t)scale_q33 * step->rate_b[i] +
                                     (int64_t)step->correct_q19 * row[i],
                                 &step->turn_res[i]);
    }
}

static void advance(mahony_step_t *step, const int32_t turn_q17[4])
{
    const int32_t w = step->quat_q14[0], x = step->quat_q14[1];
    const int32_t y = step->quat_q14[2], z = step->quat_q14[3];
    const int32_t s = turn_q17[0], a = turn_q17[1], b = turn_q17[2], c = turn_q17[3];

    step->quat_wb_q30[0] += (s * w - a * x - b * y - c * z + 1) >> 1;
    step->quat_wb_q30[1] += (s * x + a * w + c * y - b * z + 1) >> 1;
    step->quat_wb_q30[2] += (s * y + b * w + a * z - c * x + 1) >> 1;
    step->quat_wb_q30[3] += (s * z + c * w + b * x - a * y + 1) >> 1;
    for (uint8_t i = 0U; i < 4U; ++i) {
        const int32_t sum = step->quat_wb_q30[i] + step->cut_q22[i] * 256;

        step->quat_q14[i] = (int16_t)(sum >> 16);
        step->cut_q22[i]  = (uint8_t)(sum >> 8);
    }
}

static int16_t row_q14(int32_t value_q28)
{
    return (int16_t)(((value_q28 >> 8) + 32) >> 6);
}

static int16_t row_from_half_q14(int32_t half_q28)
{
    return (int16_t)(((half_q28 >> 8) + 16) >> 5);
}

static void take_rows(mahony_step_t *step)
{
    const int32_t w = step->quat_q14[0], x = step->quat_q14[1];
    const int32_t y = step->quat_q14[2], z = step->quat_q14[3];
    const int32_t ww = w * w, xx = x * x, yy = y * y, zz = z * z;

    step->east_b_q14[0]  = row_q14(ww + xx - yy - zz);
    step->east_b_q14[1]  = row_from_half_q14(x * y - w * z);
    step->east_b_q14[2]  = row_from_half_q14(x * z + w * y);
    step->north_b_q14[0] = row_from_half_q14(x * y + w * z);
    step->north_b_q14[1] = row_q14(ww - xx + yy - zz);
    step->north_b_q14[2] = row_from_half_q14(y * z - w * x);
    step->norm_error_q20 = (int16_t)((ww + xx + yy + zz - (INT32_C(1) << 28)) >> 8);
}

uint8_t port_turn(mahony_step_t *step, const int16_t gyro_b_counts[3],
                  const int16_t acc_b_counts[3], const int32_t bias_q16[3])
{
    const int32_t east_q14  = port_dot(step->east_b_q14, acc_b_counts);
    const int32_t north_q14 = port_dot(step->north_b_q14, acc_b_counts);
    int32_t       turn_q17[4];

    step->flags = flags_of(gyro_b_counts, acc_b_counts);
    ++step->sample;
    if ((step->flags & MAHONY_ACC_ZERO) != 0U) {
        step->correct_q19 = 0;
    } else {
        take_level(step, step->sample % 2U == 0U ? east_q14 : north_q14);
    }
    step->level_q14 = step->sample % 2U == 0U ? north_q14 : east_q14;
    for (uint8_t i = 0U; i < 3U; ++i) {
        step->rate_b[i] = port_sat_i16(
            carry((int64_t)gyro_b_counts[i] * 65536 - bias_q16[i], &step->rate_res[i]));
    }
    take_turn(step, turn_q17);
    advance(step, turn_q17);
    take_rows(step);
    return step->flags;
}
