/* SPDX-License-Identifier: MIT */
#include "checkweigher.h"

#include "fixed.h"
#include "port_wide.h"
#include "scale_wide.h"

#define MASS_MG            1073741824L /* 2^30 */
#define SPREAD_MG          4194304L    /* 2^22: weights of 272 in all keep the sum below 2^31 */
#define MINUTE_US_OVER_256 234375UL    /* so that the ratio in Q32 is products a minute in Q24 */

enum { SAMPLES_MAX = CHECKWEIGHER_SAMPLES_MAX, INTERVAL_SHIFT = 3 };

_Static_assert((SAMPLES_MAX & (SAMPLES_MAX - 1)) == 0, "the ring's places wrap by a mask");

static bool times_hold(const checkweigher_config_t *config)
{
    const uint32_t most = CHECKWEIGHER_TIME_MAX_US;

    return config->settle_us <= most && config->tail_us <= most && config->gap_us >= 1U &&
           config->gap_us <= CHECKWEIGHER_GAP_MAX_US;
}

static bool is_lawful(const checkweigher_config_t *config)
{
    if (config->classes < 1U || config->classes > CHECKWEIGHER_CLASSES_MAX) { return false; }
    for (uint8_t at = 0U; at + 1U < config->classes; ++at) {
        const int32_t limit = config->limit_mg[at];
        if (limit < -MASS_MG || limit > MASS_MG) { return false; }
        if (at != 0U && limit <= config->limit_mg[at - 1U]) { return false; }
    }
    return config->leave_mg > 0 && config->leave_mg < config->enter_mg &&
           config->enter_mg <= MASS_MG && config->samples_min >= 1U &&
           config->samples_min <= SAMPLES_MAX && times_hold(config);
}

bool checkweigher_init(checkweigher_t *checkweigher, const checkweigher_config_t *config)
{
    if (!is_lawful(config)) { return false; }
    *checkweigher        = (checkweigher_t){0};
    checkweigher->config = config;
    return true;
}

static void hold(checkweigher_t *checkweigher, int32_t mass_mg, uint32_t device_us)
{
    const uint8_t at = checkweigher->next;

    checkweigher->ring_mg[at]    = mass_mg;
    checkweigher->ring_256us[at] = (uint16_t)(device_us >> 8);
    checkweigher->next           = (uint8_t)((at + 1U) & (SAMPLES_MAX - 1U));
    if (checkweigher->held != SAMPLES_MAX) { ++checkweigher->held; }
}

/* How many masses are in the stretch, from the ring's oldest on. */
static uint8_t stretch(const checkweigher_t *checkweigher, uint8_t oldest, uint32_t device_us)
{
    const uint16_t now  = (uint16_t)(device_us >> 8);
    const uint16_t tail = (uint16_t)(checkweigher->config->tail_us >> 8); /* < 2^14 */
    uint8_t        len  = 0U;

    while (len != checkweigher->held) {
        const uint8_t at = (uint8_t)((uint8_t)(oldest + len) & (SAMPLES_MAX - 1U));
        if ((uint16_t)(now - checkweigher->ring_256us[at]) < tail) { break; }
        ++len;
    }
    return len;
}

/* Put one difference more into the running sum; false where it is too far off. */
static bool gather(const checkweigher_t *checkweigher, uint8_t at, int32_t base, int32_t *running)
{
    const int32_t off = checkweigher->ring_mg[at & (SAMPLES_MAX - 1U)] - base; /* both > 0 */

    if (off < -SPREAD_MG || off > SPREAD_MG) { return false; }
    *running += off;
    return true;
}

