/* SPDX-License-Identifier: MIT */
#include "scale.h"

#include "port_rom.h"
#include "scale_units.h"
#include "scale_wide.h"

/* One more than 2^32 / 10 and 2^32 / 50, rounded down: for Max <= 5e8 the products' upper halves
 * are Max / 10 and Max / 50, rounded down. */
#define TENTH_Q32    429496730UL
#define FIFTIETH_Q32 85899346UL

enum { DIGITS = 3, Q_COARSE = 40, Q_FINE = 32, FINE_BITS = 23 };

static bool within(int32_t value, int32_t limit)
{
    return value >= -limit && value <= limit;
}

/* The difference in the direction of `falls`; 0 where it goes the other way. */
static uint32_t rise(int32_t from, int32_t to, bool falls)
{
    const bool lawful = falls ? to < from : to > from;

    if (!lawful) { return 0U; }
    return falls ? (uint32_t)from - (uint32_t)to : (uint32_t)to - (uint32_t)from;
}

static bool falls(const scale_config_t *config)
{
    return config->point_counts_q7[1] < config->point_counts_q7[0];
}

static scale_status_t check_points(const scale_config_t *config)
{
    const int32_t *counts_q7 = config->point_counts_q7, *mass_mg = config->point_mass_mg;

    if (config->points < 2U || config->points > SCALE_POINTS_MAX) { return SCALE_BAD_COUNT; }
    for (uint8_t at = 0U; at < config->points; ++at) {
        if (!within(counts_q7[at], SCALE_COUNTS_Q7) || !within(mass_mg[at], SCALE_MAX_MG)) {
            return SCALE_BAD_POINT;
        }
    }
    for (uint8_t at = 1U; at < config->points; ++at) {
        const uint32_t counts = rise(counts_q7[at - 1U], counts_q7[at], falls(config));
        const uint32_t mass   = rise(mass_mg[at - 1U], mass_mg[at], false);
        if (counts == 0U || mass == 0U) { return SCALE_NOT_MONOTONE; }
        if (mass >= counts) { return SCALE_TOO_STEEP; }
    }
    return SCALE_OK;
}

static bool ranges_hold(const scale_config_t *config)
{
    return config->max_mg >= 1 && config->max_mg <= SCALE_MAX_MG && config->interval_mg >= 1 &&
           config->interval_mg <= config->max_mg >> 4 && config->under_mg >= 0 &&
           config->under_mg <= config->max_mg && config->step_mg >= 0 &&
           config->step_mg <= config->max_mg && config->stable_band_mg >= 0 &&
           config->stable_band_mg <= config->interval_mg;
}

static bool times_hold(const scale_config_t *config)
{
    const uint32_t max_us = 0x80000000U;

    return config->stable_us >= 1U && config->stable_us <= max_us && config->gap_us >= 1U &&
           config->gap_us <= max_us;
}

/* value / 2^bits into 32 bits, rounded down; false where it does not fit. */
static bool shifted(scale_wide_t value, uint8_t bits, uint32_t *result)
{
    for (; bits != 0U; --bits) {
        value.low = value.low >> 1 | value.high << 31;
        value.high >>= 1;
    }
    *result = value.low;
    return value.high == 0U;
}

static int32_t over_mg(const scale_config_t *config)
{
    return config->max_mg + config->interval_mg * 8 + config->interval_mg; /* < 2^30 */
}

/* 1/d in 1/mg, in Q40, or in Q32 where d is fine; false where the configuration allows none. */
static bool divide_display(const scale_config_t *config, uint32_t *per_division, bool *fine)
{
    if (config->unit >= SCALE_UNIT_COUNT || config->decimals > SCALE_DECIMALS_MAX ||
        (config->digit != 1U && config->digit != 2U && config->digit != 5U) ||
        config->hysteresis_q8 > 127U) {
        return false;
    }
    const uint8_t   digit    = config->digit == 5U ? 2U : (uint8_t)(config->digit - 1U);
    const uint8_t   place    = (uint8_t)(config->unit * DIGITS + digit);
    const uint16_t *entry    = scale_unit_reciprocals[place];
    const uint32_t  mantissa = (uint32_t)port_rom_u16(&entry[0]) << 16 | port_rom_u16(&entry[1]);
    const uint8_t   exponent = (uint8_t)port_rom_u16(&entry[2]);
    uint32_t        power    = 1U;

    for (uint8_t decimal = config->decimals; decimal != 0U; --decimal) {
        power = (power << 3) + (power << 1);
    }
    const scale_wide_t product = scale_wide_product(mantissa, power); /* < 2^52 */

    *fine = !shifted(product, (uint8_t)(exponent - Q_COARSE), per_division);
    return !*fine || (shifted(product, (uint8_t)(exponent - Q_FINE), per_division) &&
                      over_mg(config) >> FINE_BITS == 0);
}

scale_status_t scale_init(scale_t *scale, const scale_config_t *config)
{
    uint32_t             per_division;
    bool                 fine;
    const scale_status_t points = check_points(config);

    if (points != SCALE_OK) { return points; }
    if (!ranges_hold(config)) { return SCALE_BAD_RANGE; }
    if (!divide_display(config, &per_division, &fine)) { return SCALE_BAD_DIVISION; }
    if (!times_hold(config)) { return SCALE_BAD_TIME; }

    const uint32_t max_mg = (uint32_t)config->max_mg;
    *scale                = (scale_t){
                       .config        = config,
                       .per_division  = per_division,
                       .fine          = fine,
                       .falling       = falls(config),
                       .over_mg       = over_mg(config),
                       .initial_mg    = (int32_t)scale_wide_product(max_mg, TENTH_Q32).high,
                       .zero_range_mg = (int32_t)scale_wide_product(max_mg, FIFTIETH_Q32).high,
    };
    for (uint8_t at = 1U; at < config->points; ++at) {
        const uint32_t counts = rise(config->point_counts_q7[at - 1U], config->point_counts_q7[at],
                                     scale->falling);
        const uint32_t mass   = rise(config->point_mass_mg[at - 1U], config->point_mass_mg[at],
                                     false);
        scale->slope_q32[at - 1U] = scale_wide_ratio(mass, counts);
    }
    return SCALE_OK;
}
