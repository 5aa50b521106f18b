/* SPDX-License-Identifier: MIT */
/* mahony_mag - heading from the field, and when not to believe it (after VQF, sec. 3.5). */
#include "mahony_internal.h"
#include "port_dot.h"
#include "port_reach.h"
#include "port_root.h"

enum {
    PART_MAX  = 23170, /* 2^15 / sqrt 2 */
    OFF_SHIFT = 3,     /* an eighth of the reference off is another field */
};

static PORT_OUTLINE int16_t limited(int32_t part_q9)
{
    const int32_t part_q1 = part_q9 >> 8;

    if (part_q1 > PART_MAX) { return PART_MAX; }
    return part_q1 < -PART_MAX ? -PART_MAX : (int16_t)part_q1;
}

static PORT_OUTLINE uint16_t size_of(int16_t value)
{
    return (uint16_t)(value < 0 ? -value : value);
}

static PORT_OUTLINE int32_t product(int16_t a, int16_t b)
{
    return (int32_t)a * b;
}

/* The field's upward part, of this sample; the level one is averaged. */
static void take_up(const mahony_t *mahony, mahony_mag_t *mag, const int16_t mag_b_counts[3])
{
    int16_t up_b_q14[3];

    mahony_up(mahony, up_b_q14);
    mag->now[1] = limited((port_dot(up_b_q14, mag_b_counts) >> 8) * 8) >> 1;
}

/* Ends a block: the mean of its level parts, and whether there is a heading at all. */
static void take_block(mahony_t *mahony, mahony_mag_t *mag)
{
    uint32_t square = 0U;

    for (uint8_t i = 0U; i < 2U; ++i) {
        const int16_t mean_q1 = limited(mag->sum_q6[i]);

        mag->mean_q1[i] = mean_q1;
        mag->sum_q6[i]  = 0;
        square += (uint32_t)((int32_t)mean_q1 * mean_q1);
    }
    uint16_t level_q1 = port_root(square);

    mag->now[0] = (int16_t)(level_q1 >> 1);
    if (level_q1 <= size_of(mag->now[1]) >> 3) { /* a sixteenth of the upward part */
        level_q1 = 0U;
        fixed_count(&mahony->counts.mag_refused);
    }
    mag->level_q1 = level_q1;
}

/* Whether the field is about this one, which then follows it: a low-pass with 16 bits more in its
 * state than in its input. Parts lie within 2^14, so that differences fit. */
static PORT_OUTLINE bool agrees(const mahony_t *mahony, mahony_field_t *field)
{
    uint16_t off = 0U, size = 0U;
    int16_t  difference[2];

    for (uint8_t i = 0U; i < 2U; ++i) {
        const int16_t part = (int16_t)(field->part_q16[i] >> 16);

        difference[i] = (int16_t)(mahony->mag.now[i] - part);
        off           = (uint16_t)(off + size_of(difference[i]));
        size          = (uint16_t)(size + size_of(part));
    }
    if (off >= size >> OFF_SHIFT) { return false; }
    for (uint8_t i = 0U; i < 2U; ++i) {
        field->part_q16[i] += product(difference[i], (int16_t)mahony->config->mag_learn_q16);
    }
    return true;
}

static bool is_moving(const mahony_t *mahony)
{
    for (uint8_t i = 0U; i < 3U; ++i) {
        if (size_of(mahony->step.rate_b[i]) > mahony->config->moving_min) { return true; }
    }
    return false;
}

static void judge_reference(mahony_t *mahony, mahony_mag_t *mag)
{
    if (!agrees(mahony, &mag->reference)) { mag->undisturbed = 0U; }
    fixed_count(&mag->undisturbed);
}

static void judge_candidate(mahony_t *mahony, mahony_mag_t *mag)
{
    if (!agrees(mahony, &mag->candidate)) {
        mag->accepted = 0U;
        for (uint8_t i = 0U; i < 2U; ++i) {
            mag->candidate.part_q16[i] = (int32_t)((uint32_t)mag->now[i] << 16);
        }
    } else if (is_moving(mahony)) {
        fixed_count(&mag->accepted);
    }
}

