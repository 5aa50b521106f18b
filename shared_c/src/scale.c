/* SPDX-License-Identifier: MIT */
#include "scale.h"

#include "fixed.h"
#include "port_curve.h"
#include "port_wide.h"
#include "scale_wide.h"

enum { AHEAD_MAX = 4095 }; /* in grains: a quarter of it, leapt in the mean, outreaches it */

#define TRACK_US 0x40000U /* zero moves once in as long, by e/8 at most */

/* Called from many places, or measured: kept whole. */
#define OUTLINE __attribute__((noinline))

/* 0 <= bound <= 2^30: one comparison modulo 2^32. */
static OUTLINE bool within(int32_t value, int32_t bound)
{
    return (uint32_t)value + (uint32_t)bound <= (uint32_t)bound * 2U;
}

static OUTLINE int32_t limited(int32_t value, int32_t bound)
{
    if (value > bound) { return bound; }
    return value < -bound ? -bound : value;
}

static uint32_t magnitude(int32_t value)
{
    return value < 0 ? 0U - (uint32_t)value : (uint32_t)value;
}

int32_t scale_mass(const scale_t *scale, int32_t counts_q7)
{
    return port_curve(scale, counts_q7);
}

static int32_t load_of(const scale_t *scale)
{
    return scale->mass_mg - scale->zero_mg; /* |.| <= 2^30 + 2^26 */
}

static void set_zero(scale_t *scale)
{
    scale->zero_mg = scale->mass_mg;
    scale->flags |= SCALE_ZEROED;
}

/* The mass has stood within the band for long enough. */
static void settle(scale_t *scale)
{
    scale->steady   = true;
    scale->since_us = scale->last_us;
    if (!scale->settled) {
        scale->settled = true;
        if ((scale->config->options & SCALE_INITIAL_ZERO) != 0U &&
            (scale->flags & SCALE_ZEROED) == 0U &&
            within(scale->mass_mg, scale->zero_range_mg * 5)) {
            scale->zero_initial_mg = scale->mass_mg;
            set_zero(scale);
        }
    } else if (!within(scale->mass_mg - scale->settled_mg, scale->config->step_mg)) {
        scale->step_from_mg = scale->settled_mg - scale->zero_mg;
        scale->step_to_mg   = load_of(scale);
        scale->flags |= SCALE_STEPPED;
        fixed_count(&scale->steps);
    }
    scale->settled_mg = scale->mass_mg;
}

static OUTLINE void unsettle(scale_t *scale)
{
    if (scale->steady) { scale->step_us = scale->last_us; }
    scale->steady = false;
    scale->begun  = false;
}

/* Follow a creeping zero, while stable. */
static void track(scale_t *scale)
{
    const scale_config_t *config = scale->config;
    const int32_t         load   = load_of(scale);

    if ((config->options & SCALE_TRACK_ZERO) != 0U && within(load, config->interval_mg >> 1)) {
        if (scale->last_us - scale->since_us < TRACK_US) { return; }
        const int32_t zero_mg = scale->zero_mg + limited(load, config->interval_mg >> 3);
        if (within(zero_mg - scale->zero_initial_mg, scale->zero_range_mg)) {
            scale->zero_mg = zero_mg;
        }
    }
    scale->since_us = scale->last_us;
}

/* Whether masses stand. */
static OUTLINE void watch(scale_t *scale)
{
    const scale_config_t *config  = scale->config;
    const int32_t         mass_mg = scale->mass_mg;
    const uint32_t        stood   = scale->last_us - scale->since_us;
    int32_t               band    = config->stable_band_mg;

    if (scale->steady) {
        band += band >> 1;
    } else if (stood < config->stable_us >> 2) {
        band >>= 1;
    }
    if (mass_mg < scale->low_mg) { scale->low_mg = mass_mg; }
    if (mass_mg > scale->high_mg) { scale->high_mg = mass_mg; }
    if (!scale->begun || scale->high_mg - scale->low_mg > band) {
        unsettle(scale);
        scale->low_mg   = mass_mg;
        scale->high_mg  = mass_mg;
        scale->begun    = true;
        scale->since_us = scale->last_us;
    } else if (scale->steady) {
        track(scale);
    } else if (stood >= config->stable_us) {
        settle(scale);
    }
}

/* What is shown, in divisions: held against flicker. */
static void display(scale_t *scale)
{
    const int32_t mass_mg = scale->kept_mg;
    uint32_t      size    = magnitude(mass_mg); /* <= 2^31 */

    if (scale->fine) { size = size > 0x7FFFFFU ? 0x7FFFFF00U : size << 8; }
    int32_t exact_q8 = (int32_t)port_wide_high(size, scale->per_division);
    if (mass_mg < 0) { exact_q8 = -exact_q8; }

    /* Both are below 2^31 - 127, so that no true distance comes round modulo 2^32. */
    const uint32_t off_q8 = (uint32_t)exact_q8 - ((uint32_t)scale->divisions << 8);
    if (!within((int32_t)off_q8, 128 + (int32_t)scale->config->hysteresis_q8)) {
        scale->divisions = (exact_q8 + 128) >> 8;
    }
}

/* The limits, and how near to zero; gives flags. */
static uint8_t judge(const scale_t *scale, int32_t load)
{
    const scale_config_t *config = scale->config;
    const int32_t         e      = config->interval_mg;

    if (load - config->max_mg - e > e * 8) { return SCALE_OVER; }
    if (load < -config->under_mg) { return SCALE_UNDER; }
    const uint8_t stable = scale->steady ? SCALE_STABLE : 0U;
    return within(load, e >> 2) ? stable | SCALE_AT_ZERO : stable;
}

