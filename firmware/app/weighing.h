/* SPDX-License-Identifier: MIT */
/* weighing - the chain from conversions to a weight: fir, Kalman filter, scale; the measured rate.
 *
 * Model     the first sample after a restart primes both filters and then passes through them like
 *           every other: fir_init(x); f = fir_update(x); weight_kf_init(f); weight_kf_update(f).
 *           The other order hands on the estimate in whole counts, rounded half up. The Kalman
 *           filter is weight_kf or weight_kf_adaptive. The scale takes what comes last.
 * Formats   as in messages.toml, SAMPLE
 * Bad data  a sample at the converter's rail passes, flagged and counted
 *           a conversion that is not one period after the one before is not trusted: the chip may
 *           have started anew, as after a loose contact, and then gives four wrong ones. What was
 *           lost is counted and flagged on the next sample.
 * Context   main loop.  Cost: firmware/budget.toml
 */
#ifndef WEIGHING_H
#define WEIGHING_H

#include "hx711.h"
#include "messages.h"

#include <stdbool.h>
#include <stdint.h>

/* Since reset; each stops at its maximum. */
typedef struct {
    uint16_t conversions_missed;
    uint16_t at_rail;
    uint16_t fir_clipped;
    uint16_t kf_clipped;
} weighing_counters_t;

/* What HELLO says of the chain. */
typedef struct {
    uint8_t fir_design;
    uint8_t fir_taps;
    uint8_t kf_schedule;
    uint8_t chain_order;
    uint8_t kf_kind;
} weighing_setup_t;

void weighing_init(void);

/* Take the time of a conversion, of a dropped one too: this gives the rate. False if the conversion
 * is off the converter's beat and therefore not to be trusted. */
bool weighing_time(uint32_t device_us);

/* The converter was restarted: the next conversion's time says nothing about the rate. */
void weighing_lose_beat(void);

/* What follows is not connected with what was: the next conversion starts the filters anew. */
void weighing_restart(void);

/* Take one conversion whose time was taken, give its sample. */
void weighing_update(messages_sample_t *sample, const hx711_conversion_t *conversion);

/* The present load becomes the tare; a MESSAGES_RESULT_... */
uint8_t weighing_tare(void);

uint32_t            weighing_rate_hz_q16(void);
weighing_counters_t weighing_counters(void);
weighing_setup_t    weighing_setup(void);

#endif