/* The weighted mean of len masses from `oldest` on; false where one is too far off. */
static bool weigh(checkweigher_t *checkweigher, uint8_t oldest, uint8_t len)
{
    const int32_t base    = checkweigher->ring_mg[oldest];
    const uint8_t half    = (uint8_t)((uint8_t)(len + 1U) >> 1);
    int32_t       sum     = 0; /* |.| <= 272 * 2^22 < 2^31 */
    int32_t       running = 0; /* |.| <= 2^26 */
    uint16_t      weights = 0U;

    /* Sums of sums: what comes i places before the end of a half counts i times. */
    for (uint8_t at = half; at != 0U; --at) {
        if (!gather(checkweigher, (uint8_t)(oldest + at - 1), base, &running)) { return false; }
        sum += running;
        weights = (uint16_t)(weights + at);
    }
    running = 0;
    for (uint8_t at = half; at != len; ++at) {
        if (!gather(checkweigher, (uint8_t)(oldest + at), base, &running)) { return false; }
        sum += running;
        weights = (uint16_t)(weights + len - at);
    }
    const uint32_t size   = sum < 0 ? 0U - (uint32_t)sum : (uint32_t)sum;
    const uint32_t share  = weights == 1U ? 0U : scale_wide_ratio(1U, weights); /* 1: sum is 0 */
    const int32_t  off    = (int32_t)port_wide_high(size, share);
    checkweigher->mass_mg = sum < 0 ? base - off : base + off;
    checkweigher->samples = len;
    return true;
}

static void judge(checkweigher_t *checkweigher)
{
    const checkweigher_config_t *config = checkweigher->config;
    uint8_t                      at     = 0U;

    while (at + 1U != config->classes && checkweigher->mass_mg >= config->limit_mg[at]) { ++at; }
    checkweigher->class_at = at;
    ++checkweigher->counts[at];
    ++checkweigher->weighed;
}

/* The pace, from the end of one product to the end of the next. */
static void pace(checkweigher_t *checkweigher, uint32_t device_us)
{
    const uint32_t elapsed_us = device_us - checkweigher->left_us;
    const uint32_t mean_us    = checkweigher->interval_us;
    const bool     first      = checkweigher->weighed == 0U && checkweigher->unweighed == 0U;

    checkweigher->left_us = device_us;
    if (first) { return; }
    if (mean_us == 0U) {
        checkweigher->interval_us = elapsed_us;
    } else {
        checkweigher->interval_us = mean_us - (mean_us >> INTERVAL_SHIFT) +
                                    (elapsed_us >> INTERVAL_SHIFT);
    }
}

static checkweigher_event_t finish(checkweigher_t *checkweigher, uint32_t device_us)
{
    const uint8_t oldest = (uint8_t)((uint8_t)(checkweigher->next - checkweigher->held) &
                                     (SAMPLES_MAX - 1U));
    const uint8_t len    = stretch(checkweigher, oldest, device_us);

    checkweigher->loaded = false;
    pace(checkweigher, device_us);
    if (checkweigher->broken || len < checkweigher->config->samples_min ||
        !weigh(checkweigher, oldest, len)) {
        fixed_count(&checkweigher->unweighed);
        return CHECKWEIGHER_UNWEIGHED;
    }
    judge(checkweigher);
    return CHECKWEIGHER_VERDICT;
}

checkweigher_event_t checkweigher_update(checkweigher_t *checkweigher, int32_t mass_mg,
                                         uint32_t device_us)
{
    const checkweigher_config_t *config     = checkweigher->config;
    const uint32_t               elapsed_us = device_us - checkweigher->last_us;

    checkweigher->last_us = device_us;
    if (mass_mg > MASS_MG) { mass_mg = MASS_MG; }
    if (mass_mg < -MASS_MG) { mass_mg = -MASS_MG; }
    if (!checkweigher->loaded) {
        if (mass_mg < config->enter_mg) { return CHECKWEIGHER_EMPTY; }
        checkweigher->loaded     = true;
        checkweigher->broken     = false;
        checkweigher->held       = 0U;
        checkweigher->entered_us = device_us;
    } else {
        if (elapsed_us > config->gap_us) { checkweigher->broken = true; }
        if (mass_mg < config->leave_mg) { return finish(checkweigher, device_us); }
    }
    if (checkweigher->held != 0U || device_us - checkweigher->entered_us >= config->settle_us) {
        hold(checkweigher, mass_mg, device_us);
    }
    return CHECKWEIGHER_LOADED;
}

uint16_t checkweigher_per_minute_q8(const checkweigher_t *checkweigher)
{
    const uint32_t interval_us = checkweigher->interval_us;

    if (interval_us == 0U) { return 0U; }
    if (interval_us <= MINUTE_US_OVER_256) { return UINT16_MAX; }
    if (interval_us > 0x80000000U) { return 0U; } /* 36 minutes: less than 1/256 a minute is 0 */
    return (uint16_t)(scale_wide_ratio(MINUTE_US_OVER_256, interval_us) >> 16);
}
