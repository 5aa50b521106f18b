/* SPDX-License-Identifier: MIT */
#include "checkweigher.h"

#include "checkweigher_tone.h"
#include "fixed.h"
#include "port_wide.h"

#define MINUTE_32US_OVER_256 7324UL /* so that the ratio in Q32 is products a minute in Q24 */

#define COMPACT __attribute__((noinline))

enum {
    SAMPLES_MAX = CHECKWEIGHER_SAMPLES_MAX,
    MEAN_SHIFT  = 3,
    STEPS       = 3 /* levelling, correlating and solving, a sample each */
};

static bool is_lawful(const checkweigher_config_t *config)
{
    for (uint8_t at = 2U; at < config->classes; ++at) {
        if (config->limit_mg[at - 1U] <= config->limit_mg[at - 2U]) { return false; }
    }
    return config->leave_mg < config->enter_mg;
}

bool checkweigher_init(checkweigher_t *checkweigher, const checkweigher_config_t *config)
{
    if (!is_lawful(config)) { return false; }
    *checkweigher        = (checkweigher_t){0};
    checkweigher->config = config;
    return true;
}

/* Keep one mass of the stretch, as so many units from its first: both are above 0. */
static void hold(checkweigher_t *checkweigher, int32_t mass_mg)
{
    const uint8_t held = checkweigher->held;

    if (held == 0U) {
        uint8_t shift = 0U;
        for (int32_t rest = mass_mg; rest >= INT16_MAX; rest >>= 1) { ++shift; }
        checkweigher->shift   = shift;
        checkweigher->base_mg = mass_mg;
    }
    const int32_t above_mg = mass_mg - checkweigher->base_mg;
    if (above_mg > checkweigher->base_mg) { checkweigher->broken = true; }
    if (held < SAMPLES_MAX) {
        const uint16_t halves   = (uint16_t)(above_mg >> checkweigher->shift);
        checkweigher->off[held] = (int16_t)((int16_t)(halves + 1U) >> 1);
    }
    if (held != UINT8_MAX) { checkweigher->held = (uint8_t)(held + 1U); }
}

/* How many masses are old enough at the end. They came evenly: there was no gap. */
static uint8_t stretch(const checkweigher_t *checkweigher, uint32_t elapsed_us)
{
    uint8_t len = checkweigher->held;

    for (uint32_t age_us = elapsed_us; len != 0U && age_us < checkweigher->config->tail_us;
         age_us += elapsed_us) {
        --len; /* an age is below 2^23 */
    }
    return len > SAMPLES_MAX ? SAMPLES_MAX : len;
}

/* The pace, from the end of one product to the end of the next. */
static void pace(checkweigher_t *checkweigher)
{
    const uint32_t elapsed_us = checkweigher->last_us - checkweigher->left_us;
    uint32_t       mean       = checkweigher->interval_32us;

    checkweigher->left_us = checkweigher->last_us;
    if (checkweigher->weighed == 0U && checkweigher->unweighed == 0U) { return; }
    if (mean == 0U) { mean = elapsed_us >> 5; }
    checkweigher->interval_32us = mean - (mean >> MEAN_SHIFT) + (elapsed_us >> 8);
}

static COMPACT checkweigher_event_t finish(checkweigher_t *checkweigher, uint32_t elapsed_us)
{
    const uint8_t len = stretch(checkweigher, elapsed_us);

    checkweigher->loaded  = false;
    checkweigher->samples = len;
    pace(checkweigher);
    if (checkweigher->broken || len < checkweigher->config->samples_min) {
        fixed_count(&checkweigher->unweighed);
        return CHECKWEIGHER_UNWEIGHED;
    }
    checkweigher_tone_smooth(checkweigher);
    checkweigher->pending = STEPS;
    return CHECKWEIGHER_EMPTY;
}

/* One step towards the verdict; true with the last. */
static COMPACT bool conclude(checkweigher_t *checkweigher)
{
    const checkweigher_config_t *config  = checkweigher->config;
    const uint8_t                pending = checkweigher->pending;
    uint8_t                      at      = 0U;

    checkweigher->pending = (uint8_t)(pending - 1U);
    if (pending == STEPS) {
        checkweigher_tone_level(checkweigher);
        return false;
    }
    if (pending != 1U) {
        checkweigher_tone_correlate(checkweigher);
        return false;
    }
    const int32_t mass_mg = checkweigher->base_mg +
                            (int32_t)((uint32_t)checkweigher_tone_solve(checkweigher)
                                      << checkweigher->shift);
    while (at + 1U != config->classes && mass_mg >= config->limit_mg[at]) { ++at; }
    checkweigher->mass_mg  = mass_mg;
    checkweigher->class_at = at;
    ++checkweigher->weighed;
    return true;
}

COMPACT checkweigher_event_t checkweigher_update(checkweigher_t *checkweigher, int32_t mass_mg,
                                                 uint32_t device_us)
{
    const checkweigher_config_t *config     = checkweigher->config;
    const uint32_t               elapsed_us = device_us - checkweigher->last_us;
    const bool                   busy       = checkweigher->pending != 0U;
    const bool                   concluded  = busy && conclude(checkweigher);
    const checkweigher_event_t   verdict    = CHECKWEIGHER_VERDICT;

    checkweigher->last_us = device_us;
    if (!checkweigher->loaded) {
        if (mass_mg < config->enter_mg) { return concluded ? verdict : CHECKWEIGHER_EMPTY; }
        checkweigher->loaded     = true;
        checkweigher->broken     = false;
        checkweigher->held       = 0U;
        checkweigher->entered_us = device_us;
    } else {
        if (elapsed_us > config->gap_us) { checkweigher->broken = true; }
        if (mass_mg < config->leave_mg && !busy) { return finish(checkweigher, elapsed_us); }
    }
    /* While busy the former's masses are in use, and who leaves does so later. */
    if (!busy && device_us - checkweigher->entered_us >= config->settle_us) {
        hold(checkweigher, mass_mg);
    }
    return concluded ? verdict : CHECKWEIGHER_LOADED;
}

void checkweigher_interrupt(checkweigher_t *checkweigher)
{
    checkweigher->broken = true; /* until the next one enters */
}

uint16_t checkweigher_per_minute_q8(const checkweigher_t *checkweigher)
{
    const uint32_t interval = checkweigher->interval_32us;

    if (interval == 0U) { return 0U; }
    if (interval <= MINUTE_32US_OVER_256) { return UINT16_MAX; }
    return (uint16_t)(port_wide_ratio(MINUTE_32US_OVER_256, interval) >> 16);
}
