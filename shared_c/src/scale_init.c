/* SPDX-License-Identifier: MIT */
#include "scale.h"

#include <stddef.h>

#include "port_outline.h"
#include "port_rom.h"
#include "port_wide.h"
#include "scale_units.h"

/* One more than 2^32 / 50: the product's upper half is Max / 50 to the nearest. */
#define FIFTIETH_Q32 85899346UL

enum { Q_FINE = 64, FINE_BITS = 23, GRAIN_ONE = 23 };

/* The first fields of a configuration in order, each with its least value, and its greatest as a
 * share, by a shift, of Max, of e or of 2^31. */
enum { MAX, INTERVAL, UNDER, STEP, BAND, STABLE, GAP, FIELDS, OF_2_31 = FIELDS };

static const uint8_t ranges[FIELDS][3] PORT_ROM = {
    {1U, OF_2_31, 2U},  {1U, MAX, 4U},     {0U, MAX, 0U},     {0U, MAX, 0U},
    {0U, INTERVAL, 1U}, {1U, OF_2_31, 0U}, {1U, OF_2_31, 0U},
};

_Static_assert(SCALE_MAX_MG == 0x80000000L >> 2, "the range of Max");
_Static_assert(offsetof(scale_config_t, gap_us) == 4U * GAP &&
                   offsetof(scale_config_t, stable_band_mg) == 4U * BAND,
               "the fields' order");

static scale_status_t check_ranges(const scale_config_t *config)
{
    const uint32_t *fields = (const uint32_t *)config;

    for (uint8_t at = 0U; at < FIELDS; ++at) {
        const uint8_t *range = ranges[at];
        const uint8_t  of    = port_rom_u8(&range[1]);
        uint32_t       most  = of == OF_2_31 ? 0x80000000U : fields[of];
        for (uint8_t bits = port_rom_u8(&range[2]); bits != 0U; --bits) { most >>= 1; }
        if (fields[at] < port_rom_u8(&range[0]) || fields[at] > most) {
            return at < STABLE ? SCALE_BAD_RANGE : SCALE_BAD_TIME;
        }
    }
    return SCALE_OK;
}

/* The band as grains of counts Q7, 127..254 of them, or single counts Q7 where it has fewer; one
 * less than it has, as distances are cut off to whole grains. */
static void take_band(scale_t *scale, uint32_t steepest_q32)
{
    uint32_t band  = (uint32_t)scale->config->stable_band_mg; /* <= 2^24 */
    uint32_t slope = steepest_q32 >> 1;                       /* 1..2^31 - 1 */
    uint8_t  grain = GRAIN_ONE;

    for (; band >= slope; slope <<= 1) { ++grain; }
    for (; grain != 0U && band << 1 < slope; band <<= 1) { --grain; }
    band = port_wide_ratio(band, slope) >> 24;
    if (grain != 0U) { --band; }
    scale->band  = (uint8_t)band;
    scale->grain = grain;
}

/* The calibration's points. Slopes are written only where they are lawful throughout. */
static PORT_OUTLINE scale_status_t take_points(const scale_config_t *config, scale_t *scale)
{
    bool     falls        = false;
    uint32_t steepest_q32 = 0U;

    if (config->points < 2U || config->points > SCALE_POINTS_MAX) { return SCALE_BAD_COUNT; }
    for (uint8_t at = 0U; at < config->points; ++at) {
        const int32_t counts_q7 = config->point_counts_q7[at], mass_mg = config->point_mass_mg[at];
        if (counts_q7 < -SCALE_31_BITS || counts_q7 >= SCALE_31_BITS || mass_mg < -SCALE_MAX_MG ||
            mass_mg > SCALE_MAX_MG) {
            return SCALE_BAD_POINT;
        }
        if (at == 0U) { continue; }
        int32_t       run  = counts_q7 - config->point_counts_q7[at - 1U]; /* |.| < 2^31 */
        const int32_t rise = mass_mg - config->point_mass_mg[at - 1U];
        if (at == 1U) { falls = run < 0; }
        if (falls) { run = -run; }
        if (run <= 0 || rise <= 0) { return SCALE_NOT_MONOTONE; }
        if (rise >= run) { return SCALE_TOO_STEEP; }
        if (scale != NULL) {
            const uint32_t slope_q32  = port_wide_ratio((uint32_t)rise, (uint32_t)run);
            scale->slope_q32[at - 1U] = slope_q32;
            if (slope_q32 > steepest_q32) { steepest_q32 = slope_q32; }
        }
    }
    if (scale != NULL) {
        scale->falling = falls;
        take_band(scale, steepest_q32);
    }
    return SCALE_OK;
}

/* 1/d in 1/mg, in Q40, or in Q32 where d is fine; 0 where the configuration allows none. */
static uint32_t divide_display(const scale_config_t *config, bool *fine)
{
    const uint8_t digit  = config->digit;
    const uint8_t parts  = digit == 1U ? 10U : digit == 2U ? 5U : digit == 5U ? 2U : 0U;
    uint32_t      factor = parts;

    if (config->unit >= SCALE_UNIT_COUNT || config->decimals > SCALE_DECIMALS_MAX || parts == 0U ||
        config->hysteresis_q8 > 127U) {
        return 0U;
    }
    for (uint8_t decimal = config->decimals; decimal != 0U; --decimal) {
        factor = (factor << 3) + (factor << 1); /* <= 10^7 */
    }
    const uint16_t *entry    = scale_unit_reciprocals[config->unit];
    const uint32_t  mantissa = (uint32_t)port_rom_u16(&entry[0]) << 16 | port_rom_u16(&entry[1]);
    for (uint8_t bits = (uint8_t)(Q_FINE - port_rom_u16(&entry[2])); bits != 0U; --bits) {
        if (factor >> 31 != 0U) { return 0U; }
        factor <<= 1;
    }
    *fine = factor >> 24 != 0U;
    if (!*fine) {
        factor <<= 8;
    } else if (config->max_mg + config->interval_mg * 9 >= 1L << FINE_BITS) {
        return 0U;
    }
    return port_wide_high(mantissa, factor);
}

scale_status_t scale_init(scale_t *scale, const scale_config_t *config)
{
    bool           fine;
    scale_status_t status = take_points(config, NULL);

    if (status == SCALE_OK) { status = check_ranges(config); }
    if (status != SCALE_OK) { return status; }
    const uint32_t per_division = divide_display(config, &fine);
    if (per_division == 0U) { return SCALE_BAD_DIVISION; }

    *scale               = (scale_t){0};
    scale->config        = config;
    scale->per_division  = per_division;
    scale->fine          = fine;
    scale->zero_range_mg = (int32_t)port_wide_high((uint32_t)config->max_mg, FIFTIETH_Q32);
    return take_points(config, scale);
}