OUTLINE uint8_t scale_update(scale_t *scale, int32_t counts_q7, uint32_t device_us)
{
    if (device_us - scale->last_us > scale->config->gap_us) { scale_interrupt(scale); }
    scale->last_us = device_us;
    if (scale->steady) { scale->settled_mg = scale->mass_mg; }
    scale->mass_mg = scale_mass(scale, counts_q7);
    scale->flags &= (uint8_t)(SCALE_ZEROED | SCALE_TARED | SCALE_FROZEN);
    watch(scale);

    const int32_t load = load_of(scale);
    const int32_t net  = load - scale->tare_mg; /* 2^29 more */
    scale->net_mg      = net;
    if (scale->show == SCALE_SHOW_LIVE ||
        (scale->show == SCALE_SHOW_PEAK && net > scale->kept_mg)) {
        scale->kept_mg = net;
    }
    scale->flags |= judge(scale, load);
    display(scale);
    return scale->flags;
}

/* How far the measurement is ahead of a mass, in grains. */
static OUTLINE int16_t ahead(const scale_t *scale, int32_t mass_mg)
{
    int32_t apart = scale->raw_mg - mass_mg; /* |.| < 2^31 */

    for (uint8_t bits = scale->grain; bits != 0U; --bits) { apart >>= 1; }
    return (int16_t)limited(apart, AHEAD_MAX);
}

void scale_look(scale_t *scale, int32_t raw_mass_mg)
{
    const int16_t band     = scale->band; /* <= 255 */
    const int16_t rough_q2 = (int16_t)(scale->rough_q4 >> 2);
    const int16_t rough    = (int16_t)(rough_q2 >> 2); /* <= 4095 */
    const int16_t wide     = rough > band ? rough : band;
    int16_t       reach    = (int16_t)(band - (band >> 2));
    int16_t       leap     = ahead(scale, raw_mass_mg);
    int16_t       most     = (int16_t)(rough + (rough >> 1) + 4);

    scale->raw_mg = raw_mass_mg;
    if (leap < 0) { leap = (int16_t)-leap; }
    if (leap > most) { leap = most; }
    scale->rough_q4 = (uint16_t)(scale->rough_q4 + (uint16_t)(leap - rough));

    int16_t off = ahead(scale, scale->mass_mg);
    if (off > wide) { off = wide; }
    if (off < -wide) { off = (int16_t)-wide; }
    off = (int16_t)(scale->lag_q3 - (scale->lag_q3 >> 3) + off); /* |.| <= 8 wide < 2^15 */
    scale->lag_q3 = off;
    if (off < 0) { off = (int16_t)-off; }

    if (reach < rough_q2) { reach = rough_q2; }
    reach = (int16_t)(reach + band); /* <= 2^14 + 254 */
    if (ahead(scale, scale->low_mg) > reach || ahead(scale, scale->high_mg) < -reach ||
        (off > wide * 4 &&
         (scale->steady || scale->last_us - scale->since_us >= scale->config->stable_us >> 2))) {
        unsettle(scale);
    }
}

void scale_interrupt(scale_t *scale)
{
    unsettle(scale);
    scale->flags &= (uint8_t)~SCALE_STABLE;
}

static OUTLINE scale_status_t take_tare(scale_t *scale, int32_t tare_mg)
{
    if (tare_mg <= 0 || tare_mg > scale->config->max_mg) { return SCALE_OUT_OF_RANGE; }
    scale->tare_mg = tare_mg;
    scale->flags |= SCALE_TARED;
    return SCALE_OK;
}

void scale_resume(scale_t *scale, int32_t zero_mg, int32_t tare_mg, bool firm)
{
    if (within(zero_mg, scale->zero_range_mg * 6)) {
        scale->zero_initial_mg = zero_mg;
        scale->zero_mg         = zero_mg;
    }
    scale->flags = firm ? SCALE_ZEROED : 0U;
    (void)take_tare(scale, tare_mg);
}

scale_status_t scale_zero(scale_t *scale)
{
    if ((scale->flags & SCALE_STABLE) == 0U) { return SCALE_NOT_STABLE; }
    if (!within(scale->mass_mg - scale->zero_initial_mg, scale->zero_range_mg)) {
        return SCALE_OUT_OF_RANGE;
    }
    set_zero(scale);
    return SCALE_OK;
}

scale_status_t scale_tare(scale_t *scale)
{
    if ((scale->flags & SCALE_STABLE) == 0U) { return SCALE_NOT_STABLE; }
    return take_tare(scale, load_of(scale));
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
    scale->kept_mg = scale->net_mg;
    scale->flags &= (uint8_t)~SCALE_FROZEN;
    if (show != SCALE_SHOW_LIVE) { scale->flags |= SCALE_FROZEN; }
    return SCALE_OK;
}

scale_status_t scale_count_out(scale_t *scale, uint16_t pieces)
{
    const int32_t e = scale->config->interval_mg, net = scale->net_mg; /* e <= 2^25 */

    if (pieces == 0U) { return SCALE_UNKNOWN; }
    if ((scale->flags & SCALE_STABLE) == 0U) { return SCALE_NOT_STABLE; }
    if (net < e * 20 || (net >> 1) < (int32_t)pieces) { return SCALE_TOO_LIGHT; }
    scale->per_piece_q32 = scale_wide_ratio(pieces, (uint32_t)net);
    return SCALE_OK;
}

int32_t scale_pieces(const scale_t *scale)
{
    const int32_t net    = scale->net_mg;
    const int32_t pieces = (int32_t)port_wide_high(magnitude(net),
                                                   scale->per_piece_q32); /* <= 2^30 */

    return net < 0 ? -pieces : pieces;
}

int32_t scale_shown(const scale_t *scale)
{
    return (int32_t)((uint32_t)scale->divisions * scale->config->digit); /* |divisions| < 2^23 */
}
