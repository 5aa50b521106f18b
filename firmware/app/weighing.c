/* SPDX-License-Identifier: MIT */
#include "weighing.h"

#include "counter.h"
#include "faults.h"
#include "fir.h"
#include "fir_designs.h"
#include "health.h"
#include "port_clamp.h"
#include "port_outline.h"
#include "port_reach.h"
#include "rate.h"
#include "setup.h"
#include "temperature.h"
#include "weighing_internal.h"
#include "weight_kf.h"
#include "weight_kf_adaptive.h"
#include "weight_kf_adaptive_variants.h"

#include <stddef.h>
#include <string.h>

_Static_assert(WEIGHT_KF_FRACTION_BITS == 7, "port_to_q7");

enum {
    CONVERTER_FAULTS = 0x3F,
    UNWEIGHED        = 255,
    RINGING          = 16 /* conversions for which an empty platform may ring */
};

_Static_assert((int)HX711_CONVERSION == (int)FAULTS_EVENT_CONVERSION &&
                   (int)HX711_DROPPED == (int)FAULTS_EVENT_DROPPED &&
                   (int)HX711_BAD_FRAME == (int)FAULTS_EVENT_BAD_FRAME &&
                   (int)HX711_TIMED_OUT == (int)FAULTS_EVENT_TIMED_OUT &&
                   (int)HX711_STUCK_LOW == (int)FAULTS_EVENT_STUCK_LOW,
               "the driver's events are faults' events");
_Static_assert((int)FAULTS_CABLE_OUT == (int)MESSAGES_FAULT_FLAG_CABLE_OUT &&
                   (int)FAULTS_NOISE == (int)MESSAGES_FAULT_FLAG_NOISE_HIGH,
               "fault_flag in messages.toml");
_Static_assert((int)SCALE_STABLE == (int)MESSAGES_WEIGHT_FLAG_STABLE &&
                   (int)SCALE_FROZEN == (int)MESSAGES_WEIGHT_FLAG_FROZEN,
               "weight_flag in messages.toml");

typedef struct {
    uint32_t previous_us;
    uint16_t missed_total; /* modulo 65536, unlike the counter */
    bool     has_beat;     /* previous_us is of the conversion just before */
    bool     gap;          /* conversions are missing before the next sample */
} beat_t;

/* A window has room for twice the taps of this design, so long as its configuration is a copy: the
 * rest of it serves for what else there is (fir.h, Two ways). */
typedef struct {
    uint8_t              taken[offsetof(fir_t, window) + FIR_SAMPLE_BYTES * WEIGHING_FIR_TAPS];
    weight_kf_adaptive_t kf;
    faults_t             faults;
    temperature_t        temperature;
    rate_t               rate;
    beat_t               beat;
    weighing_counters_t  counters;
    uint8_t              ringing;    /* while not 0, noise may be a product's */
    bool                 is_missing; /* the thermometer does not answer */
    bool                 primed;     /* the filters hold a run of samples */
} rest_t;

static union {
    fir_t  fir;
    rest_t rest;
} shared;

_Static_assert(sizeof(rest_t) <= sizeof(fir_t), "it fits in the window");

static fir_config_t         design;
static uint8_t              chain_order; /* MESSAGES_CHAIN_ORDER_..., of the run under way */
scale_t                     weighing_scale;
weighing_beside_t           weighing_beside;
bool                        weighing_calibrating;
int32_t                     weighing_last_counts_q7;
static checkweigher_event_t product; /* what the last sample meant to the checkweigher */

/* No weight until what comes now has settled. */
static void distrust(void)
{
    scale_interrupt(PORT_REACH(&weighing_scale));
}

/* What follows is not connected with what was: the next conversion starts the filters anew. */
static PORT_OUTLINE void restart(void)
{
    shared.rest.primed = false;
    distrust();
}

