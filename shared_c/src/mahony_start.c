/* SPDX-License-Identifier: MIT */
/* mahony_start - what happens seldom: start and gaps, and what is asked for. */
#include <string.h>

#include "mahony_internal.h"
#include "port_dot.h"
#include "port_turn.h"

#define ONE_Q28 (INT32_C(1) << 28)

void mahony_normalise(int32_t quat_q30[4])
{
    int16_t high_q14[4];
    int32_t error_q28 = -ONE_Q28;

    for (uint8_t i = 0U; i < 4U; ++i) {
        const int32_t value = quat_q30[i];
        const int16_t high  = (int16_t)((value + INT32_C(0x8000)) >> 16);
        const int8_t  rest  = (int8_t)(value >> 8); /* (high 2^8 + rest)^2, less rest^2 */

        error_q28 += (int32_t)port_square_i16(high) + mahony_floor_7(port_mul_i16(high, rest));
        high_q14[i] = high;
    }
    /* 1/sqrt(1 + e) = 1 - e/2 + 3/8 e^2, |e| < 2^-8: what follows is below 2e-8 */
    const int16_t half_q24   = (int16_t)((error_q28 * 8 + 128) >> 8);
    const int16_t square_q24 = (int16_t)(port_square_i16(half_q24) >> 24);
    const int16_t factor_q24 = (int16_t)(square_q24 + (square_q24 >> 1) - half_q24);

    for (uint8_t i = 0U; i < 4U; ++i) {
        quat_q30[i] += (port_mul_i16(high_q14[i], factor_q24) + 128) >> 8;
    }
}

void mahony_quaternion(const mahony_t *mahony, int32_t quat_wb_q30[4])
{
    for (uint8_t i = 0U; i < 4U; ++i) { quat_wb_q30[i] = mahony->step.quat_wb_q30[i]; }
    mahony_normalise(quat_wb_q30);
}

static int16_t crossed(int16_t a, int16_t b, int16_t c, int16_t d)
{
    return (int16_t)mahony_shift_14(port_mul_i16(a, b) - port_mul_i16(c, d));
}

void mahony_up_b_q14(const mahony_step_t *step, int16_t up_b_q14[3])
{
    const int16_t *const east = step->east_b_q14, *const north = step->north_b_q14;

    up_b_q14[0] = crossed(east[1], north[2], east[2], north[1]);
    up_b_q14[1] = crossed(east[2], north[0], east[0], north[2]);
    up_b_q14[2] = crossed(east[0], north[1], east[1], north[0]);
}

void mahony_free_acceleration(const mahony_t *mahony, const int16_t acc_b_counts[3],
                              int16_t free_b_counts[3])
{
    int16_t up_b_q14[3];

    mahony_up_b_q14(&mahony->step, up_b_q14);
    for (uint8_t i = 0U; i < 3U; ++i) {
        const int32_t gravity = port_mul_i16(up_b_q14[i], (int16_t)mahony->config->acc_one_g);

        free_b_counts[i] = mahony_limit_i16(acc_b_counts[i] - mahony_shift_14(gravity));
    }
}

mahony_half_t mahony_half(int16_t cos_q14)
{
    const uint16_t size_q14 = (uint16_t)(cos_q14 < 0 ? -cos_q14 : cos_q14); /* <= 2^14 + 2 */
    uint32_t       half_q32 = (uint32_t)(size_q14 + MAHONY_ONE_Q14) << 17;  /* (1 + |cos|) / 2 */

    if (size_q14 >= MAHONY_ONE_Q14) { half_q32 = UINT32_MAX; }
    const mahony_root_t root   = mahony_root(half_q32);
    const uint32_t      larger = port_mul_u16((uint16_t)(half_q32 >> 16), root.inverse_q15);

    return (mahony_half_t){(int16_t)((larger + UINT32_C(0x10000)) >> 17), root.inverse_q15};
}

int16_t mahony_half_sine_q14(int16_t sin_q14, const mahony_half_t *half)
{
    const int16_t inverse_q14 = (int16_t)(half->inverse_q15 >> 1); /* 1 / larger, 1..1.42 */

    return (int16_t)((port_mul_i16(sin_q14, inverse_q14) + (INT32_C(1) << 14)) >> 15);
}

