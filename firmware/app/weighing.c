/* SPDX-License-Identifier: MIT */
#include "weighing.h"

#include "counter.h"
#include "fir.h"
#include "fir_designs.h"
#include "rate.h"
#include "scale.h"
#include "scale_units.h"
#include "weight_kf.h"
#include "weight_kf_adaptive.h"
#include "weight_kf_adaptive_variants.h"
#include "weight_kf_gains.h"

enum { FIR_DESIGN = 0, KF_SCHEDULE = 0 }; /* indices in fir.toml and weight_kf.toml */

#define ONE_Q7  (1L << WEIGHT_KF_FRACTION_BITS)
#define HALF_Q7 (ONE_Q7 / 2)

#define RAIL_LOW_COUNTS  (-8388608L)
#define RAIL_HIGH_COUNTS 8388607L

static fir_t fir;
static union {
    weight_kf_t          constant;
    weight_kf_adaptive_t adaptive;
} kf;                                   /* as kf_kind says */
static uint8_t             chain_order; /* MESSAGES_CHAIN_ORDER_... */
static uint8_t             kf_kind;     /* MESSAGES_KF_KIND_... */
static rate_t              rate;
static weighing_counters_t counters; /* clipped: of the runs before the present one */
static bool                primed;   /* the filters hold a run of samples */
static bool                has_beat; /* previous_us is of the conversion just before */
static uint32_t            previous_us;
static bool                gap;          /* conversions are missing before the next sample */
static uint16_t            missed_total; /* modulo 65536, unlike the counter */
static scale_t             scale;

void weighing_init(void)
{
    rate_init(&rate);
    scale_init(&scale, &scale_default);
    primed = false;
}

void weighing_restart(void)
{
    if (!primed) { return; }
    counters = weighing_counters(); /* the filters' own counts are about to start at 0 */
    primed   = false;
    scale_interrupt(&scale);
}

static void count_missed(uint8_t missed)
{
    if (missed == 0U) { return; }
    counter_add(&counters.conversions_missed, missed);
    missed_total = (uint16_t)(missed_total + missed);
    gap          = true;
}

bool weighing_time(uint32_t device_us)
{
    const uint32_t interval_us = device_us - previous_us;
    const bool     had_beat    = has_beat;

    previous_us = device_us;
    has_beat    = true;
    if (!had_beat) { return true; }
    const bool on_beat = rate_is_next(&rate, interval_us);
    count_missed(rate_missed(&rate, interval_us));
    if (rate_update(&rate, interval_us)) { hx711_set_period_us(rate_period_us(&rate)); }
    return on_beat;
}

void weighing_lose_beat(void)
{
    has_beat = false;
}

/* The filters are called from two places each; gcc would copy these into both. */
#define COMPACT __attribute__((noinline))

COMPACT static int32_t run_fir(int32_t counts, bool restarted)
{
    if (restarted) { fir_init(&fir, &fir_lowpass32, counts); }
    return fir_update(&fir, counts);
}

COMPACT static int32_t run_kf(int32_t counts, bool restarted)
{
    if (kf_kind == MESSAGES_KF_KIND_ADAPTIVE) {
        if (restarted) {
            weight_kf_adaptive_init(&kf.adaptive, &weight_kf_adaptive_default, counts);
        }
        return weight_kf_adaptive_update(&kf.adaptive, counts);
    }
    if (restarted) { weight_kf_init(&kf.constant, &weight_kf_default, counts); }
    return weight_kf_update(&kf.constant, counts);
}

void weighing_update(messages_sample_t *sample, const hx711_conversion_t *conversion)
{
    const int32_t counts = conversion->counts;
    int32_t       last_counts_q7;
    uint8_t       flags = 0;

    if (gap) {
        flags |= MESSAGES_SAMPLE_FLAG_GAP;
        gap = false;
    }
    if (counts == RAIL_LOW_COUNTS || counts == RAIL_HIGH_COUNTS) {
        flags |= MESSAGES_SAMPLE_FLAG_AT_RAIL;
        counter_add(&counters.at_rail, 1);
    }
    const bool restarted = !primed;
    if (restarted) { flags |= MESSAGES_SAMPLE_FLAG_RESTARTED; }
    if (chain_order == MESSAGES_CHAIN_ORDER_FIR_KF) {
        sample->fir_counts   = run_fir(counts, restarted);
        sample->kf_counts_q7 = run_kf(sample->fir_counts, restarted);
        last_counts_q7       = sample->kf_counts_q7;
    } else {
        sample->kf_counts_q7 = run_kf(counts, restarted);
        /* Half up, <= 2^23 - 1 as the estimate is at most that. */
        const int32_t estimate_counts = (sample->kf_counts_q7 + HALF_Q7) >> WEIGHT_KF_FRACTION_BITS;
        sample->fir_counts            = run_fir(estimate_counts, restarted);
        last_counts_q7                = sample->fir_counts * ONE_Q7;
    }
    primed = true;

    sample->conversion = (uint16_t)(hx711_counters()->conversions + missed_total);
    sample->raw_counts = counts;
    sample->flags      = flags;

    sample->weight_flags = scale_update(&scale, last_counts_q7, conversion->device_us);
    sample->mass_mg      = scale.mass_mg;
    sample->net_mg       = scale.net_mg;
}

uint8_t weighing_tare(void)
{
    switch (scale_tare(&scale)) {
    case SCALE_OK: return MESSAGES_RESULT_OK;
    case SCALE_NOT_STABLE: return MESSAGES_RESULT_NOT_STABLE;
    default: return MESSAGES_RESULT_OUT_OF_RANGE;
    }
}

uint32_t weighing_rate_hz_q16(void)
{
    return rate_hz_q16(&rate);
}

weighing_counters_t weighing_counters(void)
{
    weighing_counters_t now = counters;

    if (primed) {
        counter_add(&now.fir_clipped, fir.clipped);
        counter_add(&now.kf_clipped, kf_kind == MESSAGES_KF_KIND_ADAPTIVE ? kf.adaptive.clipped
                                                                          : kf.constant.clipped);
    }
    return now;
}

weighing_setup_t weighing_setup(void)
{
    return (weighing_setup_t){.fir_design  = FIR_DESIGN,
                              .fir_taps    = fir_lowpass32.taps,
                              .kf_schedule = KF_SCHEDULE,
                              .chain_order = chain_order,
                              .kf_kind     = kf_kind};
}