PORT_OUTLINE scale_status_t weighing_renew(const int32_t zero_and_tare_mg[2], bool firm)
{
    /* They may be the scale's own, which begins without. */
    const int32_t        zero_mg = zero_and_tare_mg[0], tare_mg = zero_and_tare_mg[1];
    const scale_status_t status = scale_init(&weighing_scale, &setup.scale);

    if (status == SCALE_OK) { scale_resume(PORT_REACH(&weighing_scale), zero_mg, tare_mg, firm); }
    return status;
}

PORT_OUTLINE bool weighing_renew_checkweigher(void)
{
    return checkweigher_init(&weighing_beside.checkweigher, PORT_REACH(&setup.checkweigher));
}

static PORT_OUTLINE void renew_chain(void)
{
    hx711_set_gain((hx711_gain_t)setup.gain);
    faults_pause(&shared.rest.faults);
    faults_limit_noise(&shared.rest.faults, setup.noise_limit_counts);
    restart();
}

bool weighing_setup(bool running)
{
    /* A tare is of something that may lie there already: then its zero is the one to keep. */
    const bool firm = running || setup.tare_mg != 0;

    weighing_calibrating = false;
    if (!running) {
        rate_init(&shared.rest.rate);
        faults_init(&shared.rest.faults);
        faults_limit_noise(&shared.rest.faults, setup.noise_limit_counts);
        temperature_init(&shared.rest.temperature, &setup.temperature);
    }
    if (weighing_renew(&setup.zero_mg, firm) != SCALE_OK || !weighing_renew_checkweigher()) {
        return false;
    }
    temperature_refresh(&shared.rest.temperature);
    if (running) { renew_chain(); }
    return true;
}

bool weighing_setup_key(uint8_t key)
{
    if (key < SETTINGS_KEY_CHAIN_ORDER) {
        return weighing_renew(&weighing_scale.zero_mg, true) == SCALE_OK;
    }
    if (key < SETTINGS_KEY_STREAM_MASK) {
        renew_chain();
        return true;
    }
    if (key < SETTINGS_KEY_CHECKWEIGHER_ON) { return true; }
    if (key < SETTINGS_KEY_TEMPERATURE_ON) { return weighing_renew_checkweigher(); }
    temperature_refresh(&shared.rest.temperature);
    return true;
}

/* Whether a conversion came when one was due. Of a dropped one, too, the time gives the rate. */
static bool take_time(uint32_t device_us)
{
    beat_t *const  beat        = PORT_REACH(&shared.rest.beat);
    const uint32_t interval_us = device_us - beat->previous_us;
    const bool     had_beat    = beat->has_beat;

    beat->previous_us = device_us;
    beat->has_beat    = true;
    if (!had_beat) { return true; }
    uint8_t       missed;
    const uint8_t taken = rate_take(&shared.rest.rate, interval_us, &missed);
    if (missed != 0U) {
        counter_add(&shared.rest.counters.conversions_missed, missed);
        shared.rest.beat.missed_total = (uint16_t)(shared.rest.beat.missed_total + missed);
        shared.rest.beat.gap          = true;
    }
    if ((taken & RATE_CHANGED) != 0U) { hx711_set_period_8us(rate_period_8us(&shared.rest.rate)); }
    return (taken & RATE_IS_NEXT) != 0U;
}

/* What a filter has counted goes to where no restart clears it. */
static void gather(uint16_t *total, uint16_t *clipped)
{
    counter_add(total, *clipped);
    *clipped = 0;
}

static PORT_OUTLINE int32_t run_fir(int32_t counts)
{
    PORT_SAVE_BY_CALL();
    if (!shared.rest.primed) {
        design = fir_lowpass32;
        fir_init(&shared.fir, &design, counts);
    }
    const int32_t filtered = fir_update(&shared.fir, counts);
    gather(&shared.rest.counters.fir_clipped, &shared.fir.clipped);
    return filtered;
}