/* Whether the field is not the one that the heading stands on. */
static bool is_disturbed(const mahony_t *mahony, mahony_mag_t *mag)
{
    if (mag->undisturbed > mahony->config->mag_recover_len) { return false; }
    if (mag->accepted <= mahony->config->mag_accept_len && mag->raised_q21 != 0U) { return true; }
    mag->reference   = mag->candidate; /* the first, or it has held while the board turned */
    mag->undisturbed = UINT16_MAX;
    mag->accepted    = 0U;
    return false;
}

/* The heading's gain, high at first: none while a disturbance is bridged, half when that takes too
 * long. */
static void decide(mahony_t *mahony, mahony_mag_t *mag)
{
    const bool disturbed = is_disturbed(mahony, mag);
    uint16_t   gain      = (uint16_t)(mag->raised_q21 - (mag->raised_q21 >> 8) - 1U);

    if (gain > MAHONY_MAG_CORRECT_MAX) { gain = MAHONY_MAG_CORRECT_MAX; } /* at first 65535 */
    if (gain < mahony->config->mag_correct_q21) { gain = mahony->config->mag_correct_q21; }
    mag->raised_q21 = gain;
    if (!disturbed) {
        if (mag->rejected != 0U) { --mag->rejected; }
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

/* The azimuth's sine or, behind, the most that a sine can be, in the mean's place. */
static void take_sine(mahony_mag_t *mag)
{
    const uint16_t part     = mag->mean_q1[1] < 0 ? mag->level_q1 : size_of(mag->mean_q1[0]);
    const int16_t  sine_q14 = (int16_t)(port_ratio_q15(part, mag->level_q1) >> 1);

    mag->mean_q1[0] = mag->mean_q1[0] < 0 ? (int16_t)-sine_q14 : sine_q14;
}

/* Turn the world about its vertical by that: quat += k quat turn, k being world z. */
static void turn_heading(mahony_t *mahony, mahony_mag_t *mag)
{
    mahony_step_t *const step     = &mahony->step;
    const int32_t        turn_q37 = product(mag->mean_q1[0], (int16_t)mag->correct_q21) * 4 +
                             mag->turn_res; /* < 2^30 */
    const int16_t turn_q21 = (int16_t)(turn_q37 >> 16);

    mag->turn_res = (uint16_t)turn_q37;
    for (uint8_t i = 0U; i < 4U; ++i) {
        const int32_t part_q35 = product(step->quat_q14[3U - i], turn_q21);
        const int32_t part_q30 = ((part_q35 + 128) >> 8) * 8;

        step->quat_wb_q30[i] += i < 2U ? -part_q30 : part_q30;
    }
}

/* A part of the work on the block before. */
static void work(mahony_t *mahony, mahony_mag_t *mag)
{
    const uint8_t phase = mag->phase;

    if (phase == 0U) { take_block(mahony, mag); }
    if (mag->level_q1 == 0U) { return; }
    if (phase == 1U) {
        judge_reference(mahony, mag);
        take_sine(mag);
    }
    if (phase == 2U) {
        judge_candidate(mahony, mag);
        decide(mahony, mag);
    }
    if (phase > 3U) { turn_heading(mahony, mag); }
}

void mahony_update_mag(mahony_t *mahony, const int16_t mag_b_counts[3])
{
    mahony_mag_t *const mag = PORT_REACH(&mahony->mag);

    if (mahony_is_starting(mahony)) { mag->raised_q21 = 0U; } /* no vertical yet: no reference */
    if (mag->whole) { work(mahony, mag); }
    mag->sum_q6[0] += port_dot(mahony->step.east_b_q14, mag_b_counts) >> 8;
    mag->sum_q6[1] += port_dot(mahony->step.north_b_q14, mag_b_counts) >> 8;
    mag->phase = (uint8_t)((mag->phase + 1U) % MAHONY_MAG_BLOCK);
    if (mag->phase == 4U) { take_up(mahony, mag, mag_b_counts); }
    if (mag->phase == 0U) { mag->whole = true; }
}