static int16_t to_q14(int32_t value_q30)
{
    return (int16_t)((value_q30 + INT32_C(0x8000)) >> 16);
}

void mahony_turn_world(mahony_step_t *step, const int16_t left_q14[4])
{
    const int16_t  a = left_q14[0], b = left_q14[1], c = left_q14[2], d = left_q14[3];
    const int16_t  w = to_q14(step->quat_wb_q30[0]), x = to_q14(step->quat_wb_q30[1]);
    const int16_t  y = to_q14(step->quat_wb_q30[2]), z = to_q14(step->quat_wb_q30[3]);
    int32_t *const q = step->quat_wb_q30;

    q[0] = 4 * (port_mul_i16(a, w) - port_mul_i16(b, x) - port_mul_i16(c, y) - port_mul_i16(d, z));
    q[1] = 4 * (port_mul_i16(a, x) + port_mul_i16(b, w) + port_mul_i16(c, z) - port_mul_i16(d, y));
    q[2] = 4 * (port_mul_i16(a, y) - port_mul_i16(b, z) + port_mul_i16(c, w) + port_mul_i16(d, x));
    q[3] = 4 * (port_mul_i16(a, z) + port_mul_i16(b, y) - port_mul_i16(c, x) + port_mul_i16(d, w));
    mahony_normalise(q); /* both factors are 1 within 2e-4 */
    for (uint8_t i = 0U; i < 4U; ++i) { step->cut_q22[i] = 128U; }
    mahony_still(step);
}

void mahony_still(mahony_step_t *step)
{
    static const int16_t none[3]     = {0, 0, 0};
    static const int32_t none_q16[3] = {0, 0, 0};
    const int16_t        rate_b[3]   = {step->rate_b[0], step->rate_b[1], step->rate_b[2]};

    step->norm_error_q20 = 0; /* nothing turns, and no carry moves */
    port_turn(step, none, none, none_q16);
    memcpy(step->rate_b, rate_b, sizeof rate_b);
}

static int16_t along(const int16_t row_b_q14[3], const int16_t vector_b[3])
{
    return mahony_limit_i16(mahony_shift_14(port_dot(row_b_q14, vector_b)));
}

void mahony_start(mahony_t *mahony, const int16_t acc_b_counts[3])
{
    int16_t up_b_q14[3];

    mahony_up_b_q14(&mahony->step, up_b_q14);
    const int16_t  acc_w[3] = {along(mahony->step.east_b_q14, acc_b_counts),
                               along(mahony->step.north_b_q14, acc_b_counts),
                               along(up_b_q14, acc_b_counts)};
    const uint32_t square   = port_square_i16(acc_w[0]) + port_square_i16(acc_w[1]) +
                            port_square_i16(acc_w[2]);
    if (square == 0U) { return; }
    const mahony_root_t root = mahony_root(square);
    const int16_t       x    = mahony_unit_q14(acc_w[0], &root);
    const int16_t       y    = mahony_unit_q14(acc_w[1], &root);
    const int16_t       up   = mahony_unit_q14(acc_w[2], &root);
    const mahony_half_t half = mahony_half(up);

    /* The shortest turn that stands acc upright; beyond the horizontal, one without a small
     * divisor. */
    int16_t left_q14[4] = {half.larger_q14, mahony_half_sine_q14(y, &half),
                           (int16_t)-mahony_half_sine_q14(x, &half), 0};
    if (up < 0) {
        left_q14[0] = left_q14[1];
        left_q14[1] = half.larger_q14;
        left_q14[3] = (int16_t)-left_q14[2];
        left_q14[2] = 0;
    }
    mahony_turn_world(&mahony->step, left_q14);
    memset(mahony->step.level_w, 0, sizeof mahony->step.level_w);
    mahony->step.level_q14   = 0;
    mahony->ramp_left        = mahony->config->ramp_len;
    mahony->step.lowpass_q16 = mahony_raised(mahony, mahony->config->lowpass_q16);
    mahony->step.correct_q18 = mahony_correct_q18(mahony);
    mahony->started          = true;
}
