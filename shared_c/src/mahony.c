/* SPDX-License-Identifier: MIT */
#include "mahony.h"

#include <stddef.h>
#include <string.h>

#include "mahony_internal.h"
#include "port_assert.h"
#include "port_dot.h"
#include "port_i16.h"
#include "port_turn.h"

enum {
    GYRO_Q33_MAX    = 16128,
    SQUARE_MAX      = 993, /* GYRO_Q33_MAX^2 / 2^18, rounded up */
    CUBIC_MAX       = 2700,
    CORRECT_Q18_MAX = 4095, /* as port_turn.h wants it; the ramp stops there, too */
    MAG_CORRECT_MAX = 16383,
};

#define INTEGRAL_MAX_Q22 (INT32_C(328) << 22) /* 20 deg/s, the gyroscope's worst offset */
#define MEAN_MAX_Q14     (INT32_C(1) << 27)
#define HALF_Q16         UINT16_C(0x8000)

/* port_turn.S reaches the fields by these offsets. */
#define AT(field, offset) \
    _Static_assert(offsetof(mahony_step_t, field) == (offset), "port_turn.S: " #field)
AT(quat_q14, 16);
AT(cut_q22, 24);
AT(east_b_q14, 28);
AT(north_b_q14, 34);
AT(norm_error_q20, 40);
AT(rate_b, 42);
AT(rate_res, 48);
AT(correct_q19, 54);
AT(level_q14, 56);
AT(sample, 60);
AT(flags, 61);
AT(turn_res, 62);
AT(square_res, 68);
AT(loss_res, 70);
AT(scale_res, 72);
AT(gyro_q33, 74);
AT(square, 76);
AT(cubic, 78);
AT(lowpass_q16, 80);
AT(correct_q18, 82);
AT(level_w, 84);
_Static_assert(sizeof(mahony_level_t) == 8 && offsetof(mahony_level_t, correct_res) == 6,
               "port_turn.S: MEAN, MEAN_RES, CORRECT_RES");
#undef AT

static const int16_t zero_acc[3]      = {0, 0, 0};
static const int32_t zero_bias_q16[3] = {0, 0, 0};

bool mahony_is_lawful(const mahony_config_t *config)
{
    const bool turns = config->gyro_q33 >= 1U && config->gyro_q33 <= GYRO_Q33_MAX &&
                       config->square <= SQUARE_MAX && config->cubic <= CUBIC_MAX &&
                       config->steps >= 1U;
    const bool gains = config->mode <= MAHONY_CLASSIC && config->correct_q18 >= 1U &&
                       config->correct_q18 <= CORRECT_Q18_MAX && config->lowpass_q16 <= INT16_MAX &&
                       (config->lowpass_q16 != 0U) == (config->mode == MAHONY_SECOND_ORDER);
    const bool ramp  = port_mul_u16(config->ramp_len, config->ramp_step_q12) <= UINT16_MAX;
    const bool field = config->mag_correct_q21 <= MAG_CORRECT_MAX && config->mag_times_64 <= 1U &&
                       config->mag_smooth_q16 <= INT16_MAX && config->mag_learn_q16 <= INT16_MAX;

    return turns && gains && ramp && field && config->integral <= INT16_MAX &&
           config->acc_one_g <= INT16_MAX && config->moving_min <= INT16_MAX;
}

void mahony_init(mahony_t *mahony, const mahony_config_t *config)
{
    PORT_ASSERT(mahony_is_lawful(config));

    memset(mahony, 0, sizeof *mahony);
    mahony->config       = config;
    mahony->mag.settling = config->mag_settle_len;

    mahony_step_t *const step = &mahony->step;
    step->quat_wb_q30[0]      = INT32_C(1) << 30;
    step->quat_q14[0]         = MAHONY_ONE_Q14;
    step->east_b_q14[0]       = MAHONY_ONE_Q14;
    step->north_b_q14[1]      = MAHONY_ONE_Q14;
    step->gyro_q33            = config->gyro_q33;
    step->square              = config->square;
    step->cubic               = config->cubic;
    /* Carries begin at one half, so that the first cut rounds. */
    for (uint8_t i = 0U; i < 4U; ++i) { step->cut_q22[i] = 0x80U; }
    for (uint8_t i = 0U; i < 3U; ++i) {
        step->rate_res[i] = HALF_Q16;
        step->turn_res[i] = HALF_Q16;
    }
}

uint16_t mahony_raised(const mahony_t *mahony, uint16_t gain)
{
    const uint16_t more_q12 = (uint16_t)(mahony->ramp_left * mahony->config->ramp_step_q12);
    const uint32_t all      = gain + (port_mul_u16(gain, (uint16_t)(more_q12 >> 4)) >> 8);

    return all > INT16_MAX ? INT16_MAX : (uint16_t)all;
}

uint16_t mahony_correct_q18(const mahony_t *mahony)
{
    const uint16_t correct = mahony_raised(mahony, mahony->config->correct_q18);

    return correct > CORRECT_Q18_MAX ? CORRECT_Q18_MAX : correct;
}

/* The axis that the next step averages. */
static uint8_t next_axis(const mahony_step_t *step)
{
    return (uint8_t)((step->sample + 1U) & 1U);
}

/* The level acceleration is unknown: as if its mean had come again. */
static void forget_level(mahony_step_t *step)
{
    step->level_q14 = step->level_w[next_axis(step)].mean_q14;
}

static PORT_OUTLINE void count_flags(mahony_t *mahony, uint8_t flags)
{
    if ((flags & MAHONY_RAILED) != 0U) { fixed_count(&mahony->counts.railed); }
    if ((flags & MAHONY_ACC_ZERO) != 0U) {
        fixed_count(&mahony->counts.acc_zero);
        forget_level(&mahony->step);
    }
}

/* ki: a bias of the gyroscope is what the world is turned against, in the long run. */
static void integrate(mahony_t *mahony)
{
    const mahony_step_t *const step  = &mahony->step;
    const int16_t *const       about = next_axis(step) == 0U ? step->east_b_q14 : step->north_b_q14;
    const int32_t              more  = mahony->integral_res +
                         port_mul_i16(step->correct_q19, (int16_t)mahony->config->integral);

    mahony->integral_res = (uint16_t)more;
    for (uint8_t i = 0U; i < 3U; ++i) {
        int32_t bias_q22 = mahony->integral_q22[i]; /* 328 2^22 + 2^29 < 2^31 */

        bias_q22 -= port_mul_i16(about[i], (int16_t)(more >> 16));
        if (bias_q22 > INTEGRAL_MAX_Q22) { bias_q22 = INTEGRAL_MAX_Q22; }
        if (bias_q22 < -INTEGRAL_MAX_Q22) { bias_q22 = -INTEGRAL_MAX_Q22; }
        mahony->integral_q22[i] = bias_q22;
    }
}

/* Linear and classic: u is not an average but what two samples, or this one, say. */
static void follow(mahony_t *mahony, const int16_t acc_b_counts[3])
{
    mahony_step_t *const step      = &mahony->step;
    const uint8_t        axis      = next_axis(step);
    const int16_t *const row       = axis == 0U ? step->east_b_q14 : step->north_b_q14;
    int32_t              level_q14 = port_dot(row, acc_b_counts);

    if (mahony->config->mode == MAHONY_LINEAR) {
        level_q14 = (level_q14 + step->level_q14) >> 1; /* |.| <= 2^30.8 before */
        if (level_q14 >= MEAN_MAX_Q14) { level_q14 = MEAN_MAX_Q14 - 1; }
        if (level_q14 < -MEAN_MAX_Q14) { level_q14 = -MEAN_MAX_Q14; }
    } else {
        const uint32_t square = port_square_i16(acc_b_counts[0]) +
                                port_square_i16(acc_b_counts[1]) + port_square_i16(acc_b_counts[2]);
        const mahony_root_t root   = mahony_root(square);
        const int32_t       length = mahony_length(&root);
        int32_t             level  = mahony_shift_14(level_q14);

        if (level > length) { level = length; } /* rows are longer than 1 by 6e-4 at most */
        if (level < -length) { level = -length; }
        level_q14 = mahony_unit_q14(mahony_limit_i16(level), &root) * INT32_C(2048); /* g: 2^25 */
    }
    step->level_w[axis].mean_q14 = level_q14;
}

/* The rest of a sample's turn where one step would be too large. */
static void repeat(mahony_step_t *step, uint8_t steps)
{
    const int32_t level_q14 = step->level_q14;
    const uint8_t sample    = step->sample;

    for (; steps != 0U; --steps) { port_turn(step, step->rate_b, zero_acc, zero_bias_q16); }
    step->level_q14 = level_q14;
    step->sample    = sample;
}

static PORT_OUTLINE void update_unusual(mahony_t *mahony, const int16_t gyro_b_counts[3],
                                        const int16_t acc_b_counts[3], const int32_t bias_q16[3])
{
    const mahony_config_t *const config = mahony->config;
    const bool no_acc = (acc_b_counts[0] | acc_b_counts[1] | acc_b_counts[2]) == 0;
    int32_t    both_q16[3];

    if (!mahony->started) {
        if (no_acc) {
            fixed_count(&mahony->counts.acc_zero);
        } else {
            mahony_start(mahony, acc_b_counts);
        }
        return;
    }
    if (config->integral != 0U) { integrate(mahony); }
    for (uint8_t i = 0U; i < 3U; ++i) {
        both_q16[i] = bias_q16[i] + (mahony->integral_q22[i] >> 6);
    }
    if (config->mode != MAHONY_SECOND_ORDER && !no_acc) { follow(mahony, acc_b_counts); }

    const uint8_t flags = port_turn(&mahony->step, gyro_b_counts, acc_b_counts, both_q16);
    if (flags != 0U) { count_flags(mahony, flags); }
    if (config->steps > 1U) { repeat(&mahony->step, (uint8_t)(config->steps - 1U)); }
    mahony->usual = config->steps == 1U && config->integral == 0U &&
                    config->mode == MAHONY_SECOND_ORDER;
}

/* Half of it in the middle of the block, so that no sample costs much more than another. */
static PORT_OUTLINE void lower_ramp(mahony_t *mahony)
{
    if (mahony->ramp_left == 0U) {
        if (mahony->step.sample % MAHONY_RAMP_BLOCK == 0U) { return; }
        mahony->step.correct_q18 = mahony->config->correct_q18;
    } else if (mahony->step.sample % MAHONY_RAMP_BLOCK == 0U) {
        --mahony->ramp_left;
        mahony->step.lowpass_q16 = mahony_raised(mahony, mahony->config->lowpass_q16);
    } else {
        mahony->step.correct_q18 = mahony_correct_q18(mahony);
    }
}

void mahony_update(mahony_t *mahony, const int16_t gyro_b_counts[3], const int16_t acc_b_counts[3],
                   const int32_t bias_q16[3])
{
    if (mahony->usual) {
        const uint8_t flags = port_turn(&mahony->step, gyro_b_counts, acc_b_counts, bias_q16);

        if (flags != 0U) { count_flags(mahony, flags); }
    } else {
        update_unusual(mahony, gyro_b_counts, acc_b_counts, bias_q16);
    }
    if (mahony->step.sample % (MAHONY_RAMP_BLOCK / 2) == 0U) { lower_ramp(mahony); }
}

void mahony_gap(mahony_t *mahony, uint16_t samples)
{
    mahony_step_t *const step = &mahony->step;

    fixed_count(&mahony->counts.gaps);
    if (samples > mahony->config->gap_max) {
        mahony->started = false;
        mahony->usual   = false;
        return;
    }
    if (!mahony->started) { return; }
    for (; samples != 0U; --samples) { repeat(step, mahony->config->steps); }
    forget_level(step);
}