static PORT_OUTLINE int32_t run_kf(int32_t counts)
{
    PORT_SAVE_BY_CALL();
    weight_kf_adaptive_t *const kf = PORT_REACH(&shared.rest.kf);

    if (!shared.rest.primed) { weight_kf_adaptive_init(kf, &weight_kf_adaptive_default, counts); }
    weight_kf_adaptive_update(kf, counts);
    gather(&shared.rest.counters.kf_clipped, &kf->clipped);
    return kf->estimate_counts_q7;
}

static void filter(messages_sample_t *sample)
{
    if (!shared.rest.primed) { chain_order = setup.chain_order; }
    if (chain_order == MESSAGES_CHAIN_ORDER_FIR_KF) {
        sample->fir_counts      = run_fir(sample->raw_counts);
        sample->kf_counts_q7    = run_kf(sample->fir_counts);
        weighing_last_counts_q7 = sample->kf_counts_q7;
    } else {
        sample->kf_counts_q7 = run_kf(sample->raw_counts);
        /* Half up, <= 2^23 - 1 as the estimate is at most that. */
        sample->fir_counts      = run_fir(port_from_q7(sample->kf_counts_q7));
        weighing_last_counts_q7 = port_to_q7(sample->fir_counts);
    }
    shared.rest.primed = true;
}

static uint8_t sample_flags(void)
{
    uint8_t flags = 0;

    if (shared.rest.beat.gap) { flags = MESSAGES_SAMPLE_FLAG_GAP; }
    shared.rest.beat.gap = false;
    if (!shared.rest.faults.in_run) { /* then faults has seen it at a rail */
        flags |= MESSAGES_SAMPLE_FLAG_AT_RAIL;
        counter_add(&shared.rest.counters.at_rail, 1);
    }
    if (!shared.rest.primed) { flags |= MESSAGES_SAMPLE_FLAG_RESTARTED; }
    return flags;
}

/* A product that comes, rings and goes is noise to a scale at rest, and no fault to a
 * checkweigher. */
static uint8_t faults_to_tell(void)
{
    const uint8_t held = shared.rest.faults.held;

    if (!weighing_calibrating && weighing_beside.checkweigher.loaded) {
        shared.rest.ringing = RINGING;
    } else if (shared.rest.ringing != 0U && (held & FAULTS_NOISE) == 0U) {
        shared.rest.ringing--;
    }
    return shared.rest.ringing != 0U ? held & (uint8_t)~FAULTS_NOISE : held;
}

bool weighing_take(messages_sample_t *sample, hx711_status_t status,
                   const hx711_conversion_t *conversion)
{
    const uint32_t device_us = conversion->device_us;
    faults_event_t event     = (faults_event_t)status;

    if (status > HX711_DROPPED) { /* there was no conversion */
        shared.rest.beat.has_beat = false;
    } else if (!take_time(device_us)) {
        hx711_distrust();
        event = FAULTS_EVENT_OFF_BEAT;
    }
    const uint8_t news = faults_update(&shared.rest.faults, event, conversion->counts);
    health_note(CONVERTER_FAULTS, faults_to_tell());
    if ((news & FAULTS_RESTART) != 0U || hx711_state() != HX711_STATE_RUNNING) { restart(); }
    if ((news & FAULTS_SPOILT) != 0U || weighing_awaits_temperature()) { distrust(); }
    if (event != FAULTS_EVENT_CONVERSION) {
        /* Not with each distrust: a product that comes and rings is noise to a scale at rest. */
        if (!weighing_calibrating) { checkweigher_interrupt(&weighing_beside.checkweigher); }
        return false;
    }

    sample->conversion = (uint16_t)(hx711_counters()->conversions + shared.rest.beat.missed_total);
    sample->flags      = sample_flags();
    sample->raw_counts = temperature_correct(&shared.rest.temperature, conversion->counts);
    filter(sample);
    const int32_t raw_q7 = port_to_q7(sample->raw_counts);
    sample->weight_flags = scale_update(&weighing_scale, weighing_last_counts_q7, raw_q7,
                                        device_us);
    sample->mass_mg      = weighing_scale.mass_mg;
    sample->net_mg       = weighing_scale.net_mg;

    product = CHECKWEIGHER_EMPTY;
    if (setup.checkweigher_on != 0U && !weighing_calibrating) {
        const int32_t load_mg = scale_mass(&weighing_scale, raw_q7) - weighing_scale.zero_mg;
        product = checkweigher_update(&weighing_beside.checkweigher, load_mg, device_us);
    }
    return true;
}

