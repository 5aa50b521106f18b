/* SPDX-License-Identifier: MIT */
/* mahony_mag - heading from the field, and when not to believe it (after VQF, sec. 3.5). */
#include "mahony_internal.h"
#include "port_dot.h"

enum {
    NORM_OFF_Q16 = 6554, /* a tenth of the reference, */
    DIP_OFF_Q15  = 5571, /* or 0.17 in the sine of the elevation, is another field */
    TURN_MAX_Q21 = 16383,
};

/* To counts or, where these are few, to 1/64 of them. */
static int16_t scaled(const mahony_t *mahony, int32_t component_q14)
{
    const int32_t q8 = mahony->config->mag_times_64 != 0U ? component_q14
                                                          : (component_q14 >> 8) * 4;

    return mahony_limit_i16((q8 + 128) >> 8);
}

static int16_t mean_of_block(int32_t sum)
{
    return (int16_t)((sum * 32 + 128) >> 8); /* an eighth, half up */
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

/* Ends a block: the mean of its level parts, and what that is squared. */
static void take_block(mahony_mag_t *mag)
{
    mag->east      = mean_of_block(mag->east_sum);
    mag->north     = mean_of_block(mag->north_sum);
    mag->east_sum  = 0;
    mag->north_sum = 0;
    mag->level2    = port_square_i16(mag->east) + port_square_i16(mag->north);
}

/* The part along the vertical, of this sample. */
static void take_up(mahony_t *mahony, const int16_t mag_b_counts[3])
{
    int16_t up_b_q14[3];

    mahony_up_b_q14(&mahony->step, up_b_q14);
    mahony->mag.up = scaled(mahony, port_dot(up_b_q14, mag_b_counts));
}

/* Norm and elevation, and whether there is a heading at all. */
static void measure(mahony_t *mahony)
{
    mahony_mag_t *const mag   = &mahony->mag;
    const uint32_t      norm2 = mag->level2 + port_square_i16(mag->up); /* <= 3 2^30 */

    mag->refused = mag->level2 <= norm2 >> 8;
    if (mag->refused) {
        fixed_count(&mahony->counts.mag_refused);
        return;
    }
    const mahony_root_t root   = mahony_root(norm2);
    const uint16_t      length = mahony_length(&root);

    mag->norm    = length > INT16_MAX ? INT16_MAX : (int16_t)length;
    mag->dip_q15 = mahony_limit_i16(2 * (int32_t)mahony_unit_q14(mag->up, &root));
}

static void learn_reference(mahony_t *mahony)
{
    mahony_mag_t *const mag = &mahony->mag;

    if (!is_near(&mag->smooth, &mag->reference)) {
        mag->undisturbed = 0U;
        return;
    }
    fixed_count(&mag->undisturbed);
    follow_field(&mag->reference, (int16_t)(mag->smooth.norm_q16 >> 16),
                 (int16_t)(mag->smooth.dip_q31 >> 16), mahony->config->mag_learn_q16);
}

static void learn_candidate(mahony_t *mahony)
{
    mahony_mag_t *const mag = &mahony->mag;

    if (!is_near(&mag->smooth, &mag->candidate)) {
        mag->accepted  = 0U;
        mag->candidate = mag->smooth;
        return;
    }
    if (is_moving(mahony)) { fixed_count(&mag->accepted); }
    follow_field(&mag->candidate, (int16_t)(mag->smooth.norm_q16 >> 16),
                 (int16_t)(mag->smooth.dip_q31 >> 16), mahony->config->mag_learn_q16);
}

/* Whether the field is not the one that the heading stands on. */
static bool is_disturbed(mahony_t *mahony)
{
    mahony_mag_t *const mag = &mahony->mag;

    if (mag->settling != 0U) {
        --mag->settling;
        return false;
    }
    if (mag->undisturbed >= mahony->config->mag_recover_len) { return false; }
    if (mag->accepted <= mahony->config->mag_accept_len) { return true; }
    mag->reference   = mag->candidate; /* it has held while the board turned: it is the world's */
    mag->undisturbed = mahony->config->mag_recover_len;
    mag->accepted    = 0U;
    return false;
}

/* The heading's gain: none while a disturbance is bridged, half when that takes too long. */
static void decide(mahony_t *mahony)
{
    mahony_mag_t *const mag  = &mahony->mag;
    uint16_t            gain = mahony_raised(mahony, mahony->config->mag_correct_q21);

    if (gain > TURN_MAX_Q21) { gain = TURN_MAX_Q21; }
    if (!is_disturbed(mahony)) {
        mag->rejected = mag->rejected > 2U ? (uint16_t)(mag->rejected - 2U) : 0U;
    } else {
        fixed_count(&mahony->counts.mag_disturbed);
        if (mag->rejected >= mahony->config->mag_reject_len) {
            gain >>= 1;
        } else {
            ++mag->rejected;
            gain = 0U;
        }
    }
    mag->correct_q21 = gain;
}

/* The turn by which the block's mean field corrects the heading: its azimuth's sine or, behind, the
 * most that a sine can be. */
static void take_turn(mahony_mag_t *mag)
{
    mag->turn_q21 = 0;
    if (mag->refused) { return; }
    const mahony_root_t root     = mahony_root(mag->level2);
    int16_t             sine_q14 = mahony_unit_q14(mag->east, &root);

    if (mag->north < 0) { sine_q14 = sine_q14 > 0 ? MAHONY_ONE_Q14 : -MAHONY_ONE_Q14; }
    const int32_t turn_q37 = port_mul_i16(sine_q14, (int16_t)mag->correct_q21) * 4 +
                             mag->turn_res; /* < 2^31 */

    mag->turn_res = (uint16_t)turn_q37;
    mag->turn_q21 = (int16_t)(turn_q37 >> 16);
}

static int32_t part(int16_t component_q14, int16_t turn_q21)
{
    return (port_mul_i16(component_q14, turn_q21) * 8 + 128) >> 8;
}

/* Turn the world about its vertical: quat += k quat turn, k being world z. */
static void turn_heading(mahony_step_t *step, int16_t turn_q21)
{
    const int16_t w = step->quat_q14[0], x = step->quat_q14[1];
    const int16_t y = step->quat_q14[2], z = step->quat_q14[3];

    step->quat_wb_q30[0] += part((int16_t)-z, turn_q21);
    step->quat_wb_q30[1] += part((int16_t)-y, turn_q21);
    step->quat_wb_q30[2] += part(x, turn_q21);
    step->quat_wb_q30[3] += part(w, turn_q21);
}

/* An eighth of the work on a block in each sample of the next one. */
static void work(mahony_t *mahony, const int16_t mag_b_counts[3])
{
    mahony_mag_t *const mag = &mahony->mag;

    switch (mag->phase) {
    case 0: take_block(mag); break;
    case 1: take_up(mahony, mag_b_counts); break;
    case 2: measure(mahony); break;
    case 3:
        if (!mag->refused) {
            follow_field(&mag->smooth, mag->norm, mag->dip_q15, mahony->config->mag_smooth_q16);
        }
        break;
    case 4: learn_reference(mahony); break;
    case 5: learn_candidate(mahony); break;
    case 6:
        decide(mahony);
        take_turn(mag);
        break;
    default: turn_heading(&mahony->step, mag->turn_q21); break;
    }
}

/* Heading and reference from one sample, the first that has them. */
static void start_heading(mahony_t *mahony, const int16_t mag_b_counts[3])
{
    mahony_mag_t *const mag = &mahony->mag;

    mag->level2 = port_square_i16(mag->east) + port_square_i16(mag->north);
    take_up(mahony, mag_b_counts);
    measure(mahony);
    if (mag->refused) { return; }
    const mahony_root_t root        = mahony_root(mag->level2);
    const mahony_half_t half        = mahony_half(mahony_unit_q14(mag->north, &root));
    const int16_t       east_q14    = mahony_unit_q14(mag->east, &root);
    const int16_t       smaller     = mahony_half_sine_q14(east_q14, &half);
    const bool          ahead       = mag->north >= 0;
    const int16_t       left_q14[4] = {ahead ? half.larger_q14 : smaller, 0, 0,
                                 ahead ? smaller : half.larger_q14};

    mahony_turn_world(&mahony->step, left_q14);
    mag->smooth.norm_q16 = mag->norm * INT32_C(65536);
    mag->smooth.dip_q31  = mag->dip_q15 * INT32_C(65536);
    mag->reference       = mag->smooth;
    mag->candidate       = mag->smooth;
    mag->started         = true;
}

void mahony_update_mag(mahony_t *mahony, const int16_t mag_b_counts[3])
{
    mahony_step_t *const step = &mahony->step;
    mahony_mag_t *const  mag  = &mahony->mag;

    if (!mahony->started) { return; }
    const int16_t east  = scaled(mahony, port_dot(step->east_b_q14, mag_b_counts));
    const int16_t north = scaled(mahony, port_dot(step->north_b_q14, mag_b_counts));

    if (!mag->started) {
        mag->east  = east;
        mag->north = north;
        start_heading(mahony, mag_b_counts);
        return;
    }
    if (mag->whole) { work(mahony, mag_b_counts); }
    mag->east_sum += east;
    mag->north_sum += north;
    mag->phase = (uint8_t)((mag->phase + 1U) % MAHONY_MAG_BLOCK);
    if (mag->phase == 0U) { mag->whole = true; }
}
