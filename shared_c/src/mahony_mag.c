/* SPDX-License-Identifier: MIT */
/* mahony_mag - heading from the field, and when not to believe it (after VQF, sec. 3.5). */
#include <string.h>

#include "mahony_internal.h"
#include "port_i16.h"

enum {
    NORM_OFF_Q16 = 6554, /* a tenth of the reference, */
    DIP_OFF_Q15  = 5571, /* or 0.17 in the sine of the elevation, is another field */
    TURN_MAX_Q24 = 16383,
};

typedef struct {
    int16_t norm;
    int16_t dip_q15;
    int16_t east_q14, north_q14; /* its level part, of length 1 */
} sample_t;

static int16_t raised(int16_t value, uint8_t shift)
{
    int32_t all = value;

    for (; shift != 0U; --shift) { all *= 2; }
    return mahony_limit_i16(all);
}

/* False where the field has no heading: zero, or within 3.6 deg of the vertical. */
static bool take_sample(const mahony_t *mahony, const int16_t mag_b_counts[3], sample_t *sample)
{
    const uint8_t shift    = mahony->config->mag_shift;
    const int16_t mag_b[3] = {raised(mag_b_counts[0], shift), raised(mag_b_counts[1], shift),
                              raised(mag_b_counts[2], shift)};
    int16_t       mag_w[3];

    mahony_to_world(&mahony->step, mag_b, mag_w);
    const uint32_t level2 = port_square_i16(mag_w[0]) + port_square_i16(mag_w[1]);
    const uint32_t norm2  = level2 + port_square_i16(mag_w[2]); /* <= 3 2^30 */
    if (level2 <= norm2 >> 8) { return false; }
    const mahony_root_t level = mahony_root(level2), norm = mahony_root(norm2);
    const uint16_t      length = mahony_length(&norm);

    sample->norm      = length > INT16_MAX ? INT16_MAX : (int16_t)length;
    sample->dip_q15   = mahony_limit_i16(2 * (int32_t)mahony_unit_q14(mag_w[2], &norm));
    sample->east_q14  = mahony_unit_q14(mag_w[0], &level);
    sample->north_q14 = mahony_unit_q14(mag_w[1], &level);
    return true;
}

/* A low-pass with 16 bits more in its state than in its input; |difference| <= 2^16 */
static void follow(int32_t *state_q16, int16_t target, uint16_t gain_q16)
{
    *state_q16 += port_mul_i24(target - (*state_q16 >> 16), (int16_t)gain_q16);
}

static void follow_field(mahony_field_t *field, int16_t norm, int16_t dip_q15, uint16_t gain_q16)
{
    follow(&field->norm_q16, norm, gain_q16);
    follow(&field->dip_q31, dip_q15, gain_q16);
}

static bool is_near(const mahony_field_t *field, const mahony_field_t *reference)
{
    const uint16_t norm     = (uint16_t)(reference->norm_q16 >> 16);
    const int32_t  norm_max = (int32_t)(port_mul_u16(norm, NORM_OFF_Q16) >> 16);
    const int32_t  norm_off = (field->norm_q16 >> 16) - (int32_t)norm;
    const int32_t  dip_off  = (field->dip_q31 >> 16) - (reference->dip_q31 >> 16);

    return norm_off < norm_max && -norm_off < norm_max && dip_off < DIP_OFF_Q15 &&
           -dip_off < DIP_OFF_Q15;
}

static bool is_moving(const mahony_t *mahony)
{
    const int16_t limit = (int16_t)mahony->config->moving_min;

    for (uint8_t i = 0U; i < 3U; ++i) {
        const int16_t rate = mahony->step.rate_b[i];
        if (rate > limit || rate < -limit) { return true; }
    }
    return false;
}