_Static_assert(offsetof(scale_t, steps) - offsetof(scale_t, step_from_mg) ==
                       offsetof(messages_step_t, steps) &&
                   offsetof(scale_t, step_to_mg) - offsetof(scale_t, step_from_mg) ==
                       offsetof(messages_step_t, to_mg) &&
                   offsetof(scale_t, net_mg) - offsetof(scale_t, zero_mg) ==
                       offsetof(messages_weight_t, net_mg) - offsetof(messages_weight_t, zero_mg) &&
                   offsetof(scale_t, tare_mg) - offsetof(scale_t, zero_mg) ==
                       offsetof(messages_weight_t, tare_mg) - offsetof(messages_weight_t, zero_mg),
               "STEP, and WEIGHT from zero to net, lie in scale_t as on the wire");

bool weighing_step(messages_step_t *step, uint32_t *device_us)
{
    if ((weighing_scale.flags & SCALE_STEPPED) == 0U) { return false; }
    memcpy(step, &weighing_scale.step_from_mg, sizeof *step);
    *device_us = weighing_scale.step_us;
    return true;
}

bool weighing_product(messages_product_t *told, uint32_t *device_us)
{
    const checkweigher_t *checkweigher = PORT_REACH(&weighing_beside.checkweigher);
    const bool            is_weighed   = product == CHECKWEIGHER_VERDICT;

    if (!is_weighed && product != CHECKWEIGHER_UNWEIGHED) { return false; }
    told->mass_mg       = is_weighed ? checkweigher->mass_mg : 0;
    told->verdict       = is_weighed ? checkweigher->class_at : UNWEIGHED;
    told->samples       = checkweigher->samples;
    told->weighed       = checkweigher->weighed;
    told->unweighed     = checkweigher->unweighed;
    told->per_minute_q8 = checkweigher_per_minute_q8(checkweigher);
    *device_us          = checkweigher->left_us;
    return true;
}

void weighing_show(messages_weight_t *weight)
{
    memcpy(&weight->zero_mg, &weighing_scale.zero_mg, 3U * sizeof weight->zero_mg);
    weight->shown        = scale_shown(&weighing_scale);
    weight->unit         = setup.scale.unit;
    weight->decimals     = setup.scale.decimals;
    weight->weight_flags = weighing_scale.flags;
    weight->pieces       = scale_pieces(PORT_REACH(&weighing_scale));
    weight->calibrating  = weighing_calibrating ? (uint8_t)(weighing_beside.calibration.count + 1U)
                                                : 0U;
    weight->temperature_centi = shared.rest.temperature.known && !shared.rest.is_missing
                                    ? temperature_centi(&shared.rest.temperature)
                                    : INT32_MIN;
}

static void note_thermometer(void)
{
    health_note_one(MESSAGES_FAULT_FLAG_THERMOMETER,
                    shared.rest.is_missing && setup.temperature.on != 0U);
}

bool weighing_awaits_temperature(void)
{
    return setup.temperature.on != 0U && !shared.rest.temperature.known && !shared.rest.is_missing;
}

void weighing_temperature(int16_t centi)
{
    if (!shared.rest.temperature.known && setup.temperature.on != 0U) {
        restart();
    } /* all counts move */
    shared.rest.is_missing = false;
    temperature_update(&shared.rest.temperature, centi);
    note_thermometer();
}

void weighing_no_temperature(void)
{
    shared.rest.is_missing = true;
    note_thermometer();
}

const weighing_counters_t *weighing_counters(void)
{
    return &shared.rest.counters;
}

uint32_t weighing_rate_hz_q16(void)
{
    return rate_hz_q16(&shared.rest.rate);
}
