/* SPDX-License-Identifier: MIT */
#include "scale.h"

#include "fixed.h"
#include "port_curve.h"
#include "port_watch.h"
#include "port_wide.h"

enum { INITIAL_FIFTIETHS = 5 }; /* of Max, on either side */

#define FINE_MAX_MG 0x7FFFFFL /* what a fine d is shown up to */
#define TRACK_US    0x40000U  /* zero moves once in as long, by e/8 at most */

/* Called from many places, or measured: kept whole. */
#define OUTLINE __attribute__((noinline))

/* 0 <= bound <= 2^30: one comparison modulo 2^32. */
static OUTLINE bool within(int32_t value, int32_t bound)
{
    return (uint32_t)value + (uint32_t)bound <= (uint32_t)bound * 2U;
}

int32_t scale_mass(const scale_t *scale, int32_t counts_q7)
{
    return port_curve(scale, counts_q7);
}

static int32_t load_of(const scale_t *scale)
{
    return scale->mass_mg - scale->zero_mg; /* |.| <= 2^30 + 2^26 */
}

/* Whether that is within so many fiftieths of Max. */
static bool reaches(const scale_t *scale, int32_t away_mg, uint8_t fiftieths)
{
    return within(away_mg, scale->zero_range_mg * fiftieths);
}

static void set_zero(scale_t *scale)
{
    scale->zero_mg = scale->mass_mg;
    scale->flags |= SCALE_ZEROED;
}

/* The mass has stood within the band for long enough. */
static void settle(scale_t *scale)
{
    const int32_t mass_mg = scale->mass_mg, settled_mg = scale->settled_mg;

    scale->steady     = true;
    scale->settled_mg = mass_mg;
    if (!scale->settled) {
        scale->settled = true;
        if ((scale->config->options & SCALE_INITIAL_ZERO) != 0U &&
            (scale->flags & SCALE_ZEROED) == 0U && reaches(scale, mass_mg, INITIAL_FIFTIETHS)) {
            scale->zero_initial_mg = mass_mg;
            set_zero(scale);
        }
    } else if (!within(mass_mg - settled_mg, scale->config->step_mg)) {
        scale->step_from_mg = settled_mg - scale->zero_mg;
        scale->step_to_mg   = load_of(scale);
        scale->flags |= SCALE_STEPPED;
        fixed_count(&scale->steps);
    }
}

void scale_interrupt(scale_t *scale)
{
    if (scale->steady) {
        scale->step_us    = scale->last_us;
        scale->settled_mg = scale->mass_mg;
    }
    scale->steady = false;
    scale->begun  = false;
    scale->flags &= (uint8_t)~SCALE_STABLE;
}

/* Follow a creeping zero, while stable. */
static void track(scale_t *scale)
{
    const int32_t e = scale->config->interval_mg, load = load_of(scale);
    int32_t       moved_mg = load;

    if (!within(load, e >> 1) || (scale->config->options & SCALE_TRACK_ZERO) == 0U) { return; }
    if (!within(load, e >> 3)) { moved_mg = load < 0 ? -(e >> 3) : e >> 3; }
    moved_mg += scale->zero_mg;
    if (within(moved_mg - scale->zero_initial_mg, scale->zero_range_mg)) {
        scale->zero_mg = moved_mg;
    }
}

/* What follows from the mass: stability, zero, limits. */
static uint8_t conclude(scale_t *scale)
{
    const scale_config_t *config   = scale->config;
    const uint32_t        stood_us = scale->last_us - scale->since_us;
    uint8_t               flags    = 0U;

    if (stood_us >= (scale->steady ? TRACK_US : config->stable_us)) {
        if (scale->steady) { /* not by a pointer: the worst stack could not be known */
            track(scale);
        } else {
            settle(scale);
        }
        scale->since_us = scale->last_us;
    }
    const int32_t load = load_of(scale), net = load - scale->tare_mg; /* 2^29 more */
    const int32_t e = config->interval_mg, past = load - config->max_mg;
    scale->net_mg = net;
    if (scale->show == SCALE_SHOW_PEAK && net > scale->kept_mg) { scale->kept_mg = net; }

    if (past > e * 9) { /* e <= 2^25 */
        flags = SCALE_OVER;
    } else if (load + config->under_mg < 0) {
        flags = SCALE_UNDER;
    } else {
        if (scale->steady) { flags = SCALE_STABLE; }
        if (within(load, e >> 2)) { flags |= SCALE_AT_ZERO; }
    }
    return scale->flags |= flags;
}

OUTLINE uint8_t scale_update(scale_t *scale, int32_t counts_q7, int32_t raw_q7, uint32_t device_us)
{
    if (device_us - scale->last_us > scale->config->gap_us) { scale->begun = false; }
    scale->last_us = device_us;
    if (!port_watch(scale, counts_q7, raw_q7,
                    device_us - scale->since_us < scale->config->stable_us >> 2)) {
        scale_interrupt(scale); /* as of the mass before */
        scale->begun     = true;
        scale->since_us  = scale->last_us;
        scale->anchor_q7 = counts_q7;
    }
    scale->flags &= (uint8_t)(SCALE_ZEROED | SCALE_TARED | SCALE_FROZEN);
    scale->mass_mg = scale_mass(scale, counts_q7);
    return conclude(scale);
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
    if (reaches(scale, zero_mg, INITIAL_FIFTIETHS + 1U)) {
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
    scale->per_piece_q32 = port_wide_ratio(pieces, (uint32_t)net);
    return SCALE_OK;
}

int32_t scale_pieces(const scale_t *scale)
{
    return port_wide_share(scale->net_mg, scale->per_piece_q32); /* |.| <= 2^30 */
}

/* Held against flicker. */
int32_t scale_shown(scale_t *scale)
{
    int32_t mass_mg = scale->show == SCALE_SHOW_LIVE ? scale->net_mg : scale->kept_mg;

    if (scale->fine) {
        if (!within(mass_mg, FINE_MAX_MG)) { mass_mg = mass_mg < 0 ? -FINE_MAX_MG : FINE_MAX_MG; }
        mass_mg *= 256;
    }
    const int32_t exact_q8 = port_wide_share(mass_mg, scale->per_division);

    /* Both are below 2^31 - 127, so that no true distance comes round modulo 2^32. */
    const uint32_t off_q8 = (uint32_t)exact_q8 - ((uint32_t)scale->divisions << 8);
    if (!within((int32_t)off_q8, 128 + (int32_t)scale->config->hysteresis_q8)) {
        scale->divisions = (exact_q8 + 128) >> 8;
    }
    return (int32_t)((uint32_t)scale->divisions * scale->config->digit); /* |divisions| < 2^23 */
}