/* Whether the field is not the one that the heading stands on. Learns both. */
static bool is_disturbed(mahony_t *mahony)
{
    const mahony_config_t *const config  = mahony->config;
    mahony_mag_t *const          mag     = &mahony->mag;
    const int16_t                norm    = (int16_t)(mag->smooth.norm_q16 >> 16);
    const int16_t                dip_q15 = (int16_t)(mag->smooth.dip_q31 >> 16);

    if (is_near(&mag->smooth, &mag->reference)) {
        fixed_count(&mag->undisturbed);
        follow_field(&mag->reference, norm, dip_q15, config->mag_learn_q16);
    } else {
        mag->undisturbed = 0U;
    }
    if (is_near(&mag->smooth, &mag->candidate)) {
        if (is_moving(mahony)) { fixed_count(&mag->accepted); }
        follow_field(&mag->candidate, norm, dip_q15, config->mag_learn_q16);
    } else {
        mag->accepted  = 0U;
        mag->candidate = mag->smooth;
    }
    if (mag->settling != 0U) {
        --mag->settling;
        return false;
    }
    if (mag->undisturbed >= config->mag_recover_len) { return false; }
    if (mag->accepted <= config->mag_accept_len) { return true; }
    mag->reference   = mag->candidate; /* it has held while the board turned: it is the world's */
    mag->undisturbed = config->mag_recover_len;
    mag->accepted    = 0U;
    return false;
}

/* Gain of the heading: none while a disturbance is bridged, half of it when that takes too long. */
static uint16_t take_gain(mahony_t *mahony)
{
    mahony_mag_t *const mag  = &mahony->mag;
    uint16_t            gain = mahony_raised(mahony, mahony->config->mag_correct_q24);

    if (gain > TURN_MAX_Q24) { gain = TURN_MAX_Q24; }
    if (!is_disturbed(mahony)) {
        mag->rejected = mag->rejected > 2U ? (uint16_t)(mag->rejected - 2U) : 0U;
        return gain;
    }
    fixed_count(&mahony->counts.mag_disturbed);
    if (mag->rejected >= mahony->config->mag_reject_len) { return gain >> 1; }
    ++mag->rejected;
    return 0U;
}

/* Turn the world about its vertical: quat += k quat turn, k being world z. */
static void turn_heading(mahony_step_t *step, int16_t turn_q24)
{
    const int16_t w = step->quat_q14[0], x = step->quat_q14[1];
    const int16_t y = step->quat_q14[2], z = step->quat_q14[3];

    step->quat_wb_q30[0] += (port_mul_i16((int16_t)-z, turn_q24) + 128) >> 8;
    step->quat_wb_q30[1] += (port_mul_i16((int16_t)-y, turn_q24) + 128) >> 8;
    step->quat_wb_q30[2] += (port_mul_i16(x, turn_q24) + 128) >> 8;
    step->quat_wb_q30[3] += (port_mul_i16(w, turn_q24) + 128) >> 8;
}

static void start_heading(mahony_t *mahony, const sample_t *sample)
{
    const mahony_half_t half        = mahony_half(sample->north_q14);
    const int16_t       smaller     = mahony_half_sine_q14(sample->east_q14, &half);
    const bool          ahead       = sample->north_q14 >= 0;
    const int16_t       left_q14[4] = {ahead ? half.larger_q14 : smaller, 0, 0,
                                 ahead ? smaller : half.larger_q14};

    mahony_turn_world(&mahony->step, left_q14);
    mahony->mag.smooth.norm_q16 = (int32_t)sample->norm << 16;
    mahony->mag.smooth.dip_q31  = sample->dip_q15 * INT32_C(65536);
    mahony->mag.reference       = mahony->mag.smooth;
    mahony->mag.candidate       = mahony->mag.smooth;
    mahony->mag.started         = true;
}

void mahony_update_mag(mahony_t *mahony, const int16_t mag_b_counts[3])
{
    sample_t sample;

    if (!mahony->started) { return; }
    if (!take_sample(mahony, mag_b_counts, &sample)) {
        fixed_count(&mahony->counts.mag_refused);
        return;
    }
    if (!mahony->mag.started) {
        start_heading(mahony, &sample);
        return;
    }
    follow_field(&mahony->mag.smooth, sample.norm, sample.dip_q15, mahony->config->mag_smooth_q16);

    int16_t sine_q14 = sample.east_q14; /* of the heading's error; behind, as far as it goes */
    if (sample.north_q14 < 0) { sine_q14 = sine_q14 > 0 ? MAHONY_ONE_Q14 : -MAHONY_ONE_Q14; }
    const int32_t turn_q40 = 4 * port_mul_i16(sine_q14, (int16_t)take_gain(mahony)) +
                             mahony->mag.turn_res; /* |.| <= 2^30 + 2^16 */

    mahony->mag.turn_res = (uint16_t)turn_q40;
    turn_heading(&mahony->step, (int16_t)(turn_q40 >> 16));
}
