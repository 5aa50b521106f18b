/* SPDX-License-Identifier: MIT */
#include "checkweigher.h"

#include "checkweigher_tone.h"
#include "fixed.h"
#include "scale_wide.h"

#define MASS_MG              1073741824L /* 2^30 */
#define MINUTE_32US_OVER_256 7324UL      /* so that the ratio in Q32 is products a minute in Q24 */

enum {
    SAMPLES_MAX = CHECKWEIGHER_SAMPLES_MAX,
    MEAN_SHIFT  = 3,
    SMOOTHING   = 4, /* so many fewer are left */
    STEPS       = 2  /* summing and solving, a sample each */
};

static bool is_lawful(const checkweigher_config_t *config)
{
    const uint8_t classes = config->classes, samples = config->samples_min;

    if (classes < 1U || classes > CHECKWEIGHER_CLASSES_MAX) { return false; }
    for (uint8_t at = 1U; at < classes - 1U; ++at) {
        if (config->limit_mg[at] <= config->limit_mg[at - 1U]) { return false; }
    }
    return config->leave_mg > 0 && config->leave_mg < config->enter_mg &&
           samples >= CHECKWEIGHER_SAMPLES_MIN && samples <= SAMPLES_MAX;
}

bool checkweigher_init(checkweigher_t *checkweigher, const checkweigher_config_t *config)
{
    if (!is_lawful(config)) { return false; }
    *checkweigher        = (checkweigher_t){0};
    checkweigher->config = config;
    return true;
}

/* The stretch's unit: 2^this mg; base is below 2^14 of them. */
static uint8_t unit_shift(int32_t base_mg)
{
    uint8_t shift = 0U;

    for (; base_mg >= CHECKWEIGHER_OFF_MAX; base_mg >>= 1) { ++shift; }
    return shift; /* <= 17 */
}

/* Keep one mass of the stretch, as so many units from its first. */
static void hold(checkweigher_t *checkweigher, int32_t mass_mg)
{
    if (checkweigher->held == 0U) { checkweigher->base_mg = mass_mg; }
    const int32_t base_mg = checkweigher->base_mg; /* both > 0 */
    const uint8_t shift   = unit_shift(base_mg);
    int32_t       off     = (mass_mg - base_mg + (int32_t)((1UL << shift) >> 1)) >> shift;
    if (off >= CHECKWEIGHER_OFF_MAX || off <= -CHECKWEIGHER_OFF_MAX) { off = CHECKWEIGHER_OFF_MAX; }
    if (checkweigher->held < SAMPLES_MAX) { checkweigher->off[checkweigher->held] = (int16_t)off; }
    if (checkweigher->held != UINT8_MAX) { ++checkweigher->held; }
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

static void judge(checkweigher_t *checkweigher)
{
    const checkweigher_config_t *config = checkweigher->config;
    uint8_t                      at     = 0U;

    while (at + 1U != config->classes && checkweigher->mass_mg >= config->limit_mg[at]) { ++at; }
    checkweigher->class_at = at;
    ++checkweigher->counts[at];
}

uint32_t checkweigher_weighed(const checkweigher_t *checkweigher)
{
    uint32_t weighed = 0U;

    for (uint8_t at = 0U; at != CHECKWEIGHER_CLASSES_MAX; ++at) {
        weighed += checkweigher->counts[at];
    }
    return weighed;
}

/* The pace, from the end of one product to the end of the next. */
static void pace(checkweigher_t *checkweigher, uint32_t device_us)
{
    const uint32_t elapsed_256us = (device_us - checkweigher->left_us) >> 8;
    const uint32_t mean          = checkweigher->interval_32us;
    const bool first = checkweigher->unweighed == 0U && checkweigher_weighed(checkweigher) == 0U;

    checkweigher->left_us = device_us;
    if (first) { return; }
    checkweigher->interval_32us = mean == 0U ? elapsed_256us << MEAN_SHIFT
                                             : mean - (mean >> MEAN_SHIFT) + elapsed_256us;
}

static checkweigher_event_t finish(checkweigher_t *checkweigher, uint32_t device_us,
                                   uint32_t elapsed_us)
{
    const uint8_t len = stretch(checkweigher, elapsed_us);

    checkweigher->loaded  = false;
    checkweigher->samples = len;
    pace(checkweigher, device_us);
    if (checkweigher->broken || len < checkweigher->config->samples_min ||
        !checkweigher_tone_smooth(checkweigher->off, len)) {
        fixed_count(&checkweigher->unweighed);
        return CHECKWEIGHER_UNWEIGHED;
    }
    checkweigher->pending = STEPS;
    return CHECKWEIGHER_EMPTY;
}

/* One step towards the verdict; true with the last. */
static bool conclude(checkweigher_t *checkweigher)
{
    const uint8_t len = checkweigher->samples;

    if (--checkweigher->pending != 0U) {
        checkweigher_tone_sum(&checkweigher->sums, checkweigher->off, (uint8_t)(len - SMOOTHING));
        return false;
    }
    const uint8_t shift = unit_shift(checkweigher->base_mg);
    int32_t       off   = checkweigher_tone_solve(&checkweigher->sums); /* Q8, |.| <= 2^22 */
    if (shift < 8U) {
        off = (off + (128 >> shift)) >> (8U - shift);
    } else {
        off *= 1L << (shift - 8U);
    }
    checkweigher->mass_mg = checkweigher->base_mg + off;
    judge(checkweigher);
    return true;
}

checkweigher_event_t checkweigher_update(checkweigher_t *checkweigher, int32_t mass_mg,
                                         uint32_t device_us)
{
    const checkweigher_config_t *config     = checkweigher->config;
    const uint32_t               elapsed_us = device_us - checkweigher->last_us;
    const bool                   concluded  = checkweigher->pending != 0U && conclude(checkweigher);
    const checkweigher_event_t   verdict    = CHECKWEIGHER_VERDICT;

    checkweigher->last_us = device_us;
    if (mass_mg > MASS_MG) { mass_mg = MASS_MG; }
    if (!checkweigher->loaded) {
        if (mass_mg < config->enter_mg) { return concluded ? verdict : CHECKWEIGHER_EMPTY; }
        checkweigher->loaded     = true;
        checkweigher->broken     = false;
        checkweigher->held       = 0U;
        checkweigher->entered_us = device_us;
    } else {
        if (elapsed_us > config->gap_us) { checkweigher->broken = true; }
        if (mass_mg < config->leave_mg) { /* two answers do not go into one: it leaves later */
            return concluded ? verdict : finish(checkweigher, device_us, elapsed_us);
        }
    }
    /* until then the former's masses are in use */
    if (checkweigher->pending == 0U &&
        (checkweigher->held != 0U || device_us - checkweigher->entered_us >= config->settle_us)) {
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
    return (uint16_t)(scale_wide_ratio(MINUTE_32US_OVER_256, interval) >> 16);
}
