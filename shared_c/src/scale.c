/* SPDX-License-Identifier: MIT */
#include "scale.h"

#include "fixed.h"
#include "port_hot.h"
#include "port_i16.h"
#include "port_wide.h"
#include "scale_wide.h"

#define TRACK_US 0x20000U /* zero moves once in as long, by e/16 at most */

/* A mass or counts Q7 limited to +-2^30: the upper two bits differ only beyond. */
static int32_t within_2_30(int32_t value)
{
    _Static_assert(SCALE_COUNTS_Q7 == 1L << 30 && SCALE_MASS_MG == 1L << 30, "one limit for both");
    const uint8_t top = (uint8_t)((uint32_t)value >> 24);

    if ((uint8_t)(top + 0x40U) < 0x80U) { return value; }
    return value < 0 ? -SCALE_MASS_MG : SCALE_MASS_MG;
}

static PORT_OUTLINE uint32_t magnitude(int32_t value)
{
    return value < 0 ? 0U - (uint32_t)value : (uint32_t)value;
}

static PORT_OUTLINE uint32_t distance(int32_t a, int32_t b)
{
    return a > b ? (uint32_t)a - (uint32_t)b : (uint32_t)b - (uint32_t)a;
}

static bool reached(int32_t counts_q7, int32_t point, bool falls)
{
    return falls ? counts_q7 <= point : counts_q7 >= point;
}

PORT_OUTLINE int32_t scale_mass(const scale_t *scale, int32_t counts_q7)
{
    const scale_config_t *config = scale->config;
    const int32_t        *points = config->point_counts_q7;
    const bool            falls  = scale->falling;
    uint8_t               at     = 0U;
    uint8_t               last   = (uint8_t)(config->points - 2U);

    counts_q7 = within_2_30(counts_q7);
    while (at != last) { /* the last segment whose point was reached, or the first */
        const uint8_t middle = (uint8_t)((uint8_t)(at + last + 1) >> 1);
        if (reached(counts_q7, points[middle], falls)) {
            at = middle;
        } else {
            last = (uint8_t)(middle - 1U);
        }
    }
    const int32_t  from  = points[at];
    const bool     above = reached(counts_q7, from, falls);
    const uint32_t away  = distance(counts_q7, from);                  /* <= 2^31 */
    const uint32_t risen = port_wide_high(away, scale->slope_q32[at]); /* <= 2^31 */
    /* |mass of a point| < 2^29, and 3 * 2^29 more reach beyond 2^30 on either side */
    const int32_t rise = risen > 0x60000000U ? 0x60000000 : (int32_t)risen;
    const int32_t base = config->point_mass_mg[at];

    return within_2_30(above ? base + rise : base - rise);
}

static void set_zero(scale_t *scale, int32_t mass_mg)
{
    scale->zero_mg     = mass_mg;
    scale->zero_mg_q4  = mass_mg * 16; /* |.| <= 0.12 * 5e8 * 16 < 2^30 */
    scale->tracking_us = 0U;
    scale->flags |= SCALE_ZEROED;
}

/* Where tracking ends: 2 % of Max from the zero that was set first. */
static void set_zero_range(scale_t *scale)
{
    const int32_t centre_mg = scale->zero_initial_mg, range_mg = scale->zero_range_mg;

    scale->zero_low_mg_q4  = (centre_mg - range_mg) * 16;
    scale->zero_high_mg_q4 = (centre_mg + range_mg) * 16;
}

/* The mass has stood within the band for long enough. */
static PORT_OUTLINE void settle(scale_t *scale, int32_t mass_mg)
{
    const scale_config_t *config = scale->config;

    scale->steady = true;
    if (!scale->settled) {
        scale->settled = true;
        if ((config->options & SCALE_INITIAL_ZERO) != 0U && (scale->flags & SCALE_ZEROED) == 0U &&
            magnitude(mass_mg) <= (uint32_t)scale->initial_mg) {
            scale->zero_initial_mg = mass_mg;
            set_zero(scale, mass_mg);
        }
        set_zero_range(scale);
    } else if (distance(mass_mg, scale->settled_mg) > (uint32_t)config->step_mg) {
        scale->step_us      = scale->left_us;
        scale->step_from_mg = scale->settled_mg - scale->zero_mg;
        scale->step_to_mg   = mass_mg - scale->zero_mg;
        scale->flags |= SCALE_STEPPED;
        fixed_count(&scale->steps);
    }
}

