/* SPDX-License-Identifier: MIT */
#include "faults_blocks.h"

#include "fir_designs.h"
#include "weight_kf_adaptive_variants.h"

void faults_blocks_init(faults_blocks_t *chain, scale_t *scale)
{
    faults_init(&chain->faults);
    chain->scale   = scale;
    chain->primed  = false;
    chain->watched = true;
}

/* As weighing_take of the firmware. */
static void weigh(faults_blocks_t *chain, faults_event_t event, int32_t counts, uint32_t device_us)
{
    const uint8_t found  = faults_update(&chain->faults, event, counts);
    const uint8_t answer = chain->watched ? found : 0U;

    if (event != FAULTS_EVENT_CONVERSION || (answer & FAULTS_RESTART) != 0U) {
        chain->primed = false;
    }
    if (!chain->primed || (answer & FAULTS_SPOILT) != 0U) { scale_interrupt(chain->scale); }
    if (event != FAULTS_EVENT_CONVERSION) { return; }

    if (!chain->primed) { fir_init(&chain->fir, &fir_lowpass32, counts); }
    const int32_t filtered = fir_update(&chain->fir, counts);

    if (!chain->primed) {
        weight_kf_adaptive_init(&chain->kf, &weight_kf_adaptive_default, filtered);
    }
    const int32_t estimate_q7 = weight_kf_adaptive_update(&chain->kf, filtered);

    chain->primed = true;
    scale_update(chain->scale, estimate_q7, counts * 128, device_us); /* Q7: 24 bits and 7 more */
}

void faults_blocks_weigh(faults_blocks_t *chain, const uint8_t events[], const int32_t counts[],
                         const uint32_t device_us[], uint8_t held[], uint8_t flags[],
                         int32_t mass_mg[], size_t count)
{
    for (size_t at = 0U; at < count; ++at) {
        weigh(chain, (faults_event_t)events[at], counts[at], device_us[at]);
        held[at]    = chain->faults.held;
        flags[at]   = chain->scale->flags;
        mass_mg[at] = chain->scale->mass_mg;
    }
}
