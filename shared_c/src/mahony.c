/* SPDX-License-Identifier: MIT */
#include "mahony.h"

#include <stddef.h>
#include <string.h>

#include "mahony_internal.h"
#include "port_turn.h"

enum {
    GYRO_Q33_MAX    = 16128,
    SQUARE_MAX      = 993, /* GYRO_Q33_MAX^2 / 2^18, rounded up */
    CUBIC_MAX       = 2700,
    CORRECT_Q18_MAX = 4095, /* as port_turn.h wants it; the ramp stops there, too */
    LOWPASS_MAX     = 4095, /* eightfold it is below 2^15 */
    START_SHIFT_MAX = 30,
};

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

/* Gains and averages lie together: one memset at a start. */
#define AVERAGES (sizeof(mahony_step_t) - offsetof(mahony_step_t, lowpass_q16))
#define TURNS    (offsetof(mahony_step_t, lowpass_q16) - offsetof(mahony_step_t, gyro_q33))
#define ONE_Q14  INT16_C(0x4000)

_Static_assert(offsetof(mahony_config_t, cubic) - offsetof(mahony_config_t, gyro_q33) ==
                   offsetof(mahony_step_t, cubic) - offsetof(mahony_step_t, gyro_q33),
               "what turns lies in both in one order");

bool mahony_is_lawful(const mahony_config_t *config)
{
    const bool turns = config->gyro_q33 >= 1U && config->gyro_q33 <= GYRO_Q33_MAX &&
                       config->square <= SQUARE_MAX && config->cubic <= CUBIC_MAX;
    const bool gains = config->correct_q18 >= 1U && config->correct_q18 <= CORRECT_Q18_MAX &&
                       config->lowpass_q16 <= LOWPASS_MAX && config->start_shift <= START_SHIFT_MAX;
    const bool ramp  = (config->ramp_mask & (config->ramp_mask + 1U)) == 0U;
    const bool field = config->mag_correct_q21 >= 1U &&
                       config->mag_correct_q21 <= MAHONY_MAG_CORRECT_MAX &&
                       config->mag_learn_q16 <= INT16_MAX;

    return turns && gains && ramp && field && config->acc_one_g <= INT16_MAX &&
           config->moving_min <= INT16_MAX;
}

/* The next accelerations stand the estimate upright, beside the gyroscope, and are not averaged;
 * then gains begin anew. */
static void restart(mahony_t *mahony)
{
    mahony->ramp_left = MAHONY_START_LEN + MAHONY_RAMP_LEN;
    memset(&mahony->step.lowpass_q16, 0, AVERAGES);
}

PORT_OUTLINE void mahony_init(mahony_t *mahony, const mahony_config_t *config)
{
    mahony_step_t *const step = &mahony->step;

    memset(mahony, 0, sizeof *mahony);
    mahony->config       = config;
    mahony->ramp_left    = MAHONY_START_LEN + MAHONY_RAMP_LEN;
    step->quat_wb_q30[0] = INT32_C(1) << 30;
    step->quat_q14[0]    = ONE_Q14;
    step->east_b_q14[0]  = ONE_Q14;
    step->north_b_q14[1] = ONE_Q14;
    memcpy(&step->gyro_q33, &config->gyro_q33, TURNS);
}

static void lower_ramp(mahony_t *mahony)
{
    const uint8_t left    = --mahony->ramp_left;
    uint16_t      lowpass = mahony->config->lowpass_q16;
    uint16_t      correct = mahony->config->correct_q18;

    if (left > MAHONY_RAMP_LEN) { return; }
    for (uint8_t i = (uint8_t)(left + 3U) >> 2; i != 0U; --i) { /* eightfold at first */
        lowpass = (uint16_t)(lowpass * 2U);
        correct = (uint16_t)(correct * 2U);
    }
    if (correct > CORRECT_Q18_MAX) { correct = CORRECT_Q18_MAX; }
    mahony->step.lowpass_q16 = lowpass;
    mahony->step.correct_q18 = correct;
}

static void count_flags(mahony_t *mahony, uint8_t flags)
{
    if ((flags & MAHONY_RAILED) != 0U) { fixed_count(&mahony->counts.railed); }
    if ((flags & MAHONY_ACC_ZERO) != 0U) { fixed_count(&mahony->counts.acc_zero); }
}

void mahony_update(mahony_t *mahony, const int16_t gyro_b_counts[3], const int16_t acc_b_counts[3],
                   const int32_t bias_q16[3])
{
    const uint8_t flags = mahony_is_starting(mahony)
                              ? mahony_stand(mahony, gyro_b_counts, acc_b_counts, bias_q16)
                              : port_turn(&mahony->step, gyro_b_counts, acc_b_counts, bias_q16);

    if (flags != 0U) { count_flags(mahony, flags); }
    if (mahony->ramp_left != 0U && (mahony->step.sample & mahony->config->ramp_mask) == 0U) {
        lower_ramp(mahony);
    }
}

void mahony_bridge(mahony_step_t *step)
{
    static const union {
        int16_t acc_b[3];
        int32_t bias_q16[3];
    } none; /* zeros */

    port_turn(step, step->rate_b, none.acc_b, none.bias_q16);
}

void mahony_gap(mahony_t *mahony, uint16_t samples)
{
    fixed_count(&mahony->counts.gaps);
    if (samples > mahony->config->gap_max) { restart(mahony); }
    if (mahony_is_starting(mahony)) { return; }
    for (; samples != 0U; --samples) { mahony_bridge(&mahony->step); }
}