static void unsettle(scale_t *scale, uint32_t device_us)
{
    if (scale->steady) { scale->left_us = device_us; }
    scale->steady      = false;
    scale->tracking_us = 0U;
}

/* Whether masses stand. */
static PORT_OUTLINE void watch(scale_t *scale, int32_t mass_mg, uint32_t device_us)
{
    const scale_config_t *config = scale->config;

    if (mass_mg < scale->low_mg) { scale->low_mg = mass_mg; }
    if (mass_mg > scale->high_mg) { scale->high_mg = mass_mg; }
    if (!scale->begun ||
        (uint32_t)scale->high_mg - (uint32_t)scale->low_mg > (uint32_t)config->stable_band_mg) {
        unsettle(scale, device_us);
        scale->low_mg   = mass_mg;
        scale->high_mg  = mass_mg;
        scale->since_us = device_us;
        scale->begun    = true;
    } else if (!scale->steady && device_us - scale->since_us >= config->stable_us) {
        settle(scale, mass_mg);
    }
    if (scale->steady) { scale->settled_mg = mass_mg; }
}

/* Follow a creeping zero, while stable. */
static PORT_OUTLINE void track(scale_t *scale, uint32_t elapsed_us)
{
    const scale_config_t *config = scale->config;
    const int32_t         load   = scale->mass_mg - scale->zero_mg;

    if ((config->options & SCALE_TRACK_ZERO) == 0U ||
        magnitude(load) > (uint32_t)config->interval_mg >> 1) {
        scale->tracking_us = 0U;
        return;
    }
    elapsed_us += scale->tracking_us; /* < 2^17 + 2^31 */
    if (elapsed_us < TRACK_US) {
        scale->tracking_us = elapsed_us;
        return;
    }
    scale->tracking_us = 0U;
    /* A sixteenth of e is e in Q4. */
    const int32_t most_q4 = config->interval_mg, sixteenth = most_q4 >> 4;
    int32_t       zero_q4 = scale->zero_mg_q4;
    zero_q4 += load > sixteenth ? most_q4 : load < -sixteenth ? -most_q4 : load * 16;
    if (zero_q4 < scale->zero_low_mg_q4) { zero_q4 = scale->zero_low_mg_q4; }
    if (zero_q4 > scale->zero_high_mg_q4) { zero_q4 = scale->zero_high_mg_q4; }
    scale->zero_mg_q4 = zero_q4;
    scale->zero_mg    = (zero_q4 + 8) >> 4;
}

/* What is shown, in divisions: held against flicker. */
static PORT_OUTLINE void display(scale_t *scale, int32_t mass_mg)
{
    uint32_t size = magnitude(mass_mg); /* <= 2^31 */
    if (scale->fine) { size = size > 0x7FFFFFU ? 0x7FFFFF00U : size << 8; }
    const int32_t there_q8 = (int32_t)port_wide_high(size, scale->per_division);
    const int32_t exact_q8 = mass_mg < 0 ? -there_q8 : there_q8;

    /* Further off than most_q8 on either side, by one comparison modulo 2^32: both are below 2^31 -
     * 127, so that no true distance comes round to most_q8. */
    const uint16_t most_q8 = 128U + scale->config->hysteresis_q8; /* <= 255 */
    const uint32_t off_q8  = (uint32_t)exact_q8 - ((uint32_t)scale->divisions << 8);
    if (off_q8 + most_q8 > (uint32_t)most_q8 * 2U) { scale->divisions = (exact_q8 + 128) >> 8; }
}

/* The limits, and how near to zero; gives flags. */
static PORT_OUTLINE uint8_t judge(const scale_t *scale, int32_t load)
{
    const scale_config_t *config = scale->config;

    if (load > scale->over_mg) { return SCALE_OVER; }
    if (load < -config->under_mg) { return SCALE_UNDER; }
    const uint8_t stable = scale->steady ? SCALE_STABLE : 0U;
    const bool    zero   = magnitude(load) <= (uint32_t)config->interval_mg >> 2;
    return zero ? stable | SCALE_AT_ZERO : stable;
}

PORT_OUTLINE uint8_t scale_update(scale_t *scale, int32_t counts_q7, uint32_t device_us)
{
    const uint32_t elapsed_us = device_us - scale->last_us;

    if (elapsed_us > scale->config->gap_us) { scale_interrupt(scale); }
    scale->last_us        = device_us;
    const int32_t mass_mg = scale_mass(scale, counts_q7);
    const bool    steady  = scale->steady;
    scale->mass_mg        = mass_mg;
    scale->flags &= (uint8_t)(SCALE_ZEROED | SCALE_TARED | SCALE_FROZEN);
    watch(scale, mass_mg, device_us);
    if (steady && scale->steady) { track(scale, elapsed_us); }

    const int32_t load = mass_mg - scale->zero_mg; /* |.| <= 2^30 + 2^26 */
    const int32_t net  = load - scale->tare_mg;    /* and 2^29 more */
    scale->load_mg     = load;
    scale->net_mg      = net;
    if (net > scale->peak_mg) { scale->peak_mg = net; }
    scale->flags |= judge(scale, load);
    display(scale, scale->show == SCALE_SHOW_LIVE   ? net
                   : scale->show == SCALE_SHOW_HELD ? scale->held_mg
                                                    : scale->peak_mg);
    return scale->flags;
}

void scale_interrupt(scale_t *scale)
{
    unsettle(scale, scale->last_us);
    scale->begun = false;
    scale->flags &= (uint8_t)~SCALE_STABLE;
}

void scale_resume(scale_t *scale, int32_t zero_mg, int32_t tare_mg, bool firm)
{
    if (magnitude(zero_mg) <= (uint32_t)(scale->initial_mg + scale->zero_range_mg)) {
        scale->zero_initial_mg = zero_mg;
        set_zero(scale, zero_mg);
    }
    scale->flags = firm ? SCALE_ZEROED : 0U;
    if (tare_mg > 0 && tare_mg <= scale->config->max_mg) {
        scale->tare_mg = tare_mg;
        scale->flags |= SCALE_TARED;
    }
}

scale_status_t scale_zero(scale_t *scale)
{
    const int32_t off = scale->mass_mg - scale->zero_initial_mg;

    if ((scale->flags & SCALE_STABLE) == 0U) { return SCALE_NOT_STABLE; }
    if (magnitude(off) > (uint32_t)scale->zero_range_mg) { return SCALE_OUT_OF_RANGE; }
    set_zero(scale, scale->mass_mg);
    return SCALE_OK;
}

scale_status_t scale_tare(scale_t *scale)
{
    if ((scale->flags & SCALE_STABLE) == 0U) { return SCALE_NOT_STABLE; }
    if (scale->load_mg <= 0 || scale->load_mg > scale->config->max_mg) {
        return SCALE_OUT_OF_RANGE;
    }
    scale->tare_mg = scale->load_mg;
    scale->flags |= SCALE_TARED;
    return SCALE_OK;
}

void scale_tare_clear(scale_t *scale)
{
    scale->tare_mg = 0;
    scale->flags &= (uint8_t)~SCALE_TARED;
}

scale_status_t scale_show(scale_t *scale, scale_show_t show)
{
    if (show > SCALE_SHOW_PEAK) { return SCALE_UNKNOWN; }
    scale->show    = (uint8_t)show;
    scale->held_mg = scale->net_mg;
    if (show == SCALE_SHOW_PEAK) { scale->peak_mg = scale->net_mg; }
    scale->flags &= (uint8_t)~SCALE_FROZEN;
    if (show != SCALE_SHOW_LIVE) { scale->flags |= SCALE_FROZEN; }
    return SCALE_OK;
}

scale_status_t scale_count_out(scale_t *scale, uint16_t pieces)
{
    const int32_t e = scale->config->interval_mg; /* <= 2^25 */

    if (pieces == 0U) { return SCALE_UNKNOWN; }
    if ((scale->flags & SCALE_STABLE) == 0U) { return SCALE_NOT_STABLE; }
    if ((scale->net_mg >> 2) < e + e * 4 || (scale->net_mg >> 1) < (int32_t)pieces) {
        return SCALE_TOO_LIGHT;
    }
    scale->per_piece_q32 = scale_wide_ratio(pieces, (uint32_t)scale->net_mg);
    return SCALE_OK;
}

int32_t scale_pieces(const scale_t *scale)
{
    const int32_t pieces = (int32_t)port_wide_high(magnitude(scale->net_mg),
                                                   scale->per_piece_q32); /* <= 2^30 */

    return scale->net_mg < 0 ? -pieces : pieces;
}

int32_t scale_shown(const scale_t *scale)
{
    const int32_t divisions = scale->divisions; /* < 2^23 */

    return scale->config->digit == 1U   ? divisions
           : scale->config->digit == 2U ? divisions * 2
                                        : divisions * 4 + divisions;
}
